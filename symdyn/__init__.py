"""symdyn: equations of motion of mechanisms, from a declared scene to proved code."""

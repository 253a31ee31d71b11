"""The table of outputs, the roads that derive each of them, and the door `derive`."""

"""The mechanism as declared: its state, its tree, where bodies are and how they move, and what acts on them."""

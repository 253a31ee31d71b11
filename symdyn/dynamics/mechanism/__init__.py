"""The mechanism as declared: its state, its tree, where bodies are and how they move, and what acts on them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Closed mechanisms: what loops demand, where they close, what is free; inverse dynamics: outputs/closed_outputs.py."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Closed mechanisms: what loops demand, where they close, what they leave free, and the equations of what is left."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

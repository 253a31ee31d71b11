"""Contacts that open and close: their rows, their forces in every mode, what strikes."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Motions in time: motion prescribed and forces found, or forces prescribed and motion found."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Run time against error, work against precision, and hard cases: what the code is worth, measured."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

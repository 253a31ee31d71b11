"""Compiles generated code, loads and runs it: the only package that starts a compiler."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""The table of outputs, the formulations that derive each of them, and the entry point `derive`."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

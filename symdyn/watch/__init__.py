"""A scene's file, watched: a page in the browser that shows what stands in it, while it is written."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

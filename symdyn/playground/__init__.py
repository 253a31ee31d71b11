"""The playground: a page on which a scene is written, and at once there are its picture, its equations and its code."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

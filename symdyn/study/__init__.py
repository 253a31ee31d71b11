"""One scene at many values of its parameters: designs, blocks that any executor runs, and what comes of them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

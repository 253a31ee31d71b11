"""Programs: equations as straight-line code, pruned, named and counted; no syntax yet."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

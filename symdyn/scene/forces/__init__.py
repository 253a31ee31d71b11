"""Forces: everything that acts in a scene beside gravity and drives, a kind a file."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

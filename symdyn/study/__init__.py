"""Many runs of one scene: as arrays or by designs, in lanes or in blocks that any executor runs, and what they give."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

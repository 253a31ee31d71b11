"""From measured motion to parameters: base parameters with their standard errors, and a scene that has them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

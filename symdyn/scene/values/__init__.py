"""What a scene is made of: exact quantities and formulas, names, and the nouns that hold them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

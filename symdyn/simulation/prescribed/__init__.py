"""What a user prescribes over time: driving forces and motions, from formulas, named laws and tables of numbers."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

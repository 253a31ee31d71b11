"""What a graph can be run over: numbers, batches, big floats, finite fields, polynomials, degrees, SymPy."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

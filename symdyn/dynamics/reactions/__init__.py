"""What joints transmit: D'Alembert's equilibrium of every body, eq. (5.1)-(5.20)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

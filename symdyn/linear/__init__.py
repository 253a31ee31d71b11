"""Mechanisms to first order next to a point or a steady motion: state space, modes, stability."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

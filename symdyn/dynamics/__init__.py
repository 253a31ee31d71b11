"""Equations of motion, derived twice: by Lagrange's equations and by recursion along the tree.

What decides numerically about loops and reactions needs NumPy and is imported when it is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Closed mechanisms, with loops, contacts or other constraint rows: what these demand, where they close, what is free.

Inverse dynamics of them: outputs/constrained_outputs.py.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

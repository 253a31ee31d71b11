"""Pictures and animations of a scene: SVG and HTML text that needs nothing else, and files of many kinds.

Functions are imported when they are first used: a plot of a run needs none of those that draw mechanisms.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

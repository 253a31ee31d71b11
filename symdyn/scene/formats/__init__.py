"""Scenes in other people's files: one module a format and a direction, imported when such a file is met.

A reader is `read(path, options) -> Reading`, a writer `write_text(scene) -> Written`; `symdyn.scene.scene_files`
picks one.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

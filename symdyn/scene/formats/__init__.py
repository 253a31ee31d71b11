"""Scenes in other people's files: one module a format and a direction, imported when such a file is met.

A reader is `read(path, options) -> Reading`, a writer `write_text(scene) -> Written`; `symdyn.scene.scene_files`
picks one.
"""

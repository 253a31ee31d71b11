"""Lessons: the derivation of a scene as one document, what renders it, and a student's own derivation checked."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

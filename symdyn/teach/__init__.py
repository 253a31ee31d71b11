"""Lessons: the derivation of a scene as one document, and what renders it."""

from symdyn.teach.document import Document
from symdyn.teach.lagrange import lagrange_walkthrough as walkthrough
from symdyn.teach.render import rendered

__all__ = ["Document", "rendered", "walkthrough"]

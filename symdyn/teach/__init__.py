"""Lessons: the derivation of a scene as one document, and what renders it."""

from symdyn.teach.document import Document
from symdyn.teach.lessons import walkthrough
from symdyn.teach.render import rendered

__all__ = ["Document", "rendered", "walkthrough"]

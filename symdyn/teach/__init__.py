"""Lessons: the derivation of a scene as one document, what renders it, and a student's own derivation checked."""

from symdyn.teach.answers import in_words
from symdyn.teach.derivation_check import check_derivation
from symdyn.teach.document import Document
from symdyn.teach.lessons import walkthrough
from symdyn.teach.render import rendered

__all__ = ["Document", "check_derivation", "in_words", "rendered", "walkthrough"]

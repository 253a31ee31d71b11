"""Lessons: the derivation of a scene as one document, what renders it, and a student's own derivation checked."""

from symdyn.teach.document import Document
from symdyn.teach.render import rendered
from symdyn.teach.roads.lessons import walkthrough
from symdyn.teach.student.answers import in_words
from symdyn.teach.student.derivation_check import check_derivation

__all__ = ["Document", "check_derivation", "in_words", "rendered", "walkthrough"]

"""Emitters: the only room that knows syntax."""

from symdyn.emit.door import TARGETS, emit
from symdyn.emit.files import write
from symdyn.emit.sources import Sources

__all__ = ["TARGETS", "Sources", "emit", "write"]

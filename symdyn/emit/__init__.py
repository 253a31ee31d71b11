"""Emitters: the only room that knows syntax."""

from symdyn.emit.door import TARGETS, emit
from symdyn.emit.files import write
from symdyn.emit.sources import Sources
from symdyn.emit.target import Draft, Target

__all__ = ["TARGETS", "Draft", "Sources", "Target", "emit", "write"]

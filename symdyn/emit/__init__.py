"""Emitters: the only room that knows syntax."""

from symdyn.emit.code.target import Draft, Sources, Target
from symdyn.emit.targets.door import TARGETS, beside, emit
from symdyn.emit.targets.json_reader import read_program
from symdyn.emit.writing import write

__all__ = ["TARGETS", "Draft", "Sources", "Target", "beside", "emit", "read_program", "write"]

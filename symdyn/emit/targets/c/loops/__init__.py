"""Functions of C as loops over a table of joints: constants are data, the text is the same for every mechanism."""

from symdyn.emit.targets.c.loops.table import LoopText, loop_text

__all__ = ["LoopText", "loop_text"]

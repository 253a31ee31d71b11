"""Functions of C as loops over a table of joints: constants are data, the text is the same for all joints of a kind."""

from symdyn.emit.targets.c.loops.text import LoopText, loop_text

__all__ = ["LoopText", "loop_text"]

"""The C target: `c99.py` is its row, `writer.py` writes lines, the others say how batches are computed."""

from symdyn.emit.code.target import BATCH
from symdyn.emit.targets.c.c99 import HEADER_ONLY, ROWS, C

__all__ = ["BATCH", "HEADER_ONLY", "ROWS", "C"]

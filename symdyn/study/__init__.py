"""One scene at many values of its parameters: designs, blocks that any executor runs, and what comes of them."""

from symdyn.study.door import sweep
from symdyn.study.study import Study

__all__ = ["Study", "sweep"]

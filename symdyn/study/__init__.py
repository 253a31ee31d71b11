"""One scene at many values of its parameters: designs, blocks that any executor runs, and what comes of them."""

from symdyn.study.door import open, sweep
from symdyn.study.indices import Indices
from symdyn.study.study import Study

__all__ = ["Indices", "Study", "open", "sweep"]

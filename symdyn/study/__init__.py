"""One scene at many values of its parameters: designs, blocks that any executor runs, and what comes of them."""

from symdyn.study.door import open, sweep
from symdyn.study.error_bars import Uncertainty
from symdyn.study.first_order import uncertainty
from symdyn.study.indices import Indices
from symdyn.study.study import Study

__all__ = ["Indices", "Study", "Uncertainty", "open", "sweep", "uncertainty"]

"""PyTorch over our C: `symdyn.load(…, backend="torch")`, all derivatives in one call, and a gradient."""

from __future__ import annotations

from typing import Any

import numpy as np
from cases import Case
from harness import Timed, python_sweep
from native import MissingError

import symdyn
from tools.ours import MANY, OUTPUTS, many

try:
    import torch
except ImportError as fault:
    raise MissingError("PyTorch is not installed") from fault

torch.set_num_threads(1)


def version() -> str:
    """Return how PyTorch calls itself."""
    return f"PyTorch {torch.__version__}"


def timed(case: Case) -> list[Timed]:
    """Return both functions with many states."""
    arm: Any = symdyn.load(case.scene, OUTPUTS, backend="torch")
    found = []
    for output in OUTPUTS:
        arguments = [torch.from_numpy(one) for one in many(case, output)]

        def sweep(call: Any = arm[output], arguments: Any = arguments) -> Any:
            return call(*arguments)

        def result(sweep: Any = sweep, known: int = len(case.references[output])) -> np.ndarray:
            return sweep()[:known].numpy().reshape(known, -1)

        found.append(Timed(case.name, output, "torch", "batch", MANY, python_sweep(sweep), result))
    return found

"""A module whose functions are called with many states at once, to measure one of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from symdyn.program import Program, shared

STATES = 32
"""More than any target computes one by one."""


class InRows:
    """The functions of a module, each of one state that stands in a row of many like it."""

    def __init__(self, module: Any, program: Program) -> None:
        """Stand before `module`, whose functions take leading dimensions."""
        self._module = module
        names = {one.function.name: [a.name for a in one.function.arguments] for one in program.routines}
        self._varying = {name: [a != shared(taken) for a in taken] for name, taken in names.items()}

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return the function called `name`, of one state."""
        call = getattr(self._module, name)

        def of_many(*operands: Any) -> Any:
            rows = [
                np.broadcast_to(given, (STATES, *np.shape(given))) if varies else given
                for given, varies in zip(operands, self._varying[name], strict=True)
            ]
            return np.asarray(call(*rows))[-1] if any(self._varying[name]) else call(*operands)

        return of_many

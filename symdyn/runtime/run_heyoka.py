"""The only file that runs heyoka: expressions of a generated module, compiled as callables of arrays."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.dynamics import Function
from symdyn.emit import Sources
from symdyn.runtime.run_casadi import called, loaded
from symdyn.runtime.warned import check_target


def run_heyoka(sources: Sources) -> SimpleNamespace:
    """Return the functions of sources that `emit(program, "heyoka")` made, and `module`, the module itself.

    Each takes arrays, their own dimension last, leading dimensions for states. It is compiled when it is first called.

    Raises:
        BuildError: sources of another target.
        MissingProgram: heyoka is not installed.
    """
    check_target(sources, "heyoka")
    module = loaded(sources, "heyoka", "simulate")
    named = zip(sources.functions, sources.program.routines, strict=True)
    calls = {name: _call(getattr(module, name), routine.function) for name, routine in named}
    return SimpleNamespace(**calls, module=module)


def _call(written: Callable[..., Any], function: Function) -> Callable[..., Any]:
    """Return one function as a callable of arrays."""

    @cache
    def compiled() -> Any:
        heyoka = importlib.import_module("heyoka")
        given = [[heyoka.expression(f"{a.name}[{i}]") for i in range(len(a.symbols))] for a in function.arguments]
        entries = np.ravel(written(*given))
        return heyoka.cfunc([*entries], vars=[x for one in given for x in one])

    def compute(*columns: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        count = max((one.shape[1] for one in columns), default=1)
        every = [np.broadcast_to(one, (len(one), count)) for one in columns]
        found = compiled()(np.ascontiguousarray(np.concatenate(every)))
        return np.asarray(found).reshape(-1, count)

    return called(compute, function)

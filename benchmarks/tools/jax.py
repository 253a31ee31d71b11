"""JAX over our C: `symdyn.load(…, backend="jax")` inside jit, all derivatives in one call, and by jacfwd."""

from __future__ import annotations

import os
import time
from functools import cache
from typing import Any

import numpy as np
from cases import Case
from harness import Timed, python_sweep
from native import MissingError

import symdyn
from tools.ours import MANY, OUTPUTS, many

os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

try:
    import jax
except ImportError as fault:
    raise MissingError("JAX is not installed") from fault

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_cpu_enable_async_dispatch", False)  # on the thread whose time is taken

ID, IDD = OUTPUTS


def version() -> str:
    """Return how JAX calls itself."""
    return f"JAX {jax.__version__}"


@cache
def arm(case: Case) -> Any:
    """Return the functions for JAX."""
    return symdyn.load(case.scene, OUTPUTS, backend="jax")


def _whole(case: Case) -> Any:
    """Return jacfwd of inverse dynamics of one state, as one matrix."""
    slopes = jax.jacfwd(arm(case).inverse_dynamics, argnums=(0, 1, 2))
    return lambda *given: jax.numpy.concatenate(slopes(*given), -1)


def _timed(case: Case, output: str, peer: str, function: Any) -> Timed:
    call, arguments = jax.jit(function), [jax.numpy.asarray(one) for one in many(case, output)]

    def result() -> np.ndarray:
        known = len(case.references[output])
        return np.asarray(call(*arguments))[:known].reshape(known, -1)

    return Timed(
        case.name, output, peer, "batch", MANY, python_sweep(lambda: call(*arguments).block_until_ready()), result
    )


def timed(case: Case) -> list[Timed]:
    """Return both functions with many states, and the derivatives by jacfwd under vmap."""
    return [
        _timed(case, ID, "jax", arm(case).inverse_dynamics),
        _timed(case, IDD, "jax", arm(case).inverse_dynamics_derivatives),
        _timed(case, IDD, "jax, jacfwd", jax.vmap(_whole(case))),
    ]


def seconds(case: Case) -> dict[str, float]:
    """Return how long jit takes with the dearest of them, our C compiled before."""
    arguments = [jax.numpy.asarray(one) for one in many(case, IDD)]
    start = time.perf_counter()
    jax.jit(jax.vmap(_whole(case))).lower(*arguments).compile()
    return {"jax, jit": time.perf_counter() - start}

"""The functions of a scene for JAX: jit, vmap, grad, jacfwd, jacrev, in double and in float.

XLA calls the C by its foreign function interface, on a card kernels. A call's arguments are put into the form that the
primitive takes; that and what XLA's program calls is in `jax_primitives.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp

from symdyn.dynamics import LoopChoices
from symdyn.errors import ArgumentError
from symdyn.runtime.backends.jax_card import register
from symdyn.runtime.backends.jax_primitives import REALS, call
from symdyn.runtime.backends.rules import Array
from symdyn.runtime.backends.words import Library, Word, is_weak, loaded_for
from symdyn.runtime.loaded import Loaded
from symdyn.scene import Scene


def _array(value: Any) -> Array:
    """Return a value as JAX's array.

    Raises:
        ArgumentError: it has digits that JAX would drop.
    """
    wide = getattr(value, "dtype", None) == "float64" and getattr(value, "ndim", 0) > 0
    if wide and not jax.config.jax_enable_x64:
        raise ArgumentError(
            "float64 is given, which JAX takes for float32 as it is set; "
            'jax.config.update("jax_enable_x64", True), or give float32'
        )
    return jnp.asarray(value)


def placed(word: Word, *given: Any) -> Array:
    """Return what a function computes of arguments (n,) or (..., n), given by place.

    Raises:
        ValueError: a last dimension of another length, leading dimensions that do not broadcast.
        ArgumentError: numbers of another type than float32 and float64.
    """
    if len(given) != len(word.arguments):
        raise ValueError(f"{len(given)} arguments are given")
    arrays = [_array(one) for one in given]
    strong = [a for a, one in zip(arrays, given, strict=True) if not is_weak(one)]
    dtype = jnp.result_type(*strong) if strong else jnp.result_type(float)
    dtype = dtype if jnp.issubdtype(dtype, jnp.inexact) else jnp.result_type(float)
    if dtype.name not in REALS:
        raise ArgumentError(
            f"{word.routine.function.name}: {dtype.name} is given; there is code for {' and '.join(REALS)}"
        )
    owns = [core for _, core in word.arguments]
    if any(a.shape[a.ndim - len(core) :] != core for a, core in zip(arrays, owns, strict=True)):
        raise ValueError("a last dimension has another length")
    leading = jnp.broadcast_shapes(*(a.shape[: a.ndim - len(core)] for a, core in zip(arrays, owns, strict=True)))
    return call(
        word,
        *(
            a.astype(dtype).reshape((1,) * (len(leading) + len(core) - a.ndim) + a.shape)
            for a, core in zip(arrays, owns, strict=True)
        ),
    )


def stacked(values: Sequence[Any]) -> Any:
    """Return values as one array along its last dimension; numbers alone as they are."""
    if all(is_weak(one) for one in values):
        return list(values)
    return jnp.stack(jnp.broadcast_arrays(*map(_array, values)), axis=-1)


def loaded(
    again: Callable[..., Loaded],
    scene: Scene,
    requests: tuple[str, ...] | None,
    compiler: str | None,
    machine: str,
    prepare: bool,
    closing: LoopChoices,
    free: Mapping[str, float],
) -> Loaded:
    """Return the functions of a scene for JAX; see `symdyn.load`."""
    real = REALS[jnp.result_type(float).name]
    make = partial(register, compiler=compiler, machine=machine)
    library = Library("JAX", real, make, placed, stacked)
    return loaded_for("jax", library, scene, requests, compiler, machine, prepare, closing, free, again)

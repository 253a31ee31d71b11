"""The functions of a scene for JAX, over the same C: jit, vmap, grad, jacfwd, jacrev, in double and in float.

One primitive calls one word (`words.py`). XLA calls the C by its foreign function interface; what moves with what is in
`rules.py`, and JAX differentiates nothing by itself. Where vmap gives one state many directions, as jacfwd does, all of
J is computed once and multiplied.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from symdyn.build.backends.backend_function import Library, is_weak, loaded_for
from symdyn.build.backends.rules import Array, Arrays, all_columns, all_rows, cotangent, tangent
from symdyn.build.backends.words import ALONG, BACK, Word, weights_of
from symdyn.build.backends.xla_library import register
from symdyn.build.loaded import Loaded
from symdyn.dynamics import LoopChoices
from symdyn.errors import ArgumentError, BuildError
from symdyn.scene import Scene

REALS = {"float64": "double", "float32": "float"}

MANY = 4
"""Directions from which J and a product cost less than a product along each."""

call_p = Primitive("symdyn")


def call(word: Word, *given: Array) -> Array:
    """Return what a word computes of arrays whose leading dimensions are equal, or 1 where they are broadcast."""
    return call_p.bind(*given, word=word)


ARRAYS = Arrays(jnp, lambda word, given: call(word, *given))


def _leading(word: Word, shapes: Sequence[tuple[int, ...]]) -> tuple[int, ...]:
    """Return the dimensions that arguments broadcast to."""
    own = [shape[: len(shape) - len(core)] for shape, (_, core) in zip(shapes, word.arguments, strict=True)]
    return tuple(next((n for n in column if n != 1), 1) for column in zip(*own, strict=True))


def _shape(*given: Any, word: Word) -> Any:
    shapes = [one.shape for one in given]
    return jax.core.ShapedArray((*_leading(word, shapes), *word.shape), given[0].dtype)


def _evaluated(*given: Array, word: Word) -> Array:
    return call(word, *given)


call_p.def_abstract_eval(_shape)
call_p.def_impl(jax.jit(_evaluated, static_argnames=("word",)))


def _lowered(context: Any, *operands: Any, word: Word) -> Any:
    """Return the call of the C in XLA's program."""
    (result,) = context.avals_out
    name = word.text.ready(REALS[result.dtype.name]).get(word.routine.function.name)
    if name is None and 0 not in word.shape:
        raise BuildError(f"{word.routine.function.name} takes an argument without entries, which XLA cannot hand on")
    if name is None:
        return mlir.lower_fun(lambda *_: jnp.zeros(result.shape, result.dtype), multiple_results=False)(
            context, *operands
        )
    return jax.ffi.ffi_lowering(name)(context, *operands)


def _nowhere_else(context: Any, *operands: Any, word: Word) -> Any:
    others = ", ".join(context.module_context.platforms)
    raise BuildError(
        f"{word.routine.function.name} runs on the CPU alone, there is no kernel for {others}; "
        'put its arguments there by jax.device_put(x, jax.devices("cpu")[0])'
    )


mlir.register_lowering(call_p, _nowhere_else)
mlir.register_lowering(call_p, _lowered, platform="cpu")


def _batched(given: Sequence[Array], places: Sequence[int | None], *, word: Word) -> tuple[Array, int]:
    """Return the result for one dimension more, in front."""
    moved = {
        name: array[None] if place is None else jnp.moveaxis(array, place, 0)
        for name, array, place in zip(word.names, given, places, strict=True)
    }
    fresh = {name for name, place in zip(word.names, places, strict=True) if place is not None}
    size = next(moved[name].shape[0] for name in fresh)
    if word.way is not None and size >= MANY and not fresh & set(word.way.of.names):
        x = {name: moved[name] for name in word.way.of.names}
        if word.kind == ALONG:
            return all_columns(ARRAYS, word.way, x, moved), 0
        if word.kind == BACK:
            return all_rows(ARRAYS, word.way, x, moved[weights_of(word.way.of)]), 0
    return call(word, *moved.values()), 0


batching.primitive_batchers.update({call_p: _batched})


def _moved(given: Sequence[Array], rates: Sequence[Any], *, word: Word) -> tuple[Array, Any]:
    """Return the result, and how it moves."""
    result = call(word, *given)
    named = dict(zip(word.names, given, strict=True))
    moving = {name: d for name, d in zip(word.names, rates, strict=True) if type(d) is not ad.Zero}
    if not moving or 0 in result.shape:
        return result, ad.Zero.from_primal_value(result)
    found = tangent(ARRAYS, word, named, moving)
    return result, jnp.broadcast_to(found, result.shape)


ad.primitive_jvps.update({call_p: _moved})


def _transposed(y: Any, *given: Any, word: Word) -> list[Any]:
    """Return the derivatives of the arguments in which the word is linear."""
    wanted = [name for name, one in zip(word.names, given, strict=True) if ad.is_undefined_primal(one)]
    if type(y) is ad.Zero:
        return [ad.Zero(one.aval) if ad.is_undefined_primal(one) else None for one in given]
    known = {name: one for name, one in zip(word.names, given, strict=True) if not ad.is_undefined_primal(one)}
    found = cotangent(ARRAYS, word, known, y, wanted)
    return [
        _gathered(found[name], one.aval.shape) if ad.is_undefined_primal(one) else None
        for name, one in zip(word.names, given, strict=True)
    ]


def _gathered(array: Array, shape: tuple[int, ...]) -> Array:
    """Return the sum over dimensions in which an argument was broadcast."""
    axes = tuple(axis for axis, (a, b) in enumerate(zip(array.shape, shape, strict=True)) if a != b == 1)
    return jnp.broadcast_to(array.sum(axes, keepdims=True) if axes else array, shape)


ad.primitive_transposes.update({call_p: _transposed})


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
    requests: tuple[str, ...],
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

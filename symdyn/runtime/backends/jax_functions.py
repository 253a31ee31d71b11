"""The functions of a scene for JAX: jit, vmap, grad, jacfwd, jacrev, in double and in float.

XLA calls the C by its foreign function interface. Code is made when a program is lowered for a platform, for that
platform alone. A call's arguments are put into the form that the primitive takes.

On a card XLA calls kernels, on the stream that it computes on. What a handler takes there is (entries, states), all
leading dimensions one after another. XLA turns rows into that on the card, and where (7, n) was transposed before, it
does neither; what lacks a leading dimension it broadcasts before the call. Nothing leaves the card.

One primitive calls one word (`words.py`) and knows its shape, and what becomes of it under vmap, jvp and transposition.
What moves with what is in `rules.py`, and JAX differentiates nothing by itself. Where vmap gives one state many
directions, as jacfwd does, all of J is computed once and multiplied.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import jaxlib
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from symdyn.emit import C, Entries, Sources, emit
from symdyn.errors import ArgumentError, BuildError
from symdyn.frozen import dataclass
from symdyn.program import Program, shared
from symdyn.runtime.backends.rules import Array, Arrays, Named, all_columns, all_rows, cotangent, tangent, whole
from symdyn.runtime.backends.words import (
    ALL,
    ALONG,
    BACK,
    DerivativeRule,
    Kernels,
    Library,
    Word,
    architecture,
    compiled,
    is_weak,
    several,
    weights_of,
)
from symdyn.runtime.commands import Needs
from symdyn.runtime.compiler import PATIENCE, find_compiler
from symdyn.runtime.library import SUFFIX, LibraryKind, load_library

REALS = {"float64": "double", "float32": "float"}

HEADERS, ABI = (jax.ffi.include_dir(),), ("xla", jaxlib.__version__)
"""Where XLA's header is, and whose it is."""

REGISTERED: dict[str, ctypes.CDLL] = {}
"""Libraries whose handlers XLA knows, by what they are called there: they stay loaded as long as XLA may call them."""


def register(
    program: Program, real: str, columns: Sequence[int], compiler: str | None, machine: str
) -> Mapping[tuple[str, str], str]:
    """Return what XLA calls the handlers of a program, by function and kind; one without entries has none.

    A name has the hash of all that the code is made of in it: what JAX keeps compiled on disk finds the same code in
    another process, or none.

    Raises:
        BuildError: no compiler, or its own words when it refuses.
        EmitError: the program cannot be written in this type.
    """
    sources = emit(program, C.name, real, option="batch")
    entries = Entries.of_xla(sources, columns)
    needs = Needs(headers=HEADERS, exports=tuple(entries.symbols.values()))
    kind = LibraryKind(SUFFIX, needs, ABI, ctypes.CDLL)
    path, library = load_library(entries.files, find_compiler(compiler, machine), PATIENCE, kind)
    return hand_over("cpu", sources, entries, path, library)


def hand_over(
    platform: str, _: Sources, entries: Entries, path: Path, library: ctypes.CDLL
) -> Mapping[tuple[str, str], str]:
    """Return what XLA calls handlers of a library, by function and kind, when it knows them for a platform."""
    known = {}
    for key, symbol in entries.symbols.items():
        known[key] = target = f"symdyn_{path.stem}_{symbol}"
        if target not in REGISTERED:
            REGISTERED[target] = library
            jax.ffi.register_ffi_target(target, jax.ffi.pycapsule(getattr(library, symbol)), platform=platform)
    return known


@dataclass(frozen=True)
class Card:
    """How kernels come to one of JAX's platforms.

    Attributes:
        machine: returns the architecture of its devices, as the compiler calls it.
        build: returns the library of files for an architecture, and its path.
        open: hands a library over to XLA, and returns what it calls the handlers.
    """

    machine: Callable[[], str]
    build: Callable[[Mapping[str, str], str], tuple[Path, ctypes.CDLL]]
    open: Callable[[Sources, Entries, Path, ctypes.CDLL], Mapping[tuple[str, str], str]]

    @property
    def kernels(self) -> Kernels:
        """What makes handlers for the devices that are there."""
        return Kernels(self.machine(), self.build, Entries.of_xla, self.open)


def over_columns(handler: str, platform: str, word: Word, leading: tuple[int, ...], *given: Array) -> Array:
    """Return what a handler computes, (*leading, *shape of the word), of arrays with these dimensions in front, or 1.

    Raises:
        ArgumentError: several sets of parameters; a kernel takes one for all states.
    """
    common, states = shared(word.names), prod(leading)
    columns = []
    for (name, core), one in zip(word.arguments, given, strict=True):
        if name == common:
            count = prod(one.shape[: one.ndim - len(core)])
            if count != 1:
                raise several(word.routine.function.name, platform, name, count)
            columns.append(one.reshape(prod(core), 1))
        else:
            columns.append(_turned(jnp.broadcast_to(one, leading + core), len(leading)).reshape(prod(core), states))
    result = jax.ShapeDtypeStruct((prod(word.shape), states), given[0].dtype)
    found = jax.ffi.ffi_call(handler, result)(*columns)
    return _turned(found.reshape(word.shape + leading), len(word.shape))


def _turned(array: Array, front: int) -> Array:
    """Return an array with so many of its dimensions from the front at the end."""
    return array.transpose(*range(front, array.ndim), *range(front))


def _architecture() -> str:
    """Return the architecture of the cards that JAX sees; of several kinds the oldest, whose code newer ones take."""
    try:
        devices = jax.local_devices(backend="cuda")
    except RuntimeError as fault:
        raise BuildError(
            f"JAX sees no card ({fault}), and kernels are compiled for the one that is there; "
            "lower for the CPU, or where a card is"
        ) from fault
    return architecture(min(tuple(map(int, one.compute_capability.split("."))) for one in devices))


KIND = LibraryKind(SUFFIX, Needs(headers=HEADERS), ("cuda", *ABI), ctypes.CDLL)

CARDS: dict[str, Card] = {"cuda": Card(_architecture, partial(compiled, kind=KIND), partial(hand_over, "CUDA"))}
"""By JAX's name of a platform; one that has no row has no kernels."""


def lower_by_platform(primitive: Any, rule: Callable[..., Any]) -> None:
    """Let XLA's programs do what `rule` returns for a platform: of its name, JAX's context and operands."""
    mlir.register_lowering(primitive, _nowhere_else)
    for platform in ("cpu", *CARDS):
        mlir.register_lowering(primitive, partial(rule, platform), platform=platform)


def lowered(platform: str, context: Any, *operands: Any, word: Word) -> Any:
    """Return the call of a word in XLA's program; without entries or states there is nothing to call."""
    (result,) = context.avals_out
    if 0 in result.shape:
        return _as_written(lambda *_: jnp.zeros(result.shape, result.dtype), context, *operands)
    handler = _handler(platform, word, result)
    if platform not in CARDS:
        return jax.ffi.ffi_lowering(handler)(context, *operands)
    leading = result.shape[: len(result.shape) - len(word.shape)]
    return _as_written(partial(over_columns, handler, platform, word, leading), context, *operands)


def times_lowered(
    plain: Callable[..., Any], platform: str, context: Any, *operands: Any, word: Word, left: bool
) -> Any:
    """Return the call of all of J times directions; `plain` where there is no code for that, as on a card."""
    (result,) = context.avals_out
    if platform in CARDS or 0 in result.shape:
        return _as_written(partial(plain, word=word, left=left), context, *operands)
    return jax.ffi.ffi_lowering(_handler(platform, word, result, "weighted" if left else "columns"))(context, *operands)


def _handler(platform: str, word: Word, result: Any, kind: str = "") -> str:
    name, card = word.routine.function.name, CARDS.get(platform)
    made = word.code.ready(REALS[result.dtype.name], None if card is None else card.kernels)
    found: str | None = made.get((name, kind))
    if found is None:
        raise BuildError(f"{name} takes an argument without entries, which XLA cannot hand on")
    return found


def _as_written(function: Callable[..., Any], context: Any, *operands: Any) -> Any:
    return mlir.lower_fun(function, multiple_results=False)(context, *operands)


def _nowhere_else(context: Any, *operands: Any, word: Word, **_: Any) -> Any:
    others = ", ".join(context.module_context.platforms)
    raise BuildError(
        f"{word.routine.function.name} runs on the CPU and on CUDA, there is no kernel for {others}; "
        'put its arguments there by jax.device_put(x, jax.devices("cpu")[0])'
    )


MANY = 4
"""Directions from which J and a product cost less than a product along each."""

call_p = Primitive("symdyn")


def call(word: Word, *given: Array) -> Array:
    """Return what a word computes of arrays whose leading dimensions are equal, or 1 where they are broadcast."""
    return call_p.bind(*given, word=word)


class Names:
    """What rules ask of JAX, by NumPy's names; without the precision a card multiplies floats with ten bits."""

    eye, zeros, concatenate, moveaxis = map(staticmethod, (jnp.eye, jnp.zeros, jnp.concatenate, jnp.moveaxis))
    einsum = staticmethod(partial(jnp.einsum, precision=jax.lax.Precision.HIGHEST))


ARRAYS = Arrays(Names, lambda word, given: call(word, *given))


def _leading(word: Word, shapes: Sequence[tuple[int, ...]]) -> tuple[int, ...]:
    own = [shape[: len(shape) - len(core)] for shape, (_, core) in zip(shapes, word.arguments, strict=True)]
    return tuple(next((n for n in column if n != 1), 1) for column in zip(*own, strict=True))


def _shape(*given: Any, word: Word) -> Any:
    shapes = [one.shape for one in given]
    return jax.core.ShapedArray((*_leading(word, shapes), *word.shape), given[0].dtype)


def _evaluated(*given: Array, word: Word) -> Array:
    return call(word, *given)


call_p.def_abstract_eval(_shape)
call_p.def_impl(jax.jit(_evaluated, static_argnames=("word",)))


lower_by_platform(call_p, lowered)


def _batched(given: Sequence[Array], places: Sequence[int | None], *, word: Word) -> tuple[Array, int]:
    """Return the result for one dimension more, and where that is."""
    fresh = {name for name, place in zip(word.names, places, strict=True) if place is not None}
    moved = {
        name: array[None] if place is None else jnp.moveaxis(array, place, 0)
        for name, array, place in zip(word.names, given, places, strict=True)
    }
    size = next(moved[name].shape[0] for name in fresh)
    way = word.way
    if way is None or size < MANY or fresh & set(way.of.names) or word.kind not in (ALONG, BACK):
        return call(word, *moved.values()), 0
    x = {name: array for name, array in zip(word.names, given, strict=True) if name in way.of.names}
    by = _common({name: moved[name] for name in word.names if name not in x}, word, size)
    if by and set(way.word(ALL).names) <= set(x):
        return times(way, word.kind == BACK, x, by)
    x = {name: array[None] for name, array in x.items()}
    if word.kind == ALONG:
        return all_columns(ARRAYS, way, x, moved), 0
    return all_rows(ARRAYS, way, x, moved[weights_of(way.of)]), 0


def _common(by: Named, word: Word, size: int) -> list[Array]:
    """Return directions as matrices, a row each, where all states share them; else []."""
    cores = dict(word.arguments)
    if any(n != 1 for name, one in by.items() for n in one.shape[1 : one.ndim - len(cores[name])]):
        return []
    return [
        jnp.broadcast_to(one.reshape((one.shape[0], prod(cores[name]))), (size, prod(cores[name])))
        for name, one in by.items()
    ]


batching.primitive_batchers.__setitem__(call_p, _batched)


def _moved(given: Sequence[Array], rates: Sequence[Any], *, word: Word) -> tuple[Array, Any]:
    result = call(word, *given)
    named = dict(zip(word.names, given, strict=True))
    moving = {name: d for name, d in zip(word.names, rates, strict=True) if type(d) is not ad.Zero}
    if not moving or 0 in result.shape:
        return result, ad.Zero.from_primal_value(result)
    found = tangent(ARRAYS, word, named, moving)
    return result, jnp.broadcast_to(found, result.shape)


ad.primitive_jvps.__setitem__(call_p, _moved)


def _transposed(y: Any, *given: Any, word: Word) -> list[Any]:
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


ad.primitive_transposes.__setitem__(call_p, _transposed)


# J times what all states share

times_p = Primitive("symdyn_times")


def times(way: DerivativeRule, left: bool, x: Named, by: Sequence[Array]) -> tuple[Array, int]:
    """Return J times directions (k, n) of each argument, or weights (k, m) times J, and where k is in the result."""
    word = way.word(ALL)
    found = times_p.bind(*(x[name] for name in word.names), *by, word=word, left=left)
    if left:
        return found, found.ndim - 2
    return found.reshape((*found.shape[:-2], *way.of.shape, found.shape[-1])), found.ndim - 2 + len(way.of.shape)


def _plain(*given: Array, word: Word, left: bool) -> Array:
    """Return the same in terms of J, as JAX differentiates it."""
    assert word.way is not None, "J belongs to a way"
    own = len(word.arguments)
    J = whole(ARRAYS, word.way, dict(zip(word.names, given[:own], strict=True)))
    by = jnp.concatenate(given[own:], -1)
    return Names.einsum("...mn,bm->...bn" if left else "...mn,bn->...mb", J, by)


def _times_shape(*given: Any, word: Word, left: bool) -> Any:
    own = len(word.arguments)
    leading = _leading(word, [one.shape for one in given[:own]])
    columns, many = sum(word.code.columns), given[own].shape[0]
    shape = (many, columns) if left else (prod(word.shape) // columns, many)
    return jax.core.ShapedArray((*leading, *shape), given[0].dtype)


def _times_batched(given: Sequence[Array], places: Sequence[int | None], *, word: Word, left: bool) -> Any:
    own = len(word.arguments)
    if any(place is not None for place in places[own:]):
        return jax.vmap(partial(_plain, word=word, left=left), places)(*given), 0
    x = [
        array[None] if place is None else jnp.moveaxis(array, place, 0)
        for array, place in zip(given[:own], places[:own], strict=True)
    ]
    return times_p.bind(*x, *given[own:], word=word, left=left), 0


def _times_moved(given: Sequence[Array], rates: Sequence[Any], *, word: Word, left: bool) -> Any:
    found = times_p.bind(*given, word=word, left=left)
    moving = {k: one for k, one in enumerate(rates) if type(one) is not ad.Zero}

    def along(*moved: Array) -> Array:
        values = dict(zip(moving, moved, strict=True))
        return _plain(*(values.get(k, one) for k, one in enumerate(given)), word=word, left=left)

    return found, jax.jvp(along, tuple(given[k] for k in moving), tuple(moving.values()))[1]


def _times_transposed(y: Any, *given: Any, word: Word, left: bool) -> list[Any]:
    unknown = [k for k, one in enumerate(given) if ad.is_undefined_primal(one)]
    if type(y) is ad.Zero:
        return [ad.Zero(one.aval) if k in unknown else None for k, one in enumerate(given)]

    def linear(*by: Array) -> Array:
        values = dict(zip(unknown, by, strict=True))
        return _plain(*(values.get(k, one) for k, one in enumerate(given)), word=word, left=left)

    avals = [given[k].aval for k in unknown]
    found = jax.linear_transpose(linear, *(jax.ShapeDtypeStruct(one.shape, one.dtype) for one in avals))(y)
    known = dict(zip(unknown, found, strict=True))
    return [known.get(k) for k in range(len(given))]


times_p.def_abstract_eval(_times_shape)
times_p.def_impl(
    jax.jit(lambda *given, word, left: times_p.bind(*given, word=word, left=left), static_argnames=("word", "left"))
)
lower_by_platform(times_p, partial(times_lowered, _plain))
batching.primitive_batchers.__setitem__(times_p, _times_batched)
ad.primitive_jvps.__setitem__(times_p, _times_moved)
ad.primitive_transposes.__setitem__(times_p, _times_transposed)


def _array(value: Any) -> Array:
    """Return a value as JAX's array; ArgumentError where it has digits that JAX would drop."""
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


LIBRARY = Library("JAX", lambda: REALS[jnp.result_type(float).name], register, placed, stacked)

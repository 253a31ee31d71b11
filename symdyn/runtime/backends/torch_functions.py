"""The functions of a scene for PyTorch, over the same C: autograd of any order, torch.func, in double and in float.

One autograd function calls one word (`words.py`) by the ufunc that `load` makes of it: tensors on the CPU are handed on
where they stand, broadcast by NumPy, and the interpreter's lock is let go. What moves with what is in `rules.py`.

Tensors on a card go to launchers in C, on the stream that PyTorch computes on. A tensor (n, m) whose memory is that of
a contiguous (m, n) is columns, and is taken where it lies; another one is copied on its card. Results are such tensors,
so that what one function returns the next one takes without a copy. Nothing waits, and nothing leaves the card.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import cache, partial, reduce
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import torch

from symdyn.emit import TARGETS, Entries, Sources, emit
from symdyn.errors import ArgumentError, BuildError
from symdyn.frozen import dataclass
from symdyn.program import Program, shared
from symdyn.runtime.backends.rules import Array, Arrays, all_columns, all_rows, cotangent, tangent
from symdyn.runtime.backends.words import (
    ALONG,
    BACK,
    Kernels,
    Library,
    Word,
    architecture,
    compiled,
    is_weak,
    several,
    weights_of,
)
from symdyn.runtime.library import build_extension
from symdyn.runtime.runners import run_or_python

REALS = {torch.float64: "double", torch.float32: "float"}


@dataclass(frozen=True)
class Card:
    """How kernels come to devices of one type.

    Attributes:
        machine: returns the architecture of a device, as the compiler calls it.
        build: returns the library of files for an architecture, and its path.
        chosen: makes a device the current one for a while.
        stream: returns the stream that work for a device goes to now, as a pointer.
    """

    machine: Callable[[Any], str]
    build: Callable[[Mapping[str, str], str], tuple[Path, ctypes.CDLL]]
    chosen: Callable[[Any], AbstractContextManager[Any]]
    stream: Callable[[Any], int]


def launch(card: Card, word: Word, given: Sequence[Array]) -> Array:
    """Return what a word computes, (..., *its shape), of tensors on one card with equal leading dimensions, or 1.

    Raises:
        ArgumentError: several sets of parameters; a kernel takes one for all states.
        BuildError: there is no compiler, it refuses, or the card does.
    """
    function, device, dtype = word.routine.function, given[0].device, given[0].dtype
    common = shared(word.names)
    fronts = [one.shape[: one.ndim - len(core)] for (_, core), one in zip(word.arguments, given, strict=True)]
    leading = tuple(torch.broadcast_shapes(*fronts))
    columns = []
    for (name, core), one in zip(word.arguments, given, strict=True):
        if name == common:
            columns.append(_set(function.name, name, one, len(core)))
        else:
            columns.append(one.expand(leading + core).reshape(prod(leading), prod(core)).T.contiguous())
    states, size = prod(leading), len(function.entries)
    out = torch.empty((size, states), dtype=dtype, device=device)
    run = word.code.ready(REALS[dtype], kernels(card, device))[word.place]
    with card.chosen(device):
        said = run(card.stream(device), states, *(one.data_ptr() for one in columns), out.data_ptr())
    if said:
        raise BuildError(f"{function.name}: {device} refused the kernel: {said.decode(errors='replace')}")
    return out.T.reshape(leading + word.shape)


def kernels(card: Card, device: Any) -> Kernels:
    """Return what makes launchers for a device."""
    return Kernels(card.machine(device), card.build, Entries.of, _launchers)


def _launchers(sources: Sources, made: Entries, _: Path, library: ctypes.CDLL) -> list[Callable[..., bytes]]:
    """Return a launcher for every function: of a stream, the number of states, and pointers."""
    found = []
    for name, routine in zip(made.symbols.values(), sources.program.routines, strict=True):
        run = getattr(library, name)
        pointers = [ctypes.c_void_p] * (len(routine.function.arguments) + 1)
        run.argtypes, run.restype = [ctypes.c_void_p, ctypes.c_size_t, *pointers], ctypes.c_char_p
        found.append(run)
    return found


def _set(function: str, name: str, given: Array, rank: int) -> Array:
    """Return the one set of parameters that all states have; dimensions in front that repeat it are left out."""
    front = given.ndim - rank
    for axis in range(front):
        if given.shape[axis] != 1 and given.stride(axis) != 0:
            raise several(function, given.device, name, given.shape[axis])
    return given[(slice(1),) * front].contiguous()


CARDS: dict[str, Card] = {
    "cuda": Card(
        lambda device: architecture(torch.cuda.get_device_capability(device)),
        compiled,
        torch.cuda.device,
        lambda device: torch.cuda.current_stream(device).cuda_stream,
    )
}
"""By type of device; one that has no row has no kernels."""


MANY = 4
"""Directions from which J and a product cost less than a product along each."""

UFUNC = TARGETS["ufunc"]

TYPES = (torch.float32, torch.float64)


class Call(torch.autograd.Function):
    """One word."""

    @staticmethod
    def forward(word: Word, *given: Array) -> Array:
        """Return what the word computes, by NumPy's ufunc on the tensors' own memory, or by a kernel on their card."""
        card = CARDS.get(given[0].device.type)
        if card is not None:
            return launch(card, word, [one.detach().resolve_neg() for one in given])
        run = word.code.ready("double")[word.place]
        arrays = [one.detach().resolve_neg().numpy() for one in given]  # z.conj().imag is a view with its sign to come
        return torch.from_numpy(np.asarray(run(*arrays), arrays[0].dtype))

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Array) -> None:
        """Keep what derivatives are of."""
        ctx.word, *given = inputs
        ctx.save_for_backward(*given)
        ctx.save_for_forward(*given)

    @staticmethod
    def backward(ctx: Any, y: Array) -> tuple[Array | None, ...]:
        """Return the derivatives of the arguments that want them."""
        word, given = ctx.word, dict(zip(ctx.word.names, ctx.saved_tensors, strict=True))
        wanted = [name for name, need in zip(word.names, ctx.needs_input_grad[1:], strict=True) if need]
        found = cotangent(_arrays(y.device), word, given, y, wanted)
        return (None, *(_gathered(found[name], given[name]) if name in found else None for name in word.names))

    @staticmethod
    def jvp(ctx: Any, _: None, *rates: Array | None) -> Array:
        """Return how the result moves."""
        word, given = ctx.word, dict(zip(ctx.word.names, ctx.saved_tensors, strict=True))
        moving = {name: d for name, d in zip(word.names, rates, strict=True) if d is not None}
        arrays = _arrays(ctx.saved_tensors[0].device)
        found = tangent(arrays, word, given, moving)
        return torch.broadcast_to(found, (*arrays.leading(word, given), *word.shape))

    @staticmethod
    def vmap(info: Any, places: tuple[int | None, ...], word: Word, *given: Array) -> tuple[Array, int]:
        """Return the result for one dimension more, in front."""
        moved = {
            name: array[None] if place is None else _moved(array, place, 0)
            for name, array, place in zip(word.names, given, places[1:], strict=True)
        }
        fresh = {name for name, place in zip(word.names, places[1:], strict=True) if place is not None}
        if word.way is not None and info.batch_size >= MANY and not fresh & set(word.way.of.names):
            x = {name: moved[name] for name in word.way.of.names if name in moved}
            arrays = _arrays(given[0].device)
            if word.kind == ALONG:
                return all_columns(arrays, word.way, x, moved), 0
            if word.kind == BACK:
                return all_rows(arrays, word.way, x, moved[weights_of(word.way.of)]), 0
        return call(word, *moved.values()), 0


def call(word: Word, *given: Array) -> Array:
    """Return what a word computes of tensors whose leading dimensions are equal, or 1 where they are broadcast."""
    return Call.apply(word, *given)


def _moved(array: Array, source: int, place: int) -> Array:
    """Return the array with one dimension at another place; vmap knows no rule for torch.moveaxis."""
    order = list(range(array.ndim))
    order.insert(place % array.ndim, order.pop(source % array.ndim))
    return array.permute(order)


class Names:
    """What rules ask of a library of arrays, by NumPy's names; what is made is on one device."""

    einsum, concatenate, moveaxis = map(staticmethod, (torch.einsum, torch.cat, _moved))

    def __init__(self, device: Any) -> None:
        self.eye, self.zeros = partial(torch.eye, device=device), partial(torch.zeros, device=device)


@cache
def _arrays(device: Any) -> Arrays:
    return Arrays(Names(device), lambda word, given: call(word, *given))


def _gathered(array: Array, like: Array) -> Array:
    """Return the sum over dimensions in which an argument was broadcast."""
    axes = [axis for axis, (a, b) in enumerate(zip(array.shape, like.shape, strict=True)) if a != b == 1]
    return torch.broadcast_to(array.sum(axes, keepdim=True) if axes else array, like.shape)


def _strong(value: Any) -> Array:
    """Return what is no number of Python as a tensor; ValueError where it is none of numbers."""
    try:
        return value if isinstance(value, torch.Tensor) else torch.as_tensor(value)
    except (RuntimeError, TypeError) as error:
        raise ValueError(str(error)) from error


def _tensor(value: Any, dtype: Any, device: Any) -> Array:
    return value.to(dtype) if isinstance(value, torch.Tensor) else torch.as_tensor(np.asarray(value)).to(device, dtype)


def _ready(word: Word, given: Sequence[Any]) -> bool:
    """Tell whether arguments are tensors of one type and device whose leading dimensions are equal, as most are."""
    first = given[0] if given else None
    if not isinstance(first, torch.Tensor) or len(given) != len(word.arguments) or first.dtype not in TYPES:
        return False
    leading = first.shape[: first.ndim - len(word.arguments[0][1])]
    return _computes(first.device) and all(
        isinstance(one, torch.Tensor)
        and one.dtype is first.dtype
        and one.shape == leading + core
        and one.device == first.device
        for one, (_, core) in zip(given, word.arguments, strict=True)
    )


def _computes(device: Any) -> bool:
    return device.type == "cpu" or device.type in CARDS


def placed(word: Word, *given: Any) -> Array:
    """Return what a function computes of arguments (n,) or (..., n), given by place.

    Raises:
        ValueError: a last dimension of another length, leading dimensions that do not broadcast.
        ArgumentError: tensors on several devices or on one without code, numbers of another type than float32 and
            float64, several sets of parameters on a card.
        BuildError: nvcc is not there, refuses the kernels, or the card refuses to run one.
    """
    if _ready(word, given):
        return call(word, *given)
    name = word.routine.function.name
    if len(given) != len(word.arguments):
        raise ValueError(f"{len(given)} arguments are given")
    strong = [_strong(one) for one in given if not is_weak(one)]
    dtype = torch.get_default_dtype()
    if strong:
        dtype = reduce(torch.promote_types, (one.dtype for one in strong))
    if not (dtype.is_floating_point or dtype.is_complex):
        dtype = torch.get_default_dtype()
    if dtype not in TYPES:
        raise ArgumentError(f"{name}: {dtype} is given; there is code for {' and '.join(map(str, TYPES))}")
    devices = list(dict.fromkeys(one.device for one in strong)) or [torch.device("cpu")]
    for device in devices:
        if not _computes(device):
            raise ArgumentError(f"{name} runs on the CPU and on CUDA, and a tensor is on {device}; give x.cpu()")
    if len(devices) > 1:
        found = " and ".join(map(str, devices))
        raise ArgumentError(f"{name}: tensors are on {found}; give all on one device, x.to('{devices[0]}')")
    arrays = [_tensor(one, dtype, devices[0]) for one in given]
    owns = [core for _, core in word.arguments]
    if any(tuple(a.shape[a.ndim - len(core) :]) != core for a, core in zip(arrays, owns, strict=True)):
        raise ValueError("a last dimension has another length")
    leading = np.broadcast_shapes(*(tuple(a.shape[: a.ndim - len(core)]) for a, core in zip(arrays, owns, strict=True)))
    return call(
        word,
        *(
            a.reshape((1,) * (len(leading) + len(core) - a.ndim) + tuple(a.shape))
            for a, core in zip(arrays, owns, strict=True)
        ),
    )


def stacked(values: Sequence[Any]) -> Any:
    """Return values as one tensor along its last dimension; numbers alone as they are."""
    if all(is_weak(one) for one in values):
        return list(values)
    strong = [_strong(one) for one in values if not is_weak(one)]
    dtype = reduce(torch.promote_types, (one.dtype for one in strong))
    return torch.stack(torch.broadcast_tensors(*(_tensor(one, dtype, strong[0].device) for one in values)), -1)


def _made(program: Program, *_: Any, compiler: str | None, machine: str) -> list[Callable[..., Any]]:
    sources = emit(program, UFUNC.name)
    calls = run_or_python(sources, lambda one: build_extension(one, compiler, machine=machine)[1], compiler)[0]
    return list(calls.values())


LIBRARY = Library("PyTorch", lambda: "double", _made, placed, stacked)

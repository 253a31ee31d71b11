"""symdyn: the generated C, called from C; one state a call, batches of both layouts, and batches on two threads."""

from __future__ import annotations

import ctypes
import random
import re

import numpy as np
from cases import Case
from harness import Timed, moved
from native import address, compiled, loops

from symdyn.emit import emit
from symdyn.emit.code import stem
from symdyn.runtime import find_compiler
from symdyn.runtime.commands import FLAGS

NAME, FILLING, ALONE = "symdyn", "filling the result's array", "symdyn, arithmetic alone"

BATCH, BATCH_OF_MATRICES = 1024, 256
"""States of a batch that is timed, and of one with derivatives; arguments and results stay in the second cache."""

LONG = 8_000
"""Operations above which batch code is not compiled here, to keep the run short."""


def version() -> str:
    """Return how the code is compiled."""
    return f"this checkout, gcc {' '.join(flags())}"


def flags() -> tuple[str, ...]:
    """Return the package's own compiler flags, and those of this machine."""
    return (*(flag for flag in FLAGS if flag != "-shared"), *find_compiler("gcc").machine)


def library(case: Case, output: str, more: tuple[str, ...] = ()) -> ctypes.CDLL:
    """Return the compiled code of one output, compiled with `more` flags."""
    program = case.programs[output]
    (routine,) = program.routines
    short = routine.counts.multiplications + routine.counts.additions <= LONG
    option = "batch" if short or routine.function.loop else ""
    sources = emit(program, "c", option=option)
    header, text = sources.files[1], sources.files[0][1]
    joined = text.replace(f'#include "{header[0]}"', header[1])
    return ctypes.CDLL(str(compiled(joined + arithmetic(joined, output), (*flags(), *more))))


def arithmetic(text: str, output: str) -> str:
    """Return a function `alone` that computes a result in batch and leaves it in work space, "" where there is none.

    It calls the blocks of `output` in `text`, all for the same rows: of the largest matrices these are copied to where
    they have to go, which is then no part of it.
    """
    block = re.search(rf"/\* (\d+) states side by side.*\nstatic void {output}_block\(size_t stride.*\bq, double", text)
    reach = re.search(rf"{output}_block\(n, (\d+), q \+ k \+ j, r \+ j\)", text)
    if not (block and reach and "spread_columns" in text):
        return ""
    return f"""
void alone(size_t n, const double *q, double *out)
{{
    for (size_t k = 0; k + {block[1]} <= n; k += {block[1]}) {{
        {output}_block(n, {reach[1]}, q + k, out + k % {int(reach[1]) // 64 * 64});
    }}
}}
"""


def timed(case: Case, output: str, peer: str = NAME, more: tuple[str, ...] = ()) -> list[Timed]:
    """Return scalar C, batch C of both layouts, and two threads, as a peer of some name compiled with `more` flags."""
    code, clock = library(case, output, more), loops()
    name = f"{stem(case.scene.name)}_{output}"
    arguments = [np.ascontiguousarray(case.states[a]) for a in case.arguments(output)]
    states, size = case.references[output].shape
    out = np.zeros((states, size))
    places = [address(a) for a in padded(arguments)]
    entries = lengths(arguments)

    def scalar(sweeps: int) -> float:
        return clock.time_states(
            getattr(code, name), len(arguments), *longs(states, sweeps), entries, *longs(size), *places, address(out)
        )

    def scalar_result() -> np.ndarray:
        scalar(1)
        return out

    found = [Timed(case.name, output, peer, "state", states, scalar, scalar_result)]
    if not hasattr(code, f"{name}_rows"):
        return found
    count = BATCH if size <= case.n**2 else BATCH_OF_MATRICES
    many = case.draw(count)
    many = {key: np.concatenate([case.states[key], value[states:]]) for key, value in many.items()}
    rows = padded([np.ascontiguousarray(many[a]) for a in case.arguments(output)])
    columns = padded([np.ascontiguousarray(many[a].T) for a in case.arguments(output)])
    wide, tall = np.zeros((count, size)), np.zeros((size, count))
    batch, row = getattr(code, f"{name}_batch"), getattr(code, f"{name}_rows")
    to = random.Random(0)

    def in_columns(sweeps: int) -> float:
        nonlocal tall
        here, tall = [moved(a, to) for a in columns], moved(tall, to)
        where = [address(a) for a in here]
        return clock.time_batch(batch, len(arguments), *longs(count, sweeps), *where, address(tall))

    def in_rows(sweeps: int) -> float:
        nonlocal wide
        here, wide = [moved(a, to) for a in rows], moved(wide, to)
        where = [address(a) for a in here]
        return clock.time_batch(row, len(arguments), *longs(count, sweeps), *where, address(wide))

    def on_two(sweeps: int) -> float:
        nonlocal wide
        here, wide = [moved(a, to) for a in rows], moved(wide, to)
        where = [address(a) for a in here]
        return clock.time_threads(
            row, len(arguments), *longs(count, sweeps), entries, *longs(size), *where, address(wide)
        )

    def filling(sweeps: int) -> float:
        nonlocal tall
        tall = moved(tall, to)
        return clock.time_filling(*longs(count * size, sweeps), address(tall))

    def alone(sweeps: int) -> float:
        here = [moved(a, to) for a in columns]
        return clock.time_batch(code.alone, len(arguments), *longs(count, sweeps), *map(address, here), address(tall))

    def columns_result() -> np.ndarray:
        in_columns(1)
        return tall.T[:states]

    def rows_result() -> np.ndarray:
        in_rows(1)
        return wide[:states]

    def threads_result() -> np.ndarray:
        wide[:] = 0
        on_two(1)
        return wide[:states]

    ways = [
        (peer, "batch", in_columns, columns_result),
        (f"{peer}, rows", "batch", in_rows, rows_result),
        (f"{peer}, rows", "threads", on_two, threads_result),
    ]
    if output == "mass_matrix" and peer == NAME:
        ways.append((FILLING, "batch", filling, columns_result))
    if output == "mass_matrix" and peer == NAME and hasattr(code, "alone"):
        ways.append((ALONE, "batch", alone, columns_result))
    return [*found, *(Timed(case.name, output, *way[:2], count, *way[2:], own_clock=True) for way in ways)]


def padded(arrays: list[np.ndarray]) -> list[np.ndarray]:
    """Return three arrays: the loops in C take three addresses and use as many as the function has arguments."""
    return [*arrays, *[arrays[0]] * (3 - len(arrays))]


def lengths(arguments: list[np.ndarray]) -> ctypes.Array[ctypes.c_long]:
    """Return how many entries each of three arguments has."""
    return (ctypes.c_long * 3)(*(a.shape[1] for a in padded(arguments)))


def longs(*numbers: int) -> list[ctypes.c_long]:
    """Return numbers as C takes them."""
    return [ctypes.c_long(number) for number in numbers]

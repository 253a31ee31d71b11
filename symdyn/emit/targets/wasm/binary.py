"""A program as one WebAssembly module: what is imported, memory, functions."""

from __future__ import annotations

from symdyn.emit.targets.wasm.encoding import Body, module
from symdyn.emit.targets.wasm.lanes import IMPORTED, pair_of
from symdyn.emit.targets.wasm.routines import RoutineWriter, columns
from symdyn.emit.targets.wasm.sincos import large_angles, sincos
from symdyn.graph import Op
from symdyn.program import ANGULAR, Program

BLOCK = 256
"""States that stand in memory at a time."""

STRIDE = 8 * BLOCK + 64
"""Bytes from column to column; if it were a power of two, columns would compete for few places of the nearest cache."""


def binary(program: Program, names: tuple[str, ...], batch: bool, made_by: str) -> bytes:
    """Return the module of a program.

    Args:
        program: what it computes.
        names: of its functions.
        batch: whether there are functions of many states, too.
        made_by: the command that makes it.
    """
    used = {op for routine in program.routines for op in routine.operations if op in IMPORTED}
    used |= set(ANGULAR) if used & set(ANGULAR) else set()
    imported = [IMPORTED[op] for op in sorted(used)]
    calls = {name: number for number, (name, _) in enumerate(imported)}
    bodies: list[Body] = []

    def add(body: Body) -> None:
        calls[body.name] = len(imported) + len(bodies)
        bodies.append(body)

    if Op.SIN in used:
        add(large_angles(calls["sin"], calls["cos"]))
        add(sincos(calls["large_angles"]))
    for op in sorted(used - set(ANGULAR)) if batch else ():
        add(pair_of(op, calls[op.name.lower()]))
    end = work = max(columns(routine, STRIDE if batch else 8).end for routine in program.routines) + 15 & -16
    for name, routine in zip(names, program.routines, strict=True):
        writer = RoutineWriter(program, routine, calls, work)
        bodies.append(writer.single(name, columns(routine, 8)))
        end = max(end, writer.work)
        if batch:
            writer = RoutineWriter(program, routine, calls, work)
            bodies += writer.batch(name, columns(routine, STRIDE), len(imported) + len(bodies))
            end = max(end, writer.work)
    return module(imported, bodies, end, made_by)

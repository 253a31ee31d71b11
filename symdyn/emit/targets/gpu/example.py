"""Beside kernels: an example for CUDA and one for OpenCL, which call every kernel and know what must come out."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.real import find_real
from symdyn.emit.code.target import Sources
from symdyn.emit.code.worked_example import Called, ExampleInputs, worked_example
from symdyn.emit.render import render
from symdyn.emit.targets.gpu.kernels import budgets
from symdyn.emit.targets.gpu.resource_budget import Budget
from symdyn.program import Program, shared

STATES = 1000
"""As many as fill several blocks, the last of them in part."""


@dataclass(frozen=True)
class Launched:
    """One kernel of the example.

    Attributes:
        call: its name, what it is given, what must come out.
        single: whether it runs for one state, since what the others have in common is all that it takes.
        kept: whether other kernels read what comes out.
        block: threads of a block.
        parts: rows of blocks.
        required: whether a group must have so many.
    """

    call: Called
    single: bool
    kept: bool
    block: int
    parts: int
    required: bool


def files_beside(sources: Sources) -> dict[str, str]:
    """Return both examples."""
    opening, real = stem(sources.program.scene.name), find_real(sources.real)
    made = worked_example(sources, real.suffix)
    runs = dict(zip(sources.functions, budgets(sources.program, real), strict=True))
    values = {
        "stem": opening,
        "real": real.name,
        "dtype": real.dtype,
        "suffix": real.suffix,
        "states": STATES,
        "given": [(one, _is_common(one)) for one in made.given],
        "launched": [_launched(call, runs[call.name]) for call in made.called],
        "left_out": made.left_out,
    }
    return {f"{opening}_main{ending}": render(f"gpu/main{ending}.jinja", values) for ending in (".cu", ".py")}


def _is_common(one: ExampleInputs) -> bool:
    """Tell whether all states of the example have an argument in common."""
    return _plain(one.name) in (Program.PARAMS, Program.PREPARED)


def _launched(call: Called, room: Budget) -> Launched:
    names = [_plain(name) for name in call.arguments]
    common = {Program.PARAMS, Program.PREPARED}.intersection(names)
    single = bool(common) and not shared(names)
    return Launched(call, single, call.name == Program.PREPARE, room.block, len(room.plans), required=room.places > 0)


def _plain(name: str) -> str:
    """Return an argument's name without the length that tells two of one name apart."""
    head, _, tail = name.rpartition("_")
    return head if head and tail.isdigit() else name

"""How each target is run here, by its name: sources in, callables out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from symdyn.build.extension import build_extension
from symdyn.build.run_c import build
from symdyn.build.run_node import run_js
from symdyn.build.run_python import run_python
from symdyn.build.warned import warn_once
from symdyn.emit import Sources, emit
from symdyn.emit.code.c import BATCH, C
from symdyn.emit.code.javascript import JS
from symdyn.emit.code.python import NUMPY
from symdyn.emit.code.ufunc import DOUBLES, UFUNC
from symdyn.errors import MissingProgram

Call = Callable[..., Any]

SLOWER = "until then the functions are those of the NumPy module, which are slower"


@dataclass(frozen=True)
class Runner:
    """How the sources of one target are run.

    Attributes:
        run: returns what has the functions as attributes, each a callable of arrays; MissingProgram where this machine
            lacks what it takes, BuildError where that refuses the code.
        batches: whether they take leading dimensions, and quickly; else one state a call.
        many: the target's option for that; "" for none.
        measured: its option for `verify`, which leaves out what is measured elsewhere.
        usual: whether `verify` leaves out what `load` does, since compiling it takes longer than it tells.
    """

    run: Callable[[Sources], Any]
    batches: bool
    many: str
    measured: str
    usual: bool


def _extension(sources: Sources) -> ModuleType:
    return build_extension(sources)[1]


RUNNERS: dict[str, Runner] = {
    NUMPY.name: Runner(run_python, batches=True, many="", measured="", usual=False),
    C.name: Runner(build, batches=True, many=BATCH, measured="", usual=False),
    UFUNC.name: Runner(_extension, batches=True, many="", measured=DOUBLES, usual=True),
    JS.name: Runner(run_js, batches=False, many="", measured="", usual=False),
}


def run_or_python(sources: Sources, run: Callable[[Sources], Any]) -> tuple[dict[str, Call], bool]:
    """Return the functions of sources by name, and whether they run as asked.

    Where this machine lacks what that takes, they are those of the NumPy module, and a warning says so, once; so is, in
    silence, a function that the target leaves out, such as a ufunc of a result without entries.
    """
    try:
        module = run(sources)
    except MissingProgram as fault:
        warn_once(f"{fault}\n{SLOWER}")
        module = None
    calls = {name: getattr(module, name, None) for name in sources.functions}
    if not all(calls.values()):
        plain = emit(sources.program, real=sources.real)
        there = run_python(plain)
        for name, other in zip(calls, plain.functions, strict=True):
            calls[name] = calls[name] or getattr(there, other)
    return {name: call for name, call in calls.items() if call}, module is not None

"""The heyoka target: a module whose functions are heyoka's expressions, and the equations of motion of its integrator.

import two_link_heyoka, heyoka
start, pars = [0.1, 0.2, 0, 0], [1, 1, 1, 1, 9.81, 0, 0]
run = heyoka.taylor_adaptive(two_link_heyoka.dynamics(), start, pars=pars, compact_mode=True)
run.propagate_until(10.0)
"""

from __future__ import annotations

import builtins
import keyword
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import accumulate

from symdyn.dynamics.mechanism import TIME
from symdyn.emit.code.operators import OPERATORS, Printer, Spelling, call
from symdyn.emit.code.real import digits
from symdyn.emit.code.target import ArgumentText, Draft, FunctionText, Target, alone
from symdyn.emit.escape import in_docstring
from symdyn.emit.render import render
from symdyn.graph import Op
from symdyn.program import Program
from symdyn.scene.values import velocity_name

SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(f"heyoka.{op.name.lower()}") for op in (Op.SIN, Op.COS, Op.SQRT, Op.EXP, Op.LOG, Op.TANH)},
    Op.ATAN2: call("heyoka.atan2", 2),
}

LACKS: Mapping[Op, str] = {
    Op.SIGN: "a Taylor series does not step over a jump; give dry friction a smoothing, or take another target",
    Op.ABS: "a Taylor series does not step over a corner; write sqrt(x**2 + e**2), e small, or take another target",
}

BUILTINS = tuple(name for name in dir(builtins) if not name.startswith("_"))

HELPERS = ("array_of", "expressions_of", "pars_of")
"""What the module has for itself, with a stroke before it, as what writes out a function."""

KEYWORDS = frozenset((*keyword.kwlist, *BUILTINS, *HELPERS, "dynamics", "heyoka", "numpy"))
"""Reserved words, what is there unasked, and what the module has and imports."""

MOTION, RATES = "forward_dynamics", "coordinate_rates"
"""Functions that the equations of motion are made of; the second where velocities are no rates of coordinates."""

STATE = ("q", "qd")
"""Arguments that are heyoka's variables."""


def _write(draft: Draft) -> dict[str, str]:
    """Return the module."""
    scene = draft.program.scene
    there = {function.name: function for function in draft.page.functions}
    plain = scene.velocities == tuple(map(velocity_name, scene.coordinates))
    wanted = (MOTION,) if plain else (MOTION, RATES)
    values = {
        "page": draft.page,
        "about": draft.about,
        "missing": [name for name in wanted if name not in there],
        "motion": there.get(MOTION),
        "rates": None if plain else there.get(RATES),
        "given": _given([there[name] for name in wanted if name in there]),
        "coordinates": list(scene.coordinates),
        "velocities": list(scene.velocities),
    }
    return {f"{draft.stem}_heyoka.py": render("heyoka/module.py.jinja", values)}


def _given(functions: Sequence[FunctionText]) -> list[tuple[ArgumentText, int]]:
    """Return the arguments beside state and time, and where heyoka's parameters for them begin: free ones first."""
    every = {one.name: one for function in functions for one in function.arguments if one.name not in (*STATE, TIME)}
    ordered = sorted(every.values(), key=lambda one: one.name not in (Program.PARAMS, Program.PREPARED))
    return list(zip(ordered, [0, *accumulate(one.length for one in ordered)], strict=False))


HEYOKA = Target(
    name="heyoka",
    title="heyoka",
    text="expressions of heyoka, ready for its Taylor series, in doubles",
    reals=("double",),
    options={},
    files={"{stem}_heyoka.py": str},
    first=0,
    keywords=KEYWORDS,
    lacks=LACKS,
    functions=None,
    tunes=False,
    printer=lambda real: Printer(SPELLINGS, partial(digits, real=real)),
    comment=in_docstring,
    write=_write,
    beside=alone,
    shortens=(),
    loops=False,
)

"""Targets that are modules of Python: NumPy's and heyoka's.

The NumPy module runs with NumPy alone, for one state or a batch of them. Every function is written once, for people to
read, with bare `sin` and `cos`. For one state, or as few as 16, the module runs that text over plain floats: NumPy's
calls on so short arrays take longer. For a batch it records, the first time, which NumPy calls the text comes to, and
makes them on blocks of states with `out=`: all intermediate results share a few rows of one work space, used again and
again while they lie in the cache. Nothing is allocated line by line, and no text is compiled.

The heyoka module has functions that are heyoka's expressions, and the equations of motion of its integrator.

    import two_link_heyoka, heyoka
    start, pars = [0.1, 0.2, 0, 0], [1, 1, 1, 1, 9.81, 0, 0]
    run = heyoka.taylor_adaptive(two_link_heyoka.dynamics(), start, pars=pars, compact_mode=True)
    run.propagate_until(10.0)
"""

from __future__ import annotations

import builtins
import keyword
from collections.abc import Mapping, Sequence
from functools import cache, partial
from importlib.resources import files
from itertools import accumulate

from symdyn.dynamics.mechanism import TIME
from symdyn.emit.code.spelling import OPERATORS, REALS, SINGLE, TABLE, Printer, Real, Spelling, call, digits
from symdyn.emit.code.target import ArgumentText, Draft, FunctionText, Target
from symdyn.emit.render import in_docstring, render
from symdyn.graph import ELEMENTARY, Op
from symdyn.program import Program
from symdyn.scene.values import velocity_name

FUNCTIONS: Mapping[Op, tuple[str, str, str]] = {
    **{op: (op.name.lower(), f"math.{op.name.lower()}", f"numpy.{op.name.lower()}") for op in ELEMENTARY},
    Op.SIGN: ("sign", "_sign", "numpy.sign"),
    Op.ATAN2: ("atan2", "math.atan2", "numpy.arctan2"),
    Op.POW: ("pow", "math.pow", "numpy.power"),
    Op.SELECT: ("select", "_select", "_select_rows"),
}
"""Names, and what each stands for among plain floats and among arrays; `abs` is Python's for both."""

NUMPY_SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(name, op.arity) for op, (name, _, _) in FUNCTIONS.items()},
    Op.ABS: call("abs"),
    Op.TABLE: TABLE,
}

BLOCK = 4096
"""States that are computed at a time: enough to hide the cost of a NumPy call, few enough for the cache."""

RETURN = """    return numpy.fromiter(entries, numpy.float64).reshape(shape)"""
NARROW = """    with numpy.errstate(over="ignore"):  # what is too large for the type is infinity
        return numpy.fromiter(entries, numpy.float64).reshape(shape)"""
"""How floats of Python become numbers of the type; those of a narrower one may be too large for it."""

ASSIGN = """    results[...] = rows"""
ASSIGN_NARROW = """    with numpy.errstate(over="ignore"):
        results[...] = rows"""
"""The same for a few states."""

PYTHON = (*keyword.kwlist, *(name for name in dir(builtins) if not name.startswith("_")))
"""Reserved words, and what is there unasked."""

NUMPY_WORDS = frozenset((*PYTHON, "collections", "functools", "math", "numpy"))
"""Those, and what the module imports."""


def _write_numpy(draft: Draft) -> dict[str, str]:
    used = {f.name: [op for op in FUNCTIONS if op in f.operations] for f in draft.page.functions}
    values = {
        "page": draft.page,
        "about": draft.about,
        "dtype": draft.real.dtype,
        "block": BLOCK,
        "player": player_text(draft.real, BLOCK),
        "branches": [row for op, row in FUNCTIONS.items() if any(op in ops for ops in used.values())],
        "used": {name: [FUNCTIONS[op][0] for op in ops] for name, ops in used.items()},
    }
    return {f"{draft.stem}.py": render("numpy/module.py.jinja", values)}


@cache
def player_text(real: Real, block: int) -> str:
    """Return `symdyn.emit.targets.player` as it stands in a module of a number type and of blocks of so many states."""
    text = files("symdyn.emit.targets").joinpath("player.py").read_text(encoding="utf-8")
    text = text[text.index("def _run(") :].rstrip("\n")
    if real is not REALS["double"]:
        text = text.replace(RETURN, NARROW).replace(ASSIGN, ASSIGN_NARROW)
    return text.replace("float64", real.dtype).replace("4096", str(block))


NUMPY = Target(
    name="numpy",
    title="NumPy",
    text="a module that runs with NumPy alone, for one state or a batch",
    reals=SINGLE,
    files={"{stem}.py": str},
    keywords=NUMPY_WORDS,
    printer=lambda real: Printer(NUMPY_SPELLINGS, partial(digits, real=real)),
    comment=in_docstring,
    write=_write_numpy,
)


HEYOKA_SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(f"heyoka.{op.name.lower()}", op.arity) for op in (*ELEMENTARY, Op.ATAN2)},
    Op.POW: call("_pow_of", 2),
}

HEYOKA_LACKS: Mapping[Op, str] = {
    Op.SIGN: "a Taylor series does not step over a jump; give dry friction a smoothing, or take another target",
    Op.ABS: "a Taylor series does not step over a corner; write sqrt(x**2 + e**2), e small, or take another target",
    Op.SELECT: "a Taylor series does not step over a corner; write a smooth formula, or take another target",
}

HEYOKA_HELPERS = ("array_of", "expressions_of", "pars_of", "pow_of")
"""What the module has for itself, with a stroke before it, as what writes out a function."""

HEYOKA_WORDS = frozenset((*PYTHON, *HEYOKA_HELPERS, "dynamics", "heyoka", "numpy"))
"""Reserved words, what is there unasked, and what the module has and imports."""

MOTION, RATES, WHOLE_STATE = "forward_dynamics", "coordinate_rates", "state_rates"
"""Functions that equations of motion are made of; the second where velocities are no rates of coordinates, the third in
place of both where there are states of one's own."""

STATE = ("q", "qd", "internal")
"""Arguments that are heyoka's variables."""


def _write_heyoka(draft: Draft) -> dict[str, str]:
    scene = draft.program.scene
    there = {function.name: function for function in draft.page.functions}
    plain = scene.velocities == tuple(map(velocity_name, scene.coordinates))
    own = [one.name for one in scene.states]
    wanted = (WHOLE_STATE,) if own else (MOTION,) if plain else (MOTION, RATES)
    values = {
        "page": draft.page,
        "about": draft.about,
        "missing": [name for name in wanted if name not in there],
        "motion": there.get(wanted[0]),
        "own": own,
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
    files={"{stem}_heyoka.py": str},
    keywords=HEYOKA_WORDS,
    lacks=HEYOKA_LACKS,
    printer=lambda real: Printer(HEYOKA_SPELLINGS, partial(digits, real=real)),
    comment=in_docstring,
    write=_write_heyoka,
)

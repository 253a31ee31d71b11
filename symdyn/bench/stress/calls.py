"""What cases are measured with: every implementation of a function at given states, and the truth at 50 digits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb_mat

from symdyn.algebra import Balls, Floats
from symdyn.bench.reference import Reference, column, norm, reference
from symdyn.dynamics import Equations, Function, Requested, Workspace, derive_one, row_of
from symdyn.emit import emit
from symdyn.errors import MissingCompiler
from symdyn.graph import evaluate
from symdyn.program import Program, choose, identifier, lower
from symdyn.runtime import RUNNERS, build
from symdyn.scene import Scene

Array = npt.NDArray[np.float64]

SINGULAR_BITS = 600
"""Bits of the reference where a mass matrix is inverted: condition numbers reach 1e30."""


@dataclass(frozen=True)
class Calls:
    """A scene's functions, ready to be measured.

    Attributes:
        program: of them.
        others: functions without code.
        modules: NumPy module and compiled C by name; the second is missing where there is no compiler.
    """

    program: Program
    others: Program
    modules: Mapping[str, Any]

    def function(self, name: str) -> Function:
        """Return the function of an output, with code or without; where loops close, its own name may be another."""
        return next(program[name] for program in (self.program, self.others) if name in program).function

    def results(self, name: str, states: Mapping[str, Array]) -> dict[str, Array]:
        """Return the results of every implementation at states, a row a state; shapes (N, size)."""
        function = self.function(name)
        legal = identifier(function.name)
        given = [states[a.name][..., 0] if a.scalar else states[a.name] for a in function.arguments]
        count = max(
            (len(x) for x, a in zip(given, function.arguments, strict=True) if x.ndim > len(a.shape)), default=1
        )
        found = {}
        with np.errstate(all="ignore"):
            for way, module in self.modules.items():
                call = getattr(module, legal)
                found[f"{way}, many states"] = np.asarray(call(*given), float).reshape(count, -1)
                rows = [call(*(x[k] for x in given)) for k in range(count)]
                found[f"{way}, one state"] = np.asarray(rows, float).reshape(count, -1)
        return found

    def truth(self, name: str, states: Mapping[str, Array]) -> Reference:
        """Return exact results with running error bounds."""
        count = max(len(value) for value in states.values())
        return reference(self.function(name), states, count)


def looked_at(scene: Scene) -> tuple[str, ...]:
    """Return the outputs that a first look at a scene shows, as far as it has them."""
    there, _ = Requested.of(Workspace(scene)).available()
    return tuple(name for name in there if row_of(name)[0].default_in == "overview")


class Interpreted:
    """A program's functions by name, run operation by operation in doubles: for those too long to be compiled."""

    def __init__(self, program: Program) -> None:
        """Take the functions of a program."""
        self.functions = {routine.function.name: routine.function for routine in program.routines}

    def __getattr__(self, name: str) -> Callable[..., Array]:
        """Return a function by name, of one state or of many."""
        if name.startswith("_") or name not in self.functions:
            raise AttributeError(name)
        function = self.functions[name]

        def call(*given: Array) -> Array:
            if given[0].ndim > len(function.arguments[0].shape):
                return np.array([call(*one) for one in zip(*given, strict=True)])
            return np.array(evaluate(function.entries, Floats(), function.values(given))).reshape(function.shape)

        return call


def calls(
    scene: Scene,
    outputs: Sequence[str],
    real: str = "double",
    formulation: str | None = None,
    beside: Sequence[str] = (),
    compiled: bool = True,
) -> Calls:
    """Return functions of a scene in NumPy and in C with batch code.

    Of outputs `beside` them true values are needed and no code. What is not `compiled` is run operation by operation
    in place of both. A formulation of None is the cheapest.
    """
    w = Workspace(scene)
    functions = (
        choose(w, outputs) if formulation is None else tuple(derive_one(w, name, formulation) for name in outputs)
    )
    program = lower(Equations(scene, w.graph, functions))
    others = lower(Equations(scene, w.graph, tuple(derive_one(w, name) for name in beside)), passes=())
    if not compiled:
        return Calls(program, others, {"program": Interpreted(program)})
    modules: dict[str, Any] = {"NumPy": RUNNERS["numpy"].run(emit(program, real=real))}
    with suppress(MissingCompiler):
        modules["C"] = build(program, real=real)
    return Calls(program, others, modules)


@dataclass(frozen=True)
class Solved:
    """How well M qdd = tau - h was solved, infinity norms.

    Attributes:
        forward: |qdd - true| / (n eps |M^-1| (|M||qdd| + |h| + |tau|)).
        backward: |M qdd + h - tau| / (eps (|M||qdd| + |h| + |tau|)).
        where: implementation and state.
    """

    forward: float
    backward: float
    where: str


EPSILON = 2.0**-52


def solved(made: Calls, states: Mapping[str, Array], epsilon: float = EPSILON) -> list[Solved]:
    """Return how well every implementation of forward dynamics solves at every state where M and h are finite.

    Args:
        made: has forward_dynamics, mass_matrix and inverse_dynamics.
        states: q, qd, tau of shapes (N, n), and params if there are free ones.
        epsilon: spacing of the numbers at one.
    """
    n, count = states["tau"].shape[1], len(states["q"])
    at_rest = {**states, "qdd": np.zeros((count, n))}
    name = "forward_dynamics"
    M, h, exact = (_exact(made.function(one), at_rest, count) for one in (*row_of(name)[0].solves, name))
    results = made.results(name, states)
    found = []
    with Balls(SINGULAR_BITS) as algebra:
        for k in range(count):
            if not all(ball.is_finite() for ball in (*M[k], *h[k])):
                continue  # there is nothing to solve
            matrix, force = arb_mat(n, n, M[k]), arb_mat(n, 1, h[k])
            inverse = norm(matrix.inv())
            tau = column(states["tau"][k], algebra)
            for way, values in results.items():
                if not np.isfinite(values[k]).all():
                    found.append(Solved(np.inf, np.inf, f"{way}, state {k}"))
                    continue
                qdd = column(values[k], algebra)
                size = epsilon * (norm(matrix) * norm(qdd) + norm(force) + norm(tau) or 1.0)
                error, residual = norm(qdd - arb_mat(n, 1, exact[k])), norm(matrix * qdd + force - tau)
                found.append(Solved(error / (n * inverse * size), residual / size, f"{way}, state {k}"))
    return found


def _exact(function: Function, states: Mapping[str, Array], count: int) -> list[list[Any]]:
    found = []
    with Balls(SINGULAR_BITS) as algebra:
        for k in range(count):
            given = [states[argument.name][k] for argument in function.arguments]
            found.append(evaluate(function.entries, algebra, function.values(given, algebra.number)))
    return found

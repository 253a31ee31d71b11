"""How the end of a run depends on its start and on parameters: the function `sensitivity`.

    Φ = ∂(end)/∂(start, p)        by variational equations (forward) or by adjoints (backward), see `variations`

Positions move along the velocities, d/dε f(q ∘ exp(ε X_k)), velocities by themselves, each with the other held. The
start of a closed mechanism moves along its manifold: independent positions (of rows that hold positions) and
independent velocities (of all rows) are the columns, what depends on them follows, δr = 0 and δ(G u) = 0. A parameter
changes while the independent start is held: what depends on it follows the parameter too, as prescribed motions do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Unpack

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import check_arguments, with_fields
from symdyn.errors import SimulateError, UnknownNameError
from symdyn.scene import Scene, SceneLike
from symdyn.scene.values import Faults, listed, suggestion
from symdyn.shown import Shown
from symdyn.simulation.equations.variational import AGAINST, ALONG, Flow
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.feedback.gains import state_names
from symdyn.simulation.integrate.method import DOUBLES
from symdyn.simulation.integrate.tape import UNHEARD
from symdyn.simulation.problem import Problem
from symdyn.simulation.run import Outlook
from symdyn.simulation.variations import Variations

DOORS = {"forward": ALONG, "adjoint": AGAINST}

RTOL = 1e-12
"""Tolerance of a step: of the motion, and so of its derivatives, whose steps are the same."""


@dataclass(frozen=True, eq=False)
class Sensitivity(Shown):
    """How the end of a run depends on its start and on parameters.

    Attributes:
        scene: the mechanism.
        t: time of the end, s.
        q, u: coordinates and velocities there, shapes (nq,) and (nv,).
        rows: names of positions and velocities at the end.
        columns: names of positions and velocities at the start, then of parameters.
        matrix: shape (rows, columns); units are those of the row over those of the column.
        by: "forward" or "adjoint".
        method: the integrator.
        steps: how many it took.
        notes: what a user should know of the start.
    """

    scene: Scene
    t: float
    q: Array
    u: Array
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    matrix: Array = field(repr=False)
    by: str
    method: str
    steps: int
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        what = f"at t = {self.t:g} s, d({listed(self.rows)}) / d({listed(self.columns)})"
        return f"<Sensitivity of {self.scene.name}: {what}, by {self.by}>"

    def __getitem__(self, names: tuple[str, str]) -> float:
        """Return the entry of a row and a column by their names; UnknownNameError if there is none."""
        check_arguments(Sensitivity.__getitem__, locals(), UnknownNameError)
        for name, known in zip(names, (self.rows, self.columns), strict=True):
            if name not in known:
                raise UnknownNameError(f"{name} is not there; {suggestion(name, known)}")
        return float(self.matrix[self.rows.index(names[0]), self.columns.index(names[1])])


@with_fields(Problem)
def sensitivity(
    scene: SceneLike | Problem,
    *,
    until: float = 10.0,
    parameters: str | Sequence[str] | None = None,
    of: str | Sequence[str] | None = None,
    by: str = "forward",
    rtol: float | None = None,
    atol: float | None = None,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
    **fields: Unpack[Problem.Fields],
) -> Sensitivity:
    """Return how the state at the end of a run depends on its start and on parameters.

    >>> import symdyn
    >>> found = symdyn.sensitivity(symdyn.example("cart_pole"), until=1, parameters="mp", of="x")
    >>> found
    <Sensitivity of cart_pole: at t = 1 s, d(x) / d(x, theta, x_dot, theta_dot, mp), by forward>
    >>> found.matrix.shape
    (1, 5)

    Args:
        scene: the mechanism, its parameters bound; or a `Problem`.
        **fields: of `Problem`.
        until: time of the end, s.
        parameters: name of the one that is varied, or names; None for all that are free in the equations.
        of: a position or velocity at the end, or several; None for all. Adjoints cost by them, not by the columns.
        by: "forward", variational equations, or "adjoint".
        rtol: relative tolerance of a step; None takes 1e-12.
        atol: absolute tolerance of a step; None takes rtol.
        progress: called with the share that is done: to 0.5 of the run, from there on of its derivatives.
        say: called with lines for the user: how long a long run takes.

    Raises:
        SimulateError: with every fault of the arguments; the run ends sooner, or would take years; or its equations
            jump.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    problem, run = Problem.requested(sensitivity, locals())
    scene, faults = problem.scene, Faults("")
    forces, initial, _, _ = problem.posed(run, faults, finest=DOUBLES)
    forces.check_differentiable(faults)
    if by not in DOORS:
        faults.add("by", f"{by} is not known; {suggestion(by, DOORS)}")
    every, known = state_names(scene), [one.name for one in scene.parameters]
    rows = tuple(every) if of is None else _each(of)
    parameters = None if parameters is None else _each(parameters)
    for name in rows:
        if name not in every:
            faults.add("of", f"{name} is no position or velocity of the end; {suggestion(name, every)}")
    for name in parameters or ():
        if name not in known:
            faults.add("parameters", f"{name} is not known; {suggestion(name, known)}")
    faults.close(SimulateError)
    system = state_equations(scene, forces, (), problem.whole)
    x = np.concatenate([initial.q, initial.u, np.zeros(int(system.works))])
    outlook, told = Outlook(run.until, say), progress or UNHEARD

    def look(t: float) -> None:
        outlook.look(t)
        told(t / run.until / 2)

    def later(part: float) -> None:
        told((1 + part) / 2)

    of_run = Variations.of(
        system,
        x,
        np.array([0.0, run.until]),
        None,
        parameters,
        RTOL if run.rtol is None else run.rtol,
        run.atol,
        DOORS[by],
        look,
    )
    end, tape = of_run.tape.x[-1], of_run.tape
    covectors = _ends(of_run.flow, end)[[every.index(name) for name in rows]]
    matrix = covectors @ of_run.forward(later)[-1].T if by == "forward" else of_run.backward(covectors, later)
    if not np.all(np.isfinite(matrix)):
        raise SimulateError(f"{scene.name}: a derivative has no finite value on the way to t = {run.until:g} s")
    q, u, notes = end[: system.nq], end[system.nq :], (*initial.notes, *system.notes, *of_run.notes)
    return Sensitivity(scene, run.until, q, u, rows, of_run.names, matrix, by, tape.method, len(tape.steps), notes)


def _each(names: str | Sequence[str]) -> tuple[str, ...]:
    """Return names once each; one name alone is one."""
    return (names,) if isinstance(names, str) else tuple(dict.fromkeys(names))


def _ends(along: Flow, x: Array) -> Array:
    """Return the covectors of all positions along the velocities, and of velocities, at a state, shape (2 nv, nx)."""
    nq, nv = along.system.nq, along.system.nv
    found = np.zeros((2 * nv, along.size))
    found[:nv, :nq] = np.linalg.pinv(along.turned(x[:nq]))
    found[nv:, nq:] = np.eye(nv)
    return found

"""How the end of a run depends on its start and on parameters: the function `sensitivity`.

    Φ = ∂(end)/∂(start, p)        by variational equations (forward) or by adjoints (backward), see `variations`

Positions move along the velocities, d/dε f(q ∘ exp(ε X_k)), velocities by themselves, each with the other held. The
start of a closed mechanism moves along its manifold: independent positions (of rows that hold positions) and
independent velocities (of all rows) are the columns, what depends on them follows, δr = 0 and δ(G u) = 0. A parameter
changes while the independent start is held: what depends on it follows the parameter too, as prescribed motions do.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import check_arguments, doubles
from symdyn.errors import SimulateError, UnknownNameError
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.scene.values import Faults, listed, suggestion
from symdyn.shown import Shown
from symdyn.simulation.equations.variational import AGAINST, ALONG, Flow
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.feedback.gains import state_names
from symdyn.simulation.forward import check_run
from symdyn.simulation.initial import Start, Values, read_start
from symdyn.simulation.integrate.method import DOUBLES
from symdyn.simulation.integrate.tape import UNHEARD
from symdyn.simulation.prescribed.entries import Entries
from symdyn.simulation.prescribed.forces import Forces, read_forces
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


def sensitivity(
    scene: SceneLike,
    forces: Forces | Entries = Forces(),  # noqa: B008  frozen
    until: float = 10.0,
    start: Values | Start | None = None,
    start_rates: Values | None = None,
    parameters: str | Sequence[str] | None = None,
    of: str | Sequence[str] | None = None,
    by: str = "forward",
    rtol: float | None = None,
    atol: float | None = None,
    values: Mapping[str, object] | None = None,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Sensitivity:
    """Return how the state at the end of a run depends on its start and on parameters.

    >>> import symdyn
    >>> found = symdyn.sensitivity(symdyn.example("cart_pole"), until=1, parameters="mp", of="x")
    >>> found
    <Sensitivity of cart_pole: at t = 1 s, d(x) / d(x, theta, x_dot, theta_dot, mp), by forward>
    >>> found.matrix.shape
    (1, 5)

    Args:
        scene: the mechanism, its parameters bound.
        forces: driving forces, from `read_forces`, or what that takes.
        until: time of the end, s.
        start: formulas by coordinate, in place of what the scene says; or a whole state.
        start_rates: formulas by velocity.
        parameters: name of the one that is varied, or names; None for all that are free in the equations.
        of: a position or velocity at the end, or several; None for all. Adjoints cost by them, not by the columns.
        by: "forward", variational equations, or "adjoint".
        rtol: relative tolerance of a step; None takes 1e-12.
        atol: absolute tolerance of a step; None takes rtol.
        values: of parameters, in place of those that the scene gives.
        progress: called with the share that is done: to 0.5 of the run, from there on of its derivatives.
        say: called with lines for the user: how long a long run takes.

    Raises:
        SimulateError: with every fault of the arguments; the run ends sooner, or would take years; or its equations
            jump.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    check_arguments(sensitivity, locals(), SimulateError)
    until, rtol, atol = doubles(until, rtol, atol)
    scene = scene_of(scene)
    scene = scene_of(scene, values)
    faults = Faults("")
    forces = forces if isinstance(forces, Forces) else read_forces(scene, forces)
    with faults.noted():
        initial = read_start(scene, start, start_rates)
    with faults.noted():
        check_run(scene, until, None, rtol, atol, finest=DOUBLES)
    for one in forces.functions:
        faults.add(one.where, "a function has no derivatives; write a formula")
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
    system = state_equations(scene, forces, (), initial.q if isinstance(start, Start) else None)
    x = np.concatenate([initial.q, initial.u, np.zeros(int(system.works))])
    outlook, told = Outlook(until, say), progress or UNHEARD

    def look(t: float) -> None:
        outlook.look(t)
        told(t / until / 2)

    def later(part: float) -> None:
        told((1 + part) / 2)

    of_run = Variations.of(
        system, x, np.array([0.0, until]), None, parameters, RTOL if rtol is None else rtol, atol, DOORS[by], look
    )
    end, tape = of_run.tape.x[-1], of_run.tape
    covectors = _ends(of_run.flow, end)[[every.index(name) for name in rows]]
    matrix = covectors @ of_run.forward(later)[-1].T if by == "forward" else of_run.backward(covectors, later)
    if not np.all(np.isfinite(matrix)):
        raise SimulateError(f"{scene.name}: a derivative has no finite value on the way to t = {until:g} s")
    q, u, notes = end[: system.nq], end[system.nq :], (*initial.notes, *system.notes, *of_run.notes)
    return Sensitivity(scene, until, q, u, rows, of_run.names, matrix, by, tape.method, len(tape.steps), notes)


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

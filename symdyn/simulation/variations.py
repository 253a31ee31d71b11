"""How a run depends on its start and on parameters: its steps, differentiated, and the function `sensitivity`.

    Ẇ = ∂f/∂x W + ∂f/∂p C        W = ∂x/∂(start, p), a way a column; C says by how much it changes each parameter
    Φ = ∂(end)/∂(start, p)       the last W, by variational equations (forward) or by adjoints (backward)

The steps of the run are differentiated (`tape`); they end on each sample that is asked for. What does not belong to the
state (forces, energies, points, outputs) has central differences: evaluated on both sides of the run, divided by the
distance.

Positions move along the velocities, d/dε f(q ∘ exp(ε X_k)), velocities by themselves, each with the other held. The
start of a closed mechanism moves along its manifold. The columns are independent positions (by constraints on them) and
independent velocities (by all); the others follow from δr = 0 and δ(G u) = 0. A parameter changes while the independent
start is held: what depends on it follows the parameter too, as prescribed motions do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Unpack

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import check_arguments, with_fields
from symdyn.errors import SimulateError, UnknownNameError, listed, suggestion
from symdyn.frozen import dataclass, field
from symdyn.scene import Scene, SceneLike, with_values
from symdyn.scene.values import Faults
from symdyn.shown import Shown
from symdyn.simulation.equations.linear_feedback import state_names
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.equations.variational import AGAINST, ALONG, Flow, smooth_flow
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.forward import Control, check_start, is_stiff, ready
from symdyn.simulation.initial import Start
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.integrate.integration import DOUBLES, END, Integration, IntegrationError, Outlook
from symdyn.simulation.integrate.tape import UNHEARD, Tape, Told, taped
from symdyn.simulation.prescribed.forces import Forces
from symdyn.simulation.problem import Problem
from symdyn.simulation.trajectory import Trajectory
from symdyn.simulation.trajectory_builder import trajectory_of
from symdyn.unlocked import cached_property

RTOL = 1e-10
"""Relative tolerance of a step, of a run whose columns are varied."""

STEP = 1e-5
"""Part of a parameter's size, or 1, by which columns beside the state are told on both sides of a run."""

UNTOLD = frozenset({"work", "energy_error", "loop_error", "loop_rate_error"})
"""Columns that say how well a run was integrated, or what is integrated beside it: of these nothing is told."""


@dataclass(frozen=True, eq=False)
class Variations:
    """The steps of a run, and the directions in which it moves where its start or a parameter does."""

    flow: Flow  # the mechanism under its forces, and its derivative
    tape: Tape  # the steps
    times: Array  # at which steps end, s, shape (T,)
    names: tuple[str, ...]  # positions and velocities at the start, and parameters, shape (k,)
    starts: Array  # change of the state at the start, q and then u, over that of each name, shape (k, nq + nv)
    changes: Array  # by how much each name changes each of the flow's parameters, shape (k, at least 1)
    notes: tuple[str, ...] = ()  # what a user should know of tolerances

    @classmethod
    def of(
        cls,
        system: StateEquations,
        x: Array,
        times: Array,
        names: Sequence[str] | None = None,
        parameters: Sequence[str] | None = None,
        rtol: float = RTOL,
        atol: float | None = None,
        sweep: str = ALONG,
        look: Told = UNHEARD,
    ) -> Variations:
        """Return the steps of a run from a state on.

        Args:
            system: the mechanism under its forces.
            x: the state at the first of the times, work behind it.
            times: ascending, s, shape (T,).
            names: what is varied; None for the independent positions and velocities, and the parameters.
            parameters: of the flow; None for all that are free in the equations.
            rtol: relative tolerance of a step.
            atol: absolute tolerance of a step; None takes rtol.
            sweep: along directions, or against covectors.
            look: hears the time after every step.

        Raises:
            IntegrationError: the run does not come to its end.
            SimulateError: forces jump; a name that follows others through the loops; or times that are one double.
        """
        check_start(system, x)
        flow = smooth_flow(system, parameters, sweep)
        starts, changes, known = flow.starting(x[: flow.size])
        lacking = [name for name in names or () if name not in known]
        if lacking:
            raise SimulateError(
                f"{system.scene.name}: {', '.join(lacking)} at the start follows others through the loops; independent "
                f"there are {listed(known[: len(known) - len(flow.parameters)])}"
            )
        rows = [known.index(name) for name in (known if names is None else names)]
        names, starts, changes = tuple(known[k] for k in rows), starts[rows], changes[rows]
        until = float(times[-1])
        stiff = is_stiff(system, x, until)
        name = "radau" if stiff else "dop853"
        relative, absolute, said = METHODS[name].tolerances(name, rtol, atol)
        parts = np.cos(1.0 + np.arange(len(rows))) * [_size(system, name) for name in names]
        probe = parts @ starts, parts @ changes
        tape = taped(flow, x[: flow.size], probe, times, relative, absolute, stiff, look)
        if len(tape.x) != len(times):
            same = f"until = {until:.6g} s leaves times that are the same double"
            raise SimulateError(f"{system.scene.name}: {same}; give fewer times or a later end")
        return cls(flow, tape, times, names, starts, changes, tuple(said))

    def forward(self, reported: Told = UNHEARD) -> Array:
        """Return the change of the state at all times over that of each name, shape (T, k, nq + nv)."""
        return self.tape.forward(self.flow, self.starts, self.changes, reported)

    def backward(self, covectors: Array, reported: Told = UNHEARD) -> Array:
        """Return the derivatives of combinations of the state at the end, shape (m, nq + nv); shape (m, k)."""
        moved, changed = self.tape.backward(self.flow, covectors, reported)
        return moved @ self.starts.T + changed @ self.changes[:, : len(self.flow.parameters)].T

    @cached_property
    def ways(self) -> Array:
        """What `forward` returns."""
        return self.forward()

    def slopes(self, run: Trajectory, columns: Sequence[str]) -> Array:
        """Return the derivatives of columns of the run by each of the names, shape (T, columns, k)."""
        scene = run.scene
        nq, nv = len(scene.coordinates), len(scene.velocities)
        accelerations = run.names[1 + nq + nv : 1 + nq + 2 * nv]
        exact = [*scene.coordinates, *scene.first_order, *accelerations]
        each = zip(self.times.tolist(), self.tape.x, self.ways, strict=True)
        rates = np.array([self.flow.along(t, x, way, self.changes) for t, x, way in each])
        parts = np.concatenate([self.ways, rates[:, :, nq : nq + nv]], axis=2)
        found = np.zeros((len(run.t), len(columns), len(self.names)))
        beside = [name for name in columns if name not in exact]
        for j, name in enumerate(columns):
            if name in exact:
                found[:, j] = parts[:, :, exact.index(name)]
        if beside:
            at = [j for j, name in enumerate(columns) if name not in exact]
            for k in range(len(self.names)):
                step = self.step(k)
                ahead, behind = (self.beside(run, k, sign * step) for sign in (1, -1))
                found[:, at, k] = np.array([(ahead[name] - behind[name]) / (2 * step) for name in beside]).T
        return found

    def step(self, k: int) -> float:
        """Return by how much a name may be moved, so that the run moves by little against the size of everything."""
        largest = float(np.abs(self.ways[:, k]).max(initial=0.0))
        return STEP * min(_size(self.flow.system, self.names[k]), 1.0 / largest if largest else 1.0)

    def beside(self, run: Trajectory, k: int, step: float) -> Trajectory:
        """Return the run as it is to first order where one of the names is moved by a step."""
        system = self.flow.system
        x = run.states + step * self.ways[:, k]
        x = np.hstack([x, np.zeros((len(x), int(system.works)))])
        moved = {
            name: system.opened.values[name] + step * float(change)
            for name, change in zip(self.flow.parameters, self.changes[k], strict=False)
            if change
        }
        if moved:
            scene = with_values(system.scene, moved)
            system = system.at(scene, system.forces)
        return trajectory_of(system, Integration(run.t, x, (), END, 0, 0, 0.0, 0.0), (), (), False)


def variations(run: Trajectory, forces: Forces, start: Start, names: Sequence[str]) -> Variations:
    """Return how a run moves where names at its start, or parameters, move.

    Args:
        run: what `simulate` has found.
        forces: what drove it.
        start: the state that it started from.
        names: independent positions and velocities at the start as `sensitivity` calls them, and parameters.

    Raises:
        SimulateError: a name that is none of these; forces that have no derivative; or an integration that fails.
    """
    scene = run.scene
    _check(scene, forces, names)
    system = state_equations(scene, forces, (), start.q)
    x = np.concatenate([start.q, start.moving, np.zeros(int(system.works))])
    every = [one.name for one in scene.parameters]
    what = f"{scene.name}: variations of the run to t = {run.t[-1]:g} s"
    try:
        found = Variations.of(system, x, run.t, names, [name for name in names if name in every])
    except IntegrationError as fault:
        raise SimulateError(f"{what}: {fault}") from fault
    if not np.all(np.isfinite(found.ways)):
        raise SimulateError(f"{what}: a derivative has no finite value")
    return found


def _check(scene: Scene, forces: Forces, names: Sequence[str]) -> None:
    """Raise SimulateError with every name that is not known, and every force without derivatives."""
    faults = Faults("")
    every = [*state_names(scene), *(one.name for one in scene.parameters)]
    for name in names:
        if name not in every:
            told = f"{name} is no parameter, and no position or velocity; {suggestion(name, every)}"
            faults.add(scene.name, scene.derived_words(name) or told)
    forces.check_differentiable(faults)
    faults.close(SimulateError)


def _size(system: StateEquations, name: str) -> float:
    """Return what a change of a name is measured by: its size, of a parameter, or 1."""
    return abs(system.opened.values.get(name, 1.0)) or 1.0


DOORS = {"forward": ALONG, "adjoint": AGAINST}

END_RTOL = 1e-12
"""Tolerance of a step: of the motion, and so of its derivatives, whose steps are the same."""


@dataclass(frozen=True, eq=False)
class Sensitivity(Shown):
    """How the end of a run depends on its start and on parameters.

    Attributes:
        scene: the mechanism.
        t: time of the end, s.
        q, u: coordinates there, shape (nq,), velocities and states of one's own, shape (nu,).
        rows: names of positions, velocities and states at the end.
        columns: the same at the start, then parameters.
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
            faults.add("parameters", scene.derived_words(name) or f"{name} is not known; {suggestion(name, known)}")
    faults.close(SimulateError)
    system, x = ready(problem, forces, (), initial, run.until, Control())
    if system.contacts is not None and (closed := system.contacts.closed(x)):
        which = listed(map(system.contacts.name, closed))
        why = "contacts that are closed at the start, where not all can be varied; start where they are open"
        raise SimulateError(f"{scene.name}: {which}: {why}")
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
        END_RTOL if run.rtol is None else run.rtol,
        run.atol,
        DOORS[by],
        look,
    )
    end, tape = of_run.tape.x[-1], of_run.tape
    covectors = state_covectors(of_run.flow, end)[[every.index(name) for name in rows]]
    matrix = covectors @ of_run.forward(later)[-1].T if by == "forward" else of_run.backward(covectors, later)
    if not np.all(np.isfinite(matrix)):
        raise SimulateError(f"{scene.name}: a derivative has no finite value on the way to t = {run.until:g} s")
    q, u, notes = (
        end[: system.nq],
        end[system.nq : len(end) - system.hidden],
        (*initial.notes, *system.notes, *of_run.notes),
    )
    return Sensitivity(scene, run.until, q, u, rows, of_run.names, matrix, by, tape.method, len(tape.steps), notes)


def _each(names: str | Sequence[str]) -> tuple[str, ...]:
    """Return names once each; one name alone is one."""
    return (names,) if isinstance(names, str) else tuple(dict.fromkeys(names))


def state_covectors(along: Flow, x: Array) -> Array:
    """Return the covectors of all positions along the velocities, and of the rest of a state, shape (nv + nu, nx)."""
    nq, nv = along.system.nq, along.system.nv
    found = np.zeros((nv + along.system.nu, along.size))
    found[:nv, :nq] = np.linalg.pinv(along.turned(x[:nq]))
    found[nv:, nq:] = np.eye(along.system.nu)
    return found

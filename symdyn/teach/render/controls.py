"""Sliders: what of the state and the parameters can be moved by hand, from where, in which range, and what follows.

A quaternion is moved by roll, pitch and yaw: R = Rz(yaw) Ry(pitch) Rx(roll). In a mechanism with loops coordinates that
follow have a number only.

Of closed mechanisms all coefficients are reduced to the independent velocities, with what closes the loops:

    u = T u_i,  u̇ = T u̇_i + s      what loops and rows allow, s quadratic in u
    tau*_i = Tᵀ (M u̇ + c + g + k_E - Q),  so with b(u) = Tᵀ (M s + c):

    k_z* = Tᵀ M T,  k_G* = Tᵀ g,  k_E* = Tᵀ k_E,  k_D*_j = b(T e_j),  k_C*_jk = b(T e_j + T e_k) - b(T e_j) - b(T e_k)

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 3.2.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import combinations
from typing import Any

import numpy as np

from symdyn.draw import Text
from symdyn.dynamics import Function, Workspace, derive_one
from symdyn.dynamics.loops import Partition
from symdyn.dynamics.mechanism import TIME, quaternions, solve
from symdyn.dynamics.outputs import arguments
from symdyn.emit import in_html
from symdyn.emit.print import latex_symbols
from symdyn.errors import DerivationError, SymdynError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, reachable, substitute
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.forces import elastic
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Joint, Parameter, acceleration_name
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.dalembert.shown_motion import choose_motion
from symdyn.teach.mathematics import inline
from symdyn.teach.shown_state import shown_state, starting_rates, undriven

ACTING = "acting"

STATE = ("q", "qd", "qdd")

NOTHING = 1e-9
"""What a step of one metre or radian moves a coordinate by that it does not move."""


@dataclass(frozen=True)
class Held:
    """How loops and rows of a scene tie its state together.

    Attributes:
        velocities: independent ones.
        moved: by coordinate that may be moved by itself the velocity that is its rate, -1 where none is.
        closing: position-level rows, with the velocities that take a state back to them, in the order of solving;
            of a contact whose rows need each other, the one that holds its height, with all that they determine.
        drives: velocities with a drive.
        multipliers: (owner, words) of each, such as ("hinge", "force along x").
        undriven: why the drives are not determined; "" where they are.
    """

    velocities: tuple[int, ...]
    moved: dict[int, int]
    closing: Partition
    drives: tuple[int, ...]
    multipliers: tuple[tuple[str, str], ...]
    undriven: str

    @property
    def dependent(self) -> tuple[int, ...]:
        """Velocities that take a state back to what holds positions; none where rows hold velocities only."""
        return tuple(sorted(k for block in self.closing.blocks for k in block.velocities))


def held(w: Workspace) -> Held:
    """Return what a scene's loops and rows decide.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    decisions, labels = w.loops.decisions, w.loops.recursive.labels
    whole = decisions.partition
    G, closing = w.loops.G(w.loops.recursive), []
    for block in whole.blocks:
        rows = tuple(r for r in block.rows if labels[decisions.independent_rows[r]].holonomic)
        used = tuple(k for k in block.velocities if any(not G[r][k].is_zero for r in rows))
        if rows:
            closing.append(block if rows == block.rows else replace(block, rows=rows, velocities=used))
    back = Partition((), (), tuple(closing))
    words = tuple((labels[k].owner, decisions.names[k].partition(": ")[2]) for k in decisions.independent_rows)
    return Held(
        whole.independent,
        _moved(w, back),
        back,
        tuple(w.scene.actuated_velocities) if decisions.actuated else (),
        words,
        "" if decisions.actuated else decisions.fault,
    )


def _moved(w: Workspace, closing: Partition) -> dict[int, int]:
    """Return what `Held.moved` says."""
    found: dict[int, int] = {}
    q, u = 0, 0
    dependent = {k for block in closing.blocks for k in block.velocities}
    still = _left_alone(w, closing)
    for joint in w.scene.moving:
        size, ball = len(joint.coordinates), JOINTS[joint.type].quaternion(joint)
        places, velocities = range(q, q + size), range(u, u + len(joint.rates))
        if ball is None:
            found |= {q + k: u + k for k in range(size) if u + k not in dependent}
        elif not dependent.intersection(velocities):
            found |= dict.fromkeys(places, -1)
        elif still.issuperset(places[ball:]):
            found |= dict.fromkeys(sorted(still.intersection(places)), -1)
        q, u = q + size, u + len(joint.rates)
    return found


def _left_alone(w: Workspace, closing: Partition) -> set[int]:
    """Return the coordinates that no step of blocks with more velocities than rows moves; none without such."""
    blocks = [block for block in closing.blocks if len(block.rows) < len(block.velocities)]
    numbers, decisions = w.loops.numbers, w.loops.decisions
    at = np.array(decisions.assembly.regular)
    G = numbers.jacobian(at)[list(decisions.independent_rows)]
    moved = np.zeros(len(at))
    for block in blocks:
        steps = np.linalg.pinv(G[np.ix_(block.rows, block.velocities)])
        for step in steps.T:
            whole = np.zeros(w.state.n)
            whole[list(block.velocities)] = step / np.abs(step).max()
            moved += np.abs(numbers.retract(at, whole) - at)
    return {int(k) for k in np.flatnonzero(moved < NOTHING)} if blocks else set()


def reduced_functions(w: Workspace, tied: Held) -> list[Function]:
    """Return the functions of a closed mechanism's page.

    These are the coefficients of its rows, "row_forces", their sums, and "acting", what acts beside drives, all shape
    (independent,); "fitted_velocities" and "fitted_accelerations" of (q, qd), (q, qd, qdd), shape (nv,): independent
    entries as they are, the others as loops and rows demand; "correction" of q, Newton's step that closes loops, and
    "carried" of (q, qd), how dependent velocities of loops follow all others, shape (nv,); "constraint_residual";
    "inverse_dynamics" and, of (q, qd, qdd, tau), "multipliers". A motion passes positions at which a partition is
    singular, so it is kept on the loops by "nearest" velocities, (1 - G⁺ G) u, and "shortest" steps, -G⁺ r.
    """
    reduced, M, size = w.loops.reduction, w.composite_mass, len(tied.velocities)
    forces = w.forces(list(w.state.qdd))
    square, C, D = [x for row in reduced.mass(M) for x in row], *_velocity_coefficients(w)
    rows = [
        function(w, "k_z", "reduced k_z", square, ("q",), (size, size)),
        function(w, "k_C", "reduced k_C", C, ("q",), (size, size * (size - 1) // 2)),
        function(w, "k_D", "reduced k_D", D, ("q",), (size, size)),
        function(w, "k_G", "reduced k_G", reduced.project(w.gravity_forces), ("q",)),
        function(w, "row_forces", "reduced forces", reduced.project(forces), STATE),
    ]
    if elastic(w.scene):
        rows.append(function(w, "k_E", "reduced k_E", reduced.project(w.elastic.forces), ("q",)))
    if any(not force.is_zero for force in w.Q):
        rows.append(function(w, ACTING, "reduced forces beside drives", reduced.project(w.Q), ("q", "qd")))
    return [*(one for one in rows if one.entries), *_fitting(w, tied), *_driving(w, forces)]


def _velocity_coefficients(w: Workspace) -> tuple[list[Expr], list[Expr]]:
    """Return k_C*, shape (independent, pairs), and k_D*, shape (independent, independent)."""
    reduced = w.loops.reduction
    n = range(len(reduced.independent))

    def b(*moving: int) -> list[Expr]:
        u = [w.graph.total(row[reduced.independent[j]] for j in moving if reduced.independent[j] in row) for row in T]
        s = substitute(reduced.s, dict(zip(w.state.qd, u, strict=True)))
        return reduced.project(w.velocity_forces(u, s))

    T = reduced.T
    alone = [b(j) for j in n]
    pairs = [(b(j, k), alone[j], alone[k]) for j, k in combinations(n, 2)]
    return [both[i] - one[i] - other[i] for i in n for both, one, other in pairs], [alone[j][i] for i in n for j in n]


def _fitting(w: Workspace, tied: Held) -> list[Function]:
    """Return what makes a state fit the loops and rows."""
    reduced, zero, rows = w.loops.reduction, w.graph.zero, w.loops.recursive
    rates = [w.graph.total(t * w.state.qd[i] for i, t in row.items()) for row in reduced.T]
    bent = reduced.expand([w.state.qdd[i] for i in reduced.independent])
    functions = [
        function(w, "fitted_velocities", "velocities that the loops allow", rates, ("q", "qd")),
        function(w, "fitted_accelerations", "accelerations that the loops allow", bent, STATE),
    ]
    G, residual = w.loops.G(rows), w.loops.residual(rows)
    if G:
        off = [w.graph.dot(row, w.state.qd) for row in G]
        nearest = [u + x for u, x in zip(w.state.qd, _least(G, off), strict=True)]
        functions.append(function(w, "nearest", "nearest velocities that the loops allow", nearest, ("q", "qd")))
    if tied.closing.blocks:
        step = _taken_back(G, tied, [-r for r in residual])
        steps = [step.get(k, zero) for k in range(w.state.n)]
        others = [k for k in range(w.state.n) if k not in tied.dependent]
        follow = _taken_back(G, tied, [-w.graph.total(row[k] * w.state.qd[k] for k in others) for row in G])
        carried = [follow.get(k, u) for k, u in enumerate(w.state.qd)]
        functions += [
            function(w, "constraint_residual", "residuals of the loops", residual, ("q",)),
            function(w, "shortest", "Newton's shortest step", _least(G, residual), ("q",)),
            function(w, "correction", "Newton's step of dependent coordinates", steps, ("q",)),
            function(w, "carried", "velocities that close the loops", carried, ("q", "qd")),
        ]
    return functions


def _taken_back(G: Sequence[Sequence[Expr]], tied: Held, b: Sequence[Expr]) -> dict[int, Expr]:
    """Return x with G x = b in the position-level rows, by velocity; the least one where more than one does."""
    x: dict[int, Expr] = {}
    for block in tied.closing.blocks:
        rest = [b[r] - b[r].graph.total(G[r][k] * x[k] for k in x) for r in block.rows]
        matrix = [[G[r][k] for k in block.velocities] for r in block.rows]
        square = len(block.rows) == len(block.velocities)
        found = block.solve(G, rest) if square else _least(matrix, [-one for one in rest])
        x |= dict(zip(block.velocities, found, strict=True))
    return x


def _least(G: Sequence[Sequence[Expr]], b: Sequence[Expr]) -> list[Expr]:
    """Return -G⁺ b, shape (nv,), for rows that are independent."""
    graph = b[0].graph
    square = [[graph.dot(one, other) for other in G] for one in G]
    found = solve(range(-1, len(G)), square, b)
    return [-graph.total(row[k] * x for row, x in zip(G, found, strict=True)) for k in range(len(G[0]))]


def _driving(w: Workspace, forces: list[Expr]) -> list[Function]:
    """Return inverse dynamics, at independent velocities where drives do not fit, and the multipliers."""
    decisions, reduced = w.loops.decisions, w.loops.reduction
    try:
        functions = [derive_one(w, "inverse_dynamics")]
    except DerivationError:
        alone = dict(zip(reduced.independent, reduced.project(forces), strict=True))
        entries = [alone.get(k, w.graph.zero) for k in range(w.state.n)]
        functions = [function(w, "inverse_dynamics", "forces at independent velocities", entries, STATE)]
    if decisions.independent_rows:
        excess = [force - tau for force, tau in zip(forces, w.state.tau, strict=True)]
        found = decisions.partition.solve_transposed(w.loops.G(w.loops.recursive), excess)
        functions.append(function(w, "multipliers", "what loops and rows exert", found, (*STATE, "tau")))
    return functions


def function(
    workspace: Workspace,
    name: str,
    text: str,
    entries: Sequence[Expr],
    takes: Sequence[str],
    shape: tuple[int, ...] | None = None,
) -> Function:
    """Return entries as a function of what it takes, of time too where they depend on it."""
    timed = any(node.op is Op.SYMBOL and node.value == TIME for node in reachable(entries))
    given = arguments(workspace, (*takes, *((TIME,) if timed else ())))
    return Function(name, text, given, name, (len(entries),) if shape is None else shape, tuple(entries), "", name)


RATES = {"rad": (8.0, 20.0), "m": (3.0, 10.0)}  # largest velocity and acceleration of a slider
UNITS = {
    "rad": ("rad", "rad/s", "rad/s^2", "N\u202fm"),
    "m": ("m", "m/s", "m/s^2", "N"),
    "1": ("", "1/s", "1/s^2", ""),
}
TURNS = (("roll", math.pi), ("pitch", math.pi / 2), ("yaw", math.pi))

Row = dict[str, Any]


def controls(
    scene: Scene, begun: Start, extent: float, tied: Held | None, led: Sequence[int] = ()
) -> list[dict[str, Any]]:
    """Return groups of rows: time where motions are prescribed, positions, velocities, accelerations and parameters.

    A row is a slider (label, unit, range, value), a number that follows (without a range), or a heading of rows. Slides
    go as far as the extent, m; `led` are velocities with a prescribed motion.
    """
    symbols, values, t = latex_symbols(scene), begun.parameters, begun.t
    groups: list[dict[str, Any]] = []
    if led:
        fastest = max(abs(begun.qd[k]) for k in led)
        last = max(t, min(60.0, max(2.0, 4 * math.pi / fastest)) if fastest else 10.0)
        groups.append({"key": "t", "rows": [_row("t", 0, "t", "t", scene.shown_unit("s"), (0.0, last), t)]})
    groups.append({"key": "q", "rows": _positions(scene, symbols, begun, extent, tied, led)})
    accelerations = [acceleration_name(v) for v in scene.velocities]
    for k, key, names, at in ((1, "qd", scene.velocities, begun.qd), (2, "qdd", accelerations, begun.qdd)):
        rows = []
        for i, (name, unit) in enumerate(zip(names, SceneUnits(scene).velocities, strict=True)):
            largest = max(RATES[unit][k - 1], 1.5 * abs(at[i]))
            free = i not in led and (tied is None or i in tied.velocities)
            span = (-largest, largest) if free else None
            rows.append(_row(key, i, name, symbols[name], scene.shown_unit(UNITS[unit][k]), span, at[i], led=i in led))
        groups.append({"key": key, "rows": rows})
    if scene.parameters:
        told = SceneUnits(scene).inferred
        rows = [
            _row("params", k, p.name, symbols[p.name], told[p.name], _range(p, values[p.name]), values[p.name], p.text)
            for k, p in enumerate(scene.parameters)
        ]
        groups.append({"key": "params", "rows": rows})
    return groups


def _positions(
    scene: Scene, symbols: Mapping[str, str], begun: Start, extent: float, tied: Held | None, led: Sequence[int]
) -> list[Row]:
    rows: list[Row] = []
    first, turned, units = 0, 0, SceneUnits(scene).coordinates
    wide = {"rad": math.pi, "m": extent, "1": 1.0}
    for joint in scene.moving:
        ball = JOINTS[joint.type].quaternion(joint)
        prescribed = joint.rates[0] in [scene.velocities[k] for k in led]
        for k, name in enumerate(joint.coordinates):
            unit = units[first + k]
            at, free = begun.q[first + k], not prescribed and (tied is None or first + k in tied.moved)
            if ball is not None and k >= ball and free:
                break
            span = _span(joint, wide[unit], at, begun.parameters) if free else None
            shown = scene.shown_unit(UNITS[unit][0])
            rows.append(_row("q", first + k, name, symbols[name], shown, span, at, led=prescribed))
        if ball is not None and (tied is None or first + ball in tied.moved):
            rows.append({"heading": in_html(joint.text or joint.name)})
            angles = roll_pitch_yaw(begun.q[first + ball : first + ball + 4])
            for k, ((word, size), angle) in enumerate(zip(TURNS, angles, strict=True)):
                one = _row("turn", turned + k, word, "", scene.shown_unit("rad"), (-size, size), angle)
                rows.append({**one, "word": word, "joint": in_html(joint.text or joint.name)})
            turned += 3
        first += len(joint.coordinates)
    return rows


def roll_pitch_yaw(e: list[float]) -> tuple[float, float, float]:
    """Return the angles of a unit quaternion (w, x, y, z), rad."""
    w, x, y, z = e
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    return roll, pitch, math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _row(
    group: str,
    k: int,
    name: str,
    latex: str,
    unit: str,
    span: tuple[float, float] | None,
    value: float,
    text: str = "",
    led: bool = False,
) -> Row:
    plain = Text.of_latex(latex).plain if latex else name
    row: Row = {
        "group": group,
        "k": k,
        "label": inline(latex) if latex else "",
        "spoken": in_html(f"{plain}, {text}" if text else plain),
        "text": in_html(text),
        "unit": re.sub(r"\^(\d)", r"<sup>\1</sup>", in_html(unit)),
        "value": value,
        "why": "led" if led else "follows",  # what stands in place of a slider
    }
    return row if span is None else {**row, "low": span[0], "high": span[1]}


def _span(joint: Joint, wide: float, at: float, values: Mapping[str, float]) -> tuple[float, float]:
    """Return the range of a coordinate: the joint's limits where it has them, else `wide` each way."""
    low, high = joint.range(values)
    return min(low if math.isfinite(low) else -wide, at), max(high if math.isfinite(high) else wide, at)


def _range(parameter: Parameter, value: float) -> tuple[float, float]:
    """Return the range of a parameter's slider: a tenth to three times its value where it must be positive."""
    if value == 0.0:
        return (0.1, 1.0) if parameter.positive else (-1.0, 1.0)
    return (value / 10, 3 * value) if parameter.positive else (-3 * abs(value), 3 * abs(value))


@dataclass(frozen=True)
class Start:
    """A state: q, shape (nq,), qd and qdd, shape (nv,), values of all parameters, and the time, s."""

    q: list[float]
    qd: list[float]
    qdd: list[float]
    parameters: dict[str, float]
    t: float


def start(scene: Scene) -> Start:
    """Return the state at which the scene's lesson shows numbers, with the velocities that the scene starts with.

    Of closed mechanisms that is D'Alembert's lesson. There is none for quaternions: closed ones begin at rest where the
    scene says nothing.
    """
    chosen, still = shown_state(scene), scene.is_constrained
    if still and not quaternions(scene):
        with suppress(SymdynError):  # too large for a lesson
            chosen, still = choose_motion(Balance(scene, "en")), False
    led = any(joint.motion is not None for joint in scene.joints)
    declared = any(joint.start_rates for joint in scene.joints)
    if still or (declared and not led and not scene.is_constrained):
        rates = dict(zip(scene.velocities, starting_rates(scene, chosen.parameters), strict=True))
        chosen = undriven(
            scene, chosen.with_values({x: rates[str(x.value)] for x in chosen.values if str(x.value) in rates})
        )
    numbers = {str(symbol.value): value for symbol, value in chosen.values.items()}
    accelerations = [numbers.get(acceleration_name(u), 0.0) for u in scene.velocities]
    return Start(
        list(chosen.q),
        [numbers.get(u, 0.0) for u in scene.velocities],
        accelerations,
        dict(chosen.parameters),
        numbers[TIME] if led else 0.0,
    )

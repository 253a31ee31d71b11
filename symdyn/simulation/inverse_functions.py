"""Functions of a given motion, compiled: inverse dynamics, rows and Jacobians that coordinates follow, and their rates.

A mechanism without rows has no functions of them; what asks gets arrays without entries.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.dynamics import Function, Workspace, derive_one
from symdyn.dynamics.mechanism import TIME, State
from symdyn.dynamics.outputs import arguments
from symdyn.graph import Expr, Graph, tangents
from symdyn.program import identifier
from symdyn.scene import Scene
from symdyn.simulation.equations.compiled_routines import (
    Calls,
    Compiled,
    Opened,
    compiled,
    compiled_once,
    function_of,
    opened,
    plain,
    points,
)
from symdyn.simulation.equations.monitors import limits_of
from symdyn.simulation.equations.written import written_decisions
from symdyn.simulation.prescribed.point_path import ScenePath


class InverseFunctions:
    """Compiled functions of positions, velocities and accelerations.

    Attributes:
        follows: whether there are rows or paths that coordinates follow; loops whose rows are all redundant have none.
        limits: of joints, in the order of the entries of "limits".
        lifts: what is said where a rope lifts off a wheel, in the order of the entries of "lifts".
        holding: of the rows of loops and contacts, whether each holds a position.
        holds: whether rows or paths do.
    """

    def __init__(self, scene: Scene, path: ScenePath) -> None:
        found, names = opened(scene), tuple(one.name for one in path.points)
        key = (found.scene, written_decisions(scene), names)
        self._open, self._names, self._key = found, names, key
        self._made = compiled_once(("inverse", *key), lambda: _compiled(found, names))
        self._calls = self._made.at(found.values)
        functions = {routine.function.name: routine.function for routine in self._made.program.routines}
        closed = "constraint_jacobian" in functions
        residuals = functions["constraint_residual"].entries if closed else ()
        self.limits = limits_of(found.scene, graph := Graph(), State.of(found.scene, graph).tau)
        self.lifts = [told for _, told in Workspace(found.scene, found.closing).loops.lifts] if scene.ropes else []
        self.holding = np.array([not x.is_zero for x in residuals], dtype=bool)
        self.follows, self.holds = closed or bool(names), bool(self.holding.any()) or bool(names)
        self._lacking = (
            {}
            if closed
            else {"constraint_residual": (0,), "constraint_bias": (0,)}
            | {"constraint_jacobian": (0, len(scene.velocities))}
        )

    def __call__(
        self,
        name: str,
        t: Any,
        q: Array,
        u: Array,
        a: Array | None = None,
        tau: Array | None = None,
        inputs: Array | None = None,
        states: Array | None = None,
    ) -> Array:
        """Return a function's values, one a row."""
        if name in self._lacking:
            return np.zeros((*q.shape[:-1], *self._lacking[name]))
        return _called(self._made, self._calls, name, t, q, u, a, tau, inputs, states)

    def off_wheels(self, t: Array, q: Array, u: Array) -> npt.NDArray[np.bool_]:
        """Tell of every row which ropes are off a wheel that they pass, in the order of `lifts`."""
        return (self("lifts", t, q, u) if self.lifts else np.ones((len(q), 0))) <= 0

    def rates(self, q: Array, u: Array) -> dict[str, Array]:
        """Return the rates of kinematics, rows and Jacobians by name."""
        made = compiled_once(("rates", *self._key), lambda: _compiled_rates(self._open, self._names))
        calls = made.at(self._open.values)
        known = {routine.function.name for routine in made.program.routines}
        n = len(self._open.scene.velocities)
        names = ("kinematics", "constraint_jacobian", *(f"jacobian:{name}" for name in self._names))
        found = {name: _called(made, calls, name, 0.0, q, u) for name in names if identifier(name) in known}
        return {"constraint_jacobian": np.zeros((0, n))} | found


def _called(
    made: Compiled,
    calls: Calls,
    name: str,
    t: Any,
    q: Array,
    u: Array,
    a: Array | None = None,
    tau: Array | None = None,
    inputs: Array | None = None,
    states: Array | None = None,
) -> Array:
    name, known = identifier(name), {"q": q, "qd": u, "qdd": a, "tau": tau, TIME: t}
    known |= {"inputs": inputs, "internal": states}
    with np.errstate(all="ignore"):  # where there is no force, the rows end, and words say so
        found = np.asarray(calls[name](*(known[one] for one in made.takes(name))), dtype=np.float64)
    return np.broadcast_to(found, (*q.shape[:-1], *made.program[name].function.shape))


def _compiled(scene: Opened, points_on_paths: Sequence[str]) -> Compiled:
    w = Workspace(scene.scene, scene.closing)
    names = ["inverse_dynamics"]
    if w.scene.is_constrained:
        names += ["constraint_residual", "constraint_jacobian", "constraint_bias"]
    names += [f"{kind}:{name}" for name in points_on_paths for kind in ("pose", "jacobian", "jdot_qdot")]
    functions = [derive_one(w, name) for name in names]
    turned = tangents(w.state.rates, w.state.velocity)  # Ḣ u
    limits = [one.beyond for one in limits_of(w.scene, w.graph, w.state.tau)]
    functions += [points(w), _kinematics(w), _of_motion(w, "turning", turned)]
    functions += [_of_motion(w, "limits", limits, "tau")] if limits else []
    lifts = [formula for formula, _ in w.loops.lifts]
    functions += [function_of(w, "lifts", lifts, ("q",))] if lifts else []
    return compiled(w.scene, w.graph, functions)


def _of_motion(w: Workspace, name: str, entries: Sequence[Expr], *more: str) -> Function:
    """Return entries as a function of q and qd, and of what it takes more; states have no part in them."""
    return plain(name, entries, arguments(w, ("q", "qd", *more)))


def _kinematics(w: Workspace) -> Function:
    columns = [tangents(w.state.rates, {u: w.graph.one}) for u in w.state.qd]
    H = [column[k] for k in range(len(w.state.q)) for column in columns]
    return replace(_of_motion(w, "kinematics", H), shape=(len(w.state.q), w.state.n))


def _compiled_rates(scene: Opened, points_on_paths: Sequence[str]) -> Compiled:
    w = Workspace(scene.scene, scene.closing)
    names = ["constraint_jacobian"] if w.scene.is_constrained else []
    names += [f"jacobian:{name}" for name in points_on_paths]
    functions = [_kinematics(w), *(derive_one(w, name) for name in names)]
    moved = [
        replace(_of_motion(w, one.name, tangents(one.entries, w.state.velocity)), shape=one.shape) for one in functions
    ]
    return compiled(w.scene, w.graph, moved)

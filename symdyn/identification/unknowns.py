"""What data may tell of a scene: the parameters that its forces are linear in, and how base parameters come of them.

    beta = map · pi                 pi: ten of every body about its frame, armatures, friction, stiffness, ... (linear
                                    parameters); beta: base parameters, what motion can tell of pi
    S · pi >= 0                     what no body or joint can have below zero: armature, damping, dry friction

The pseudo-inertia of a body is [[J, h], [h, m]], J = tr(I)/2 · 1 - I its second moments about the frame, h = m r.

Reference: Gautier and Khalil (1990); Wensing, Kim and Slotine (2018).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs import BaseColumns, Linear
from symdyn.errors import SceneError
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute
from symdyn.scene import INERTIAL, Quantity, Scene
from symdyn.scene.forces import FORCES

TEN = len(INERTIAL)


@dataclass(frozen=True)
class Unknowns:
    """The linear parameters of a scene, with their values there.

    Attributes:
        scene: whose they are.
        opened: the same scene with these parameters as symbols; everything else as it was.
        names: of the parameters, as columns of `regressor`; ten a body, then what acts.
        values: as the scene declares them, shape (p,); kg, kg m, kg m^2 and the units of what acts.
        base: names of the base parameters, as columns of `base_regressor`.
        map: shape (b, p): base parameters are map · values.
        signs: shape (s, p): signs · values is not negative in any real mechanism.
        signed: what each of these rows is, such as "damping of shoulder".
    """

    scene: Scene
    opened: Scene
    names: tuple[str, ...]
    values: Array
    base: tuple[str, ...]
    map: Array
    signs: Array
    signed: tuple[str, ...]

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, whose ten come first, in this order."""
        return tuple(body.name for body in self.scene.bodies)

    def ten(self, values: Array) -> Array:
        """Return the ten of every body out of values of all parameters, shape (bodies, 10)."""
        found: Array = values[: TEN * len(self.scene.bodies)].reshape(-1, TEN)
        return found

    def inertias(self, values: Array) -> list[tuple[float, Array, Array, Array]]:
        """Return mass, centre of mass, principal moments and spread of every body, as of `ten_of_body`."""
        return [ten_of_body(ten) for ten in self.ten(values)]


def unknowns(scene: Scene, unbound: Collection[str] = ()) -> Unknowns:
    """Return the linear parameters of a scene whose numbers are known.

    Args:
        scene: the mechanism.
        unbound: parameters that are unknowns although they are zero; what is zero drops out of a derivation else.

    Raises:
        SceneError: parameters without a value, on which masses, inertias or places depend.
    """
    free = [parameter.name for parameter in scene.free_parameters]
    if free:
        told = ", ".join(free)
        raise SceneError(f"{scene.source or scene.name}: {told}: without a value; give each one, such as {free[0]}=1")
    w = Workspace(without_values(scene, unbound))
    found, base = Linear.of(w), BaseColumns.of(w)
    there = found.workspace
    graph = there.graph
    columns = [graph.symbol(name) for name in found.columns]
    rows = [gradient(one, columns) for one in substitute(base.of_columns(), found.known)]
    signed, signs = _signs(there, columns)
    values = _numbers(found.declared, there, scene)
    return Unknowns(
        scene,
        there.scene,
        found.columns,
        np.array(values),
        base.names,
        np.array([_numbers(row, there, scene) for row in rows]).reshape(-1, len(columns)),
        np.array(signs).reshape(-1, len(columns)),
        signed,
    )


def without_values(scene: Scene, names: Collection[str]) -> Scene:
    """Return the scene with some parameters left open."""
    return replace(scene, parameters=tuple(replace(p, value=None) if p.name in names else p for p in scene.parameters))


def _signs(w: Workspace, columns: list[Expr]) -> tuple[tuple[str, ...], list[list[float]]]:
    """Return what is never negative, as rows that the parameters are multiplied by; what is not linear has none."""
    told, rows = list[str](), list[list[float]]()
    for what, quantity in never_negative(w.scene):
        slopes = gradient(quantity.express(w.graph), columns)
        if any(not slope.is_zero for slope in slopes) and not {*reachable(slopes)} & {*columns}:
            told.append(what)
            rows.append(_numbers(slopes, w))
    return tuple(told), rows


def never_negative(scene: Scene) -> list[tuple[str, Quantity]]:
    """Return what no joint can have below zero, each with its name: armature, damping, dry friction."""
    found = list[tuple[str, Quantity]]()
    for joint in scene.joints:
        found += [(f"armature of {joint.name}", joint.armature), (f"damping of {joint.name}", joint.damping)]
        if joint.dry is not None:
            known = {key: x for part in FORCES[joint.dry.kind].parts for key, x, _ in part.numbers(joint.dry)}
            found += [(f"{key} friction of {joint.name}", known[key]) for key in ("coulomb", "static") if key in known]
    return found


def _numbers(entries: Sequence[Expr], w: Workspace, scene: Scene | None = None) -> list[float]:
    """Return the values of formulas, with what the scene says of its parameters."""
    known = {p.name: p.value for one in (w.scene, scene or w.scene) for p in one.parameters if p.value is not None}
    values = {
        w.graph.symbol(name): evaluate([value.express(w.graph)], Floats(), {})[0] for name, value in known.items()
    }
    return [float(x) for x in evaluate(list(entries), Floats(), values)]


def ten_of_body(ten: Array) -> tuple[float, Array, Array, Array]:
    """Return mass, kg, centre of mass, m, principal moments about it, kg m^2, and the spread of its mass, m^2.

    Args:
        ten: m, m r, I about the body frame, shape (10,).

    Returns:
        The spread is the covariance of places of mass, shape (3, 3); where there is no mass, what is over it is NaN.
    """
    m, xx, yy, zz, xy, xz, yz = (float(ten[k]) for k in (0, 4, 5, 6, 7, 8, 9))
    h = np.asarray(ten[1:4], dtype=float)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if m == 0:
        none = np.full((3, 3), np.nan)
        return m, none[0], np.linalg.eigvalsh(inertia), none
    central = inertia - (h @ h * np.eye(3) - np.outer(h, h)) / m
    spread = (np.trace(central) / 2 * np.eye(3) - central) / m
    return m, h / m, np.linalg.eigvalsh(central), spread

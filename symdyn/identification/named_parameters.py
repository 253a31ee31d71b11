"""Values of a scene's own parameters, m1 or l2c, that give the estimated base parameters.

    minimise    (beta(theta) - e)^T Sigma^-1 (beta(theta) - e)

beta are formulas of the parameters, not always linear ones (m1 h1^2). Parameters of the geometry are no unknowns: the
regressor was made with their values. Those that data do not tell stay where they were, by a prior a thousand times
their size; those that data do not tell apart become, of all values that give the estimates, the nearest.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs import BaseColumns
from symdyn.graph import Expr, Op, evaluate, gradient, reachable
from symdyn.identification.by_name import places_of
from symdyn.identification.unknowns import never_negative, without_values
from symdyn.scene import Quantity, Scene

WEAK = 1e-3
"""One over the standard deviation of the prior, in sizes of a parameter."""

UNTOLD = 1e-3
"""Share in directions that the prior decides and not the data, from which on a parameter is not told by itself."""

AT_LIMIT = 1e-9
"""In sizes of a parameter that cannot be negative: below it is zero."""


@dataclass(frozen=True)
class Named:
    """Values of parameters that have names in the scene.

    Attributes:
        names: of the parameters that were unknown, shape (k,).
        before: their values in the scene, NaN where it has none, shape (k,).
        values: as found, shape (k,).
        errors: standard errors, shape (k,); NaN for what data do not tell by itself.
        distance: of the estimates from what these parameters can give, in standard errors (Mahalanobis).
        spare: how many more combinations were estimated than there are parameters told: distance^2 is about this if
            the scene is built as it says.
        fixed: names of parameters of geometry and gravity, which keep their values.
    """

    names: tuple[str, ...]
    before: Array
    values: Array
    errors: Array
    distance: float
    spare: int
    fixed: tuple[str, ...]


def inertial_names(scene: Scene) -> tuple[str, ...]:
    """Return the parameters that bodies are made of, and nothing of the geometry is."""
    places = {name for one in Quantity.inside(_geometry(scene)) for name in one.symbols}
    used = {name for one in Quantity.inside(scene.bodies) for name in one.symbols}
    return tuple(p.name for p in scene.parameters if p.name in used and p.name not in places)


def fit_names(
    scene: Scene,
    base: Sequence[str],
    combinations: Array,
    estimate: Array,
    covariance: Array,
    unbound: Collection[str] = (),
) -> Named:
    """Return values of the scene's parameters, by least squares in the metric of the covariance.

    Args:
        scene: the mechanism; parameters of its geometry have values.
        base: names of the base parameters, shape (b,).
        combinations: C, shape (k, b): estimated were C · base parameters.
        estimate: shape (k,).
        covariance: shape (k, k).
        unbound: parameters that are unknowns although they are zero.
    """
    from scipy.optimize import least_squares

    told = BaseColumns.of(Workspace(without_values(scene, unbound))).named()
    beta = [told[k][1] for k in places_of(base, [name for name, _ in told])]
    graph = beta[0].graph
    places = {name for one in Quantity.inside(_geometry(scene)) for name in one.symbols}
    met = {str(node.value) for node in reachable(beta)}
    unknown = [p for p in scene.parameters if p.name in met and p.name not in places]
    fixed = [p for p in scene.parameters if p.name not in {one.name for one in unknown}]
    known = {graph.symbol(p.name): _number(p.value) for p in fixed if p.value is not None}
    before = np.array([np.nan if p.value is None else _number(p.value) for p in unknown])
    start = np.where(np.isnan(before), 1.0, before)
    size = np.where(np.abs(start) > 0, np.abs(start), 1.0)
    symbols = [graph.symbol(p.name) for p in unknown]
    slopes = [one for row in (gradient(entry, symbols) for entry in beta) for one in row]
    orders = reachable(beta), reachable(slopes)

    def at(theta: Array, entries: Sequence[Expr], order: Sequence[Expr]) -> Array:
        values = {**known, **dict(zip(symbols, map(float, theta), strict=True))}
        return np.array(evaluate(entries, Floats(), values, order=order))

    least = 1e-9 * np.maximum(np.abs(estimate), 1e-3 * float(np.abs(estimate).max(initial=1e-12)))
    weigh = np.linalg.solve(np.linalg.cholesky(covariance + np.diag(least**2)), np.eye(len(estimate)))

    def off(theta: Array) -> Array:
        data = weigh @ (combinations @ at(theta, beta, orders[0]) - estimate)
        return np.concatenate([data, WEAK * (theta - start) / size])

    def slope(theta: Array) -> Array:
        rows = at(theta, slopes, orders[1]).reshape(len(beta), len(symbols))
        return np.vstack([weigh @ combinations @ rows, WEAK * np.diag(1 / size)])

    bounded = {str(quantity.value) for _, quantity in never_negative(scene) if quantity.op is Op.SYMBOL}
    low = np.array([0.0 if p.positive or p.name in bounded else -np.inf for p in unknown])
    begin = np.where(np.isfinite(low), np.maximum(start, 1e-9 * size), start)
    found = least_squares(off, begin, slope, bounds=(low, np.inf), x_scale=size, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    rows = slope(found.x)
    covered = np.linalg.inv(rows.T @ rows)
    errors = np.sqrt(np.diag(covered))
    _, told_by, Vt = np.linalg.svd(rows[: len(estimate)] * size)
    known_by_data = int(np.sum(told_by > WEAK))
    errors[np.linalg.norm(Vt[known_by_data:], axis=0) > UNTOLD] = np.nan
    distance = float(np.linalg.norm(off(found.x)[: len(estimate)]))
    felt = np.linalg.norm(rows[: len(estimate)] * size, axis=0) > WEAK
    values = np.where(felt, found.x, start)
    values = np.where(np.isfinite(low) & (values < AT_LIMIT * size), 0.0, values)
    return Named(
        tuple(p.name for p in unknown), before, values, errors, distance, len(estimate) - known_by_data,
        tuple(p.name for p in fixed),
    )  # fmt: skip


def _number(value: Quantity) -> float:
    return float(value.at({}) or 0)


def _geometry(scene: Scene) -> Scene:
    """Return the scene without what acts and what is heavy."""
    joints = tuple(
        replace(joint, armature=Quantity.ZERO, damping=Quantity.ZERO, friction=Quantity.ZERO, dry=None, forces=())
        for joint in scene.joints
    )
    return replace(scene, bodies=(), elements=(), joints=joints, parameters=(), outputs=())

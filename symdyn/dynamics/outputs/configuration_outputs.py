"""Outputs that add displacements to positions and take them apart: rows of OUTPUTS.

    q ⊕ d    positions after unit time at the velocities d, each joint's kept in its own axes; q + d where velocities
             are rates of coordinates, on the group of rotations or of placements where there is a quaternion
    q' ⊖ q   the smallest displacement with q ⊕ d = q'; of a quaternion that of e' or -e', at most half a turn
    v, ω     parts of d, in the moved frame; θ² = ω·ω

    e'       e ∘ (cos θ/2, S ω)                          S = sin(θ/2)/θ
    p'       p + R (v + 2 S² ω × v + A ω × (ω × v))      A = (θ - sin θ)/θ³
    c, n     scalar and vector of ē ∘ e', s² = n·n
    ω        F n                                         F = 2 atan(s/c)/s
    v        x - ω × x/2 + B ω × (ω × x)                 B = (1 - F c/2)/θ², x = Rᵀ (p' - p)

S, A, F and B are analytic: near zero they are taken from their series, so that derivatives of any order hold there.

*Quaternions* are multiplied, or what they need is read from the rates of coordinates, q̇ = H u: e ∘ (0, ω) = 2 H ω, and
the vector of ē ∘ e' is 2 Hᵀ e'. J are derivatives along the velocities, of q ⊕ d along those of the result.

Reference: Solà, Deray and Atchuthan, A micro Lie theory for state estimation in robotics (2018), appendices B and D.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from itertools import islice

from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.contact_outputs import where
from symdyn.dynamics.outputs.named_functions import STEP, TO, direction
from symdyn.dynamics.outputs.output import Formulation, Output
from symdyn.dynamics.outputs.tangent_space import COLUMNS, SWEEPS
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr, Graph, Op, substitute
from symdyn.scene.joints import JOINTS
from symdyn.spatial import Mat, Vec, add, cross, dot, scale, sub

NEAR = Fraction(1, 16), Fraction(1, 64)
"""θ² up to which S and A are series, and s²/c² up to which F and B are: the first term left out is below 1e-17."""

COS = tuple(Fraction((-1) ** k, f) for k, f in enumerate((1, 8, 384, 46_080, 10_321_920, 3_715_891_200)))
SIN = tuple(Fraction((-1) ** k, f) for k, f in enumerate((2, 48, 3_840, 645_120, 185_794_560, 81_749_606_400)))
REST = tuple(Fraction((-1) ** k, f) for k, f in enumerate((6, 120, 5_040, 362_880, 39_916_800, 6_227_020_800)))
ATAN = tuple(Fraction((-1) ** k * 2, 2 * k + 1) for k in range(9))
BACK = (*(Fraction(1, f) for f in (12, 720, 30_240, 1_209_600, 47_900_160)), Fraction(691, 1_307_674_368_000))
"""Coefficients of cos(√x/2), S, A and B of x = θ²; of c F of s²/c²."""


def _series(x: Expr, coefficients: Sequence[Fraction]) -> Expr:
    total = x.graph.zero
    for one in reversed(coefficients):
        total = total * x + x.graph.constant(one)
    return total


def _half(square: Expr) -> tuple[Expr, Expr, Expr]:
    """Return cos θ/2, S and A of θ²."""
    graph, far = square.graph, square - square.graph.constant(NEAR[0])
    x = where(far, square, graph.one)  # a root has no slope at zero
    theta = graph.sqrt(x)
    s, c = graph.sin(theta / 2) / theta, graph.cos(theta / 2)
    ways = (c, COS), (s, SIN), ((1 - 2 * s * c) / x, REST)
    c, s, a = (where(far, closed, _series(square, near)) for closed, near in ways)
    return c, s, a


def _back(c: Expr, n: Vec) -> tuple[Expr, Callable[[Vec], Expr]]:
    """Return F, and B of ω."""
    graph, square = c.graph, dot(n, n)
    far = square - graph.constant(NEAR[1]) * c * c
    x, near = where(far, square, graph.one), where(far, graph.one, c)
    s = graph.sqrt(x)
    angle = graph.function(Op.ATAN2, 2 * s * c, c * c - x)  # 2 atan(s/c), where c is zero, too
    F = where(far, angle / s, _series(square / (near * near), ATAN) / near)

    def B(omega: Vec) -> Expr:
        theta = dot(omega, omega)
        return where(far, (1 - F * c / 2) / where(far, theta, graph.one), _series(theta, BACK))

    return F, B


def _moved(v: Vec, omega: Vec, once: Expr, twice: Expr) -> Vec:
    """Return v + once ω × v + twice ω × (ω × v)."""
    across = cross(omega, v)
    return add(v, add(scale(once, across), scale(twice, cross(omega, across))))


def _parts(w: Workspace) -> Iterator[tuple[list[int], list[int], bool]]:
    """Yield the numbers of coordinates and of velocities of every part, and whether it has a quaternion."""
    q, u = iter(range(len(w.state.q))), iter(range(w.state.n))
    for joint in w.scene.moving:
        for block in JOINTS[joint.type].blocks(joint):
            yield list(islice(q, len(block.coordinates))), list(islice(u, len(block.velocities))), bool(block.letters)


def _three(of: Sequence[Expr], at: Sequence[int]) -> Vec:
    x, y, z = (of[k] for k in at)
    return (x, y, z)


Rates = Callable[[Sequence[int], Sequence[int], Vec], list[Expr]]
"""Rates of coordinates, for three of the velocities."""


def _by_products(w: Workspace) -> tuple[Rates, Rates]:
    def turned(at: Sequence[int], _: Sequence[int], omega: Vec) -> list[Expr]:
        e, n = w.state.q[at[0]], _three(w.state.q, at[1:])
        return [-dot(n, omega) / 2, *scale(w.graph.one / 2, add(scale(e, omega), cross(n, omega)))]

    def slid(at: Sequence[int], _: Sequence[int], v: Vec) -> list[Expr]:
        return list(Mat.of_quaternion(tuple(w.state.q[k] for k in at[-4:])) @ v)

    return turned, slid


def _by_rates(w: Workspace) -> tuple[Rates, Rates]:
    def rates(at: Sequence[int], velocities: Sequence[int], of: Vec) -> list[Expr]:
        graph, along = w.graph, w.directions.along
        pairs = list(zip(velocities, of, strict=True))
        return [graph.total(x * along[k][w.state.q[c]] for k, x in pairs if w.state.q[c] in along[k]) for c in at]

    return rates, lambda at, velocities, v: rates(at[:3], velocities, v)


WAYS = {"quaternions": _by_products, "rates": _by_rates}


def _integrate(w: Workspace, way: str) -> list[Expr]:
    """Return q ⊕ d, shape (nq,)."""
    q, d, (turned, slid) = w.state.q, direction(w.graph, STEP, w.state.n), WAYS[way](w)
    found: list[Expr] = []
    for at, along, turns in _parts(w):
        if not turns:
            found += [q[k] + d[j] for k, j in zip(at, along, strict=True)]
            continue
        omega = _three(d, along[-3:])
        c, s, a = _half(dot(omega, omega))
        if len(along) == 6:
            way_gone = _moved(_three(d, along[:3]), omega, 2 * s * s, a)
            found += [q[k] + x for k, x in zip(at, slid(at, along[:3], way_gone), strict=False)]
        rates = turned(at[-4:], along[-3:], omega)
        found += [c * q[k] + 2 * s * x for k, x in zip(at[-4:], rates, strict=True)]
    return found


def _transposed(rates: Rates, graph: Graph, at: Sequence[int], along: Sequence[int], x: Sequence[Expr]) -> Vec:
    """Return Hᵀ x for three of the velocities."""
    columns = (rates(at, along, unit) for unit in Mat.identity(graph))
    a, b, c = (graph.dot(column, x) for column in columns)
    return (a, b, c)


def _difference(w: Workspace, way: str) -> list[Expr]:
    """Return q' ⊖ q, shape (nv,)."""
    q, graph, (turned, slid) = w.state.q, w.graph, WAYS[way](w)
    to = direction(graph, TO, len(q))
    found: list[Expr] = []
    for at, along, turns in _parts(w):
        if not turns:
            found += [to[k] - q[k] for k in at]
            continue
        e = at[-4:]
        c = graph.total(q[k] * to[k] for k in e)
        n = scale(graph.constant(2), _transposed(turned, graph, e, along[-3:], [to[k] for k in e]))
        F, B = _back(c, n)
        omega = scale(F, n)
        if len(along) == 6:
            apart = sub(_three(to, at[:3]), _three(q, at[:3]))
            x = _transposed(slid, graph, at, along[:3], apart)
            found += _moved(x, omega, graph.constant(Fraction(-1, 2)), B(omega))
        found += omega
    return found


# Derivatives


def _integrate_jacobian(sweep: str, w: Workspace) -> list[Expr]:
    """Return [∂/∂q | ∂/∂d] of q ⊕ d row by row, shape (nv, 2 nv): rates of coordinates there, as velocities."""
    graph, found = w.graph, w.once(_integrate, "quaternions")
    seeds = [*w.directions.along, *({one: graph.one} for one in direction(graph, STEP, w.state.n))]
    flat, width = SWEEPS[sweep](found, seeds), len(seeds)
    rates = [flat[k * width : (k + 1) * width] for k in range(len(found))]
    there = [substitute(list(way.values()), dict(zip(w.state.q, found, strict=True))) for way in w.directions.along]
    number = {q: k for k, q in enumerate(w.state.q)}
    entries: list[Expr] = []
    for way, values in zip(w.directions.along, there, strict=True):
        square = 4 if len(way) == 4 else 1  # |H ω|² = ω²/4 of a quaternion, the columns of all else are of length one
        pairs = [(number[q], h * square) for q, h in zip(way, values, strict=True)]
        entries += [graph.total(h * rates[k][j] for k, h in pairs) for j in range(width)]
    return entries


def _difference_jacobian(sweep: str, w: Workspace) -> list[Expr]:
    """Return [∂/∂q | ∂/∂q'] of q' ⊖ q row by row, shape (nv, 2 nv)."""
    ways, q = w.directions.along, w.state.q
    put = dict(zip(q, direction(w.graph, TO, len(q)), strict=True))
    there = [dict(zip((put[x] for x in way), substitute(list(way.values()), put), strict=True)) for way in ways]
    return SWEEPS[sweep](w.once(_difference, "quaternions"), [*ways, *there])


def _neutral(w: Workspace) -> list[Expr]:
    firsts = {group[0] for group in w.state.spheres}
    return [w.graph.one if q in firsts else w.graph.zero for q in w.state.q]


_row = partial(Output, when_constrained="same", default_in="request")
_DISPLACED = "rad or m; v and w of quaternions along the moved axes"


def _both(derive: Callable[[Workspace, str], list[Expr]]) -> dict[str, Formulation]:
    return {way: Formulation(lambda w, way=way: derive(w, way)) for way in WAYS}


def _swept(derive: Callable[[str, Workspace], list[Expr]]) -> dict[str, Formulation]:
    return {sweep: Formulation(partial(derive, sweep)) for sweep in SWEEPS}


def _square(second: str) -> tuple[labels.Axis, labels.Axis]:
    columns = COLUMNS["q"]
    return labels.velocities, lambda w: (*columns(w), *(f"{second} {name}" for name in columns(w)))


CONFIGURATIONS: dict[str, Output] = {
    "neutral": _row(
        "neutral positions: zeros, and quaternions without rotation",
        (), "q_0", (labels.coordinates,), "rad, m, or 1 for a quaternion",
        formulations={"joints": Formulation(_neutral)},
    ),
    "integrate": _row(
        "positions after unit time at the velocities step, each joint's kept in its own axes: q + step but for "
        "quaternions and positions of free joints, those along the exponential of the group",
        ("q", STEP), "q_new", (labels.coordinates,), "rad, m, or 1 for a quaternion",
        formulations=_both(_integrate),
    ),
    "difference": _row(
        "displacement along the velocities that takes q to q_to, by the logarithm of the group where there are "
        "quaternions, at most half a turn; q_to - q elsewhere",
        ("q", TO), "d", (labels.velocities,), _DISPLACED, formulations=_both(_difference),
    ),
    "integrate_jacobian": _row(
        "[displacement of the result of integrate by displacements of q | by step], all along the velocities",
        ("q", STEP), "J", _square("step"), f"1, or rad/m; {_DISPLACED}", formulations=_swept(_integrate_jacobian),
    ),
    "difference_jacobian": _row(
        "[derivatives of difference by displacements of q | of q_to], all along the velocities",
        ("q", TO), "J", _square("to"), f"1, or rad/m; {_DISPLACED}", formulations=_swept(_difference_jacobian),
    ),
}  # fmt: skip

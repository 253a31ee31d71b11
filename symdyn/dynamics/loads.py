"""What acts beside gravity and drives, by positions and their derivatives: springs, dampers, friction, loads.

    x, v    way of a spring from its free position or length, and rate of a joint or of a distance
    E       Σ preload x + k1 x²/2 + k2 x³/3 + …, the elastic energy, J
    Q_i     F·∂ṗ/∂u_i + C·∂ω/∂u_i, virtual work of force F at p and couple C; of a damper or dry friction F ∂v/∂u_i

This is the Lagrange road; `wrenches` finds the same forces along the tree. Both share the laws of force only.

Reference: the textbook, eq. (5.22), Q^A; Olsson et al., Friction models and friction compensation, European Journal of
Control 4 (1998), for Coulomb's and Stribeck's curve.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import comb

from symdyn.dynamics.positions import body_placements
from symdyn.dynamics.state import State, joint_position, state_symbols, vector
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, Op, gradient, tangents
from symdyn.scene import Damper, Friction, Joint, Load, Place, Scene, Spring, express
from symdyn.scene.quantity import ZERO
from symdyn.spatial import Transform, Vec, apply, dot, sub

# Laws of force


def tension(spring: Spring, way: Expr) -> Expr:
    """Return the force of a spring at a way x from `free`: preload + k1 x + k2 x² + …, N or N m."""
    graph = way.graph
    total, power = express(spring.preload, graph), way
    for k in spring.stiffness:
        total = total + express(k, graph) * power
        power = power * way
    return total


def pull(spring: Spring, square: Expr) -> Expr:
    """Return the force of a spring between two points over their distance, F / s, N/m.

    What does not pull where the points meet, as a spring of free length zero, is a polynomial there and has a value;
    what pulls has no direction. Points that never part pull at nothing.

    Args:
        spring: between points.
        square: s², m².
    """
    graph, terms = square.graph, _of_distance(spring, square.graph)
    if square.is_zero:
        return graph.zero
    s = graph.sqrt(square)
    if not terms[0].is_zero:
        return tension(spring, s - express(spring.free, graph)) / s
    return graph.total(c * _power(s, square, m) for m, c in enumerate(terms[1:]))


def stored_between(spring: Spring, square: Expr) -> Expr:
    """Return the energy of a spring between two points of squared distance s², J; zero where s is its free length."""
    graph, terms = square.graph, _of_distance(spring, square.graph)
    s, free = graph.sqrt(square), express(spring.free, graph)
    if not terms[0].is_zero:
        return stored(spring, s - free)
    ways = [c * _power(s, square, m) / m for m, c in enumerate(terms[1:], 2)]
    return graph.total([*ways, stored(spring, -free)])


def _of_distance(spring: Spring, graph: Graph) -> list[Expr]:
    """Return c with force = c_0 + c_1 s + c_2 s² + … in terms of the distance s."""
    known = [express(x, graph) for x in (spring.preload, *spring.stiffness)]
    free = express(spring.free, graph)
    terms = []
    for j in range(len(known)):
        power, total = graph.one, graph.zero
        for m in range(j, len(known)):
            total = total + known[m] * comb(m, j) * power
            power = -free * power
        terms.append(total)
    return terms


def _power(s: Expr, square: Expr, m: int) -> Expr:
    """Return s to the power m, by its square as far as that goes: a root has no slope at zero."""
    result = s.graph.one if m % 2 == 0 else s
    for _ in range(m // 2):
        result = result * square
    return result


def resistance(damper: Damper, rate: Expr) -> Expr:
    """Return the force of a damper against its rate v: c1 v + c3 v³ + …, N or N m."""
    graph, power = rate.graph, rate
    total = graph.zero
    for c in damper.damping:
        total = total + express(c, graph) * power
        power = power * rate * rate
    return total


def friction(dry: Friction, rate: Expr) -> Expr:
    """Return the dry friction against a rate v, N or N m; see `Friction`."""
    graph = rate.graph
    size = express(dry.coulomb, graph)
    if dry.static is not None:
        slow = rate / express(dry.stribeck, graph)
        size = size + (express(dry.static, graph) - size) * graph.function(Op.EXP, -(slow * slow))
    smoothing = express(dry.smoothing, graph)
    if smoothing.is_zero:
        return size * graph.function(Op.SIGN, rate)
    return size * graph.function(Op.TANH, rate / smoothing)


def joint_resistance(joint: Joint, rate: Expr) -> Expr:
    """Return viscous damping and dry friction of a joint against one of its rates, N or N m."""
    viscous = express(joint.damping, rate.graph) * rate
    return viscous if joint.dry is None else viscous + friction(joint.dry, rate)


def refuse_ideal_friction(scene: Scene) -> None:
    """Raise where friction cannot be integrated: with an ideal sign it has no value at rest.

    Raises:
        DerivationError: a joint has dry friction without smoothing.
    """
    ideal = [joint.name for joint in scene.joints if joint.dry is not None and joint.dry.smoothing == ZERO]
    if ideal:
        plural = "s" * (len(ideal) > 1)
        raise DerivationError(
            f"forward dynamics does not exist: dry friction in joint{plural} {', '.join(ideal)} is an ideal sign of "
            "the rate, and at rest it takes whatever value keeps the joint at rest, which no formula gives; write a "
            "smoothing (a rate well below those of interest) to have tanh(rate / smoothing), or ask for inverse "
            "dynamics, where the sign is enough"
        )


# Elastic energy


def elastic_energy(scene: Scene, graph: Graph) -> Expr:
    """Return E(q) of all springs, J; zero where each is at `free`."""
    placed = body_placements(scene, graph) if scene.springs else {}
    return graph.total(_stored(scene, placed, spring, graph) for spring in scene.springs)


def elastic_slopes(scene: Scene, graph: Graph, slopes: Callable[[Expr], list[Expr]]) -> list[Expr]:
    """Return X E, shape (nv,), for X that `slopes` applies: F X x at a joint, F/s X s² / 2 between points.

    s² has a slope where the points meet, and s has none.
    """
    placed = body_placements(scene, graph) if scene.springs else {}
    found = [graph.zero] * len(scene.velocities)
    for spring in scene.springs:
        if spring.ends:
            x = _square(placed, spring, graph)
            force = pull(spring, x) / 2
        else:
            x = joint_position(joint_of(scene, spring), graph) - express(spring.free, graph)
            force = tension(spring, x)
        found = [total + force * slope for total, slope in zip(found, slopes(x), strict=True)]
    return found


def _stored(scene: Scene, placed: dict[str, Transform], spring: Spring, graph: Graph) -> Expr:
    if spring.ends:
        return stored_between(spring, _square(placed, spring, graph))
    return stored(spring, joint_position(joint_of(scene, spring), graph) - express(spring.free, graph))


def stored(spring: Spring, way: Expr) -> Expr:
    """Return the energy of a spring at a way x from `free`: preload x + k1 x²/2 + k2 x³/3 + …, J."""
    graph = way.graph
    total, power = express(spring.preload, graph) * way, way * way
    for m, k in enumerate(spring.stiffness, 2):
        total = total + express(k, graph) * power / m
        power = power * way
    return total


def joint_of(scene: Scene, element: Spring | Damper) -> Joint:
    """Return the joint that a spring or damper acts at."""
    return next(joint for joint in scene.joints if joint.name == element.joint)


def _square(placed: dict[str, Transform], element: Spring | Damper, graph: Graph) -> Expr:
    """Return the squared distance of the ends, m²."""
    a, b = (_point(placed, end, graph) for end in element.ends)
    apart = sub(b, a)
    return dot(apart, apart)


def _point(placed: dict[str, Transform], place: Place, graph: Graph) -> Vec:
    return placed[place.body].point(vector(place.at, graph))


# Generalized forces


def generalized_forces(scene: Scene, graph: Graph) -> list[Expr]:
    """Return Q^A of (5.22), shape (nv,): everything but drives, gravity and springs; N m or N."""
    state = state_symbols(scene, graph)
    forces = joint_forces(scene, graph)
    placed = body_placements(scene, graph) if scene.dampers or scene.loads else {}
    for damper in scene.dampers:
        if damper.ends:
            (rate,) = tangents([graph.sqrt(_square(placed, damper, graph))], state.velocity)
            _oppose(forces, rate, resistance(damper, rate), state)
    for load in scene.loads:
        work = _work(load, placed[load.place.body], scene, graph)
        forces = [force + share for force, share in zip(forces, work, strict=True)]
    return forces


def joint_forces(scene: Scene, graph: Graph) -> list[Expr]:
    """Return the part of Q that acts at joints: declared forces, damping, friction, dampers; shape (nv,), N m or N."""
    state, forces = state_symbols(scene, graph), declared_forces(scene, graph)
    for joint in scene.joints:
        for rate in joint_rates(joint, graph):
            _oppose(forces, rate, joint_resistance(joint, rate), state)
    for damper in scene.dampers:
        for rate in joint_rates(joint_of(scene, damper), graph) if damper.joint else ():
            _oppose(forces, rate, resistance(damper, rate), state)
    return forces


def _oppose(forces: list[Expr], rate: Expr, force: Expr, state: State) -> None:
    """Let a force act against a rate."""
    for i, share in enumerate(gradient(rate, state.qd)):
        forces[i] = forces[i] - force * share


def declared_forces(scene: Scene, graph: Graph) -> list[Expr]:
    """Return the generalized forces that the joints declare, shape (nv,); N m or N."""
    return [express(force, graph) for joint in scene.joints for force in joint.forces or (ZERO,) * len(joint.rates)]


def joint_rates(joint: Joint, graph: Graph) -> list[Expr]:
    """Return the rates of a joint, by differentiating its position where it follows another one."""
    if joint.coupling is None:
        return [graph.symbol(name) for name in joint.rates]
    leader = joint.coupling.coordinate
    return tangents([joint_position(joint, graph)], {graph.symbol(leader): graph.symbol(f"{leader}_dot")})


def _work(load: Load, T: Transform, scene: Scene, graph: Graph) -> list[Expr]:
    """Return F·∂ṗ/∂u_i + C·∂ω/∂u_i for every velocity; F and C do no work of their own on the way."""
    force, couple = load_vectors(load, graph)
    if load.frame == "body":
        force, couple = apply(T.R, force), apply(T.R, couple)
    columns = placement_rates(Transform(T.R, T.point(vector(load.place.at, graph))), scene, graph)
    return [dot(force, p) + dot(couple, w) for p, w in columns]


def load_vectors(load: Load, graph: Graph) -> tuple[Vec, Vec]:
    """Return force and couple of a load along the axes of its frame, N and N m."""
    return vector(load.force, graph), vector(load.couple, graph)


def placement_rates(T: Transform, scene: Scene, graph: Graph) -> list[tuple[Vec, Vec]]:
    """Return (∂ṗ/∂u_i, ∂ω/∂u_i) of a placement for every velocity, ground frame, from ω̃ = Ṙ Rᵀ."""
    state = state_symbols(scene, graph)
    entries: Sequence[Expr] = (*T.p, *T.R[0], *T.R[1], *T.R[2])
    rates = tangents(entries, state.velocity)
    columns = []
    for u in state.qd:
        x = tangents(rates, {u: graph.one})
        rows = [x[3:6], x[6:9], x[9:12]]
        spin = [graph.total(a * b for a, b in zip(rows[i], T.R[j], strict=True)) for i, j in ((2, 1), (0, 2), (1, 0))]
        columns.append(((x[0], x[1], x[2]), (spin[0], spin[1], spin[2])))
    return columns

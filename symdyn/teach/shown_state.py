"""The state that a lesson shows in numbers: a place that hides nothing, and a motion that the scene allows.

At a right angle, at zero, or where two coordinates are equal, a wrong sign or a sine in place of a cosine goes unseen;
such coordinates are moved. A prescribed coordinate is where its formula has it, at the time that the lesson lists.

Letters of masses and lengths are drawn in the picture where they measure something.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product

import numpy as np

from symdyn.algebra import Batches, Floats
from symdyn.draw import Lettered, pose
from symdyn.dynamics import Energies, Workspace
from symdyn.dynamics.mechanism import TIME, State, body_placements, prescribed, vector
from symdyn.emit.print import latex_symbols
from symdyn.errors import DrawError, NoValueError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, evaluate, gradient, reachable
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.joints import joint_motion, start_of
from symdyn.scene.values import Pose
from symdyn.spatial import Transform, Vec, add, scale

RATES = (1.0, -0.6, 0.8, 0.5, -0.4, 0.3)
ACCELERATIONS = (0.5, 1.2, -0.7, 0.9, 0.4, -0.3)
ANGLES = (0.6, 0.5, 0.7, 0.4, 0.9, 0.3, 1.0, 0.2)  # rad: for turns that would hide something where they are
WAYS = (1.0, 1.3, 0.8, 1.5, 0.7)  # the same for slides: parts of where they are, or of 0.2 m
NEAR = 1e-6
FALL = 9.81  # m/s^2: for an acceleration of free fall without a value
SIZES = {"kg": 2.0, "m": 1.0}
"""What other parameters without a value start from; each takes another share of it, so that no two are alike."""
TURNS = [math.pi * x for x in (0, 0.5, 1, -0.5, 0.2, 0.7, -0.2, -0.7)]  # rad: where zeros are looked for
FAR = 100.0  # of the largest length: a slide that is looked at beside those where it is one
TIMES = np.array([0.0, *(10 ** (5 * k / 199 - 3) for k in range(200))])  # s
NOTHING = 1e-13  # of the largest value at a time: what is one
MOMENTS = (0.4, 0.2, 0.1, 0.0)
"""s: times, the first of which is shown at which the prescribed motions are possible."""


@dataclass(frozen=True)
class Chosen:
    """A state and parameters in numbers: values of all symbols, and q alone."""

    values: Mapping[Expr, float]
    q: tuple[float, ...]
    parameters: Mapping[str, float]

    def with_values(self, values: Mapping[Expr, float]) -> Chosen:
        """Return it with other values of some symbols."""
        return replace(self, values={**self.values, **values})

    def of(self, *nodes: Expr) -> list[float]:
        """Return the values of nodes.

        Raises:
            NoValueError: a formula has none at this state, or none that a double holds.
        """
        found = [float(x) for x in evaluate(nodes, Floats(), self.values)]
        if not all(map(math.isfinite, found)):
            raise NoValueError("at the state of the lesson a number is beyond the largest double; choose other units")
        return found

    def meets_zero(self, node: Expr, scene: Scene, q: Sequence[Expr]) -> bool:
        """Whether a node of up to three of the coordinates q, and of time, is zero somewhere or has both signs."""
        inside = {str(x.value): x for x in reachable([node]) if x.op is Op.SYMBOL}
        lengths = [self.parameters[x.name] for x in scene.parameters if x.unit == "m" and x.name in inside]
        far = FAR * (max(map(abs, lengths), default=0.0) or 1.0)
        ways = {"m": [0.0, far, -far, *lengths, *(-x for x in lengths)]}
        own = {x: ways.get(unit, TURNS) for x, unit in zip(q, SceneUnits(scene).coordinates, strict=True)}
        own = {x: values for x, values in own.items() if str(x.value) in inside}
        timed = {inside[TIME]: TIMES[:, None]} if TIME in inside else {}
        if not (own or timed) or len(own) > 3:
            return False
        at = dict(zip(own, np.array([*product(*own.values())]).T, strict=True))
        with np.errstate(all="ignore"):
            (found,) = evaluate([node], Batches(), {**self.values, **timed, **at})
        values = np.where(np.isfinite(found), found, np.nan)
        sizes = np.abs(np.where(np.isfinite(found), found, 0.0))
        few = NOTHING * (np.max(sizes, axis=1)[:, None] if timed else np.max(sizes))
        return bool(np.any(values <= few) and np.any(values >= -few))


def choose_state(scene: Scene, state: State, graph: Graph, moving: bool = True) -> Chosen:
    """Return a position that hides nothing, and velocities that are not all alike; without `moving`, at rest.

    Rates that the scene starts with are kept, and those of prescribed motions are as prescribed; what nothing drives
    is accelerated as `undriven` says.
    """
    q, parameters, moment = _placed(scene, _parameters(scene, moving))
    values = {graph.symbol(name): value for name, value in parameters.items()}
    values |= scene.at_time(graph, moment)
    values |= dict(zip(state.q, q, strict=True))
    given = starting_rates(scene, parameters)
    for k, (u, a) in enumerate(zip(state.qd, state.qdd, strict=True)):
        values[u] = (given[k] or RATES[k % len(RATES)]) if moving else 0.0
        values[a] = ACCELERATIONS[k % len(ACCELERATIONS)] if moving else 0.0
    led = prescribed(scene, graph)
    rates = evaluate([*led.velocity, *led.acceleration], Floats(), values)
    symbols = [*(state.qd[k] for k in led.place), *(state.qdd[k] for k in led.place)]
    values |= {symbol: float(value) for symbol, value in zip(symbols, rates, strict=True)}
    chosen = Chosen(values, q, parameters)
    return undriven(scene, chosen) if moving else chosen


def undriven(scene: Scene, chosen: Chosen) -> Chosen:
    """Return the state of an open mechanism with the accelerations that its equations give where nothing drives.

    Those of the others stay. Where a mass that is zero leaves some open, they are the least.
    """
    idle = idle_velocities(scene)
    if scene.is_constrained or not idle:
        return chosen
    w = Workspace(scene)
    qdd = w.state.qdd
    forces = [w.forces(list(qdd))[i] for i in idle]
    slopes = [x for force in forces for x in gradient(force, [qdd[i] for i in idle])]
    values = {w.graph.symbol(str(symbol.value)): value for symbol, value in chosen.values.items()}
    values |= {qdd[i]: 0.0 for i in idle}
    found = np.array([float(x) for x in evaluate([*forces, *slopes], Floats(), values)])
    rest, M = found[: len(idle)], found[len(idle) :].reshape(len(idle), len(idle))
    solved = np.linalg.lstsq(M, -rest, rcond=1e-12)[0]
    given = dict(zip((str(qdd[i].value) for i in idle), solved, strict=True))
    return chosen.with_values({x: float(given[str(x.value)]) for x in chosen.values if str(x.value) in given})


def idle_velocities(scene: Scene) -> list[int]:
    """Return the velocities for which there is neither a drive nor a prescribed motion."""
    led = scene.prescribed_velocities
    return [i for i, drive in enumerate(scene.drives) if drive is None and i not in led]


def starting_rates(scene: Scene, parameters: Mapping[str, float]) -> list[float]:
    """Return the velocities at which a scene starts, zeros where it does not say; shape (nv,)."""
    known = {name: Fraction(value) for name, value in parameters.items()}
    return [float(x.at(known) or 0) for x in start_of(scene).velocity]


def shown_state(scene: Scene) -> Chosen:
    """Return the state at which lessons of a scene show numbers; a mechanism with loops or rows is at rest there."""
    graph = Graph()
    return choose_state(scene, State.of(scene, graph), graph, moving=not scene.is_constrained)


def rates_of(energies: Energies, state: State, chosen: Chosen) -> list[float]:
    """Return the terms of d/dt K and d/dt P at a state, W: what their sum may be rounded by goes with these."""
    moving = (*state.q, *state.qd), (*state.rates, *state.qdd)
    return chosen.of(
        *(
            slope * rate
            for energy in (energies.K, energies.P)
            for slope, rate in zip(gradient(energy, moving[0]), moving[1], strict=True)
        )
    )


def timed(scene: Scene) -> bool:
    """Whether a force or a prescribed motion is a formula in time."""
    formulas = [x for joint in scene.joints for x in (*joint.forces, joint.motion) if x is not None]
    formulas += Quantity.inside(scene.loads)
    return any(TIME in x.symbols for x in formulas)


def _parameters(scene: Scene, moving: bool) -> dict[str, float]:
    """Return values for parameters that have none."""
    given: dict[str, float] = {}
    for parameter in scene.free_parameters:
        if parameter.unit.replace("²", "2").replace("^", "") == "m/s2":
            given[parameter.name] = FALL
        elif moving:
            given[parameter.name] = round(SIZES.get(parameter.unit, 1.0) * _share(len(given)), 3)
    return given


def _share(n: int) -> float:
    """Return the share of a usual size that the n-th parameter takes: no two of 297 alike, and none lost in rounding.

    >>> [round(_share(n), 3) for n in (0, 1, 10, 11, 12, 75)]
    [1.0, 0.8, 0.107, 0.999, 0.799, 0.128]
    """
    again, place = divmod(n, 11)
    return 0.8**place - 0.001 * (again % 27)


# Where


def _placed(scene: Scene, given: Mapping[str, float]) -> tuple[tuple[float, ...], dict[str, float], float]:
    """Return q, values of all parameters, and the time, s."""
    q, parameters = pose(scene, parameters=given)
    drawn = dict(zip(scene.coordinates, map(float, q), strict=True))
    for moment in MOMENTS:
        held = _led(scene, parameters, moment)
        for wanted in (_distinct(scene, drawn | held, held, parameters), held):
            try:
                q, parameters = pose(scene, at=wanted, parameters=given)
            except DrawError:  # loops that do not close there
                continue
            return tuple(map(float, q)), dict(parameters), moment
    return tuple(drawn.values()), dict(parameters), MOMENTS[-1]


def _led(scene: Scene, parameters: Mapping[str, float], moment: float) -> dict[str, float]:
    """Return where prescribed motions have their coordinates."""
    graph = Graph()
    led = prescribed(scene, graph)
    values = {graph.symbol(name): value for name, value in parameters.items()} | {graph.symbol(TIME): moment}
    names = [joint.coordinates[0] for joint in scene.moving if joint.motion is not None]
    return dict(zip(names, map(float, evaluate(led.position, Floats(), values)), strict=True))


def _distinct(
    scene: Scene, q: Mapping[str, float], held: Mapping[str, float], parameters: Mapping[str, float]
) -> dict[str, float]:
    """Return coordinates that are held, and others where none hides another; with loops or rows only driven ones."""
    found, seen, tied = dict(held), list(held.values()), scene.is_constrained
    for joint, name, unit in SceneUnits(scene).each_coordinate():
        if name in held or unit == "1" or (tied and not any(joint.drives)):
            continue
        low, high = joint.range({name: Fraction(value) for name, value in parameters.items()})
        for value in (q[name], *_others(q[name], unit)):
            if low < value < high and not _hides(value, unit, seen):
                found[name] = value
                break
        seen.append(found.get(name, q[name]))
    return found


def _others(value: float, unit: str) -> list[float]:
    return [*ANGLES, *(-x for x in ANGLES)] if unit == "rad" else [(value or 0.2) * way for way in WAYS]


def _hides(value: float, unit: str, seen: list[float]) -> bool:
    """Tell whether a coordinate is zero, an eighth of a turn, or as large as another one."""
    special = abs(math.remainder(value, math.pi / 4)) if unit == "rad" else abs(value)
    return special < NEAR or any(abs(abs(value) - abs(other)) < NEAR for other in seen)


def picture_letters(scene: Scene, graph: Graph, chosen: Chosen) -> tuple[Lettered, ...]:
    """Return the letters that stand for a mass alone, at its place, and for a length alone, amid it; each once."""
    latex, found = latex_symbols(scene), dict[str, Lettered]()
    for letter, place in (*_masses(scene, graph), *_lengths(scene, graph)):
        if letter not in found:
            found[letter] = Lettered(latex[letter], tuple(chosen.of(*place)))
    return tuple(found.values())


def _masses(scene: Scene, graph: Graph) -> Iterator[tuple[str, Vec]]:
    placed = body_placements(scene, graph)
    for body in scene.bodies:
        T = placed[body.name]
        for particle in body.particles:
            if particle.mass.op is Op.SYMBOL:
                yield str(particle.mass.value), T.point(vector(particle.at, graph))
        if body.mass.op is Op.SYMBOL and body.com is not None:
            yield str(body.mass.value), T.point(vector(body.com, graph))


def _lengths(scene: Scene, graph: Graph) -> Iterator[tuple[str, Vec]]:
    """Yield shifts of joints and places of particles and points along one axis, by one letter."""
    placed = body_placements(scene, graph)
    for joint in scene.joints:
        before = placed[joint.parent]
        yield from _steps(before, joint.origin, graph)
        if joint.tip.steps:
            moved = before @ joint.origin.transform(graph) @ joint_motion(joint, graph).placement
            yield from _steps(moved, joint.tip, graph)
    fixed = [(body.name, particle.at) for body in scene.bodies for particle in body.particles]
    fixed += [(point.body, _shift(point.at)) for point in scene.points if point.body in placed]
    for body, at in fixed:
        named = [_letter(x) for x in at]
        if sum(x != Quantity.ZERO for x in at) == 1 and any(named):
            T = placed[body]
            yield next(filter(None, named)), _middle(T.p, T.point(vector(at, graph)))


def _steps(T: Transform, pose: Pose, graph: Graph) -> Iterator[tuple[str, Vec]]:
    for kind, amount in pose.steps:
        after = T @ Transform.elementary(kind, amount.express(graph))
        if kind[0] == "T" and (letter := _letter(amount)):
            yield letter, _middle(T.p, after.p)
        T = after


def _shift(pose: Pose) -> tuple[Quantity, Quantity, Quantity]:
    """Return the shift of a pose without turns; zeros of any other."""
    shifts = dict(pose.steps)
    if len(shifts) < len(pose.steps) or any(kind[0] != "T" for kind in shifts):
        return (Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)
    return (shifts.get("Tx", Quantity.ZERO), shifts.get("Ty", Quantity.ZERO), shifts.get("Tz", Quantity.ZERO))


def _letter(amount: Quantity) -> str:
    """Return the letter that a quantity or its negative is; "" for any other."""
    inner = amount.args[0] if amount.op is Op.NEG else amount
    return str(inner.value) if inner.op is Op.SYMBOL else ""


def _middle(a: Vec, b: Vec) -> Vec:
    return scale(a[0].graph.one / 2, add(a, b))

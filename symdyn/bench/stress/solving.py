"""What is hard to solve, and angles that are hard.

Near-singular mass matrices: massless and near-massless links, mass ratios of 1e±12, gimbal lock.

    forward     |qdd - true| ≤ c n ε |M⁻¹| (|M||qdd| + |h| + |tau|)        c = 10
    backward    |M qdd + h - tau| ≤ 10 ε (|M||qdd| + |h| + |tau|)

in infinity norms, ε = 2^-52; backward errors of closed mechanisms as in `symdyn.bench.reference`. The plain bound
ε cond(M) |qdd| fails where tau ≈ h: the accelerations are then small, and the error that is left in h is not.

Chains of up to 100 links, in angles relative to the link before and to the vertical:

    inverse dynamics    |tau - true| ≤ c n ε (|M||qdd| + |M||qd|² + |g|)        c = 1
    forward dynamics    |qdd - true| as for near-singular mass matrices
                        |M qdd + h - tau| ≤ c n ε (|M||qdd| + |h| + |tau|)      c = 1

M and h go through n rotations, one for each link, so that n roundings are in them. Running error bounds say nothing
here: they grow exponentially along a chain, errors do not.

Angles that are huge, tiny, or sums of huge ones: code that rounds q1 + q2 first has lost its digits.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.bench.measurements import Case, worst
from symdyn.bench.reference import Positions, Solve, linear, positions_of
from symdyn.bench.stress.scenes import (
    EPSILON,
    Calls,
    arm,
    calls,
    chain,
    gimbal,
    heavier,
    looked_at,
    offset_pendulum,
    one_body,
    solved,
    two_link,
)
from symdyn.dynamics import formulations_of, row_of
from symdyn.dynamics.mechanism import TIME
from symdyn.emit.code import REALS, Real
from symdyn.errors import DerivationError
from symdyn.graph import evaluate
from symdyn.scene import Scene
from symdyn.simulation.prescribed import parameter_values

C = 10.0
FORWARD = ("forward_dynamics",)
BESIDE = row_of(*FORWARD)[0].solves
STATES = 12
NOT_FINITE = "the equations are not finite"
SMALL, LARGE = Fraction(1, 10**12), 10**12


def builtin() -> Iterator[Case]:
    """Yield the cases of the built-in scenes."""
    for formulation in _formulations(two_link(0)):
        made = calls(two_link(0), FORWARD, formulation=formulation, beside=BESIDE)
        bent = {
            name: value[1:] for name, value in states(positions_of(two_link(0)), 2).items()
        }  # M has no inverse in line
        yield from cases(f"two links, first massless, {formulation}", made, bent)
    for name, one in (
        ("two links, first nearly massless: singular where they are in line", two_link(SMALL)),
        ("two links, first 1e12 times as heavy", two_link(LARGE)),
        ("two links, second 1e-12 times as heavy", two_link(1, SMALL)),
        ("two links, second 1e12 times as heavy", two_link(1, LARGE)),
        ("6 axes, last link 1e12 times as heavy", heavier(arm(), (1,) * 5 + (LARGE,))),
        ("6 axes, last link 1e-12 times as heavy", heavier(arm(), (1,) * 5 + (SMALL,))),
        ("6 axes, links 1 and 1e-12 by turns", heavier(arm(), (1, SMALL) * 3)),
    ):
        for formulation in _formulations(one):
            made = calls(one, FORWARD, formulation=formulation, beside=BESIDE)
            yield from cases(f"{name}, {formulation}", made, states(positions_of(one), len(one.velocities)))
    made = calls(gimbal(), (*FORWARD, *BESIDE))
    yield from cases("gimbal lock, pitch pi/2 - 10^-k, k = 1 … 14", made, _locked(made))


def of_scene(scene: Scene) -> Iterator[Case]:
    """Yield the cases of a scene with its last body lighter and heavier."""
    parameter_values(scene)
    if any(joint.motion is not None for joint in scene.joints):
        return
    given = states(positions_of(scene), len(scene.velocities)) | {TIME: np.linspace(0.0, 1.0, STATES)[:, None]}
    given |= {"inputs": np.linspace(1.0, 2.0, STATES * len(scene.inputs)).reshape(STATES, -1)}
    given |= {"internal": np.linspace(1.0, 2.0, STATES * len(scene.states)).reshape(STATES, -1)}
    for name, factor in (("as it is", 1), ("last body 1e12 times as heavy", LARGE), ("last body 1e-12 times", SMALL)):
        one = heavier(scene, (*(1,) * (len(scene.bodies) - 1), factor))
        for formulation in _formulations(one):
            try:
                if scene.is_constrained:
                    yield _closed(f"{name}, {formulation}", one, calls(one, FORWARD, formulation=formulation), given)
                else:
                    yield from cases(
                        f"{name}, {formulation}", calls(one, FORWARD, formulation=formulation, beside=BESIDE), given
                    )
            except DerivationError:
                if factor == 1:
                    raise  # else the last body alone moves something, of which too little mass is left


def _formulations(scene: Scene) -> list[str]:
    """Return the derivations of forward dynamics that pay for any number of coordinates."""
    row, _ = row_of(*FORWARD, scene)
    return [
        formulation
        for formulation in formulations_of(*FORWARD, scene)
        if row.formulations[formulation].up_to == math.inf
    ]


def cases(name: str, made: Calls, given: Mapping[str, Array]) -> Iterator[Case]:
    """Yield both errors of a scene's forward dynamics at states."""
    found = solved(made, given)
    forward = worst([(one.forward, one.where) for one in found], NOT_FINITE)
    backward = worst([(one.backward, one.where) for one in found], NOT_FINITE)
    yield Case(name, "forward error / (n eps |M^-1| (|M||qdd| + |h| + |tau|))", C, *forward)
    yield Case(name, "backward error / eps", 10.0, *backward)


def _closed(name: str, one: Scene, made: Calls, given: Mapping[str, Array]) -> Case:
    """Return the backward error of a closed mechanism's forward dynamics."""
    solve = Solve.at(linear(one, *FORWARD), given, STATES)
    found = []
    if solve is not None:
        for way, computed in made.results("forward_dynamics", given).items():
            errors = solve.backward(computed, given["tau"], np.arange(STATES), EPSILON)
            found += [(error, f"{way}, state {k}") for k, error in enumerate(errors)]
    metric = "backward error of accelerations and of loops / eps"
    return Case(name, metric, 10.0, *worst(found, NOT_FINITE))


def states(positions: Positions, n: int, seed: int = 1) -> dict[str, Array]:
    """Return states; of a tree a third are stretched out and one exactly, where rows of M come close to each other."""
    rng = np.random.default_rng(seed)
    units = positions.units
    q = positions.draw("range", STATES, rng)
    qd, tau = rng.uniform(-2, 2, (STATES, n)), rng.uniform(-5, 5, (STATES, n))
    if positions.loops is not None:
        return {"q": q, "qd": positions.loops.allowed(q, qd), "tau": tau}
    turning = np.array([unit == "rad" for unit in units])
    turning[:1] = False
    third = STATES // 3
    q[:third] = np.where(turning, rng.uniform(-1, 1, (third, len(units))) * 1e-6, q[:third])
    q[0] = np.where(turning, 0.0, q[0])
    return {"q": q, "qd": qd, "tau": tau}


def _locked(made: Calls) -> dict[str, Array]:
    """Return pitches ever closer to π/2, once without forces and once with forces that nearly hold the top."""
    pitch = [math.pi / 2 - 10.0**-k for k in range(1, 15)]
    q = np.array([(0.3, theta, -0.7) for theta in pitch])
    qd = np.tile((0.4, -0.3, 0.2), (len(q), 1))
    h = made.modules["NumPy"].inverse_dynamics(q, qd, np.zeros_like(q))
    return {"q": np.vstack([q, q]), "qd": np.vstack([qd, qd]), "tau": np.vstack([0 * h, h])}


LINKS_INVERSE, LINKS_FORWARD = (2, 10, 100), {False: (2, 10, 100), True: (2, 10, 30, 100)}
"""Links. M is not tree-sparse in absolute angles, and its elimination grows with the cube of their number."""

COMPILED = 30
"""Links beyond which elimination in absolute angles is run as a program: no compiler likes 400 000 lines of C."""

CHAIN_STATES = 3


def chains() -> Iterator[Case]:
    """Yield inverse and forward dynamics of chains of up to 100 links."""
    for absolute, kind in ((False, "relative"), (True, "absolute")):
        for n in LINKS_INVERSE:
            yield _inverse(f"{n} links, {kind} angles", n, absolute)
        for n in LINKS_FORWARD[absolute]:
            compiled = not absolute or n <= COMPILED
            made = calls(chain(n, absolute), ("forward_dynamics",), beside=BESIDE, compiled=compiled)
            forward, backward = cases(f"{n} links, {kind} angles", made, _chain_states(n, ("q", "qd", "tau")))
            yield forward
            share = None if backward.measured is None else backward.measured / n
            yield replace(backward, metric="backward error / (n eps)", bound=1.0, measured=share)


def _chain_states(n: int, names: tuple[str, ...]) -> dict[str, Array]:
    rng = np.random.default_rng(n)
    return {name: rng.uniform(-2, 2, (CHAIN_STATES, n)) for name in names}


def _inverse(name: str, n: int, absolute: bool) -> Case:
    made = calls(chain(n, absolute), ("inverse_dynamics",), beside=("mass_matrix", "gravity_forces"))
    given = _chain_states(n, ("q", "qd", "qdd"))
    known = made.truth("inverse_dynamics", given)
    M = _doubles(made, "mass_matrix", given["q"]).reshape(-1, n, n)
    g = _doubles(made, "gravity_forces", given["q"])
    norm = np.abs(M).sum(axis=2).max(axis=1)
    scale = norm * (np.abs(given["qdd"]).max(axis=1) + np.abs(given["qd"]).max(axis=1) ** 2) + np.abs(g).max(axis=1)
    found = []
    for way, computed in made.results("inverse_dynamics", given).items():
        share = known.errors(computed).max(axis=1) / (n * EPSILON * scale)
        found.append((float(share.max()), way))
    return Case(name, "error of inverse_dynamics / (n eps (|M||qdd| + |M||qd|^2 + |g|))", 1.0, *worst(found))


def _doubles(made: Calls, name: str, q: Array) -> Array:
    function = made.function(name)
    return np.array([evaluate(function.entries, Floats(), function.values([row])) for row in q], float)


def shares(
    made: Calls, output: str, given: dict[str, Array], roundoff: float = REALS["double"].roundoff
) -> tuple[float | None, str]:
    """Return the largest error of any entry, state and implementation over its running error bound, and where."""
    known = made.truth(output, given)
    found = []
    for way, computed in made.results(output, given).items():
        own = known.bound * (roundoff / REALS["double"].roundoff) + np.finfo(float).tiny
        share = known.errors(computed) / own
        found.append((float(share.max()) if share.size else None, way))
    return worst(found)


TINY = (1e-3, 1e-6, 1e-9, 1e-12, 1e-100, 1e-154, 1e-160, 1e-300, 1e-310, 5e-324)


def huge_angles() -> Iterator[Case]:
    """Yield huge angles, sums of them, and tiny ones."""
    for power in (6, 9, 12, 15, 16, 22):
        yield _sums(power)
    yield _huge_chain()
    yield _tiny()
    yield _cancelled()


def angles_of_scene(scene: Scene) -> Iterator[Case]:
    """Yield what functions of the scene's position lose at turns of 1e6 to 1e15 rad."""
    parameter_values(scene)
    anywhere = Positions(positions_of(scene).units, np.empty((0, len(scene.coordinates))))
    units = anywhere.units
    names = [name for name in looked_at(scene) if row_of(name)[0].arguments == ("q",)]
    if "rad" not in units or not names:
        return
    rng = np.random.default_rng(1)
    q = anywhere.draw("range", 8, rng)
    q = np.where([unit == "rad" for unit in units], np.sign(q) * 10 ** rng.uniform(6, 15, q.shape), q)
    made = calls(scene, names)
    for name in names:
        metric = f"error of {name} / running error bound"
        yield Case("turns of 1e6 … 1e15 rad", metric, Real.ALLOWED, *shares(made, name, {"q": q}))


def _sums(power: int) -> Case:
    """Return the error of two links' tip at q1 = 10^k, in ulps of the length of a link; sin(q1 + q2) is in it."""
    made = calls(two_link(), ("pose:tool", "gravity_forces"))
    q = np.array([[10.0**power, 1.0], [10.0**power, -(10.0**power) + 2.0], [1.0, -(10.0**power)]])
    known = made.truth("pose_tool", {"q": q})
    found = [(float(np.max(known.errors(x))) / EPSILON, way) for way, x in made.results("pose_tool", {"q": q}).items()]
    return Case(f"sums of angles of 1e{power} rad", "error of the tip, ulps of a link", 8.0, *worst(found))


def _huge_chain() -> Case:
    made = calls(chain(4), ("inverse_dynamics",))
    rng = np.random.default_rng(4)
    q = rng.choice([-1.0, 1.0], (12, 4)) * 10 ** rng.uniform(6, 16, (12, 4))
    given = {"q": q, "qd": rng.uniform(-2, 2, q.shape), "qdd": rng.uniform(-2, 2, q.shape)}
    metric = "error of inverse_dynamics / running error bound"
    return Case("chain of 4, angles of 1e6 … 1e16 rad", metric, Real.ALLOWED, *shares(made, "inverse_dynamics", given))


def _tiny() -> Case:
    """Return the relative error of gravity forces, which are as small as the angle."""
    made = calls(one_body(), ("gravity_forces",))
    q = np.array([(sign * x,) for x in TINY for sign in (1.0, -1.0)])
    known = made.truth("gravity_forces", {"q": q})
    found = []
    for way, computed in made.results("gravity_forces", {"q": q}).items():
        size = np.maximum(np.abs(known.high), 2.0**-1022)
        found.append((float(np.max(known.errors(computed) / size)) / EPSILON, way))
    return Case("pendulum at 1e-3 … 5e-324 rad", "relative error of gravity_forces, ulps", 2.0, *worst(found))


def _cancelled() -> Case:
    """Return the error of a height 1 - cos q, in ulps of the link: all that rounding cos q once leaves of it."""
    made = calls(offset_pendulum(), ("pose:bob",))
    q = np.array([(x,) for x in TINY])
    known = made.truth("pose_bob", {"q": q})
    found = [(float(np.max(known.errors(x))) / EPSILON, way) for way, x in made.results("pose_bob", {"q": q}).items()]
    return Case("height 1 - cos q at 1e-3 … 5e-324 rad", "error of the height, ulps of a link", 1.0, *worst(found))

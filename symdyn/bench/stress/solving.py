"""Near-singular mass matrices: massless and near-massless links, mass ratios of 1e±12, gimbal lock.

    forward     |qdd - true| ≤ c n ε |M⁻¹| (|M||qdd| + |h| + |tau|)        c = 10
    backward    |M qdd + h - tau| ≤ 10 ε (|M||qdd| + |h| + |tau|)

in infinity norms, ε = 2^-52; backward errors of closed mechanisms as in `symdyn.bench.reference`. The plain bound
ε cond(M) |qdd| fails where tau ≈ h: the accelerations are then small, and the error that is left in h is not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from symdyn.bench.case import Case, worst
from symdyn.bench.reference import Positions, Solve, linear, positions_of
from symdyn.bench.stress.scenes import EPSILON, Calls, arm, calls, gimbal, heavier, solved, two_link
from symdyn.dynamics import formulations_of, row_of
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import DerivationError
from symdyn.scene import Scene
from symdyn.simulation.prescribed import parameter_values

Array = npt.NDArray[np.float64]

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
    for name, factor in (("as it is", 1), ("last body 1e12 times as heavy", LARGE), ("last body 1e-12 times", SMALL)):
        one = heavier(scene, (*(1,) * (len(scene.bodies) - 1), factor))
        for formulation in _formulations(one):
            try:
                if scene.is_closed:
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


def cases(name: str, made: Calls, given: Mapping[str, Array], epsilon: float = EPSILON) -> Iterator[Case]:
    """Yield both errors of a scene's forward dynamics at states."""
    found = solved(made, given, epsilon)
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

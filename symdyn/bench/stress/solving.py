"""Near-singular mass matrices: massless and near-massless links, mass ratios of 1e±12, gimbal lock.

    forward     |qdd - true| ≤ c n ε |M⁻¹| (|M||qdd| + |h| + |tau|)        c = 10
    backward    |M qdd + h - tau| ≤ 10 ε (|M||qdd| + |h| + |tau|)

in infinity norms, ε = 2^-52. The plain bound ε cond(M) |qdd| fails where tau ≈ h: the accelerations are then small, and
the error that is left in h is not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from symdyn.bench.states import Positions
from symdyn.bench.stress.calls import EPSILON, Calls, calls, solved
from symdyn.bench.stress.model import Case, worst
from symdyn.bench.stress.scenes import arm, gimbal, heavier, two_link
from symdyn.dynamics import roads
from symdyn.dynamics.loops.outputs import is_closed
from symdyn.scene import JOINTS, Scene

Array = npt.NDArray[np.float64]

FAMILY = "solving"
C = 10.0
FORWARD = ("forward_dynamics",)
BESIDE = ("mass_matrix", "inverse_dynamics")
STATES = 12
SMALL, LARGE = Fraction(1, 10**12), 10**12


def builtin() -> Iterator[Case]:
    """Yield the cases of the built-in scenes."""
    for name, one in (
        ("two links, first nearly massless: singular where they are in line", two_link(SMALL)),
        ("two links, first 1e12 times as heavy", two_link(LARGE)),
        ("two links, second 1e-12 times as heavy", two_link(1, SMALL)),
        ("two links, second 1e12 times as heavy", two_link(1, LARGE)),
        ("6 axes, last link 1e12 times as heavy", heavier(arm(), (1,) * 5 + (LARGE,))),
        ("6 axes, last link 1e-12 times as heavy", heavier(arm(), (1,) * 5 + (SMALL,))),
        ("6 axes, links 1 and 1e-12 by turns", heavier(arm(), (1, SMALL) * 3)),
    ):
        for road in ("crba", "aba"):
            made = calls(one, FORWARD, road=road, beside=BESIDE)
            yield from cases(f"{name}, {road}", made, states(len(one.velocities), ("rad",) * len(one.coordinates)))
    made = calls(gimbal(), (*FORWARD, *BESIDE))
    yield from cases("gimbal lock, pitch pi/2 - 10^-k, k = 1 … 14", made, _locked(made))


def of_scene(scene: Scene) -> Iterator[Case]:
    """Yield the cases of a tree with its last body lighter and heavier; closed mechanisms have none."""
    free = any(p.value is None for p in scene.parameters)
    if is_closed(scene) or free or not scene.velocities or any(joint.motion is not None for joint in scene.joints):
        return
    units = tuple(unit for joint in scene.moving for unit in JOINTS[joint.type].coordinates(joint))
    given = states(len(scene.velocities), units)
    for name, factor in (("as it is", 1), ("last body 1e12 times as heavy", LARGE), ("last body 1e-12 times", SMALL)):
        one = heavier(scene, (*(1,) * (len(scene.bodies) - 1), factor))
        for road in roads("forward_dynamics", one):
            if road in ("crba", "aba"):
                yield from cases(f"{name}, {road}", calls(one, FORWARD, road=road, beside=BESIDE), given)


def cases(name: str, made: Calls, given: Mapping[str, Array], epsilon: float = EPSILON) -> Iterator[Case]:
    """Yield both errors of a scene's forward dynamics at states."""
    found = solved(made, given, epsilon)
    forward = worst([(one.forward, one.where) for one in found])
    backward = worst([(one.backward, one.where) for one in found])
    yield Case(FAMILY, name, "forward error / (n eps |M^-1| (|M||qdd| + |h| + |tau|))", C, *forward)
    yield Case(FAMILY, name, "backward error / eps", 10.0, *backward)


def states(n: int, units: tuple[str, ...], seed: int = 1) -> dict[str, Array]:
    """Return states, a third of them stretched out and one exactly so, where rows of M come close to each other."""
    rng = np.random.default_rng(seed)
    positions = Positions(units, np.empty((0, len(units))))
    q = positions.draw("range", STATES, rng)
    turning = np.array([unit == "rad" for unit in units])
    turning[:1] = False
    third = STATES // 3
    q[:third] = np.where(turning, rng.uniform(-1, 1, (third, len(units))) * 1e-6, q[:third])
    q[0] = np.where(turning, 0.0, q[0])
    return {"q": q, "qd": rng.uniform(-2, 2, (STATES, n)), "tau": rng.uniform(-5, 5, (STATES, n))}


def _locked(made: Calls) -> dict[str, Array]:
    """Return pitches ever closer to π/2, once without forces and once with forces that nearly hold the top."""
    pitch = [math.pi / 2 - 10.0**-k for k in range(1, 15)]
    q = np.array([(0.3, theta, -0.7) for theta in pitch])
    qd = np.tile((0.4, -0.3, 0.2), (len(q), 1))
    h = made.modules["NumPy"].inverse_dynamics(q, qd, np.zeros_like(q))
    return {"q": np.vstack([q, q]), "qd": np.vstack([qd, qd]), "tau": np.vstack([0 * h, h])}

"""Angles that are huge or tiny, and sums of huge ones: code that rounds q1 + q2 first has lost its digits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from symdyn.bench.case import Case, worst
from symdyn.bench.states import Positions, positions_of
from symdyn.bench.stress.chains import shares
from symdyn.bench.stress.scenes import calls, chain, looked_at, offset_pendulum, one_body, two_link
from symdyn.dynamics import row_of
from symdyn.emit.code import Real
from symdyn.scene import Scene
from symdyn.simulation.prescribed import parameter_values

Array = npt.NDArray[np.float64]

EPSILON = 2.0**-52
TINY = (1e-3, 1e-6, 1e-9, 1e-12, 1e-100, 1e-154, 1e-160, 1e-300, 1e-310, 5e-324)


def builtin() -> Iterator[Case]:
    """Yield huge angles, sums of them, and tiny ones."""
    for power in (6, 9, 12, 15, 16, 22):
        yield _sums(power)
    yield _huge_chain()
    yield _tiny()
    yield _cancelled()


def of_scene(scene: Scene) -> Iterator[Case]:
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

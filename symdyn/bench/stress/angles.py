"""Angles that are hard: along chains of up to 100 links, huge, tiny, and sums of huge ones.

Chains are in angles relative to the link before and to the vertical:

    inverse dynamics    |tau - true| ≤ c n ε (|M||qdd| + |M||qd|² + |g|)        c = 1
    forward dynamics    |qdd - true| as for near-singular mass matrices
                        |M qdd + h - tau| ≤ c n ε (|M||qdd| + |h| + |tau|)      c = 1

in infinity norms. M and h go through n rotations, one for each link, so that n roundings are in them. Running error
bounds say nothing here: they grow exponentially along a chain, errors do not.

Of huge angles, code that rounds q1 + q2 first has lost its digits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Floats
from symdyn.bench.case import Case, worst
from symdyn.bench.reference import Positions, positions_of
from symdyn.bench.stress.scenes import EPSILON, Calls, calls, chain, looked_at, offset_pendulum, one_body, two_link
from symdyn.bench.stress.solving import BESIDE, cases
from symdyn.dynamics import row_of
from symdyn.emit.code import REALS, Real
from symdyn.graph import evaluate
from symdyn.scene import Scene
from symdyn.simulation.prescribed import parameter_values

Array = npt.NDArray[np.float64]

INVERSE, FORWARD = (2, 10, 100), {False: (2, 10, 100), True: (2, 10, 30, 100)}
"""Links. M is not tree-sparse in absolute angles, and its elimination grows with the cube of their number."""

COMPILED = 30
"""Links beyond which elimination in absolute angles is run as a program: no compiler likes 400 000 lines of C."""

STATES = 3


def chains() -> Iterator[Case]:
    """Yield inverse and forward dynamics of chains of up to 100 links."""
    for absolute, kind in ((False, "relative"), (True, "absolute")):
        for n in INVERSE:
            yield _inverse(f"{n} links, {kind} angles", n, absolute)
        for n in FORWARD[absolute]:
            compiled = not absolute or n <= COMPILED
            made = calls(chain(n, absolute), ("forward_dynamics",), beside=BESIDE, compiled=compiled)
            forward, backward = cases(f"{n} links, {kind} angles", made, _states(n, ("q", "qd", "tau")))
            yield forward
            share = None if backward.measured is None else backward.measured / n
            yield replace(backward, metric="backward error / (n eps)", bound=1.0, measured=share)


def _states(n: int, names: tuple[str, ...]) -> dict[str, Array]:
    rng = np.random.default_rng(n)
    return {name: rng.uniform(-2, 2, (STATES, n)) for name in names}


def _inverse(name: str, n: int, absolute: bool) -> Case:
    made = calls(chain(n, absolute), ("inverse_dynamics",), beside=("mass_matrix", "gravity_forces"))
    given = _states(n, ("q", "qd", "qdd"))
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
    """Return a function of q in plain doubles, shape (N, size)."""
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

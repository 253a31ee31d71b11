"""Long chains, in angles relative to the link before and to the vertical.

    inverse dynamics    |tau - true| ≤ c n ε (|M||qdd| + |M||qd|² + |g|)        c = 1
    forward dynamics    |qdd - true| as for near-singular mass matrices
                        |M qdd + h - tau| ≤ c n ε (|M||qdd| + |h| + |tau|)      c = 1

in infinity norms. M and h go through n rotations, one for each link, so that n roundings are in them. Running error
bounds say nothing here: they grow exponentially along a chain, errors do not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Floats
from symdyn.bench.case import Case, worst
from symdyn.bench.stress.scenes import EPSILON, Calls, calls, chain
from symdyn.bench.stress.solving import BESIDE, cases
from symdyn.emit.code import REALS
from symdyn.graph import evaluate

Array = npt.NDArray[np.float64]

INVERSE, FORWARD = (2, 10, 100), {False: (2, 10, 100), True: (2, 10, 30, 100)}
"""Links. M is not tree-sparse in absolute angles, and its elimination grows with the cube of their number."""

COMPILED = 30
"""Links beyond which elimination in absolute angles is run as a program: no compiler likes 400 000 lines of C."""

STATES = 3


def builtin() -> Iterator[Case]:
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

"""The quadruped with its feet held to the ground, and states in which they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from cases import EXAMPLES, Array, Case

from symdyn.bench.reference import positions_of
from symdyn.program import quaternion_places
from symdyn.scene import SceneUnits, read, read_text

FEET = {"fl": ("0.19", "0.13"), "fr": ("0.19", "-0.13"), "rl": ("-0.19", "0.13"), "rr": ("-0.19", "-0.13")}
"""Where the feet stand at the start, m."""

SHANK = (0.0, 0.0, -0.21)
"""Where a foot is on its shank, m."""

REACH = 0.2
"""How far coordinates are drawn from the start, rad or m, before they are brought onto the loops."""


@dataclass(frozen=True)
class Held(Case):
    """A robot with points of it held to the ground.

    Attributes:
        free: the same without.
        points: the joint that carries the body of each point, and where the point is on it, m.
    """

    free: Case
    points: tuple[tuple[str, tuple[float, ...]], ...]

    def draw(self, count: int) -> dict[str, Array]:
        """Return `count` states next to the start: q and qd on the loops, and tau, shape (count, entries)."""
        rng, loops = np.random.default_rng(7), positions_of(self.scene).loops
        assert loops is not None, "nothing holds a robot that is free"
        start = loops.numbers.start()
        q = start + rng.uniform(-REACH, REACH, (count, len(start)))
        for k in quaternion_places(SceneUnits(self.scene).coordinates):
            q[:, k : k + 4] /= np.linalg.norm(q[:, k : k + 4], axis=1, keepdims=True)
        q = loops.closed(q)
        qd, tau = rng.uniform(-2, 2, (2, count, self.n))
        return {"q": q, "qd": loops.allowed(q, qd), "tau": tau}


def held_quadruped() -> Held:
    """Return the quadruped on its four feet."""
    text = (EXAMPLES / "quadruped.toml").read_text("utf-8")
    for leg, (x, y) in FEET.items():
        text += f'\n[[loop]]\nname = "{leg}_held"\ntype = "spherical"\nparent = "ground"\nchild = "{leg}_shank"\n'
        text += f"origin = [{x}, {y}, 0]\ntip = [{', '.join(str(-one) for one in SHANK)}]\n"  # from foot to shank
    points = tuple((f"{leg}_knee", SHANK) for leg in FEET)
    return Held("quadruped_held", read_text(text), Case("quadruped", read(EXAMPLES / "quadruped.toml")), points)

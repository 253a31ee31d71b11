"""What a scene weighs, one entry a particle and one a rigid body: the indices that formulas of a walkthrough carry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symdyn.dynamics.mechanism import vector
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene
from symdyn.scene.values import Body
from symdyn.spatial import Mat, Transform, Vec

AXES = "xyz"


@dataclass(frozen=True)
class Mass:
    """A particle or a rigid body.

    Attributes:
        tag: its index in print: the body's number from 1, with a letter where the body has several masses.
        body: what carries it.
        particle: whether it is a point mass.
        m: kg.
        place: of the particle, the centre of mass, or (`h` given) the origin of the body frame; ground frame, m.
        inertia: about that place, body axes; kg m^2.
        h: first moment in the ground frame, kg m, where inertia is declared about the body frame's origin; else None.
    """

    tag: str
    body: Body
    particle: bool
    m: Expr
    place: Vec
    inertia: Mat
    h: Vec | None = None

    @property
    def spins(self) -> bool:
        """Whether there is a moment of inertia."""
        return not all(x.is_zero for row in self.inertia for x in row)


def masses(scene: Scene, graph: Graph, placed: Mapping[str, Transform]) -> list[Mass]:
    """Return all masses, the ground's side first; `placed` says where bodies are in the ground frame."""
    found = []
    for number, body in enumerate(scene.bodies, 1):
        T = placed[body.name]
        own = [(p.mass.express(graph), T.point(vector(p.at, graph))) for p in body.particles]
        m, inertia = body.mass.express(graph), Mat.symmetric(*(x.express(graph) for x in body.inertia))
        extended = not m.is_zero or not all(x.is_zero for row in inertia for x in row) or body.first_moment is not None
        tags = [str(number)] if len(own) + extended == 1 else [f"{number}{letter}" for letter in "abcdefgh"]
        if len(own) + extended > len(tags):
            tags = [f"{number},{k + 1}" for k in range(len(own) + extended)]
        if extended:
            tag, *tags = tags
            if body.about == "com" and body.com is not None:
                found.append(Mass(tag, body, False, m, T.point(vector(body.com, graph)), inertia))
            else:
                found.append(Mass(tag, body, False, m, T.p, inertia, T.R @ body.mass_moment(graph)))
        nothing = Mat.symmetric(*[graph.zero] * 6)
        found += [Mass(tag, body, True, m, at, nothing) for tag, (m, at) in zip(tags, own, strict=False)]
    return found

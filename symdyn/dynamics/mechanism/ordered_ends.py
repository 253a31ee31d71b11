"""Springs and dampers on one line, as lessons take them: their ends keep the order of the start.

Their length √u² is |u|, which is the polynomial u that is positive at the start as long as the ends do not pass each
other. Generated code keeps the root, which holds on both sides.
"""

from __future__ import annotations

from symdyn.dynamics.mechanism.ropes import Taut
from symdyn.dynamics.mechanism.state import ends_apart
from symdyn.frozen import replace
from symdyn.graph import Graph, Op
from symdyn.scene import Scene
from symdyn.scene.values import Strut
from symdyn.spatial import dot


def in_order(scene: Scene) -> Scene:
    """Return the scene with ends on one line marked as ordered; parameters without a value count as 1 for the sign."""
    taut, elements = Taut(scene, Graph()), []
    for one in scene.elements:
        if isinstance(one, Strut) and one.ends and not one.is_rope:
            apart = ends_apart(scene, one.ends, taut.graph)
            if taut.root(dot(apart, apart), guessed=True).op not in (Op.SQRT, Op.CONSTANT):
                one = replace(one, ends=tuple(replace(end, ordered=True) for end in one.ends))
        elements.append(one)
    return replace(scene, elements=tuple(elements))

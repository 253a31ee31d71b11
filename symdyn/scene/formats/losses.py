"""What robot files have no words for: loops, what acts, and where a scene starts."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.scene.forces import FORCES, place_of
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import ZERO
from symdyn.scene.values.spelling import spell


def lost_words(scene: Scene) -> Iterator[str]:
    """Return what neither URDF nor a parameter file holds, one line each."""
    yield from (f"loops.{one.name}: closes a loop, and the file holds trees" for one in scene.loops)
    yield from (f"{place_of(one)}: {FORCES[one.kind].lost}" for one in scene.elements)
    for joint in scene.joints:
        where = f"joints.{joint.name}"
        if any(force != ZERO for force in joint.forces):
            shown = ", ".join(spell(force) for force in joint.forces)
            yield f"{where}: force = {shown}: there are no forces in formulas"
        if joint.dry is not None:
            yield f"{where}: {FORCES[joint.dry.kind].lost}"
        if joint.motion is not None:
            yield f"{where}: motion = {spell(joint.motion)}"
        if any(x != ZERO for x in (*joint.start, *joint.start_rates)):
            yield f"{where}: where it starts"

"""What a reader of scene files is asked and what it answers, and the same for a writer."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.scene.values.model import Scene


@dataclass(frozen=True)
class ReadOptions:
    """How to read a file.

    Attributes:
        snap: whether a decimal that is a small rational multiple of π, correctly rounded at its own digits, is read as
            that multiple.
        allow_invalid_inertia: whether inertias that no body has are notes instead of faults.
        spanning_tree: names of the joints to cut where joints close loops; None chooses them, with a note for each.
        floating_base: name of a free joint with a quaternion between the ground and the root of a robot; None: the root
            is the ground.
    """

    snap: bool = True
    allow_invalid_inertia: bool = False
    spanning_tree: tuple[str, ...] | None = None
    floating_base: str | None = None


@dataclass(frozen=True)
class Reading:
    """A scene as it was read.

    Attributes:
        scene: checked and in order.
        notes: what the reader changed, doubts or leaves out of the equations, one line each, "<source>: " in front.
    """

    scene: Scene
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Written:
    """A scene as text of some format.

    Attributes:
        text: contents of the file.
        lost: what the format cannot hold, one line each.
    """

    text: str
    lost: tuple[str, ...] = ()

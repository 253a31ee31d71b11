"""Keys of joint types: what each of them says, as data that readers, writers, checks and makers of symbols walk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from symdyn.scene.values.model import Joint
from symdyn.scene.values.quantity import ONE, ZERO, Vector
from symdyn.scene.values.table import Table, show

T = TypeVar("T")


@dataclass(frozen=True)
class JointKey(Generic[T]):
    """One thing that joints of a type take beside what every joint takes.

    Its value is a number, a direction in the joint frame, text, a tuple of texts, or steps in the joint's coordinates.

    Attributes:
        name: as scenes write it.
        read: its value from a table, its name, and what stands in after a fault.
        default: its value where it is left out.
        example: what to write where it must be given; "" where it may be left out.
        above_zero: what a number of zero or less is, and what to give instead; "" where it may be any.
        letter: of the parameter that stands for a number; "" for none.
        unit: of a number.
        text: what a number is, before the name of the joint.
        turned: of a direction, whether it is in the moved joint frame.
    """

    name: str
    read: Callable[[Table, str, T], T]
    default: T
    example: str = ""
    above_zero: str = ""
    letter: str = ""
    unit: str = ""
    text: str = ""
    turned: bool = False

    def of(self, joint: Joint) -> T:
        """Return what a joint says."""
        value: T = dict(joint.shape).get(self.name, self.default)
        return value

    def declared(self, table: Table) -> T:
        """Return what a table says; a key that must be given and is not is a fault."""
        if self.example and self.name not in table:
            table.fault(f"{self.name} is missing; write {self.example}")
        return self.read(table, self.name, self.default)


def _orientation(table: Table, name: str, default: str) -> str:
    raw = table.text(name, default)
    axes = len(raw) == 3 and all(letter in "xyz" for letter in raw) and raw[0] != raw[1] != raw[2]
    if raw != "quaternion" and not axes:
        table.fault(
            f'{name} = {show(raw)} is neither "quaternion" nor three axes of which no two neighbours are equal; '
            'write one such as "zyx" or "zxz"'
        )
        return default
    return raw


AXIS: JointKey[Vector] = JointKey("axis", Table.vector, (ZERO, ZERO, ONE))

ORIENTATION = JointKey("orientation", _orientation, "quaternion")
"""How any rotation is described: "quaternion", or three axes such as "zyx"."""

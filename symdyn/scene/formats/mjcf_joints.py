"""Joints of a compiled MuJoCo model: what they do, what resists them, and which of them follow others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symdyn.scene import folding
from symdyn.scene.formats.doubles import Doubles
from symdyn.scene.formats.turns import Step, inverse, plus, towards
from symdyn.scene.formula import quantity
from symdyn.scene.model import Pose
from symdyn.scene.quantity import NULL, ZERO, Quantity, Vector, symbol
from symdyn.scene.table import Faults, compose


class Joints:
    """The hinges and slides of a model, one table each.

    Attributes:
        followers: for each joint that follows another one, what to write under `mimic`.
        springs: names of the joints with a spring.
    """

    def __init__(self, mujoco: Any, model: Any, names: Sequence[str], doubles: Doubles, faults: Faults) -> None:
        """Refuse free and ball joints and closed loops."""
        self.mujoco, self.model, self.names = mujoco, model, names
        self.doubles, self.faults = doubles, faults
        self.springs: list[str] = []
        self.coordinates = 0
        for j, name in enumerate(names):
            self.refuse(j, name)
        self.followers = self.couplings()

    def refuse(self, j: int, name: str) -> None:
        """Report a joint that has more than one coordinate."""
        kind, kinds = self.model.jnt_type[j], self.mujoco.mjtJoint
        for which, word, advice in (
            (kinds.mjJNT_FREE, "free", "delete it to hold the body where it is"),
            (kinds.mjJNT_BALL, "ball", "write three hinges on one body in its place"),
        ):
            if kind == which:
                what = f"is a {word} joint, and {word} joints come with quaternions, which a scene does not have yet"
                self.faults.add(f"joint {name}", f"{what}; {advice}")

    def couplings(self) -> dict[int, dict[str, object]]:
        """Return the joints that linear equality constraints tie to others; refuse all other constraints."""
        model, kinds, faults = self.model, self.mujoco.mjtEq, self.faults
        found: dict[int, dict[str, object]] = {}
        for i in range(model.neq):
            where = f"equality {model.equality(i).name or i + 1}"
            follower, leader = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
            if not model.eq_active0[i] or self.off("EQUALITY"):
                faults.note(where, "is not active and left out")
            elif model.eq_type[i] != kinds.mjEQ_JOINT:
                kind = kinds(model.eq_type[i]).name.removeprefix("mjEQ_").lower()
                what = f"is a {kind} constraint, and these come with closed loops, which a scene does not have yet"
                faults.add(where, f"{what}; delete it to leave the tree open")
            elif leader < 0 or any(model.eq_data[i][2:5]) or follower in found:
                advice = "a joint1 that follows a joint2 by a polynomial a0 + a1 x is read; correct it or delete it"
                faults.add(where, f"is no linear coupling of two joints; {advice}")
            else:
                found[follower] = self.coupling(follower, leader, model.eq_data[i])
                names = f"{self.names[follower]} follows {self.names[leader]}"
                faults.note(where, f"{names} without give here; MuJoCo's constraint is soft")
        return found

    def coupling(self, follower: int, leader: int, data: Sequence[float]) -> dict[str, object]:
        """Return q₁ - ref₁ = a₀ + a₁ (q₂ - ref₂) as ratio and offset."""
        ratio = quantity(float(data[1]))
        start = folding.neg(folding.mul(ratio, self.reference(leader)))
        offset = plus(plus(self.reference(follower), start), quantity(float(data[0])))
        return {"joint": self.names[leader], "ratio": ratio, "offset": offset}

    def table(self, j: int, place: Sequence[Step]) -> dict[str, object]:
        """Return the table of a joint; `place` leads from the parent to the body frame before the joint moves."""
        model, dof, name = self.model, int(self.model.jnt_dofadr[j]), self.names[j]
        hinge = self.hinge(j)
        axis = self.doubles.direction(model.jnt_axis[j])
        x, y, z = self.doubles.vector(model.jnt_pos[j]) if hinge else NULL
        table: dict[str, object] = {
            "type": "revolute" if hinge else "prismatic",
            "axis": axis,
            "origin": merged(*place, *shift((x, y, z)), *self.back(j, axis)),
            "tip": compose(*shift((folding.neg(x), folding.neg(y), folding.neg(z)))),
        }
        for key, value in (
            ("armature", model.dof_armature[dof]),
            ("damping", 0 if self.off("DAMPER") else model.dof_damping[dof]),
            ("friction", 0 if self.off("FRICTIONLOSS") else model.dof_frictionloss[dof]),
        ):
            if value:
                table[key] = quantity(float(value))
        limits = self.limits(j)
        if limits:
            table["limits"] = limits
        for polynomial, row in (("dof_dampingpoly", dof), ("jnt_stiffnesspoly", j)):
            if any(getattr(model, polynomial)[row] if hasattr(model, polynomial) else ()):
                what = "has a spring or damper that is not linear"
                self.faults.add(f"joint {name}", f"{what}; such ones come with force elements, give one coefficient")
        if j in self.followers:
            table["mimic"] = self.followers[j]
        else:
            self.coordinates += 1
        self.spring(j, table)
        return table

    def spring(self, j: int, table: dict[str, object]) -> None:
        """Add -stiffness (q - springref) to the forces of a joint."""
        stiffness = quantity(float(self.model.jnt_stiffness[j]))
        if stiffness == ZERO or self.off("SPRING"):
            return
        if j in self.followers:
            what = "has a spring but follows another joint, and forces act on coordinates"
            self.faults.add(f"joint {self.names[j]}", f"{what}; move the spring to the joint that it follows")
            return
        rest = self.position(j, float(self.model.qpos_spring[self.model.jnt_qposadr[j]]), "springref")
        stretch = folding.sub(symbol(f"q{self.coordinates}"), rest)
        table["coordinate"] = f"q{self.coordinates}"
        table["force"] = folding.neg(folding.mul(stiffness, stretch))
        self.springs.append(self.names[j])

    def limits(self, j: int) -> dict[str, Quantity]:
        """Return range and largest force, as far as they are limited."""
        model, found = self.model, {}
        if model.jnt_limited[j]:
            for key, value in zip(("lower", "upper"), model.jnt_range[j], strict=True):
                found[key] = self.position(j, float(value), "range")
        if model.jnt_actfrclimited[j]:
            low, high = (float(x) for x in model.jnt_actfrcrange[j])
            found["effort"] = quantity(max(abs(low), abs(high)))
            if low != -high:
                what = f"actuatorfrcrange = {low:g} {high:g} is kept as one largest force, {max(abs(low), abs(high)):g}"
                self.faults.note(f"joint {self.names[j]}", what)
        return found

    def back(self, j: int, axis: Vector) -> tuple[Step, ...]:
        """Return the motion that takes the joint from position ref, where the file draws it, to position 0."""
        reference = self.reference(j)
        if reference == ZERO:
            return ()
        kind, back = "R" if self.hinge(j) else "T", folding.neg(reference)
        along = [(letter, x) for letter, x in zip("xyz", axis, strict=True) if x != ZERO]
        if len(along) == 1:
            letter, x = along[0]
            return ((f"{kind}{letter}", back if (folding.fraction(x) or 0) > 0 else reference),)
        turn = towards(axis)
        return (*turn, (f"{kind}z", back), *inverse(turn))

    def reference(self, j: int) -> Quantity:
        """Return the position of the joint in the file."""
        return self.position(j, float(self.model.qpos0[self.model.jnt_qposadr[j]]), "ref")

    def position(self, j: int, value: float, key: str) -> Quantity:
        """Return an angle or a length."""
        return self.doubles.angle(value, f"{key} of joint {self.names[j]}") if self.hinge(j) else quantity(value)

    def hinge(self, j: int) -> bool:
        """Whether a joint turns."""
        return bool(self.model.jnt_type[j] == self.mujoco.mjtJoint.mjJNT_HINGE)

    def off(self, what: str) -> bool:
        """Whether an option of the file switches something off."""
        bits = self.mujoco.mjtDisableBit
        bit = getattr(bits, f"mjDSBL_{what}", getattr(bits, "mjDSBL_PASSIVE", 0))  # one switch for two until 3.3
        return bool(self.model.opt.disableflags & int(bit))


def shift(place: Vector) -> tuple[Step, ...]:
    """Return a translation as steps."""
    x, y, z = place
    return ("Tx", x), ("Ty", y), ("Tz", z)


def merged(*steps: Step) -> Pose:
    """Return steps as a pose; translations in a row become one, and so do turns about one axis."""
    found: list[Step] = []
    for kind, amount in steps:
        if amount == ZERO:
            continue
        run = len(found)
        while run and kind[0] == "T" and found[run - 1][0][0] == "T":
            run -= 1
        run = min(run, max(len(found) - 1, 0))
        same = next((k for k in range(run, len(found)) if found[k][0] == kind), None)
        if same is None:
            found.append((kind, amount))
        else:
            found[same] = (kind, plus(found[same][1], amount))
    return compose(*found)

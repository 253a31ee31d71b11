"""Joints of a compiled MuJoCo model: what they do, what resists them, which follow others or close loops.

Tendons whose length is a sum of joint positions (fixed tendons), and what an equality of tendons says of the joints.

    length = Σ c_j q_j                             of a fixed tendon
    (L1 - L1 ref) - a0 - a1 (L2 - L2 ref) = 0      an equality, L2 left out: a1 = 0; ref: as the file draws it

so an equality of degree one is Σ k_j (q_j - q_j ref) = a0, a coupling where two or more k_j are not zero. Reference:
MuJoCo documentation, "XML Reference", tendon/fixed and equality/tendon.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symdyn.errors import listed
from symdyn.scene.formats.placing import Doubles, printable_names
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values import folding
from symdyn.scene.values.body import Pose, Step, inverse_steps, plus
from symdyn.scene.values.entry import Entry, Faults, compose
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, Quantity, Vector

ADVICE = "delete it, convert to TOML, and write there what it does: [constraints.NAME] with a formula in velocities"


class NoCouplingError(Exception):
    """Why an equality of tendons couples no joints."""


def tied(mujoco: Any, model: Any, i: int, names: Sequence[str]) -> dict[int, float]:
    """Return k_j of the joints that equality i ties, two or more.

    Raises:
        NoCouplingError: why it is no coupling.
    """
    first, second = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
    _, slope, *higher = (float(x) for x in model.eq_data[i][:5])
    if second >= 0 and any(higher):
        raise NoCouplingError(
            f"ties two tendons by a polynomial of higher degree, which is no linear coupling; {ADVICE}"
        )
    found = _coefficients(mujoco, model, first)
    for joint, x in _coefficients(mujoco, model, second).items() if second >= 0 else ():
        found[joint] = found.get(joint, 0.0) - slope * x
    found = {joint: x for joint, x in found.items() if x}
    if len(found) > 1:
        return found
    tells = f"ties {len(found)} joints ({listed(names[j] for j in found)}), and a coupling ties two or more"
    advice = "it holds this joint still: delete the joint, or lock it in TOML (locked = true)" if found else ADVICE
    raise NoCouplingError(f"{tells}; {advice}")


def _coefficients(mujoco: Any, model: Any, tendon: int) -> dict[int, float]:
    """Return how a fixed tendon's length depends on joints."""
    start = int(model.tendon_adr[tendon])
    found: dict[int, float] = {}
    for wrap in range(start, start + int(model.tendon_num[tendon])):
        if model.wrap_type[wrap] != mujoco.mjtWrap.mjWRAP_JOINT:
            name = model.tendon(tendon).name or tendon + 1
            raise NoCouplingError(
                f"the tendon {name} runs through space, and its length is no sum of joint positions; delete it, or "
                'make it a loop with a joint of type "rod" in TOML'
            )
        joint = int(model.wrap_objid[wrap])
        found[joint] = found.get(joint, 0.0) + float(model.wrap_prm[wrap])
    return found


REFUSED = {
    "armature": "a free body has no rotor; add it to the body's own mass and inertia, or set it to 0",
    "stiffness": "its torque, along the rotation vector, jumps at half a turn; write three hinges, or set it to 0",
}
"""Why what MuJoCo does at a ball or a free joint is not done here, and what would work."""


class Joints:
    """The joints of a model, one table each; what closes loops; springs at joints.

    Attributes:
        followers: for each joint that follows another one, what to write under `mimic`.
        springs: springs at joints.
        loops: what connect and weld constraints become.
    """

    def __init__(
        self,
        mujoco: Any,
        model: Any,
        names: Sequence[str],
        frames: Mapping[tuple[str, int], str],
        doubles: Doubles,
        faults: Faults,
    ) -> None:
        """Read the equality constraints; `names` are those of the joints, `frames` those of bodies and sites."""
        self.mujoco, self.model, self.names, self.frames = mujoco, model, names, frames
        self.doubles, self.faults = doubles, faults
        self.springs: list[Entry] = []
        self.loops: list[Entry] = []
        self.followers = self.couplings()

    def couplings(self) -> dict[int, dict[str, object]]:
        """Return the joints that linear equality constraints tie to others; collect the loops; refuse the rest."""
        model, kinds, faults = self.model, self.mujoco.mjtEq, self.faults
        found: dict[int, dict[str, object]] = {}
        for i in range(model.neq):
            where = f"equality {model.equality(i).name or i + 1}"
            follower, leader = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
            if not model.eq_active0[i] or self.off("EQUALITY"):
                faults.note(where, "is not active and left out")
            elif int(model.eq_type[i]) in (int(kinds.mjEQ_CONNECT), int(kinds.mjEQ_WELD)):
                self.loops.append(self.loop(i, where))
            elif model.eq_type[i] == kinds.mjEQ_TENDON:
                self.tendons(i, where, found)
            elif model.eq_type[i] != kinds.mjEQ_JOINT:
                kind = kinds(model.eq_type[i]).name.removeprefix("mjEQ_").lower()
                faults.add(where, f"is a {kind} constraint; joint, tendon, connect and weld are read; delete it")
            elif leader < 0 or any(model.eq_data[i][2:5]) or follower in found:
                advice = "a joint1 that follows a joint2 by a polynomial a0 + a1 x is read; correct it or delete it"
                faults.add(where, f"is no linear coupling of two joints; {advice}")
            else:
                a, slope = (float(x) for x in model.eq_data[i][:2])
                self.follow(follower, {leader: slope}, a, where, found)
        return found

    def tendons(self, i: int, where: str, result: dict[int, dict[str, object]]) -> None:
        """Collect an equality of fixed tendons that couples joints; the outermost follows that is free to."""
        try:
            ties = tied(self.mujoco, self.model, i, self.names)
        except NoCouplingError as reason:
            self.faults.add(where, str(reason))
            return
        follower = next((j for j in sorted(ties, reverse=True) if j not in result), None)
        if follower is None:
            names = " and ".join(self.names[j] for j in ties)
            self.faults.add(where, f"ties {names}, and each of them follows another joint already; delete one of them")
            return
        offset = float(self.model.eq_data[i][0]) / ties[follower]
        slopes = {leader: -slope / ties[follower] for leader, slope in ties.items() if leader != follower}
        self.follow(follower, slopes, offset, where, result)

    def follow(
        self, follower: int, slopes: Mapping[int, float], a: float, where: str, result: dict[int, dict[str, object]]
    ) -> None:
        """Collect the coupling q₁ - ref₁ = a + Σ a_k (q_k - ref_k) as ratios and offset, with a note."""
        ratios = {leader: quantity(slope) for leader, slope in slopes.items()}
        offset = self.reference(follower)
        for leader, ratio in ratios.items():
            offset = plus(offset, folding.neg(folding.mul(ratio, self.reference(leader))))
        names = {self.names[leader]: ratio for leader, ratio in ratios.items()}
        (one, ratio), *more = names.items()
        leads = {"ratios": names} if more else {"joint": one, "ratio": ratio}
        result[follower] = leads | {"offset": plus(offset, quantity(a))}
        told = f"{self.names[follower]} follows {listed(names)} without give here; MuJoCo's constraint is soft"
        self.faults.note(where, told)

    def loop(self, i: int, where: str) -> Entry:
        """Return a connect constraint as a spherical joint that closes a loop, a weld as a fixed one.

        Of connect, data are the anchor in body 1 and in body 2; of weld, the anchor in body 2, in body 1, and the
        rotation of body 2 in body 1 (MuJoCo, engine_core_constraint.c).
        """
        model, data = self.model, self.model.eq_data[i]
        weld = model.eq_type[i] == self.mujoco.mjtEq.mjEQ_WELD
        ends = [int(model.eq_obj1id[i]), int(model.eq_obj2id[i])]
        places: list[tuple[Step, ...]]
        if model.eq_objtype[i] == self.mujoco.mjtObj.mjOBJ_SITE:
            places = [
                (*shift(self.doubles.vector(model.site_pos[k])), *self.doubles.rotation(model.site_quat[k], where))
                for k in ends
            ]
            ends = [int(model.site_bodyid[k]) for k in ends]
        else:
            first, second = (data[3:6], data[0:3]) if weld else (data[0:3], data[3:6])
            places = [shift(self.doubles.vector(first)), shift(self.doubles.vector(second))]
            if weld:
                places[0] = (*places[0], *self.doubles.rotation(data[6:10], where))
        self.faults.note(where, "closes a loop without give here; MuJoCo's constraint is soft")
        table = {
            "type": "fixed" if weld else "spherical",
            "parent": self.frames.get(("body", ends[0]), Scene.GROUND),
            "child": self.frames.get(("body", ends[1]), Scene.GROUND),
            "origin": merged(*places[0]),
            "tip": merged(*inverse_steps(places[1])),
        }
        name = self.model.equality(i).name or f"loop{i + 1}"
        return Entry(printable_names([name], "loop")[name], table, where)

    def table(self, j: int, place: Sequence[Step]) -> dict[str, object]:
        """Return the table of a joint and collect its spring.

        Args:
            j: number of the joint.
            place: steps from the parent to the body frame before the joint moves.
        """
        model, dof, name = self.model, int(self.model.jnt_dofadr[j]), self.names[j]
        if self.several(j):
            return self.ball_or_free(j, place)
        hinge = self.hinge(j)
        axis = self.doubles.direction(model.jnt_axis[j])
        x, y, z = self.doubles.vector(model.jnt_pos[j]) if hinge else NULL
        table: dict[str, object] = {
            "type": "revolute" if hinge else "prismatic",
            "axis": axis,
            "origin": merged(*place, *shift((x, y, z)), *self.back(j, axis)),
            "tip": compose(*shift((folding.neg(x), folding.neg(y), folding.neg(z)))),
        }
        if model.dof_armature[dof]:
            table["armature"] = quantity(float(model.dof_armature[dof]))
        table |= self.losses(dof)
        limits = self.limits(j)
        if limits:
            table["limits"] = limits
        for polynomial, row in (("dof_dampingpoly", dof), ("jnt_stiffnesspoly", j)):
            if any(getattr(model, polynomial)[row] if hasattr(model, polynomial) else ()):
                what = "has a spring or damper that is not linear"
                self.faults.add(f"joint {name}", f"{what}; such ones come with force elements, give one coefficient")
        if j in self.followers:
            table["mimic"] = self.followers[j]
        self.spring(j)
        return table

    def losses(self, dof: int) -> dict[str, object]:
        """Return damping and friction of a joint, the same for all its velocities."""
        model = self.model
        damping = 0 if self.off("DAMPER") else model.dof_damping[dof]
        friction = 0 if self.off("FRICTIONLOSS") else model.dof_frictionloss[dof]
        values = {"damping": damping, "friction": friction}
        return {key: quantity(float(value)) for key, value in values.items() if value}

    def ball_or_free(self, j: int, place: Sequence[Step]) -> dict[str, object]:
        """Return the table of a joint with a quaternion; a free one starts where the file puts its body."""
        model, dof, name = self.model, int(self.model.jnt_dofadr[j]), self.names[j]
        where = f"joint {name}"
        free, armature = model.jnt_type[j] == self.mujoco.mjtJoint.mjJNT_FREE, float(model.dof_armature[dof])
        refused = {"armature": free and armature, "stiffness": not self.off("SPRING") and model.jnt_stiffness[j]}
        for key in [key for key, value in refused.items() if value]:
            kind = "free joint" if free else "ball"
            self.faults.add(where, f"{key} of a {kind} is not read: {REFUSED[key]}")
        if model.jnt_limited[j]:
            self.faults.note(where, "the limit of a joint with a quaternion is left out")
        if free:
            first = int(model.jnt_qposadr[j])
            start = [quantity(float(x)) for x in model.qpos0[first : first + 7]]
            return {"type": "free", "start": start, **self.losses(dof)}
        anchor = shift(self.doubles.vector(model.jnt_pos[j]))
        frames = {"origin": merged(*place, *anchor), "tip": merged(*inverse_steps(anchor))}
        rotor = {"armature": quantity(armature)} if armature else {}
        return {"type": "spherical", **frames, **rotor, **self.losses(dof)}

    def spring(self, j: int) -> None:
        stiffness = quantity(float(self.model.jnt_stiffness[j]))
        if stiffness == Quantity.ZERO or self.off("SPRING"):
            return
        rest = self.position(j, float(self.model.qpos_spring[self.model.jnt_qposadr[j]]), "springref")
        name = self.names[j]
        self.springs.append(Entry(name, {"joint": name, "stiffness": stiffness, "free": rest}, f"joint {name}"))

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
        kind = "revolute" if self.hinge(j) else "prismatic"
        return JOINTS[kind].held(Joint("", kind, "", "", (("axis", axis),)), folding.neg(self.reference(j)))

    def reference(self, j: int) -> Quantity:
        return self.position(j, float(self.model.qpos0[self.model.jnt_qposadr[j]]), "ref")

    def position(self, j: int, value: float, key: str) -> Quantity:
        return self.doubles.angle(value, f"{key} of joint {self.names[j]}") if self.hinge(j) else quantity(value)

    def hinge(self, j: int) -> bool:
        return bool(self.model.jnt_type[j] == self.mujoco.mjtJoint.mjJNT_HINGE)

    def several(self, j: int) -> bool:
        kinds = self.mujoco.mjtJoint
        return int(self.model.jnt_type[j]) in (int(kinds.mjJNT_FREE), int(kinds.mjJNT_BALL))

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
        if amount == Quantity.ZERO:
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

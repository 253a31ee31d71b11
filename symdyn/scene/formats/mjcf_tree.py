"""A compiled MuJoCo model as bodies, joints and points.

    pose of a body in its parent = T(pos) R(quat) · joint 1 · joint 2 · ...
    hinge                        T(anchor) R(axis, q - ref) T(-anchor)
    slide                        T(axis (q - ref))
    ball                         T(anchor) R(q) T(-anchor), q a quaternion, velocities ω in the body
    free                         T(q1 q2 q3) R(q4 q5 q6 q7) in the world, in place of pos and quat

so every joint but the last of a body carries a massless body of its own. Positions q are MuJoCo's qpos. Its
velocities qvel are ours, but for a free joint's first three: they are along the axes of the world, ours along those of
the body. Reference: MuJoCo documentation, "XML Reference" and
"Computation".
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import product
from typing import Any

from symdyn.errors import listed
from symdyn.scene.declaration.declare import Declaration
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats.inertias import WHERE as FLOATING, free_base, from_principal
from symdyn.scene.formats.mjcf_joints import Joints, merged, shift
from symdyn.scene.formats.placing import Doubles, matrix_of, printable_names
from symdyn.scene.values.entry import Entry, Faults, shorten
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.grammar import LONGEST
from symdyn.scene.values.model import Scene

NO_NAME = "MuJoCo Model"

PLANE, SPHERE, CAPSULE = 0, 2, 3
"""Types of geoms, MuJoCo's mjtGeom."""

TENDON_KEYS = ("stiffness", "damping", "frictionloss", "armature", "stiffnesspoly", "dampingpoly")


class Tree:
    """One walk over one compiled model."""

    def __init__(self, mujoco: Any, spec: Any, model: Any, faults: Faults, options: ReadOptions) -> None:
        """Give every body, joint and site a printable name."""
        self.model, self.faults, self.title = model, faults, spec.modelname
        self.declared = {body.id: body.fullinertia for body in spec.bodies}
        self.gravity_off = bool(model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY))
        self.doubles = Doubles(options.snap)
        self.frames = self.names(
            [("body", i) for i in range(1, model.nbody)] + [("site", i) for i in range(model.nsite)], "frame"
        )
        self.base = options.floating_base
        self.joint_names = self.names([("joint", j) for j in range(model.njnt)], "joint")
        self.joints = Joints(mujoco, model, list(self.joint_names.values()), self.frames, self.doubles, faults)
        self.taken = {"frame": list(self.frames.values()), "joint": list(self.joint_names.values())}

    def declaration(self, stem: str) -> Declaration:
        """Return what the model declares; what it has and a scene has not is a fault or a note."""
        self.refuse()
        self.faults.close()
        bodies: list[Entry] = []
        joints: list[Entry] = []
        for i in range(1, self.model.nbody):
            self.body(i, bodies, joints)
        if self.base is not None:
            self.set_free(self.base, joints)
        points = tuple(self.point(i) for i in range(self.model.nsite))
        self.note()
        name = stem if self.title in ("", NO_NAME) else self.title
        x, y, z = (0.0 if self.gravity_off else float(g) for g in self.model.opt.gravity)
        return Declaration(
            name=printable_names([name], "robot")[name],
            gravity=[quantity(x), quantity(y), quantity(z)],
            bodies=tuple(bodies),
            joints=tuple(joints),
            points=points,
            loops=tuple(self.joints.loops),
            elements={"springs": tuple(self.joints.springs)},
        )

    def names(self, elements: Iterable[tuple[str, int]], kind: str) -> dict[tuple[str, int], str]:
        """Return a printable name for each element; those without a name, or with one that is taken, get one."""
        given: dict[str, tuple[str, int]] = {}
        for element in elements:
            what, i = element
            name = getattr(self.model, what)(i).name or f"{what}{i + (what != 'body')}"
            while name in given:
                name += f"_{what}"
            given[name] = element
        chosen = printable_names(given, kind)
        for name, better in chosen.items():
            if name != better:
                self.faults.note(f"{given[name][0]} {shorten(name)}", f"is called {better} here")
        return {element: chosen[name] for name, element in given.items()}

    def refuse(self) -> None:
        """Report what acts on the bodies and cannot be read."""
        model, faults = self.model, self.faults
        for i in range(model.ntendon):
            if any(
                nonzero(getattr(model, f"tendon_{key}")[i]) for key in TENDON_KEYS if hasattr(model, f"tendon_{key}")
            ):
                what = "has stiffness, damping, friction or armature, and no force along a tendon is read"
                advice = (
                    'delete it, and write what it does in TOML: force = "..." of its joints, [springs] between points'
                )
                faults.add(f"tendon {model.tendon(i).name or i + 1}", f"{what}; {advice}")
        if model.opt.density or model.opt.viscosity:
            what = "density and viscosity of a fluid make MuJoCo guess drag from each body's inertia; this is not read"
            faults.add("option", f'{what}; set both to 0, and write the drag in TOML: [loads] with force = "..."')

    def note(self) -> None:
        """Note what was recognised, and what is not part of the equations."""
        model, note = self.model, self.faults.note
        if self.doubles.turned:
            note("", f"multiples of pi were recognised in {listed(self.doubles.turned)}")
        if model.ntendon:
            note("", f"tendons without stiffness and damping are left out ({model.ntendon})")
        if any(model.body_gravcomp):
            note("", "gravcomp is left out: the weight that it takes off the joints stays in the equations")
        if model.nmocap:
            note("", "mocap bodies stand still where the file puts them")
        if any(model.geom_contype) or any(model.geom_conaffinity):
            note("", "contacts are not part of the equations")
        if lines := list(self.on_floors()):
            rigid = "rigid, whatever solref and solimp say, with restitution 0 unless told"
            note("", f"the floor is left out; in TOML spheres and ends of capsules on it are [contacts], {rigid}:")
            for line in lines:
                note("", line)

    def on_floors(self) -> Iterator[str]:
        """Yield the row of [contacts] for each sphere and end of a capsule that may touch a plane of the world."""
        model, count = self.model, 0
        a, b, every = model.geom_contype, model.geom_conaffinity, range(model.ngeom)
        floors = [p for p in every if model.geom_type[p] == PLANE and not model.geom_bodyid[p]]
        for k, p in product((k for k in every if model.body_weldid[model.geom_bodyid[k]]), floors):
            half = {SPHERE: 0.0, CAPSULE: float(model.geom_size[k][1])}
            length = half.get(int(model.geom_type[k])) if a[k] & b[p] | a[p] & b[k] else None
            first = max(model.geom_priority[k], model.geom_priority[p])  # which of the two says what friction is
            says = [i for i in (k, p) if model.geom_priority[i] == first]
            mu = max(model.geom_friction[i][0] for i in says) * (max(model.geom_condim[i] for i in says) > 1)
            axis, normal = ([row[2] for row in matrix_of(model.geom_quat[i])] for i in (k, p))
            for end in () if length is None else (length, -length)[: 1 + bool(length)]:
                count, name = count + 1, self.frames["body", int(model.geom_bodyid[k])]
                at = _row(x + end * z for x, z in zip(model.geom_pos[k], axis, strict=True))
                plane = f"{{ at = {_row(model.geom_pos[p])}, normal = {_row(normal)} }}"
                place = f'type = "ball", body = "{name}", at = {at}, radius = {model.geom_size[k][0]:.9g}'
                yield f"{name}_{count} = {{ {place}, plane = {plane}, friction = {mu:.9g} }}"

    def body(self, i: int, bodies: list[Entry], joints: list[Entry]) -> None:
        """Add a body, its joints, and a massless body for every joint but the last."""
        model, name = self.model, self.frames["body", i]
        place = (
            *shift(self.doubles.vector(model.body_pos[i])),
            *self.doubles.rotation(model.body_quat[i], f"body {name}"),
        )
        parent = self.frames.get(("body", int(model.body_parentid[i])), Scene.GROUND)
        count = int(model.body_jntnum[i])
        for k in range(count):
            j = int(model.body_jntadr[i]) + k
            joint = self.joint_names["joint", j]
            child = name if k == count - 1 else self.fresh("frame", f"{name}_{joint}")
            if child != name:
                bodies.append(Entry(child, {}, f"body {name}"))
            table = {"parent": parent, "child": child, **self.joints.table(j, place)}
            joints.append(Entry(joint, table, f"joint {joint}"))
            parent, place = child, ()
        if not count:
            table = {"type": "fixed", "parent": parent, "child": name, "origin": merged(*place)}
            joints.append(Entry(self.fresh("joint", f"{name}_weld"), table, f"body {name}"))
        bodies.append(Entry(name, self.inertial(i), f"body {name}"))

    def set_free(self, name: str, joints: list[Entry]) -> None:
        """Put a free joint in the place of the weld that holds the base: the one body without joints that carries some.

        The base starts where the file puts it.
        """
        model = self.model
        roots = sorted({int(model.body_rootid[i]) for i in range(1, model.nbody) if model.body_jntnum[i]})
        bases = [i for i in roots if not model.body_jntnum[i]]
        if len(bases) != 1:
            jointed = listed(self.frames["body", i] for i in roots if model.body_jntnum[i])
            found = f"{listed(self.frames['body', i] for i in bases)} without a joint, {jointed} with joints"
            what = "the one body of the world that has no joint and carries some is set free"
            self.faults.add(FLOATING, f"{what}; here the world carries {found}")
            return
        (base,) = bases
        start = [quantity(float(x)) for x in (*model.body_pos[base], *model.body_quat[base])]
        root = self.frames["body", base]
        k = next(k for k, joint in enumerate(joints) if joint.table["child"] == root)
        joints[k] = free_base(name, root, [*joints[:k], *joints[k + 1 :]], self.faults, start)

    def fresh(self, kind: str, name: str) -> str:
        """Return a name that nothing has, for something that the file has no name for."""
        taken = self.taken[kind]
        name = name[: LONGEST - 10]
        while name in taken:
            name += "_"
        taken.append(name)
        return name

    def inertial(self, i: int) -> dict[str, object]:
        """Return mass, centre of mass and inertia of a body."""
        model = self.model
        return {
            "mass": quantity(float(model.body_mass[i])),
            "com": self.doubles.vector(model.body_ipos[i]),
            "inertia": from_principal(model.body_inertia[i], model.body_iquat[i], self.declared.get(i), self.doubles),
            "inertia_about": "com",
        }

    def point(self, i: int) -> Entry:
        model, name = self.model, self.frames["site", i]
        place = self.doubles.vector(model.site_pos[i])
        turn = self.doubles.rotation(model.site_quat[i], f"site {name}")
        carrier = self.frames.get(("body", int(model.site_bodyid[i])), Scene.GROUND)
        return Entry(name, {"body": carrier, "at": merged(*shift(place), *turn)}, f"site {name}")


def _row(values: Iterable[float]) -> str:
    return f"[{', '.join(f'{round(float(x), 12) + 0.0:.12g}' for x in values)}]"


def nonzero(value: Any) -> bool:
    """Whether a number, or any of several, is not zero."""
    return bool(any(value) if hasattr(value, "__len__") else value)

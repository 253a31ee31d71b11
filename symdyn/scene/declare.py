"""From raw tables to a checked scene: the one road that TOML files, Denavit-Hartenberg tables and Python all take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from symdyn.scene.check import Draft, check
from symdyn.scene.coupling import Mimic, couple, read_mimic
from symdyn.scene.dh import BODY_KEYS, expand
from symdyn.scene.folding import FormulaError
from symdyn.scene.formula import quantity
from symdyn.scene.joints import JOINTS
from symdyn.scene.locking import lock, read_locks
from symdyn.scene.model import STANDARD_GRAVITY, Body, Joint, Limits, Parameter, Particle, Point, Scene
from symdyn.scene.names import suggestion
from symdyn.scene.quantity import NULL, ZERO, Quantity, Vector, number
from symdyn.scene.table import Entry, Faults, Table, plain, show, vector

PARAMETER_KEYS = ("value", "positive", "unit", "latex", "text")

MOTION_KEYS = ("axis", "coordinate", "drive", "force", "mimic", "armature", "damping", "friction", "limits")

LOCK_KEYS = ("locked", "position")

JOINT_KEYS = ("type", "parent", "child", "origin", "tip", *MOTION_KEYS, *LOCK_KEYS)

LIMIT_KEYS = ("lower", "upper", "velocity", "effort")

POINT_KEYS = ("body", "at")

INERTIA_KEYS = ("xx", "yy", "zz", "xy", "xz", "yz")

Z_AXIS: Vector = (ZERO, ZERO, number(1))


@dataclass(frozen=True)
class Declaration:
    """A scene as raw as the user wrote it.

    Attributes:
        name: of the scene.
        gravity: raw value; None for the standard 9.81 m/s^2 along -z, False or "none" for no gravity.
        parameters, bodies, joints, points: declared tables.
        dh: a Denavit-Hartenberg table.
    """

    name: str
    gravity: object = None
    parameters: tuple[Entry, ...] = ()
    bodies: tuple[Entry, ...] = ()
    joints: tuple[Entry, ...] = ()
    points: tuple[Entry, ...] = ()
    dh: Entry | None = None


def assemble(declaration: Declaration, source: str, faults: Faults, allow_invalid_inertia: bool = False) -> Scene:
    """Return the checked scene, joints sorted parents first.

    Args:
        declaration: what the user wrote.
        source: where it was written, for messages.
        faults: faults found so far.
        allow_invalid_inertia: let every body pass whose inertia no body has, with a note in `faults` for each.

    Raises:
        SceneError: with every fault of the declaration, one line each.
    """
    bodies, joints = list(declaration.bodies), list(declaration.joints)
    if declaration.dh is not None:
        more_bodies, more_joints = expand(declaration.dh, faults)
        bodies, joints = bodies + more_bodies, joints + more_joints
    joints = _parents_first(joints)
    scene = Scene(
        name=declaration.name,
        parameters=tuple(_parameter(entry, faults) for entry in declaration.parameters),
        gravity=_gravity(declaration.gravity, faults),
        bodies=tuple(_body(entry, faults) for entry in bodies),
        joints=_joints(joints, faults),
        points=tuple(_point(entry, faults) for entry in declaration.points),
        source=source,
    )
    places = {"parameters": declaration.parameters, "bodies": bodies, "joints": joints, "points": declaration.points}
    draft = Draft(scene, {kind: tuple(entry.where for entry in entries) for kind, entries in places.items()})
    positions = read_locks(joints, faults)
    excused = check(draft, faults, allow_invalid_inertia)
    faults.close()
    carried = {body.name: body for body in scene.bodies}
    carried |= {name: replace(carried[name], allow_invalid_inertia=True) for name in excused}
    ordered = replace(scene, bodies=tuple(carried[joint.child] for joint in scene.joints))
    return lock(ordered, positions, faults) if positions else ordered


def _parents_first(joints: Sequence[Entry]) -> list[Entry]:
    """Return the joints in declared order, each after the joint that carries its parent; cycles stay as they are."""
    carrier = {str(entry.table.get("child")): entry for entry in reversed(joints)}
    placed: dict[int, Entry] = {}
    for entry in joints:
        path: dict[int, Entry] = {}
        step: Entry | None = entry
        while step is not None and id(step) not in placed and id(step) not in path:
            path[id(step)] = step
            step = carrier.get(str(step.table.get("parent")))
        placed.update(reversed(path.items()))
    return list(placed.values())


def _gravity(raw: object, faults: Faults) -> Vector:
    if raw is None:
        return STANDARD_GRAVITY
    if raw is False or (isinstance(raw, str) and raw == "none"):
        return NULL
    advice = 'give a vector such as [0, 0, -9.81], or "none"'
    if raw is True or isinstance(raw, str):
        faults.add("", f"gravity = {show(raw)} is not a vector; {advice}")
        return NULL
    return Table(Entry("", {"gravity": raw}, ""), faults, ("gravity",)).vector("gravity")


def _parameter(entry: Entry, faults: Faults) -> Parameter:
    table = Table(entry, faults, PARAMETER_KEYS)
    return Parameter(
        name=entry.name,
        value=table.quantity("value") if "value" in table else None,
        positive=table.flag("positive"),
        unit=table.text("unit"),
        latex=table.text("latex") if "latex" in table else None,
        text=table.text("text"),
    )


def _body(entry: Entry, faults: Faults) -> Body:
    table = Table(entry, faults, BODY_KEYS if not entry.where.startswith("dh.") else tuple(entry.table))
    about = table.text("inertia_about", "frame" if "first_moment" in table else "com")
    if about not in ("com", "frame"):
        table.fault(f'inertia_about = "{about}" is not known; write "com" or "frame"')
    elif "inertia" in table and "inertia_about" not in table:
        table.fault('inertia_about is missing; write "com" (centre of mass) or "frame" (origin of the body frame)')
    if "first_moment" in table:
        if "com" in table:
            table.fault("com and first_moment say the same thing twice; give one of them")
        if about == "com":
            table.fault(
                'first_moment goes with inertia_about = "frame"; give com instead, or the inertia about the frame'
            )
    return Body(
        name=entry.name,
        mass=table.quantity("mass"),
        com=None if "first_moment" in table else table.vector("com"),
        first_moment=table.vector("first_moment") if "first_moment" in table else None,
        inertia=_inertia(table),
        about=about,
        particles=_particles(table, faults),
        allow_invalid_inertia=table.flag("allow_invalid_inertia"),
    )


def _inertia(table: Table) -> tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]:
    """Return (xx, yy, zz, xy, xz, yz) from a diagonal, a table of entries or a symmetric matrix."""
    nothing = (ZERO,) * 6
    raw = plain(table.raw.get("inertia", (0, 0, 0)))
    try:
        if isinstance(raw, Mapping):
            for key in raw:
                if key not in INERTIA_KEYS:
                    raise FormulaError(f"has an unknown key {show(str(key))}; {suggestion(str(key), INERTIA_KEYS)}")
            xx, yy, zz, xy, xz, yz = (quantity(raw.get(key, 0)) for key in INERTIA_KEYS)
            return xx, yy, zz, xy, xz, yz
        if not isinstance(raw, (list, tuple)) or len(raw) != 3:
            raise FormulaError("is neither [xx, yy, zz] nor a table { xx = 1, yy = 1, zz = 1, xy = 0, xz = 0, yz = 0 }")
        if not any(isinstance(row, (list, tuple)) for row in raw):
            return (*vector(raw), ZERO, ZERO, ZERO)
        rows = [vector(row) for row in raw]
        if any(rows[i][j] != rows[j][i] for i in range(3) for j in range(i)):
            raise FormulaError("is not symmetric; entry [i][j] must equal entry [j][i]")
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = rows
    except FormulaError as error:
        table.refuse("inertia", error)
        return nothing
    return xx, yy, zz, xy, xz, yz


def _particles(table: Table, faults: Faults) -> tuple[Particle, ...]:
    raw = table.raw.get("particles", ())
    advice = 'give a list such as [{ mass = "m1", at = [0, 0, 0] }]'
    if not isinstance(raw, (list, tuple)):
        table.fault(f"particles = {show(raw)} is not a list; {advice}")
        return ()
    particles = []
    for k, item in enumerate(raw):
        if isinstance(item, Particle):
            particles.append(item)
            continue
        if not isinstance(item, Mapping):
            table.fault(f"particles[{k}] = {show(item)} is not a table; {advice}")
            continue
        row = Table(Entry("", item, f"{table.entry.where}: particles[{k}]"), faults, ("mass", "at"))
        for key in ("mass", "at"):
            if key not in row:
                row.fault(f"{key} is missing; {advice}")
        particles.append(Particle(row.quantity("mass"), row.vector("at")))
    return tuple(particles)


def _joints(entries: Sequence[Entry], faults: Faults) -> tuple[Joint, ...]:
    tables = [Table(entry, faults, JOINT_KEYS) for entry in entries]
    joints: list[Joint] = []
    mimics: list[Mimic | None] = []
    moving = 0
    for table in tables:
        kind = _joint_type(table)
        mimics.append(read_mimic(table) if kind != "fixed" else None)
        joints.append(_joint(table, kind, moving + 1, mimics[-1] is not None))
        moving += bool(joints[-1].coordinate)
    return couple(joints, mimics, tables)


def _joint_type(table: Table) -> str:
    """Return a key of `JOINTS`; "revolute" stands in for what is none."""
    kind = table.required("type", f"write one of {', '.join(JOINTS)}")
    if kind and kind not in JOINTS:
        table.fault(f'type = "{kind}" is not a joint; {suggestion(kind, JOINTS)} (there are {", ".join(JOINTS)})')
    return kind if kind in JOINTS else "revolute"


def _joint(table: Table, kind: str, k: int, follows: bool) -> Joint:
    """Return a joint; if it has a coordinate, it is the k-th that does, which names coordinate and drive by default."""
    if kind == "fixed":
        _refuse(table, (*MOTION_KEYS, *LOCK_KEYS), "a fixed joint")
    elif follows:
        _refuse(table, ("coordinate", "drive", "force", *LOCK_KEYS), "a joint that follows another one")
    free = kind != "fixed" and not follows
    return Joint(
        name=table.entry.name,
        type=kind,
        parent=table.required("parent", 'write the body that carries it, or "ground"'),
        child=table.required("child", "write the body that it carries"),
        axis=table.vector("axis", Z_AXIS),
        origin=table.pose("origin"),
        tip=table.pose("tip"),
        coordinates=((table.text("coordinate", f"q{k}") or f"q{k}"),) if free else (),
        drives=(_drive(table, f"tau{k}"),) if free else (),
        forces=(table.quantity("force"),) if "force" in table else (),
        armature=table.quantity("armature"),
        damping=table.quantity("damping"),
        friction=table.quantity("friction"),
        limits=_limits(table),
    )


def _refuse(table: Table, keys: Sequence[str], what: str) -> None:
    for key in keys:
        if key in table and not (key == "drive" and table.raw[key] is False):
            table.fault(f"{key} = {show(table.raw[key])} has no meaning for {what}; leave it out")


def _limits(table: Table) -> Limits:
    if "limits" not in table:
        return Limits()
    inner = table.inner("limits", LIMIT_KEYS, "write limits = { lower = -1, upper = 1, velocity = 2, effort = 50 }")
    return Limits(*(inner.quantity(key) if inner.raw.get(key) is not None else None for key in LIMIT_KEYS))


def _drive(table: Table, default: str) -> str | None:
    raw = table.raw.get("drive", True)
    if raw is False:
        return None
    return default if raw is True else table.text("drive", default)


def _point(entry: Entry, faults: Faults) -> Point:
    table = Table(entry, faults, POINT_KEYS)
    return Point(entry.name, table.required("body", "write the body that carries the point"), table.pose("at"))

"""Denavit-Hartenberg tables: a compact way to write a chain of joints.

    standard   A_i = Rz(θ) Tz(d) Tx(a) Rx(α)                 link frame at the far end of its link
    modified   A_i = Rx(α) Tx(a) Rz(θ) Tz(d)                 a, α of row i are the book's a_(i-1), α_(i-1) (Craig)

The joint moves along or about its z axis: θ = theta + q for a revolute joint, d = d + q for a prismatic one, so theta
or d in a row is the offset of the coordinate. Rotation and shift along one axis commute, so both stand in the origin;
Tx(a) Rx(α) of a standard table is the tip. Body frames are the link frames of the table.
"""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.scene.values.entry import Entry, EntryReader, Faults, compose, plain, show
from symdyn.scene.values.model import Scene

CONVENTIONS = ("standard", "modified")

TABLE_KEYS = ("convention", "parent", "links")

BODY_KEYS = ("mass", "com", "first_moment", "inertia", "inertia_about", "particles", "allow_invalid_inertia", "shape")

JOINT_KEYS = (
    *("type", "pitch", "coordinate", "coordinates", "drive", "drives", "force", "forces", "mimic", "armature", "rotor"),
    *("damping", "friction", "limits", "start", "start_rates", "motion", "locked", "position"),
)

LINK_KEYS = ("name", "theta", "d", "a", "alpha", *JOINT_KEYS, *BODY_KEYS)


def expand(entry: Entry, faults: Faults) -> tuple[list[Entry], list[Entry]]:
    """Return the bodies and joints that a table `dh` stands for; faults are collected."""
    table = EntryReader(entry, faults, TABLE_KEYS)
    convention = table.required("convention", f'write convention = "{CONVENTIONS[0]}" or "{CONVENTIONS[1]}"')
    if convention and convention not in CONVENTIONS:
        table.fault(f'convention = "{convention}" is not known; write "{CONVENTIONS[0]}" or "{CONVENTIONS[1]}"')
    faults.nameless(entry.where, "convention", convention)
    parent = table.text("parent", Scene.GROUND)
    rows = plain(entry.table.get("links", ()))
    if not isinstance(rows, (list, tuple)) or not rows:
        table.fault("links is no list of rows; write one [[dh.links]] for each joint")
        return [], []
    bodies, joints = [], []
    for k, row in enumerate(rows, start=1):
        if not isinstance(row, Mapping):
            table.fault(f"links: row {k} = {show(row)} is not a table; give theta, d, a and alpha")
            continue
        named = row.get("name", f"link{k}")
        link = Entry(named if isinstance(named, str) else f"link{k}", row, f"dh.links.{named}")
        body, joint = _link(link, k, parent, convention, faults)
        bodies.append(body)
        joints.append(joint)
        parent = link.name
    return bodies, joints


def _link(link: Entry, k: int, parent: str, convention: str, faults: Faults) -> tuple[Entry, Entry]:
    table = EntryReader(link, faults, LINK_KEYS)
    table.text("name", link.name)
    turn, shift = ("Rz", table.quantity("theta")), ("Tz", table.quantity("d"))
    length, twist = ("Tx", table.quantity("a")), ("Rx", table.quantity("alpha"))
    standard = convention != "modified"
    joint: dict[str, object] = {"type": "revolute", "parent": parent, "child": link.name}
    joint |= {key: link.table[key] for key in JOINT_KEYS if key in link.table}
    joint["origin"] = compose(turn, shift) if standard else compose(twist, length, turn, shift)
    joint["tip"] = compose(length, twist) if standard else compose()
    body = {key: link.table[key] for key in BODY_KEYS if key in link.table}
    return Entry(link.name, body, link.where), Entry(f"joint{k}", joint, link.where)

"""Families of mechanisms, one function each: it draws bodies and joints, and returns where the mechanism starts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..mechanism import Array
from ..states import assemble
from .scenes import ANGLES, AXES, IN_PLANE, IN_SPACE, STRAIGHT, TREE, Drawing, Undrawable


def tree(d: Drawing) -> Array:
    """A tree of joints of every type."""
    for k in range(d.rng.randint(1, 4)):
        d.joint(d.rng.choice(TREE) if k else d.rng.choice(TREE[:-2]), parent(d), d.body(f"b{k + 1}"))
    return d.first()


def coupled(d: Drawing) -> Array:
    """A tree of which some joints follow others, with rotors."""
    for k in range(d.rng.randint(2, 4)):
        kind = d.rng.choice(("revolute", "revolute", "prismatic", "helical", "cylindrical" if k == 0 else "revolute"))
        more: dict[str, Any] = {}
        if kind != "cylindrical" and k and d.rng.random() < 0.6:
            leader = d.rng.choice([n for j in d.tables["joints"].values() for n in j.get("coordinates", [])])
            more = {"mimic": {"coordinate": leader, "ratio": d.small(), "offset": d.small()}}
        name = d.joint(kind, parent(d), d.body(f"b{k + 1}"), **more)
        if kind != "cylindrical" and d.rng.random() < 0.7:
            d.tables["joints"][name]["armature"] = d.positive()
    return d.first()


def parent(d: Drawing) -> str:
    """Return a body to go on from, the last ones preferred."""
    return d.rng.choice(["ground", *d.tables["bodies"], *list(d.tables["bodies"])[-2:]])


def space(d: Drawing) -> Array:
    """A closed mechanism in space: a tree with freedoms enough, and one or two joints that close it."""
    kinds = ["revolute", "revolute", "prismatic", "spherical", "universal", "cylindrical", "revolute", "free", "rod"]
    for k in range(d.rng.randint(2, 4)):
        d.joint(d.rng.choice(kinds), parent(d) if k > 1 else "ground" if k == 0 else "b1", d.body(f"b{k + 1}"))
    q = d.first()
    for _ in range(d.rng.choice([1, 1, 1, 2])):
        close(d, d.rng.choice(IN_SPACE), q)
    return q


def planar(d: Drawing) -> Array:
    """A mechanism that moves in one oblique plane, closed by joints that lie anyhow."""
    base = [["Rx", d.rng.choice(ANGLES)], ["Ry", d.rng.choice(ANGLES)]] if d.rng.random() < 0.6 else []
    for k in range(d.rng.randint(2, 4)):
        kind = d.rng.choice(["revolute", "revolute", "revolute", "prismatic", "planar"] if k < 3 else ["revolute"])
        axis = [0, 0, 1] if kind != "prismatic" else d.rng.choice([[1, 0, 0], [0, 1, 0], [1, 2, 0]])
        on = parent(d) if k > 1 else "ground"
        shifts = [[step, d.small()] for step in ("Tx", "Ty", "Tz")] + [["Rz", d.rng.choice(ANGLES)]]
        tip = [["Tx", d.small()]]
        d.joint(kind, on, d.body(f"b{k + 1}"), origin=(base if on == "ground" else []) + shifts, axis=axis, tip=tip)
    if d.rng.random() < 0.5:
        d.gravity = [0, -9.81, 0]
    q = d.first()
    for _ in range(d.rng.choice([1, 1, 2])):
        kind = d.rng.choice(IN_PLANE)
        flat = kind in ("revolute", "cylindrical", "prismatic") or d.rng.random() < 0.3
        close(d, kind, q, base, flat)
    return q


def close(d: Drawing, kind: str, q: Array, base: list[Any] | None = None, flat: bool = False) -> None:
    """Close a loop between two bodies; a flat one by a joint whose axis is that of the plane, or lies in it."""
    first, second = d.rng.sample(["ground", *d.tables["bodies"]], 2)
    more: dict[str, Any] = {}
    if flat:
        if kind not in STRAIGHT:
            more["axis"] = [1, 0, 0] if kind == "prismatic" else [0, 0, 1]
        shifts = [["Tx", d.small()], ["Ty", d.small()], ["Tz", d.small()]]
        more["origin"] = (base or [] if first == "ground" else []) + shifts
    d.close(kind, first, second, q, **more)


def wheels(d: Drawing) -> Array:
    """Discs, balls and wheels that roll: on the ground, on a slope, on a plate that moves; carts and bicycles."""
    return d.rng.choice([disc, disc, cart, bicycle])(d)


def disc(d: Drawing) -> Array:
    """A disc or a ball that flies but for its contact, perhaps with a pendulum, perhaps on a plate."""
    on_plate = d.rng.random() < 0.3
    if on_plate:
        d.joint(d.rng.choice(["revolute", "prismatic"]), "ground", d.body("plate"), tip=[])
    orientation = d.rng.choice(["quaternion", "zxy", "zxz", "yxz"])
    d.joint("free", "ground", d.body("b1"), origin=[], tip=[], orientation=orientation)
    if d.rng.random() < 0.3:
        d.joint("revolute", "b1", d.body("b2"))
    row = wheel(d, "b1")
    if on_plate or d.rng.random() < 0.4:
        row.pop("normal")
        row["plane"] = {"body": "plate" if on_plate else "ground", "at": d.place(), "normal": d.rng.choice(AXES)}
    if d.rng.random() < 0.3:
        row.pop("axis")  # a ball; its two ways in the plane are no names for directions
        row["components"] = ["along", "across", *(["normal"] if "normal" in row["components"] else [])]
    d.tables["constraints"] = {"contact": row}
    q = d.first()
    yaw, lean, spin = (0.0, 0.0, 0.0) if d.natural else [d.rng.uniform(-1, 1) for _ in range(3)]
    first = int(on_plate) + 3
    q[first - 1] = 0.8
    if orientation == "quaternion":
        e = np.array([1, lean / 2, spin / 2, yaw / 2])
        q[first : first + 4] = e / np.linalg.norm(e)
    else:
        q[first : first + 3] = [yaw, lean, spin]
    return touching(d, q)


def cart(d: Drawing) -> Array:
    """A cart that slides or moves in the plane, with one or two wheels on an axle."""
    kind = d.rng.choice(["prismatic", "planar", "planar"])
    axis = [1, 0, 0] if kind == "prismatic" else [0, 0, 1]
    d.joint(kind, "ground", d.body("b1"), origin=[["Tz", 0.4]], axis=axis, tip=[])
    d.tables["constraints"] = {}
    for k in range(d.rng.randint(1, 2)):
        origin = [["Ty", (-1) ** k * 0.5], ["Tx", d.small()]]
        d.joint("revolute", "b1", d.body(f"b{k + 2}"), origin=origin, axis=[0, 1, 0], tip=[])
        d.tables["constraints"][f"wheel{k + 1}"] = {**wheel(d, f"b{k + 2}"), "axis": [0, 1, 0], "radius": 0.4}
    return touching(d, d.first())


def bicycle(d: Drawing) -> Array:
    """A frame that is a wheel itself, a fork that steers, a wheel in it."""
    d.joint("free", "ground", d.body("b1"), origin=[], tip=[], orientation=d.rng.choice(["quaternion", "zxy"]))
    d.joint("revolute", "b1", d.body("b2"), origin=[["Ry", 0.3]], axis=[0, 0, 1], tip=[])
    d.joint("revolute", "b2", d.body("b3"), origin=[["Tx", 1]], axis=[0, 1, 0], tip=[])
    d.tables["constraints"] = {
        "front": {**wheel(d, "b3"), "axis": [0, 1, 0]},
        "rear": {**wheel(d, "b1"), "axis": [0, 1, 0]},
    }
    q = d.first()
    angles = [1, 0.1, 0.05, 0.3] if len(q) == 9 else [0.3, 0.1, 0.2]
    if d.natural:
        angles = [1, 0, 0, 0] if len(q) == 9 else [0, 0, 0]
    q[3 : 3 + len(angles)] = angles
    return touching(d, q)


def wheel(d: Drawing, body: str) -> dict[str, Any]:
    """Return a row of a wheel on level ground."""
    some = [["along", "across"], ["along", "across", "normal"], ["normal"], ["across"], ["along", "normal"]]
    components = d.rng.choice(some[:2] + some)
    return {
        "type": "rolling", "body": body, "at": [0, 0, 0], "axis": d.rng.choice([[0, 1, 0], [0, 1, 0], [0, 3, 4]]),
        "radius": d.positive(0.2, 0.6), "components": components, "normal": [0, 0, 1],
    }  # fmt: skip


def touching(d: Drawing, q: Array) -> Array:
    """Return a start near q at which wheels touch the ground."""
    m = d.mechanism()
    q = q.copy()
    i = 0
    for joint in m.scene.moving:
        i += len(joint.coordinates)
        if len(joint.coordinates) > len(joint.rates):
            q[i - 4 : i] /= np.linalg.norm(q[i - 4 : i])
    found = assemble(m, q)
    if found is None:
        raise Undrawable
    return found


def blades(d: Drawing) -> Array:
    """Sleds and skates on knife edges, and trees with formulas in velocities."""
    if d.rng.random() < 0.5:
        kind = d.rng.choice(["planar", "planar", "free", "point_on_plane"])
        d.joint(kind, "ground", d.body("b1"), axis=[0, 0, 1]) if kind != "free" else d.joint(
            kind, "ground", d.body("b1")
        )
        if d.rng.random() < 0.6:
            d.joint("revolute", "b1", d.body("b2"), axis=d.rng.choice([[0, 0, 1], [1, 2, 3]]))
        blade = {"type": "knife_edge", "body": d.rng.choice(list(d.tables["bodies"])), "at": d.place()}
        d.tables["constraints"] = {
            "skate": blade | {"axis": d.rng.choice([[0, 1, 0], [1, 0, 0], [1, 2, 0], [1, 2, 3]])}
        }
    else:
        for k in range(d.rng.randint(2, 4)):
            d.joint(d.rng.choice(["revolute", "prismatic", "universal", "planar"]), parent(d), d.body(f"b{k + 1}"))
        names = [n for j in d.tables["joints"].values() for n in j["coordinates"]]
        if len(names) < 3:
            raise Undrawable
        a, b, c = d.rng.sample(names, 3)
        formulas = [
            f"{a}_dot - {d.positive()}*{b}_dot",
            f"{a}_dot*cos({c}) + 0.5*{c}*{b}_dot",
            f"{a}_dot - {b}_dot*{a}",
        ]
        d.tables["constraints"] = {"row": {"formula": d.rng.choice(formulas), "acts_in": "joints"}}
    return d.first()


FAMILIES: Mapping[str, Callable[[Drawing], Array]] = {
    "tree": tree, "coupled": coupled, "planar": planar, "space": space, "wheels": wheels, "blades": blades,
}  # fmt: skip

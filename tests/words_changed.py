"""Every word of a scene's file with two values: a row is a word by its path, and makes two scenes that differ in it."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from typing import Any

from fuzz.mutate import toml

from symdyn.scene.declaration.declare import schema
from symdyn.scene.forces.force_table import sections

PIN: dict[str, Any] = {"type": "revolute", "parent": "cart", "child": "arm", "axis": [1, 2, 2], "origin": [0.1, 0, 0.2]}
PIN["drive"] = False
TURNING = {"inertia": [0.3, 0.2, 0.1], "inertia_about": "com"}

BASE: dict[str, Any] = {
    "name": "base",
    "parameters": {
        "k": {"value": 3, "unit": "N m s"},
        "r": 0.5,
        "M0": {"value": 2, "unit": "N m"},
        "w": {"value": 1, "unit": "rad/s"},
    },
    "bodies": {
        "cart": {"mass": 2, "com": [0.1, 0, 0.2], **TURNING},
        "arm": {"mass": 1, "com": [0.1, 0.2, 0.3], **TURNING},
    },
    "joints": {
        "rail": {"type": "prismatic", "parent": "ground", "child": "cart", "axis": [1, 0, 0], "start_rates": 0.7},
        "pin": PIN,
    },
}
"""A cart with an arm, whose joint `pin` may be of any type."""

ABSENT = None

Row = tuple[tuple[str, ...], Any, Any, Mapping[str, Any]]


def row(path: str, one: Any, other: Any = ABSENT, **beside: Any) -> Row:
    """Return a word by its path with two values, and what the scene says beside, by paths with __ for strokes."""
    return tuple(path.split("/")), one, other, beside


def of(kind: str, **keys: Any) -> dict[str, Any]:
    """Return the joint `pin` as one of another type."""
    beside = {key: value for key, value in PIN.items() if key not in ("axis", "type")}
    return {"joints__pin": {**beside, "type": kind, **keys}}


JUMP: dict[str, object] = {
    "states__s": {"rate": 1, "reset": {"when": "s - 0.1"}},
    "joints__pin__force": "s",
}
TIP = {"points__tip": {"body": "arm", "at": [0.2, 0.3, 0.1]}}
COIL = {"springs__coil": {"from": "tip", "to": "ground", "stiffness": 5, "free": 0.3}, **TIP}
CURVE = {"joints__pin__force": 'table("curve", q1)', "tables__curve": {"points": [[0, 0], [0.3, 5], [1, 3]]}}
SHOCK = {"dampers__shock": {"from": "tip", "to": "ground", "damping": 5}, **TIP}
STRUCK: dict[str, object] = {"type": "gap", "gap": "0.1 - q1", "tangent": "r*q2_dot", "friction": 0.1}
HIT: dict[str, object] = {"contacts__hit": STRUCK, "joints__pin__start_rates": 1}
STUCK: dict[str, object] = {
    "contacts__hit": {**STRUCK, "gap": "-q1", "friction": 0.01},
    "joints__rail__start_rates": 0,
    "joints__rail__force": 30,
    "joints__pin__force": "2*t",
}
BOUNCED: dict[str, object] = {**HIT, "contacts__hit": {**STRUCK, "friction": 5, "restitution": 0.5}}
UNDER = {"at": [0, 0, -0.2], "normal": [0, 0, 1]}
STEEP = {"at": [0, 0, -0.2], "normal": [0.5, 0, 1]}
SPUN: dict[str, object] = {"joints__pin__start_rates": 1}
FALL: dict[str, object] = {"contacts__hit": {"body": "arm", "plane": UNDER}, **SPUN}
ROLL: dict[str, object] = {"contacts__hit": {"type": "ball", "body": "arm", "radius": 0.1, "plane": UNDER}}
RIM: dict[str, object] = {"contacts__hit": {"type": "wheel", "body": "arm", "radius": 0.1, "plane": UNDER}, **SPUN}
POINTED: dict[str, object] = {"contacts__hit": {"plane": UNDER}, **TIP, "points__hub": {"body": "arm"}}
LEAKS: dict[str, object] = {
    "states__filled": {"rate": -0.3, "start": 2, "unit": "kg"},
    "bodies__arm__mass": "filled",
    "joints__pin__start_rates": 1,
}
OUT = {"velocity": [1, 2, 3]}
JET: dict[str, object] = {**LEAKS, "flows__jet": {"body": "arm", "at": [0, 0, 1], "velocity": [1, 2, 3]}}
JETS: dict[str, object] = {**JET, "flows__other": {"body": "arm", "at": [0, 1, 1], "velocity": [3, 0, 1]}}
PUSH = {"loads__push": {"body": "arm", "at": [0, 0, 1], "force": [1, 2, 3]}, **TIP}
FREE = of("free", parent="ground", start_rates=[0.5, 0, 0, 0, 1, 0.3])
WHEEL = {
    **FREE,
    "constraints__wheel": {"type": "rolling", "body": "arm", "axis": [0, 1, 0], "radius": 0.5},
    "points__hub": {"body": "arm", "at": [0, 0.3, 0]},
    "points__rim": {"body": "cart", "at": [0, 0, 0.1]},
}
LEVEL = {"constraints__wheel__plane": {"normal": [0, 0, 1]}}
RAISED = {"constraints__wheel__plane": {"at": [0, 0, 0.1]}}
PULLED = {"ropes__hoist": {"type": "elastic", "through": ["tip", "ground"], "stiffness": 5}, **TIP}
HOIST = {"ropes__hoist": {"through": ["tip", "ground"], "length": 0.7}, **TIP}
SNAPPED = {"ropes__hoist": {"type": "slack", "through": ["tip", "ground"], "length": 0.7}, **TIP, **SPUN}
OVER = {"body": "ground", "at": [0, 0, 1], "radius": 0.1, "axis": [0, 1, 0], "turn": "left"}
LED = {"ropes__hoist": {"length": 2, "through": ["cart", OVER, {"body": "ground", "at": [1, 0, 0]}]}}
SLED = {**FREE, "constraints__blade": {"type": "knife_edge", "body": "arm", "axis": [0, 1, 0]}, **TIP}


def ring(kind: str, **keys: Any) -> dict[str, Any]:
    """Return a loop around an arm that is free but for it."""
    return {**FREE, "loop": [{"name": "ring", "type": kind, "parent": "arm", "child": "ground", **keys}]}


RING = ring("spherical")
DH = {
    "convention": "standard",
    "parent": "arm",
    "links": [{"a": 0.5, "alpha": 0.7, "mass": 2, "com": [0.1, 0, 0.2], **TURNING}, {"a": 0.3, "mass": 1}],
}

ROLLING = {"type": "rolling", "axis": [0, 1, 0], "radius": 0.5}
ABOUT_FRAME = {"mass": 1, "inertia": [3, 2, 2], "inertia_about": "frame"}
MATRIX = {"xx": 3, "yy": 3, "zz": 3}
FOOT = {
    "bodies__foot": {"mass": 1},
    "joints__foot": {"type": "prismatic", "parent": "cart", "child": "foot", "axis": [0, 0, 1], "coordinate": "q3"},
}
PINION = {
    "bodies__foot": {"inertia": [1, 1, 1], "inertia_about": "com"},
    "joints__foot": {"type": "revolute", "parent": "cart", "child": "foot", "coordinate": "q3"},
}
PLACES, TWO = ("origin", "tip", "child_origin"), ([0, 0, 1], [0, 1, 0])
HUB = {"points__hub": {"body": "cart", "at": [0, 0, 1]}}
ENDS = [
    (place, end, {**said, **HUB, f"{place.replace('/', '__')}__{other}": "ground"})
    for place, said in (("springs/coil", COIL), ("dampers/shock", SHOCK))
    for end, other in (("from", "to"), ("to", "from"))
]
"""Ends of springs and dampers, whose other end is the ground."""


def on_arm(place: str, end: str) -> dict[str, Any]:
    """Return an end that is at the arm."""
    return {f"{place.replace('/', '__')}__{end}": {"body": "arm"}}


def turned(place: str, word: str) -> dict[str, Any]:
    """Return the other half of a placement of the joint."""
    return {f"joints__pin__{place}": {word: [0, 0, 1]}}


WORDS: tuple[Row, ...] = (
    row("name", "base", "other"),
    row("gravity", [0, 0, -9.81], [0, 0, -1]),
    row("parameters/k/value", 3, 4, joints__pin__damping="k"),
    row("parameters/k/positive", True, False, joints__pin__damping="k"),
    row("parameters/k/unit", "N m s", "N mm s", joints__pin__damping="k"),
    row("parameters/k/tolerance", 0.1, 0.2),
    row("parameters/k/latex", r"\kappa", ABSENT, joints__pin__damping="k"),
    row("parameters/k/text", "of a spring", ABSENT),
    row("bodies/arm/mass", 1, 2),
    row("bodies/arm/com", [0.1, 0.2, 0.3], [0.1, 0.2, 0.4]),
    row("bodies/arm/first_moment", [0.1, 0, 0], [0.2, 0, 0], bodies__arm=ABOUT_FRAME),
    row("bodies/arm/inertia", [0.3, 0.2, 0.1], [0.3, 0.3, 0.1]),
    row("bodies/arm/inertia_about", "com", "frame", bodies__arm__inertia=[3, 2, 2]),
    row("bodies/arm/particles", [{"mass": 1, "at": [0, 0, 1]}], [{"mass": 1, "at": [0, 0, 2]}]),
    row("bodies/arm/shape", "ball", {"type": "disc", "radius": 0.7}),
    row("joints/pin/type", "revolute", "cylindrical"),
    row("joints/pin/parent", "cart", "ground"),
    row("joints/pin/origin", [0, 0, 1], [0, 0, 2], joints__pin__axis=[0, 1, 1]),
    row("joints/pin/tip", [0, 0, 1], [0, 0, 2]),
    row("joints/pin/child_origin", [0, 0, 1], [0, 0, 2]),
    row("joints/pin/axis", [0, 1, 0], [0, 1, 1]),
    row("joints/pin/pitch", 0.1, 0.2, **of("helical", axis=[1, 0, 0])),
    row("joints/pin/second_axis", [0, 1, 0], [0, 1, 1], **of("universal", axis=[1, 0, 0])),
    row("joints/pin/orientation", "quaternion", "zyx", **of("spherical")),
    row("joints/pin/length", 0.5, 0.7, **of("rod")),
    row("joints/pin/steps", [["Rz", "u"]], [["Rx", "u"]], **of("custom", units=["rad"], coordinate="u")),
    row("joints/pin/units", ["rad"], ["m"], **of("custom", steps=[["Tz", "u**2"]], coordinate="u"), units="none"),
    row("joints/pin/coordinate", "phi", "psi"),
    row("joints/pin/coordinates", ["phi"], ["psi"]),
    row("joints/pin/drive", "M", False),
    row("joints/pin/drives", ["M"], [False], joints__pin__drive=None),
    row("joints/pin/force", "M0*sin(w*t)", "M0*cos(w*t)"),
    row("joints/pin/forces", ["M0*sin(w*t)"], ["M0*cos(w*t)"]),
    row("joints/pin/start", 0.5, 0.6),
    row("joints/pin/start_rates", 0.5, 0.6),
    row("joints/pin/latex", r"\theta", ABSENT),
    row("joints/pin/motion", "sin(w*t)", "cos(w*t)", joints__pin__drive="M"),
    row("joints/pin/mimic", {"coordinate": "q1", "ratio": 2}, {"coordinate": "q1", "ratio": 3}),
    row("joints/pin/mimic/ratio", 2, 3, joints__pin__mimic={"coordinate": "q1"}),
    row("joints/pin/mimic/offset", 2, 3, joints__pin__mimic={"coordinate": "q1", "ratio": 2}),
    row("joints/pin/mimic/ratios", {"q1": 2}, {"q1": 3}, joints__pin__mimic={}),
    row("joints/pin/mimic/radii", [1, 2], [1, 3], joints__pin__mimic={"joint": "foot"}, **PINION),
    row("joints/pin/mimic/mesh", "internal", ABSENT, joints__pin__mimic={"joint": "foot", "radii": [1, 2]}, **PINION),
    row("joints/pin/armature", 0.5, 0.6),
    row("joints/pin/rotor", {"inertia": 0.1, "gear": 3}, {"inertia": 0.1, "gear": 4}),
    row("joints/pin/rotor/inertia", 0.1, 0.2, joints__pin__rotor={"gear": 3}),
    row("joints/pin/rotor/gear", 3, 4, joints__pin__rotor={"inertia": 0.1}),
    row("joints/pin/damping", 0.5, 0.6),
    row("joints/pin/friction", 0.5, {"coulomb": 0.5}),
    row("joints/pin/friction/coulomb", 0.5, 0.6, joints__pin__friction={"smoothing": 0.01}),
    row("joints/pin/friction/static", 0.7, 0.8, joints__pin__friction={"coulomb": 0.5, "stribeck": 0.2}),
    row("joints/pin/friction/stribeck", 0.2, 0.3, joints__pin__friction={"coulomb": 0.5, "static": 0.9}),
    row("joints/pin/friction/smoothing", 0.1, 0.4, joints__pin__friction={"coulomb": 0.5}),
    row("joints/pin/limits", {"lower": -0.1, "upper": 0.1}, ABSENT, joints__pin__start_rates=3),
    row("joints/pin/limits/lower", -0.1, -0.2, joints__pin__limits={"upper": 1}, joints__pin__start_rates=-3),
    row("joints/pin/limits/upper", 0.1, 0.2, joints__pin__limits={"lower": -1}, joints__pin__start_rates=3),
    row("joints/pin/limits/velocity", 1, 2, joints__pin__limits={"lower": -1}),
    row("joints/pin/limits/restitution", 0.3, 0.6, joints__pin__limits={"upper": 0.1}, joints__pin__start_rates=3),
    row("joints/pin/limits/one_way", True, False, joints__pin__limits={"upper": 1}),
    row("joints/pin/limits/effort", 1, 2, joints__pin__limits={"lower": -1}, joints__pin__drive="M"),
    row("joints/pin/locked", True, False),
    row("joints/pin/position", 0.1, 0.2, joints__pin__locked=True),
    row("points/tip/body", "arm", "cart", **TIP),
    row("points/tip/at", [0, 0, 1], [0, 0, 2], **TIP),
    row("inputs/v/value", 2, 3, joints__pin__force="v"),
    row("inputs/v/unit", "N m", "V", inputs__v={"value": 2}),
    row("inputs/v/latex", r"\nu", ABSENT, inputs__v={"value": 2}, joints__pin__force="v"),
    row("inputs/v/text", "of a motor", ABSENT, inputs__v={"value": 2}),
    row("states/s/rate", 2, "3 - s", joints__pin__force="s"),
    row("states/s/start", 2, 3, joints__pin__force="s", states__s__rate=1),
    row("states/s/unit", "N m", "V", states__s={"rate": 1}),
    row("states/s/latex", r"\sigma", ABSENT, states__s={"rate": 1}, joints__pin__force="s"),
    row("states/s/text", "of a coil", ABSENT, states__s={"rate": 1}),
    row("states/s/reset", {"when": "s - 0.1"}, ABSENT, states__s={"rate": 1}, joints__pin__force="s"),
    row("states/s/reset/when", "s - 0.1", "s - 0.2", states__s={"rate": 1, "reset": {}}, joints__pin__force="s"),
    row("states/s/reset/to", 0, -1, **JUMP),
    row("states/s/reset/way", "up", "down", **JUMP),
    row("signals/g/formula", "2*q1", "3*q1", joints__pin__force="g"),
    row("signals/g/unit", "J", ABSENT, signals__g={"formula": "2*q1"}),
    row("signals/g/text", "a spring", ABSENT, signals__g={"formula": "2*q1"}),
    row("outputs/y/formula", "2*q1", "3*q1"),
    row("outputs/y/unit", "J", ABSENT, outputs__y={"formula": "2*M0"}),  # N m by its dimension
    row("outputs/y/text", "height", ABSENT, outputs__y={"formula": "2*q1"}),
    row("tables/curve/points", [[0, 0], [1, 5]], [[0, 0], [1, 6]], **CURVE),
    row("tables/curve/method", "cubic", ABSENT, **CURVE),
    row("springs/coil/joint", "pin", "rail", springs__coil={"stiffness": 3}),
    row("springs/coil/from", "tip", "arm", **COIL),
    row("springs/coil/to", "ground", "cart", **COIL),
    row("springs/coil/stiffness", 5, [5, 1], **COIL),
    row("springs/coil/free", 0.3, 0.4, **COIL),
    row("springs/coil/preload", 0.3, 0.4, **COIL),
    row("dampers/shock/joint", "pin", "rail", dampers__shock={"damping": 3}),
    row("dampers/shock/from", "tip", "arm", **SHOCK),
    row("dampers/shock/to", "ground", "cart", **SHOCK),
    row("dampers/shock/damping", 5, [5, 1], **SHOCK),
    row("loads/push/body", "arm", "cart", **PUSH),
    row("loads/push/point", "tip", "hub", **TIP, points__hub={"body": "cart"}, loads__push={"force": [1, 2, 3]}),
    row("loads/push/at", [0, 0, 1], [0, 0, 2], **PUSH),
    row("loads/push/force", [1, 2, 3], [1, 2, 4], **PUSH),
    row("loads/push/couple", [1, 2, 3], [1, 3, 4], **PUSH),
    row("loads/push/frame", "body", "ground", **PUSH),
    row("constraints/tie/formula", "q1_dot - 2*q2_dot", "q1_dot - 3*q2_dot"),
    row("constraints/tie/acts_in", "joints", ABSENT, constraints__tie={"formula": "q1_dot - r*q2_dot"}),
    row("constraints/wheel/body", "arm", "cart", **WHEEL),
    row("constraints/wheel/at", [0, 0.1, 0], [0, 0.2, 0], **WHEEL),
    row("constraints/wheel/axis", [0, 1, 0], [0, 1, 1], **WHEEL),
    row("constraints/wheel/radius", 0.5, 0.6, **WHEEL),
    row("constraints/wheel/normal", [0, 0, 1], [0, 1, 1], **WHEEL),
    row("constraints/wheel/components", ["along"], ["along", "across"], **WHEEL),
    row("constraints/wheel/plane", {"at": [0, 0, 0.1]}, {"at": [0, 0, 0.2]}, **WHEEL),
    row("constraints/wheel/point", "hub", "tip", **{**WHEEL, "constraints__wheel": ROLLING}, **TIP),
    row("flows/jet/velocity", [1, 2, 3], [1, 2, 4], **JET),
    row("flows/jet/at", [0, 0, 1], [0, 1, 1], **JET),
    row("flows/jet/frame", "ground", "body", **JET),
    row("flows/jet/rate", -0.1, -0.2, **JETS),
    row("flows/jet/point", "tip", "hub", **LEAKS, **TIP, points__hub={"body": "arm"}, flows__jet=OUT),
    row("contacts/hit/gap", "0.1 - q1", "0.2 - q1", **HIT),
    row("contacts/hit/tangent", "r*q2_dot", "-2*r*q2_dot", **HIT),
    row("contacts/hit/restitution", 0.5, 0.6, **HIT),
    row("contacts/hit/friction", 0.1, 0.2, **HIT),
    row("contacts/hit/static", 0.02, 20, **STUCK),
    row("contacts/hit/law", "poisson", "newton", **BOUNCED),
    row("contacts/hit/active", "1", "-1", **HIT),
    row("contacts/hit/at", [0.1, 0, 0], [0.2, 0, 0], **FALL),
    row("contacts/hit/body", "arm", "cart", **FALL),
    row("contacts/hit/radius", 0.1, 0.15, **ROLL),
    row("contacts/hit/axis", [0, 1, 0], [1, 1, 0], **RIM),
    row("contacts/hit/point", "tip", "hub", **POINTED),
    row("contacts/hit/normal", [0, 0, 1], [0, 1, 1], contacts__hit={"body": "arm", "at": [0, 0, 1]}),
    row("contacts/hit/plane/at", [0, 0, -0.2], [0, 0, -0.3], **FALL),
    row("contacts/hit/plane/normal", [0, 0, 1], [0, 0.2, 1], **FALL),
    row("contacts/hit/plane/body", "cart", "ground", contacts__hit={"body": "arm", "plane": STEEP}),
    row("contacts/hit/plane", UNDER, {"at": [0, 0, -0.3]}, contacts__hit={"body": "arm"}),
    row("ropes/hoist/length", 0.7, 0.8, **HOIST),
    row("ropes/hoist/restitution", 0.1, 0.5, **SNAPPED),
    row("ropes/hoist/through", ["tip", "ground"], ["arm", "ground"], **HOIST),
    row("ropes/hoist/stiffness", 5, [5, 1], **PULLED),
    row("ropes/hoist/free", 0.3, 0.4, **PULLED),
    row("ropes/hoist/preload", 0.3, 0.4, **PULLED),
    row("ropes/hoist/damping", 5, [5, 1], ropes__hoist={"type": "damping", "through": ["tip", "ground"]}, **TIP),
    row("ropes/hoist/through/1/body", "ground", "arm", **LED),
    row("ropes/hoist/through/1/at", [0, 0, 1], [0, 0, 0.5], **LED),
    row("ropes/hoist/through/1/radius", 0.1, 0.2, **LED),
    row("ropes/hoist/through/1/axis", [0, 1, 0], [0, -1, 0], **LED),
    row("ropes/hoist/through/1/turn", "left", "right", **LED),
    row("ropes/hoist/through/0/point", "tip", "hub", ropes__hoist={"length": 0.7, "through": [{}, "ground"]}, **TIP,
        points__hub={"body": "arm"}),
    row("loop/0/type", "spherical", "universal", **RING),
    row("loop/0/parent", "arm", "cart", **RING),
    row("loop/0/child", "ground", "cart", **RING),
    row("loop/0/name", "ring", "cut", **RING),
    row("loop/0/origin", [0, 0, 0.1], [0, 0, 0.2], **RING),
    row("loop/0/tip", [0, 0, 0.1], [0, 0, 0.2], **RING),
    row("loop/0/child_origin", [0, 0, 0.1], [0, 0, 0.2], **RING),
    row("dh/convention", "standard", "modified", dh=DH),
    row("dh/parent", "cart", "arm", dh=DH),
    row("dh/links/0/theta", 0.1, 0.2, dh=DH),
    row("dh/links/0/d", 0.1, 0.2, dh=DH),
    row("dh/links/0/a", 0.1, 0.2, dh=DH),
    row("dh/links/0/alpha", 0.1, 0.2, dh=DH),
    row("dh/links/0/type", "prismatic", "revolute", dh=DH),
    row("dh/links/0/name", "one", "two", dh=DH),
    *(row(f"bodies/arm/inertia/{word}", 0.02, 0.03, bodies__arm__inertia=MATRIX) for word in ("xy", "xz", "yz")),
    *(row(f"bodies/arm/inertia/{word}", 3, 3.5, bodies__arm__inertia=MATRIX) for word in ("xx", "yy", "zz")),
    row("bodies/arm/shape/type", "rod", "disc"),
    row("bodies/arm/shape/radius", 0.5, 0.6, bodies__arm__shape={"type": "disc"}),
    row("bodies/arm/shape/length", 0.5, 0.6, bodies__arm__shape={"type": "rod"}),
    row("bodies/arm/shape/axis", [1, 0, 0], [0, 1, 0], bodies__arm__shape={"type": "rod", "length": 0.5}),
    row("bodies/arm/shape/width", 0.5, 0.6, bodies__arm__shape={"type": "plate", "height": 0.4}),
    row("bodies/arm/shape/height", 0.5, 0.6, bodies__arm__shape={"type": "plate", "width": 0.4}),
    *(row(f"{place}/{end}/body", "arm", "cart", **said) for place, end, said in ENDS),
    *(row(f"{place}/{end}/at", *TWO, **said, **on_arm(place, end)) for place, end, said in ENDS),
    *(row(f"{place}/{end}/point", "tip", "hub", **said) for place, end, said in ENDS),
    row("joints/pin/mimic/coordinate", "q1", "q3", joints__pin__mimic={"ratio": 2}, **FOOT),
    *(row(f"joints/pin/{place}/xyz", *TWO, **turned(place, "rpy")) for place in PLACES),
    *(row(f"joints/pin/{place}/rpy", *TWO, **turned(place, "xyz")) for place in PLACES),
    row("points/tip/at/xyz", [0, 0, 1], [0, 1, 0], points__tip={"body": "arm", "at": {"rpy": [0, 0, 1]}}),
    row("points/tip/at/rpy", [0, 0, 1], [0, 1, 0], points__tip={"body": "arm", "at": {"xyz": [0, 0, 1]}}),
    row("parameters/k/tolerance/sigma", 0.1, 0.2, parameters__k__tolerance={}),
    row("parameters/k/tolerance/within", 0.1, 0.2, parameters__k__tolerance={}),
    row("constraints/wheel/plane/at", [0, 0, 0.1], [0, 0, 0.2], **WHEEL, **LEVEL),
    row("constraints/wheel/plane/normal", [0, 0, 1], [0, 0.1, 1], **WHEEL, **RAISED),
    row("constraints/wheel/plane/body", "cart", "ground", **WHEEL, **LEVEL),
    row("loop/0/axis", [0, 1, 0], [0, 1, 1], **ring("revolute")),
    row("loop/0/second_axis", [0, 1, 0], [0, 1, 1], **ring("universal", axis=[1, 0, 0])),
    row("loop/0/length", 1, 2, **ring("rod")),
    row("loop/0/pitch", 1, 2, **ring("helical")),
    *(row(f"loop/0/{place}/xyz", *TWO, **ring("spherical", **{place: {"rpy": [0, 0, 1]}})) for place in PLACES),
    *(row(f"loop/0/{place}/rpy", *TWO, **ring("revolute", **{place: {"xyz": [0, 0, 1]}})) for place in PLACES),
)  # fmt: skip

SILENT: dict[str, str] = {
    "bodies/allow_invalid_inertia": "it takes an inertia that is refused without it, and says so",
    "bodies/particles/at": "stands in the row of `particles`",
    "bodies/particles/mass": "likewise",
    "dh/links": "each of its words is a row",
    "joints/child": "every body hangs on one joint: with another child it is another mechanism",
    "joints/mimic/joint": "names by its joint the coordinate that `mimic` names",
    "joints/steps/rpy": "steps of a custom joint are in words such as Rz; a placement is of other joints",
    "joints/steps/xyz": "likewise",
    "loop/drive": "false, as of every joint that nothing drives: true is refused",
    "loop/orientation": "a loop has no coordinates, whose angles it would choose; the page of words says so",
    "loop/steps": "a custom joint closes no loop",
    "loop/units": "likewise",
    "units": "it takes formulas that are refused without it: tests/test_dimensions.py",
    "constraints/type": "other types have other keys, each a row by itself",
    "ropes/type": "likewise",
    "contacts/type": "likewise",
    "flows/body": "matter flows from the body whose mass changes: with another body it is another mechanism",
    "text": "what lessons and pictures call it, a body, a joint: tests/test_languages.py",
    "inputs/rates": "adds inputs, and lets supports and joints follow",
    "bodies/text": "likewise",
    "joints/text": "likewise",
    "loop/text": "likewise",
    **{f"{one}/text": "likewise" for one in sections()},
}
"""Words that have no row, and why."""

ONLY_TOLD: dict[str, str] = {
    "name": "of files and functions",
    "parameters/latex": "how it is printed",
    "parameters/text": "what it is, for tables",
    "parameters/positive": "an assumption of what is printed",
    "parameters/tolerance": "of studies",
    "bodies/shape": "of pictures",
    "joints/limits/velocity": "of tables and robot files: it stops no run",
    "joints/limits/effort": "likewise, and drives are judged by it afterwards",
    "joints/units": "of columns",
    "inputs/latex": "how it is printed",
    "joints/latex": "how its coordinates are printed",
    "inputs/text": "what it is, for tables",
    "inputs/unit": "of columns",
    "states/latex": "how it is printed",
    "states/text": "what it is, for tables",
    "states/unit": "of columns",
    "signals/text": "what it is, for tables",
    "signals/unit": "what its formula is checked by",
    "outputs/text": "what it is, for tables",
    "outputs/unit": "of columns",
    "constraints/components": "names of reactions",
    "loop/name": "of reactions",
    "dh/links/name": "of bodies",
    "dh/links/shape": "of pictures",
    "dh/links/limits": "as of joints",
}
"""Words, or tables of words, whose values change nothing that is computed, and what they are for."""

CHAIN = ("joints/pin/", "bodies/arm/")
"""What a link of a Denavit-Hartenberg table says of its joint and of its body."""


def of_links() -> Iterator[Row]:
    """Return the words of joints and bodies, as those of a link of a table."""
    words = known()
    for path, one, other, beside in WORDS:
        place = "/".join(path)
        own = {"joints__pin", "bodies__arm"} & {*beside}
        if place.startswith(CHAIN) and f"dh/links/{'/'.join(path[2:])}" in words and not own:
            names = {name: name.replace("joints__pin", "dh__links__0") for name in beside}
            there = {names[name].replace("bodies__arm", "dh__links__0"): said for name, said in beside.items()}
            beside_it = {"joints__foot__parent": "arm"} if "joints__foot" in beside else {}  # as the link
            yield ("dh", "links", "0", *path[2:]), one, other, {"dh": DH, **there, **beside_it}


def every() -> tuple[Row, ...]:
    """Return all rows, each word once."""
    told = {one[0]: one for one in (*of_links(), *WORDS)}
    return tuple(told.values())


def known() -> set[str]:
    """Return all words by their section, those of tables in them too, as editors are told them."""
    found = set[str]()
    for section, shape in schema()["properties"].items():
        inner = shape.get("additionalProperties") or shape.get("items") or (shape if section == "dh" else {})
        found |= {f"{section}/{path}" for path in _paths(inner)} or {section}
    return found


def _paths(shape: Any) -> Iterator[str]:
    if not isinstance(shape, Mapping) or shape.get("properties", {}).keys() == {"value", "unit"}:
        return  # a number with its unit, which stands wherever a number does
    for word, inside in shape.get("properties", {}).items():
        if word:
            yield word
            yield from (f"{word}/{path}" for path in _paths(inside))
    for branch in shape.get("anyOf", ()):
        yield from _paths(branch)
    if isinstance(shape.get("items"), Mapping):
        yield from _paths(shape["items"])


def section_of(one: Row) -> str:
    """Return a word by its section, without the names that a user gives."""
    first, *rest = one[0]
    names = 0 if first in ("name", "gravity", "units", "dh") else 1
    return "/".join([first, *(part for part in rest[names:] if not part.isdigit())])


def scenes(one: Row) -> tuple[str, str]:
    """Return two texts of scenes that differ in a word alone."""
    path, first, second, beside = one
    made = []
    for value in (first, second):
        tables = copy.deepcopy(BASE)
        for place, said in beside.items():
            _put(tables, tuple(place.split("__")), copy.deepcopy(said))
        _put(tables, path, copy.deepcopy(value))
        made.append(toml(tables))
    return made[0], made[1]


def _put(tables: Any, path: tuple[str, ...], value: Any) -> None:
    *inner, last = path
    for key in inner:
        place: Any = int(key) if isinstance(tables, list) else key
        if not isinstance(tables, list) and not isinstance(tables.get(place), (dict, list)):
            tables[place] = {}  # in place of a name, such as that of a point
        tables = tables[place]
    if value is ABSENT:
        tables.pop(last, None)
    else:
        tables[last] = value

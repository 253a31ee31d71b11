"""Scene files as JSON Schema, for editors, made of the tables by which the reader goes: both know the same words.

A schema sees one table at a time. What takes a look at the rest of a scene stays with the reader: names that are
declared nowhere, or twice; formulas that have no value; masses below zero; joints that close no tree.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import Any

from symdyn.scene.declaration.coupling import MIMIC_KEYS
from symdyn.scene.declaration.declare import INERTIA_KEYS, MOST_PARTICLES, TABLE_KEYS
from symdyn.scene.declaration.dh import CONVENTIONS, LINK_KEYS, TABLE_KEYS as TABLE
from symdyn.scene.declaration.joint_table import LIMIT_KEYS, OWN_KEYS, loop_keys, meaningless
from symdyn.scene.forces.force_kind import ForceKind
from symdyn.scene.forces.force_table import kinds_of, sections
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_table import JOINTS, own_keys
from symdyn.scene.toml import SHORT
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import (
    ANYTHING,
    FLAG,
    NAMED,
    NUMBER,
    PLACEMENT,
    TEXT,
    VECTOR,
    Key,
    Shape,
    choice_of,
    name_shape,
    not_both,
    scene_name_shape,
    several,
    table_shape,
)
from symdyn.scene.values.outline import OUTLINES
from symdyn.scene.values.tolerance import LONGEST as LONGEST_TOLERANCE, WORDS as TOLERANCE_WORDS

DRAFT = "https://json-schema.org/draft/2020-12/schema"

TITLE = "Scene of symdyn"

NAME, LETTER = name_shape(), name_shape(letter=True)
LETTERS: Shape = {"anyOf": [LETTER, {"type": "array", "items": LETTER}]}
DRIVE: Shape = {"anyOf": [LETTER, FLAG, {"type": "array", "items": {"anyOf": [LETTER, FLAG]}}]}
OF_LETTERS = ("parameters", "inputs", "outputs")
"""Tables whose names formulas or columns have."""

TOLERANCE: Shape = {
    "anyOf": [
        {"type": "number", "exclusiveMinimum": 0},
        {"type": "string", "maxLength": LONGEST_TOLERANCE, "pattern": r"^[^0-9]*[0-9.]"},
    ]
}
EACH: Shape = {"anyOf": [NUMBER, {"type": "array", "items": NUMBER}]}

WORDS: Mapping[str, tuple[str, Shape]] = {  # what a word means, and its shape; "table.word" where it differs there
    "name": ("its name", NAME),
    "scene.name": ("its name, of files and functions too", scene_name_shape()),
    "value": ("its value; without one it is an argument of generated functions", NUMBER),
    "inputs.value": ("what it is where nobody gives it; zero when left out", NUMBER),
    "positive": ("whether it is above zero whatever its value, so that forms get shorter", FLAG),
    "unit": ("of its value, such as mm, kg or N/m: a bare number is in it", TEXT),
    "outputs.unit": ("of SI, for tables, comments and axes of plots", TEXT),
    "tolerance": (
        'how far the value may be off, for sweeps: "5 %" of it, "0.1 mm", 0.02; or { sigma = .. }, a deviation',
        {"anyOf": [TOLERANCE, *(table_shape({word: TOLERANCE}, (word,)) for word in TOLERANCE_WORDS)]},
    ),
    "latex": ("its symbol in printed equations", TEXT),
    "text": (
        "what it is, for tables and comments; or a table of languages: { en = ..., sk = ... }",
        {
            "anyOf": [
                TEXT,
                {
                    "type": "object",
                    "patternProperties": {"^[a-z]{2}$": TEXT},
                    "additionalProperties": False,
                    "minProperties": 1,
                },
            ]
        },
    ),
    "formula": ("of coordinates, rates, points, reactions, inputs, parameters and t", NUMBER),
    "mass": ("kg", NUMBER),
    "com": ("centre of mass in the body frame, m", VECTOR),
    "first_moment": ("mass times centre of mass, kg m, in place of com", VECTOR),
    "inertia": (
        "kg m^2: [xx, yy, zz], a symmetric matrix, or a table of matrix entries",
        {"anyOf": [VECTOR, several(VECTOR, 3), table_shape(dict.fromkeys(INERTIA_KEYS, NUMBER))]},
    ),
    "inertia_about": ("what the inertia refers to: centre of mass or origin of the frame", choice_of("com", "frame")),
    "particles": (
        "point masses of the body",
        several(table_shape({"mass": NUMBER, "at": VECTOR}, ("mass", "at")), 0, MOST_PARTICLES),
    ),
    "shape": (
        "what it looks like in pictures, where its inertia does not tell",
        {
            "anyOf": [
                choice_of(*OUTLINES),
                *(
                    table_shape(
                        {
                            "type": {"const": word},
                            **dict.fromkeys(kind.sizes, NUMBER),
                            **({} if kind.axis is None else {"axis": VECTOR}),
                        },
                        ("type",),
                    )
                    for word, kind in OUTLINES.items()
                ),
            ]
        },
    ),
    "allow_invalid_inertia": ("accept an inertia that no body has", FLAG),
    "type": ("what kind of joint", choice_of(*JOINTS)),
    "parent": ('name of the body it hangs on, or "ground"', NAMED),
    "child": ("name of the body it carries", NAMED),
    "body": ("name of the body that carries it", NAMED),
    "at": ("placement in the frame of the body", PLACEMENT),
    "origin": ("from the frame of the parent to that of the joint", PLACEMENT),
    "tip": ("from the moved frame of the joint to that of the child", PLACEMENT),
    "coordinate": ("name of q; q1, q2, ... when left out", LETTERS),
    "coordinates": ("names of q of a joint that has several", LETTERS),
    "drive": ("name of the driving force or torque, false for a passive joint", DRIVE),
    "drives": ("names of the driving forces, false where it is passive", DRIVE),
    "force": ("generalized force beside the drive, N m or N, in what moves, inputs and t", EACH),
    "forces": ("generalized forces, one a velocity, N m or N", EACH),
    "start": ("position at the start, rad or m; a guess where loops close", EACH),
    "start_rates": ("velocity at the start", EACH),
    "motion": ("prescribed motion, a formula in t", NUMBER),
    "mimic": (
        "position = ratio * position of another joint + offset",
        {
            **table_shape({key: NAMED if key in ("joint", "coordinate") else NUMBER for key in MIMIC_KEYS}),
            "oneOf": [{"required": ["joint"]}, {"required": ["coordinate"]}],
        },
    ),
    "axis": ("direction in the frame of the joint or body, any length but zero", VECTOR),
    "second_axis": ("in the frame that the first rotation has turned", VECTOR),
    "orientation": ("quaternion, or three axes of turns", ANYTHING),
    "steps": ("the motion: elementary steps whose amounts are formulas in its coordinates", ANYTHING),
    "units": ("of its coordinates", ANYTHING),
    "frame": ("whose axes the components are along", ANYTHING),
    "components": ("of the velocity of the point that touches, which vanish", ANYTHING),
    "smoothing": ("rate below which friction fades, rad/s or m/s", ANYTHING),
    "convention": ("of the table", choice_of(*CONVENTIONS)),
    "links": ("one row a joint", ANYTHING),
    "armature": ("inertia of a rotor, seen at the joint, kg m^2 or kg", NUMBER),
    "rotor": (
        "in place of armature, which is inertia * gear^2",
        table_shape({"inertia": NUMBER, "gear": NUMBER}, ("inertia",)),
    ),
    "damping": ("viscous, N m s/rad or N s/m", NUMBER),
    "friction": ("dry friction: a number is data, a table acts", ANYTHING),
    "limits": ("of position, velocity and force", table_shape(dict.fromkeys(LIMIT_KEYS, NUMBER))),
    "locked": ("whether it stands still", FLAG),
    "position": ("where a locked joint stands, rad or m", NUMBER),
    "theta": ("turn about z, rad", NUMBER),
    "d": ("shift along z, m", NUMBER),
    "a": ("shift along x, m", NUMBER),
    "alpha": ("turn about x, rad", NUMBER),
}

USUAL = "revolute"
"""Type of a joint in a table of Denavit and Hartenberg that says none."""

TWICE = [
    *(("coordinate", "coordinates"), ("drive", "drives"), ("force", "forces"), ("armature", "rotor")),
    ("com", "first_moment"),
]
"""Words that say the same thing."""

REQUIRED: Mapping[str, tuple[str, ...]] = {"points": ("body",), "outputs": ("formula",)}

BODY_RULES: Sequence[Shape] = (
    {"if": {"required": ["inertia"]}, "then": {"required": ["inertia_about"]}},
    {"if": {"required": ["first_moment"]}, "then": {"properties": {"inertia_about": choice_of("frame")}}},
)


def schema() -> dict[str, Any]:
    """Return the JSON Schema of scene files, draft 2020-12, as plain data."""
    sheet = {key: _tables(key, keys) for key, keys in TABLE_KEYS.items()}
    for kind in SHORT:
        sheet[kind]["additionalProperties"] = {"anyOf": [sheet[kind]["additionalProperties"], NUMBER]}
    sheet["joints"]["additionalProperties"] = _joint(TABLE_KEYS["joints"], ("type", "parent", "child"))
    sheet["bodies"]["additionalProperties"]["allOf"] = [*BODY_RULES, *_twice(TABLE_KEYS["bodies"])]
    sheet |= {section: _named(_elements(section)) for section in sections()}
    loop = _joint(("name", *loop_keys()), ("type", "parent", "child"), tree=False)
    loop["properties"]["drive"] = {"description": "false, as of every joint that nothing drives", "const": False}
    words = {
        "name": _word("scene", "name"),
        "gravity": {
            "description": 'acceleration of free fall in the ground frame, m/s^2; "none" for none',
            "anyOf": [VECTOR, {"enum": [False, "none"]}],
        },
        "units": {"description": '"none" of a scene without dimensions; else they are checked', "const": "none"},
        **sheet,
        "loop": {"type": "array", "items": loop},
        "dh": _denavit_hartenberg(),
    }
    found = {"$schema": DRAFT, "title": TITLE, **table_shape(words)}
    return {**found, "anyOf": [{"required": ["joints"]}, {"required": ["dh"]}]}


def _word(section: str, word: str) -> Shape:
    """Return the shape of a word in a table, with what it means."""
    told, shape = WORDS.get(f"{section}.{word}", WORDS.get(word, ("", ANYTHING)))
    return {"description": told, **shape} if told else shape


def _told(word: str, shape: Shape) -> Shape:
    """Return the shape of a word of a kind, with what it means where the kind does not say."""
    return shape if "description" in shape else {"description": WORDS.get(word, ("",))[0], **shape}


def _named(table: Shape, name: Shape = NAME) -> dict[str, Any]:
    """Return a table of tables by name."""
    return {"type": "object", "propertyNames": name, "additionalProperties": table}


def _tables(section: str, keys: Sequence[str]) -> dict[str, Any]:
    """Return the tables of a section."""
    table = table_shape({key: _word(section, key) for key in keys}, REQUIRED.get(section, ()))
    return _named(table, LETTER if section in OF_LETTERS else NAME)


def _twice(keys: Sequence[str]) -> list[dict[str, Any]]:
    return not_both(pair for pair in TWICE if set(pair) <= set(keys))


def _joint(keys: Sequence[str], required: Sequence[str], tree: bool = True) -> dict[str, Any]:
    """Return the table of a joint; what each type takes, needs and refuses stands in a rule of its own."""
    words = {key: _word("joints", key) for key in keys}
    own = (item for kind in JOINTS.values() for key in kind.keys for item in key.words.items())
    words |= {name: _told(name, shape) for name, shape in own}
    if "friction" in words:
        words["friction"] = {**_word("joints", "friction"), "anyOf": [NUMBER, _elements("friction")]}
    rules = [_of_type(name, kind, tree, "type" not in required and name == USUAL) for name, kind in JOINTS.items()]
    if "mimic" in keys:
        rules.append({"if": {"required": ["mimic"]}, "then": {"properties": dict.fromkeys(OWN_KEYS, False)}})
    if "locked" in keys:
        standing = {"required": ["locked"], "properties": {"locked": {"const": True}}}
        rules.append({"if": {"required": ["position"]}, "then": standing})
    return {**table_shape(words, required), "allOf": [*rules, *_twice(keys)]}


def _of_type(name: str, kind: JointKind, tree: bool, usual: bool) -> dict[str, Any]:
    """Return what is so of a joint of one type, which need not be said where it is the usual one."""
    own = {key.name for key in kind.keys}
    refused: dict[str, Any] = {key: False for key in own_keys() if key not in own}
    needed = [key.name for key in kind.keys if key.example]
    then: dict[str, Any] = {}
    if tree:
        joint = Joint("", name, "", "", tuple((key.name, key.default) for key in kind.keys))
        refused |= {key: False for keys, _ in meaningless(joint) for key in keys}
        refused |= {"drive": {"const": False}} if refused.get("drive") is False else {}
        if kind.names_coordinates:
            then["anyOf"] = [{"required": [key]} for key in ("coordinate", "coordinates")]
        else:
            then["allOf"] = _lengths(kind, joint, own)
    then |= {"properties": refused} | ({"required": needed} if needed else {})
    this = {"properties": {"type": {"const": name}}}
    return {"if": this if usual else {**this, "required": ["type"]}, "then": then}


def _lengths(kind: JointKind, joint: Joint, own: Container[str]) -> list[dict[str, Any]]:
    """Return how long the lists of a joint are, which may be left to its orientation."""
    usual = {"properties": _counts(kind, joint)}
    if "orientation" not in own:
        return [usual]
    angles = {"properties": _counts(kind, joint.shaped(orientation="zyx"))}
    return [{"if": {"properties": {"orientation": {"const": "quaternion"}}}, "then": usual, "else": angles}]


def _counts(kind: JointKind, joint: Joint) -> dict[str, Any]:
    """Return how long the lists of a joint with these coordinates and velocities are; one number is no list."""
    nq, nv = len(kind.coordinates(joint)), len(kind.velocities(joint))
    found: dict[str, Any] = {"coordinate": {"type": "string"}} if nq == 1 else {}
    of = {"coordinate": nq, "coordinates": nq, "start": nq, "start_rates": nv, "force": nv, "forces": nv}
    for word, n in of.items() if nv else ():
        found.setdefault(word, {"minItems": n, "maxItems": n} | ({"type": "array"} if n > 1 else {}))
    for word in ("drive", "drives") if nv else ():
        found[word] = {"minItems": nv, "maxItems": nv} | ({"type": ["array", "boolean"]} if nv > 1 else {})
    return found


def _elements(section: str) -> dict[str, Any]:
    """Return the table of an element; of the kinds that share a section `type` tells which."""
    kinds = kinds_of(section)
    parts = [part for kind in kinds.values() for part in kind.parts]
    words = {name: _told(name, shape) for part in parts for name, shape in part.words.items()}
    if len(kinds) == 1:
        (kind,) = kinds.values()
        return {**table_shape(words), "allOf": _rules(kind)}
    first, *_ = kinds
    rules = []
    for name, kind in kinds.items():
        own = {key for part in kind.parts for key in part.keys}
        this: dict[str, Any] = {"properties": {"type": {"const": name}}}
        this |= {} if name == first else {"required": ["type"]}
        then = {"properties": {key: False for key in words if key not in own}, "allOf": _rules(kind)}
        rules.append({"if": this, "then": then})
    return {**table_shape({"type": choice_of(*kinds), **words}), "allOf": rules}


def _rules(kind: ForceKind) -> list[Shape]:
    """Return what is so of several keys of an element."""
    needs = [{"anyOf": [{"required": [key]} for key in kind.needs]}] if kind.needs else []
    needed = [key.name for key in kind.parts if isinstance(key, Key) and key.example]
    return [*needs, *([{"required": needed}] if needed else []), *(rule for part in kind.parts for rule in part.rules)]


def _denavit_hartenberg() -> dict[str, Any]:
    """Return the table [dh]; its rows are joints and bodies at once."""
    link = _joint([key for key in LINK_KEYS if key not in own_keys()], ())
    link["properties"] = {key: link["properties"].get(key, _word("dh", key)) for key in LINK_KEYS}
    link["allOf"] += [*BODY_RULES, *_twice([key for key in LINK_KEYS if key in TABLE_KEYS["bodies"]])]
    words = {
        **{word: _word("dh", word) for word in TABLE},
        "links": {**_word("dh", "links"), "type": "array", "items": link, "minItems": 1},
    }
    return {
        "description": "a chain of joints by its Denavit-Hartenberg parameters",
        **table_shape(words, ("convention", "links")),
    }

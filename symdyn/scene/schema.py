"""Scene files as JSON Schema, for editors, made of the tables by which the reader goes: both know the same words.

A schema sees one table at a time. What takes a look at the rest of a scene stays with the reader: names that are
declared nowhere, or twice; formulas that have no value; masses below zero; joints that close no tree.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from typing import Any

from symdyn.scene.declaration.declare import CHAIN, LINK, LINK_OF_JOINT, SECTIONS
from symdyn.scene.declaration.joint_table import (
    COORDINATES,
    DRIVES,
    FORCE,
    OWN_COORDINATES,
    ROWS,
    START,
    START_RATES,
    meaningless,
    place_keys,
)
from symdyn.scene.declaration.scene_table import BODY, HEAD, SHORT
from symdyn.scene.forces.force_kind import ForceKind
from symdyn.scene.forces.force_table import kinds_of, sections
from symdyn.scene.joints.joint_kind import JointKind
from symdyn.scene.joints.joint_table import JOINTS, own_keys
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Part, keys_of, needed_of
from symdyn.scene.values.shape import NUMBER, Shape, choice_of, described, name_shape, table_shape

DRAFT = "https://json-schema.org/draft/2020-12/schema"

TITLE = "Scene of symdyn"

NAME, LETTER = name_shape(), name_shape(letter=True)

OWN_NAME = described("its name", NAME)

USUAL = "revolute"
"""Type of a joint in a table of Denavit and Hartenberg that says none."""


def schema() -> dict[str, Any]:
    """Return the JSON Schema of scene files, draft 2020-12, as plain data."""
    place = place_keys()
    joint = _joint([*place, *_types(), *ROWS], needed_of(place))
    sheet = {
        section: _named(joint if section == "joints" else _table(parts), LETTER if section in SHORT else NAME)
        for section, parts in SECTIONS.items()
    }
    for section in SHORT:
        sheet[section]["additionalProperties"] = {"anyOf": [sheet[section]["additionalProperties"], NUMBER]}
    sheet |= {section: _named(_elements(section)) for section in sections()}
    loop = _joint([*place, *_types()], needed_of(place), tree=False)
    passive = {"description": "false, as of every joint that nothing drives", "const": False}
    loop["properties"] |= {"name": OWN_NAME, "drive": passive}
    words = {
        **_words(HEAD),
        **sheet,
        "loop": {"type": "array", "items": loop},
        "dh": _denavit_hartenberg(),
    }
    found = {"$schema": DRAFT, "title": TITLE, **table_shape(words)}
    return {**found, "anyOf": [{"required": ["joints"]}, {"required": ["dh"]}]}


def _named(table: Shape, name: Shape = NAME) -> dict[str, Any]:
    """Return a table of tables by name."""
    return {"type": "object", "propertyNames": name, "additionalProperties": table}


def _words(parts: Iterable[Part]) -> dict[str, Shape]:
    return {key: shape for part in parts for key, shape in part.words.items()}


def _rules(parts: Iterable[Part]) -> list[Shape]:
    return [rule for part in parts for rule in part.rules]


def _table(parts: Sequence[Part]) -> dict[str, Any]:
    """Return a table of a section."""
    rules = _rules(parts)
    return {**table_shape(_words(parts), needed_of(parts)), **({"allOf": rules} if rules else {})}


def _types() -> list[Part]:
    """Return what some types of joints take."""
    return [key for kind in JOINTS.values() for key in kind.keys]


def _joint(parts: Sequence[Part], required: Sequence[str], tree: bool = True) -> dict[str, Any]:
    """Return the table of a joint; what each type takes, needs and refuses stands in a rule of its own."""
    words = _words(parts)
    rules = [_of_type(name, kind, tree, "type" not in required and name == USUAL) for name, kind in JOINTS.items()]
    if tree:
        words["friction"] = {**words["friction"], "anyOf": [NUMBER, _elements("friction")]}
        rules.append({"if": {"required": ["mimic"]}, "then": {"properties": _refused(keys_of(OWN_COORDINATES))}})
    return {**table_shape(words, required), "allOf": [*rules, *_rules(parts)]}


def _refused(keys: Iterable[str]) -> dict[str, Any]:
    """Return that keys are not given; that nothing drives may be said of all joints."""
    return {key: {"const": False} if key == "drive" else False for key in keys}


def _of_type(name: str, kind: JointKind, tree: bool, usual: bool) -> dict[str, Any]:
    """Return what is so of a joint of one type, which need not be said where it is the usual one."""
    own = {key.name for key in kind.keys}
    refused: dict[str, Any] = {key: False for key in own_keys() if key not in own}
    needed = [key.name for key in kind.keys if key.example]
    then: dict[str, Any] = {}
    if tree:
        joint = Joint("", name, "", "", tuple((key.name, key.default) for key in kind.keys))
        refused |= _refused(key for keys, _ in meaningless(joint) for key in keys)
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
    for part in (COORDINATES, START, DRIVES, FORCE, START_RATES) if nv else ():
        n, lists = nq if part in (COORDINATES, START) else nv, ["array", "boolean"] if part is DRIVES else "array"
        for word in part.keys:
            found.setdefault(word, {"minItems": n, "maxItems": n} | ({"type": lists} if n > 1 else {}))
    return found


def _elements(section: str) -> dict[str, Any]:
    """Return the table of an element; of the kinds that share a section `type` tells which."""
    kinds = kinds_of(section)
    words = {key: shape for kind in kinds.values() for key, shape in _words(kind.parts).items()}
    if len(kinds) == 1:
        (kind,) = kinds.values()
        return {**table_shape(words), "allOf": _rules_of(kind)}
    first, *_ = kinds
    rules = []
    for name, kind in kinds.items():
        own = keys_of(kind.parts)
        this: dict[str, Any] = {"properties": {"type": {"const": name}}}
        this |= {} if name == first else {"required": ["type"]}
        then = {"properties": {key: False for key in words if key not in own}, "allOf": _rules_of(kind)}
        rules.append({"if": this, "then": then})
    return {**table_shape({"type": choice_of(*kinds), **words}), "allOf": rules}


def _rules_of(kind: ForceKind) -> list[Shape]:
    """Return what is so of several keys of an element."""
    needs = [{"anyOf": [{"required": [key]} for key in kind.needs]}] if kind.needs else []
    needed = needed_of(kind.parts)
    return [*needs, *([{"required": needed}] if needed else []), *_rules(kind.parts)]


def _denavit_hartenberg() -> dict[str, Any]:
    """Return the table [dh]; its rows are joints and bodies at once."""
    type_, *_ = place_keys()
    link = _joint([type_, *ROWS], ())
    own = {key: shape for key, shape in _words(_types()).items() if key in LINK_OF_JOINT}
    link["properties"] |= {"name": OWN_NAME, **_words(LINK), **own, **_words(BODY)}
    link["allOf"] += _rules(BODY)
    words = {
        **_words(CHAIN),
        "links": {"description": "one row a joint", "type": "array", "items": link, "minItems": 1},
    }
    return {
        "description": "a chain of joints by its Denavit-Hartenberg parameters",
        **table_shape(words, [*needed_of(CHAIN), "links"]),
    }

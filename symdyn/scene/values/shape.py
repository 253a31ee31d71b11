"""Shapes of raw values as JSON Schema, for editors: what a reader of the same word takes without looking at the rest.

number      a number, a formula, a number and a unit, or a table of both       vector   three of them
placement   {xyz, rpy}, [x, y, z], or elementary steps such as ["Tz", 0.1]
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from keyword import kwlist
from typing import Any

from symdyn.scene.values.body import ELEMENTARY
from symdyn.scene.values.grammar import C_KEYWORDS, CLOCK, FORMULA_NAMES, LONGEST, LONGEST_WORDS

Shape = Mapping[str, Any]

FORMULA: Shape = {"type": "string", "pattern": r"^[A-Za-z0-9_+\-*/()., \t\n]*[A-Za-z0-9][A-Za-z0-9_+\-*/()., \t\n]*$"}
VALUE: Shape = {
    "type": "string",
    "pattern": r"^\s*[+-]?\s*[0-9.][0-9.eE+\-/ ]*\(?[A-Za-zµμΩΩ°%][A-Za-z0-9µμΩΩ°%⁰¹²³⁴⁵⁶⁷⁸⁹⁻·⋅×*/^() \-]*$",
}
VALUED: Shape = {
    "type": "object",
    "properties": {"value": {"anyOf": [{"type": "number"}, FORMULA, VALUE]}, "unit": {"type": "string"}},
    "required": ["value"],
    "additionalProperties": False,
}
NUMBER: Shape = {"anyOf": [{"type": "number"}, FORMULA, VALUE, VALUED]}
NUMBERS: Shape = {"anyOf": [*NUMBER["anyOf"], {"type": "array", "items": NUMBER, "minItems": 1}]}
FLAG: Shape = {"type": "boolean"}
TEXT: Shape = {"type": "string", "maxLength": LONGEST_WORDS, "pattern": r"^[^\x00-\x1f\x7f]*$"}
NAMED: Shape = {**TEXT, "minLength": 1}
ANYTHING: Shape = {}


def several(shape: Shape, least: int, most: int | None = None) -> Shape:
    """Return a list of one shape; of exactly `least` where `most` is left out."""
    return {"type": "array", "items": shape, "minItems": least, "maxItems": least if most is None else most}


VECTOR: Shape = several(NUMBER, 3)


def choice_of(*words: str) -> Shape:
    """Return one of some words."""
    return {"enum": list(words)}


def table_shape(words: Mapping[str, Shape], required: Sequence[str] = ()) -> dict[str, Any]:
    """Return a table of these words and no others."""
    made: dict[str, Any] = {"type": "object", "properties": dict(words), "additionalProperties": False}
    return made | ({"required": list(required)} if required else {})


PLACEMENT: Shape = {
    "anyOf": [
        VECTOR,
        table_shape({"xyz": VECTOR, "rpy": VECTOR}),
        {
            "type": "array",
            "items": {
                "type": "array",
                "prefixItems": [choice_of(*ELEMENTARY), NUMBER],
                "minItems": 2,
                "maxItems": 2,
            },
        },
    ]
}


def exactly_one(*groups: Sequence[str]) -> dict[str, Any]:
    """Return that the words of one group are given, and none of the others."""
    every = [word for group in groups for word in group]
    return {
        "oneOf": [
            {"required": list(group), "properties": {word: False for word in every if word not in group}}
            for group in groups
        ]
    }


def not_both(pairs: Iterable[tuple[str, str]]) -> list[dict[str, Any]]:
    """Return that two words that say the same thing are not given together."""
    return [{"not": {"required": [one, other]}} for one, other in pairs]


def scene_name_shape() -> Shape:
    """Return the name of a scene, as `check_scene_name` judges it."""
    return {"type": "string", "pattern": rf"^[A-Za-z][A-Za-z0-9_]{{0,{LONGEST - 1}}}$"}


def name_shape(letter: bool = False) -> Shape:
    """Return a name that every target can print, as `check_name` judges it; a `letter` is one of formulas."""
    taken = [*kwlist, *C_KEYWORDS, *FORMULA_NAMES, *([CLOCK] if letter else [])]
    spelled = {"pattern": scene_name_shape()["pattern"]}
    return {"type": "string", "allOf": [spelled, {"not": {"pattern": r"_d?dot$"}}, {"not": {"enum": taken}}]}


def described(told: str, shape: Shape) -> Shape:
    """Return a shape with what is told of it, if anything is."""
    return {"description": told, **shape} if told else shape

"""Systems over values of one name: a parameter of the scene, or a letter that positions, rates or forces name.

Equations are derived once, with parameters free; only a value that changes their form, as zero does, derives again.
Where a value moves the place of rest, or of a steady motion, it is followed from the last one. That A is the same at
two times of a steady motion is looked at for the first value; at the others, that velocities stay and that the same
positions are cyclic. Where axes do not spin with a body it is looked at for every value, as their spin is another.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import LinearizeError
from symdyn.linear.equilibrium import nearest
from symdyn.linear.linearization import Linearization
from symdyn.linear.locus import MOST
from symdyn.linear.modes import untouched
from symdyn.linear.prepared import Prepared, prepared
from symdyn.linear.spinning import STILL
from symdyn.linear.steady import BALANCED, settled, steady_next_to
from symdyn.scene import FormulaError, Parameter, Scene, bind, parse, question
from symdyn.scene.values import fits, read_unit, split_commas, value_of
from symdyn.simulation import Forces, opened, read_forces, read_start

RANGES: Mapping[str, Callable[[float, float, int], Array]] = {"linspace": np.linspace, "geomspace": np.geomspace}

RANGE = re.compile(r"(?P<kind>\w+)\s*\((?P<inside>.*)\)\Z", re.DOTALL)

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")

FORM = '"NAME=linspace(0,10,100)", geomspace(0.1,10,50) or [1, 2, 5]'


def read_values(text: str, option: str = "--over", scene: Scene | None = None) -> tuple[str, Array]:
    """Return the name and the values of `NAME=linspace(a,b,n)`, `geomspace(a,b,n)` or `[a, b, ...]`.

    With a scene, numbers are asked about that are bare where its parameter is in another unit than that of SI.

    Raises:
        LinearizeError: it is none of these.
    """
    name, equals, said = (part.strip() for part in text.partition("="))
    if not equals or not NAME.match(name):
        raise LinearizeError(f'{option}: "{text}" names nothing; write {FORM}')
    letters = () if scene is None else scene.parameters
    return name, numbers(said, f"{option} {name}", next((one for one in letters if one.name == name), None))


def numbers(said: str, where: str, letter: Parameter | None = None) -> Array:
    """Return the values of a range or a list, as of `read_values`."""
    found = RANGE.match(said)
    if found and found["kind"] in RANGES:
        texts = split_commas(found["inside"])
        parts = [_number(part, where, letter if k < 2 else None) for k, part in enumerate(texts)]
        if len(parts) != 3 or parts[2] != int(parts[2]) or not 2 <= parts[2] <= MOST:
            raise LinearizeError(f"{where}: {said} wants a beginning, an end and how many, 2 to {MOST}")
        if found["kind"] == "geomspace" and not parts[0] * parts[1] > 0:
            raise LinearizeError(f"{where}: {said} begins and ends on the same side of zero")
        return np.asarray(RANGES[found["kind"]](parts[0], parts[1], int(parts[2])))
    if said.startswith("[") and said.endswith("]"):
        return np.array([_number(part, where, letter) for part in split_commas(said[1:-1])])
    raise LinearizeError(f'{where}: "{said}" is no range; write {FORM}')


def number_in(text: str, letter: Parameter | None = None) -> float:
    """Return the number that a formula without names is, of a letter or of none.

    Raises:
        FormulaError: it is none, or in a unit that does not fit the letter's, or in none where it has one of its own.
    """
    formula = parse(text)
    if letter is not None:
        fits(formula, read_unit(letter.unit) if letter.unit else None)
        if asked := question(letter, text):
            raise FormulaError(asked)
    if formula.symbols:
        raise FormulaError(f"{text} is no number; it names {', '.join(formula.symbols)}")
    value = value_of(formula, {})
    assert value is not None, "a formula without names has a value, or raises"
    return float(value)


def _number(text: str, where: str, letter: Parameter | None) -> float:
    try:
        return number_in(text, letter)
    except FormulaError as error:
        raise LinearizeError(f"{where}: {text}: {error}") from None


def systems(
    scene: Scene,
    name: str,
    at: Mapping[str, str] | None = None,
    rates: Mapping[str, str] | None = None,
    forces: Sequence[str] | Mapping[str, str] = (),
    outputs: str | Sequence[str] = (),
    independent: str | Sequence[str] = (),
    anywhere: bool = False,
) -> Callable[[float], Linearization]:
    """Return the system at a value of a name; arguments and errors as of `linearize`.

    Raises:
        LinearizeError: the name is no parameter, and no formula has it.
    """
    formulas = [*(at or {}).values(), *(rates or {}).values()]
    formulas += list(forces.values()) if isinstance(forces, Mapping) else list(forces)
    taken = {
        *scene.coordinates,
        *scene.velocities,
        *filter(None, scene.drives),
        *(one.name for one in scene.inputs),
        "t",
    }
    if name in taken:
        raise LinearizeError(f"--over: {name} moves; a range is of a parameter, or of a letter that formulas name")
    if name not in [one.name for one in scene.parameters]:
        if not any(re.search(rf"\b{re.escape(name)}\b", text) for text in formulas):
            there = ", ".join(one.name for one in scene.parameters) or "none"
            raise LinearizeError(
                f"--over: {name} is no parameter (they are: {there}) and in no formula; say what it does, as in "
                f'--speed "{scene.velocities[0]}={name}"'
            )
        scene = replace(scene, parameters=(*scene.parameters, Parameter(name)))
    derived: dict[Scene, Prepared] = {}
    known: dict[tuple[Scene, bool], tuple[Linearization, Linearization]] = {}
    last: list[Array] = []

    def system(value: float) -> Linearization:
        bound = bind(scene, {name: value})
        form = opened(bound).scene
        read = read_forces(bound, forces, differentiable=True) if forces else Forces()
        if form not in derived:
            derived[form] = prepared(bound, read, outputs, independent)
        asked = replace(derived[form], scene=bound, forces=read)
        start = read_start(bound, at, rates)
        still = bool(np.abs(start.u).max() <= STILL)
        like, slim = known.get((form, still), (None, None))
        found = asked.at(start.q, start.u, 0.0, start.notes, like=like)
        if not (anywhere or stays(found)):
            found = _followed(asked, found, start.q, still, last) or found
        if like is not None and slim is not None and not slim.spin.any() and stays(found):
            dropped = [found.states.names.index(one) for one in slim.dropped]
            if len(untouched(found.A, dropped)) == len(dropped):
                last[:] = [found.point.q]
                return replace(found.without(dropped), kind=slim.kind)
        known[form, still] = found, settled(asked, found, anywhere)
        last[:] = [found.point.q]
        return known[form, still][1]

    return system


def _followed(
    asked: Prepared, found: Linearization, start: Array, still: bool, last: Sequence[Array]
) -> Linearization | None:
    """Return the system at the place of rest, or the steady motion, next to the last one; None where none is near."""
    if still:
        place = nearest(asked, last[-1] if last else start)
        return None if place is None else asked.at(place, np.zeros(len(found.point.u)), like=found)
    return steady_next_to(asked, found, last[-1] if last else None)


def stays(found: Linearization) -> bool:
    """Whether the independent velocities stay at the point of a system."""
    velocities = [found.scene.velocities.index(name) for name in found.states.names[found.positions :]]
    size = max(1.0, float(np.abs(found.A[found.positions :]).max(initial=0.0)))
    return bool(np.all(np.abs(found.point.udot[velocities]) <= BALANCED * size))

"""The dimensions of a scene: of every letter, as said or as told by where it stands, and formulas that do not fit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache

from symdyn.scene.checks.draft import CLOCK, Use
from symdyn.scene.joints import JOINTS
from symdyn.scene.values.dimension import FORCE, LENGTH, TIME, TORQUE, Dimension
from symdyn.scene.values.dimensional_analysis import Analysis, Measure, Pair, Place
from symdyn.scene.values.joint import acceleration_name
from symdyn.scene.values.model import Letter, Scene
from symdyn.scene.values.signals import MULTIPLIER, REACTION
from symdyn.scene.values.table import Faults, shown
from symdyn.scene.values.unit import read_unit

ADVICE = "correct it, write the factor that is left out as a parameter with its unit"
"""What to do about a term that does not fit; a factor of one cannot be told from none."""


@cache
def dimension_of(unit: str) -> Dimension:
    """Return what a unit of ours measures."""
    return read_unit(unit).dimension


def said(scene: Scene) -> dict[str, Dimension]:
    """Return the dimension of every letter whose unit is said, or is that of a joint."""
    found = {CLOCK: TIME}
    letters: tuple[Letter, ...] = (*scene.parameters, *scene.inputs)
    for one in letters:
        if one.unit:
            found[one.name] = dimension_of(one.unit)
    for joint in scene.joints:
        kind = JOINTS[joint.type]
        found |= {q: dimension_of(unit) for q, unit in zip(joint.coordinates, kind.coordinates(joint), strict=False)}
        for k, (velocity, unit) in enumerate(zip(joint.rates, kind.velocities(joint), strict=False)):
            way = dimension_of(unit)
            found |= {velocity: way / TIME, acceleration_name(velocity): way / TIME**2}
            if k < len(joint.drives) and (drive := joint.drives[k]):
                found[drive] = FORCE if way == LENGTH else TORQUE
    return found


def known_in(scene: Scene, more: Mapping[str, Dimension] | None = None) -> Callable[[str], Dimension | None]:
    """Return what tells the dimension of a letter, None where nobody says it."""
    letters = said(scene) | dict(more or {})

    def known(name: str) -> Dimension | None:
        if name in letters:
            return letters[name]
        if name.startswith("point_"):
            return LENGTH
        if name.startswith((REACTION, MULTIPLIER)):
            parts = name.split("_")
            return next((FORCE if one[0] == "f" else TORQUE for one in parts[::-1] if one[1:] in "xyz"), None)
        return None

    return known


def analysed(scene: Scene, asked: Iterable[Use], more: Mapping[str, Dimension] | None = None) -> Analysis:
    """Return what formulas of a scene tell of dimensions."""
    found = Analysis(known_in(scene, more))
    for use in asked:
        wanted = dimension_of(use.unit) if use.unit else None
        found.add(Place(use.where, use.key, use.quantity, use.unit, wanted))
    found.solve()
    return found


def check_dimensions(scene: Scene, asked: Iterable[Use], faults: Faults) -> None:
    """Report terms of letters alone that measure something else than what is asked for, or than each other."""
    found = analysed(scene, asked)
    for pair in found.wrong:
        faults.add(pair.place.where, f"{words(pair, found)}; {ADVICE}, or {faults.unchecked}")


def words(pair: Pair, found: Analysis) -> str:
    """Return what is wrong with a pair: what was found and what was asked for."""
    place = pair.place
    front = f"{place.key} = {shown(place.formula)}"
    one, other = (_unit(found.resolved(measure)) for measure in (pair.first, pair.second))
    if pair.other is not None:
        told = f"{front}: {shown(pair.one)} is {one}, and {shown(pair.other)} is {other}"
    elif pair.function:
        told = f"{front}: {shown(pair.one)} is {one}, and {pair.function} takes a plain number"
    else:
        term = "" if pair.one == place.formula else f": {shown(pair.one)}"
        told = f"{front}{term} is {one}, and {place.unit} is asked for"
    return f"{told}{_because(pair, found)}"


def _because(pair: Pair, found: Analysis) -> str:
    """Return where the letters of a pair that say no unit were told theirs."""
    both = pair.one.symbols + (pair.other.symbols if pair.other is not None else ())
    told = []
    for name in dict.fromkeys(both):
        origin = found.origins.get(name)
        if origin is not None and origin.place != pair.place and (own := found.letter(name)) is not None:
            told.append(f"{name} is {_unit(Measure(own))} by {place_words(origin.place)}")
    return f" ({', '.join(told)})" if told else ""


def place_words(place: Place) -> str:
    """Return a place for a message."""
    return ": ".join(part for part in (place.where, f"{place.key} = {shown(place.formula)}") if part)


def _unit(measure: Measure) -> str:
    return "a plain number" if measure.text == "1" else f"in {measure.text}"

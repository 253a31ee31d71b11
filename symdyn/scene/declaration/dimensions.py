"""The dimensions of a scene: of every letter, as said or as told by where it stands, and formulas that do not fit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache

from symdyn.graph import Op
from symdyn.scene.declaration.draft import Use
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.dimension import FORCE, LENGTH, TORQUE, Dimension, force_unit
from symdyn.scene.values.dimensional_analysis import Analysis, Measure, Pair, TermPlace, terms
from symdyn.scene.values.entry import Faults, shown
from symdyn.scene.values.folding import fraction
from symdyn.scene.values.joint import acceleration_name
from symdyn.scene.values.model import Letter, Scene
from symdyn.scene.values.names import CLOCK
from symdyn.scene.values.quantity import Quantity, spell
from symdyn.scene.values.signals import LETTERS
from symdyn.scene.values.unit import Unit, UnitError, out_of_si

ADVICE = "correct it, write the factor that is left out as a parameter with its unit"
"""What to do about a term that does not fit; a factor of one cannot be told from none."""


@cache
def dimension_of(unit: str) -> Dimension:
    """Return what a unit of ours measures."""
    return Unit.read(unit).dimension


def declared_units(scene: Scene) -> dict[str, str]:
    """Return the unit of every letter whose unit is said, or is that of a joint."""
    found = {CLOCK: "s"}
    letters: tuple[Letter, ...] = (*scene.parameters, *scene.inputs)
    found |= {one.name: one.unit for one in letters if one.unit}
    for joint in scene.joints:
        kind = JOINTS[joint.type]
        found |= dict(zip(joint.coordinates, kind.coordinates(joint), strict=False))
        for k, (velocity, unit) in enumerate(zip(joint.rates, kind.velocities(joint), strict=False)):
            found |= {velocity: f"{unit}/s", acceleration_name(velocity): f"{unit}/s^2"}
            if k < len(joint.drives) and (drive := joint.drives[k]):
                found[drive] = force_unit(unit)
    return found


def known_in(units: Mapping[str, str]) -> Callable[[str], Dimension | None]:
    """Return what tells the dimension of a letter, None where nobody says it; `units` of letters, "" of silent ones."""
    letters: dict[str, Dimension] = {}
    for one, unit in units.items():
        try:
            letters |= {one: dimension_of(unit)} if unit else {}
        except UnitError:  # "m or 1", of a column
            continue

    def known(name: str) -> Dimension | None:
        if name in letters:
            return letters[name]
        if name.startswith("point_"):
            return LENGTH
        if name.startswith((LETTERS.reaction, LETTERS.multiplier)):
            parts = name.split("_")
            return next((FORCE if one[0] == "f" else TORQUE for one in parts[::-1] if one[1:] in "xyz"), None)
        return None

    return known


def analysed(scene: Scene, uses: Iterable[Use], more: Mapping[str, str] | None = None) -> Analysis:
    """Return what formulas of a scene tell of dimensions; with units of `more` letters, such as columns of runs."""
    units = declared_units(scene) | dict(more or {})
    found = Analysis(known_in(units), units)
    for use in uses:
        wanted = dimension_of(use.unit) if use.unit and not use.other else None
        found.add(TermPlace(use.where, use.key, use.quantity, use.unit, wanted))
    found.solve()
    return found


def check_dimensions(scene: Scene, uses: Iterable[Use], faults: Faults) -> None:
    """Report terms of letters alone that measure something else than what is asked for, or than each other."""
    uses = tuple(uses)
    found = analysed(scene, uses)
    for pair in found.wrong:
        faults.add(pair.place.where, f"{words(pair, found)}; {ADVICE}, or {faults.unchecked}")
    for use in (one for one in uses if one.other):
        own = found.of(use.quantity)
        if not (own.letters or own.numbers) and own.dimension not in (dimension_of(use.unit), dimension_of(use.other)):
            told = f"{use.key} = {shown(use.quantity)} is {_unit(own)}, and {use.unit} or {use.other} is asked for"
            faults.add(use.where, f"{told}; {ADVICE}, or {faults.unchecked}")
    for use, why in _cycles(scene, uses):
        faults.add(use.where, f"{use.key} = {shown(use.quantity)} {why}")


def _cycles(scene: Scene, uses: Iterable[Use]) -> Iterator[tuple[Use, str]]:
    """Yield where a letter in cycles stands alone, its sign apart, and rad/s is asked for, with both readings."""
    letters: tuple[Letter, ...] = (*scene.parameters, *scene.inputs)
    own = {one.name: (one, Unit.read(one.written or one.unit)) for one in letters if one.unit}
    for use in uses:
        name = alone(use.quantity)
        if name not in own or not use.unit or not own[name][1].cycles:
            continue
        letter, unit = own[name]
        value = None if letter.value is None else fraction(out_of_si(letter.value, unit))
        if why := unit.misfit(Unit.read(use.unit), "" if value is None else spell(value)):
            yield use, why


def alone(formula: Quantity) -> str:
    """Return the letter that a formula is, its sign apart; "" where it is more."""
    while formula.op is Op.NEG:
        (formula,) = formula.args
    return str(formula.value) if formula.op is Op.SYMBOL else ""


def doubts(scene: Scene, analysis: Analysis) -> Iterator[str]:
    """Yield what is right in SI and may be meant otherwise: letters of two dimensions, and sines of cycles."""
    told: dict[str, list[str]] = {}
    for pair in analysis.disagreeing:
        for name, _ in pair.ratio.letters:
            where = f"{pair.place.where}: " if pair.place.where else ""
            told.setdefault(name, []).append(f"{where}{words(pair, analysis)}")
    for name, places in told.items():
        yield f"{name} says no unit and stands in places of two dimensions: {'; '.join(dict.fromkeys(places))}"
    letters: tuple[Letter, ...] = (*scene.parameters, *scene.inputs)
    cyclic = {one.name for one in letters if one.unit and Unit.read(one.unit).cycles}
    for pair in analysis.pairs if cyclic else ():
        if pair.function not in ("sin", "cos"):
            continue
        for term in terms(pair.one):
            names = cyclic.intersection(term.symbols)
            if names and CLOCK in term.symbols and not _has_number(term):
                name = min(names)
                yield (
                    f"{pair.place.words}: {pair.function}({shown(pair.one)}) has {name} in cycles a second, and "
                    f"is of radians: 2*pi*{name} is the angular frequency of {name}"
                )


def _has_number(formula: Quantity) -> bool:
    return formula.op in (Op.CONSTANT, Op.PI) or any(map(_has_number, formula.args))


def words(pair: Pair, analysis: Analysis) -> str:
    """Return what is wrong with a pair: what was found and what was asked for."""
    place = pair.place
    front = f"{place.key} = {shown(place.formula)}"
    one = _unit(analysis.resolved(pair.first), pair.one, analysis)
    other = _unit(analysis.resolved(pair.second), pair.other, analysis)
    if pair.other is not None:
        told = f"{front}: {shown(pair.one)} is {one}, and {shown(pair.other)} is {other}"
    elif pair.function:
        told = f"{front}: {shown(pair.one)} is {one}, and {pair.function} takes a plain number"
    else:
        term = "" if pair.one == place.formula else f": {shown(pair.one)}"
        told = f"{front}{term} is {one}, and {place.unit} is asked for"
    return f"{told}{_because(pair, analysis)}"


def _because(pair: Pair, analysis: Analysis) -> str:
    """Return where the letters of a pair that say no unit were told theirs."""
    both = pair.one.symbols + (pair.other.symbols if pair.other is not None else ())
    told = []
    for name in dict.fromkeys(both):
        origin = analysis.origins.get(name)
        if origin is not None and origin.place != pair.place and (own := analysis.letter(name)) is not None:
            told.append(f"{name} is {_unit(Measure(own))} by {origin.place.words}")
    return f" ({', '.join(told)})" if told else ""


def _unit(measure: Measure, term: Quantity | None = None, analysis: Analysis | None = None) -> str:
    """Return what something measures; of a letter in radians a second as it says that itself."""
    own = analysis.units.get(alone(term), "") if analysis and term else ""
    if "rad/" in own or "/rad" in own:
        return f"in {own}"
    return "a plain number" if measure.text == "1" else f"in {measure.text}"

"""The dimensions and units of a scene: of every letter, as said or as told by where it stands.

Formulas that do not fit are faults. Coordinates and velocities have "rad", "m" or "1" as the joints have them. A letter
that says no unit takes the one of where it stands, as far as terms of letters alone tell it: a number that stands
beside it as a factor may carry a dimension itself.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from functools import cache, lru_cache

from symdyn.arguments import argument
from symdyn.frozen import dataclass
from symdyn.graph import Op
from symdyn.scene.declaration.draft import Draft, Use, draft_of, uses
from symdyn.scene.forces.constraints import Formula
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.dimension import FORCE, NUMBER, POWER, TORQUE, Dimension, force_unit
from symdyn.scene.values.dimensional_analysis import Analysis, Measure, Pair, TermPlace, fits, terms
from symdyn.scene.values.entry import Faults, shown
from symdyn.scene.values.folding import fraction
from symdyn.scene.values.grammar import CLOCK, LETTERS
from symdyn.scene.values.joint import Joint, acceleration_name
from symdyn.scene.values.letters import Letter, Parameter
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import Quantity, spell
from symdyn.scene.values.unit import Unit, UnitError, out_of_si, with_unit

ADVICE = "correct it, write the factor that is left out as a parameter with its unit"
"""What to do about a term that does not fit; a factor of one cannot be told from none."""


@cache
def dimension_of(unit: str) -> Dimension:
    """Return what a unit of ours measures."""
    return Unit.read(unit).dimension


def declared_units(scene: Scene) -> dict[str, str]:
    """Return the unit of every letter whose unit is said, or is that of a joint."""
    found = {CLOCK: "s"} | strut_units(scene)
    found |= {one.name: one.unit for one in scene.letters if one.unit}
    for joint in scene.joints:
        kind = JOINTS[joint.type]
        found |= dict(zip(joint.coordinates, kind.coordinates(joint), strict=False))
        for k, (velocity, unit) in enumerate(zip(joint.rates, kind.velocities(joint), strict=False)):
            found |= {velocity: f"{unit}/s", acceleration_name(velocity): f"{unit}/s^2"}
            if k < len(joint.drives) and (drive := joint.drives[k]):
                found[drive] = force_unit(unit)
    return found


def strut_units(scene: Scene) -> dict[str, str]:
    """Return the units of what formulas of outputs call forces and lengths of struts."""
    found = dict[str, str]()
    units = {joint.name: unit for joint in scene.joints for unit in JOINTS[joint.type].coordinates(joint)[:1]}
    for strut in scene.struts:
        force = "N" if strut.ends else force_unit(units.get(strut.joint, ""))  # "" of a joint that is not there
        unit = {"force": force, "length": "m", "rate": "m/s"}
        found |= {name: unit[what] for name, what in LETTERS.of_strut(strut).items()}
    return found


def known_in(units: Mapping[str, str]) -> Callable[[str], Dimension | None]:
    """Return what implies the dimension of a symbol, None for nothing; `units` by symbol, "" where none is given."""
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
            return dimension_of(LETTERS.point_unit(name))
        if name.startswith(LETTERS.tension):
            return FORCE
        if name in LETTERS.energies:
            return TORQUE  # J
        if name.startswith((LETTERS.reaction, LETTERS.multiplier)):
            parts = name.split("_")
            return next((FORCE if one[0] == "f" else TORQUE for one in parts[::-1] if one[1:] in "xyz"), None)
        return None

    return known


def analysed(scene: Scene, uses: Iterable[Use], more: Mapping[str, str] | None = None) -> Analysis:
    """Return what formulas of a scene tell of dimensions; with units of `more` letters, such as columns of runs."""
    units = declared_units(scene) | dict(more or {})
    found = Analysis(known_in(units), units, frozenset(one.name for one in scene.parameters if one.unit))
    for use in uses:
        wanted = dimension_of(use.unit) if use.unit and not use.other else None
        found.add(TermPlace(use.where, use.key, use.quantity, use.unit, wanted))
    found.solve()
    return found


def check_units(draft: Draft, faults: Faults, dimensions: bool) -> None:
    """Every value that was written with a unit is in one that fits where it stands; and every formula fits there."""
    formulas, parameters = [], {one.name for one in draft.scene.parameters}
    known = known_in(declared_units(draft.scene))
    named = {where for kind in ("outputs", "states", "signals") for where in draft.where[kind]}
    for use in uses(draft):
        if use.quantity.op is not Op.CONSTANT and use.quantity.symbols:
            formulas += [use] if parameters.union(use.allowed).issuperset(use.quantity.symbols) else []
        elif use.quantity.unit:
            either = use.other and Unit.read(use.quantity.unit).misfit(Unit.read(use.other)) is None
            unit = use.other if either else use.unit
            try:
                letters = {name: known(name) for name in parameters.union(use.allowed)}
                fits(use.quantity, Unit.read(unit) if unit else None, letters, use.key if use.where in named else "")
            except UnitError as error:
                asked = f"{use.unit} or {use.other}" if use.other else use.unit
                why = str(error).replace(f"{use.unit} is asked", f"{asked} is asked")
                told = with_unit(use.quantity, use.quantity.unit).replace(" ", "", use.quantity.tight)
                faults.add(use.where, f'{use.key} = "{told}" {why}')
    if formulas and dimensions:
        _check_dimensions(draft.scene, formulas, faults)


def _check_dimensions(scene: Scene, uses: Iterable[Use], faults: Faults) -> None:
    """Report terms that measure something else than is asked for; a parameter that fits nowhere at its own line."""
    uses = tuple(use for use in uses if not faults.told(use.where, "has "))  # what it is at is not known
    found = analysed(scene, uses)
    ratios = [(pair, pair.ratio) for pair in found.pairs] if found.wrong else []
    right = {one for pair, by in ratios if not by.letters and by.dimension == NUMBER for one in _symbols(pair)}
    alone = {one for pair in found.wrong for one in _symbols(pair) if {*_symbols(pair)} == {one}}
    for pair in found.wrong:
        where, told = pair.place.where, words(pair, found)
        if blamed := sorted((alone & found.said - right).intersection(_symbols(pair))):
            told = f"{blamed[0]} fits nowhere: {': '.join(filter(None, (where, told)))}"
            where = f"parameters.{blamed[0]}"
        if not (blamed and faults.told(where, f"{blamed[0]} fits")):
            faults.add(where, f"{told}; {ADVICE}, or {faults.unchecked}")
    for use in (one for one in uses if one.other):
        own = found.of(use.quantity)
        if not (own.letters or own.numbers) and own.dimension not in (dimension_of(use.unit), dimension_of(use.other)):
            told = f"{use.key} = {shown(use.quantity)} is {_unit(own)}, and {use.unit} or {use.other} is asked for"
            faults.add(use.where, f"{told}; {ADVICE}, or {faults.unchecked}")
    for use, why in _cycles(scene, uses):
        faults.add(use.where, f"{use.key} = {shown(use.quantity)} {why}")


def _cycles(scene: Scene, uses: Iterable[Use]) -> Iterator[tuple[Use, str]]:
    """Yield where a letter in cycles stands alone, its sign apart, and rad/s is asked for, with both readings."""
    own = {one.name: (one, Unit.read(one.written or one.unit)) for one in scene.letters if one.unit}
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
    while formula.op in (Op.ABS, Op.NEG):
        (formula,) = formula.args
    return str(formula.value) if formula.op is Op.SYMBOL else ""


def doubts(scene: Scene, analysis: Analysis) -> Iterator[str]:
    """Yield what is right in SI and may be meant otherwise: symbols of two dimensions, and sines of cycles."""
    found: dict[str, list[str]] = {}
    for pair in analysis.disagreeing:
        for name, _ in pair.ratio.letters:
            where = f"{pair.place.where}: " if pair.place.where else ""
            found.setdefault(name, []).append(f"{where}{words(pair, analysis)}")
    for name, places in found.items():
        yield f"{name} has no unit and is used with two dimensions: {'; '.join(dict.fromkeys(places))}"
    cyclic = {one.name for one in scene.letters if one.unit and Unit.read(one.unit).cycles}
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
    told = []
    for name in dict.fromkeys(_symbols(pair)):
        origin = analysis.origins.get(name)
        if origin is not None and origin.place != pair.place and (own := analysis.letter(name)) is not None:
            told.append(f"{name} is {_unit(Measure(own))} by {origin.place.words}")
    return f" ({', '.join(told)})" if told else ""


def _symbols(pair: Pair) -> tuple[str, ...]:
    return pair.one.symbols + (pair.other.symbols if pair.other is not None else ())


def _unit(measure: Measure, term: Quantity | None = None, analysis: Analysis | None = None) -> str:
    """Return what something measures; of a letter in radians a second as it says that itself."""
    own = analysis.units.get(alone(term), "") if analysis and term else ""
    if "rad/" in own or "/rad" in own:
        return f"in {own}"
    return "a plain number" if measure.text == "1" else f"in {measure.text}"


PLAIN_NUMBERS = (Quantity.number(2), Quantity.number(Fraction(1, 2)), Quantity.PI)
"""Factors of areas, energies and circles, which carry no dimension where the unit of an output is told."""


JOULE, ENERGY = "J", re.compile(r"(?<![a-z])(energy|work)(?![a-z])")
"""The unit of an energy, and what names of energies have in them as words."""


@dataclass(frozen=True)
class SceneUnits:
    """The units of a scene's letters, and of formulas in them."""

    scene: Scene

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The unit of every coordinate, shape (nq,)."""
        return tuple(unit for joint in self.scene.moving for unit in JOINTS[joint.type].coordinates(joint))

    @property
    def velocities(self) -> tuple[str, ...]:
        """The unit of every velocity but for its second, shape (nv,): "rad" of rad/s."""
        return tuple(unit for joint in self.scene.moving for unit in JOINTS[joint.type].velocities(joint))

    def each_coordinate(self) -> Iterator[tuple[Joint, str, str]]:
        """Yield every coordinate, in order, with its joint and its unit."""
        for joint in self.scene.moving:
            yield from (
                (joint, q, unit)
                for q, unit in zip(joint.coordinates, JOINTS[joint.type].coordinates(joint), strict=True)
            )

    def each_drive(self) -> Iterator[tuple[Joint, str, str]]:
        """Yield every drive, in order, with its joint and its unit, "N m" or "N"."""
        for joint in self.scene.moving:
            for drive, unit in zip(joint.drives, JOINTS[joint.type].velocities(joint), strict=False):
                if drive:
                    yield joint, drive, force_unit(unit)

    @property
    def letters(self) -> dict[str, str]:
        """The coherent unit of every symbol that takes a value, "" where it is not known."""
        found = self.inferred | {"t": "s"}
        found |= dict(zip(self.scene.coordinates, self.coordinates, strict=True))
        for velocity, drive, unit in zip(self.scene.velocities, self.scene.drives, self.velocities, strict=True):
            found |= {velocity: f"{unit}/s", acceleration_name(velocity): f"{unit}/s^2"}
            found |= {drive: force_unit(unit)} if drive else {}
        return found

    def letter(self, name: str) -> Letter:
        """Return the letter of a name; one that has no value of its own, such as a coordinate, with its unit."""
        letters: tuple[Letter, ...] = (*self.scene.parameters, *self.scene.inputs)
        unit = self.letters.get(name, "")
        return next((one for one in letters if one.name == name), None) or Parameter(name, unit=unit)

    @property
    def inferred(self) -> dict[str, str]:
        """The coherent unit of every parameter and input: as it says, or as where it stands tells; else ""."""
        found = {one.name: one.unit for one in self.scene.letters}
        silent = [name for name, unit in found.items() if not unit]
        if silent and not self.scene.dimensionless:
            known = self.dimensions
            found |= {name: _unit_of(name, known) for name in silent if name in known.certain}
        return found

    @property
    def written(self) -> dict[str, str]:
        """The values of parameters and inputs as their writer said them, "500 mm", where that is no unit of SI."""
        letters = self.scene.letters
        said = {one.name: (one.value, one.written or one.value.unit) for one in letters if one.value is not None}
        return {
            name: with_unit(x, unit) for name, (x, unit) in said.items() if unit and not Unit.read(unit).is_coherent
        }

    @property
    def outputs(self) -> dict[str, str]:
        """The unit of every output, as given or as its formula shows; else ""."""
        return {one.name: one.unit or self.of_formula(one.formula, {}, one.name) for one in self.scene.outputs}

    @property
    def constraints(self) -> dict[str, str]:
        """The unit of the multiplier of every formula and rope, by the row's name; "" where it is not known.

        The multiplier times the formula is a power: N where the formula is a speed in m/s, N m where one in rad/s.
        """
        rows = [row for row in self.scene.constraints if isinstance(row, Formula)]
        ropes = {row.name: self.scene.shown_unit("N") for row in self.scene.lasting_ropes}
        if not rows or self.scene.dimensionless:
            return ropes | {row.name: "" for row in rows}
        found = {row.name: self.dimensions.of(row.formula) for row in rows}
        return ropes | {k: "" if x.letters or x.numbers else (POWER / x.dimension).text for k, x in found.items()}

    @property
    def dimensions(self) -> Analysis:
        """What the formulas of the scene imply for the dimensions of its symbols."""
        return _analysis(self.scene)

    def of_formula(self, formula: Quantity, columns: Mapping[str, str], called: str = "") -> str:
        """Return the unit of what a formula looks at, "" where a number in it may carry one, or nothing tells.

        Factors of 2, 1/2 and pi are taken as plain. Dimensions tell no energy from a torque: m*v**2/2 is in N m, unless
        one of its terms is in J, or it is called an energy or a work.

        Args:
            formula: in its letters and in columns of runs.
            columns: units of these.
            called: the name of what it stands for.
        """
        units = self.letters | dict(columns)
        names = [alone(term) for term in terms(formula)]
        if self.scene.dimensionless:
            return self.inferred.get(names[0], "")
        energy = any(units.get(name) == JOULE for name in names) or ENERGY.search(called)
        found = units[names[0]] if names[0] in units else _looked_at(self.scene, formula, units)
        return JOULE if energy and found == TORQUE.text else found

    def check(
        self, formula: Quantity, where: str, faults: Faults, columns: Mapping[str, str] | None = None,
        unit: str = "", place: str = "",
    ) -> None:  # fmt: skip
        """Report terms of letters alone that do not measure the same, in a formula that looks at a scene.

        One that is given for something in a `unit` has to be in it: each term in which a symbol stands that says its
        own, as in sin(t) and -x a factor of 1 is left out. At a `place` "bodies." factors count as they do there.
        """
        said = frozenset(one.name for one in self.scene.letters if one.unit)
        parts = [one for one in terms(formula) if said & {*one.symbols}] if unit else [formula]
        if self.scene.dimensionless or not formula.symbols:
            return
        silent = {one.name: "" for one in self.scene.letters if not one.unit}
        known = self.letters | silent | dict(columns or {})
        found = analysed(self.scene, [Use(place, "", one, unit=unit) for one in parts], known)
        for pair in found.wrong:
            if unit and said.isdisjoint(_symbols(pair)):
                continue
            told = words(pair, found).removeprefix(" = ")
            unchecked = Faults(self.scene.source).unchecked
            asking = argument("no_units", True, 'units="none"')
            asked = unchecked if asking in unchecked else f"{unchecked} of the scene"
            asked += f", or ask with {asking}" * (asked != unchecked and asking.startswith("--"))  # a flag of all verbs
            faults.add(where, f"{told}; {ADVICE}, or {asked}")

    @property
    def doubtful(self) -> tuple[str, ...]:
        """What is to be said of dimensions that are no fault: letters of two, and sines of cycles."""
        return () if self.scene.dimensionless else tuple(dict.fromkeys(doubts(self.scene, self.dimensions)))

    @property
    def mistakable(self) -> tuple[str, ...]:
        """Notes on values whose unit is also the name of a symbol of the scene."""
        scene, letters = self.scene, self.letters
        nouns = (scene.gravity, *scene.parameters, *scene.bodies, *scene.joints, *scene.points, *scene.loops)
        told = []
        for one in Quantity.inside((*nouns, *scene.elements, *scene.given, *scene.outputs)):
            both = [name for name in re.findall(r"[^\W\d_]+", one.unit) if name in letters]
            if both:
                value = with_unit(one, one.unit)
                told.append(f"{value} is a number and a unit: {both[0]} is not the scene's symbol there")
        return tuple(dict.fromkeys(told))


def _unit_of(name: str, known: Analysis) -> str:
    """Return the unit of a letter that was told one: as its place says it, where it stands alone there."""
    place = known.origins[name].place
    alone = (
        place.unit
        and place.formula.symbols == (name,)
        and place.formula in (Quantity.symbol(name), -Quantity.symbol(name))
    )
    return place.unit if alone else known.certain[name].text


@lru_cache(16)
def _analysis(scene: Scene) -> Analysis:
    return analysed(scene, (use for use in uses(draft_of(scene)) if use.quantity.symbols))


def _looked_at(scene: Scene, formula: Quantity, units: Mapping[str, str]) -> str:
    if not formula.symbols:
        return ""
    found = analysed(scene, (), units).of(formula)
    return "" if found.letters or any(one not in PLAIN_NUMBERS for one, _ in found.numbers) else found.dimension.text

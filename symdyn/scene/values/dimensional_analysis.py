"""Dimensional analysis of formulas: every term measures what is asked for, and letters without a unit take theirs.

A formula is walked term by term. What is added has one dimension, what a sine takes is a plain number, and what stands
where metres are asked for is in metres: each of these is an equation between products of powers of letters. A letter
whose dimension is not known is an unknown of these equations, which are linear in the exponents, so that elimination
tells it. A number that stands as a factor, pi among them, may carry a dimension: an equation with such a number is
taken last, tells letters as if the number were plain, and where that cannot be it tells what the number would have to
be; a factor of shapes, such as 1/12 beside parameters that all say units, excuses none of them. Where a letter that
says no unit stands in places of two dimensions, nothing is refused: they are told.

Quantities that were written with a unit are checked alone: whether it fits where they stand, and how they are written
again. Where a run gives a bare number to a letter that is in its writer's unit, "500 mm", it is asked for.

Reference: Buckingham, On physically similar systems, Physical Review 4 (1914); Kennedy, Dimension types (1994), for
unknown dimensions by elimination.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from math import isfinite
from numbers import Real
from types import MappingProxyType
from typing import NamedTuple

from symdyn.errors import SceneError, listed
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Op
from symdyn.scene.values import folding
from symdyn.scene.values.dimension import NUMBER, Dimension, Exponent, product
from symdyn.scene.values.entry import EntryReader, shown
from symdyn.scene.values.folding import fraction
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.letters import Letter
from symdyn.scene.values.quantity import FormulaError, Quantity, spell
from symdyn.scene.values.unit import Unit, UnitError, out_of_si, with_unit

Powers = tuple[tuple[str, Exponent], ...]

PLAIN = {Op.SIN: "sin", Op.COS: "cos", Op.EXP: "exp", Op.LOG: "log", Op.TANH: "tanh"}
"""Functions of plain numbers, which give one."""


class Measure(NamedTuple):
    """What an expression measures: a dimension times powers of letters whose own is not known.

    Attributes:
        dimension: of what is known of it.
        letters: the others and their powers.
        numbers: constants that stand in it as factors, each of which may carry a dimension, and their powers.
    """

    dimension: Dimension = NUMBER
    letters: Powers = ()
    numbers: tuple[tuple[Quantity, Exponent], ...] = ()

    def times(self, other: Measure, power: Exponent = 1) -> Measure:
        """Return what the product with a power of another one measures."""
        if not other.letters:
            letters = self.letters
        elif not self.letters and power == 1:
            letters = other.letters
        else:
            powers = dict(self.letters)
            for name, own in other.letters:
                powers[name] = powers.get(name, 0) + own * power
            letters = tuple((name, own) for name, own in powers.items() if own)
        dimension = other.dimension if power == 1 else other.dimension**power
        numbers = tuple((one, own * power) for one, own in other.numbers) if other.numbers else ()
        return Measure(self.dimension * dimension, letters, self.numbers + numbers)

    @property
    def text(self) -> str:
        """The unit of it, letters that are not known as letters."""
        known = self.dimension.text
        unknown = product(self.letters)
        return known if not self.letters else unknown if known == "1" else f"{known} {unknown}"


@dataclass(frozen=True)
class TermPlace:
    """Where a formula stands, and the unit that is asked for there, None where any will do."""

    where: str
    key: str
    formula: Quantity
    unit: str
    expected: Dimension | None

    @property
    def words(self) -> str:
        return ": ".join(part for part in (self.where, f"{self.key} = {shown(self.formula)}") if part)


class Pair(NamedTuple):
    """Two things that measure the same.

    Attributes:
        place: where.
        one, other: the terms; the other is None of what is asked for, or of a plain number.
        first, second: what they measure.
        function: whose argument it is, "" elsewhere.
    """

    place: TermPlace
    one: Quantity
    other: Quantity | None
    first: Measure
    second: Measure
    function: str = ""

    @property
    def ratio(self) -> Measure:
        """What the first measures over what the second does, which is a plain number."""
        return self.first.times(self.second, -1)


@dataclass(frozen=True)
class Origin:
    """What told the dimension of a letter: a place, and the number beside the letter that was taken as plain."""

    place: TermPlace
    plain: Quantity | None = None


@dataclass(frozen=True)
class Carried:
    """A number that has to carry a dimension."""

    place: TermPlace
    number: Quantity
    dimension: Dimension


@dataclass
class Analysis:
    """The equations between dimensions of some formulas, and what they tell.

    Attributes:
        known: the dimension of a letter, None where no one says it.
        units: of letters, as they say them, for messages.
        said: parameters whose units are said.
        certain: the dimensions that terms of letters alone tell.
        pairs: all of them, as `add` found them.
        inferred: unknown letters in terms of others.
        origins: which place told each letter.
        wrong: pairs of letters alone, the units of which are said, that do not measure the same.
        disagreeing: such pairs with letters that say no unit, so that these stand in places of two dimensions.
        carried: numbers that have to carry a dimension.
    """

    known: Callable[[str], Dimension | None]
    units: Mapping[str, str] = field(default_factory=dict)
    said: frozenset[str] = frozenset()
    certain: dict[str, Dimension] = field(default_factory=dict)
    pairs: list[Pair] = field(default_factory=list)
    inferred: dict[str, Measure] = field(default_factory=dict)
    origins: dict[str, Origin] = field(default_factory=dict)
    wrong: list[Pair] = field(default_factory=list)
    disagreeing: list[Pair] = field(default_factory=list)
    carried: list[Carried] = field(default_factory=list)

    def add(self, place: TermPlace) -> None:
        """Take up a formula; a number alone measures whatever is asked for."""
        if not place.formula.symbols:
            return
        wanted = Measure() if place.expected is None else Measure(place.expected)
        parts = [(part, self._measure(part, place)) for part in terms(place.formula)]
        alone = next(((part, own) for part, own in parts if not own.numbers), parts[0])
        for part, own in parts:
            if part is alone[0]:
                continue
            if own.numbers and place.expected is not None:
                self.pairs.append(Pair(place, part, None, own, wanted))
            else:
                self.pairs.append(Pair(place, alone[0], part, alone[1], own))
        if place.expected is not None:
            whole = place.formula if len(parts) == 1 or not alone[1].numbers else alone[0]
            self.pairs.append(Pair(place, whole, None, alone[1], wanted))

    def solve(self) -> None:
        """Work out the letters: by terms of letters alone, in order, then with pi, then with numbers."""
        ratios = [(pair, pair.ratio) for pair in self.pairs]
        for pair, ratio in ratios:
            if not ratio.numbers:
                self._take(pair, ratio)
        for pair, ratio in ratios:
            if ratio.numbers and _only_pi(ratio):
                self._take(pair, ratio)
        doubted = {name for pair in self.disagreeing for name, _ in pair.ratio.letters}
        self.certain = {
            name: found for name in self.inferred if name not in doubted and (found := self.letter(name)) is not None
        }
        for pair, ratio in ratios:
            if not _only_pi(ratio):
                self._take(pair, ratio)

    def resolved(self, measure: Measure) -> Measure:
        """Return what something measures, by all that is told by now."""
        for name, _ in measure.letters:
            if name in self.inferred:
                self._shorten(name)
        return self._put_in(measure)

    def _put_in(self, measure: Measure) -> Measure:
        """Return something with letters that are told replaced by what they are told to be, once."""
        if not any(name in self.inferred for name, _ in measure.letters):
            return measure
        found = Measure(measure.dimension, tuple(one for one in measure.letters if one[0] not in self.inferred))
        for name, power in measure.letters:
            if name in self.inferred:
                found = found.times(self.inferred[name], power)
        return found

    def _shorten(self, name: str) -> None:
        """Write a told letter in terms of letters that are not told, and so those on the way, each way walked once."""
        way = [name]
        while way:
            letters = [one for one, _ in self.inferred[way[-1]].letters if one in self.inferred]
            longer = [one for one in letters if any(x in self.inferred for x, _ in self.inferred[one].letters)]
            if longer:
                way.append(longer[0])
            else:
                last = way.pop()
                self.inferred[last] = self._put_in(self.inferred[last])

    def of(self, formula: Quantity) -> Measure:
        """Return what a formula that was added measures as a whole."""
        parts = [self.resolved(self._measure(part, None)) for part in terms(formula)]
        return next((own for own in parts if not own.numbers), parts[0])

    def letter(self, name: str) -> Dimension | None:
        """Return the dimension of a letter, None where nothing tells it."""
        found = self.known(name)
        if found is None and name in self.inferred:
            measure = self.resolved(self.inferred[name])
            return None if measure.letters else measure.dimension
        return found

    def _take(self, pair: Pair, ratio: Measure) -> None:
        left = self.resolved(ratio)
        number, own = _number(ratio) if ratio.numbers else (None, 1)
        if left.letters:
            name, power = left.letters[0]
            others = tuple(one for one in left.letters if one[0] != name)
            self.inferred[name] = Measure().times(Measure(left.dimension, others), Fraction(-1) / power)
            self.origins[name] = Origin(pair.place, number)
        elif left.dimension != NUMBER and number is None:
            (self.disagreeing if ratio.letters else self.wrong).append(pair)
        elif left.dimension != NUMBER and number is not None:
            carried = Carried(pair.place, number, left.dimension ** (Fraction(-1) / own))
            letters = [_measured(one) for one in (pair.one, pair.other) if one is not None]
            plain = all(_of_shapes(one) for one, _ in ratio.numbers) and all(set() < x <= self.said for x in letters)
            body = pair.place.where.startswith("bodies.")  # in forces 2 may be a gain
            if body and plain and min(carried.dimension.exponents) < 0:  # else a mass or a length of 1 may be left out
                self.wrong.append(pair)
            else:
                self.carried.append(carried)

    def _measure(self, q: Quantity, place: TermPlace | None) -> Measure:
        """Return what an expression measures; of a place, equations of its parts are written down."""
        op = q.op
        if op in (Op.CONSTANT, Op.PI) or (op in (*PLAIN, Op.ATAN2) and not q.symbols):
            return Measure(numbers=((q, 1),))
        if op is Op.SYMBOL:
            name = str(q.value)
            dimension = self.known(name)
            return Measure(letters=((name, 1),)) if dimension is None else Measure(dimension)
        if op in (Op.NEG, Op.ABS):
            return self._measure(q.args[0], place)
        if op in (Op.MUL, Op.DIV):
            above = Measure() if q.args[0] == Quantity.ONE else self._measure(q.args[0], place)  # of 1/x as of x**-1
            return above.times(self._measure(q.args[1], place), 1 if op is Op.MUL else -1)
        if op is Op.SQRT:
            inner = self._measure(q.args[0], place)
            return Measure().times(inner, Fraction(1, 2))
        if op in PLAIN:
            inner = self._measure(q.args[0], place)
            if place is not None:
                self.pairs.append(Pair(place, q.args[0], None, inner, Measure(), PLAIN[op]))
            return Measure()
        if op is Op.SIGN:
            self._measure(q.args[0], place)
            return Measure()
        if op is Op.POW:
            return self._power(q.args[0], q.args[1], place)
        if q.value is not None:
            for arg in q.args:
                self._measure(arg, place)
            return Measure(letters=((spell(replace(q, args=())), 1),))  # as of a letter whose unit is not said
        if op is Op.SELECT:
            self._measure(q.args[0], place)
            return self._alike([part for part in q.args[1:] if part != Quantity.ZERO], place)
        parts = q.args if op is Op.ATAN2 else terms(q)
        found = self._alike([part for part in parts if part != Quantity.ZERO], place)
        return Measure() if op is Op.ATAN2 else found

    def _power(self, base: Quantity, exponent: Quantity, place: TermPlace | None) -> Measure:
        """Return what a power measures: of a letter as exponent, a plain number to a plain number."""
        inner, number = self._measure(base, place), fraction(exponent)
        if number is not None:
            return Measure().times(inner, number)
        if place is not None:
            front = f"the power **{spell(exponent)}"
            self.pairs.append(Pair(place, base, None, inner, Measure(), front))
            self.pairs.append(Pair(place, exponent, None, self._measure(exponent, place), Measure(), "an exponent"))
        return Measure()

    def _alike(self, parts: Sequence[Quantity], place: TermPlace | None) -> Measure:
        """Return what all terms of a sum measure: as one of letters alone does, where there is one."""
        measures = [self._measure(part, place) for part in parts]
        if not parts:
            return Measure()
        first = next((k for k, one in enumerate(measures) if not one.numbers), 0)
        if place is not None:
            self.pairs += [
                Pair(place, parts[first], part, measures[first], own)
                for k, (part, own) in enumerate(zip(parts, measures, strict=True))
                if k != first
            ]
        return measures[first]


def _of_shapes(number: Quantity) -> bool:
    """Tell whether a number is 2, pi or a fraction of areas, volumes and inertias, as 1/2, 2/5, 1/12; 0.1 is none."""
    found = fraction(number) or Fraction(0)
    return number.op is Op.PI or abs(found) == 2 or found.denominator in (2, 3, 4, 5, 6, 8, 12)


def _measured(q: Quantity) -> set[str]:
    """Return the letters of a formula that tell what it measures: none in sines."""
    inner = () if q.op in PLAIN else map(_measured, q.args)
    return {str(q.value)} if q.op is Op.SYMBOL else set[str]().union(*inner)


def _only_pi(measure: Measure) -> bool:
    """Tell whether all numbers in something, if there are any, are pi."""
    return all(number.op is Op.PI for number, _ in measure.numbers)


def _number(measure: Measure) -> tuple[Quantity, Exponent]:
    """Return the number in something that may carry a dimension, and its power: the product of those of one power."""
    first, power = measure.numbers[0]
    for number, own in measure.numbers[1:]:
        first = folding.mul(first, number) if own == power else first
    return first, power


def terms(q: Quantity) -> Iterator[Quantity]:
    """Yield the terms of a sum, signs left out."""
    if q.op in (Op.ADD, Op.SUB):
        yield from terms(q.args[0])
        yield from terms(q.args[1])
    elif q.op is Op.NEG and q.args[0].op in (Op.ADD, Op.SUB):
        yield from terms(q.args[0])
    else:
        yield q


def ask_for_units(letters: Iterable[Letter], given: Iterable[tuple[str, object]], option: str) -> None:
    """Look whether bare numbers were given for letters that are in another unit than that of SI, see `question`.

    Raises:
        SceneError: there are such, and what may be meant.
    """
    chosen = {one.name: one for one in letters}
    told = (question(chosen[name], raw) for name, raw in given if name in chosen)
    if asked := [f"{option}: {one}" for one in told if one]:
        raise SceneError(asked)


NEAR, FAR = 10.0, 30.0
"""Times a scene's value that a number is at most in the unit of its text, and at least in SI, if it may be meant so."""


def question(letter: Letter, raw: object, spread: bool = False) -> str:
    """Return what a bare number may mean for a symbol in another unit than that of SI; "" where it is clear.

    Text says its unit. Other numbers are in SI; one far from the letter's value there and near it in its own unit, such
    as 100 where the scene says "150 g", is asked about; so is a standard deviation, `spread`, above a third of it.
    """
    asked = _is_bare(raw) if isinstance(raw, str) else _meant_otherwise(letter, raw, spread)
    if not letter.written or not asked:
        return ""
    number = fraction(quantity(raw))
    size = Quantity.ONE if number is None else folding.constant(number)
    ways = (f"{letter.name}={spell(size)}{unit}" for unit in (letter.written, letter.unit))
    return f"{letter.name} is given in {letter.written}: write {' or '.join(ways)}, whichever is meant"


def _meant_otherwise(letter: Letter, raw: object, spread: bool) -> bool:
    value = letter.value.at({}) if letter.written and letter.value is not None else None
    if not value or not isinstance(raw, Real) or not raw or not isfinite(raw):
        return False
    ratio = abs(float(raw) / float(value))
    inside = ratio * Unit.read(letter.written).size
    return inside < NEAR and (3 * ratio > 1 if spread else not 1 / FAR < ratio < FAR and inside > 1 / NEAR)


def _is_bare(text: str) -> bool:
    """Tell whether a text is a number without a unit, other than zero, which is zero in all of them."""
    try:
        found = quantity(text)
    except FormulaError:
        return False
    return not (found.unit or found.symbols or found == Quantity.ZERO)


def fits(
    value: Quantity, unit: Unit | None, letters: Mapping[str, Dimension | None] = MappingProxyType({}), key: str = ""
) -> None:
    """Look whether a value, where it was written with a unit, is of the kind of another one, None where none is told.

    A formula may name `letters` there, each with what it measures; `key` is the value's where its table has a unit.

    Raises:
        UnitError: it is not; or a product of letters fits as well, which 3m may be and, where no unit is known, 3 m.
    """
    if not value.unit:
        return
    own, names = Unit.read(value.unit), re.findall(r"[^\W\d]\w*|[^\w\s*/^()-]", value.unit)
    size = out_of_si(value, own)
    number = fraction(size)
    reason = unit and own.misfit(unit, "" if number is None else spell(number))
    told = ""
    if names and all(name in letters for name in names):
        factors = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", value.unit).replace("^", "**")
        noun = "the symbol" if len(names) == 1 else "the symbols"
        told = f"; for {spell(size)} times {noun} write {spell(size)}*{factors}"
        made = Analysis(letters.get).of(quantity(factors))
        if not reason and (unit is None or (value.tight and (made.letters or made.dimension == unit.dimension))):
            reason = f"is in {value.unit}, and {listed(names)} {'is' if len(names) == 1 else 'are'} named here as well"
            written = with_unit(value, value.unit)
            both = f'{key} = "{written}", unit = "{own.si}{" s" * (key == "rate")}"' if key else spell(value)
            told += f", for the unit {written if unit else both}"
    if reason:
        raise UnitError(f"{reason}{told}")


def fits_place(table: EntryReader, key: str, value: Quantity, units: Sequence[str]) -> None:
    """Report a value in none of the units that may stand there; for what loses its unit as it is read."""
    try:
        if value.unit and all(Unit.read(value.unit).misfit(Unit.read(one)) for one in units):
            fits(value, Unit.read(units[0]))
    except UnitError as error:
        table.refuse(key, error)

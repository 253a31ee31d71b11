"""The units of a scene's letters; of coordinates and velocities "rad", "m" or "1" as the joints have them.

A letter that says no unit takes the one of where it stands, as far as terms of letters alone tell it: a number that
stands beside it as a factor may carry a dimension itself.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from symdyn.graph import Op
from symdyn.scene.declaration.dimensions import ADVICE, analysed, doubts, words
from symdyn.scene.declaration.draft import Use, draft_of, uses
from symdyn.scene.forces.velocity_row import Formula
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.dimension import POWER, TORQUE, force_unit
from symdyn.scene.values.dimensional_analysis import Analysis, terms
from symdyn.scene.values.entry import Faults
from symdyn.scene.values.joint import Joint, acceleration_name
from symdyn.scene.values.model import Letter, Scene
from symdyn.scene.values.quantity import Quantity
from symdyn.scene.values.requested_units import with_unit
from symdyn.scene.values.unit import Unit

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
        """The coherent unit of every letter that somebody gives a value, "" of one that nothing tells."""
        found = self.inferred | {"t": "s"}
        found |= dict(zip(self.scene.coordinates, self.coordinates, strict=True))
        for velocity, drive, unit in zip(self.scene.velocities, self.scene.drives, self.velocities, strict=True):
            found |= {velocity: f"{unit}/s", acceleration_name(velocity): f"{unit}/s^2"}
            found |= {drive: force_unit(unit)} if drive else {}
        return found

    @property
    def inferred(self) -> dict[str, str]:
        """The coherent unit of every parameter and input: as it says, or as where it stands tells; else ""."""
        letters: tuple[Letter, ...] = (*self.scene.parameters, *self.scene.inputs)
        found = {one.name: one.unit for one in letters}
        silent = [name for name, unit in found.items() if not unit]
        if silent and not self.scene.dimensionless:
            known = self.dimensions
            found |= {name: _unit_of(name, known) for name in silent if name in known.certain}
        return found

    @property
    def written(self) -> dict[str, str]:
        """The values of parameters and inputs as their writer said them, "500 mm", where that is no unit of SI."""
        letters: tuple[Letter, ...] = (*self.scene.parameters, *self.scene.inputs)
        said = {one.name: (one.value, one.written or one.value.unit) for one in letters if one.value is not None}
        return {
            name: with_unit(x, unit) for name, (x, unit) in said.items() if unit and not Unit.read(unit).is_coherent
        }

    @property
    def outputs(self) -> dict[str, str]:
        """The unit of every output, as it says or as its formula tells; else ""."""
        return {one.name: one.unit or self.of_formula(one.formula, {}, one.name) for one in self.scene.outputs}

    @property
    def rows(self) -> dict[str, str]:
        """The unit of the multiplier of every row that is a formula, by its name; "" where nothing tells it.

        The multiplier times the formula is a power: N where the formula is a speed in m/s, N m where one in rad/s.
        """
        rows = [row for row in self.scene.rows if isinstance(row, Formula)]
        if not rows or self.scene.dimensionless:
            return {row.name: "" for row in rows}
        found = {row.name: self.dimensions.of(row.formula) for row in rows}
        return {k: "" if x.letters or x.numbers else (POWER / x.dimension).text for k, x in found.items()}

    @property
    def dimensions(self) -> Analysis:
        """What the formulas of the scene tell of the dimensions of its letters."""
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
        names = [_alone(term) for term in terms(formula)]
        if self.scene.dimensionless:
            return self.inferred.get(names[0], "")
        energy = any(units.get(name) == JOULE for name in names) or ENERGY.search(called)
        found = units[names[0]] if names[0] in units else _looked_at(self.scene, formula, units)
        return JOULE if energy and found == TORQUE.text else found

    def check(self, formula: Quantity, where: str, faults: Faults, columns: Mapping[str, str] | None = None) -> None:
        """Report terms of letters alone that do not measure the same, in a formula that looks at a scene."""
        if self.scene.dimensionless or not formula.symbols:
            return
        letters: tuple[Letter, ...] = (*self.scene.parameters, *self.scene.inputs)
        silent = {one.name: "" for one in letters if not one.unit}
        known = self.letters | silent | dict(columns or {})
        found = analysed(self.scene, [Use("", "", formula)], known)
        for pair in found.wrong:
            told = words(pair, found).removeprefix(" = ")
            unchecked = Faults(self.scene.source).unchecked
            asked = unchecked if "--no-units" in unchecked else f"{unchecked} of the scene, or ask with --no-units"
            faults.add(where, f"{told}; {ADVICE}, or {asked}")

    @property
    def doubtful(self) -> tuple[str, ...]:
        """What is to be said of dimensions that are no fault: letters of two, and sines of cycles."""
        return () if self.scene.dimensionless else tuple(dict.fromkeys(doubts(self.scene, self.dimensions)))

    @property
    def mistakable(self) -> tuple[str, ...]:
        """What is to be said of values with units in which somebody may see a letter of the scene."""
        scene, letters = self.scene, self.letters
        nouns = (scene.gravity, *scene.parameters, *scene.bodies, *scene.joints, *scene.points, *scene.loops)
        told = []
        for one in Quantity.inside((*nouns, *scene.elements, *scene.inputs, *scene.outputs)):
            both = [name for name in re.findall(r"[^\W\d_]+", one.unit) if name in letters]
            if both:
                value = with_unit(one, one.unit)
                told.append(f"{value} is a number and a unit: {both[0]} is no letter of the scene there")
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
    """Return what the formulas of a scene tell of the dimensions of its letters."""
    return analysed(scene, (use for use in uses(draft_of(scene)) if use.quantity.symbols))


def _alone(term: Quantity) -> str:
    """Return the name of a letter that stands alone in a term, but for its sign; else ""."""
    while term.op in (Op.ABS, Op.NEG):
        term = term.args[0]
    return str(term.value) if term.op is Op.SYMBOL else ""


def _looked_at(scene: Scene, formula: Quantity, units: Mapping[str, str]) -> str:
    """Return the unit that the dimensions of a formula tell, "" where they do not."""
    if not formula.symbols:
        return ""
    found = analysed(scene, (), units).of(formula)
    return "" if found.letters or any(one not in PLAIN_NUMBERS for one, _ in found.numbers) else found.dimension.text

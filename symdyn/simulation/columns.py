"""The columns of a run: of which kind, in which unit, how they are written where there is mathematics, what is in them.

A run becomes a table as CSV, a data frame of pandas, or a data set of xarray; these packages are the user's own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import ROUND_HALF_EVEN, Context, Decimal
from itertools import count
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.reactions import unknown_forces, why_no_reactions
from symdyn.emit import in_latex
from symdyn.emit.print import PrintName, latex_symbols
from symdyn.errors import SimulateError, choice, listed, quoted
from symdyn.extras import package
from symdyn.frozen import dataclass, replace
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import LETTERS, Faults, acceleration_name, force_unit
from symdyn.simulation.prescribed.forces import drive_names
from symdyn.simulation.prescribed.formulas_in_time import read_seen
from symdyn.table import Table

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import xarray


RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

FORCES, ENERGIES, OTHERS = "driving forces", "energies", "others"


@dataclass(frozen=True)
class Column:
    """What one column of a run is."""

    name: str  # its name
    kind: str  # in the plural, such as "coordinates"
    unit: str  # such as "rad/s"; "" where it is not known, as that of a multiplier of a formula
    latex: str = ""  # its symbol; "" where its name is the better word

    @property
    def words(self) -> str:
        """Its name as words, where it has no symbol."""
        return self.name.replace("_", " ").strip()

    @property
    def printed_unit(self) -> str:
        """Its unit as it is printed, such as "m/s²"."""
        unit, _, power = self.unit.partition("^")
        digits = power[: len(power) - len(power.lstrip("-0123456789"))]
        return unit + digits.translate(RAISED) + power[len(digits) :]


@dataclass(frozen=True)
class ColumnRow:
    """Columns beside the state, by the pattern of their names."""

    pattern: str  # of the whole name
    kind: str  # of all of them
    unit: Callable[[re.Match[str]], str] | str  # of one, from the match
    latex: Callable[[re.Match[str]], str] = lambda found: ""  # its symbol, from the match


def _force(match: re.Match[str]) -> str:
    return "N" if match["what"][0] == "f" else "N m"


def _momentum(match: re.Match[str]) -> str:
    return "kg m/s" if match["what"] == "P" else "kg m^2/s"


ROWS = (
    ColumnRow("(kinetic|potential)_energy|work", ENERGIES, "J"),
    ColumnRow("(drive|other)_power", "powers", "W"),
    ColumnRow("energy_error", "error of the energy balance", "J"),
    ColumnRow("loop_error", "residual of the loops", "m or 1"),
    ColumnRow("loop_rate_error", "velocity against rows", "m/s or rad/s"),
    ColumnRow(
        "point_(?P<name>.+)_(?P<axis>[xyz])", "points", "m", lambda of: f"{of[2]}_{{\\mathrm{{{in_latex(of[1])}}}}}"
    ),
    ColumnRow("point_.+_[xyz]_d?dot", "points", lambda found: LETTERS.point_unit(found[0])),
    ColumnRow(r"reaction_.+_(?P<what>[fm])[xyz](_joint|_ground)?(_not_unique)?", "reactions", _force),
    ColumnRow(r"multiplier_.+_(?P<what>[fm])[xyz]_joint(_\d+)?(_not_unique)?", "multipliers", _force),
    ColumnRow(r"multiplier_.+_(?P<what>force|moment)(_\d+)?(_not_unique)?", "multipliers", _force),
    ColumnRow(r"multiplier_.+_(along|across|normal)(_\d+)?(_not_unique)?", "multipliers", "N"),
    ColumnRow(r"multiplier_.+", "multipliers", ""),
    ColumnRow(r"tension_.+", "tensions", "N"),
    ColumnRow("gap_.+", "gaps", "m or rad"),
    ColumnRow("(normal|friction)_.+", "contact forces", "N or N m"),
    ColumnRow("mode_.+", "modes", "1"),
    ColumnRow(r"momentum_.+_(?P<what>[PL])[xyz]", "momenta", _momentum),
    ColumnRow("command_(?P<of>.+)", "commands", ""),
    ColumnRow("reference_(?P<of>.+)", "references", ""),
    ColumnRow("measured_(?P<of>.+)", "measurements", ""),
    ColumnRow("(?P<of>.+)_(hat|estimate)", "estimates", ""),
    ColumnRow(r"controller_x\d+|pid_(integral|filter)", "controller states", ""),
)
"""The first that fits. What is `of` another column has its unit."""


def columns(scene: Scene, extra: Iterable[str]) -> tuple[Column, ...]:
    """Return what the columns of a run of a scene are, in their order, those beside the state by name."""
    latex = latex_symbols(scene, [name for name in drive_names(scene) if name not in scene.drives])
    rates, forces = SceneUnits(scene).velocities, drive_names(scene)
    found = [Column(TIME, "time", "s", TIME)]
    places = zip(scene.coordinates, SceneUnits(scene).coordinates, strict=True)
    found += [Column(name, "coordinates", unit, latex[name]) for name, unit in places]
    for kind, ending, names in (
        ("velocities", "/s", scene.velocities),
        ("accelerations", "/s^2", tuple(map(acceleration_name, scene.velocities))),
    ):
        found += [Column(name, kind, unit + ending, latex[name]) for name, unit in zip(names, rates, strict=True)]
    for name, unit in zip(forces, rates, strict=True):
        found.append(Column(name, FORCES, force_unit(unit), latex[name]))
    told = SceneUnits(scene).inferred
    said = {
        one.name: Column(one.name, kind, told[one.name], one.latex or str(PrintName.of_code(one.name)))
        for kind, letters in (("inputs", scene.inputs), ("states", scene.states))
        for one in letters
    }
    units = {one.name: one.unit for one in (*found, *said.values())}
    said |= {
        one.name: Column(one.name, "outputs", one.unit or _unit(scene, one.formula, units, one.name))
        for one in scene.outputs
    }
    units |= {name: one.unit for name, one in said.items()}
    own = {
        f"momentum_{velocity.removesuffix('_dot')}": unit
        for velocity, unit in zip(scene.velocities, rates, strict=True)
    }
    held = {
        f"multiplier_{row}": Column(f"multiplier_{row}", "multipliers", unit)
        for row, unit in SceneUnits(scene).constraints.items()
    }
    found += [said.get(name) or held.get(name) or _beside(name, own, units) for name in extra]
    return tuple(one if one.name in said else replace(one, unit=scene.shown_unit(one.unit)) for one in found)


def unit_of(formula: Quantity, scene: Scene) -> str:
    """Return the unit of what an output may name; "" where a number in it may carry one, or nothing tells."""
    names = (one.name for one in scene.given)
    return _unit(scene, formula, {one.name: one.unit for one in columns(replace(scene, outputs=()), names)})


def read_output(scene: Scene, text: object, where: str, faults: Faults) -> tuple[Quantity, str] | None:
    """Return a formula in what an output may name, as `read_seen` does, and its unit; None after a fault."""
    formula = read_seen(scene, text, where, faults)
    return None if formula is None else (formula, unit_of(formula, scene))


def _unit(scene: Scene, formula: Quantity, units: Mapping[str, str], called: str = "") -> str:
    return SceneUnits(scene).of_formula(formula, column_units(formula.symbols) | dict(units), called)


def column_units(names: Iterable[str]) -> dict[str, str]:
    """Return the units of columns beside the state, by name, of those that have one."""
    return {name: unit for name in names if (unit := _beside(name, {}).unit)}


def apart(scene: Scene, extra: Mapping[str, Array]) -> dict[str, Array]:
    """Return columns beside the state, those that a scene has given away the names of, as "work", as "work_"."""
    taken, found = {one.name for one in columns(scene, ())}, dict[str, Array]()
    for name, values in extra.items():
        free = next(one for one in (name + "_" * k for k in count()) if one not in taken)
        taken.add(free)
        found[free] = values
    return found


def known(name: str) -> bool:
    """Tell whether a column beside the state may be called so."""
    return _beside(name, {}).kind != OTHERS or name.startswith("momentum_")


def _beside(name: str, momenta: Mapping[str, str], units: Mapping[str, str] = MappingProxyType({})) -> Column:
    """Return what a column beside the state is; `units` are those of others."""
    if name in momenta:
        return Column(name, "momenta", "kg m^2/s" if momenta[name] == "rad" else "kg m/s")
    for row in ROWS:
        if found := re.fullmatch(row.pattern, name.rstrip("_")):
            unit = row.unit if isinstance(row.unit, str) else row.unit(found)
            of = found.groupdict().get("of") or ""
            return Column(name, row.kind, unit or units.get(of) or (of and _beside(of, momenta).unit), row.latex(found))
    return Column(name, OTHERS, "")


def missing(name: object, names: Sequence[str], scene: Scene) -> str:
    """Return what is said of a name that no column has."""
    if not isinstance(name, str):
        return f"{quoted(name)} is no name of a column; run[NAME][-1] is the last number of one; {choice('', names)}"
    parts = [one.strip() for one in re.split("[+,]", name)]
    if len(parts) > 1 and {*parts} <= {*names}:
        one = ", ".join(f'"{part}"' for part in parts)
        return f"there is no column {name}; names stand apart, {one}; a list of names is one panel: plot([[{one}]])"
    if name.startswith(LETTERS.reaction) and not any(one.startswith(LETTERS.reaction) for one in names):
        axes = next((one for one in ("ground", "joint") if one in name.split("_")), "body")
        return f"there is no column {name}; {argument('reactions', axes)} adds {LETTERS.reaction}JOINT_fx and others"
    energies = ("kinetic_energy", "potential_energy", "drive_power", "other_power", "work")
    simulated = (*scene.point_names, *(one.name for one in scene.outputs), *energies)
    if more := [one for one in simulated if f"{one}_".startswith(f"{name}_") and one not in names]:
        return f"there is no column {name}; simulated runs have {listed(more)}, found.simulated() of a solution for one"
    return f"there is no column {name}; {choice(name, names, scene)}"


def columns_csv(names: Sequence[str], table: Array, low: Array | None = None) -> str:
    """Return lines of CSV; columns from the second on have 32 digits with `low`, what they are beyond their doubles."""
    rows: list[list[float | str]] = table.tolist()
    for k, more in enumerate([] if low is None else low.tolist()):
        rows[k][1 : 1 + len(more)] = map(in_full, table[k, 1 : 1 + len(more)].tolist(), more)
    return Table(names, rows).csv()


def in_full(high: float, low: float) -> str:
    """Return a double-double with 32 digits.

    >>> in_full(0.1, -5.551115123125783e-18)
    '0.10000000000000000000000000000000'
    """
    if not math.isfinite(high):
        return repr(high)
    exact = Context(prec=800).add(Decimal(high), Decimal(low))
    return str(Context(prec=32, rounding=ROUND_HALF_EVEN).plus(exact))


def frame(columns: Sequence[Column], table: Array, about: Mapping[str, Any]) -> pandas.DataFrame:
    """Return a data frame over the index t, s; units by column stand in `attrs`, beside what is known of the run."""
    pandas = package("pandas", SimulateError)
    found = pandas.DataFrame(
        table[:, 1:],
        index=pandas.Index(table[:, 0], name=columns[0].name),
        columns=[one.name for one in columns[1:]],
    )
    found.attrs |= {"units": {one.name: one.unit for one in columns}, **about}
    return found


def data_set(columns: Sequence[Column], table: Array, about: Mapping[str, Any]) -> xarray.Dataset:
    """Return a data set over the coordinate t; unit and kind of every variable stand in its `attrs`."""
    time, *others = columns
    variables = {
        one.name: (time.name, values, {"units": one.unit, "long_name": one.kind})
        for one, values in zip(others, table[:, 1:].T, strict=True)
    }
    at = {time.name: (time.name, table[:, 0], {"units": time.unit, "long_name": time.kind})}
    found: xarray.Dataset = package("xarray", SimulateError).Dataset(variables, at, dict(about))
    return found


def axes_of(reactions: bool | str, faults: Faults, scene: Scene | None = None) -> str:
    """Return the axes that are asked for, "" for none; what is no axes is a fault, and so is a scene without."""
    if reactions and scene is not None and (why := why_no_reactions(scene)):
        faults.add("", why)
    if reactions and scene is not None and (why := unknown_forces(scene)):
        faults.add("reactions", why)
    if isinstance(reactions, str) and reactions not in ("", *LETTERS.axes):
        faults.add("reactions", f'"{reactions}" are no axes; write body, joint or ground')
    return reactions if isinstance(reactions, str) else "body" if reactions else ""

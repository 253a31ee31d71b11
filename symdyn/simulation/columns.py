"""The columns of a run: of which kind, in which unit, how they are written where there is mathematics, what is in them.

A run becomes a table as CSV, a data frame of pandas, or a data set of xarray; these packages are the user's own.

Of a known motion inputs, outputs of the scene by their formulas, joint reactions and multipliers are columns, evaluated
from positions, reactions and forces as they came out. Functions called `outputs` are derived, `output:NAME` by two
formulations.

Reactions are what parents exert on children. Multipliers are the forces of loops and other constraints:

    f        forces of the spanning tree, as if nothing closed it
    λ        M u̇ + h = τ + Gᵀ λ, found as Gᵀ λ = f - τ, the least one; what a relation between constraints
             leaves open is reported

Multipliers of a loop have the axes of the joint frame on its parent; its wrench acts at the origin of the moved joint
frame, on the child. Those of a contact have its track, the direction across it, and the normal of its plane as axes;
its force acts on its body.
"""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_HALF_EVEN, Context, Decimal
from functools import lru_cache
from itertools import count
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.dynamics import Function, Workspace, derive_one
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import WrittenDecisions, reaction_names, unique
from symdyn.dynamics.reactions import why_no_reactions
from symdyn.emit import in_latex
from symdyn.emit.print import PrintName, latex_symbols
from symdyn.errors import SimulateError, choice, quoted, suggestion
from symdyn.graph import Graph, evaluate, reachable
from symdyn.program import formulate
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import LETTERS, Faults, acceleration_name, force_unit
from symdyn.simulation.equations.compiled_routines import Compiled, Opened, compiled, compiled_once, function_of, opened
from symdyn.simulation.equations.written import written_decisions
from symdyn.simulation.prescribed.forces import ForceFunction, Forces, drive_names
from symdyn.simulation.prescribed.formulas_in_time import read_seen
from symdyn.table import Table

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import xarray

    from symdyn.simulation.trajectory import Trajectory

RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

FORCES, ENERGIES, OTHERS = "driving forces", "energies", "others"


@dataclass(frozen=True)
class Column:
    """What one column of a run is.

    Attributes:
        name: its name.
        kind: in the plural, such as "coordinates".
        unit: such as "rad/s"; "" where it is not known, as that of a multiplier of a formula.
        latex: its symbol; "" where its name is the better word.
    """

    name: str
    kind: str
    unit: str
    latex: str = ""

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
    """Columns beside the state, by the pattern of their names.

    Attributes:
        pattern: of the whole name.
        kind: of all of them.
        unit: of one, from the match.
        latex: its symbol, from the match.
    """

    pattern: str
    kind: str
    unit: Callable[[re.Match[str]], str] | str
    latex: Callable[[re.Match[str]], str] = lambda found: ""


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
        "point_(?P<name>.+)_(?P<axis>[xyz])",
        "points",
        "m",
        lambda found: f"{found['axis']}_{{\\mathrm{{{in_latex(found['name'])}}}}}",
    ),
    ColumnRow(r"reaction_.+_(?P<what>[fm])[xyz](_joint|_ground)?(_not_unique)?", "reactions", _force),
    ColumnRow(r"multiplier_.+_(?P<what>[fm])[xyz]_joint(_\d+)?(_not_unique)?", "multipliers", _force),
    ColumnRow(r"multiplier_.+_(?P<what>force|moment)(_\d+)?(_not_unique)?", "multipliers", _force),
    ColumnRow(r"multiplier_.+_(along|across|normal)(_\d+)?(_not_unique)?", "multipliers", "N"),
    ColumnRow(r"multiplier_.+", "multipliers", ""),
    ColumnRow(r"momentum_.+_(?P<what>[PL])[xyz]", "momenta", _momentum),
    ColumnRow("command_(?P<of>.+)", "commands", ""),
    ColumnRow("reference_(?P<of>.+)", "references", ""),
    ColumnRow("measured_(?P<of>.+)", "measurements", ""),
    ColumnRow("(?P<of>.+)_hat", "estimates", ""),
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
        one.name: Column(one.name, "inputs", told[one.name], one.latex or str(PrintName.of_code(one.name)))
        for one in scene.inputs
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
    names = (one.name for one in scene.inputs)
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


def missing(name: object, names: Sequence[str]) -> str:
    """Return what is said of a name that no column has."""
    if not isinstance(name, str):
        return f"{quoted(name)} is no name of a column; {choice('', names)}"
    return f"there is no column {name}; {choice(name, names)}"


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
    found: pandas.DataFrame = _package("pandas").DataFrame(
        table[:, 1:],
        index=_package("pandas").Index(table[:, 0], name=columns[0].name),
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
    found: xarray.Dataset = _package("xarray").Dataset(variables, at, dict(about))
    return found


def _package(name: str) -> Any:
    """Return a package.

    Raises:
        SimulateError: it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise SimulateError(
            f"to_{name}() needs {name}, which is not installed; pip install {name}, or take .table() and .to_csv()"
        ) from None


def multipliers(motion: Trajectory, decisions: WrittenDecisions) -> Array:
    """Return λ of the independent rows, N and N m, shape (N, rows), of a motion and all forces that drive it."""
    found = opened(motion.scene)

    def make() -> Compiled:
        w = Workspace(found.scene, found.closing)
        inputs = ("inputs",) if w.scene.inputs else ()
        forces = function_of(w, "forces", w.forces(list(w.state.qdd)), ("q", "qd", "qdd", TIME, *inputs))
        return compiled(w.scene, w.graph, (forces, derive_one(w, "constraint_jacobian")))

    made = compiled_once(("multipliers", found.scene, decisions), make)
    f, G = (_over(motion, made, found, routine.function) for routine in made.program.routines)
    return np.asarray(np.einsum("nrk,nk->nr", np.linalg.pinv(G.transpose(0, 2, 1)), f - motion.tau))


def _over(motion: Trajectory, made: Compiled, result: Opened, function: Function) -> Array:
    """Return a compiled function at all samples of a motion, shape (N, ...)."""
    series = {"q": motion.q, "qd": motion.qd, "qdd": motion.qdd, "tau": motion.tau, TIME: motion.t}
    series |= {"inputs": motion.inputs} if motion.scene.inputs else {}
    values = made.at(result.values)[function.name](*(series[one] for one in made.takes(function.name)))
    return np.broadcast_to(values, (len(motion.t), *function.shape))


def multiplier_columns(motion: Trajectory) -> dict[str, Array]:
    """Return the multipliers of the independent rows as columns.

    They are called `multiplier_LOOP_fx_joint`, along x of the joint frame on the parent; `multiplier_LOOP_force` along
    a direction of its own, such as a rod's; `multiplier_CONTACT_normal`; `multiplier_ROW` of a formula.
    """
    scene = motion.scene
    if not scene.is_constrained:
        return {}
    decisions = written_decisions(scene)
    return dict(zip(decisions.letters, multipliers(motion, decisions).T, strict=True)) if decisions.letters else {}


def reaction_columns(motion: Trajectory, given: bool, axes: str = "body") -> dict[str, Array]:
    """Return force and moment of every joint and loop at the origin of its moved frame, drives included; N and N m.

    They are called `reaction_JOINT_fx`, and in other axes than the body's `reaction_JOINT_fx_joint`, `.._fx_ground`.
    The multipliers of a closed mechanism follow them.

    Args:
        motion: with its driving forces.
        given: whether these give the motion, and more of them may be than it needs; else they are those it takes.
        axes: one of `AXES`.
    """
    scene = motion.scene
    name = "forward_reactions" if scene.is_constrained and (given or not any(scene.drives)) else "reactions"
    request, found = name if axes == "body" else f"{name}:{axes}", opened(scene)

    def make() -> Compiled:
        equations = formulate(found.scene, (request,), closing=found.closing)
        return compiled(found.scene, equations.graph, equations.functions)

    made = compiled_once((request, found.scene, choices(scene, axes)), make)
    function = made.program.routines[0].function
    values = _over(motion, made, found, function).reshape(len(motion.t), -1)
    wrenches = dict(zip(reaction_names(scene, function.unique, axes), values.T, strict=True))
    return wrenches | multiplier_columns(motion)


@lru_cache(maxsize=16)
def choices(scene: Scene, axes: str) -> Hashable:
    """Return what numbers choose for reactions of a closed mechanism: reactions of the same choices are one function.

    Beside rows and velocities these are the wrenches that close loops, node by node, which in a plane have nothing
    across it, and the entries that rigid bodies determine.
    """
    if not scene.is_constrained:
        return None
    found = opened(scene)
    w = Workspace(found.scene, found.closing)
    closing = w.hanging.closing
    place = {node: k for k, node in enumerate(reachable(closing))}
    nodes = tuple((node.op, node.value, *(place[arg] for arg in node.args)) for node in place)
    return written_decisions(scene), w.once(unique, axes), nodes, tuple(place[x] for x in closing)


def axes_of(reactions: bool | str, faults: Faults, scene: Scene | None = None) -> str:
    """Return the axes that are asked for, "" for none; what is no axes is a fault, and so is a scene without."""
    if reactions and scene is not None and (why := why_no_reactions(scene)):
        faults.add("", why)
    if isinstance(reactions, str) and reactions not in ("", *LETTERS.axes):
        faults.add("reactions", f'"{reactions}" are no axes; write body, joint or ground')
    return reactions if isinstance(reactions, str) else "body" if reactions else ""


def output_columns(motion: Trajectory, given: bool) -> dict[str, Array]:
    """Return the outputs of the scene by name, each of shape (N,); `given` as for `reaction_columns`.

    Raises:
        SimulateError: a reaction or multiplier that there is not.
    """
    scene = motion.scene
    if not scene.outputs:
        return {}
    named = dict.fromkeys(name for one in scene.outputs for name in one.formula.symbols)
    series: dict[str, Array] = dict(zip(motion.names, motion.table()[1].T, strict=True))
    axes = scene.reaction_axes
    for one in dict.fromkeys(axes[name] for name in named if name in axes):
        series |= reaction_columns(motion, given, one)
    if any(name.startswith(LETTERS.multiplier) for name in named):
        series |= multiplier_columns(motion)
    series |= {name: np.asarray(value) for name, value in opened(scene).values.items()}
    for name in named:
        if name not in series:
            raise SimulateError(f"{scene.name}: outputs: {name} is not known; {suggestion(name, series)}")
    found = _formula_values([one.formula for one in scene.outputs], series, motion.t)
    return {one.name: column for one, column in zip(scene.outputs, found, strict=True)}


def input_columns(scene: Scene, forces: Forces, t: Array, q: Array, u: Array) -> dict[str, Array]:
    """Return inputs over a motion that is known, each of shape (N,): as given, else as the scene says.

    Raises:
        SimulateError: one has no finite value.
    """
    series: dict[str, Array] = {TIME: t} | dict(zip(scene.coordinates, q.T, strict=True))
    series |= dict(zip(scene.velocities, u.T, strict=True))
    series |= {name: np.asarray(value) for name, value in opened(scene).values.items()}
    acting = {name: function for function in forces.functions for name in function.names}
    found: dict[str, Array] = {}
    for k, one in enumerate(scene.inputs, len(scene.velocities)):
        table, formula = forces.tables.get(k), forces.formulas.get(k, one.value)
        if one.name in acting:
            found[one.name] = _of_function(acting[one.name], one.name, t, q, u)
        else:
            (found[one.name],) = _formula_values([formula], series, t) if table is None else [table(t)]
        wrong = np.flatnonzero(~np.isfinite(found[one.name]))
        if len(wrong):
            raise SimulateError(f"forces: {one.name} has no finite value at t = {t[wrong[0]]:g} s")
    return found


def _of_function(function: ForceFunction, name: str, t: Array, q: Array, u: Array) -> Array:
    """Return what a function says of an input over rows; SimulateError where that is no number."""
    k = function.names.index(name)
    try:
        rows = [np.ravel(function.of(float(at), *state)) for at, *state in zip(t, q, u, strict=True)]
        return np.array([row[k] for row in rows], dtype=np.float64)
    except Exception as fault:  # whatever a user's function raises
        raise SimulateError(f"{function.where}: the function raised {type(fault).__name__}: {fault}") from fault


def _formula_values(formulas: Sequence[Quantity], series: Mapping[str, Array], t: Array) -> list[Array]:
    """Return formulas over the rows of columns, each of shape (N,); NaN where one has no value."""
    graph = Graph()
    values = {graph.symbol(name): series[name] for one in formulas for name in one.symbols}
    with np.errstate(all="ignore"):
        found = evaluate([one.express(graph) for one in formulas], Batches(), values)
    return [np.array(np.broadcast_to(np.asarray(x, dtype=np.float64), t.shape)) for x in found]

"""A log: measured coordinates and driving forces of a scene over time, read from columns by name and checked.

    t                       s
    q1, ...                 coordinates; rad or m
    q1_dot, ...             velocities, where they were measured; else they are differentiated
    q1_ddot, ...            accelerations, likewise
    tau1, F, ...            driving forces, as `drive_names` calls them: N m or N, what `simulate` writes
    u, i, ...               inputs, and states of one's own

Other columns are ignored. All faults of all logs are reported together.

Columns may be given in other units. A log does not state its units, but notes point at columns that look wrong:
velocities beside the rate of their coordinates, coordinates beside the limits of their joints, forces beside those that
the scene expects.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from fnmatch import fnmatchcase
from math import isfinite, pi
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import IdentifyError, SimulateError, choice, listed, nearest
from symdyn.frozen import dataclass, field
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Faults, Unit, UnitError, acceleration_name, shorten
from symdyn.simulation.prescribed import Columns, drive_names, read_entries

GAINED = {"A": "A", "mA": "A", "V": "V", "mV": "V", "%": "%", "counts": "count"}
"""What a drive may show in place of its force, by what unit its gain counts, and what one of it is."""

NEAR, ALIKE = 0.1, 0.9
"""How near a ratio is to a factor of units, and the correlation from which two columns show the same thing."""

OFF = 0.05
"""Part by which a velocity and the rate of its coordinate may differ without a note."""

FAR = 2.0
"""Times a limit, from which a coordinate is beyond what its joint can do."""


LONG = 20.0
"""m of travel from which a joint without limits is asked whether it is in millimetres."""


@dataclass(frozen=True)
class ColumnUnits:
    """A gain that was given with the unit of a column, as in "0.12*A"."""

    value: float  # in N m or N
    unit: str  # of what the drive shows, such as "A"


def in_si(
    table: Columns, units: Mapping[str, str], drives: Collection[str], kinds: Mapping[str, str], faults: Faults
) -> Columns:
    """Return columns in SI with radians, those that `units` say, by name or pattern such as "q*", in another unit.

    Of several patterns that fit a column the last counts. One in a unit of positions, "q*=deg", is of rates, too.
    A drive in a unit of `GAINED` stays what it shows, unless its gain stands before the unit, as in "0.12*A".

    Args:
        table: as it was read.
        units: by name or pattern of columns.
        drives: names of the columns that may be in a unit of `GAINED`.
        kinds: the units that columns are to be in, by name, "" where that is not known.
        faults: takes what is wrong.
    """
    factors = dict[str, float]()
    for pattern, said in units.items():
        found = [name for name in (TIME, *table.values) if fnmatchcase(name, pattern)]
        try:
            count, unit = _factor(said)
        except UnitError as error:
            faults.add("units", f"{pattern}: {said} is no unit of a column: {error}")
            continue
        fitting = {name for name in found if unit.dimension == Unit.read(kinds.get(name) or "1").dimension}
        other = [name for name in found if name not in drives and name not in fitting]
        if not found:
            faults.add(
                "units", f"{pattern}: {table.source} has no such column; {choice(pattern, (TIME, *table.values))}"
            )
        elif unit.text in GAINED and other:
            faults.add(
                "units",
                f"{pattern}: {unit.text} is what a drive shows, and {other[0]} is none; "
                f"{choice(other[0], tuple(drives))}",
            )
        elif unit.text in GAINED and not fitting:
            factors |= dict.fromkeys(found, count * _size(unit))
        else:
            for name in found:
                reason = _misfit(unit, kinds.get(name, ""))
                if reason:
                    faults.add("units", f"{pattern}: {name} {reason}")
            factors |= dict.fromkeys(found, count * unit.size)
    values = {name: x * factors[name] if name in factors else x for name, x in table.values.items()}
    return Columns(table.source, table.t * factors.get(TIME, 1.0), values, table.every)


def _misfit(unit: Unit, kind: str) -> str | None:
    """Return what is wrong with a unit of a column; one of positions may be that of rates, too."""
    wanted = Unit.read(kind or "1")
    time = Unit.read("s").dimension
    if not kind or unit.dimension in (wanted.dimension * time, wanted.dimension * time**2):
        return None
    return unit.misfit(wanted)


def shown_in(units: Mapping[str, str], drives: Sequence[str]) -> dict[int, str]:
    """Return of which drives the gain is to be found: their numbers, and what one of what they show is, such as "A"."""
    found = {}
    for k, name in enumerate(drives):
        said = [str(one).strip() for pattern, one in units.items() if fnmatchcase(name, pattern)]  # the last one counts
        if said and said[-1] in GAINED:
            found[k] = GAINED[said[-1]]
    return found


def given_gains(units: Mapping[str, str], drives: Sequence[str]) -> dict[int, ColumnUnits]:
    """Return the gains that are given with the units of drives, by their numbers."""
    found = {}
    for k, name in enumerate(drives):
        said = [str(one) for pattern, one in units.items() if fnmatchcase(name, pattern)][-1:]
        if said and "*" in said[0] and (factor := _factor(said[0]))[1].text in GAINED:
            found[k] = ColumnUnits(factor[0], GAINED[factor[1].text])
    return found


def _factor(specified: str) -> tuple[float, Unit]:
    """Return the number before a unit, 1 where there is none, and the unit; UnitError where one of the two is none."""
    specified = str(specified).strip()
    before, times, text = (one.strip() for one in specified.rpartition("*"))
    try:
        number = float(before) if times else 1.0
    except ValueError:
        return 1.0, Unit.read(specified)  # as N*m
    if not isfinite(number) or number == 0:
        raise UnitError("a gain is a number other than zero, such as 0.12*A")
    return number, Unit.read(text)


def _size(unit: Unit) -> float:
    """Return how many of what one of it is called a unit of `GAINED` is."""
    return float(unit.scale / Unit.read(GAINED[unit.text]).scale)


def looks_off(scene: Scene, source: str, t: Array, q: Array, qd: Array | None, faults: Faults) -> list[str]:
    """Return notes on units of motion that look off, and add those that cannot be right to the faults."""
    notes: list[str] = []
    kinds = SceneUnits(scene).coordinates
    if qd is not None and q.shape == qd.shape:
        rates = np.gradient(q, t, axis=0)
        ratios = [_ratio(qd[:, k], rates[:, k]) for k in range(q.shape[1])]
        told = [one for one in ratios if one is not None]
        if len(told) > 1 and all(_near(one, 1e3) for one in told):
            faults.add(source, f"all velocities are 1000 times the rates of their coordinates; {_way('t', 'ms')}")
            return notes
        for k, ratio in enumerate(ratios):
            if ratio is not None:
                _judge(scene, source, k, kinds[k], ratio, faults, notes)
    for k, (low, high) in _limits(scene).items():
        size, most = float(np.abs(q[:, k]).max()), max(abs(low), abs(high))
        name, turns = scene.coordinates[k], kinds[k] == "rad"
        factor, unit = (pi / 180, "deg") if turns else (1e-3, "mm")
        if most > 0 and size > FAR * most and size * factor < 1.5 * most:
            faults.add(
                source,
                f"{name} goes to {size:.4g}, its joint to {most:.4g} {kinds[k]}: it looks like {unit}; "
                f"{_way(name, unit)}",
            )
    for k, kind in enumerate(kinds):
        if kind == "rad" and k not in _limits(scene) and float(np.ptp(q[:, k])) > 60:
            notes.append(
                f"{source}: {scene.coordinates[k]} ranges over {np.ptp(q[:, k]):.4g} rad, "
                f"{np.ptp(q[:, k]) / 2 / pi:.3g} turns; if that are degrees, {_way(scene.coordinates[k], 'deg')}"
            )
        if kind == "m" and k not in _limits(scene) and float(np.ptp(q[:, k])) > LONG:
            notes.append(
                f"{source}: {scene.coordinates[k]} ranges over {np.ptp(q[:, k]):.4g} m; if that are millimetres, "
                f"{_way(scene.coordinates[k], 'mm')}"
            )
    step = float(np.median(np.diff(t)))
    if step >= 0.5:
        notes.append(f"{source}: samples are {step:.4g} s apart; if that are milliseconds, {_way(TIME, 'ms')}")
    return notes


def forces_off(source: str, drives: Sequence[str], kinds: Sequence[str], tau: Array, expected: Array) -> list[str]:
    """Return notes on driving forces that are a thousand times, or a thousandth of, what the scene expects.

    `kinds` are the units of their velocities, rad or m.
    """
    notes = []
    for j, drive in enumerate(drives):
        ratio = _ratio(tau[:, j], expected[:, j])
        turns = kinds[j] == "rad"
        for factor, unit in ((1000.0, "mNm" if turns else "mN"), (1e-3, "kNm" if turns else "kN")):
            if ratio is not None and 0.5 < abs(ratio) / factor < 2:
                notes.append(
                    f"{source}: {drive} is {abs(ratio):.4g} times what the scene expects: it looks like {unit}; "
                    f"{_way(drive, unit)}"
                )
        if ratio is not None and ratio < -0.2:
            notes.append(f"{source}: {drive} has the other sign than the scene expects; turn its column round")
    return notes


def _judge(scene: Scene, source: str, k: int, kind: str, ratio: float, faults: Faults, notes: list[str]) -> None:
    """Tell what is wrong with a velocity that is `ratio` times the rate of its coordinate."""
    name, rate = scene.coordinates[k], scene.velocities[k]
    what = f"{rate} is {ratio:.4g} times the rate of {name}"
    turns = kind == "rad"
    known = [(180 / pi, rate, "deg/s"), (pi / 180, name, "deg"), (30 / pi, rate, "rpm")] if turns else []
    known += [] if turns else [(1e3, rate, "mm/s"), (1e-3, name, "mm")]
    for factor, column, unit in known:
        if _near(ratio, factor):
            faults.add(source, f"{what}: {column} looks like {unit}; {_way(column, unit)}")
            return
    if _near(ratio, 1e3) or _near(ratio, 1e-3):
        way = argument("units", {rate: "mm/s"})
        faults.add(source, f"{what}: one of the two is off by 1000; give its unit, as in {way}")
    elif ratio < 0:
        faults.add(source, f"{what}: one of the two has the other sign; turn its column round")
    elif abs(ratio - 1) > OFF:
        notes.append(f"{source}: {what}; both are used as they are, leave {rate} out if it is the worse")


def _way(column: str, unit: str) -> str:
    return f"{argument('units', {column: unit})} gives it"


def _ratio(one: Array, other: Array) -> float | None:
    """Return by how much one column is larger than another that shows the same thing, None where they do not."""
    one, other = one - one.mean(), other - other.mean()
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    if size <= 1e-12 or abs(float(one @ other)) < ALIKE * size:
        return None
    return float(one @ other) / float(other @ other)


def _near(ratio: float, factor: float) -> bool:
    return abs(ratio / factor - 1) < NEAR


def _limits(scene: Scene) -> dict[int, tuple[float, float]]:
    """Return lower and upper limit of coordinates that have numbers for them."""
    found = {}
    places = {name: k for k, name in enumerate(scene.coordinates)}
    values = {p.name: known for p in scene.parameters if p.value is not None and (known := p.value.at({}))}
    for joint in scene.joints:
        low, high = joint.limits.lower, joint.limits.upper
        if len(joint.coordinates) == 1 and low is not None and high is not None:
            ends = [one.at(values) for one in (low, high)]
            if ends[0] is not None and ends[1] is not None:
                found[places[joint.coordinates[0]]] = (float(ends[0]), float(ends[1]))
    return found


SHORTEST = 20
"""Rows that a log needs at least, so that something can be filtered."""

SHORTEST_STEP, LONGEST_STEP = 1e-15, 1e15
"""Between which samples are apart, s: what is beyond has no spectrum in doubles."""

LARGEST = 1e30
"""Size of what is measured, in SI: squares of it and of its derivatives are doubles."""


@dataclass(frozen=True)
class Log:
    """What was measured of one motion.

    Attributes:
        source: the file, or "data", for messages.
        t: times, s, shape (N,), strictly rising.
        q: coordinates, shape (N, nq); rad or m.
        qd: velocities, shape (N, nv), None where they are to be differentiated.
        qdd: accelerations, shape (N, nv), None likewise.
        tau: driving forces, shape (N, nv), zero where a joint is passive; N m or N, or what a drive shows instead.
        notes: what is doubtful, one line each.
        inputs, states: shapes (N, inputs) and (N, states).
    """

    source: str
    t: Array
    q: Array
    qd: Array | None
    qdd: Array | None
    tau: Array
    notes: tuple[str, ...] = ()
    inputs: Array = field(default_factory=lambda: np.zeros((0, 0)))
    states: Array = field(default_factory=lambda: np.zeros((0, 0)))


def read_logs(scene: Scene, data: Any, units: Mapping[str, str] | None = None) -> tuple[Log, ...]:
    """Return the logs that data hold.

    Args:
        scene: the mechanism.
        data: path of a CSV file, arrays by name, a data frame or run, or a list of such, a log each.
        units: of columns that are not in SI with radians, by name or pattern, such as {"q*": "deg"}.

    Raises:
        IdentifyError: with every fault, one line each.
    """
    if isinstance(data, Log):
        return (data,)
    if isinstance(data, Sequence) and not isinstance(data, str) and all(isinstance(one, Log) for one in data) and data:
        return tuple(data)
    faults = Faults("")
    try:
        said = read_entries(data, "data", faults, known(scene))
    except SimulateError as error:
        raise IdentifyError(error.faults) from None
    for where, name, _ in said.texts:
        faults.add(where, f"{name}: a log is a CSV file or arrays over t, not a formula")
    for name, _ in said.functions:
        faults.add("data", f"{name or 'a function'}: a log is a CSV file or arrays over t, not a function")
    if not said.tables and not faults.lines:
        faults.add("data", "is no log; give a CSV file with the columns t, " + ", ".join(expected(scene)))
    drives = [drive for drive in scene.drives if drive]
    tables = [in_si(table, units or {}, drives, SceneUnits(scene).letters, faults) for table in said.tables]
    logs = [one for table in tables if (one := _log(scene, table, faults)) is not None]
    faults.close(IdentifyError)
    return tuple(logs)


def expected(scene: Scene) -> tuple[str, ...]:
    """Return the columns beside t that a log of a scene must have."""
    return (*scene.coordinates, *(drive for drive in scene.drives if drive), *(one.name for one in scene.given))


def known(scene: Scene) -> tuple[str, ...]:
    """Return all columns beside t that a log of a scene may have and that are read."""
    rates = scene.velocities
    told = (*scene.coordinates, *rates, *(acceleration_name(name) for name in rates), *drive_names(scene))
    return (*told, *(one.name for one in scene.given))


def _log(scene: Scene, table: Columns, faults: Faults) -> Log | None:
    """Return one log, None after a fault."""
    source = table.source or "data"
    missing = [name for name in expected(scene) if name not in table.values]
    if missing:
        there = [name for name in table.values if name not in expected(scene)]
        meant = [f"{name} (did you mean {near}?)" if (near := nearest(name, there)) else name for name in missing]
        have = listed([shorten(name) for name in (TIME, *table.values)])
        need = ", ".join((TIME, *expected(scene)))
        alone = bool(missing) and set(missing) <= set(scene.drives)
        more = "; symdyn.identification.output_error finds parameters where forces are not measured" * alone
        faults.add(source, f"has no column {', '.join(meant)}; {scene.name} needs {need}, and it has {have}{more}")
    if len(table.t) < SHORTEST:
        faults.add(source, f"has {len(table.t)} rows; at least {SHORTEST} are needed, some hundred are better")
    if missing or len(table.t) < SHORTEST:
        return None
    before = len(faults.lines)
    step = float(np.median(np.diff(table.t)))
    if not SHORTEST_STEP < step < LONGEST_STEP:
        way = argument("units", {"t": "ms"})
        faults.add(source, f"samples are {step:.3g} s apart, as no log's are; {way} where t is in ms")
    for name in [name for name in table.values if name in known(scene)]:
        if (most := float(np.abs(table.values[name]).max())) > LARGEST:
            faults.add(source, f"{name} goes to {most:.3g}, as nothing does that is measured; leave such rows out")
    if len(faults.lines) > before:
        return None
    notes: list[str] = []
    qd = _some(table.values, scene.velocities, source, notes)
    qdd = _some(table.values, [acceleration_name(name) for name in scene.velocities], source, notes)
    if qd is None and len(scene.velocities) != len(scene.coordinates):
        faults.add(source, f"has no column {', '.join(scene.velocities)}; velocities of quaternions are to be measured")
        return None
    q = np.stack([table.values[name] for name in scene.coordinates], axis=-1)
    still = np.zeros(len(table.t))
    tau = np.stack([table.values.get(name, still) for name in drive_names(scene)], axis=-1)
    notes += looks_off(scene, source, table.t, q, qd, faults)
    idle = [drive for k, drive in enumerate(scene.drives) if drive and not tau[:, k].any()]
    if idle:
        notes.append(f"{source}: {', '.join(idle)} is zero all the time")
    letters = (scene.inputs, scene.states)
    given = [np.array([table.values[one.name] for one in some]).reshape(-1, len(still)).T for some in letters]
    return Log(source, table.t, q, qd, qdd, tau, tuple(notes), *given)


def _some(values: Mapping[str, Array], names: Sequence[str], source: str, notes: list[str]) -> Array | None:
    """Return columns that may be left out, None where one is, which is noted where others are there."""
    there = [name for name in names if name in values]
    if len(there) == len(names):
        return np.stack([values[name] for name in names], axis=-1)
    if there:
        lacking = ", ".join(name for name in names if name not in values)
        notes.append(f"{source}: has {', '.join(there)} and not {lacking}; all of them are differentiated")
    return None

"""A function at many parameter sets: what is asked for, read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import Workspace, derive_one
from symdyn.errors import DerivationError, SimulateError
from symdyn.scene import Scene, SceneUnits, bind
from symdyn.scene.values import Faults, split_commas, suggestion
from symdyn.simulation import Measure, Problem
from symdyn.simulation.prescribed import Columns, number_of, parameter_values, read_formula, words
from symdyn.study.design import read_design
from symdyn.study.job import Job, Measured, check_names, read_measured
from symdyn.study.place_block import TIME, Called, called
from symdyn.study.varied import Over, read_over

At: TypeAlias = str | Path | Mapping[str, Any] | None

BLOCK = 50_000
"""Sets of a block times places: a hundredth of a second, a few times what giving a block to a worker costs."""

FEWEST = 1000

TABLE = ".csv"


def at_places(
    scene: Scene,
    function: str,
    at: At,
    over: Over,
    measure: str | Sequence[str],
    design: str | None,
    count: int | None,
    seed: int,
    block: int | None,
    faults: Faults,
) -> Job:
    """Return a study of what a function of the scene returns.

    Args:
        scene: the mechanism.
        function: such as "inverse_dynamics", as for `symdyn.load`.
        at: where it is called: entries of its arguments by name, as "q1=0.3,q1_dot=1", numbers or formulas in
            parameters, or arrays of one length, shape (S,), for many places; or a .csv file of such columns over t.
            What is not given is where the scene starts, at rest.
        over: what is varied: parameters, or entries of arguments.
        measure: formulas of what the function returns, of its arguments and of parameters, in folds over places as
            over runs; with one place, the folds may be left out.
        design: as for `symdyn.sweep`.
        count: likewise.
        seed: likewise.
        block: parameter sets of one block; None for what takes some milliseconds.
        faults: what is wrong already.

    Raises:
        SimulateError: with every fault, those that there are already among them.
    """
    faults.close(SimulateError)
    moving = (*scene.coordinates, *scene.velocities)
    letters = _entries(scene, function, faults)
    varied = read_over(scene, over, [name for name in letters if name not in moving], faults)
    planned = read_design(varied, design, count, seed, faults)
    measures = read_measured(measure, faults)
    check_names(measures, [one.name for one in varied], faults)
    if block is not None and block < 1:
        faults.add("block", f"{block} is no number of sets; give 1 or more")
    faults.close(SimulateError)
    assert planned is not None, "what is missing is a fault"
    first = dict(zip(planned.names, planned.values(0, 1)[0].tolist(), strict=True))
    scene = bind(scene, {one.name: first[one.name] for one in scene.free_parameters if one.name in first})
    mine = {one.name for one in scene.parameters}
    free = tuple(name for name in planned.names if name in mine)
    with faults.noted():
        parameter_values(scene)
    faults.close(SimulateError)
    call = called(scene, function, free)
    there, where = _places(scene, call, at, planned.names, faults)
    measures = tuple(one for one in (_checked(scene, one, call, len(there[TIME]), faults) for one in measures) if one)
    for name in planned.names:
        if name not in mine and name not in call.letters:
            faults.add("over", f"{function} takes no {name}; {suggestion(name, (*mine, *call.letters))}")
    faults.close(SimulateError)
    size = block or max(FEWEST, BLOCK // len(there[TIME]))
    asked = {"function": function, "at": there, "varied": {"values": list(free)}}
    return Job("places", scene, planned, measures, asked, (("function", function), ("at", where)), size)


def _entries(scene: Scene, function: str, faults: Faults) -> tuple[str, ...]:
    """Return names of the entries of the arguments."""
    try:
        arguments = derive_one(Workspace(scene), function).arguments
    except DerivationError as fault:
        faults.add("function", str(fault))
        return ()
    return tuple(str(entry.value) for one in arguments for entry in one.symbols)


def _checked(scene: Scene, one: Measured, call: Called, places: int, faults: Faults) -> Measured | None:
    """Return a measure that can be read, with a fold round it where there is but one place."""
    known = {*call.letters, *(p.name for p in scene.parameters)}
    found = Measure.read(scene, one.formula, faults, more=call.letters, alone="end" if places == 1 else "")
    for name in [] if found is None else dict.fromkeys(n for inside in found.insides for n in inside.symbols):
        if name not in known:
            faults.add("measure", f"{one.name}: {call.name} neither takes nor gives {name}; {suggestion(name, known)}")
    return None if found is None else replace(one, formula=found.text)


def _places(scene: Scene, call: Called, at: At, varied: Iterable[str], faults: Faults) -> tuple[dict[str, Array], str]:
    """Return every entry of every argument over places, and time, shape (S,) each; and the same in words."""
    start = Problem(scene).initial
    usual = dict(zip(scene.coordinates, start.q.tolist(), strict=True))
    known = [name for one in call.operands for name in one.entries]
    given, where = _given(scene, at, faults)
    for name in given:
        if name not in (*known, TIME):
            faults.add("at", f"{call.name} takes no {name}; {suggestion(name, known)}")
        elif name in varied:
            faults.add("at", f"{name} is varied; leave it out here")
    count = max((len(one) for one in given.values() if one.ndim), default=1)
    for name, one in given.items():
        if one.ndim and len(one) not in (1, count):
            faults.add("at", f"{name} has {len(one)} places, and another one has {count}")
    faults.close(SimulateError)
    there = {name: np.broadcast_to(given.get(name, np.asarray(usual.get(name, 0.0))), (count,)) for name in known}
    times = given.get(TIME, np.arange(count, dtype=np.float64))
    return there | {TIME: np.broadcast_to(times, (count,))}, where


def _given(scene: Scene, at: At, faults: Faults) -> tuple[dict[str, Array], str]:
    """Return what is given by name, and the same in words that are equal where the numbers are."""
    if isinstance(at, Path) or (isinstance(at, str) and at.strip().endswith(TABLE)):
        with faults.noted():
            table = Columns.read(Path(at.strip() if isinstance(at, str) else at))
            return _told({TIME: table.t, **table.values})
        return {}, ""
    entries: Mapping[str, Any] = words(split_commas(at), "at", faults) if isinstance(at, str) else dict(at or {})
    values, units = parameter_values(scene), SceneUnits(scene).letters
    found: dict[str, Array] = {}
    for name, said in entries.items():
        if isinstance(said, str):
            formula = read_formula(said, values, f"at: {name}", faults, unit=units.get(str(name), ""))
            number = None if formula is None else number_of(formula, values, f"at: {name}", faults)
            found[str(name)] = np.asarray(np.nan if number is None else number)
        else:
            array = _array(said)
            if array is None:
                faults.add("at", f"{name} is no finite numbers, one or an array (S,)")
            found[str(name)] = np.zeros(()) if array is None else array
    return _told(found)


def _array(specified: Any) -> Array | None:
    """Return numbers, shape () or (S,); None of what is none."""
    try:
        found = np.asarray(specified)
    except ValueError:  # rows of several lengths
        return None
    fits = found.ndim < 2 and found.dtype.kind in "iuf" and found.size > 0 and bool(np.isfinite(found).all())
    return found.astype(np.float64) if fits else None


def _told(result: dict[str, Array]) -> tuple[dict[str, Array], str]:
    from hashlib import sha256

    text = ";".join(f"{name}={one.tolist()!r}" for name, one in sorted(result.items()))
    return result, text if len(text) < 500 else f"sha256 {sha256(text.encode()).hexdigest()}"

"""Run time against error of every function of a scene, in every implementation: the function `bench`."""

from __future__ import annotations

import os
import platform
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, suggesting
from symdyn.bench.implementations import Implementation, Timed, implementations, nanoseconds
from symdyn.bench.measurements import Bench, Errors, Measured, motion, unbeaten
from symdyn.bench.reference import (
    REGIONS,
    Positions,
    Reference,
    Solve,
    draw,
    linear,
    near_singular,
    positions_of,
    reference,
    state_of,
)
from symdyn.dynamics import Equations, Requested, Workspace, derive_one, formulations_of, row_of
from symdyn.emit import emit
from symdyn.emit.code import REALS
from symdyn.errors import DerivationError, MissingCompiler, SimulateError
from symdyn.frozen import asdict, dataclass, replace
from symdyn.program import formulate, lower
from symdyn.runtime import CACHE_VARIABLE, RUNNERS, find_compiler, here
from symdyn.scene import Scene, SceneLike, scene_of

Progress = Callable[[str], None]

STATES, STATES_QUICK = 200, 20
LONGEST = 16
"""Velocities up to which formulations that are not preferred are measured beside the one that is."""

MANY = 512
"""States of a call that is timed, where it takes many: they fit the nearest caches."""


@suggesting
def bench(
    scene: SceneLike,
    functions: Sequence[str] | None = None,
    quick: bool = False,
    trajectories: bool = True,
    seed: int = 1,
    command: str = "",
    progress: Progress = lambda _: None,
) -> Bench:
    """Return operations, times and errors of a scene's functions in every implementation.

    Args:
        scene: the mechanism; free parameters are drawn from 0.5 … 1.5.
        functions: as for `derive`; None takes all that the scene has, with `quick` those of a first look.
        quick: few states, native code with batch code, few tolerances: a first look, in under 20 s.
        trajectories: whether to add work against precision of a motion.
        seed: of the states.
        command: what makes the report again, for its head.
        progress: takes what is being done.

    Raises:
        DerivationError: a function does not exist.
        BuildError: the compiler refuses.
    """
    scene = scene_of(scene)
    notes: list[str] = []
    names, left_out = Requested.of(Workspace(scene)).available()
    if functions is None:
        notes += left_out
        functions = [one for one in names if row_of(one)[0].default_in == "overview"] if quick else names
    _check(scene, functions)
    machines: tuple[str, ...] = ("native",) if quick else ("native", "portable")
    about = [("processor", _processor()), ("Python", platform.python_version()), ("NumPy", np.__version__)]
    try:
        about.append(("compiler", find_compiler().version.splitlines()[0]))
    except MissingCompiler as fault:
        machines = ()
        notes.append(f"C and ufunc were not measured: {fault}")
    else:
        if why := here()["headers"]["why"]:
            notes.append(f"ufunc was not measured: {why}")
    progress("looking for singular positions")
    positions = _positions(scene, seed)
    found: list[Measured] = []
    with _fresh_cache():
        for number, name in enumerate(functions, start=1):
            progress(f"measuring {name}, {number} of {len(functions)}")
            found += _function(scene, name, positions, machines, quick, seed)
        nowhere = dict.fromkeys(one.function for one in found if not one.errors)
        notes += [f"{one}: it is real at none of the states, so its error is not shown" for one in nowhere]
        moved = None
        if trajectories:
            try:
                moved = motion(scene, quick, progress)
            except (SimulateError, DerivationError) as fault:
                notes.append(f"no trajectories: {fault}")
    return Bench(scene.name, command, tuple(about), REGIONS, tuple(found), moved, tuple(notes))


def _check(scene: Scene, functions: Sequence[str]) -> None:
    """Raise DerivationError, all at once, where functions do not exist, or none is asked for."""
    if not functions:
        told = f"name some, or leave {argument('functions')} out"
        raise DerivationError(f"{scene.name}: no function is asked for; {told}")
    faults = []
    for name in functions:
        try:
            formulations_of(name, scene)
        except DerivationError as fault:
            faults.append(str(fault))
    if faults:
        raise DerivationError("\n".join(dict.fromkeys(faults)))


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


@contextmanager
def _fresh_cache() -> Iterator[None]:
    """Compile everything anew, so that compile times are such."""
    before = os.environ.get(CACHE_VARIABLE)
    with tempfile.TemporaryDirectory(prefix="symdyn-bench-", ignore_cleanup_errors=True) as folder:
        os.environ[CACHE_VARIABLE] = folder
        try:
            yield
        finally:
            del os.environ[CACHE_VARIABLE]
            if before is not None:
                os.environ[CACHE_VARIABLE] = before


def _positions(scene: Scene, seed: int) -> Positions:
    """Return the coordinates, and positions near which M, a Jacobian or the rows of loops are singular."""
    last = [f"jacobian:{point.name}" for point in scene.points] or [f"jacobian:{scene.bodies[-1].name}"]
    rows = ["constraint_jacobian"] if scene.is_constrained else []
    program = lower(formulate(scene, ("mass_matrix", *last, *rows)))
    module = RUNNERS["numpy"].run(emit(program))
    anywhere = positions_of(scene, seed)
    matrices = []
    for routine in program.routines:
        function = routine.function
        if not function.entries:
            continue
        given = draw(function.arguments, anywhere, "range", 1, seed, "double")
        others = [given[a.name] for a in function.arguments if a.name != "q"]
        call = getattr(module, function.name)
        matrices.append(lambda q, call=call, others=others: call(q, *others))
    return replace(anywhere, singular=near_singular(anywhere, matrices, seed))


def comparable(scene: Scene, request: str) -> tuple[str, ...]:
    """Return the formulations of an output that are worth measuring to compare them, in the table's order."""
    n, formulations = len(scene.velocities), row_of(request, scene)[0].formulations
    return tuple(name for name in formulations_of(request, scene) if n <= min(LONGEST, formulations[name].up_to))


def _function(
    scene: Scene, name: str, positions: Positions, machines: Sequence[str], quick: bool, seed: int
) -> list[Measured]:
    start = time.perf_counter()
    workspace = Workspace(scene)
    chosen = derive_one(workspace, name)
    derived = time.perf_counter() - start
    if not chosen.entries:
        return []
    equations = Equations(scene, workspace.graph, (chosen,))
    reals = ("double", "float")
    made = list(implementations(equations, derived, machines, reals, extra=1 if quick else 2))
    for formulation in () if machines == () else comparable(scene, name):
        if formulation != chosen.formulation:
            start = time.perf_counter()
            other = Workspace(scene)
            rival = Equations(scene, other.graph, (derive_one(other, name, formulation),))
            took = time.perf_counter() - start
            made += implementations(rival, took, ("native",), ("double",), extra=0)
    times = _times(made, positions, quick, seed)
    references: dict[tuple[str, str, str], dict[str, _Region]] = {}
    for one in made:  # every formulation has error bounds of its own
        key = (one.routine.function.formulation, one.real, one.accuracy)
        if key not in references:
            references[key] = _references(one, scene, name, positions, STATES_QUICK if quick else STATES, seed)
    measured = [
        _measured(one, took, references[one.routine.function.formulation, one.real, one.accuracy])
        for one, took in zip(made, times, strict=True)
    ]
    return marked(measured)


def _times(made: Sequence[Implementation], positions: Positions, quick: bool, seed: int) -> list[float]:
    timed = []
    for one in made:
        count = 1 if one.single else MANY
        states = draw(one.routine.function.arguments, positions, "range", count, seed, one.real)
        if one.single:
            states = state_of(states, 0)
        timed.append(Timed(one.prepare(states)[0], count))
    with np.errstate(all="ignore"):
        return nanoseconds(timed, 3 if quick else 7, 1e-3 if quick else 5e-3)


@dataclass(frozen=True)
class _Region:
    """States of a region, the exact results there, and the equations where accelerations are solved for."""

    states: Mapping[str, Array]
    known: Reference
    solve: Solve | None


def _references(
    made: Implementation, scene: Scene, name: str, positions: Positions, count: int, seed: int
) -> dict[str, _Region]:
    function = made.routine.function
    solved = linear(scene, name)
    found = {}
    for region in REGIONS:
        states = draw(function.arguments, positions, region, count, seed, made.real)
        solve = Solve.at(solved, states, count) if solved else None
        found[region] = _Region(states, reference(function, states, count, made.accuracy), solve)
    return found


def _measured(one: Implementation, took: float, regions: Mapping[str, _Region]) -> Measured:
    function, real = one.routine.function, REALS[one.real]
    errors, relative = [], []
    for region, states in regions.items():
        known = states.known
        if not len(known.kept):
            continue
        with np.errstate(all="ignore"):
            computed = np.asarray(one.results(states.states), float)
        gap = known.errors(computed)
        largest = np.max(np.abs(known.high), axis=1)
        scale = np.where(largest > 0, largest, 1.0)
        ulp = np.max(gap, axis=1) / (2 * real.roundoff * np.maximum(largest, real.tiniest / real.roundoff))
        own = known.bound * (real.roundoff / REALS["double"].roundoff) + real.tiniest
        share = np.max(gap / own, axis=1)
        solve, tau = states.solve, states.states.get("tau")
        plain = computed.ndim == 2  # else each number is a sum, which is not solved with here
        backward = (
            solve.backward(computed, tau, known.kept, real.roundoff) if solve and tau is not None and plain else None
        )
        errors.append(
            Errors(region, len(known.kept), _spread(ulp), _spread(share), _spread(backward) if backward else None)
        )
        relative.append(float(np.percentile(np.max(gap, axis=1) / scale, 99)))
    return Measured(
        function.name,
        one.variant,
        one.real,
        one.machine,
        function.formulation,
        {key: int(number) for key, number in asdict(one.routine.counts).items()},
        one.generate,
        one.compile,
        took,
        max(relative, default=np.nan),
        tuple(errors),
    )


def _spread(values: Sequence[float] | Array) -> tuple[float, float, float]:
    ordered = np.sort(np.asarray(values, float))
    last = len(ordered) - 1
    return float(ordered[last // 2]), float(ordered[round(0.99 * last)]), float(ordered[-1])


def marked(measured: Sequence[Measured]) -> list[Measured]:
    """Return the same with those marked that no other one beats: as accurate or more so, and faster."""
    best = unbeaten([(one.call, one.relative) for one in measured])
    return [replace(one, best=mark) for one, mark in zip(measured, best, strict=True)]

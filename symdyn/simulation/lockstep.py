"""Runs in lockstep: 64 at a time in compiled code, each with its own step, what measures fold taken along.

A tree under forces that are formulas. What runs are made of is one program, of one lane each:

    rates(q, qd, t, values)      q̇, u̇
    seen(...)                    formulas that are folded
    watched(...)                 what ends a run where it crosses zero
    prepare(params) -> values    what depends on parameters alone, once a run

It is written as the C target writes lanes, with a loop around it, as one file. Runs that come to their end otherwise
than by time (a joint's limit, a formula that stops them, a step that would vanish, more steps than a system that is not
stiff takes) are run again by `simulate`, which says when and why.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array, Batches
from symdyn.dynamics import OUTPUTS, Equations, Workspace, derive_one
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.dynamics.outputs import Moving, lacks_modes
from symdyn.emit import C, emit, render
from symdyn.emit.code import REALS
from symdyn.errors import MissingCompiler
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, evaluate, substitute
from symdyn.program import Program, assemble, lower, prepare
from symdyn.runtime import find_compiler, load_functions
from symdyn.scene import Quantity
from symdyn.scene.values import LETTERS, Faults
from symdyn.simulation.ensemble_task import RunBlock, RunMode, Runner, Task, one_after_other, replaced
from symdyn.simulation.equations.compiled_routines import Kept, Opened, acting, function_of, opened
from symdyn.simulation.equations.monitors import SLACK, STOPS, limits_of
from symdyn.simulation.forward import dies_out_fast
from symdyn.simulation.integrate.integration import DOUBLES, END, INTERRUPTED
from symdyn.simulation.integrate.watch import CLOSER, FIRST, ROUNDING, Looks
from symdyn.simulation.measures import FOLDS, Sums
from symdyn.simulation.prescribed.forces import Forces
from symdyn.simulation.prescribed.formulas_in_time import read_seen

TAKEN = ("q", "qd", TIME)

VALUES = "values"
"""The argument of what was prepared: a number for every lane, where `prepared` is one for all."""

ENERGIES = {"kinetic_energy": "kinetic_energy", "potential_energy": "potential_energy"}
"""Columns of a run that measures may name, and the outputs that they are."""


@dataclass(frozen=True)
class Lockstep:
    """The program of runs in lockstep."""

    program: Program  # its functions
    parameters: tuple[str, ...]  # names of what `prepare` takes, () where nothing is prepared
    values: int  # how many numbers it returns
    seen: int  # how many formulas are folded
    watched: int  # how many ways a run may end before its time
    outward: int  # the first of them that counts only where it turns positive


def lockstep(
    opened: Opened, forces: Forces, insides: Sequence[Quantity], stops: Sequence[Quantity], ignore_limits: bool
) -> Lockstep:
    """Return the program of a tree under forces without tables and functions.

    Raises:
        DerivationError: there is no forward dynamics, or a reaction that there is not.
    """
    w = Workspace(opened.scene, opened.closing)
    place = acting(w, forces)
    accelerations = substitute(derive_one(w, "forward_dynamics").entries, place)
    moving = Moving.driven(w)
    named = {name for one in insides for name in one.symbols}
    energies = {
        w.graph.symbol(name): derive_one(w, output).entries[0] for name, output in ENERGIES.items() if name in named
    }
    seen = substitute(substitute(moving.expressed(insides), energies), place) if insides else []
    tau = [place[one] for one in w.state.tau]
    driving = OUTPUTS["drive_forces"].exists(w.scene)
    drives = list(substitute(derive_one(w, "drive_forces").entries, place)) if driving else tau
    limits = [] if ignore_limits else [one for one in limits_of(w.scene, w.graph, drives) if one.kind in STOPS]
    both = [*(substitute(moving.expressed(stops), place) if stops else ()), *(f for f, _ in w.loops.ends)]
    watched: list[Expr] = [*both, *(limit.beyond - Fraction(str(SLACK)) for limit in limits)]
    functions = [
        function_of(w, name, entries, TAKEN)
        for name, entries in (
            ("rates", [*substitute(w.state.rates, place), *accelerations]), ("seen", seen), ("watched", watched),
        )
        if entries
    ]  # fmt: skip
    made = prepare(lower(Equations(w.scene, w.graph, tuple(functions))))
    if not made.is_prepared:
        return Lockstep(made, (), 0, len(seen), len(watched), len(both))
    first = made[Program.PREPARE].function
    apart = [
        replace(
            one.function,
            arguments=tuple(
                replace(a, name=VALUES) if a.name == Program.PREPARED else a
                for a in one.function.arguments
                if a.symbols or a.name != Program.PREPARED  # where no function needs a parameter there are no values
            ),
        )
        for one in made.routines
        if one.function.entries
    ]
    graph = apart[0].entries[0].graph
    program = assemble(opened.scene, graph, tuple(apart)).checked()
    names = tuple(str(one.value) for a in first.arguments for one in a.symbols)
    return Lockstep(program, names, len(first.entries), len(seen), len(watched), len(both))


def jacobian_at(made: Lockstep, parameters: Mapping[str, float], x: Array) -> Callable[[float], Array]:
    """Return what gives ∂f/∂x at t = 0 by central differences of a relative size, zero where it is not finite."""
    rates = made.program["rates"].function
    known: dict[Expr, Any] = {}
    if made.values:
        first = made.program[Program.PREPARE].function
        names = {one: np.float64(parameters[str(one.value)]) for a in first.arguments for one in a.symbols}
        symbols = next(a.symbols for a in rates.arguments if a.name == VALUES)
        known |= zip(symbols, evaluate(first.entries, Batches(), names), strict=True)
    letters = [one for a in rates.arguments if a.name in TAKEN[:2] for one in a.symbols]

    def jacobian(relative: float) -> Array:
        steps = relative * np.maximum(1.0, np.abs(x))
        states = np.vstack([x + np.diag(steps), x - np.diag(steps)])
        at = known | dict(zip(letters, states.T, strict=True)) | {rates.entries[0].graph.symbol(TIME): np.float64(0.0)}
        with np.errstate(all="ignore"):
            found = np.array([np.broadcast_to(y, len(states)) for y in evaluate(rates.entries, Batches(), at)])
            J = (found[:, : len(x)] - found[:, len(x) :]) / (2 * steps)
        return np.where(np.isfinite(J), J, 0.0)

    return jacobian


KEPT = 8
"""Numbers that are kept of a formula that is folded."""

MOST = 200_000
"""Steps of a run, after which it is looked at one by one: the system may be stiff."""

RESULT = 12
"""The stage whose state is that at the end of the step."""


@dataclass(frozen=True)
class Library:
    """The compiled loop.

    Attributes:
        functions: what it runs.
        nq, nx: numbers of coordinates, and of coordinates and velocities.
        calls: the functions of the library.
    """

    functions: Lockstep
    nq: int
    nx: int
    calls: tuple[Any, Any]

    def prepared(self, parameters: Mapping[str, Array], runs: int) -> Array:
        """Return what depends on parameters alone, shape (runs, values)."""
        found = np.empty((runs, self.functions.values))
        if self.functions.values and runs:
            names = self.functions.parameters
            given = np.empty((runs, len(names)))
            for k, name in enumerate(names):
                given[:, k] = parameters[name]
            self.calls[1](runs, given.ctypes.data, found.ctypes.data)
        return found

    def run(
        self, x: Array, values: Array, times: Array, tolerances: tuple[float, float], halt: npt.NDArray[np.int32],
        keep: bool,
    ) -> tuple[Array, Array, npt.NDArray[np.int32], Array, Array | None, int]:  # fmt: skip
        """Return ends, their times, why, what is kept of formulas and of samples, and steps, from states (runs, nx)."""
        runs, seen = len(x), self.functions.seen
        end, ended, why = np.full((runs, self.nx), np.nan), np.zeros(runs), np.zeros(runs, dtype=np.int32)
        sums = np.full((runs, seen, KEPT), np.nan)
        kept = np.full((runs, len(times), self.nx), np.nan) if keep else None
        arrays = [np.ascontiguousarray(one, dtype=np.float64) for one in (x, values, np.append(times, np.inf))]
        steps = self.calls[0](
            runs, arrays[0].ctypes.data, arrays[1].ctypes.data, len(times), arrays[2].ctypes.data, *tolerances, MOST,
            halt.ctypes.data, end.ctypes.data, ended.ctypes.data, why.ctypes.data, sums.ctypes.data,
            None if kept is None else kept.ctypes.data,
        )  # fmt: skip
        if steps < 0:
            raise MemoryError("no memory for runs in lockstep")
        return end, ended, why, sums, kept, int(steps)


def library(functions: Lockstep, quaternions: Iterable[int], peaks: Sequence[tuple[int, int]] = ()) -> Library:
    """Return the loop compiled, from the cache if it was compiled before; `peaks` of formulas that are seen, and signs.

    Raises:
        MissingCompiler: there is no C compiler.
        BuildError: its own words where it refuses the code.
    """
    program = functions.program
    sources = emit(program, C.name, option="batch")
    opening = sources.stem
    nq, nv = len(program.scene.coordinates), len(program.scene.velocities)
    values = {
        "stem": opening, "lanes": REALS["double"].lanes, "nq": nq, "nx": nq + nv, "values": functions.values,
        "seen": functions.seen, "watched": functions.watched, "outward": functions.outward,
        "quaternions": list(quaternions), "peaks": [*peaks], **tableau(),
        "first": _looks(FIRST), "closer": _looks(CLOSER), "rounding": repr(ROUNDING),
    }  # fmt: skip
    name = f"{opening}.c"
    files = {**sources.texts, name: sources.texts[name] + render("ensemble/lockstep.c.jinja", values)}
    exports = (f"{opening}_lockstep", *((f"{opening}_{Program.PREPARE}_rows",) if functions.values else ()))
    _, found = load_functions(files, exports)
    p, n, d = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
    run, prepare = found[exports[0]], found[exports[1]] if functions.values else None
    run.argtypes, run.restype = [n, p, p, n, p, d, d, n, p, p, p, p, p, p], n
    if prepare is not None:
        prepare.argtypes, prepare.restype = [ctypes.c_size_t, p, p], None
    return Library(functions, nq, nq + nv, (run, prepare))


def tableau() -> dict[str, Any]:
    """Return the coefficients of DOP853 as text, from SciPy's."""
    from scipy.integrate._ivp import dop853_coefficients as of

    stages = range(1, of.N_STAGES)
    steps = [{"to": "stage", "number": s, "c": repr(float(of.C[s])), "sum": _sum(of.A[s, :s])} for s in stages]
    steps.append({"to": "y", "number": RESULT, "c": "1.0", "sum": _sum(of.B)})
    more = range(RESULT + 1, of.N_STAGES_EXTENDED)
    extra = [{"number": s, "c": repr(float(of.C[s])), "sum": _sum(of.A[s, :s])} for s in more]
    return {
        "steps": steps, "extra": extra, "dense": [_sum(row) for row in of.D], "fifth": _sum(of.E5),
        "third": _sum(of.E3), "stages": of.N_STAGES_EXTENDED,
    }  # fmt: skip


def _looks(of: Looks) -> dict[str, Any]:
    """Return nodes, and the rows of coefficients that tell of bends, as text."""
    rows = zip(of.coefficients, of.bends, strict=True)
    lines = [{"numbers": [repr(float(x)) for x in row], "bends": repr(float(bend))} for row, bend in rows if bend]
    return {"parts": [repr(float(x)) for x in of.parts], "coefficients": lines}


def _sum(row: Array) -> str:
    terms = [f"{float(x)!r} * a->slope[{j}][i][k]" for j, x in enumerate(row) if x]
    return " + ".join(terms)


ENDED, HALTED = 0, 4
"""Why a run ended, in the words of the template: by time, or since it was to be halted; all else is looked at again."""

_FUNCTIONS: Kept[Lockstep] = Kept()
_LIBRARIES: Kept[Library] = Kept()


def refuses(task: Task) -> str:
    """Return why runs are not run in lockstep."""
    if why := shape(task):
        return why
    try:
        find_compiler()
    except MissingCompiler:
        return "there is no C compiler"
    return "the system is stiff" if task.method is None and stiff(task) else ""


def shape(task: Task) -> str:
    """Return why rates are no functions of a state, time and parameters alone."""
    scene, forces = task.scene, task.forces
    if task.rtol < DOUBLES:
        return "doubles have no such tolerance"
    if scene.is_constrained:
        return "loops close"
    if lacks_modes(scene):
        return "contacts open and close"
    if not scene.velocities:
        return "nothing moves"
    if scene.states:
        return "it has states of its own"
    if forces.tables:
        return "a force is a table"
    if forces.functions or forces.fed:
        return "a force is a function"
    if task.feedback is not None:
        return "a controller acts that is more than gains"
    if any(one.function is not None for one in task.measures):
        return "a measure is a function of a run"
    if whole := {fold for one in task.measures for _, fold, _ in one.folds if FOLDS[fold].whole}:
        return f"{', '.join(sorted(whole))} is known of whole runs"
    columns = {name for one in task.insides for name in one.symbols if name in LETTERS.columns and name not in ENERGIES}
    if columns:
        return f"{', '.join(sorted(columns))} is known of whole runs"
    free = {p.name for p in opened(scene).scene.free_parameters}
    decided = [name for name in task.lanes.values if name not in free]
    if decided:
        return f"{', '.join(decided)} decides the form of equations"
    return ""


def stiff(task: Task) -> bool:
    """Tell whether the first run is stiff at its start."""
    if not task.lanes.count:
        return False
    one = slice(0, 1)
    values = {name: float(np.ravel(x)[0]) for name, x in task.lanes.parameters(one).items()}
    jacobian = jacobian_at(functions(task), values, task.begun(one)[0])
    return dies_out_fast(jacobian, task.until)


def _key(task: Task) -> tuple[Hashable, ...]:
    return opened(task.scene).scene, *task.forces.form, task.insides, task.stops, task.ignore_limits


def functions(task: Task) -> Lockstep:
    """Return what is to be run, derived once for all values."""

    def make() -> Lockstep:
        stops = [read_seen(task.scene, text, "event", Faults("")) for text in task.stops]
        known = [one for one in stops if one is not None]
        return lockstep(opened(task.scene), task.forces, task.insides, known, task.ignore_limits)

    return _FUNCTIONS.get(_key(task), make)


def ready(task: Task) -> Runner:
    """Return what runs a part; what it runs is compiled once."""
    scene, key, parts = task.scene, _key(task), functions(task)
    names = list(scene.coordinates)
    firsts = [names.index(group[0]) for group in quaternions(scene)]
    peaks = tuple((task.insides.index(inside), sign) for inside, sign in task.peaks)
    made = _LIBRARIES.get((*key, peaks), lambda: library(parts, firsts, peaks))
    again = one_after_other(task)
    halt = np.zeros(1, dtype=np.int32)

    def run(part: slice) -> RunBlock:
        return _run(task, made, halt, part, again)

    def stop() -> None:
        halt[0] = 1

    return Runner(run, stop)


def _run(task: Task, made: Library, halt: Any, part: slice, again: Runner) -> RunBlock:
    lanes, nq = task.lanes, made.nq
    runs = len(range(lanes.count)[part])
    x = task.begun(part)
    values = made.prepared(lanes.parameters(part), runs)
    times = task.times if task.insides or task.keep else task.times[-1:]  # nobody looks at samples
    end, t, why, kept, samples, steps = made.run(x, values, times, (task.rtol, task.atol), halt, task.keep)
    stopped = np.full(runs, END, dtype=object)
    stopped[why == HALTED] = INTERRUPTED
    end[why == HALTED], kept[why == HALTED] = np.nan, np.nan
    sums = {one: _sums(kept[:, k], t) for k, one in enumerate(task.insides)}
    block = RunBlock(t, end[:, :nq], end[:, nq:], tuple(stopped.tolist()), sums, samples, steps)
    return replaced(task, block, part, (why != ENDED) & (why != HALTED), again)


def _sums(kept: Any, t: Any) -> Sums:
    """Return what was kept of a formula; where it had no value, none of it has."""
    first, last, least, most, when_least, when_most, area, squares = kept.T.copy()
    lost = ~np.isfinite(area)
    for one in (least, most, when_least, when_most, area, squares):
        one[lost] = np.nan
    return Sums(first, last, least, most, when_least, when_most, area, squares, t.copy(), np.full(t.shape, np.nan))


MODE = RunMode("lockstep", "64 runs in lockstep by DOP853", "compiled", 4096, ready, refuses, ("dop853",))

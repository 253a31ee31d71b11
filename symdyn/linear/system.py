"""Linear systems with what they came from: at a point, at all positions of rest, or along the run of a file.

A run on disk, as `simulate -o` writes it, is read back as states and driving forces over time.

Gains along a run, `track`, are those of the linear quadratic regulator of the systems along it:

    least xᵀ(T) S_T x(T) + ∫ xᵀ Q x + wᵀ R w dt      x, w: deviations from the motion, ẋ = A(t) x + B(t) w
    -Ṡ = Aᵀ S + S A - S B R⁻¹ Bᵀ S + Q,  S(T) = S_T   from the end to the begin
    w = -K(t) x,  K = R⁻¹ Bᵀ S                        K(T) behind the end

Reference: Anderson and Moore, Optimal Control: Linear Quadratic Methods (1990), section 2.3.
"""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import suggesting
from symdyn.draw import Reel
from symdyn.emit import Contents, check_folder, write_file
from symdyn.errors import LinearizeError, beside
from symdyn.frozen import dataclass, replace
from symdyn.linear.compensator import Observer
from symdyn.linear.contact_mode import read_mode
from symdyn.linear.equilibrium import equilibria
from symdyn.linear.evolution import along_a_step
from symdyn.linear.linearization import Linearization
from symdyn.linear.linearized import along, linearize_along, search_report
from symdyn.linear.modes import MODE_PERIOD, Mode, animate_modes
from symdyn.linear.prepared import Prepared, prepared
from symdyn.linear.regulator import Regulator, controls
from symdyn.linear.report import Symbolic, as_json, latex, text
from symdyn.linear.state_space import StateSpace
from symdyn.linear.steady import settled
from symdyn.linear.symbolic import symbolic
from symdyn.linear.transfer import shown
from symdyn.linear.weights import Axis, Weights, check_arrays, read_weights, weight
from symdyn.rounding import in_digits
from symdyn.scene import Scene
from symdyn.scene.values import Faults
from symdyn.simulation import Feedback, Problem, Trajectory, read_feedback
from symdyn.simulation.prescribed import Columns, drive_names
from symdyn.table import Table

NUMBERS, NAMES = ("t", "q", "qd", "tau"), ("coordinates", "velocities")
"""Arrays of a .npz file that simulate writes: those of numbers, and those of names."""

WRITTEN = (*NUMBERS, *NAMES)


def read_run(scene: Scene, path: Path) -> Trajectory:
    """Return the run in a .csv or .npz file: coordinates and velocities of a scene, and its driving forces if told.

    Raises:
        LinearizeError: no such file, another ending, or columns that are not the scene's.
        SimulateError: with every fault of a CSV file.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise LinearizeError(f"{path}: runs are read from {' or '.join(READERS)} files, as simulate -o writes them")
    if not path.is_file():
        raise LinearizeError(f"{path}: there is no such file; {beside(path)}")
    t, columns = reader(path, [one.name for one in scene.given])
    missing = [name for name in (*scene.coordinates, *scene.velocities) if name not in columns]
    if missing:
        raise LinearizeError(
            f"{path}: has no column {', '.join(missing)}; a run of {scene.name} has t, coordinates, velocities, drives"
        )
    still = np.zeros(len(t))
    q = np.stack([columns[name] for name in scene.coordinates], axis=-1)
    u = np.stack([columns[name] for name in scene.velocities], axis=-1)
    forces = (columns.get(f"force {k}", columns.get(name, still)) for k, name in enumerate(drive_names(scene)))
    tau = np.stack(list(forces), axis=-1)
    for letters, what in ((scene.inputs, "which {} is given over time"), (scene.states, "a state of {}")):
        if lacking := [one.name for one in letters if one.name not in columns]:
            raise LinearizeError(f"{path}: has no column {', '.join(lacking)}, {what.format(scene.name)}")
    given = {one.name: columns[one.name] for one in scene.given}
    return Trajectory(scene, t, q, u, np.zeros_like(u), tau, given)


def _csv(path: Path, inputs: Sequence[str]) -> tuple[Array, Mapping[str, Array]]:
    found = Columns.read(path)
    return found.t, found.values


def _npz(path: Path, inputs: Sequence[str]) -> tuple[Array, Mapping[str, Array]]:
    try:
        check_arrays(path, WRITTEN)
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: np.asarray(file[name]) for name in NUMBERS}
            names = [str(name) for key in NAMES for name in file[key]]
            more = {name: np.asarray(file[name]) for name in inputs if name in file}
    except (OSError, ValueError, KeyError, EOFError) as fault:
        raise LinearizeError(f"{path}: is no run that simulate has written: {fault}") from None
    wide = np.hstack([arrays["q"], arrays["qd"]])
    if wide.shape != (len(arrays["t"]), len(names)) or not np.isfinite(wide).all():
        raise LinearizeError(f"{path}: its rows do not fit its names, or are not finite")
    found = {name: wide[:, k] for k, name in enumerate(names)}
    return arrays["t"], found | more | {f"force {k}": column for k, column in enumerate(arrays["tau"].T)}


READERS = {".csv": _csv, ".npz": _npz}


@dataclass(frozen=True)
class System:
    """A linear system and what it came from.

    Attributes:
        prepared: what was linearised; linear systems at other places, and values, are asked of it.
        linearization: the system.
        formulas: the same in formulas, where it is small.
    """

    prepared: Prepared
    linearization: Linearization
    formulas: Symbolic | None

    def text(self) -> str:
        """Return it as text: where, states, matrices, modes, stability."""
        return text(self.linearization, self.formulas)

    def latex(self) -> str:
        """Return it in LaTeX: formulas where there are some, else numbers."""
        return latex(self.linearization, self.formulas)

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON, all digits."""
        return as_json(self.linearization, self.formulas)

    def sampled(self, period: float) -> tuple[StateSpace, StateSpace]:
        """Return the system between samples, exactly and along a step; errors as of `discretize` and `along_a_step`."""
        return StateSpace.discretize(self.linearization, period), along_a_step(
            self.prepared, self.linearization, period
        )

    def lqr(self, weights: Sequence[str], period: float | None = None) -> Regulator:
        """Return the regulator of weights that --lqr says; errors as of `read_weights` and `lqr`."""
        words = [part for one in weights for part in re.split(NEXT_WEIGHT, one)]
        led = [one.partition("=")[2] for one in words if one.partition("=")[0].strip() == "integral"]
        integral = [name.strip() for one in led for name in one.split(";")]
        others = [one for one in words if one.partition("=")[0].strip() != "integral"]
        one = self.linearization
        given = read_weights("--lqr", others, {"Q": one.states.names, "R": one.inputs.names, "N": ()})
        return one.lqr(given.get("Q"), given.get("R"), period, N=given.get("N"), integral=integral)

    def kalman(self, variances: Sequence[str], period: float | None = None) -> Observer:
        """Return the gain of the filter of variances that --kalman says; errors as of `read_weights` and `kalman`."""
        words, one = [part for one in variances for part in re.split(NEXT_WEIGHT, one)], self.linearization
        given = read_weights("--kalman", words, {"W": one.states.names, "V": one.outputs.names})
        return one.kalman(given.get("W"), given.get("V"), period)

    def animate(self, path: Path, reel: Reel, note: Callable[[str], None]) -> list[tuple[Path, Mode, str]]:
        """Write every mode as a film, and return which is where, in words too; errors as of `animate_modes`."""
        made = animate_modes(self.linearization, path, reel, note)
        return [(where, mode, _words(mode)) for where, mode in made]

    @classmethod
    def find(
        cls,
        problem: Problem,
        where: Path | str,
        outputs: Sequence[str] = (),
        independent: Sequence[str] = (),
        anywhere: bool = False,
        mode: Mapping[str, str] | None = None,
    ) -> tuple[list[System], Sequence[str]]:
        """Return the linear systems of a scene, and what is said of how they were found.

        `where` is a file of a run, for a system at every sample; "rest" for all positions of rest; "start" for where
        the problem starts. Other arguments as of `linearize`.

        Raises:
            LinearizeError: as of `linearize`; no position of rest, or a file that is no run of the scene.
        """
        asked = prepared(problem, outputs, independent, told := read_mode(problem.scene, mode or {}))
        if told and where != "start":
            raise LinearizeError("mode: it is that of one point; leave --along and --start rest out")
        if isinstance(where, Path):
            return [cls(asked, one, None) for one in along(asked, read_run(problem.scene, where))], ()
        if where != "rest":
            start = problem.initial
            found = settled(asked, asked.at(start.q, start.moving, notes=start.notes), anywhere)
            return [cls(asked, found, None if told else symbolic(asked, found))], ()
        places = equilibria(asked)
        notes = search_report(places)
        if not places.systems:
            way = "" if places.crossings or places.locked else "; give forces that hold it, as in --forces NAME=FORMULA"
            raise LinearizeError([f"{problem.scene.name}: {notes[0]}{way}", *notes[1:]])
        return [cls(asked, one, symbolic(asked, one)) for one in places.systems], notes


def _words(mode: Mode) -> str:
    turns = f", {in_digits(mode.frequency, 6)} Hz, a round in {MODE_PERIOD:g} s" if mode.oscillates else ""
    return f"the mode {shown(mode.value)} 1/s{turns}"


def arrays(systems: Sequence[Linearization]) -> dict[str, Any]:
    """Return the arrays of a system, or of several, then with one more axis in front; times and points beside them."""
    parts: dict[str, Any] = {letter: np.array([getattr(one, letter) for one in systems]) for letter in "ABCD"}
    parts |= {name: np.array([getattr(one.point, name) for one in systems]) for name in ("t", "q", "u", "tau")}
    parts["eigenvalues"] = np.array([one.poles for one in systems])
    parts = {name: part[0] if len(systems) == 1 else part for name, part in parts.items()}
    for name in ("states", "inputs", "outputs"):
        axis: Axis = getattr(systems[0], name)
        parts[name], parts[f"{name[:-1]}_units"] = np.array(axis.names), np.array(axis.units)
    return parts


def write_npz(systems: Sequence[Linearization], file: IO[bytes]) -> None:
    """Write arrays, names, units, and JSON of the rest."""
    about = np.array(json.dumps([_about(one) for one in systems], ensure_ascii=False))
    np.savez_compressed(file, **arrays(systems), about=about)


def write_mat(systems: Sequence[Linearization], file: IO[bytes]) -> None:
    """Write arrays, names and units for MATLAB and Octave; several systems have a last axis more, one a system."""
    from scipy.io import savemat

    parts = arrays(systems)
    if len(systems) > 1:
        parts |= {letter: np.moveaxis(parts[letter], 0, -1) for letter in "ABCD"}
    names = [name for name, part in parts.items() if part.dtype.kind == "U"]
    parts |= {name: np.array(parts[name].tolist(), dtype=object) for name in names}
    whole = io.BytesIO()
    savemat(whole, parts)  # type: ignore[arg-type]  # a file serves
    text = whole.getvalue()
    file.write(b"symdyn linearize".ljust(116) + text[116:])  # in place of the date


def csv_text(systems: Sequence[Linearization]) -> str:
    """Return A, B, C, D one below the other: the matrix, its row, and a column for every state and input."""
    first = systems[0]
    heads = ("t", "matrix", "row", "unit", *first.states.names, *first.inputs.names)
    rows: list[tuple[str | float, ...]] = []
    for one in systems:
        for left, right, axis, name in ((one.A, one.B, one.states, "rate"), (one.C, one.D, one.outputs, "output")):
            units = [_rate(unit) if name == "rate" else unit for unit in axis.units]
            for row, unit, x, w in zip(axis.names, units, left.tolist(), right.tolist(), strict=True):
                rows.append((one.point.t, name, row, unit, *x, *w))
    return Table(heads, rows).csv()


def _rate(unit: str) -> str:
    return f"{unit}^2" if unit.endswith("/s") else f"{unit}/s"


def _about(one: Linearization) -> dict[str, Any]:
    return {key: value for key, value in as_json(one).items() if key not in ("A", "B", "C", "D", "formulas")}


WRITERS: Mapping[str, Callable[[Sequence[Linearization]], Contents]] = {
    ".npz": lambda found: partial(write_npz, found),
    ".mat": lambda found: partial(write_mat, found),
    ".csv": csv_text,
}


@dataclass(frozen=True)
class SystemsFile:
    """A file that linear systems are written to.

    Raises:
        LinearizeError: an ending that is none of `WRITERS`, or no such folder.
    """

    path: Path

    def __post_init__(self) -> None:
        if self.path.suffix.lower() not in WRITERS:
            raise LinearizeError(f"{self.path}: linear systems are written to {' or '.join(WRITERS)} files")
        check_folder(self.path, LinearizeError)

    def write(self, systems: Sequence[Linearization]) -> None:
        """Write systems of the same states, inputs and outputs.

        Raises:
            LinearizeError: systems of different states, or a file that cannot be written.
        """
        if len({(one.states, one.inputs, one.outputs) for one in systems}) != 1:
            raise LinearizeError(
                f"{self.path}: these are systems of different states; write one at a time, with --start"
            )
        write_file(self.path, WRITERS[self.path.suffix.lower()](systems), LinearizeError)


NEXT_WEIGHT = r";\s*(?=(?:[QRNWV]|integral)\s*=)"

RESTS = 1e-6
"""Velocities, and accelerations that forces leave, over the largest of the motion or entry of A, that are none."""

RTOL, ATOL = 1e-8, 1e-10
"""Tolerances of Riccati's equation, over the size of S at the end and of Q."""


@suggesting
def track(
    run: Trajectory,
    Q: Weights | None = None,
    R: Weights | None = None,
    end: Weights | None = None,
    independent: str | Sequence[str] = (),
) -> Feedback:
    """Return the controller that brings a mechanism back to a motion: u = u0(t) - K(t) (x - x0(t)).

    It holds the forces of the motion itself: nothing else is to give them. Where the motion ends at rest, in a place
    where forces can hold the mechanism, the last gains hold it there from then on, about the forces that do; else the
    last forces, place and velocities stay as well, which a note of the run says. Gains of a sampled controller are
    these at its samples: `Feedback(track(...), period=0.01)`.

    Args:
        run: the motion, with a sample wherever it bends: gains and places are interpolated between them.
        Q: weight of states, as of `lqr`.
        R: of drives, likewise.
        end: S(T), a weight of the deviation at the end; None takes what `lqr` has there, or Q where there is none.
        independent: positions and velocities that others follow, as of `linearize`.

    Raises:
        LinearizeError: with every fault, as of `linearize_along` and `lqr`.
    """
    if len(run.t) < 2:
        raise LinearizeError(f"{run.scene.name}: a motion of one sample cannot be followed; give one of two or more")
    each = linearize_along(run.scene, run, independent=independent)
    last, used, faults = each[-1], controls(each[-1]), Faults("")
    inputs = last.inputs.of(used)
    heavy, light = weight("Q", Q, last.states, faults), weight("R", R, inputs, faults, True, last.inputs)
    final = None if end is None else weight("end", end, last.states, faults)
    faults.close(LinearizeError)
    A, B = np.array([one.A for one in each]), np.array([one.B[:, used] for one in each])
    S = _swept(run.t, A, B, heavy, light, _held(A[-1], B[-1], heavy, light) if final is None else final)
    state = np.hstack([run.q, run.qd]).T
    said = {
        "t": run.t,
        "K": np.linalg.solve(light, B.transpose(0, 2, 1) @ S),
        "states": list(last.states.names),
        "inputs": list(inputs.names),
        "x0": dict(zip((*run.scene.coordinates, *run.scene.velocities), state, strict=True)),
        "u0": {name: run[name] for name in inputs.names},
    }
    feedback = read_feedback(run.scene, said)
    return replace(feedback, law=_behind(run, feedback.law, last, used))


def _behind(run: Trajectory, law: Any, last: Linearization, used: Sequence[int]) -> Any:
    """Return the law, a schedule, so that it holds its end about forces of rest where the motion comes to rest."""
    end, B = float(run.t[-1]), last.B[last.positions :][:, used]
    rates = last.point.udot[last.velocities]
    away = np.linalg.lstsq(B, -rates)[0]
    size = max(1.0, float(np.abs(last.A).max(initial=0.0)), float(np.abs(run.qd).max(initial=0.0)))
    left = np.concatenate([rates + B @ away, run.qd[-1]])
    if np.abs(left).max(initial=0.0) > RESTS * size:
        return replace(law, end=end)
    gains = law.at(end)
    still = gains.u0 * (np.arange(len(gains.u0)) >= run.qd.shape[1])
    held = replace(gains, u0=still, initial=tuple(gains.initial + away))
    return replace(law, at=lambda t: law.at(t) if t <= end else held)


def _held(A: Array, B: Array, Q: Array, R: Array) -> Array:
    """Return S of a motion that stays as it ends for ever; Q where nothing holds it."""
    from scipy.linalg import solve_continuous_are  # late: it takes long to load

    try:
        return np.asarray(solve_continuous_are(A, B, Q, R), dtype=np.float64)
    except (np.linalg.LinAlgError, ValueError):
        return Q


def _swept(t: Array, A: Array, B: Array, Q: Array, R: Array, end: Array) -> Array:
    """Return S at times, shape (N, nx, nx), from the end to the begin; A and B are straight between them."""
    from scipy.integrate import solve_ivp
    from scipy.interpolate import make_interp_spline

    n, curves = len(Q), [make_interp_spline(t, one, k=1) for one in (A, B)]

    def rates(now: float, entries: Array) -> Array:
        S, (a, b) = entries.reshape(n, n), (curve(now) for curve in curves)
        half = S @ a
        return -np.asarray(half + half.T - S @ b @ np.linalg.solve(R, b.T @ S) + Q).ravel()

    size = max(float(np.abs(end).max()), float(np.abs(Q).max()))
    with np.errstate(over="ignore", invalid="ignore"):  # steps that are too long are tried again, and shorter
        found = solve_ivp(rates, (t[-1], t[0]), end.ravel(), "DOP853", t[::-1], rtol=RTOL, atol=ATOL * size)
    if not found.success or not np.isfinite(found.y).all():
        raise LinearizeError(f"Riccati's equation has no solution along the motion: {found.message}")
    S = found.y.T[::-1].reshape(-1, n, n)
    return np.asarray(S + S.transpose(0, 2, 1)) / 2

"""Controllers with states: linear laws between what is measured and what is driven.

    e = r - y                           y measured signals, r their references
    v = u0 + C z + D e                  the command; limits cut it to sat(v)
    ż = A z + B e + L (sat(v) - v)      all the time: z is integrated along with the motion
    z' = A z + B e + L (sat(v) - v)     from sample to sample

L, shape (n, m), is the gain of back calculation: it holds the states back while a limit cuts the command, so that they
do not wind up. Where a reference is not given it is y0, the signal at the operating point.

Measured signals and references are formulas in time, coordinates, velocities, places of points and parameters, and in
outputs of the scene that are made of these: what is measured must not depend on the forces that answer it.

Reference: Åström and Hägglund, Advanced PID Control (2006), chapter 3, back calculation and tracking.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import Workspace
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import Moving
from symdyn.errors import quoted, suggestion
from symdyn.frozen import dataclass
from symdyn.graph import Expr, tangents
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import LETTERS, Faults
from symdyn.simulation.equations.compiled_routines import (
    Calls,
    Compiled,
    argument,
    compiled,
    compiled_once,
    function_of,
    opened,
    plain,
)
from symdyn.simulation.prescribed.formulas_in_time import parameter_values, read_formula, read_number, read_seen
from symdyn.unlocked import cached_property

STATE = ("q", "qd", TIME)
"""What measured signals may depend on."""


@dataclass(frozen=True, eq=False, repr=False)
class LinearLaw:
    """A linear controller of n states, p measured signals and m commands; see the module's legend.

    Attributes:
        A, B, C, D: shapes (n, n), (n, p), (m, n) and (m, p).
        y0: signals where e vanishes, unless a reference is given, shape (p,).
        initial: u0, shape (m,).
        states: names of the columns that show z, shape (n,).
        tracking: L, shape (n, m).
        start: z at the start over e there, shape (n, p).
        shown: of what columns show beside z: where z is 0, shape (n,), and by r - y0 and its rate, shape (2, n, p).
    """

    A: Array
    B: Array
    C: Array
    D: Array
    y0: tuple[float, ...]
    initial: tuple[float, ...]
    states: tuple[str, ...]
    tracking: Array
    start: Array
    shown: tuple[Array, Array] | None = None

    @classmethod
    def read(
        cls, matrices: Mapping[str, object], measures: Sequence[str], drives: Sequence[str], faults: Faults
    ) -> LinearLaw:
        """Return the law of A, B, C and D; what has another size, or is no number, is a fault."""
        found = {name: _numbers(name, one, faults) for name, one in matrices.items()}
        A, p, m = found["A"], len(measures), len(drives)
        n = len(A) if A.ndim == 2 and A.size else round(math.sqrt(A.size))
        sizes = {"A": (n, n), "B": (n, p), "C": (m, n), "D": (m, p)}
        for name, size in sizes.items():
            if name == "D" and not found[name].ndim and not found[name]:
                found[name] = np.zeros(size)
            vector = found[name].ndim < 2 or not found[name].size
            if found[name].shape != size and not (vector and found[name].size == math.prod(size)):
                told = " x ".join(map(str, found[name].shape)) or "a number"
                faults.add(
                    name, f"is {told}; {_count(n, 'state')}, {_count(p, 'measured signal')} ({', '.join(measures)}) "
                    f"and {_count(m, 'command')} ({', '.join(drives)}) need {size[0]} x {size[1]}",
                )  # fmt: skip
                found[name] = np.zeros(size)
            elif not np.isfinite(found[name]).all():
                faults.add(name, "has an entry that is not finite")
        A, B, C, D = (found[name].reshape(size) for name, size in sizes.items())
        states = tuple(f"controller_x{k + 1}" for k in range(n))
        return cls(A, B, C, D, (0.0,) * p, (0.0,) * m, states, np.zeros((n, m)), np.zeros((n, p)))

    def command(self, z: Array, e: Array) -> Array:
        """Return v, shape (m,)."""
        return np.asarray(np.asarray(self.initial) + self.C @ z + self.D @ e)

    def moved(self, z: Array, e: Array, missed: Array) -> Array:
        """Return ż, or the states at the next sample, shape (n,), where `missed` is sat(v) - v, shape (m,)."""
        return np.asarray(self.A @ z + self.B @ e + self.tracking @ missed)


def _numbers(name: str, given: object, faults: Faults) -> Array:
    try:
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        faults.add(name, f"{quoted(given)} is no matrix of real numbers")
        return np.zeros(())


def _count(n: int, what: str) -> str:
    return f"{n} {what}{'s' * (n != 1)}"


def by_signal(given: object, names: Sequence[str], where: str, faults: Faults) -> dict[str, object]:
    """Return what is given by name, or in order of the names, by name; what is neither is a fault."""
    if given is None:
        return {}
    if isinstance(given, Mapping):
        for name in given:
            if name not in names:
                faults.add(where, f"{name} is not among {', '.join(names)}; {suggestion(str(name), names)}")
        return {str(name): one for name, one in given.items() if name in names}
    one = not isinstance(given, Iterable) or isinstance(given, str) or getattr(given, "ndim", None) == 0
    each: list[object] = [given] if one else list(given)  # type: ignore[call-overload]
    if len(each) != len(names):
        some = "is one number" if one else f"has {len(each)} entries"
        by_name = f'give all, or by name, as in {{"{names[0]}": 0.1}}' if names else "leave it out"
        faults.add(where, f"{quoted(given)} {some} for {len(names)}: {', '.join(names)}; {by_name}")
    return dict(zip(names, each, strict=False))


def numbers_by_signal(
    given: object, names: Sequence[str], where: str, faults: Faults, scene: Scene | None = None
) -> dict[str, float]:
    """Return finite numbers, as of `by_signal`; with a scene also of texts with units."""
    found = {}
    for name, one in by_signal(given, names, where, faults).items():
        if scene and isinstance(one, str):
            letter = SceneUnits(scene).letter(name)
            found[name] = read_number(one, parameter_values(scene), f"{where}: {name}", faults, letter, scene) or 0.0
            continue
        try:
            found[name] = float(one)  # type: ignore[arg-type]
        except (TypeError, ValueError, OverflowError):
            found[name] = math.nan
        if not math.isfinite(found[name]):
            faults.add(where, f"{name} = {quoted(one)} is no finite number")
    return found


@dataclass(frozen=True, eq=False)
class Signals:
    """What a controller measures, and the references of it, at values of the scene's parameters."""

    scene: Scene  # the mechanism
    measures: tuple[str, ...]  # names or formulas of the measured signals, shape (p,)
    formulas: tuple[Quantity, ...]  # of the signals, and then of the references that are formulas
    numbers: tuple[float, ...]  # the references that are numbers, shape (p,)
    led: list[int]  # indices of the signals whose references are formulas
    given: list[int]  # indices of the signals whose reference is given

    @classmethod
    def read(
        cls, scene: Scene, measures: Sequence[str], reference: object, y0: Sequence[float], faults: Faults
    ) -> Signals:
        """Return the signals; a formula that cannot be measured is a fault."""
        where = "feedback: measures"
        for text in {one for one in measures if list(measures).count(one) > 1}:
            faults.add(where, f"{text} is named twice")
        formulas = [_measurable(scene, text, where, faults) for text in measures]
        given = by_signal(reference, measures, "feedback: reference", faults)
        texts = {name: one for name, one in given.items() if isinstance(one, str)}
        for name in (one for one in measures if one in texts):
            place, unit = f"feedback: reference: {name}", SceneUnits(scene).letter(name).unit
            formula = read_formula(texts[name], _letters(scene), place, faults, unit=unit, scene=scene)
            formulas.append(formula or Quantity.ZERO)
        others = {name: one for name, one in given.items() if name not in texts}
        known = dict(zip(measures, y0, strict=False))
        known |= numbers_by_signal(others, measures, "feedback: reference", faults)
        led, told = ([k for k, name in enumerate(measures) if name in some] for some in (texts, given))
        return cls(scene, tuple(measures), tuple(formulas), tuple(known.values()), led, told)

    @property
    def labels(self) -> tuple[str, ...]:
        """What columns call the signals: their names, y1, y2, ... where they are formulas."""
        return tuple(one if one.isidentifier() else f"y{k + 1}" for k, one in enumerate(self.measures))

    def __call__(self, t: float, q: Array, u: Array) -> tuple[Array, Array]:
        """Return y and r, shape (p,) each."""
        values, r = self._calls["signals"](q, u, t), np.array(self.numbers)
        r[self.led] = values[len(r) :]
        return values[: len(r)], r

    def slopes(self, t: float, q: Array, u: Array) -> Array:
        """Return ∂(r - y)/∂(q, u), shape (p, nq + nv)."""
        p, every = len(self.measures), np.eye(len(q) + len(u))
        dq, du = (np.ascontiguousarray(part) for part in np.split(every, [len(q)], axis=1))
        values = self._along["along"](q, u, t, dq, du).T
        found: Array = -values[:p]
        found[self.led] += values[p:]
        return found

    @cached_property
    def _calls(self) -> Calls:
        return self._compiled("signals")

    @cached_property
    def _along(self) -> Calls:
        return self._compiled("along")

    def _compiled(self, name: str) -> Calls:
        found = opened(self.scene)

        def make() -> Compiled:
            w = Workspace(found.scene, found.closing)
            function = function_of(w, "signals", Moving.driven(w).expressed(self.formulas), STATE)
            if name == "along":
                dq, du = (argument(w.graph, "dq", len(w.state.q)), argument(w.graph, "du", w.state.n + len(w.states)))
                seeds: dict[Expr, Expr] = dict(
                    zip((*w.state.q, *w.state.qd, *w.states), (*dq.symbols, *du.symbols), strict=True)
                )
                function = plain(name, tangents(function.entries, seeds), (*function.arguments, dq, du))
            return compiled(w.scene, w.graph, (function,))

        return compiled_once(("signals", name, found.scene, self.formulas), make).at(found.values)


def _measurable(scene: Scene, text: object, where: str, faults: Faults) -> Quantity:
    """Return a formula in what can be measured; zero after a fault."""
    formula = read_seen(scene, text, where, faults) or Quantity.ZERO
    for name in (one for one in formula.symbols if one not in _letters(scene)):
        faults.add(
            where, f"{text} depends on {name}, which forces make at once; measure what coordinates, velocities, points "
            "and parameters tell",
        )  # fmt: skip
    return formula


def _letters(scene: Scene) -> tuple[str, ...]:
    parameters = (one.name for one in scene.parameters)
    states = (one.name for one in scene.states)
    seen = (*scene.point_names, *LETTERS.of_struts(scene.struts))
    return (TIME, *scene.coordinates, *scene.velocities, *states, *seen, *parameters)


# Systems of python-control and SciPy, known by what they have: these packages need not be there


def matrices_of(system: Any, faults: Faults) -> dict[str, Array] | None:
    """Return A, B, C and D of what has `dt` beside them, or num and den, or is made to have by `to_tf`; None of others.

    What has `dt` and none of them is a fault. A function with such attributes is a function, but for python-control's,
    which have `ninputs`.
    """
    kept = isinstance(system, type) or all(hasattr(system, name) for name in "ABCD")  # not to_tf: other states
    whole = system.to_tf() if {"to_tf", "poles"} <= {*dir(system)} and not kept else system
    function = callable(whole) and not hasattr(whole, "ninputs")
    if isinstance(system, type) or function or not hasattr(whole, "dt"):
        return None
    if kept:
        return {name: np.atleast_2d(getattr(whole, name)) for name in "ABCD"}
    if hasattr(whole, "num") and hasattr(whole, "den"):
        return _realised(whole.num, whole.den, faults)
    faults.add("", f"{quoted(system)} is no linear system; give transfer functions or A, B, C and D")
    return None


def names_of(system: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names that somebody gave the inputs, and the outputs, of a system; () of those that are counted."""
    ins, outs = (
        () if any(re.fullmatch(r"[uy]\[\d+\]", one) for one in names) else names
        for names in (tuple(getattr(system, f"{which}_labels", None) or ()) for which in ("input", "output"))
    )
    return ins, outs


def _realised(num: Any, den: Any, faults: Faults) -> dict[str, Array]:
    """Return A, B, C and D of transfer functions, each in its controllable canonical form, side by side.

    Numerators and denominators are lists of lists, an output a row, or one for one input and output.
    """
    many = isinstance(num, list) or np.asarray(num).dtype == np.dtype(object)
    rows, below = (num, den) if many else ([[num]], [[den]])
    m, p = len(rows), len(rows[0])
    blocks, D = list[tuple[int, int, Array, Array]](), np.zeros((m, p))
    for i, j in np.ndindex(m, p):
        b, a = (np.trim_zeros(np.ravel(np.asarray(one[i][j], dtype=np.float64)), "f") for one in (rows, below))
        if len(b) > len(a):
            faults.add(
                "", f"the transfer function is improper, of degree {len(b) - 1} over {len(a) - 1}: what it makes of a "
                "jump has no end; give it more poles, as the filter of a derivative is one",
            )  # fmt: skip
            continue
        if not len(b):
            continue
        b, a = np.concatenate([np.zeros(len(a) - len(b)), b]) / a[0], a / a[0]
        D[i, j] = b[0]
        blocks.append((i, j, a[1:], b[1:] - b[0] * a[1:]))
    n = sum(len(a) for _, _, a, _ in blocks)
    A, B, C, first = np.zeros((n, n)), np.zeros((n, p)), np.zeros((m, n)), 0
    for i, j, a, c in blocks:
        here = slice(first, first + len(a))
        A[here, here] = np.eye(len(a), k=-1)
        if len(a):
            A[first, here], B[first, j] = -a, 1.0
        C[i, here] = c
        first += len(a)
    return {"A": A, "B": B, "C": C, "D": D}

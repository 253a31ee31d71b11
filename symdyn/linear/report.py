"""What is told of a linear system: as text, as LaTeX, and for JSON.

Formulas of its parameters stand where the mechanism is small, eigenvalues too where they have a closed form; numbers in
all other cases, to six digits in print and all digits in JSON.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array, Form, Number, Symbol
from symdyn.emit.print import BMatrix, Latex, latex_symbols, text_of
from symdyn.frozen import dataclass
from symdyn.linear.modes import Mode
from symdyn.rounding import in_digits, requested_digits, showing
from symdyn.scene import SceneUnits
from symdyn.scene.values import force_unit
from symdyn.simulation.prescribed import drive_names
from symdyn.table import Table

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization
    from symdyn.linear.state_space import StateSpace
    from symdyn.linear.weights import Axis

SAME = 1e-7
"""How nearly formulas and numbers are the same."""

Rows = tuple[tuple[Form, ...], ...]


@dataclass(frozen=True)
class Root:
    """Eigenvalues in closed form.

    Attributes:
        kind: "zero"; "real", λ = first; "pair", ω² = first, of λ² + ω² = 0; "damped", λ² + second λ + first = 0;
            "coupled", λ⁴ + second λ² + first = 0.
        first, second: formulas.
        times: how often it is one.
    """

    kind: str
    first: Form
    second: Form
    times: int


@dataclass(frozen=True)
class Symbolic:
    """Formulas of A, B, C, D, and those of eigenvalues that have one.

    Attributes:
        A, B, C, D: as in the linearization.
        roots: eigenvalues in closed form; not all may be.
        held: coordinates that the formulas keep as symbols.
        defined: names that they use and what these stand for: of loops, how dependent velocities follow independent
            ones, and multipliers.
    """

    A: Rows
    B: Rows
    C: Rows
    D: Rows
    roots: tuple[Root, ...]
    held: tuple[str, ...]
    defined: tuple[tuple[str, Form], ...] = ()


def negated(form: Form) -> Form:
    """Return -form."""
    return Form.product((Number.MINUS_ONE, form)) if form.terms else form


DIGITS, NOTHING = 6, 1e-12
"""Digits of numbers in print, and what beside the largest entry of a matrix is zero in print."""


def number(x: float, size: float = 0.0) -> str:
    """Return a number in print; one that is nothing beside `size` is 0."""
    return "0" if abs(x) <= NOTHING * size else in_digits(x + 0.0, DIGITS)


def text(system: Linearization, formulas: Symbolic | None = None) -> str:
    """Return a system as text: where, states, matrices, modes, stability."""
    lines = [f"{system.scene.name}, linearised {system.manner}", f"  {where_in_words(system)}"]
    lines += [f"  {note}" for note in system.notes]
    for letter, axis in (("x", system.states), ("w", system.inputs), ("y", system.outputs)):
        lines.append(f"  {letter} = ({', '.join(_named(axis)) or 'nothing'})")
    lines.append("")
    for letter, (rows, columns) in system.names.items():
        matrix: Array = getattr(system, letter)
        if matrix.size and (letter in "AB" or matrix.any()):
            lines += [*Table.matrix(letter, rows, columns, matrix.tolist()).lines(), ""]
        elif matrix.size:
            lines += [f"{letter} = 0", ""]
    if formulas is not None:
        told = [line for one in "ABCD" for line in _formulas(one, getattr(formulas, one), system.names[one])]
        told += [f"with {name} = {_short(form)}" for name, form in formulas.defined]
        lines += [*told, ""] if told else []
    lines += [*_modes(system), *(f"  {line}" for line in roots(formulas)), "", f"stability: {system.stability.words}"]
    lines += [f"  {line}" for line in system.stability.lines]
    return "\n".join(lines)


def roots(formulas: Symbolic | None) -> list[str]:
    """Return what closed forms say of eigenvalues, one line each."""
    moving = [root for root in (formulas.roots if formulas is not None else ()) if root.kind != "zero"]
    return [_root(root) + f"   ({root.times} times)" * (root.times > 1) for root in moving]


def _spelled(form: Form) -> str:
    """Return a formula in print, its numbers rounded where that is asked for."""
    return text_of(form, requested_digits())


def _short(form: Form) -> str:
    """Return a definition in print, or what has one that is longer than 400 characters."""
    spelled, where = _spelled(form), "--format latex, --json and symdyn.linearize(...).formulas in Python have it"
    return spelled if len(spelled) <= 400 else f"... ({len(spelled)} characters; {where})"


def _root(root: Root) -> str:
    first, second = _spelled(root.first), _spelled(root.second)
    if root.kind == "real":
        return f"λ = {first}"
    if root.kind == "coupled":
        return f"ω⁴ - b ω² + c = 0 with b = {second}, c = {first}"
    if first.startswith("-"):
        grows = _spelled(negated(root.first))
        return f"λ² = {grows}" if root.kind == "pair" else f"λ² + ({second}) λ = {grows}"
    return f"ω² = {first}" if root.kind == "pair" else f"ω² = {first}, 2 ζ ω = {second}"


def _named(axis: Axis) -> list[str]:
    return [f"{name} [{unit}]" if unit else name for name, unit in zip(axis.names, axis.units, strict=True)]


def where_in_words(system: Linearization) -> str:
    """Return the operating point: coordinates, velocities that are not zero, forces that are not."""
    scene, point = system.scene, system.point

    def shown(name: str, x: float, unit: str) -> str:
        return f"{name} = {scene.in_shown_unit(number(x), '' if unit == '1' else unit)}"

    parts = [*map(shown, scene.coordinates, point.q, SceneUnits(scene).coordinates)]
    units = SceneUnits(scene).velocities
    speeds = (*(f"{unit}/s" for unit in units), *(one.unit for one in scene.states))
    parts += [shown(n, x, u) for n, x, u in zip(scene.first_order, point.u, speeds, strict=True) if x]
    names = drive_names(scene)
    parts += [shown(names[k], x, force_unit(units[k])) for k, x in enumerate(point.tau) if abs(x) > NOTHING]
    inputs = zip(scene.inputs, point.inputs, strict=False)
    told = SceneUnits(scene).inferred
    parts += [f"{one.name} = {number(x)} {told[one.name]}".rstrip() for one, x in inputs if abs(x) > NOTHING]
    return f"at {', '.join(parts)}" + (f"; {shown('t', point.t, 's')}" if point.t else "")


def _formulas(letter: str, rows: Rows, names: tuple[Sequence[str], Sequence[str]]) -> list[str]:
    return [
        f"{letter}[{row}, {column}] = {_spelled(entry)}"
        for row, entries in zip(names[0], rows, strict=True)
        for column, entry in zip(names[1], entries, strict=True)
        if not isinstance(entry, Number)
    ]


def _modes(system: Linearization) -> list[str]:
    """Return a line a mode: eigenvalue, frequency, damping, what moves."""
    if not system.modes:
        return ["all eigenvalues are zero"]
    size = 1e3 * system.spectrum.size
    rows = [(eigenvalue(x, size), number(x.frequency), number(x.damping, 1.0), shape(x, system)) for x in system.modes]
    return Table(HEAD, rows).lines()


HEAD = ("eigenvalue, 1/s", "frequency, Hz", "damping ratio", "shape")
"""What is told of a mode, wherever one is told."""


def eigenvalue(mode: Mode, size: float) -> str:
    """Return an eigenvalue in print, ± where it is a pair; what is nothing beside `size` is 0."""
    real = number(mode.value.real, size)
    return f"{real} ± {number(mode.value.imag, size)} i" if mode.oscillates else real


def shape(mode: Mode, system: StateSpace) -> str:
    """Return how the positions move in a mode, phases in degrees; the velocities, or states, where no position does."""
    count: int = getattr(system, "positions", 0)
    p = count if np.abs(mode.shape[:count]).max(initial=0.0) > NOTHING else 0
    some, names = mode.shape[: p or None], system.states.names[: p or None]
    some = some / some[np.abs(some).argmax()]
    parts = []
    for name, x in zip(names, some, strict=True):
        if abs(x) < SMALL:
            continue
        angle = float(np.degrees(np.angle(x)))
        if abs(angle) < TURN or abs(abs(angle) - 180) < TURN:
            parts.append(f"{name} {in_digits(x.real, 3)}")
        else:
            parts.append(f"{name} {in_digits(abs(x), 3)} ∠ {angle:.0f}°")
    return ", ".join(parts)


SMALL, TURN = 1e-6, 0.5
"""Parts of a shape that are not told, and phases in degrees that are none."""


def latex(system: Linearization, formulas: Symbolic | None = None) -> str:
    """Return ẋ = A x + B w, y = C x + D w in LaTeX: formulas where there are some, else numbers."""
    names = latex_symbols(system.scene)
    write = Latex(names)

    def entries(letter: str) -> list[list[str]]:
        matrix: Array = getattr(system, letter)
        rows: Rows | None = None if formulas is None else getattr(formulas, letter)
        size = float(np.abs(matrix).max(initial=0.0))
        if rows is not None:
            return [[write.unbroken(entry) for entry in row] for row in rows]
        return [[write.scientific(number(x, size)) for x in row] for row in matrix.tolist()]

    def column(axis: Axis) -> str:
        return str(BMatrix([[names.get(name) or rf"\mathrm{{{_escaped(name)}}}"] for name in axis.names]))

    x, w, y = (rf"\mathbf{{{letter}}}" for letter in "xwy")
    axes = [(x, system.states), (w, system.inputs), (y, system.outputs)]
    told = r", \quad ".join(f"{letter} = {column(axis)}" for letter, axis in axes if len(axis))
    driven = rf" + {BMatrix(entries('B'))} {w}" if len(system.inputs) else ""
    through = rf" + {BMatrix(entries('D'))} {w}" if system.D.any() else ""
    rows = [told.replace(" = ", " &= ", 1), rf"\dot{{{x}}} &= {BMatrix(entries('A'))} {x}{driven}"]
    if len(system.outputs):
        rows.append(rf"{y} &= {BMatrix(entries('C'))} {x}{through}")
    for name, form in formulas.defined if formulas is not None else ():
        rows.append(rf"{write.unbroken(Symbol(name))} &= {write.unbroken(form)}")
    return "\n".join([r"\begin{align*}", " \\\\\n".join(rows), r"\end{align*}"])


def _escaped(name: str) -> str:
    return name.replace("_", r"\_").replace("*", r"\cdot ").replace("^", r"\hat{}")


def as_json(system: Linearization, formulas: Symbolic | None = None) -> dict[str, Any]:
    """Return a system for JSON, all digits."""
    scene, point, verdict = system.scene, system.point, system.stability
    axes = {name: getattr(system, name) for name in ("states", "inputs", "outputs")}
    inputs = dict(zip((one.name for one in scene.inputs), point.inputs.tolist(), strict=True))
    with showing(None):
        eigenvalues = roots(formulas)
    return {
        "scene": scene.name,
        "kind": system.kind,
        "point": {
            "t": point.t,
            "q": dict(zip(scene.coordinates, point.q.tolist(), strict=True)),
            "u": dict(zip(scene.first_order, point.u.tolist(), strict=True)),
            "tau": dict(zip(drive_names(scene), point.tau.tolist(), strict=True)),
            **({"inputs": inputs} if inputs else {}),
        },
        **{name: [{"name": n, "unit": u} for n, u in zip(a.names, a.units, strict=True)] for name, a in axes.items()},
        "positions": system.positions,
        **{letter: getattr(system, letter).tolist() for letter in "ABCD"},
        "formulas": None
        if formulas is None
        else {letter: [[text_of(x) for x in row] for row in getattr(formulas, letter)] for letter in "ABCD"}
        | {"eigenvalues": eigenvalues, "with": {name: text_of(form) for name, form in formulas.defined}},
        "eigenvalues": [
            {
                "re": mode.value.real,
                "im": mode.value.imag,
                "frequency_hz": mode.frequency,
                "damping": mode.damping,
                "shape": {n: [x.real, x.imag] for n, x in zip(system.states.names, mode.shape.tolist(), strict=True)},
            }
            for mode in system.modes
        ],
        "zero": verdict.zeros,
        "cyclic": list(verdict.names),
        "stability": verdict.verdict,
        "dropped": list(system.dropped),
        "notes": list(system.notes),
    }

"""What a notebook shows of scenes, equations, functions, costs, identified parameters, linear systems, sensitivities.

Equations are shown as they are read, where they are not too long for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from symdyn.emit.print import BREAK, Printable, printed_text, value_text
from symdyn.errors import SymdynError
from symdyn.extras import EXTRAS, install
from symdyn.notebook.page import Markup, beside, formula, formulas, head, note, notes, picture, shown, table, verdict
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import spell
from symdyn.table import Table

if TYPE_CHECKING:  # one of these is shown, and its package is there then
    from symdyn.algebra import Array
    from symdyn.dynamics import ClosedForm, Equations, Function
    from symdyn.emit.print import EquationsOfMotion, SympyEquations
    from symdyn.identification import Calibration, Identification, Identified, OutputFit
    from symdyn.linear import Formulas, Linearization
    from symdyn.program import Program
    from symdyn.runtime import Loaded, NumericFunction
    from symdyn.simulation import Branches, Gait, Sensitivity


def scene(result: Scene) -> list[Markup]:
    """Return picture and tables of a scene."""
    return [head(result.name, _counts(result)), beside(_picture(result), _tables(result))]


def _picture(result: Scene) -> Markup:
    from symdyn.draw import picture as drawn  # with NumPy, which equations can do without

    try:
        return picture(drawn(result), "svg", f"picture of {result.name}")
    except SymdynError as fault:  # a mechanism that cannot be assembled is still one that has a table
        return note(f"no picture: {fault}")


def _counts(result: Scene) -> str:
    """Return how much there is of what, kinds that there are."""
    counts = {
        "body": len(result.bodies), "coordinate": len(result.coordinates), "loop": len(result.loops),
        "contact": len(result.contacts), "spring or damper": len(result.struts), "load": len(result.loads),
    }  # fmt: skip
    plural = {"body": "bodies", "spring or damper": "springs and dampers"}
    return ", ".join(f"{n} {word if n == 1 else plural.get(word, f'{word}s')}" for word, n in counts.items() if n)


def _tables(result: Scene) -> list[Markup]:
    units = dict(zip(result.coordinates, map(result.shown_unit, SceneUnits(result).coordinates), strict=True))
    drives: dict[str, list[str]] = {}
    for joint, drive, unit in SceneUnits(result).each_drive():
        drives.setdefault(joint.name, []).append(", ".join(filter(None, (drive, result.shown_unit(unit)))))
    rows = [
        (
            q,
            result.shown_unit(units[q]),
            joint.name,
            joint.type.replace("_", " "),
            "; ".join(drives.pop(joint.name, ())),
        )
        for joint in result.moving
        for q in joint.coordinates
    ]
    told, looked = SceneUnits(result).inferred, SceneUnits(result).outputs
    named = [
        (one.name, "" if one.value is None else value_text(one.value), told[one.name], one.text)
        for one in result.parameters
    ]
    given = [(one.name, spell(one.value), told[one.name], one.text) for one in result.inputs]
    own = [(one.name, spell(one.rate), spell(one.value), told[one.name], one.text) for one in result.states]
    seen = [(one.name, spell(one.formula), looked[one.name], one.text) for one in result.outputs]
    gravity = ", ".join(map(spell, result.gravity))
    return [
        table(("coordinate", "unit", "joint", "type", "drive"), rows),
        table(("parameter", "value", "unit", ""), named),
        table(("input", "unless given", "unit", ""), given),
        *([table(("state", "rate", "start", "unit", ""), own)] if own else []),
        table(("output", "formula", "unit", ""), seen),
        note(f"gravity [{gravity}] m/s²"),
    ]


def derived(equations: Equations) -> list[Markup]:
    """Return the functions that were derived, and by which formulation."""
    rows = [(_call(one), _shape(one.shape), one.units, one.formulation, one.text) for one in equations.functions]
    return [
        head(equations.scene.name, "functions on one expression graph"),
        table(("function", "shape", "unit", "derived by", ""), rows),
    ]


def program(result: Program) -> list[Markup]:
    """Return the routines, and how many operations each takes."""
    rows = [
        (_call(one.function), _shape(one.function.shape), one.counts.cost, len(one.steps), one.function.text)
        for one in result.routines
    ]
    return [
        head(result.scene.name, "straight-line program"),
        table(("routine", "shape", "operations, weighted", "lines", ""), rows),
    ]


def loaded(result: Loaded) -> list[Markup]:
    """Return how every function is called."""
    kind = (
        f"compiled functions for {result.backend}"
        if result.compiled
        else "functions of the NumPy module: there was no compiler"
    )
    return [
        head(result.scene.name, kind),
        table(("function", "lengths"), (text.split(": ", 1) for text in result.signatures.values())),
        note("leading dimensions broadcast; parameters and inputs may be given by name"),
    ]


def numeric(function: NumericFunction) -> list[Markup]:
    """Return how a function is called, and the entries of its arguments, which may be given by name."""
    rows = [
        (one.name, "number" if one.scalar else len(one.entries), ", ".join(one.entries)) for one in function.operands
    ]
    return [
        head(function.name, function.description.partition(": ")[2]),
        table(("argument", "length", "entries"), rows),
        table(("fixed", "value"), function.fixed.items()),
        note("leading dimensions broadcast; parameters and inputs may be given by name"),
    ]


def _call(one: Function) -> str:
    return f"{one.name}({', '.join(argument.name for argument in one.arguments)})"


def _shape(shape: tuple[int, ...]) -> str:
    return " × ".join(map(str, shape)) if shape else "number"


def output_fit(result: OutputFit) -> list[Markup]:
    """Return what was found, before and after, and how far the run is from what was measured."""
    scatter = ", ".join(f"{name} {size:.3g}" for name, size in zip(result.measured, result.noise, strict=True))
    return [
        head(result.declared.name, f"parameters by output error, {result.runs} runs"),
        shown(result.table()),
        note(f"residuals: {scatter}; condition number {result.condition:.3g}; {result.dof} degrees of freedom"),
        *notes(result.notes),
    ]


def calibration(result: Calibration) -> list[Markup]:
    """Return parameters before and after, how far the point was off, and what is not identifiable."""
    return [
        head(result.scene.name, f"calibrated by poses of {result.model.point.name}"),
        *map(shown, result.tables),
        *notes(result.notes),
    ]


def identification(result: Identification) -> list[Markup]:
    """Return base parameters before and after, how well forces are predicted, and what is not identifiable."""
    regression = result.regression
    columns = zip(
        result.names, result.units, result.before, result.after, result.errors, regression.identifiable, strict=True
    )
    rows = [(n, u, float(b), float(a), float(e) if known else "not identifiable") for n, u, b, a, e, known in columns]
    fits = [(one.drive, one.unit, one.size, one.error, one.validation) for one in result.fits]
    count = len(result.model.names)
    gains = [(one.drive, one.unit, one.value, one.error) for one in result.gains]
    return [
        head(result.declared.name, f"{regression.identifiable[:count].sum()} of {count} base parameters identifiable"),
        table(("", "unit", "before", "after", "standard error"), rows[: len(rows) - len(gains)], "base parameters"),
        *([table(("", "unit", "gain", "standard error"), gains, "gains of drives")] if gains else []),
        table(("", "unit", "measured", "error", "validation error"), fits, "driving forces, root mean squares"),
        note(
            f"condition number {regression.condition:.3g}; band {result.band:.3g} Hz; "
            f"{regression.dof} degrees of freedom"
        ),
        *notes(result.notes),
    ]


def identified(result: Identified) -> list[Markup]:
    """Return bodies, or parameters with names, before and after."""
    parts = [head(result.scene.name, "identified")]
    if result.named is not None:
        one = result.named
        columns = zip(one.names, one.before, one.values, one.errors, strict=True)
        rows = [(name, float(before), float(value), float(error)) for name, before, value, error in columns]
        parts.append(table(("", "before", "after", "standard error"), rows, "parameters with names"))
    if result.physical is not None:
        known = result.physical.unknowns
        both = (("before", known.inertias(known.values)), ("after", known.inertias(result.physical.values)))
        bodies: list[list[str | int | float | Markup]] = [
            [name, when, mass, *map(float, (*centre, *moments))]
            for k, name in enumerate(known.bodies)
            for when, each in both
            for mass, centre, moments, _ in [each[k]]
        ]
        heads = ("", "", "mass, kg", "x, m", "y, m", "z, m", "I1, kg m\u00b2", "I2", "I3")
        parts.append(table(heads, bodies, "masses, centres of mass, principal moments"))
    return [*parts, *notes(result.notes)]


WIDEST = 16
"""Columns of a matrix that are shown."""


def linearization(system: Linearization) -> list[Markup]:
    """Return the matrices of a linear system, its modes, and whether it is stable."""
    told = system.stability
    matrices = [_matrix(letter, getattr(system, letter), *names) for letter, names in system.names.items()]
    return [
        head(system.scene.name, f"linearised {system.manner}"),
        verdict(told.verdict != "unstable", told.words),
        note(system.where),
        beside(*matrices),
        shown(system.damp()),
        *(note(line) for line in told.lines),
        *notes(system.notes),
    ]


def latex_of_linearization(system: Linearization | Formulas) -> str:
    """Return the linear system in LaTeX."""
    return system.latex()


def linear_answer(result: Any) -> list[Markup]:
    """Return what a linear system, a regulator or a response says of itself, its plot if it has one, its tables."""
    first, *lines = repr(result)[1:-1].split("\n")
    parts, draw = [head(first), *map(note, lines)], getattr(result, "picture", None)
    if draw and EXTRAS["plot"].there:
        parts.append(picture(draw("svg"), "svg", f"plot of {first}", dark=False))
    elif draw:
        parts.append(note(f"plots need matplotlib: {install('plot')}"))
    return [*parts, beside(*map(shown, result.tables()))]


def linear_formulas(result: Formulas) -> list[Markup]:
    """Return the matrices of a linear system in SymPy, those in full that are short."""
    rows = []
    for name in ("A", "B", "C", "D"):
        matrix = getattr(result, name)
        short = matrix and sum(entry.count_ops() for entry in matrix) <= SHORT
        rows.append((name, formula(result.latex(name)) if short else f"{matrix.rows} × {matrix.cols}"))
    return [head(result.name, "linearised, in SymPy"), table(("", ""), rows), note(repr(result)[1:-1])]


def sensitivity(result: Sensitivity) -> list[Markup]:
    """Return the derivatives of the end of a run."""
    text = f"{result.method}, {result.steps} steps, {result.by}"
    return [
        head(result.scene.name, f"how the end at t = {result.t:g} s depends on the start; {text}"),
        _matrix("d end / d start", result.matrix, result.rows, result.columns),
        *notes(result.notes),
    ]


def branches(result: Branches) -> list[Markup]:
    """Return the postures in which an arm has a pose."""
    return [head(result.scene.name, "postures at a pose"), shown(result.table), *notes(result.notes)]


def gait(result: Gait) -> list[Markup]:
    """Return a periodic motion: period, fixed point, multipliers."""
    first, *rest = result.words
    return [head(result.scene.name, first.partition(": ")[2]), *notes(rest)]


def _matrix(name: str, matrix: Array, rows: Sequence[str], columns: Sequence[str]) -> Markup:
    """Return a matrix with names on its rows and columns; one that is zero or wide in a line."""
    if not matrix.size:
        return Markup("")
    if not matrix.any():
        return note(f"{name} = 0")
    if len(columns) > WIDEST:
        return note(f"{name}: {len(rows)} × {len(columns)} numbers")
    return shown(Table.matrix(name, rows, columns, matrix.tolist()))


MOST = 1200
"""Terms of equations beyond which nobody reads them in a notebook; a six-axis arm with numbers has a thousand."""


def equations_of_motion(equations: EquationsOfMotion) -> list[Markup]:
    """Return the equations of motion, and those of loops and contacts."""
    first = head(equations.scene.name, "equations of motion")
    try:
        if (long := _length(equations.closed)) > MOST:
            return [first, note(_too_long(long, ".latex(), .text() and .sympy()"))]
        page = equations.page
    except SymdynError as fault:
        return [first, note(str(fault))]
    return [first, formulas(_equations(page)), *_constraints(page)]


def latex_of_equations(equations: EquationsOfMotion) -> str:
    """Return the equations of motion in LaTeX, "" where they are too long or there are none."""
    try:
        return _latex(equations.closed, "equations")
    except SymdynError:
        return ""


def closed_form(result: ClosedForm, printable: Callable[[ClosedForm], Printable] = Printable.of) -> list[Markup]:
    """Return the coefficients that do not vanish; `printable` may know already what is said of them."""
    first = head(result.scene.name, "coefficients of the equations of motion")
    try:
        if (long := _length(result)) > MOST:
            return [first, note(_too_long(long, ".form() and .sympy() of one coefficient, such as ('k_z', 0, 0),"))]
        page = printable(result)
    except SymdynError as fault:
        return [first, note(str(fault))]
    return [first, formulas(_coefficients(page))]


def latex_of_closed_form(result: ClosedForm) -> str:
    """Return the coefficients in LaTeX, "" where they are too long."""
    return _latex(result, "coefficients")


def sympy_equations(result: SympyEquations) -> list[Markup]:
    """Return what there is, matrix by matrix, those in full that are short."""
    from sympy.physics.vector.printing import vlatex

    rows = []
    for name, text in MATRICES.items():
        matrix = getattr(result, name)
        if not matrix.rows or (name == "k_E" and matrix.is_zero_matrix):
            continue
        entries: str | Markup = f"{matrix.rows} × {matrix.cols}"
        if sum(entry.count_ops() for entry in matrix) <= SHORT:
            entries = formula(vlatex(matrix, symbol_names=result.letters, mat_str="bmatrix", mat_delim=""))
        rows.append((text, formula(LETTERS.get(name, name)), entries))
    elastic = "" if result.k_E.is_zero_matrix else " + k_E"
    loops = r" + G^{\mathsf T} \lambda" if result.G.rows else ""
    law = rf"M \ddot q + C \dot q + g{elastic} = \tau{loops}"
    return [head(result.scene.name, "equations of motion in SymPy"), formula(law), table(("", "", ""), rows)]


MATRICES = {
    "M": "mass matrix",
    "C": "Coriolis matrix, Ṁ - 2 C is skew",
    "g": "gravity",
    "k_E": "springs",
    "tau": "drives and other forces",
    "G": "rows of loops and contacts",
    "multipliers": "multipliers",
}
"""What is shown of equations in SymPy."""

LETTERS = {"k_E": "k_E", "tau": r"\tau", "multipliers": r"\lambda"}
SHORT = 120
"""Operations of a matrix that is shown in full."""


def _length(closed: ClosedForm) -> int:
    """Return the number of terms in normal form, which is known before anything is written."""
    return sum(len(closed[key]) for key in closed.coefficient_names() if key[0] != "k_E")


def _too_long(terms: int, way: str) -> str:
    return f"{terms} terms are more than a notebook shows; {way} give them"


def _latex(closed: ClosedForm, group: str) -> str:
    return "" if _length(closed) > MOST else printed_text(closed, "latex", group)


def _equations(page: Printable) -> Iterator[str]:
    write = page.writer()
    for i in range(len(page.rows)):
        yield f"{write(page.left(i)) or '0'} {BREAK}= {write(page.driving(i))}"
    for name, form in (*page.beside, *page.definitions):
        yield f"{write.symbols[name]} {BREAK}= {write(form)}"


def _constraints(page: Printable) -> Iterator[Markup]:
    found, write = page.constraints, page.writer()
    rows = [(formula(write.symbols[row.multiplier]), row.text, row.unit) for row in found.rows]
    yield table(("multiplier", "", "unit"), rows)
    if found.missing:
        yield note(f"G has no closed form: {found.missing}")
    forms = {"positions": found.positions(), "velocities": found.rates(), "accelerations": found.accelerations()}
    for name, rows_of in forms.items():
        if rows_of and not found.missing:
            yield note(f"loops and contacts, {name}")
            yield formulas(f"{write(form)} {BREAK}= 0" for form in rows_of)


def _coefficients(page: Printable) -> Iterator[str]:
    write = page.writer()
    for c in page.written:
        yield f"{' = '.join(c.names)} {BREAK}= {write(c.form)}"
    for zero in page.vanishing:
        yield f" {BREAK}= ".join([*(c.names[0] for c in zero), "0"])
    for name, form in page.definitions:
        yield f"{write.symbols[name]} {BREAK}= {write(form)}"

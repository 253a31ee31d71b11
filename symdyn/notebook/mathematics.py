"""Equations in a notebook: as they are read, where they are not too long for it."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.dynamics import ClosedForm
from symdyn.emit.print import BREAK, EquationsOfMotion, Printable, SympyEquations, latex_symbols, printed_text
from symdyn.errors import SymdynError
from symdyn.notebook.page import Markup, formula, formulas, head, note, table

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


def closed_form(result: ClosedForm) -> list[Markup]:
    """Return the coefficients that do not vanish."""
    first = head(result.scene.name, "coefficients of the equations of motion")
    try:
        if (long := _length(result)) > MOST:
            return [first, note(_too_long(long, ".form() and .sympy() of one coefficient, such as ('k_z', 0, 0),"))]
        page = Printable.of(result)
    except SymdynError as fault:
        return [first, note(str(fault))]
    return [first, formulas(_coefficients(page))]


def latex_of_closed_form(result: ClosedForm) -> str:
    """Return the coefficients in LaTeX, "" where they are too long."""
    return _latex(result, "coefficients")


def sympy_equations(result: SympyEquations) -> list[Markup]:
    """Return what there is, matrix by matrix, those in full that are short."""
    from sympy.physics.vector.printing import vlatex

    names = {
        symbol: latex for name, latex in latex_symbols(result.scene).items() if (symbol := result.symbols.get(name))
    }
    rows = []
    for name, text in MATRICES.items():
        matrix = getattr(result, name)
        if not matrix.rows or (name == "k_E" and matrix.is_zero_matrix):
            continue
        short = sum(entry.count_ops() for entry in matrix) <= SHORT
        shown: str | Markup = f"{matrix.rows} × {matrix.cols}"
        if short:
            shown = formula(vlatex(matrix, symbol_names=names, mat_str="bmatrix", mat_delim=""))
        rows.append((text, formula(LETTERS.get(name, name)), shown))
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
    for name, form in (*page.motions, *page.definitions):
        yield f"{write.symbols[name]} {BREAK}= {write(form)}"


def _constraints(page: Printable) -> Iterator[Markup]:
    """Yield what multipliers are, and the rows."""
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

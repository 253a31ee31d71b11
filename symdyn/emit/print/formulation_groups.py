"""What pages of other formulations are made of: groups of equations, letters that a scene has not, short quotients."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Power, Ratios, Sum, Symbol
from symdyn.dynamics import ClosedForm, Workspace, angle_groups, closed_form
from symdyn.emit.print.formula_text import Forms, in_sines
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op
from symdyn.scene import Scene

LONGEST = 30
"""Terms and factors of a solved velocity up to which it is put in; longer ones stay a linear system."""


TOO_LONG = (DerivationError, OverflowError, ValueError, ZeroDivisionError)
"""What says that there is no quotient that is short enough; a list of other length is one that was not solved for."""


@dataclass(frozen=True)
class EquationRow:
    """One equation: its left side as text and in LaTeX, and the formula on the right.

    Attributes:
        letter, place: of an entry, what its matrix or vector is called in the scene's own letters or not, and where it
            stands there, from 0.
    """

    name: str
    latex: str
    form: Form
    letter: str = ""
    place: tuple[int, ...] = ()


@dataclass(frozen=True)
class EquationGroup:
    """Equations under a title."""

    key: str  # what they are, for what explains them; of a body with its name behind a colon
    title: str
    text: str  # what is said of them, in plain words
    rows: tuple[EquationRow, ...]
    latex: str = ""  # the same with formulas in LaTeX; "" where it is the same
    letters: Sequence[str] = ()  # names of its own that have rates, as coordinates do


def quotient(closed: ClosedForm, node: Expr) -> Form:
    """Return a node as a quotient in factors, each sum as short as sines can write it."""
    form, powers = Ratios.form_of(node), dict[Form, int]()
    _collect(form, 1, powers)
    sign = _squared_sines(powers)
    over = (one.power(e) for one, e in powers.items() if e > 0)
    under = [one.power(-e) for one, e in powers.items() if e < 0]
    whole = [Form.product(under).power(-1)] if under else []
    shortened = (_short(closed, one) if isinstance(one, Sum) else one for one in over)
    return Form.product((sign, *shortened, *whole))


def _collect(form: Form, exponent: int, powers: dict[Form, int]) -> None:
    """Add the factors of a product to a table of exponents, those below a line too."""
    for one in form.factors:
        if isinstance(one, Power):
            _collect(one.base, exponent * one.exponent, powers)
        else:
            powers[one] = powers.get(one, 0) + exponent


def _squared_sines(powers: dict[Form, int]) -> Number:
    """Put sin² x in place of (cos x - 1)(cos x + 1) in a table of exponents, and return the sign that this takes."""
    sign = 1
    for below in [one for one in powers if isinstance(one, Sum)]:
        cosine = below.terms[0]
        above = Form.sum((cosine, Number.ONE))
        if not isinstance(cosine, Function) or cosine.op is not Op.COS or above not in powers:
            continue
        if below == Form.sum((cosine, Number.MINUS_ONE)) and powers[below] == powers[above]:
            both = powers.pop(below)
            sine = Function(Op.SIN, cosine.args)
            powers[sine] = powers.get(sine, 0) + 2 * powers.pop(above)
            sign *= (-1) ** abs(both)
    return Number(Fraction(sign))


def _short(closed: ClosedForm, form: Form) -> Form:
    node = form.express(closed.state.q[0].graph)
    return in_sines([node], closed.state, closed.parallel)(node)


def refuse_rows(scene: Scene, what: str) -> None:
    """Raise DerivationError where rows tie the coordinates, or a motion is prescribed."""
    if scene.is_constrained:
        raise DerivationError(
            f"{scene.name}: {what} are written in independent coordinates, and loops or rows tie these; "
            "print Lagrange's equations with multipliers, or D'Alembert's system"
        )
    refuse_led(scene, what)


def refuse_led(scene: Scene, what: str) -> None:
    """Raise DerivationError where a motion is prescribed."""
    if scene.prescribed_velocities:
        raise DerivationError(f"{scene.name}: prescribed motions have no place in {what}; print Lagrange's equations")


def open_form(scene: Scene, what: str) -> ClosedForm:
    """Return the closed form of a scene that no row ties."""
    refuse_rows(scene, what)
    return closed_form(scene)


def fresh(scene: Scene, letters: Sequence[str], index: Sequence[int] = ()) -> list[str]:
    """Return a letter, or one for each index where there are several velocities: the first that the scene has not."""
    taken = {one.name for one in (*scene.parameters, *scene.given)} | {*filter(None, scene.drives)}
    taken |= {*scene.coordinates, *scene.velocities}
    names = [[f"{x}{i + 1}" for i in index] if index and len(scene.velocities) > 1 else [x] for x in letters]
    return next((one for one in names if not taken.intersection(one)), [f"{name}_" for name in names[-1]])


def named_row(scene: Scene, letter: str, form: Form) -> EquationRow:
    """Return the row of a function by its letter, calligraphic where the scene has that letter, a small one bold."""
    (name,) = fresh(scene, (letter, f"{letter}_cal"))
    style = "cal" if letter.isupper() else "bf"  # TeX has no small calligraphic letters
    return EquationRow(name, letter if name == letter else rf"\math{style}{{{letter}}}", form)


def entry_row(scene: Scene, letter: str, form: Form, *place: int) -> EquationRow:
    """Return the row of an entry of a vector or matrix, places from 0, by its letter, as `named_row` has it."""
    of = named_row(scene, letter, form)
    head, _, below = of.latex.partition("_")
    numbers = [str(k + 1) for k in place]
    index = ("_" if any(k > 8 for k in place) else "").join(numbers)
    return EquationRow(
        f"{of.name}{index}", f"{head}_{{{','.join(filter(None, (below, *numbers)))}}}", form, letter, place
    )


def nonzero_rows(rows: Iterable[EquationRow]) -> tuple[EquationRow, ...]:
    """Return the rows that say something."""
    return tuple(row for row in rows if row.form != Number.ZERO)


def ordered_workspace(scene: Scene, what: str) -> Workspace:
    """Return a workspace whose symbols are born in the order in which formulas name them."""
    refuse_rows(scene, what)
    w = Workspace(scene)
    for name in (*(one.name for one in scene.parameters), *scene.coordinates):
        w.graph.symbol(name)
    return w


def written_forms(w: Workspace, nodes: Sequence[Expr]) -> Forms:
    """Return what writes nodes as short as sines can."""
    return in_sines(nodes, w.state, angle_groups(w.scene, w.graph))


def drive_symbols(scene: Scene) -> list[Form]:
    """Return the drive of every velocity, zero where there is none."""
    return [Symbol(drive) if drive else Number.ZERO for drive in scene.drives]

"""Equations of motion as text, grouped one way or another, and base parameters, in every format."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from symdyn.algebra import Form
from symdyn.dynamics import ClosedForm
from symdyn.emit.print.formula_text import Latex, rounded, text_of
from symdyn.emit.print.latex_page import base_parameter_name, latex_definitions, latex_document, latex_fragment
from symdyn.emit.print.printable import ENTRYWISE, Printable
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.emit.print.sympy_page import sympy_definitions, sympy_page
from symdyn.emit.print.text_page import text_definitions, text_page
from symdyn.errors import EmitError
from symdyn.rounding import requested_digits
from symdyn.scene import Scene


@dataclass(frozen=True)
class Format:
    """What equations are written in.

    Attributes:
        page: writes equations by group.
        definitions: writes name = formula.
        document: writes a whole document of them; None where it has none.
        digits: most digits of a number; None leaves them exact, or to `page`.
    """

    page: Callable[[Printable, str], str]
    definitions: Callable[[Scene, Sequence[tuple[str, Form]]], str]
    document: Callable[[Printable, str], str] | None = None
    digits: int | None = None


FORMATS = {
    "latex": Format(latex_fragment, latex_definitions, latex_document),
    "text": Format(text_page, text_definitions, digits=15),  # what every double holds
    "sympy": Format(sympy_page, sympy_definitions),
}
GROUPS = tuple(ENTRYWISE)

_CHOICES = {"format": tuple(FORMATS), "group": GROUPS, "angles": ("long", "short")}


def equations_text(
    scene: Scene | ClosedForm,
    format: str = "latex",
    group: str = "equations",
    angles: str = "long",
    document: bool = False,
) -> str:
    r"""Return the equations of motion as text.

    Args:
        scene: the mechanism, or its closed forms.
        format: "latex", "text" (`symdyn.scene.parse` reads it back; numbers exact, but for those of more digits than
            a double holds, rounded to 15) or "sympy" (Python that runs after `from sympy import *`; numbers exact).
        group: "equations" (one a joint), "coefficients" (k_{z,11} = …), "textbook" (under-braced, as (5.40)) or
            "matrix" (M(q) q̈ + c + g).
        angles: "long" for \sin(q_1 + q_2), "short" for s_{12}.
        document: a whole LaTeX document with energies and a symbol table.

    Raises:
        EmitError: an unknown choice, or a document in another format than LaTeX.
        DerivationError: the scene has no closed form, or its loops cannot be assembled.
    """
    _check("format", format)
    _check("group", group)
    _check("angles", angles)
    write = FORMATS[format].document if document else FORMATS[format].page
    if write is None:
        raise EmitError(f"a document is written in LaTeX, not as {format}; leave the format out, or the document")
    return write(Printable.of(scene, angles == "short", requested_digits() or FORMATS[format].digits), group)


def base_parameters_text(scene: Scene, format: str = "latex") -> str:
    """Return every base parameter as `name = formula`, the ground's side first; `format` as for `equations_text`.

    Raises:
        EmitError: an unknown format.
        DerivationError: a formula has no closed form.
    """
    from symdyn.dynamics import base_parameter_forms

    _check("format", format)
    digits, named = requested_digits(), base_parameter_forms(scene)
    shown = named if digits is None else [(name, rounded(form, digits)) for name, form in named]
    return FORMATS[format].definitions(scene, shown)


def _check(name: str, value: str) -> None:
    if value not in _CHOICES[name]:
        *others, last = _CHOICES[name]
        raise EmitError(f"{name} {value!r} is not known; give {', '.join(others)} or {last}")


def base_parameter_texts(scene: Scene) -> list[dict[str, str]]:
    """Return name, formula, LaTeX of both, and unit of every base parameter, numbers exact."""
    from symdyn.dynamics import base_parameter_forms

    write = Latex(latex_symbols(scene), digits=None)
    return [
        {
            "name": name,
            "formula": text_of(form),
            "latex": f"{base_parameter_name(name)} = {write.unbroken(form)}",
            "unit": "kg" if name[0] == "M" else "kg m" if name[0] == "m" else "kg m^2",
        }
        for name, form in base_parameter_forms(scene)
    ]


def printed_text(
    scene: Scene | ClosedForm,
    format: str = "latex",
    what: str = "equations",
    angles: str = "long",
    document: bool = False,
    formulation: str = "lagrange",
) -> str:
    """Return the equations of motion as `equations_text` does, or what can be printed in place of them.

    `what` is a group of equations, or "base-parameters"; `formulation` "lagrange", or "dalembert" for (5.18).

    Raises:
        EmitError, DerivationError: as `equations_text`, or as those that print the others.
    """
    if formulation == "lagrange" and what != "base-parameters":
        return equations_text(scene, format, what, angles, document)
    if angles != "long":
        raise EmitError(f"{angles} angles are those of equations in closed form; leave --angles out")
    plain = scene.scene if isinstance(scene, ClosedForm) else scene
    if formulation == "lagrange":
        return _base_parameters(plain, format, document)
    if what != "equations":
        raise EmitError(f"D'Alembert's system is no {what}; leave --as out, or --formulation dalembert")
    return _dalembert(plain, format, document)


def _base_parameters(scene: Scene, format: str, document: bool) -> str:
    if document:
        raise EmitError("a document holds equations; leave --document out, or --as base-parameters")
    return base_parameters_text(scene, format)


def _dalembert(scene: Scene, format: str, document: bool) -> str:
    from symdyn.emit.print.dalembert_page import dalembert_equations

    return dalembert_equations(scene, format, document)


CHOICES = {**_CHOICES, "what": (*GROUPS, "base-parameters"), "formulation": ("lagrange", "dalembert")}
"""What can be printed, by argument of `printed_text`."""

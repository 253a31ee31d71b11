"""The base parameters of a scene in print: LaTeX, plain text, SymPy."""

from __future__ import annotations

from symdyn.dynamics.closed_forms.frames_and_parameters import base_parameter_forms
from symdyn.emit.print.equations_text import FORMATS
from symdyn.emit.print.formula_text import Latex, text_of
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.errors import EmitError
from symdyn.scene import Scene


def base_parameters_text(scene: Scene, format: str = "latex") -> str:
    """Return every base parameter as `name = formula`, the ground's side first.

    Args:
        scene: the mechanism.
        format: "latex", "text" or "sympy", as for `equations_text`.

    Raises:
        EmitError: an unknown format.
        DerivationError: a formula has no closed form.
    """
    if format not in FORMATS:
        raise EmitError(f"format {format!r} is not known; give {', '.join(FORMATS[:-1])} or {FORMATS[-1]}")
    named = base_parameter_forms(scene)
    if format == "latex":
        from symdyn.emit.print.latex_page import latex_definitions

        return latex_definitions(scene, [(latex_name(name), form) for name, form in named])
    if format == "text":
        from symdyn.emit.print.text_page import text_definitions

        return text_definitions(named)
    from symdyn.emit.print.sympy_page import sympy_definitions

    return sympy_definitions(scene, named)


def base_parameter_texts(scene: Scene) -> list[dict[str, str]]:
    """Return name, formula, LaTeX of both, and unit of every base parameter, numbers exact."""
    write = Latex(latex_symbols(scene), digits=None)
    return [
        {
            "name": name,
            "formula": text_of(form),
            "latex": f"{latex_name(name)} = {write.unbroken(form)}",
            "unit": "kg" if name[0] == "M" else "kg m" if name[0] == "m" else "kg m^2",
        }
        for name, form in base_parameter_forms(scene)
    ]


def latex_name(name: str) -> str:
    r"""Return \mathit{ZZ}_{R1} for ZZR1 and M_{R3} for MR3."""
    head, joint = name.split("R")
    head = head if len(head) == 1 else rf"\mathit{{{head}}}"
    return rf"{head}_{{R{joint}}}"

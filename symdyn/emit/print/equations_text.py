"""The equations of motion in print: LaTeX, plain text, SymPy; per joint, per coefficient, grouped or as matrices."""

from __future__ import annotations

from symdyn.dynamics.closed_forms.closed_form import ClosedForm
from symdyn.emit.print.printable import printable
from symdyn.errors import EmitError
from symdyn.scene import Scene

GROUPS = ("equations", "coefficients", "textbook", "matrix")
FORMATS = ("latex", "text", "sympy")
ANGLES = ("long", "short")

DIGITS = 15  # of decimals in plain text: what every double holds


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
    for name, value, known in (("format", format, FORMATS), ("group", group, GROUPS), ("angles", angles, ANGLES)):
        if value not in known:
            raise EmitError(f"{name} {value!r} is not known; give {', '.join(known[:-1])} or {known[-1]}")
    if document and format != "latex":
        raise EmitError(f"a document is written in LaTeX, not as {format}; leave the format out, or the document")
    page = printable(scene, angles == "short", DIGITS if format == "text" else None)
    if format == "latex":
        from symdyn.emit.print.latex_page import latex_document, latex_fragment

        return latex_document(page, group) if document else latex_fragment(page, group)
    if format == "text":
        from symdyn.emit.print.text_page import text_page

        return text_page(page, group)
    from symdyn.emit.print.sympy_page import sympy_page

    return sympy_page(page, group)

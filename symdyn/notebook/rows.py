"""The table of what is shown, a row a noun; the file of a row is imported when a notebook first shows such a noun."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from symdyn.notebook.page import Markup, page

NOUNS = {
    "symdyn.runtime.loaded:Loaded": "functions:loaded",
    "symdyn.runtime.numeric_function:NumericFunction": "functions:numeric",
    "symdyn.draw.shown_text:HtmlText": "pictures:html",
    "symdyn.draw.shown_text:SvgText": "pictures:svg",
    "symdyn.dynamics.closed_forms.closed_form:ClosedForm": "mathematics:closed_form",
    "symdyn.dynamics.outputs.named_functions:Equations": "functions:derived",
    "symdyn.emit.print.equations_of_motion:EquationsOfMotion": "mathematics:equations_of_motion",
    "symdyn.emit.print.sympy_equations:SympyEquations": "mathematics:sympy_equations",
    "symdyn.identification.identification:Identification": "fitted:identification",
    "symdyn.identification.scene:Identified": "fitted:identified",
    "symdyn.identification.output_fit:OutputFit": "fitted:output_fit",
    "symdyn.identification.excitation:Excitation": "runs:excitation",
    "symdyn.linear.linearization:Linearization": "first_order:linearization",
    "symdyn.program.routine:Program": "functions:program",
    "symdyn.scene.values.model:Scene": "scenes:scene",
    "symdyn.simulation.gradients:Sensitivity": "first_order:sensitivity",
    "symdyn.simulation.trajectory:Trajectory": "runs:trajectory",
    "symdyn.simulation.error_bars:Uncertainty": "studies:uncertainty",
    "symdyn.study.indices:Indices": "studies:indices",
    "symdyn.study.runs:Runs": "studies:runs",
    "symdyn.transcription.solution:Solution": "runs:solution",
    "symdyn.transcription.transcribed:Collocation": "runs:collocation",
    "symdyn.verify.certificate:Certificate": "verdicts:certificate",
    "symdyn.verify.rigorous:Rigorous": "verdicts:rigorous",
}
"""Noun, and what returns the parts that are shown of one: a function of a file of this package."""

LATEX = {
    "symdyn.dynamics.closed_forms.closed_form:ClosedForm": "mathematics:latex_of_closed_form",
    "symdyn.emit.print.equations_of_motion:EquationsOfMotion": "mathematics:latex_of_equations",
    "symdyn.linear.linearization:Linearization": "first_order:latex_of_linearization",
}
"""Those that are LaTeX too, for notebooks that become documents; "" where there is none."""


def bundle(noun: Any) -> dict[str, str]:
    """Return what is shown of a noun by media type: HTML, for some LaTeX, and plain text, which is `repr`."""
    parts: list[Markup] = _row(NOUNS, noun)(noun)
    found = {"text/html": page(*parts), "text/plain": repr(noun)}
    if _key(LATEX, noun) and (latex := _row(LATEX, noun)(noun)):
        found["text/latex"] = latex
    return found


def _key(table: dict[str, str], noun: Any) -> str:
    names = (f"{one.__module__}:{one.__qualname__}" for one in type(noun).__mro__)
    return next((name for name in names if name in table), "")


def _row(table: dict[str, str], noun: Any) -> Callable[[Any], Any]:
    file, _, name = table[_key(table, noun)].partition(":")
    found: Callable[[Any], Any] = getattr(import_module(f"symdyn.notebook.{file}"), name)
    return found

"""HTML that an object shows in a notebook, made of a few kinds of parts, and the table of such objects.

All text is escaped here and nowhere else. Pictures stand in the page as data of an <img>: no script in them runs, no
identifier meets that of another output, and they follow the reader's light or dark mode by themselves. Animations run
in a frame of their own.

The table has a row for each type; the file of a row is imported when a notebook first shows an object of that type.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from typing import Any

from symdyn.emit import in_html, verbatim
from symdyn.emit.print import BREAK
from symdyn.extras import EXTRAS, install
from symdyn.frozen import dataclass
from symdyn.table import Table


@dataclass(frozen=True)
class Markup:
    """HTML that is whole: what came from a scene is escaped."""

    html: str

    def __html__(self) -> str:
        """Return it to who asks what needs no escape."""
        return self.html


Cell = str | int | float | Markup

MATHEMATICS = EXTRAS["teach"]
"""The job of the package that makes mathematics of browsers from LaTeX."""


def page(*parts: Markup) -> str:
    """Return the parts as one element, with its style."""
    return f'<div class="symdyn-shown"><style>{verbatim("notebook/style.css")}</style>\n{_lines(parts)}\n</div>'


def head(name: str, text: str = "") -> Markup:
    """Return the first line: what it is, and more of it."""
    more = f" <span>{in_html(text)}</span>" if text else ""
    return Markup(f'<p class="head">{in_html(name)}{more}</p>')


def verdict(good: bool, text: str) -> Markup:
    """Return a word that is good or bad news."""
    return Markup(f'<p class="{"good" if good else "bad"}">{in_html(text)}</p>')


def note(text: str) -> Markup:
    """Return a line beside the matter."""
    return Markup(f'<p class="note">{in_html(text)}</p>')


def notes(texts: Iterable[str]) -> list[Markup]:
    """Return lines beside the matter."""
    return [note(f"Note: {text}") for text in texts]


def picture(content: str | bytes, kind: str, text: str, dark: bool = True) -> Markup:
    """Return a picture, "svg" or "png"; `text` says what is seen, for who does not see it.

    One that is not `dark` where the reader wants it so has its light and dark exchanged there, and keeps its hues.
    """
    data = content.encode() if isinstance(content, str) else content
    kind = "svg+xml" if kind == "svg" else kind
    style = "" if dark else ' class="light"'
    source = f"data:image/{kind};base64,{b64encode(data).decode()}"
    return Markup(f'<figure><img{style} alt="{in_html(text)}" src="{source}"></figure>')


def plotted(drawn: Callable[[Any], bytes], points: int, text: str) -> Markup:
    """Return a plot that is drawn as "svg", or as "png" where it has many points; or what it takes to show it."""
    if not EXTRAS["plot"].there:
        return note(f"plots need matplotlib: {install('plot')}")
    kind = "svg" if points <= MOST_POINTS else "png"
    return picture(drawn(kind), kind, text, dark=False)


MOST_POINTS = 20_000
"""Points of curves beyond which dots make a smaller picture than lines."""


def frame(html: str, text: str) -> Markup:
    """Return a page in a frame of its own; its scripts reach nothing of the notebook."""
    return Markup(f'<iframe title="{in_html(text)}" sandbox="allow-scripts" srcdoc="{in_html(html)}"></iframe>')


def beside(*parts: Markup | Sequence[Markup]) -> Markup:
    """Return parts side by side where there is room; several that are one part are one below the other."""
    whole = [part.html if isinstance(part, Markup) else f"<div>{_lines(part)}</div>" for part in parts]
    return Markup('<div class="beside">' + "\n".join(whole) + "</div>")


def _lines(parts: Iterable[Markup]) -> str:
    return "\n".join(part.html for part in parts)


def folded(summary: str, *parts: Markup) -> Markup:
    """Return parts that are seen when the reader opens them."""
    return Markup(f"<details><summary>{in_html(summary)}</summary>\n{_lines(parts)}</details>")


def table(columns: Sequence[str], rows: Iterable[Sequence[Cell]], caption: str = "") -> Markup:
    """Return a table; columns of numbers stand to the right, and a table without rows is nothing."""
    listed = [list(row) for row in rows]
    columns_of = zip(*listed, strict=True)
    numbers = [k for k, cells in enumerate(columns_of) if all(isinstance(cell, (int, float)) for cell in cells)]
    return shown(Table(columns, listed, numbers, caption))


def shown(found: Table[Any]) -> Markup:
    """Return a table; one without rows is nothing."""
    return Markup(found.html() if found.rows else "")


def formulas(lines: Iterable[str]) -> Markup:
    """Return formulas, given in LaTeX with break marks, one a paragraph; or what it takes to show them."""
    if not MATHEMATICS.there:
        return note(f"mathematics is shown with latex2mathml: {install('teach')}")
    from symdyn.teach import flow

    shown = "\n".join(f'<div class="flow">{flow("", line)}</div>' for line in lines)
    return Markup(f'<div class="long">{shown}</div>')


def formula(latex: str) -> Markup:
    """Return a short formula in a line of text; the LaTeX itself where it cannot be shown."""
    if not MATHEMATICS.there:
        return Markup(f"<code>{in_html(latex)}</code>")
    from symdyn.teach import inline

    return Markup(inline(latex.replace(BREAK, "")))


def svg(result: str) -> list[Markup]:
    """Return a picture."""
    return [picture(result, "svg", "picture of a mechanism")]


def html(result: str) -> list[Markup]:
    """Return a page in a frame."""
    return [frame(result, "animation of a mechanism")]


NOUNS = {
    "symdyn.runtime.loaded:Loaded": "mechanisms:loaded",
    "symdyn.runtime.numeric_function:NumericFunction": "mechanisms:numeric",
    "symdyn.draw.pictures:HtmlText": "page:html",
    "symdyn.draw.pictures:SvgText": "page:svg",
    "symdyn.dynamics.closed_forms.closed_form:ClosedForm": "mechanisms:closed_form",
    "symdyn.dynamics.outputs.named_functions:Equations": "mechanisms:derived",
    "symdyn.emit.print.equations_text:EquationsOfMotion": "mechanisms:equations_of_motion",
    "symdyn.emit.print.sympy_equations:SympyEquations": "mechanisms:sympy_equations",
    "symdyn.identification.calibration:Calibration": "mechanisms:calibration",
    "symdyn.identification.identification:Identification": "mechanisms:identification",
    "symdyn.identification.identified_scene:Identified": "mechanisms:identified",
    "symdyn.identification.output_error:OutputFit": "mechanisms:output_fit",
    "symdyn.identification.excitation:Excitation": "runs:excitation",
    "symdyn.linear.formulas:Formulas": "mechanisms:linear_formulas",
    "symdyn.linear.linearization:Linearization": "mechanisms:linearization",
    "symdyn.linear.plots:Answer": "mechanisms:linear_answer",
    "symdyn.program.routine:Program": "mechanisms:program",
    "symdyn.scene.values.model:Scene": "mechanisms:scene",
    "symdyn.simulation.arm_branches:Branches": "mechanisms:branches",
    "symdyn.simulation.variations:Sensitivity": "mechanisms:sensitivity",
    "symdyn.simulation.gait:Gait": "mechanisms:gait",
    "symdyn.simulation.equations.controller:Feedback": "runs:feedback",
    "symdyn.simulation.trajectory:Trajectory": "runs:trajectory",
    "symdyn.simulation.error_bars:Uncertainty": "runs:uncertainty",
    "symdyn.study.design:Indices": "runs:indices",
    "symdyn.study.runs:Runs": "runs:runs",
    "symdyn.transcription.solution:Solution": "runs:solution",
    "symdyn.transcription.transcribed:Collocation": "runs:collocation",
    "symdyn.verify.certificate:Certificate": "runs:certificate",
    "symdyn.verify.rigorous:Rigorous": "runs:rigorous",
}
"""Noun, and what returns the parts that are shown of one: a function of a file of this package."""

LATEX = {
    "symdyn.dynamics.closed_forms.closed_form:ClosedForm": "mechanisms:latex_of_closed_form",
    "symdyn.emit.print.equations_text:EquationsOfMotion": "mechanisms:latex_of_equations",
    "symdyn.linear.formulas:Formulas": "mechanisms:latex_of_linearization",
    "symdyn.linear.linearization:Linearization": "mechanisms:latex_of_linearization",
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

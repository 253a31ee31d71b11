"""D'Alembert's system of a scene, for all reactions, in the formats that it is written in."""

from __future__ import annotations

from symdyn.emit.print.dalembert_lines import dalembert_lines
from symdyn.emit.print.dalembert_page import dalembert_text
from symdyn.errors import EmitError
from symdyn.scene import Scene


def dalembert_equations(scene: Scene, format: str = "latex", document: bool = False) -> str:
    """Return the system in LaTeX, a whole document of it where that is asked for, or as plain text.

    Raises:
        EmitError: another format, a document of text, or more than anybody reads.
    """
    if format == "text" and not document:
        return dalembert_lines(scene)
    if format != "latex":
        raise EmitError(f"D'Alembert's system is written in LaTeX and, without --document, as text, not as {format}")
    return dalembert_text(scene, document)

"""Beside C: an example that calls every function and knows what must come out, and a file for CMake that builds it."""

from __future__ import annotations

from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.real import find_real
from symdyn.emit.code.target import Sources
from symdyn.emit.code.worked_example import worked_example
from symdyn.emit.render import render
from symdyn.program.prepare import PREPARE

EXAMPLE, BUILD = "main.c", "CMakeLists.txt"


def files_beside(sources: Sources, lone_header: bool, many: bool) -> dict[str, str]:
    """Return the example and the file for CMake of C sources; both are plain of what a scene says.

    Args:
        sources: of target C.
        lone_header: whether they are one header alone.
        many: whether there are functions over many states.
    """
    opening = stem(sources.program.scene.name)
    made, real = worked_example(sources), find_real(sources.real)
    example = EXAMPLE if opening != "main" else "example.c"
    values = {
        "stem": opening, "real": real.name, "suffix": real.suffix, "given": made.given, "called": made.called,
        "left_out": made.left_out, "prepare": PREPARE, "lone_header": lone_header, "many": many,
        "example": example,
    }  # fmt: skip
    return {example: render("c/main.c.jinja", values), BUILD: render("c/CMakeLists.txt.jinja", values)}

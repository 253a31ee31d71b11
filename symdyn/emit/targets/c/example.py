"""Beside C: an example that calls every function and knows what must come out, and a file for CMake that builds it."""

from __future__ import annotations

from symdyn.emit.code.example_text import example_text
from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.real import find_real
from symdyn.emit.code.target import Sources
from symdyn.emit.render import render

BUILD = "CMakeLists.txt"


def files_beside(sources: Sources, lone_header: bool, many: bool) -> dict[str, str]:
    """Return the example and the file for CMake of C sources; both are plain of what a scene says.

    Args:
        sources: of target C.
        lone_header: whether they are one header alone.
        many: whether there are functions over many states.
    """
    real = find_real(sources.real)
    template = "c/main.c.jinja" if real.parts == 1 else "c/dd_main.c.jinja"
    example = example_text(sources, template, ".c", suffix=real.suffix, real=real.name)
    opening, (name,) = stem(sources.program.scene.name), example
    values = {"stem": opening, "example": name, "lone_header": lone_header, "many": many}
    return {**example, BUILD: render("c/CMakeLists.txt.jinja", values)}

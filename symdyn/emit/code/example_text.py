"""An example beside generated code, for languages with one file that is compiled and run by itself."""

from __future__ import annotations

from typing import Any

from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.target import Sources
from symdyn.emit.code.worked_example import worked_example
from symdyn.emit.render import render
from symdyn.program import Program


def example_text(sources: Sources, template: str, ending: str, suffix: str = "", **values: Any) -> dict[str, str]:
    """Return the example by its name: main, or example where the scene has that name itself.

    Args:
        sources: what it calls.
        template: what it looks like.
        ending: of its name.
        suffix: how numbers of the type end in the language.
        values: what else the template is given.
    """
    opening, made = stem(sources.program.scene.name), worked_example(sources, suffix)
    shapes = dict(zip(sources.functions, (r.function.shape for r in sources.program.routines), strict=True))
    example = f"{'example' if opening == 'main' else 'main'}{ending}"
    known = {
        "shapes": shapes,
        "stem": opening,
        "example": example,
        "given": made.given,
        "called": made.called,
        "left_out": made.left_out,
        "prepare": Program.PREPARE,
        "suffix": suffix,
    }
    scalars = [one.name for one in made.given if one.scalar]
    return {example: render(template, {**known, "scalars": scalars, **values})}

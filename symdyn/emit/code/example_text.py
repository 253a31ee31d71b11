"""An example beside generated code, for languages with one file that is compiled and run by itself."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.real import REALS
from symdyn.emit.code.target import Sources
from symdyn.emit.code.worked_example import worked_example
from symdyn.emit.render import render
from symdyn.program.prepare import PREPARE


def example_text(sources: Sources, template: str, ending: str, **values: Any) -> dict[str, str]:
    """Return the example by its name: main, or example where the scene has that name itself.

    Args:
        sources: what it calls.
        template: what it looks like.
        ending: of its name.
        values: what else the template is given.
    """
    opening, made = stem(sources.program.scene.name), worked_example(sources)
    shapes = dict(zip(sources.functions, (r.function.shape for r in sources.program.routines), strict=True))
    suffix = REALS[sources.real].suffix
    given = [replace(one, values=_plain(one.values, suffix)) for one in made.given]
    called = [
        replace(call, wanted=_plain(call.wanted, suffix), allowed=_plain(call.allowed, suffix)) for call in made.called
    ]
    example = f"{'example' if opening == 'main' else 'main'}{ending}"
    known = {
        "shapes": shapes,
        "stem": opening,
        "example": example,
        "given": given,
        "called": called,
        "prepare": PREPARE,
    }
    scalars = [one.name for one in made.given if one.scalar]
    return {example: render(template, {**known, "left_out": made.left_out, "scalars": scalars, **values})}


def _plain(texts: tuple[str, ...], suffix: str) -> tuple[str, ...]:
    """Return numbers without the suffix that C gives them."""
    return tuple(text.removesuffix(suffix) for text in texts)

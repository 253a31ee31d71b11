"""Pictures and animations in a notebook: as they are seen, and shut in."""

from __future__ import annotations

from symdyn.notebook.page import Markup, frame, picture


def svg(result: str) -> list[Markup]:
    """Return a picture."""
    return [picture(result, "svg", "picture of a mechanism")]


def html(result: str) -> list[Markup]:
    """Return a page in a frame."""
    return [frame(result, "animation of a mechanism")]

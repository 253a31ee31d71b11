"""Pictures and animations in a notebook: as they are seen, and shut in."""

from __future__ import annotations

from symdyn.notebook.page import Markup, frame, picture


def svg(found: str) -> list[Markup]:
    """Return a picture."""
    return [picture(found, "svg", "picture of a mechanism")]


def html(found: str) -> list[Markup]:
    """Return a page in a frame."""
    return [frame(found, "animation of a mechanism")]

"""Text of pictures and pages, which is text like any other, and in a notebook what it describes."""

from __future__ import annotations

from symdyn.shown import Shown


class SvgText(str, Shown):
    """A picture as SVG; a notebook shows the picture."""

    __slots__ = ()

    def __repr__(self) -> str:
        """Return a word in place of the text, which `print` gives."""
        return f"<SVG of {len(self)} characters>"


class HtmlText(str, Shown):
    """A page as HTML; a notebook shows the page in a frame."""

    __slots__ = ()

    def __repr__(self) -> str:
        """Return a word in place of the text, which `print` gives."""
        return f"<HTML of {len(self)} characters>"

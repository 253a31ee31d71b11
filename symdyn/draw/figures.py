"""Plots: figures of matplotlib, the same bytes on every machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from symdyn.draw.canvas import import_matplotlib, saved, settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_POINTS = 20_000
"""Points of curves beyond which dots make a smaller picture than lines."""

DPI = 150

SETTINGS: dict[str, Any] = {"svg.fonttype": "path", "font.size": 9.0, "axes.formatter.useoffset": False}
"""Letters are outlines: what is above another one, as the dots of rates, librsvg and Qt would put elsewhere."""


@dataclass(frozen=True)
class FilledFigure:
    """A plot, for which matplotlib must be installed.

    Attributes:
        title: above it; no mathematics, whatever a scene is called.
        size: width and height, inches.
        fill: draws on a figure that has no axes yet.
    """

    title: str
    size: tuple[float, float]
    fill: Callable[[Any], None]

    def picture(self, kind: str) -> bytes:
        """Return it as "svg", "pdf" or "png"; the same plot, the same bytes."""
        import_matplotlib()
        with settings(SETTINGS | {"svg.hashsalt": self.title}):
            return saved(self._made(), kind, DPI)

    def figure(self, points: int) -> Figure:
        """Return a figure that a notebook shows: as SVG, or as PNG where it has many points."""
        with settings(SETTINGS):
            found = self._made()
        kind = ("svg", "image/svg+xml") if points <= MOST_POINTS else ("png", "image/png")
        found._repr_mimebundle_ = partial(_bundle, found, self.title, *kind)  # type: ignore[attr-defined]
        return found

    def _made(self) -> Figure:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        made = Figure(figsize=self.size, layout="constrained")
        FigureCanvasAgg(made)
        self.fill(made)
        made.suptitle(self.title, x=0.01, ha="left").set_parse_math(False)
        return made


def _bundle(
    figure: Figure, title: str, kind: str, media: str, include: object = None, exclude: object = None
) -> dict[str, str | bytes]:
    """Return what a notebook shows of a figure, as it is now."""
    with settings(SETTINGS | {"svg.hashsalt": title}):
        picture = saved(figure, kind, DPI)
    return {media: picture.decode() if kind == "svg" else picture, "text/plain": repr(figure)}

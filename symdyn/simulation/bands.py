"""Plots of an uncertainty: an axis a column, with bands of one and two standard deviations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from symdyn.draw import FilledFigure
from symdyn.scene.values import listed
from symdyn.simulation.panels import chosen
from symdyn.simulation.record import check_plot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symdyn.simulation.error_bars import Uncertainty

MOST_PANELS = 12

COLOUR = "#1f5f99"


def figure(found: Uncertainty, names: Sequence[str] = ()) -> Figure:
    """Return the figure. Errors as of `Uncertainty.plot`."""
    filled = _filled(found, names)
    check_plot()
    return filled.figure(3 * len(found.t) * len(found.names))


def drawn_bands(found: Uncertainty, form: str, names: Sequence[str] = ()) -> bytes:
    """Return the picture as "svg", "pdf" or "png"; the same numbers, the same bytes."""
    return _filled(found, names).picture(form)


def _filled(found: Uncertainty, names: Sequence[str]) -> FilledFigure:
    every = chosen(found.names, names, found.run.scene.name) if names else found.names
    shown = every[:MOST_PANELS]

    def fill(made: Any) -> None:
        axes = made.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for axis, name in zip(axes, shown, strict=True):
            _draw(axis, found, name)
        more = len(every) - len(shown)
        told = f"bands of one and two standard deviations, by {listed(found.varied)}"
        told += f" (and {more} more columns)" if more else ""
        axes[0].set_title(told, loc="left", fontsize=9).set_parse_math(False)
        axes[-1].set_xlabel("$t$, s" if found.run.columns[0].unit else "$t$")
        made.align_ylabels(axes)

    return FilledFigure(found.run.scene.name, (8.0, max(2.2, 0.4 + 1.6 * len(shown))), fill)


def _draw(axis: Any, found: Uncertainty, name: str) -> None:
    place = found.names.index(name)
    middle, sd = found.run[name], found.sd[:, place]
    for count, alpha in ((2, 0.18), (1, 0.28)):
        axis.fill_between(found.t, middle - count * sd, middle + count * sd, color=COLOUR, alpha=alpha, linewidth=0)
    axis.plot(found.t, middle, color=COLOUR, linewidth=1.0)
    unit = found.columns[place].printed_unit
    axis.set_ylabel(f"{name}, {unit}" if unit else name).set_parse_math(False)
    axis.grid(alpha=0.3)

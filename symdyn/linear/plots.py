"""Plots of linear systems, as python-control and MATLAB draw them: figures of matplotlib, whose axes one can change.

Bode        a column an input; of each output magnitudes in dB above phases in degrees, over frequency
Nyquist     G(iω), for ω < 0 dashed, with the unit circle and -1
courses     a column an input, a row an output, over time; of a sampled system as stairs
pole map    poles ×, zeros ○, and the edge of stability: the imaginary axis, or the unit circle
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.arguments import check_arguments
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError
from symdyn.shown import Shown
from symdyn.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symdyn.linear.modes import Complexes
    from symdyn.linear.responses import FrequencyResponse, TimeResponse

KINDS = ("svg", "pdf", "png")
"""Kinds of pictures."""

POINTS = 20_000
"""Points of curves that a notebook shows as lines."""

WIDEST, HIGHEST = 6, 6
"""Inputs and outputs of a plot; further ones are left out, and the title says so."""


class Plotted(Shown):
    """An answer that has a plot, and tables beside it."""

    __slots__ = ()

    def _figure(self) -> FilledFigure:
        raise NotImplementedError

    def plot(self) -> Figure:
        """Return the plot, a Figure of matplotlib; its axes can be changed, and `.savefig(...)` writes it."""
        return self._figure().figure(POINTS)

    def picture(self, kind: str) -> bytes:
        """Return the plot as "svg", "pdf" or "png"; the same plot, the same bytes.

        Raises:
            LinearizeError: another kind.
        """
        check_arguments(Plotted.picture, locals(), LinearizeError)
        if kind not in KINDS:
            raise LinearizeError(f"kind = {kind!r}: give one of {', '.join(KINDS)}")
        return self._figure().picture(kind)

    def tables(self) -> Sequence[Table[Any]]:
        """Return the tables that a notebook shows below it."""
        return ()


def pole_map(
    title: str, poles: Mapping[str, Complexes], zeros: Complexes | None = None, period: float | None = None
) -> FilledFigure:
    """Return a map of poles, of one system or several by what they are called, and of zeros."""

    def fill(figure: Any) -> None:
        plane = figure.subplots()
        for k, (name, values) in enumerate(poles.items()):
            plane.plot(values.real, values.imag, "x", color=f"C{k}", label=name or "poles", markersize=7)
        if zeros is not None and len(zeros):
            plane.plot(zeros.real, zeros.imag, "o", color="C0", fillstyle="none", label="zeros", markersize=7)
        plane.axhline(0, color="0.3", linewidth=0.7)
        plane.axvline(0, color="0.3", linewidth=0.7)
        if period is not None:
            _circle(plane)
        unit = "" if period is not None else ", 1/s"
        plane.set_xlabel(f"real part{unit}")
        plane.set_ylabel(f"imaginary part{unit}")
        plane.grid(alpha=0.3)
        plane.legend(frameon=False, fontsize=8)

    return FilledFigure(f"{title}: poles", (5.0, 4.0), fill)


def _circle(plane: Any) -> None:
    turn = np.linspace(0, 2 * np.pi, 181)
    plane.plot(np.cos(turn), np.sin(turn), color="0.5", linewidth=0.7, linestyle="--")
    plane.set_aspect("equal", adjustable="datalim")


def _shown(title: str, outputs: Sequence[str], inputs: Sequence[str]) -> tuple[str, int, int]:
    """Return a title that says what is left out, and how many outputs and inputs are drawn."""
    rows, columns = min(len(outputs), HIGHEST), min(len(inputs), WIDEST)
    left = [
        f"{n - k} {what}" for n, k, what in ((len(outputs), rows, "outputs"), (len(inputs), columns, "inputs")) if n > k
    ]
    return (f"{title} (and {' and '.join(left)} more)" if left else title), rows, columns


def _grid(figure: Any, rows: int, columns: int, inputs: Sequence[str], **words: Any) -> Any:
    """Return axes, shape (rows, columns), a head over each column that says the input."""
    axes = figure.subplots(rows, columns, squeeze=False, **words)
    for k, name in enumerate(inputs[:columns]):
        axes[0, k].set_title(f"from {name}", fontsize=9).set_parse_math(False)
    for one in axes.flat:
        one.grid(alpha=0.3, which="both")
    return axes


def _label(axis: Any, text: str) -> None:
    axis.set_ylabel(text).set_parse_math(False)


def bode(response: FrequencyResponse, hertz: bool) -> FilledFigure:
    """Return the Bode plot of frequency responses."""
    title, rows, columns = _shown(f"{response.name}: frequency response", response.outputs.names, response.inputs.names)
    x = response.hertz if hertz else response.omega

    def fill(figure: Any) -> None:
        axes = _grid(figure, 2 * rows, columns, response.inputs.names, sharex=True)
        for i, k in np.ndindex(rows, columns):
            above, below = axes[2 * i, k], axes[2 * i + 1, k]
            if response.response[:, i, k].any():
                above.semilogx(x, response.decibels[:, i, k], linewidth=1.0)
                below.semilogx(x, response.degrees[:, i, k], linewidth=1.0)
                below.yaxis.set_major_locator(_quarters())
            if not k:
                _label(above, f"to {response.outputs.names[i]}\ndB")
                _label(below, "phase, °")
        for axis in axes[-1]:
            axis.set_xlabel("frequency, Hz" if hertz else "frequency, rad/s")

    return FilledFigure(title, (max(5.0, 1.0 + 3.2 * columns), 1.2 + 3.0 * rows), fill)


def _quarters() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(nbins=5, steps=[1, 1.5, 3, 4.5, 9, 10])


FAR = 20.0
"""How far from 0 a Nyquist plot goes: where a pole is on the axis the curve goes on for ever."""


def nyquist(response: FrequencyResponse) -> FilledFigure:
    """Return the Nyquist plot of frequency responses."""
    title, rows, columns = _shown(f"{response.name}: Nyquist plot", response.outputs.names, response.inputs.names)

    def fill(figure: Any) -> None:
        axes = _grid(figure, rows, columns, response.inputs.names)
        for i, k in np.ndindex(rows, columns):
            plane, G = axes[i, k], response.response[:, i, k]
            seen = G[np.abs(G) <= max(FAR, 3 * float(np.median(np.abs(G))))]
            plane.plot(seen.real, seen.imag, color="C0", linewidth=1.0)
            plane.plot(seen.real, -seen.imag, color="C0", linewidth=1.0, linestyle="--")
            plane.plot([-1], [0], "+", color="C3", markersize=9)
            _circle(plane)
            plane.set_xlabel("real part")
            _label(plane, f"to {response.outputs.names[i]}\nimaginary part" if not k else "")

    return FilledFigure(title, (max(4.6, 1.0 + 3.4 * columns), 0.8 + 3.4 * rows), fill)


def courses(response: TimeResponse) -> FilledFigure:
    """Return the plot of responses over time."""
    title, rows, columns = _shown(
        f"{response.name}: {response.kind} response", response.outputs.names, response.inputs.names
    )

    def fill(figure: Any) -> None:
        axes = _grid(figure, rows, columns, response.inputs.names, sharex=True, sharey="row")
        for i, k in np.ndindex(rows, columns):
            style = "default" if response.period is None else "steps-post"
            axes[i, k].plot(response.t, response.values[:, i, k], linewidth=1.0, drawstyle=style)
            if not k:
                _label(axes[i, k], f"to {response.outputs.names[i]}")
        for axis in axes[-1]:
            axis.set_xlabel("t, s")

    return FilledFigure(title, (max(5.0, 1.0 + 3.2 * columns), 1.0 + 1.9 * rows), fill)

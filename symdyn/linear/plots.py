"""Plots of linear systems, as python-control and MATLAB draw them: figures of matplotlib, whose axes one can change.

Bode        a column an input; of each output magnitudes in dB above phases in degrees, over frequency
Nyquist     G(iω), for ω < 0 dashed, with the unit circle and -1
courses     a column an input, a row an output, over time; of a sampled system as stairs
pole map    poles ×, zeros ○, and the edge of stability: the imaginary axis, or the unit circle
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from symdyn.arguments import checked
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError, hint, quoted, with_own_names
from symdyn.shown import Shown
from symdyn.table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from symdyn.linear.modes import Complexes
    from symdyn.linear.responses import FrequencyResponse, TimeResponse

KINDS = ("svg", "pdf", "png")
"""Kinds of pictures."""

WIDEST, HIGHEST = 6, 6
"""Inputs and outputs of a plot; further ones are left out, and the title says so."""


class Answer(Shown):
    """What a linear system answers: it has a short `repr`, and a notebook shows that and its tables."""

    __slots__ = ()

    def __call__(self, *at: object, **_: object) -> NoReturn:
        """Raise LinearizeError: it is no function."""
        told = hint("attributes", "()", dir(self)).replace("$", quoted(*at[:1] or "s")) or "it is no function"
        raise LinearizeError(f"{type(self).__name__}: {with_own_names(told, self)}")

    def tables(self) -> Sequence[Table[Any]]:
        """Return the tables that a notebook shows."""
        return ()


class Transfers(tuple[Any, ...], Answer):
    """All transfer functions of a system, output by output."""

    __slots__ = ()

    def __repr__(self) -> str:
        lines = (f"\n    {repr(one).removeprefix('<Transfer ')[:-1]}" for one in self)
        return f"<{len(self)} transfer functions:{''.join(lines)}>"

    def __call__(self, *_: object, **__: object) -> NoReturn:
        """Raise LinearizeError: one of them is a function."""
        one = f': .transfer("{self[0].output}", "{self[0].input}")(s)' if self else ", and there is none"
        raise LinearizeError(f"Transfers: one of them is a function{one}")


class Plotted(Answer):
    """An answer that has a plot, which a notebook shows above its tables."""

    __slots__ = ()

    def _figure(self) -> FilledFigure:
        raise NotImplementedError

    def plot(self, axes: Axes | Sequence[Axes] | None = None) -> Figure:
        """Return the plot, a Figure of matplotlib that can be changed; or draw into `axes` as of `Trajectory.plot`."""
        return self._figure().figure(0, axes)

    @checked(LinearizeError)
    def picture(self, kind: str) -> bytes:
        """Return the plot as "svg", "pdf" or "png"; the same plot, the same bytes.

        Raises:
            LinearizeError: another kind.
        """
        if kind not in KINDS:
            raise LinearizeError(f"kind = {kind!r}: give one of {', '.join(KINDS)}")
        return self._figure().picture(kind)


def pole_map(
    title: str,
    poles: Mapping[str, Complexes],
    zeros: Complexes | None = None,
    period: float | None = None,
    branches: Complexes | None = None,
) -> FilledFigure:
    """Return a map of poles by what they are called, of zeros, and of the branches, a column each, of a locus."""

    def fill(figure: Any) -> None:
        plane = figure.subplots()
        if branches is not None:
            size = 2.0 * float(np.abs(np.concatenate([branches[0], np.zeros(1) if zeros is None else zeros])).max())
            plane.plot(branches.real, branches.imag, linewidth=1.0)
            plane.set(xlim=(-size or -1, size or 1), ylim=(-size or -1, size or 1))
        for k, (name, values) in enumerate(poles.items()):
            plane.plot(values.real, values.imag, "x", color=f"C{k}", label=name, markersize=7)
        if zeros is not None and len(zeros):
            plane.plot(zeros.real, zeros.imag, "o", color="C0", fillstyle="none", label="zeros", markersize=7)
        plane.axhline(0, color="0.3", linewidth=0.7)
        plane.axvline(0, color="0.3", linewidth=0.7)
        if period is not None:
            _circle(plane)
        unit = "" if period is not None else ", 1/s"
        plane.set(xlabel=f"real part{unit}", ylabel=f"imaginary part{unit}")
        plane.grid(alpha=0.3)
        plane.legend(frameon=False, fontsize=8)

    return FilledFigure(title, (5.0, 4.2), fill)


def _circle(plane: Any) -> None:
    turn = np.linspace(0, 2 * np.pi, 181)
    plane.plot(np.cos(turn), np.sin(turn), color="0.5", linewidth=0.7, linestyle="--")
    plane.set_aspect("equal", adjustable="datalim")


def _grid(
    response: FrequencyResponse | TimeResponse,
    title: str,
    size: tuple[float, float],
    draw: Callable[[Sequence[Any], int, int], str],
    each: int = 1,
    **words: Any,
) -> FilledFigure:
    """Return a plot with a column an input, which stands above it, and `each` axes below each other an output.

    `draw` draws on the axes of an output and an input, of a `size` in inches, by their places, and returns what stands
    below the lowest; `words` are those of `Figure.subplots`.
    """
    outputs, inputs = response.outputs.names, response.inputs.names
    rows, columns = min(len(outputs), HIGHEST), min(len(inputs), WIDEST)
    if left := len(outputs) * len(inputs) - rows * columns:
        title = f"{title} (and {left} more)"

    def fill(figure: Any) -> None:
        axes = figure.subplots(each * rows, columns, squeeze=False, **words)
        for i, k in np.ndindex(rows, columns):
            own = axes[each * i : each * (i + 1), k]
            below = draw(own, i, k)
            for one in own:
                one.grid(alpha=0.3, which="both")
            if not i:
                own[0].set_title(f"from {inputs[k]}", fontsize=9).set_parse_math(False)
            if not k:
                own[0].set_ylabel(f"to {outputs[i]}\n{own[0].get_ylabel()}".strip()).set_parse_math(False)
            if i == rows - 1:
                own[-1].set_xlabel(below)

    return FilledFigure(f"{response.name}: {title}", (max(5.0, 1.0 + size[0] * columns), 1.0 + size[1] * rows), fill)


def bode(response: FrequencyResponse) -> FilledFigure:
    """Return the Bode plot of frequency responses."""

    def draw(axes: Sequence[Any], i: int, k: int) -> str:
        from matplotlib.ticker import MaxNLocator

        x = response.hertz if response.unit == "Hz" else response.omega
        if response.response[:, i, k].any():
            axes[0].semilogx(x, response.decibels[:, i, k], linewidth=1.0)
            axes[1].semilogx(x, response.degrees[:, i, k], linewidth=1.0)
            axes[1].yaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 1.5, 3, 4.5, 9, 10]))
        axes[0].set_ylabel("magnitude, dB")
        axes[1].set_ylabel("phase, °")
        return f"frequency, {response.unit}"

    return _grid(response, "frequency response", (3.2, 3.0), draw, 2, sharex=True)


FAR = 5.0
"""How far from 0 a Nyquist plot goes at least: where a pole is on the axis the curve goes on for ever."""


def nyquist(response: FrequencyResponse) -> FilledFigure:
    """Return the Nyquist plot of frequency responses."""

    def draw(axes: Sequence[Any], i: int, k: int) -> str:
        G = response.response[:, i, k]
        seen = G[np.abs(G) <= max(FAR, 3 * float(np.quantile(np.abs(G), 0.25)))]
        axes[0].plot(seen.real, seen.imag, color="C0", linewidth=1.0)
        axes[0].plot(seen.real, -seen.imag, color="C0", linewidth=1.0, linestyle="--")
        axes[0].plot([-1], [0], "+", color="C3", markersize=9)
        _circle(axes[0])
        axes[0].set_ylabel("imaginary part")
        return "real part"

    return _grid(response, "Nyquist plot", (3.4, 3.4), draw)


def courses(response: TimeResponse) -> FilledFigure:
    """Return the plot of responses over time."""

    def draw(axes: Sequence[Any], i: int, k: int) -> str:
        style = "default" if response.period is None else "steps-post"
        axes[0].plot(response.t, response.values[:, i, k], linewidth=1.0, drawstyle=style)
        y, w = response.outputs.units[i], response.inputs.units[k]
        axes[0].set_ylabel(f"{y or 1} per {w or 1}{' s' * (response.kind == 'impulse')}")
        return "t, s"

    return _grid(response, f"{response.kind} response", (3.2, 1.9), draw, sharex=True, sharey="row")

"""Frequency responses: G(iω) at given frequencies, as numbers, lines of a table, and a plot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError
from symdyn.linear.linearization import Linearization
from symdyn.linear.locus import numbers
from symdyn.linear.modes import Complexes
from symdyn.table import Table

POINTS = 200
"""Frequencies of a range that nobody gives."""

MOST = 12
"""Curves of a plot; further ones are left out, and the title says so."""


@dataclass(frozen=True)
class Bode:
    """Responses of all outputs to all inputs.

    Attributes:
        hertz: frequencies, Hz, shape (N,).
        inputs, outputs: names, w and y of them.
        response: G(2π i f), shape (N, y, w); infinite where the frequency is that of an undamped mode.
    """

    hertz: Array
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    response: Complexes

    @property
    def decibels(self) -> Array:
        """20 log10 |G|, shape (N, y, w); of units that outputs have over inputs."""
        with np.errstate(divide="ignore"):
            return np.asarray(20 * np.log10(np.abs(self.response)))

    @property
    def degrees(self) -> Array:
        """Phases without jumps along the frequencies, degrees, shape (N, y, w); begins within -180 … 180."""
        whole = np.where(np.isfinite(self.response), self.response, 1.0)
        return np.asarray(np.degrees(np.unwrap(np.angle(whole), axis=0)))

    @property
    def pairs(self) -> list[tuple[str, Array, Array]]:
        """Title, decibels and degrees of each output and input, those that do not follow left out."""
        return [
            (f"{output} / {name}", self.decibels[:, i, k], self.degrees[:, i, k])
            for i, output in enumerate(self.outputs)
            for k, name in enumerate(self.inputs)
            if np.any(self.response[:, i, k])
        ]

    def table(self) -> Table[str | float]:
        """Return a row a frequency: that in Hz, then decibels and degrees of each pair."""
        head = ["frequency_Hz"]
        columns = [self.hertz]
        for title, size, phase in self.pairs:
            head += [f"{title} dB", f"{title} deg"]
            columns += [size, phase]
        return Table(head, np.stack(columns, axis=1).tolist(), range(len(head)))

    def plot(self, title: str, kind: str) -> bytes:
        """Return the plot as "svg", "pdf" or "png": sizes above, phases below."""

        def fill(figure: Any) -> None:
            above, below = figure.subplots(2, 1, sharex=True)
            for name, size, phase in self.pairs[:MOST]:
                above.semilogx(self.hertz, size, label=name, linewidth=1.0)
                below.semilogx(self.hertz, phase, linewidth=1.0)
            more = len(self.pairs) - MOST
            above.set_title("size, dB" + (f" (and {more} more)" if more > 0 else ""), loc="left", fontsize=9)
            below.set_title("phase, degrees", loc="left", fontsize=9)
            above.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)
            for axis in (above, below):
                axis.grid(alpha=0.3, which="both")
            below.yaxis.set_major_locator(_quarters())
            below.set_xlabel("frequency, Hz")

        return FilledFigure(title, (8.0, 5.0), fill).picture(kind)

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON; what is not finite is None."""
        channels = [
            {"of": title, "decibels": _finite(size), "degrees": _finite(phase)} for title, size, phase in self.pairs
        ]
        return {"hertz": self.hertz.tolist(), "channels": channels}


def _finite(values: Array) -> list[float | None]:
    return [float(x) if math.isfinite(x) else None for x in values]


def bode(one: Linearization, hertz: Sequence[float] | Array | str | None = None) -> Bode:
    """Return the frequency responses of a system.

    Args:
        one: the system.
        hertz: frequencies, Hz, above zero, or a range of them, "geomspace(0.1,10,200)"; without it 200, from a decade
            below its slowest mode to one above its fastest.

    Raises:
        LinearizeError: there is no input, or a frequency is none.
    """
    if not one.inputs.names:
        raise LinearizeError(
            f"{one.scene.name}: nothing drives it, and a frequency response is that to an input; declare a drive, or "
            'name an input: --forces "NAME=w"'
        )
    hertz = numbers(hertz, "--hertz") if isinstance(hertz, str) else hertz
    given = _usual(one) if hertz is None else np.asarray(hertz, dtype=np.float64)
    if given.ndim != 1 or not len(given) or not np.isfinite(given).all() or np.any(given <= 0):
        raise LinearizeError("frequencies must be finite and above zero, in Hz")
    found = np.empty((len(given), *one.D.shape), dtype=np.complex128)
    for k, f in enumerate(given):
        pencil = 2j * math.pi * f * np.eye(len(one.A)) - one.A
        try:
            found[k] = one.C @ np.linalg.solve(pencil, one.B.astype(np.complex128)) + one.D
        except np.linalg.LinAlgError:
            found[k] = math.inf
    return Bode(given, one.inputs.names, one.outputs.names, found)


def _usual(one: Linearization) -> Array:
    """Return frequencies from a decade below the slowest mode to a decade above the fastest, Hz."""
    sizes = [abs(mode.value) / (2 * math.pi) for mode in one.modes] or [1.0]
    return np.asarray(np.geomspace(min(sizes) / 10, max(sizes) * 10, POINTS))


def _quarters() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(nbins=7, steps=[1, 1.5, 3, 4.5, 9, 10])

"""Families of periodic motions: what a coordinate does is a row of functions of time times coefficients.

    q = Φ(t) z,  q̇ = Φ̇(t) z,  q̈ = Φ̈(t) z           Φ: one constant, then functions that rest at t = 0 and T

Every family is cut down to the motions whose velocity and acceleration vanish where a period begins, so that a drive
starts and ends at rest; a log of several periods can be averaged over them.

Reference: Swevers, Ganseman, Tükel, De Schutter and Van Brussel, Optimal robot excitation and identification (1997),
for Fourier series.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array

DEGREE = 5
"""Of the splines: accelerations are cubic, their second rates continuous."""


@dataclass(frozen=True)
class Basis:
    """A row of functions of time at N times, shape (N, k) each.

    Attributes:
        position: values; the first column is 1, no other has a size far from 1.
        rate: first derivatives, 1/s.
        second: second derivatives, 1/s^2.
    """

    position: Array
    rate: Array
    second: Array

    @property
    def count(self) -> int:
        """How many functions there are."""
        return int(self.position.shape[1])


@dataclass(frozen=True)
class Family:
    """A family of periodic motions.

    Attributes:
        text: what it is, one line.
        least: fewest terms with which anything moves.
        functions: (times in periods, terms) to values, first and second derivatives by that time, shape (N, k) each,
            the constant left out.
    """

    text: str
    least: int
    functions: Callable[[Array, int], tuple[Array, Array, Array]]

    def basis(self, t: Array, period: float, terms: int) -> Basis:
        """Return the functions at times (N,), s, those that do not rest where a period begins left out."""
        from scipy.linalg import null_space

        _, rate, second = self.functions(np.zeros(1), terms)
        rest = np.vstack([rate, second])
        resting = null_space(rest / np.abs(rest).max(axis=1, keepdims=True))
        resting = resting * np.sign(resting[np.abs(resting).argmax(axis=0), np.arange(resting.shape[1])])
        x, v, a = (part @ resting for part in self.functions(np.asarray(t) / period, terms))
        none = np.zeros((len(x), 1))
        return Basis(np.hstack([none + 1, x]), np.hstack([none, v]) / period, np.hstack([none, a]) / period**2)


def _fourier(phase: Array, terms: int) -> tuple[Array, Array, Array]:
    """Return sines and cosines of 1 to `terms` rounds a period, the l-th over l."""
    order = np.arange(1, terms + 1)
    pace = 2 * np.pi * order
    angle = phase[:, None] * pace
    sine, cosine = np.sin(angle) / order, np.cos(angle) / order
    return (
        np.hstack([sine, cosine]),
        np.hstack([cosine * pace, -sine * pace]),
        -np.hstack([sine * pace**2, cosine * pace**2]),
    )


def _splines(phase: Array, terms: int) -> tuple[Array, Array, Array]:
    """Return periodic B-splines of degree 5 on 2 terms + 1 equal intervals; together they are 1, so one is left out."""
    from scipy.interpolate import BSpline

    intervals = 2 * terms + 1
    knots = np.arange(-DEGREE, intervals + DEGREE + 1) / intervals
    wrapped = np.vstack([np.eye(intervals), np.eye(intervals)[:DEGREE]])
    curve = BSpline(knots, wrapped, DEGREE)
    inside = phase % 1.0
    x, v, a = (np.asarray(curve(inside, nu=order), dtype=np.float64)[:, 1:] for order in range(3))
    return x, v, a


FAMILIES: Mapping[str, Family] = {
    "fourier": Family("Fourier series: sines and cosines of whole rounds a period", 2, _fourier),
    "splines": Family("periodic splines of degree 5, twice as many intervals as terms and one", 2, _splines),
}

"""Transfer functions G(s) = C (s - A)⁻¹ B + D, frequency responses G(iω), which modes inputs move and outputs show.

There is one an input and output; responses are numbers, lines of a table, and a plot.

    G_ik(s) = g Π(s - z) / Π(s - p)        on the states that input k reaches and output i shows

Zeros are where the rank of [A - s, B; C, D] falls; its infinite ones are taken out first, by compressions of rows and
columns, so that what is left is an eigenvalue problem.

What inputs reach is found by a staircase for the ranks, and the test of Popov, Belevitch and Hautus:

    V, W     orthonormal: [V W]ᵀ A [V W] = [A_v *; 0 A_w], [V W]ᵀ B = [B_v; 0]; what B reaches, and what is left
    σ(λ)     the smallest singular value of [A_v - λ, B_v]: how far the mode of λ is from one that no input moves

States have different units: A is balanced, D⁻¹ A D, and B and C are scaled to the size of A, before sizes are compared.
Of observability all is the same with Aᵀ and Cᵀ.

References: Emami-Naeini and Van Dooren, Computation of zeros of linear multivariable systems, Automatica 18 (1982); Van
Dooren, The generalized eigenstructure problem in linear system theory, IEEE Trans. Aut. Control 26 (1981); Eising,
Between controllable and uncontrollable, Systems & Control Letters 4 (1984), for σ.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError
from symdyn.linear.locus import numbers
from symdyn.linear.modes import Complexes, balance, pairs_of, spectrum
from symdyn.rounding import in_digits
from symdyn.table import Table

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization

SAID, NAMED = 0.1, 4
"""Parts of a mode, of the largest, that are named, and how many at most."""


@dataclass(frozen=True)
class Mark:
    """How far the mode of an eigenvalue is from being hidden.

    Attributes:
        value: eigenvalue, 1/s.
        margin: σ(λ) over the size of A, on what is reached; 0 of a mode that is hidden.
        states: names of the states that take part most in what no input moves, or no output shows.
    """

    value: complex
    margin: float
    states: tuple[str, ...]

    @property
    def hidden(self) -> bool:
        """Whether no input moves it, or no output shows it."""
        return self.margin == 0.0


@dataclass(frozen=True)
class Reach:
    """What all inputs together move, or all outputs together show.

    Attributes:
        rank: of how many states.
        order: how many states there are.
        marks: one an eigenvalue, those that are zero as one, nearest to hidden first.
    """

    rank: int
    order: int
    marks: tuple[Mark, ...]

    @property
    def margin(self) -> float:
        """How far the rank is from being less: the least margin of what is not hidden; 0 of a rank of zero."""
        return min((one.margin for one in self.marks if not one.hidden), default=0.0)

    @property
    def hidden(self) -> tuple[Mark, ...]:
        """Modes that no input moves, or no output shows."""
        return tuple(one for one in self.marks if one.hidden)

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON."""
        marks = [
            {"eigenvalue": pairs_of([m.value])[0], "margin": m.margin, "hidden": m.hidden, "states": list(m.states)}
            for m in self.marks
        ]
        return {"rank": self.rank, "order": self.order, "margin": self.margin, "modes": marks}


def controllability(one: Linearization) -> Reach:
    """Return what the inputs move."""
    A, B, _, _ = balanced(one)
    return _reach(A, B, one.states.names)


def observability(one: Linearization) -> Reach:
    """Return what the outputs show."""
    A, _, C, _ = balanced(one)
    return _reach(A.T, C.T, one.states.names)


def _reach(A: Array, B: Array, names: tuple[str, ...]) -> Reach:
    size, B = float(np.linalg.norm(A, 2)) or 1.0, alike(A, B)
    V, W = staircase(A, B)
    marks = [Mark(value, 0.0, states) for value, _, states in _least(A, B[:, :0], W, names, size)]
    marks += [Mark(*one) for one in _least(A, B, V, names, size)]
    return Reach(V.shape[1], len(A), tuple(sorted(marks, key=lambda mark: mark.margin)))


def _least(
    A: Array, B: Array, space: Array, names: tuple[str, ...], size: float
) -> list[tuple[complex, float, tuple[str, ...]]]:
    """Return the eigenvalues in a space, σ of [A - λ, B] there over the size of A, and who takes part in it most."""
    part, way = space.T @ A @ space, space.T @ B
    found = spectrum(part, size)
    told = []
    for value in [*(mode.value for mode in found.modes), *([0j] if found.zeros else [])]:
        rows, sizes, _ = np.linalg.svd(np.hstack([part - value * np.eye(len(part)), way]))
        many = max(1, int(np.sum(sizes <= NOTHING * size)))
        share = np.linalg.norm(space @ rows[:, -many:], axis=1)
        most = [k for k in np.argsort(-share, kind="stable") if share[k] > SAID * share.max()]
        told.append((value, float(sizes[-1]) / size, tuple(names[k] for k in most[:NAMED])))
    return told


def balanced(one: Linearization) -> tuple[Array, Array, Array, Array]:
    """Return D⁻¹ A D, D⁻¹ B, C D and the diagonal of D."""
    scale = balance(one.A)
    return one.A * scale[None, :] / scale[:, None], one.B / scale[:, None], one.C * scale[None, :], scale


def alike(A: Array, B: Array) -> Array:
    """Return B with columns as long as A is large, those that are zero left out of it."""
    lengths = np.linalg.norm(B, axis=0)
    return np.asarray(B * ((float(np.linalg.norm(A, 2)) or 1.0) / np.where(lengths > 0, lengths, 1.0)))


def staircase(A: Array, B: Array) -> tuple[Array, Array]:
    """Return V, shape (n, rank), and W: what B reaches of balanced states, and what is beside it."""
    size = float(np.linalg.norm(A, 2)) or 1.0
    n, V, step = len(A), np.zeros((len(A), 0)), alike(A, B)
    while V.shape[1] < n and step.shape[1]:
        step = step - V @ (V.T @ step)
        rows, sizes, _ = np.linalg.svd(step, full_matrices=False)
        fresh = rows[:, sizes > NOTHING * size]
        fresh = fresh - V @ (V.T @ fresh)
        fresh = np.linalg.qr(fresh)[0] if fresh.shape[1] else fresh
        V, step = np.hstack([V, fresh]), A @ fresh
    W = np.linalg.svd(V, full_matrices=True)[0][:, V.shape[1] :] if V.shape[1] else np.eye(n)
    return V, W


def minimal(A: Array, B: Array, C: Array) -> tuple[Array, Array, Array]:
    """Return A, B, C on the states that B reaches and C shows; all of balanced states."""
    V, _ = staircase(A, B)
    A, B, C = V.T @ A @ V, V.T @ B, C @ V
    V, _ = staircase(A.T, C.T)
    return V.T @ A @ V, V.T @ B, C @ V


def shown(value: complex) -> str:
    """Return an eigenvalue, pole or zero as text: a pair once."""
    x, y = float(value.real), float(value.imag)
    if y == 0:
        return in_digits(x, 6)
    return f"{in_digits(x, 6)} ± {in_digits(abs(y), 6)}i" if abs(x) > NOTHING * abs(y) else f"±{in_digits(abs(y), 6)}i"


NOTHING = 1e-9
"""Singular values over the size of what is balanced, a system or A, that are zero."""


@dataclass(frozen=True)
class Transfer:
    """How one output follows one input.

    Attributes:
        output, input: their names.
        zeros, poles: 1/s, pairs in full; poles of modes that the input does not move or the output not show are none.
        gain: g, the ratio of the leading coefficients; 0 where the output does not follow at all.
    """

    output: str
    input: str
    zeros: Complexes
    poles: Complexes
    gain: float

    @property
    def numerator(self) -> Array:
        """Coefficients, highest power of s first."""
        return self.gain * np.atleast_1d(np.real(np.poly(self.zeros)))

    @property
    def denominator(self) -> Array:
        """Coefficients, highest power of s first, which has 1."""
        return np.atleast_1d(np.real(np.poly(self.poles)))

    def at(self, s: complex) -> complex:
        """Return G(s)."""
        return complex(self.gain * np.prod(s - self.zeros) / np.prod(s - self.poles))

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "output": self.output, "input": self.input, "gain": self.gain, "zeros": pairs_of(self.zeros),
            "poles": pairs_of(self.poles), "numerator": self.numerator.tolist(),
            "denominator": self.denominator.tolist(),
        }  # fmt: skip


def transfers(one: Linearization) -> tuple[Transfer, ...]:
    """Return all transfer functions, output by output."""
    A, B, C, _ = balanced(one)
    return tuple(
        _transfer(output, name, A, B[:, [k]], C[[i]], one.D[[i]][:, [k]])
        for i, output in enumerate(one.outputs.names)
        for k, name in enumerate(one.inputs.names)
    )


def _transfer(output: str, name: str, A: Array, b: Array, c: Array, d: Array) -> Transfer:
    size = float(np.linalg.norm(A, 2))
    A, b, c = minimal(A, b, c)
    found = zeros(A, b, c, d, size)
    gain, markov = float(d[0, 0]), b
    for _ in range(len(A) - len(found)):
        gain, markov = float((c @ markov)[0, 0]), A @ markov
    return Transfer(output, name, found, eigenvalues(A, size), gain)


def eigenvalues(A: Array, size: float) -> Complexes:
    """Return all eigenvalues of a matrix, pairs in full, those that grow first; zero beside `size` is zero."""
    found = spectrum(A, size)
    values: list[complex] = []
    for mode in found.modes:
        values += [mode.value, mode.value.conjugate()] if mode.oscillates else [mode.value]
    return np.array([*values, *[0j] * found.zeros], dtype=np.complex128)


def zeros(A: Array, B: Array, C: Array, D: Array, size: float) -> Complexes:
    """Return the invariant zeros of a system of balanced states, 1/s: where inputs move states and outputs rest.

    Of several inputs and outputs those of all together; none where the outputs can follow everything. `size` is that of
    a whole of which the system is a part.
    """
    unit = size or 1.0
    ins, outs = (unit / (float(np.linalg.norm(one, 2)) if one.any() else unit) for one in (B, C))
    a, b, c, d = _compressed(A, B * ins, C * outs, D * (ins * outs), NOTHING * unit)
    a, c, b, d = (one.T for one in _compressed(a.T, c.T, b.T, d.T, NOTHING * unit))
    if not len(a):
        return np.zeros(0, dtype=np.complex128)
    turn = np.linalg.svd(np.hstack([c, d]))[2][len(c) :].T if len(c) else np.eye(len(a))
    return eigenvalues(np.linalg.solve(turn[: len(a)], np.hstack([a, b]) @ turn), size)


def _compressed(A: Array, B: Array, C: Array, D: Array, nothing: float) -> tuple[Array, Array, Array, Array]:
    """Return a system with the same finite zeros, whose D has full row rank."""
    while True:
        rows, sizes, _ = np.linalg.svd(D) if D.size else (np.eye(len(D)), np.zeros(0), None)
        rank = int(np.sum(sizes > nothing))
        through, lower = (rows.T @ D)[:rank], rows.T @ C
        upper, rest = lower[:rank], lower[rank:]
        if not len(rest) or not len(A):
            return A, B, upper, through
        _, sizes, across = np.linalg.svd(rest)
        seen = int(np.sum(sizes > nothing))
        if not seen:
            return A, B, upper, through
        turn = np.vstack([across[seen:], across[:seen]]).T
        A, B, upper = turn.T @ A @ turn, turn.T @ B, upper @ turn
        keep = len(A) - seen
        C, D = np.vstack([upper[:, :keep], A[keep:, :keep]]), np.vstack([through, B[keep:]])
        A, B = A[:keep, :keep], B[:keep]


POINTS = 200
"""Frequencies of a range that nobody gives."""

MOST_CURVES = 12
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
            for name, size, phase in self.pairs[:MOST_CURVES]:
                above.semilogx(self.hertz, size, label=name, linewidth=1.0)
                below.semilogx(self.hertz, phase, linewidth=1.0)
            more = len(self.pairs) - MOST_CURVES
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

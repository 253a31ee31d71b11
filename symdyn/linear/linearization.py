"""The noun of this package: how a mechanism moves next to an operating point, to first order.

    ẋ = A x + B w        x, w, y     deviations of states, inputs and outputs from the point
    y = C x + D w        p, m        independent positions (of rows that hold positions), velocities (of all rows)

x is p positions ξ, then m velocities u. A position is a coordinate's deviation, or, where a velocity is no rate of a
coordinate (quaternions), a displacement along that velocity: q moves to q ∘ exp(Σ ξ_k X_k). With rolling p > m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import native, walked
from symdyn.errors import LinearizeError
from symdyn.extras import install
from symdyn.linear.axis import Axis
from symdyn.linear.modes import Mode, Spectrum, spectrum
from symdyn.linear.zeros import zeros
from symdyn.scene import Scene
from symdyn.scene.values import listed
from symdyn.shown import Shown
from symdyn.table import Table
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.linear.reach import Reach
    from symdyn.linear.transfer import Transfer
    from symdyn.linear.verdict import Stability

Kind = Literal["rest", "steady", "moving"]


@dataclass(frozen=True)
class Point:
    """An operating point.

    Attributes:
        t: time, s, of what depends on it.
        q: coordinates, shape (nq,); rad, m or 1.
        u: velocities, shape (nv,).
        udot: their rates, shape (nv,).
        tau: driving forces, shape (nv,).
        multipliers: of the kept rows, then of prescribed motions, N and N m.
        inputs: of the scene, in its order.
    """

    t: float
    q: Array
    u: Array
    udot: Array
    tau: Array
    multipliers: Array
    inputs: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, eq=False)
class Linearization(Shown):
    """A mechanism next to an operating point.

    Attributes:
        scene: the mechanism, its parameters bound.
        point: where.
        states, inputs, outputs: what x, w and y are.
        A, B, C, D: shapes (nx, nx), (nx, nw), (ny, nx), (ny, nw).
        positions: p, how many states are positions; the others are velocities.
        moves: how all coordinates move with the positions, shape (nq, p): δq = moves ξ.
        directions: how all displacements along velocities do, shape (nv, p).
        rates: how all velocities move with the states, shape (nv, nx).
        kind: whether x = 0 is an equilibrium ("rest"), a motion along which A is constant ("steady") or neither.
        dropped: cyclic positions of a steady motion that are no states, as nothing depends on them.
        cyclic: positions that can be anywhere: equilibria, or motions, are the same there; one eigenvalue zero each.
        family: how many more directions lead to other equilibria next to this one.
        feeding: forces, then inputs, at the point where formulas of these depend on the state: part of A, and not of
            what gains have to give; () where forces are constant.
        notes: what a user should know.
        spin: Ω, shape (nv, nv), rad/s, of the axes in which states and drives along axes of a body are; the body spins
            in them (`spinning`); empty where they are its own.
    """

    scene: Scene
    point: Point
    states: Axis
    inputs: Axis
    outputs: Axis
    A: Array
    B: Array
    C: Array
    D: Array
    positions: int
    moves: Array = field(repr=False)
    directions: Array = field(repr=False)
    rates: Array = field(repr=False)
    kind: Kind = "rest"
    dropped: tuple[str, ...] = ()
    cyclic: tuple[str, ...] = ()
    family: int = 0
    feeding: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()
    spin: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)

    def __repr__(self) -> str:
        where = {"rest": "at rest", "steady": "in steady motion", "moving": "in motion"}[self.kind]
        axes = (("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs))
        told = "".join(f"\n    {len(axis)} {name}: {listed(axis.names)}" for name, axis in axes)
        return f"<Linearization of {self.scene.name} {where}:{told}>"

    def without(self, positions: Sequence[int], moving: Sequence[int] | None = None) -> Linearization:
        """Return the system without some positions on which nothing depends, and without outputs `moving` with them.

        Outputs not given are those that depend on the positions here.

        Raises:
            LinearizeError: what is no place of a position.
        """
        given = ("positions",) if moving is None else ("positions", "moving")
        positions, *told = (
            native(int, *one) for one in walked(Linearization.without, locals(), *given, error=LinearizeError)
        )
        if strange := [k for k in positions if not 0 <= k < self.positions]:
            raise LinearizeError(f"positions: there is no {strange[0]}; give some of 0 to {self.positions - 1}")
        states = [k for k in range(len(self.states)) if k not in positions]
        if told:
            (moving,) = told
        else:
            moving = np.flatnonzero(self.C[:, list(positions)].any(axis=1)).tolist()
        outputs = [k for k in range(len(self.outputs)) if k not in moving]
        p = [k for k in range(self.positions) if k not in positions]
        return replace(
            self, states=self.states.of(states), outputs=self.outputs.of(outputs), A=self.A[np.ix_(states, states)],
            B=self.B[states], C=self.C[np.ix_(outputs, states)], D=self.D[outputs], positions=len(p),
            moves=self.moves[:, p], directions=self.directions[:, p], rates=self.rates[:, states],
            dropped=(*self.dropped, *(self.states.names[k] for k in positions)),
        )  # fmt: skip

    @cached_property
    def spectrum(self) -> Spectrum:
        """Eigenvalues of A, zeros apart."""
        return spectrum(self.A)

    @property
    def modes(self) -> tuple[Mode, ...]:
        """Modes of eigenvalues that are not zero, those that grow fastest first; of the others tell `zeros`."""
        return self.spectrum.modes

    @property
    def zeros(self) -> dict[str, int]:
        """How many eigenvalues are zero, by what they come from: "cyclic" positions, "drifting" momenta, ..."""
        cyclic = [k for k in range(self.positions) if self.states.names[k] in self.cyclic]
        return zeros(self.A, self.spectrum.zeros, self.positions, cyclic, self.family, self.kind)

    @cached_property
    def eigenvalues(self) -> np.ndarray[Any, np.dtype[np.complex128]]:
        """All eigenvalues, 1/s, shape (nx,), zeros last."""
        found: list[complex] = []
        for mode in self.modes:
            found += [mode.value, mode.value.conjugate()] if mode.oscillates else [mode.value]
        return np.array([*found, *[0j] * self.spectrum.zeros])

    @cached_property
    def stability(self) -> Stability:
        """What the eigenvalues say."""
        from symdyn.linear.verdict import stability

        return stability(self)

    @property
    def manner(self) -> str:
        """In words, how it moves at the point."""
        return {"rest": "at rest", "steady": "along a steady motion", "moving": "at an instant of a motion"}[self.kind]

    @property
    def place(self) -> str:
        """The point in words: coordinates, velocities that are not zero, forces that are not."""
        from symdyn.linear.report import where

        return where(self)

    def mode_table(self) -> Table[str | float]:
        """Return a row a mode: eigenvalue, 1/s, frequency, Hz, damping ratio, and what moves."""
        from symdyn.linear.report import HEAD, eigenvalue, shape

        rows = [(eigenvalue(one, self), one.frequency, one.damping, shape(one, self)) for one in self.modes]
        return Table(HEAD, rows, (1, 2), "modes")

    def latex(self) -> str:
        """Return the system in LaTeX, in numbers."""
        from symdyn.linear.report import latex

        return latex(self)

    def transfers(self) -> tuple[Transfer, ...]:
        """Return all transfer functions, output by output."""
        from symdyn.linear.transfer import transfers

        return transfers(self)

    def controllability(self) -> Reach:
        """Return what the inputs move."""
        from symdyn.linear.reach import controllability

        return controllability(self)

    def observability(self) -> Reach:
        """Return what the outputs show."""
        from symdyn.linear.reach import observability

        return observability(self)

    def control(self) -> Any:
        """Return it as a StateSpace of python-control, names included.

        Raises:
            LinearizeError: python-control is not installed.
        """
        try:
            from control import ss
        except ImportError:
            raise LinearizeError(f"python-control is not installed; {install('control')}") from None
        names = {"states": list(self.states.names), "outputs": list(self.outputs.names)}
        if len(self.inputs):
            return ss(self.A, self.B, self.C, self.D, inputs=list(self.inputs.names), **names)
        n = len(self.A)  # python-control knows no system without inputs: one that does nothing
        return ss(self.A, np.zeros((n, 1)), self.C, np.zeros((len(self.C), 1)), inputs=["none"], **names)

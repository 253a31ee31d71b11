"""Linear systems: a mechanism about an operating point, to first order, and the stability that eigenvalues show.

    ẋ = A x + B w        x, w, y     deviations of states, inputs and outputs from the point
    y = C x + D w        p, m        independent positions (by constraints on them), velocities (by all)

x is p positions ξ, then m velocities u. A position is a coordinate's deviation, or, where a velocity is no rate of a
coordinate (quaternions), a displacement along that velocity: q moves to q ∘ exp(Σ ξ_k X_k). With rolling p > m.

Eigenvalues that are zero are no modes and no sign of instability. They are counted apart, by what they come from:

    cyclic       positions on which no rate depends
    rolling      at rest, as many as there are more positions than velocities: it stays where it is put
    drifting     velocities that no rate of a velocity depends on, once cyclic positions are left out: conserved momenta
    family       other states that A maps to nothing: equilibria, or steady motions, close to this one
    undecided    the rest: of these the linear motion tells nothing
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NoReturn

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import checked, native, walked
from symdyn.errors import LinearizeError, listed
from symdyn.frozen import dataclass, field, replace
from symdyn.linear.compensator import Compensator, Observer, kalman
from symdyn.linear.evolution import STILL
from symdyn.linear.modes import NOTHING
from symdyn.linear.regulator import Regulator, lqr, place
from symdyn.linear.stability import Stability, stability, zero_kinds
from symdyn.linear.state_space import StateSpace
from symdyn.linear.weights import Weights, places
from symdyn.scene import Scene
from symdyn.scene.values import split_commas
from symdyn.simulation.prescribed import timed
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.linear.formulas import Formulas
    from symdyn.linear.prepared import Prepared


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Ahead(StateSpace):
    """A linear system some outputs of which follow rates of inputs at once: y = C x + D w + D₁ ẇ + D₂ ẅ."""

    rates: Array  # D₁ and D₂, shape (2, ny, nw)

    def __init__(self, plain: StateSpace, rates: Array) -> None:
        """Take a system and what stands beside its D."""
        self.__dict__.update(vars(plain), rates=rates)

    def __getitem__(self, channel: tuple[str | None, str | None]) -> Ahead:
        """Return the system to one output from one input; errors as of any."""
        i, k = places(self.outputs, self.inputs, channel)
        return Ahead(super().__getitem__(channel), self.rates[:, [i]][:, :, [k]])

    def through(self, s: complex) -> npt.NDArray[np.complex128]:
        """Return D + s D₁ + s² D₂."""
        return np.asarray(self.D + s * self.rates[0] + s * s * self.rates[1])


def of_given(one: StateSpace, rates: Mapping[str, str]) -> Ahead:
    """Return a system whose inputs are those that are given alone; `rates` names the rate of what has one.

        ẋ = A x + B₀ w + B₁ ẇ + B₂ ẅ,  x = z + (B₁ + A B₂) w + B₂ ẇ:  ż = A z + (B₀ + A B₁ + A² B₂) w

    The states are z, and y follows with ẇ and ẅ as far as D₁ + C B₂ and D₂ are not zero.
    """
    names = one.inputs.names
    given = [k for k, name in enumerate(names) if name not in rates.values()]
    B, D = (np.zeros((3, len(rows), len(given))) for rows in (one.A, one.C))
    for column, k in enumerate(given):
        name: str | None = names[k]
        for order in range(3):
            if name in names:
                B[order, :, column], D[order, :, column] = (x[:, names.index(name)] for x in (one.B, one.D))
            name = rates.get(name) if name else None
    moved = B[1] + one.A @ B[2]
    ahead = np.stack([D[1] + one.C @ B[2], D[2]])
    ahead[np.abs(ahead) <= NOTHING * np.abs(D[1:]).max(initial=0.0)] = 0.0
    plain = StateSpace(
        one.A, B[0] + one.A @ moved, one.C, D[0] + one.C @ moved, one.states, one.inputs.of(given), one.outputs,
        one.period, one.name,
    )  # fmt: skip
    return Ahead(plain, ahead)


Kind = Literal["rest", "steady", "moving"]


@dataclass(frozen=True)
class Point:
    """An operating point.

    Attributes:
        t: time, s, of what depends on it.
        q: coordinates, shape (nq,); rad, m or 1.
        u: velocities, and then states of one's own, shape (nu,).
        udot: their rates, shape (nu,).
        tau: driving forces, shape (nv,).
        multipliers: of the independent rows, then of prescribed motions, N and N m.
        inputs: of the scene, in its order.
        outputs: y there, shape (ny,).
    """

    t: float
    q: Array
    u: Array
    udot: Array
    tau: Array
    multipliers: Array
    inputs: Array = field(default_factory=lambda: np.zeros(0))
    outputs: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, eq=False)
class Linearization(StateSpace):
    """A mechanism about an operating point: a `StateSpace` named after its scene, without a period.

    Attributes:
        scene: the mechanism, its parameters bound.
        point: where.
        positions: p, how many states are positions; the others are velocities.
        moves: how all coordinates move with the positions, shape (nq, p): δq = moves ξ.
        directions: how all displacements along velocities do, shape (nv, p).
        rates: how all velocities move with the states, shape (nv, nx).
        kind: whether x = 0 is an equilibrium ("rest"), a motion along which A is constant ("steady") or neither.
        dropped: cyclic positions of a steady motion that are no states, as nothing depends on them.
        cyclic: positions that can be anywhere: equilibria, or motions, are the same there; one eigenvalue zero each.
        family: how many more directions lead to other equilibria close to this one.
        feeding: forces, then inputs, at the point where formulas of these depend on the state: part of A, and not of
            what gains have to give; () where forces are constant.
        notes: what a user should know.
        spin: Ω, shape (nv, nv), rad/s, of the axes in which states and drives along axes of a body are; the body spins
            in them (`spinning`); empty where they are its own.
        prepared: what was linearised.
    """

    scene: Scene
    point: Point
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
    prepared: Prepared | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        where = {"rest": "at rest", "steady": "in steady motion", "moving": "in motion"}[self.kind]
        axes = (("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs))
        told = "".join(f"\n    {len(axis)} {name}: {listed(axis.names)}" for name, axis in axes)
        return f"<Linearization of {self.scene.name} {where}:{told}>"

    @cached_property
    def of_given(self) -> Ahead:
        """The same of inputs that are given alone: an input with rates moves by them, too, B0 + s B1 + s^2 B2."""
        return of_given(self, self.scene.rates)

    @checked(LinearizeError)
    def __getitem__(self, channel: tuple[str | None, str | None]) -> StateSpace:
        """Return the system to one output from one input, which moves by its rates, too; errors as of any system."""
        plain = not self.scene.rates or channel[1] in self.scene.rates.values()
        return super().__getitem__(channel) if plain else self._chosen(*channel)

    def _chosen(self, output: str | None, input: str | None, ahead: bool = False) -> StateSpace:
        if not self.scene.rates or input in self.scene.rates.values():
            return super()._chosen(output, input)
        found = self.of_given if output is None and input is None else self.of_given[output, input]
        if not ahead and found.rates.any():
            (_, i, k), plain = np.argwhere(found.rates)[0], np.argwhere(~found.rates.any(axis=0))
            y, w = found.outputs.names, found.inputs.names
            told = f"{self.name}: {y[i]} follows a rate of {w[k]} at once"
            other = next((f'lin["{y[i]}", "{w[k]}"]' for i, k in plain), "another output")
            raise LinearizeError(f"{told}, which only bode and nyquist can tell; ask for these, or for {other}")
        if ahead:
            return found
        axes = (found.states, found.inputs, found.outputs)
        return StateSpace(found.A, found.B, found.C, found.D, *axes, found.period, found.name)

    def to_control(self) -> Any:
        """Return it of inputs that are given alone, states beside one with rates being z; errors as of `step`."""
        return StateSpace.to_control(self._chosen(None, None))

    @timed(LinearizeError)
    def discretize(self, dt: float) -> StateSpace:
        """Return it from sample to sample, inputs, those of `to_control`, held for `dt` s; errors as there."""
        return StateSpace.discretize(self._chosen(None, None), dt)

    @property
    def velocities(self) -> list[int]:
        """Numbers of the independent velocities, and of states of one's own behind all velocities."""
        return [self.scene.first_order.index(name) for name in self.states.names[self.positions :]]

    @property
    def still(self) -> bool:
        """Whether nothing moves at the point; states of one's own may change."""
        return bool(np.abs(self.point.u[: len(self.scene.velocities)]).max(initial=0.0) <= STILL)

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
            self, point=replace(self.point, outputs=self.point.outputs[outputs]), states=self.states.of(states),
            outputs=self.outputs.of(outputs), A=self.A[np.ix_(states, states)], B=self.B[states],
            C=self.C[np.ix_(outputs, states)], D=self.D[outputs], positions=len(p), moves=self.moves[:, p],
            directions=self.directions[:, p], rates=self.rates[:, states],
            dropped=(*self.dropped, *(self.states.names[k] for k in positions)),
        )  # fmt: skip

    @property
    def zero_eigenvalues(self) -> dict[str, int]:
        """How many eigenvalues are zero, by what they come from: "cyclic" positions, "drifting" momenta, ..."""
        cyclic = [k for k in range(self.positions) if self.states.names[k] in self.cyclic]
        return zero_kinds(self.A, self.spectrum.zeros, self.positions, cyclic, self.family, self.kind)

    @cached_property
    def stability(self) -> Stability:
        """What the eigenvalues say."""
        return stability(self)

    @cached_property
    def formulas(self) -> Formulas:
        """A, B, C, D as SymPy matrices in parameters, worked out when they are first asked for.

        >>> import symdyn
        >>> pendulum = symdyn.linearize(symdyn.example("pendulum"))
        >>> pendulum.formulas.A[1, :]
        Matrix([[-g/l, -b/(l**2*m)]])

        Raises:
            LinearizeError: the system does not come from a scene's equations.
        """
        from symdyn.linear.formulas import formulas

        return formulas(self)

    @property
    def manner(self) -> str:
        """In words, how it moves at the point."""
        return {"rest": "at rest", "steady": "along a steady motion", "moving": "at an instant of a motion"}[self.kind]

    @property
    def where(self) -> str:
        """The point in words: coordinates, velocities that are not zero, forces that are not."""
        from symdyn.linear.report import where_in_words

        return where_in_words(self)

    def latex(self) -> str:
        """Return the system in LaTeX, in numbers."""
        from symdyn.linear.report import latex

        return latex(self)

    def feedback(self, *others: object) -> NoReturn:
        """Raise LinearizeError: this is what is controlled, and no controller."""
        where = "others" if others else "feedback"
        raise LinearizeError(
            f"{where}: {self.scene.name} is the mechanism, and no controller; give lin.lqr(Q, R) or lin.lqg(...), "
            "which have a .closed_loop; gains K act by symdyn.simulate(scene, feedback=K)"
        )

    @timed(LinearizeError)
    def lqr(
        self,
        Q: Weights | None = None,
        R: Weights | None = None,
        period: float | None = None,
        *,
        N: Mapping[str, float] | Sequence[Sequence[float]] | Array | None = None,
        integral: str | Sequence[str] = (),
    ) -> Regulator:
        """Return the linear quadratic regulator, u = u0 - K (x - x0).

        >>> import symdyn
        >>> cart = symdyn.linearize(symdyn.example("cart_pole"))
        >>> K, S, E = cart.lqr({"x": 1, "theta": 10, "x_integral": 1}, {"F": 0.1}, integral="x")
        >>> K.shape, S.shape, len(E)
        ((1, 5), (5, 5), 5)

        Args:
            Q: weights of states by name, others 0, or a matrix, shape (nx, nx), positive semidefinite, its diagonal,
                or a number for all; 1 each without.
            R: of drives likewise, positive definite, others 1; other inputs are no controls where there are drives.
            period: seconds between samples, for gains of a sampled controller.
            N: weights of states times drives, shape (nx, drives), or by name, {"x*F": 0.1}, others 0: 2 xᵀ N u is added
                to what is paid; not of a sampled controller.
            integral: outputs, or states, that come to their references exactly, whatever pushes: states `NAME_integral`
                stand behind the others in Q, K and S.

        Raises:
            LinearizeError: with every fault: a name that is not known, a weight that is none; a mode that is weighed,
                does not decay, and that no input moves.
        """
        some = split_commas(integral) if isinstance(integral, str) else integral
        return lqr(self, Q, R, native(float, period)[0], N, some)

    @timed(LinearizeError)
    def place(self, poles: Sequence[complex] | Array, period: float | None = None) -> Regulator:
        """Return the feedback u = u0 - K (x - x0) that gives the closed loop its poles, 1/s, one a state.

        Of a sampled controller, every `period` s, they are those of Φ - Γ K. With several drives the gains are those
        of poles that move least with rounding. A mode that no input moves stays, and is to be one of the poles.

        Raises:
            LinearizeError: poles that are too few or many, without their conjugates, or more often the same than there
                are drives; a mode that no input moves and that is none of them.
        """
        return place(self, poles, *native(float, period))

    @timed(LinearizeError)
    def kalman(self, W: Weights | None = None, V: Weights | None = None, period: float | None = None) -> Observer:
        """Return the gain of the Kalman filter, a predictor where it is sampled.

        Args:
            W: variances of what disturbs the rates of states by name, or inputs, by which they come in; others 0; or a
                matrix, shape (nx, nx); 1 for each input, or each state where there is no input, without.
            V: variances of outputs by name, which must be above zero, or a matrix, shape (ny, ny); 1 each without.
            period: seconds between samples.

        Raises:
            LinearizeError: with every fault, as of `lqr`: a mode that does not decay and that no output shows.
        """
        return kalman(self, W, V, *native(float, period))

    @timed(LinearizeError)
    def lqg(
        self,
        Q: Weights | None = None,
        R: Weights | None = None,
        W: Weights | None = None,
        V: Weights | None = None,
        period: float | None = None,
    ) -> Compensator:
        """Return the controller of measured outputs: `lqr(Q, R)` of the state that `kalman(W, V)` estimates."""
        return Compensator(self.lqr(Q, R, period), self.kalman(W, V, period))

"""A linear system along its motion: in axes in which A may stay the same, and from sample to sample, its inputs held.

Where a joint turns a body with ω, which stays in the body's own axes, directions and velocities may be looked at in
these, or in axes that do not turn with it. One rule chooses, for every joint that turns every way: of axes in which A
stays the same along the motion those in which B and the mass matrix do, too; of these the ones that do not turn. So
what is rotationally symmetric is looked at in axes that do not spin with it, and what is not, in its own.

Angles are looked at so, too, while the first alone moves: then the axes of the others turn with it, and with the
constant columns J of ω = J q̇, along axes of the body, they are spun by J⁻¹ ω̃ J where a quaternion's are by ω̃.

Between samples x(t + T) = Φ x(t) + Γ w(t), in two ways:

    exact        exp([A B; 0 0] T) = [Φ Γ; 0 1]                         at a point where A and B stay
    variations   d/dt [Φ Γ] = A(t) [Φ Γ] + [0 B(t)], Φ(0) = 1, Γ(0) = 0       along the motion from the point

In axes that do not spin with a body, inputs that are its drives are held in these axes. The second integrates the
motion itself beside its variations, and holds where the point is no equilibrium too; at one, and along a steady motion,
both are the same.

Reference: Van Loan, Computing integrals involving the matrix exponential, IEEE Trans. Aut. Control 23 (1978).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice, product
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.dynamics.outputs import COLUMNS
from symdyn.errors import LinearizeError
from symdyn.frozen import dataclass, replace
from symdyn.linear.state_space import StateSpace, check_period, sampled
from symdyn.rounding import in_digits
from symdyn.scene.joints import JOINTS, Gimbal
from symdyn.scene.values import Joint
from symdyn.simulation import opened

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization
    from symdyn.linear.prepared import Prepared

STILL = 1e-12
"""Velocities, rad/s or m/s, that are none."""

EQUAL = 1e-6
"""Differences, over the largest entry, that are none."""

MOST = 1000
"""Ways to look at all the joints that are tried."""


@dataclass(frozen=True)
class SpinAxes:
    """Axes to look at what joints move: what is said of them, and Ω of Ṙ = Ω R, shape (nv, nv), rad/s.

    R takes components in the body's axes to those of a frame that does not turn with it: Ω = ω̃ for its every vector,
    and J⁻¹ ω̃ J for angles.
    """

    words: tuple[str, ...]
    spin: Array

    def turned(self, M: Array, time: float) -> Array:
        """Return a matrix of velocities, shape (nv, nv), after some time, in this frame."""
        back = _turn(-time * self.spin)
        return np.asarray(back.T @ M @ back)


def ways(system: Linearization) -> Iterator[SpinAxes]:
    """Return the ways to look at a motion, those in axes that do not turn first, the bodies' own axes last."""
    every: list[list[SpinAxes]] = []
    n, q, u = len(system.scene.velocities), 0, 0
    for joint in system.scene.moving:
        kind = JOINTS[joint.type]
        at = u
        for block in kind.blocks(joint):
            at += len(block.velocities)
            if block.letters:
                every += _of_quaternion(system, joint, at - len(block.velocities), at)
        for gimbal in kind.gimbals(joint):
            every += _of_angles(system, joint, gimbal, q + gimbal.first, u + gimbal.first)
        q, u = q + len(kind.coordinates(joint)), u + len(joint.rates)
    for some in islice(product(*every), MOST):
        spin = sum((one.spin for one in some), np.zeros((n, n)))
        yield SpinAxes(tuple(word for one in some for word in one.words), spin)


def _of_quaternion(system: Linearization, joint: Joint, first: int, end: int) -> Iterator[list[SpinAxes]]:
    """Yield the ways to look at what a quaternion turns: velocities from `first` to `end`, the last three its ω."""
    turning, n = system.point.u[end - 3 : end], len(system.scene.velocities)
    if np.abs(turning).max() <= STILL:
        return
    spin = np.zeros((n, n))
    for part in range(first, end, 3):
        spin[part : part + 3, part : part + 3] = _skew(turning)
    what = "directions, velocities and drives" if any(joint.drives) else "directions and velocities"
    told = f"{what} along axes of a body are in axes of {joint.child} that"
    yield [
        SpinAxes((f"{told} do not spin with it about its {_named(turning)}",), spin),
        SpinAxes((f"{told} turn with it, and so are frequencies",), np.zeros((n, n))),
    ]


def _of_angles(system: Linearization, joint: Joint, gimbal: Gimbal, q: int, u: int) -> Iterator[list[SpinAxes]]:
    """Yield the ways to look at three angles whose axes turn; coordinates begin at place q, velocities at u."""
    rates, n = system.point.u[u : u + len(gimbal.axes)], len(system.scene.velocities)
    turning = [k for k, rate in enumerate(rates[:-1]) if abs(rate) > STILL]
    if len(rates) < len("zyx") or not turning:
        return
    names = system.scene.coordinates[q : q + 3]
    what = "rates and drives" if any(joint.drives) else "rates"
    told = f"{' and '.join(names[turning[0] + 1 :])}, with their {what}, are in axes"
    own = SpinAxes((f"{told} that turn with {names[turning[0]]}, and so are frequencies",), np.zeros((n, n)))
    if np.abs(rates[1:]).max() > STILL:  # J changes
        yield [own]
        return
    J = _columns(gimbal.axes, system.point.q[q : q + 3])
    omega = J @ rates
    spin = np.zeros((n, n))
    spin[u : u + 3, u : u + 3] = np.linalg.solve(J, _skew(omega) @ J)
    yield [SpinAxes((f"{told} of {joint.child} that do not spin with it about its {_named(omega)}",), spin), own]


def _columns(axes: str, angles: Array) -> Array:
    """Return J of ω = J q̇, along axes of the body, of three turns about moving axes, shape (3, 3)."""
    J, back = np.zeros((3, 3)), np.eye(3)
    for k in reversed(range(3)):
        axis = np.eye(3)["xyz".index(axes[k])]
        J[:, k] = back @ axis
        back = back @ _turn(-float(angles[k]) * _skew(axis))
    return J


def _named(way: Array) -> str:
    """Return what an axis of a body is called: x, y, z, or its direction."""
    axis = way / np.linalg.norm(way)
    largest = int(np.abs(axis).argmax())
    if np.abs(axis - axis[largest] * np.eye(3)[largest]).max() <= EQUAL:
        return "xyz"[largest]
    return f"axis ({', '.join(in_digits(float(x), 3) for x in axis * np.sign(axis[largest]) + 0.0)})"


def _skew(axis: Array) -> Array:
    x, y, z = axis
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _turn(spin: Array) -> Array:
    from scipy.linalg import expm  # late: it takes long to load

    return np.asarray(expm(spin), dtype=np.float64)


@dataclass(frozen=True)
class Turned:
    """States and inputs after some time of a frame that spins by Ω against the body's axes.

    States are some entries P of N x, N of the point in that frame; there N stays, so with R = exp(Ω t)

        X = P R⁻¹ N,  x = X x̃,  w = W w̃,  Ã = X⁻¹ (A X + P R⁻¹ Ω N),  B̃ = X⁻¹ B W
    """

    X: Array  # shape (nx, nx)
    rate: Array  # P R⁻¹ Ω N, shape (nx, nx), 1/s
    W: Array  # of inputs, the drives along axes of the body turning as its velocities do, shape (nw, nw)


def turned(start: Linearization, labels: Sequence[str], spin: Array, time: float) -> Turned:
    """Return how states and inputs of a system turn; `labels` name displacements along all velocities."""
    from scipy.linalg import block_diag  # late: it takes long to load

    p, n, nx, ns = start.positions, len(spin), len(start.states), len(start.scene.states)
    N = np.vstack([np.hstack([start.directions, np.zeros((n, nx - p))]), start.rates, np.eye(ns, nx, nx - ns)])
    chosen = [labels.index(name) for name in start.states.names[:p]]
    chosen += [n + k for k in start.velocities]
    back, both = _turn(-time * spin), block_diag(np.kron(np.eye(2), spin), np.zeros((ns, ns)))
    whole = block_diag(np.kron(np.eye(2), back), np.eye(ns))
    W = np.eye(len(start.inputs))
    drives = [k for k, name in enumerate(start.scene.drives) if name and name in start.inputs.names]
    places = [start.inputs.names.index(str(start.scene.drives[k])) for k in drives]
    W[np.ix_(places, places)] = _turn(time * spin).T[np.ix_(drives, drives)]  # so that their power stays
    return Turned((whole @ N)[chosen], (whole @ both @ N)[chosen], W)


def seen(system: Linearization, start: Linearization, labels: Sequence[str], spin: Array, time: float) -> Linearization:
    """Return a system after some time, as `turned` says, in the frame that spins by Ω against the body's axes."""
    if not spin.any():
        return system
    by = turned(start, labels, spin, time)
    AB: Array = np.asarray(np.linalg.solve(by.X, np.hstack([system.A @ by.X + by.rate, system.B @ by.W])), np.float64)
    n = len(system.states)
    return replace(system, A=AB[:, :n], B=AB[:, n:] + 0.0, C=system.C @ by.X, D=system.D @ by.W, spin=spin)


TOLERANCE = 1e-12
"""Relative, of a step of the integration; the absolute one is this over the size of a state, at least 1e-2."""


def along_a_step(prepared: Prepared, one: Linearization, period: float) -> StateSpace:
    """Return the system from sample to sample by variational equations, along the motion from the point.

    Raises:
        LinearizeError: the period is none, or the choice of independent coordinates does not hold for it.
    """
    from scipy.integrate import solve_ivp  # late, too

    check_period(period)
    point, numbers = one.point, opened(one.scene).numbers()
    full = prepared.at(point.q, point.u, point.t)
    labels = COLUMNS["q"](prepared.functions.w)
    n, inputs, nq, nv = len(full.A), full.B.shape[1], len(point.q), len(point.u)

    def rates(t: float, y: Array) -> Array:
        q, u, variations = numbers.normalised(y[:nq]), y[nq : nq + nv], y[nq + nv :].reshape(n, n + inputs)
        here = prepared.at(q, u, t)
        if here.states != full.states:
            raise LinearizeError(
                f"{argument('dt')} {period:g}: other coordinates have to determine the rest within a period; give a "
                "shorter one"
            )
        moved = here.A @ variations
        moved[:, n:] += here.B @ turned(full, labels, one.spin, t - point.t).W if one.spin.any() else here.B
        return np.concatenate([prepared.place(q, u, t).H @ u, here.point.udot, moved.ravel()])

    start = np.concatenate([point.q, point.u, np.eye(n, n + inputs).ravel()])
    run = solve_ivp(rates, (point.t, point.t + period), start, "DOP853", rtol=TOLERANCE, atol=TOLERANCE * 1e-2)
    if not run.success or not np.isfinite(run.y[:, -1]).all():
        raise LinearizeError(f"{argument('dt')} {period:g}: the motion from the point cannot be followed that long")
    found = run.y[nq + nv :, -1].reshape(n, n + inputs)
    if one.spin.any():  # to the axes that the system is in
        found = np.asarray(np.linalg.solve(turned(full, labels, one.spin, period).X, found), np.float64)
    kept = [full.states.names.index(name) for name in one.states.names]
    return sampled(one, found[np.ix_(kept, kept)], found[kept, n:], period)

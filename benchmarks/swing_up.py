"""The swing-ups of docs/performance-of-runs.md: cart-pole by the minimum principle and every method; opty's pendulum.

`python benchmarks/swing_up.py` needs CasADi for all but the truth. That knows nothing of symdyn: state and costate p of
Kelly's equations (6.1) and (6.2), SIAM Review 59 (2017) 849, obey

    x' = f(x, u),    p' = -∂(p · f)/∂x,    u = -p · ∂f/∂u / 2,    x given at both ends,

a boundary value problem that SciPy's `solve_bvp` solves. p · ∂f/∂x is by complex steps, which are exact.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_bvp

import symdyn
from symdyn.transcription import METHODS, Collocation, Solution, along
from symdyn.transcription.solution import lagrangian

Array = NDArray[np.float64]

SCENE = Path(__file__).parent / "data" / "swing_up.toml"

M1, M2, L, G = 1.0, 0.3, 0.5, 9.81
START, END, DURATION = np.zeros(4), np.array([1.0, np.pi, 0.0, 0.0]), 2.0


def motion(x: Array, u: Array) -> Array:
    """Return q1', q2', q1'', q2'' of q1, q2, q1', q2' and the cart's force, shape (4, N)."""
    s, c = np.sin(x[1]), np.cos(x[1])
    mass = M1 + M2 * s**2
    cart = (L * M2 * s * x[3] ** 2 + u + M2 * G * c * s) / mass
    pole = -(L * M2 * c * s * x[3] ** 2 + u * c + (M1 + M2) * G * s) / (L * mass)
    return np.array([x[2], x[3], cart, pole])


def force(x: Array, p: Array) -> Array:
    """Return the u that makes u² + p · f least."""
    none = np.zeros_like(x[0])
    slope = motion(x, none + 1) - motion(x, none)
    return np.asarray(-np.sum(p * slope, axis=0) / 2)


def conditions(_: Array, y: Array) -> Array:
    """Return how state, costate and cost change, shape (9, N)."""
    x, p = y[:4], y[4:8]
    u, slopes = force(x, p), []
    for k in range(4):
        moved = x.astype(complex)
        moved[k] += 1e-30j
        slopes.append(np.sum(p * motion(moved, u).imag, axis=0) / 1e-30)
    return np.vstack([motion(x, u), -np.array(slopes), u**2])


def truth(guess: Collocation, z: Array, multipliers: Array, tol: float = 1e-9) -> float:
    """Return the least cost, N² s; where it is looked for is told by a collocation that was solved."""
    t = guess.duration * guess.grid.share
    x = np.concatenate([z[guess.place["q"]], z[guess.place["u"]]], axis=1).T
    costate = multipliers[guess.row["defects"][:, -1]].T
    p = np.array([np.interp(t, t[guess.grid.node[1:]], -row) for row in costate])
    found = solve_bvp(
        conditions,
        lambda a, b: np.concatenate([a[:4] - START, b[:4] - END, a[8:]]),
        t,
        np.vstack([x, p, np.zeros_like(t)]),
        tol=tol,
        max_nodes=20_000,
    )
    if not found.success:
        raise SystemExit(found.message)
    return float(found.y[8, -1])


def problem(intervals: int, method: str = "hermite_simpson") -> Collocation:
    """Return the swing-up."""
    end = {"end": {"q1": 1, "q2": "pi"}, "end_rates": {"q1": 0, "q2": 0}}
    return symdyn.collocation(symdyn.read(SCENE), DURATION, intervals, method, cost="u**2", **end)


def pendulum() -> None:
    """Print what the pendulum of opty's example takes, from a straight way and from the motion of the fourth order."""
    from collocation import fixed_pendulum

    def told(method: str, where: str, found: Solution) -> None:
        end, turns = found.simulated(rtol=1e-11).q[-1, 0], np.diff(np.sign(found.run.qd[:, 0]))
        words = f"cost {found.objective:.4f}, {np.count_nonzero(turns)} changes of sign, {found.iterations} iterations"
        print(f"pendulum, {method} from {where}: {words}, simulated to {end:.4f} rad")

    best = fixed_pendulum("hermite_simpson").solve(max_iter=1000)
    told("hermite_simpson", "a straight way", best)
    run = best.simulated(rtol=1e-11, every=best.duration / 500)
    for method in ("implicit_midpoint", "trapezoidal"):
        told(method, "a straight way", fixed_pendulum(method).solve(max_iter=1000))
        there = fixed_pendulum(method)
        told(method, "that motion", there.solve(along(there, run), max_iter=1000))


def curvature(found: Collocation, z: Array, multipliers: Array) -> float:
    """Return the least second derivative of the cost along ways that equations and bounds leave free.

    Above zero, with the conditions of first order, there is no better motion next to it (Nocedal and Wright, Numerical
    Optimization (2006), theorem 12.6).
    """
    from scipy.linalg import null_space

    of, free = lagrangian(found), (z - found.lower > 1e-6) & (found.upper - z > 1e-6)
    H = np.zeros((found.size, found.size))
    H[of.rows, of.columns] = of.values(z, 1.0, multipliers)
    H += np.triu(H, 1).T
    ways = null_space(found.jacobian(z).toarray()[:, free], rcond=1e-10)
    return float(np.linalg.eigvalsh(ways.T @ H[np.ix_(free, free)] @ ways)[0])


def optima() -> None:
    """Print which optima of the cart-pole eight starts find, and what conditions each fulfils."""
    found = problem(25).solve(starts=8)
    print(found.searched)
    for one in found.optima:
        bends, pushes = curvature(one.problem, one.z, one.multipliers), one.run.tau[:, 0]
        words = f"cost {one.objective:.4f}, forces {pushes.min():.2f} … {pushes.max():.2f} N, curvature {bends:.1e}"
        at_bounds = np.abs(pushes).max() > 19.99  # where the principle is another one
        told = "" if at_bounds else f"; minimum principle: {truth(one.problem, one.z, one.multipliers):.9f} N² s"
        print(f"{words}{told}")


def main() -> None:
    """Print the optima, the table, and what opty's pendulum takes."""
    optima()
    for method in METHODS:
        for intervals in (25, 50, 100, 200):
            found = problem(intervals, method).solve()
            off = abs(found.simulated(rtol=1e-11).q[-1] - found.run.q[-1]).max()
            words = f"{intervals} intervals, cost {found.objective:.7f}, end error {off:.1e}"
            print(f"{method}: {words}, {found.iterations} iterations")
    pendulum()


if __name__ == "__main__":
    main()

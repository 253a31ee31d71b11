"""Trajectories: our graph in heyoka against expressions entered by hand, and against SciPy over SymPy's lambdify.

    python benchmarks/trajectories.py [rounds]

Double pendulum of two point masses on massless rods, 1 kg and 1 m each, 9.81 m/s², angles relative to the link before,
from rest at q1 = q2 = 0.5 rad: a regular motion. 100 s. Every round runs each once, in turn; times are medians, and
ratios are medians of the ratios inside a round. The reference is heyoka in `long double` at its own epsilon,
three digits beyond double on x86. At the end: what a 7-axis arm costs to translate, to compile, and a second of motion.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import heyoka as hy
import numpy as np
from scipy.integrate import solve_ivp

from symdyn.scene import Scene, read, read_text
from symdyn.simulation import METHODS
from symdyn.simulation.equations.system import Projection
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.integrate import InitialValueProblem
from symdyn.simulation.integrate.heyoka_expressions import size, translate
from symdyn.simulation.integrate.taylor import integrator

EPS = float(np.finfo(np.float64).eps)
START = (0.5, 0.5, 0.0, 0.0)
END = 100.0
EXAMPLES = Path(__file__).parent.parent / "examples"


def scene() -> Scene:
    """Return the double pendulum."""
    text = 'name = "double_pendulum"\ngravity = [0, -9.81, 0]\n'
    for k, parent in ((1, "ground"), (2, "rod1")):
        origin = "" if k == 1 else "origin = [0, -1, 0]\n"
        text += f"[bodies.rod{k}]\nmass = 1\ncom = [0, -1, 0]\n[joints.j{k}]\ntype = 'revolute'\n"
        text += f"parent = '{parent}'\nchild = 'rod{k}'\naxis = [0, 0, 1]\n{origin}"
    return read_text(text)


def entered(lib: object = hy) -> list[tuple[object, object]]:
    """Return the equations as one writes them from a textbook, M solved by Cramer's rule."""
    q1, q2, u1, u2 = hy.make_vars("q1", "q2", "u1", "u2")
    g, c, s = 9.81, hy.cos(q2), hy.sin(q2)
    m11, m12 = 3.0 + 2.0 * c, 1.0 + c
    h1 = -s * u2 * (2.0 * u1 + u2) + 2.0 * g * hy.sin(q1) + g * hy.sin(q1 + q2)
    h2 = s * u1 * u1 + g * hy.sin(q1 + q2)
    det = m11 - m12 * m12
    return [(q1, u1), (q2, u2), (u1, (m12 * h2 - h1) / det), (u2, (m12 * h1 - m11 * h2) / det)]


def lambdified() -> Callable[[float, np.ndarray], list[float]]:
    """Return the right-hand side that SymPy derives and lambdifies: Lagrange's equations, solved for accelerations."""
    import sympy as sp

    t = sp.symbols("t")
    a, b = sp.Function("a")(t), sp.Function("b")(t)
    x1, y1 = sp.sin(a), -sp.cos(a)
    x2, y2 = x1 + sp.sin(a + b), y1 - sp.cos(a + b)
    speed = sum(sp.diff(one, t) ** 2 for one in (x1, y1, x2, y2))
    L = speed / 2 - sp.Float("9.81") * (y1 + y2)
    equations = [sp.diff(sp.diff(L, sp.diff(q, t)), t) - sp.diff(L, q) for q in (a, b)]
    found = sp.solve(equations, [sp.diff(a, t, 2), sp.diff(b, t, 2)], dict=True, simplify=False)[0]
    plain = sp.symbols("q1 q2 u1 u2")
    names = {sp.diff(a, t): plain[2], sp.diff(b, t): plain[3]} | {a: plain[0], b: plain[1]}
    rates = [sp.simplify(found[sp.diff(q, t, 2)]).subs(names) for q in (a, b)]
    call = sp.lambdify(plain, rates, "math")
    return lambda _, x: [x[2], x[3], *call(*x)]


def energy(x: np.ndarray) -> float:
    """Return K + P."""
    a, b, u, w = x[0], x[0] + x[1], x[2], x[2] + x[3]
    return float(u * u + w * w / 2 + u * w * np.cos(a - b) - 2 * 9.81 * np.cos(a) - 9.81 * np.cos(b))


def reference() -> np.ndarray:
    """Return the end in extended precision (64 bits of mantissa at least), two digits and more beyond double."""
    kind = np.longdouble
    variables, entries = translate(state_equations(scene()), real=float)
    x = np.array([kind(one) for one in START])
    ta = hy.taylor_adaptive(list(zip(variables, entries, strict=True)), x, fp_type=kind)
    ta.propagate_until(kind(END))
    return ta.state.copy()


def run(ta: object) -> tuple[float, np.ndarray]:
    """Return seconds and the end of one run of a compiled integrator."""
    ta.time, ta.state[:] = 0.0, START  # type: ignore[attr-defined]
    clock = time.perf_counter()
    ta.propagate_until(END)  # type: ignore[attr-defined]
    return time.perf_counter() - clock, ta.state.copy()  # type: ignore[attr-defined]


def main(rounds: int) -> None:
    """Measure and print."""
    system = state_equations(scene())
    x = np.array(START)
    sides = {tol: list(zip(*translate(system, real=float), strict=True)) for tol in (EPS, 1e-12)}
    ours = {tol: hy.taylor_adaptive(rates, x, tol=tol) for tol, rates in sides.items()}
    theirs = {tol: hy.taylor_adaptive(entered(), x, tol=tol) for tol in (EPS, 1e-12)}
    right = lambdified()

    def sampled() -> tuple[float, np.ndarray]:
        """Our door: 200 samples, pieces, and all."""
        problem = InitialValueProblem(system, x, np.linspace(0, END, 201), EPS, EPS, (), Projection(system, 1e-14))
        pieces = METHODS["taylor"].run(problem)
        next(pieces)
        clock = time.perf_counter()
        last = list(pieces)[-1]
        return time.perf_counter() - clock, last.now[1]

    def scipy_run() -> tuple[float, np.ndarray]:
        clock = time.perf_counter()
        found = solve_ivp(right, (0, END), START, method="DOP853", rtol=1e-12, atol=1e-12)
        return time.perf_counter() - clock, found.y[:, -1]

    ways: dict[str, Callable[[], tuple[float, np.ndarray]]] = {
        "heyoka, our graph, eps": lambda: run(ours[EPS]),
        "heyoka, entered by hand, eps": lambda: run(theirs[EPS]),
        "heyoka, our graph, 1e-12": lambda: run(ours[1e-12]),
        "heyoka, entered by hand, 1e-12": lambda: run(theirs[1e-12]),
        "symdyn's taylor, 200 samples, eps": sampled,
        "SciPy DOP853, SymPy lambdify, 1e-12": scipy_run,
    }
    found = {name: [way()] for name, way in ways.items()}  # warm
    found = {name: [] for name in ways}
    names = list(ways)
    for k in range(rounds):
        for name in names[k % len(names) :] + names[: k % len(names)]:
            if "SciPy" not in name or k < 3:
                found[name].append(ways[name]())
    end, first = reference(), energy(np.array(START, dtype=np.longdouble))
    base = [seconds for seconds, _ in found[names[0]]]
    print(f"{'double pendulum, 100 s':38} {'ms':>9} {'of ours':>9} {'end error':>10} {'energy drift':>13}")
    for name in names:
        ratio = median(s / b for (s, _), b in zip(found[name], base, strict=False))
        x1 = found[name][0][1]
        error = float(np.max(np.abs(x1 - end)))
        drift = abs(energy(x1) - first) / abs(first)
        print(f"{name:38} {1e3 * median(s for s, _ in found[name]):9.3f} {ratio:9.2f} {error:10.2e} {drift:13.2e}")
    arm()


def arm() -> None:
    """Print what a 7-axis arm costs; heyoka keeps what it has compiled, and must not find it here."""
    hy.llvm_state.set_diskcache_enabled(False)
    hy.llvm_state.clear_memcache()
    system = state_equations(read(EXAMPLES / "arm7.toml"))
    x = np.concatenate([np.linspace(0.2, 0.8, 7), np.zeros(7)])
    clock = time.perf_counter()
    translate(system)
    translated = time.perf_counter() - clock
    problem = InitialValueProblem(system, x, np.array([0.0, 1.0]), 1e-12, 1e-12, (), Projection(system, 1e-14))
    clock = time.perf_counter()
    with integrator(problem) as lent:
        compiled = time.perf_counter() - clock - translated
        clock = time.perf_counter()
        lent.ta.propagate_until(1.0)
        moved = time.perf_counter() - clock
    print(
        f"7-axis arm, {size(system)} operations: translation {1e3 * translated:.0f} ms, compilation {compiled:.2f} s, "
    )
    print(f"a second of motion {1e3 * moved:.2f} ms at tolerance 1e-12")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 15)

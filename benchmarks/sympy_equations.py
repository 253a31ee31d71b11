"""Time to have equations of motion in SymPy, M, C, c, g and all else, and what is refused in its place.

    python benchmarks/sympy_equations.py

Imports are not counted. A mechanism that would take minutes is refused within seconds, with what works instead. Below
stands what a call of forward dynamics takes at one state: compiled, and by two ways through SymPy.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from statistics import median

import numpy as np
import sympy  # not counted in the first table

import symdyn
from symdyn.errors import DerivationError, EmitError
from symdyn.scene import Scene, Starter, read_text, with_symbolic_inertia


def cases() -> Iterator[tuple[str, Scene]]:
    """Yield scenes by name."""
    for name in ("two_link", "four_bar", "puma560", "arm7", "bicycle"):
        yield name, symdyn.example(name)
    yield "puma560, ten symbols a link", with_symbolic_inertia(symdyn.example("puma560"))
    for n in (10, 14, 16, 60):
        yield f"chain of {n}", read_text(Starter("chain").from_template("chain", n), "chain.toml")


CALLS, ROUNDS = 2000, 9


def ways(scene: Scene) -> dict[str, Callable[[], object]]:
    """Return calls of the forward dynamics of a scene without free parameters at one state, by how they are made."""
    equations, n = symdyn.equations(scene), len(scene.coordinates)
    compiled, x = symdyn.load(scene, "forward_dynamics").forward_dynamics, np.linspace(0.1, 0.2, 2 * n)
    q, u, tau, drives = x[:n], x[n:], np.zeros(n), dict.fromkeys(filter(None, scene.drives), 0)
    rates = equations.lambdify(drives)
    found: dict[str, Callable[[], object]] = {
        "load": lambda: compiled(q, u, tau), "equations.lambdify": lambda: rates(0.0, x)
    }  # fmt: skip
    try:
        states, f = equations.subs({**equations.sympy().values, **drives}).state_space()
    except EmitError:  # too long
        return found
    through = sympy.lambdify(list(states), list(f), "numpy")
    return found | {"state_space, SymPy's lambdify": lambda: through(*x)}


def main() -> None:
    """Print the tables."""
    print("| mechanism | seconds | operations in M and c |\n|---|---|---|")
    for name, scene in cases():
        start = time.process_time()
        try:
            found = symdyn.equations(scene).sympy()
        except DerivationError:
            print(f"| {name} | {time.process_time() - start:.1f} | refused |")
            continue
        seconds = time.process_time() - start
        print(f"| {name} | {seconds:.1f} | {sum(int(entry.count_ops()) for entry in (*found.M, *found.c))} |")
    print("\n| mechanism | way | µs a call |\n|---|---|---|")
    for name in ("cart_pole", "puma560"):
        known = ways(symdyn.example(name))
        times: dict[str, list[float]] = {way: [] for way in known}
        for way, call in list(known.items()) * ROUNDS:  # in turns
            start = time.perf_counter()
            for _ in range(CALLS):
                call()
            times[way].append((time.perf_counter() - start) / CALLS * 1e6)
        print(*(f"| {name} | {way} | {median(some):.2f} |" for way, some in times.items()), sep="\n")


if __name__ == "__main__":
    main()

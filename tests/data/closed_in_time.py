"""Make closed_in_time.json: motions of closed mechanisms in numbers of 64 bits, each step brought back to the loops.

    python tests/data/closed_in_time.py

The equations are those of symdyn by all rows at once; series, steps and numbers are heyoka's, at a tolerance of 1e-19.
Residuals are computed in 64 bits and taken away by Newton's method with a pseudo-inverse in 53, so that loops are kept
to 1e-18. What such a motion is worth is told beside it, "sure": how far another one is from it whose steps are three
quarters as long, over the size of each coordinate and velocity or 1.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.dynamics.mechanism import TIME
from symdyn.graph import Expr, evaluate
from symdyn.program.routine import Program
from symdyn.scene import Scene, read
from symdyn.simulation import read_forces
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.initial import read_start
from symdyn.simulation.integrate.heyoka_expressions import Expressions

HERE = Path(__file__).parent
ROOT = HERE.parent.parent

ROWS: Mapping[str, tuple[dict[str, str], list[str], float]] = {
    "examples/four_bar.toml": ({}, [], 5.0),
    "examples/slider_crank.toml": ({"phi": "6"}, [], 5.0),
    "examples/governor.toml": ({}, [], 5.0),
    "examples/spatial_slider_crank.toml": ({"phi": "5"}, [], 5.0),
    "examples/rssr.toml": ({"phi": "3"}, [], 5.0),
    "examples/rsup.toml": ({"phi": "3"}, [], 5.0),
    "examples/rolling_disc.toml": ({}, [], 5.0),
    "examples/cart_with_wheel.toml": ({}, ["T=0.5*cos(2*t)-0.1*x"], 5.0),
    "benchmarks/data/squeezer.toml": ({}, ["mom=0.033"], 0.03),
}
"""Velocities at the start, forces, and how long it moves, s."""

SAMPLES = 10

Long = np.longdouble


def long(value: Fraction) -> Any:
    """Return a fraction in 64 bits."""
    high = float(value)
    return Long(high) + Long(float(value - Fraction(high)))


def entries_of(system: StateEquations, made: Any, name: str) -> tuple[list[Any], list[Any]]:
    """Return the variables of the state and a function's entries as heyoka's expressions in 64 bits."""
    algebra, function = Expressions(long), made.prepared[name].function
    symbols = {argument.name: argument.symbols for argument in function.arguments}
    state = [*symbols["q"], *symbols.get("qd", ())]
    values: dict[Expr, Any] = {one: algebra.heyoka.expression(str(one.value)) for one in state}
    values |= dict.fromkeys(symbols.get(TIME, ()), algebra.heyoka.time)
    known = map(Fraction, map(float, made.values(system.opened.values)))
    values |= {one: algebra.constant(x) for one, x in zip(symbols.get(Program.PREPARED, ()), known, strict=True)}
    return [values[one] for one in state], evaluate(function.entries, algebra, values)


def brought_back(system: StateEquations) -> Callable[[Any], Any]:
    """Return what brings a state in 64 bits back to its loops."""
    import heyoka

    nq, nv = system.nq, system.nv
    calls = {}
    for name in ("constraint_residual", "row_rates"):
        variables, entries = entries_of(system, system.compiled, name)
        calls[name] = heyoka.cfunc(entries, variables, fp_type=Long, compact_mode=True), len(variables)

    def missed(name: str, x: Any) -> Any:
        call, size = calls[name]
        return call(x[:size])

    def settled(x: Any) -> Any:
        for _ in range(3):
            for part in system.quaternions:
                x[part] /= np.sqrt((x[part] * x[part]).sum())
            plus = np.linalg.pinv(system.jacobian(0.0, x.astype(float)), rcond=1e-9)
            step = -(plus.astype(Long) @ missed("constraint_residual", x))
            x[:nq] += system.calls["movement"](x[:nq].astype(float), step.astype(float))
            plus = np.linalg.pinv(system.jacobian(0.0, x.astype(float)), rcond=1e-9)
            x[nq : nq + nv] -= plus.astype(Long) @ missed("row_rates", x)
        return x

    return settled


def motion(scene: Scene, rates: Mapping[str, str], forces: list[str], until: float, share: float) -> Any:
    """Return the states at `SAMPLES` times, shape (SAMPLES, nq + nv), of steps a share as long as heyoka's."""
    import heyoka

    system, start = state_equations(scene, read_forces(scene, forces)), read_start(scene, rates=rates)
    made = system.together if system.closed and not system.linear else system.compiled
    variables, entries = entries_of(system, made, "together" if made is system.together else "rates")
    settled, n = brought_back(system), len(variables)
    x = settled(np.concatenate([start.q, start.u]).astype(Long))
    ta = heyoka.taylor_adaptive(
        list(zip(variables, entries[:n], strict=True)), x, tol=Long(1e-19), compact_mode=True, fp_type=Long
    )
    found = []
    for k in range(1, SAMPLES + 1):
        end = Long(until) * k / SAMPLES
        while ta.time < end:
            begin, state = ta.time, ta.state.copy()
            ta.step(max_delta_t=end - begin)
            if share < 1:
                h = (ta.time - begin) * share
                ta.time, ta.state[:] = begin, state
                ta.step(max_delta_t=h)
            ta.state[:] = settled(ta.state.copy())
        found.append(ta.state[: system.nq + system.nv].copy())
    return np.array(found)


def main() -> None:
    """Write the file."""
    told = {}
    for name, (rates, forces, until) in ROWS.items():
        scene = read(ROOT / name)
        x, other = (motion(scene, rates, forces, until, share) for share in (1.0, 0.75))
        size = np.maximum(1.0, np.abs(x).max(axis=0))
        told[name] = {
            "rates": rates, "forces": forces, "until": until,
            "sure": float(f"{np.abs((x - other) / size).max():.1e}"), "states": x.astype(float).tolist(),
        }  # fmt: skip
        print(name, told[name]["sure"])
    text = json.dumps({"source": "tests/data/closed_in_time.py", "rows": told})
    (HERE / "closed_in_time.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

"""Linear systems next to a point: against differences of the equations, and against what books print."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.algebra.numeric import Array, Floats
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.graph import evaluate
from symdyn.linear import Linearization
from symdyn.program import cheapest
from symdyn.simulation.equations.opened import numbers_at

EXAMPLES = Path(__file__).parent.parent / "examples"


def example(name: str) -> symdyn.Scene:
    return symdyn.read(EXAMPLES / f"{name}.toml")


PLAIN = {
    "cart_pole": ({"theta": "0.4", "x": "1"}, {"x": "0.5", "theta": "-1"}),
    "double_pendulum": ({"q1": "0.3", "q2": "-1"}, {"q1": "1", "q2": "-0.4"}),
    "four_bar": ({"phi": "0.9"}, {"phi": "2"}),
    "slider_crank": ({"phi": "0.7"}, {"phi": "-3"}),
    "governor": ({}, {"phi": "11", "alpha": "0.5"}),
    "cart_with_wheel": ({"x": "0.3", "phi": "0.2"}, {"phi": "1.5"}),
    "gripper2": ({}, {}),
}


class Moving:
    """The equations of a scene, and their accelerations next to a point on the manifold."""

    def __init__(self, linear: Linearization) -> None:
        scene, self.point = linear.scene, linear.point
        self.w, self.numbers = Workspace(scene), numbers_at(scene)
        self.entries = cheapest(self.w, "forward_dynamics").entries
        names = linear.states.names
        self.velocities = [scene.velocities.index(name) for name in names[linear.positions :]]
        self.positions = [scene.velocities.index(f"{name}_dot") for name in names[: linear.positions]]

    def rates(self, x: Array, tau: Array) -> Array:
        """Return the rates of independent positions and velocities that are by x from the point."""
        q = self.point.q.copy()
        q[self.positions] += x[: len(self.positions)]
        others = [k for k in range(len(q)) if k not in self.positions]
        for _ in range(8 if others else 0):
            R = self.numbers.residual_rates(q)[:, others]
            q[others] -= np.linalg.lstsq(R, self.numbers.residual(q), rcond=None)[0]
        u = self.point.u.copy()
        u[self.velocities] += x[len(self.positions) :]
        others = [k for k in range(len(u)) if k not in self.velocities]
        if others:
            G = self.numbers.jacobian(q)
            u[others] = -np.linalg.lstsq(G[:, others], G[:, self.velocities] @ u[self.velocities], rcond=None)[0]
        state = self.w.state
        values = self.w.graph
        known = dict(zip([*state.q, *state.qd, *state.tau], [*q, *u, *tau], strict=True))
        known |= {values.symbol(name): x for name, x in parameters(self.w.scene).items()}
        a = np.array(evaluate(self.entries, Floats(), known))
        return np.concatenate([u[self.positions], a[self.velocities]])


def parameters(scene: symdyn.Scene) -> dict[str, float]:
    from symdyn.simulation.equations.opened import opened

    return dict(opened(scene).values)


@pytest.mark.parametrize("name", PLAIN)
def test_a_and_b_are_what_differences_of_the_equations_tend_to(name: str) -> None:
    scene = example(name)
    at, rates = PLAIN[name]
    linear = symdyn.linearize(scene, at, rates, anywhere=True)
    moving, step = Moving(linear), 1e-6
    columns = []
    for x in np.eye(len(linear.states)):
        there, here = (moving.rates(sign * step * x, linear.point.tau) for sign in (1, -1))
        columns.append((there - here) / (2 * step))
    size = np.abs(linear.A).max()
    assert pytest.approx(np.stack(columns, axis=1), abs=2e-8 * max(1.0, size)) == linear.A
    for k, drive in enumerate(linear.inputs.names):
        push = np.zeros(len(scene.velocities))
        push[scene.drives.index(drive)] = 1.0
        nothing = np.zeros(len(linear.states))
        more = moving.rates(nothing, linear.point.tau + push) - moving.rates(nothing, linear.point.tau)
        assert linear.B[:, k] == pytest.approx(more, abs=1e-9 * max(1.0, np.abs(linear.B).max()))

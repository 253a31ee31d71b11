"""Derivatives of outputs along their arguments, against differences of the function itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.verify import certify

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.mark.parametrize("name", ["two_link", "cart_pole"])
@pytest.mark.parametrize("output", ["inverse_dynamics", "forward_dynamics", "kinetic_energy"])
def test_derivatives_are_what_differences_tend_to(name: str, output: str) -> None:
    scene = symdyn.read(EXAMPLES / f"{name}.toml")
    derivatives = symdyn.lambdify(scene, f"{output}_derivatives")
    function = symdyn.lambdify(scene, output)
    numbers = np.random.default_rng(7)
    free = [numbers.uniform(0.5, 1.5, len(scene.free_parameters))] if scene.free_parameters else []
    blocks = len(function_arguments(scene, output))
    state = numbers.uniform(-1, 1, (blocks, 2))
    step = 1e-6
    columns = []
    for k in range(blocks * 2):
        moved = np.zeros(blocks * 2)
        moved[k] = step
        there, here = state + moved.reshape(state.shape), state - moved.reshape(state.shape)
        columns.append(np.atleast_1d(function(*there, *free) - function(*here, *free)) / (2 * step))
    assert derivatives(*state, *free) == pytest.approx(np.stack(columns, axis=1), rel=1e-7, abs=1e-7)


def function_arguments(scene: symdyn.Scene, output: str) -> list[str]:
    """Return the names of the arguments of an output, parameters left out."""
    function = symdyn.dynamics.derive(scene, [output])[output]
    return [argument.name for argument in function.arguments if argument.name != "params"]


@pytest.mark.usefixtures("numpy_alone")
def test_forward_and_reverse_differentiation_are_proved_equal() -> None:
    scene = symdyn.read(EXAMPLES / "cart_pole.toml")
    assert certify(scene, ["inverse_dynamics_derivatives", "forward_dynamics_derivatives"]).passed

"""The recursion to derivatives of inverse and forward dynamics, against differentiation of the graph."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mechanisms import COUPLED, TREES, jointed, with_loads

import symdyn
from symdyn.algebra.numeric import Batches
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.graph import Op, evaluate, reachable
from symdyn.scene import JOINTS, Scene
from symdyn.verify import certify

EXAMPLES = [symdyn.read(path) for path in sorted((Path(__file__).parent.parent / "examples").glob("*.toml"))]
OPEN = [scene for scene in EXAMPLES if not scene.is_closed]

LOADED = [with_loads(tree, seed) for seed, tree in enumerate([*TREES[:2], *COUPLED[:2]])]
OF_KINDS = [
    jointed("revolute", kind, "prismatic", orientation=orientation)
    for kind in JOINTS
    for orientation in (("quaternion", "zyx") if kind in ("spherical", "free", "rod") else ("quaternion",))
]
IN_ROWS = [jointed("free", "free", orientation=one) for one in ("quaternion", "zyx")]
BALLS = [with_loads(jointed("revolute", "spherical", "cylindrical"), 3), with_loads(jointed("free", "helical"), 4)]


def numbers(workspace: Workspace, output: str, roads: tuple[str, ...]) -> list[np.ndarray]:
    """Return what each road gives at random states."""
    functions = [derive_one(workspace, output, road) for road in roads]
    draw = np.random.default_rng(3)
    found = reachable([entry for one in functions for entry in one.entries])
    values = {node: draw.uniform(0.5, 1.5, 3) for node in found if node.op is Op.SYMBOL}
    for names in quaternions(workspace.scene):
        parts = [workspace.graph.symbol(name) for name in names]
        length = np.sqrt(sum(values.setdefault(part, draw.uniform(0.5, 1.5, 3)) ** 2 for part in parts))
        values |= {part: values[part] / length for part in parts}
    results = [evaluate(list(one.entries), Batches(), values) for one in functions]
    return [np.array([np.broadcast_to(x, 3) for x in one]) for one in results]


ROADS = {
    "inverse_dynamics_derivatives": ("recursive", "forward"),
    "forward_dynamics_derivatives": ("recursive", "forward"),
    "coriolis_matrix": ("derivatives", "crba"),
}


@pytest.mark.parametrize(
    "scene", [*OPEN, *TREES[:4], *COUPLED[:3], *LOADED, *OF_KINDS, *IN_ROWS, *BALLS], ids=lambda scene: scene.name
)
def test_recursion_is_differentiation_in_numbers(scene: Scene) -> None:
    workspace = Workspace(scene)
    for output, roads in ROADS.items():
        recursive, other = numbers(workspace, output, roads)
        assert recursive == pytest.approx(other, rel=1e-9, abs=1e-9 * max(1.0, np.abs(other).max())), output


PROVED = [COUPLED[3], jointed("spherical"), jointed("custom")]


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("scene", PROVED, ids=lambda scene: scene.name)
def test_all_roads_are_proved_equal(scene: Scene) -> None:
    found = certify(scene, list(ROADS))
    assert found.passed, found.findings

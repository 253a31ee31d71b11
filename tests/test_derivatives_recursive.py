"""The recursion to derivatives of inverse and forward dynamics, against differentiation of the graph."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from engine.trials.cases import draw
from engine.trials.options import choice
from mechanisms import COUPLED, TREES, jointed, with_loads

import symdyn
from symdyn.algebra.numeric import Batches
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.errors import DerivationError
from symdyn.graph import Op, evaluate, reachable
from symdyn.scene import Scene, read_text
from symdyn.scene.forces.force_table import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values.quantity import Quantity
from symdyn.verify import certify

pytestmark = pytest.mark.long

EXAMPLES = Path(__file__).parent.parent / "examples"
OPEN = [scene for scene in map(symdyn.read, sorted(EXAMPLES.glob("*.toml"))) if not scene.is_constrained]

LOADED = [with_loads(tree, seed) for seed, tree in enumerate([*TREES[:2], *COUPLED[:2]])]
OF_KINDS = [
    jointed("revolute", kind, "prismatic", orientation=orientation)
    for kind in JOINTS
    for orientation in (("quaternion", "zyx") if kind in ("spherical", "free", "rod") else ("quaternion",))
]
IN_ROWS = [jointed("spherical", "free"), jointed("free", "free", orientation="zyx")]
BALLS = [with_loads(jointed("revolute", "spherical", "cylindrical"), 3), with_loads(jointed("free", "helical"), 4)]


def numbers(workspace: Workspace, output: str, formulations: tuple[str, ...]) -> list[np.ndarray]:
    """Return what each formulation gives at three random states, and at zero."""
    functions = [derive_one(workspace, output, formulation) for formulation in formulations]
    draw = np.random.default_rng(3)
    found = reachable([entry for one in functions for entry in one.entries])
    values = {node: draw.uniform(0.5, 1.5, 4) for node in found if node.op is Op.SYMBOL}
    state = workspace.state
    for one in (*state.q, *state.qd, *state.qdd, *state.tau):
        values.setdefault(one, draw.uniform(0.5, 1.5, 4))[3] = 0
    for names in quaternions(workspace.scene):
        parts = [workspace.graph.symbol(name) for name in names]
        values[parts[0]][3] = 1
        length = np.sqrt(sum(values[part] ** 2 for part in parts))
        values |= {part: values[part] / length for part in parts}
    results = [evaluate(list(one.entries), Batches(), values) for one in functions]
    return [np.array([np.broadcast_to(x, 4) for x in one]) for one in results]


FORMULATIONS = {
    "inverse_dynamics_derivatives": ("recursive", "forward"),
    "forward_dynamics_derivatives": ("recursive", "forward"),
    "coriolis_matrix": ("derivatives", "crba"),
}


def jumps(scene: Scene) -> bool:
    """Tell whether dry friction is an ideal sign, with which there is no forward dynamics."""
    return any(joint.dry is not None and FORCES[joint.dry.kind].rub.jumps(joint.dry) for joint in scene.joints)


def agree(scene: Scene) -> None:
    """Compare the formulations of all three."""
    workspace = Workspace(scene)
    for output, formulations in FORMULATIONS.items():
        if output.startswith("forward") and jumps(scene):
            with pytest.raises(DerivationError, match="ideal sign of the rate"):
                derive_one(workspace, output)
            continue
        recursive, other = numbers(workspace, output, formulations)
        size = np.nanmax(np.abs(other), initial=1.0)
        assert recursive == pytest.approx(other, rel=1e-9, abs=1e-9 * size, nan_ok=True), output
        assert np.isfinite(recursive[:, :3]).all()


@pytest.mark.wide(12)
@pytest.mark.parametrize(
    "scene", [*OPEN, *TREES[:4], *COUPLED[:3], *LOADED, *OF_KINDS, *IN_ROWS, *BALLS], ids=lambda scene: scene.name
)
def test_recursion_is_differentiation_in_numbers(scene: Scene) -> None:
    agree(scene)


def drawn(seed: int) -> Scene:
    """Return a mechanism of the engine's trials: locks, prescribed motions, springs, names of all kinds."""
    return read_text(draw(seed, choice(seed)).text)


@pytest.mark.parametrize("seed", [12, 18, 24])
def test_drawn_mechanisms_agree(seed: int) -> None:
    agree(drawn(seed))


@pytest.mark.slow
@pytest.mark.parametrize("begin", range(0, 400, 50))
def test_hundreds_of_drawn_mechanisms_agree(begin: int) -> None:
    scenes = [scene for scene in map(drawn, range(begin, begin + 50)) if not scene.is_constrained]
    assert scenes
    for scene in scenes:
        agree(scene)


def test_prescribed_motion_is_no_function_of_the_state() -> None:
    scene = symdyn.read(EXAMPLES / "two_link.toml")
    led = replace(
        scene, joints=(replace(scene.joints[0], motion=Quantity.symbol("t") * Quantity.symbol("t")), *scene.joints[1:])
    )
    agree(led)
    rows = symdyn.dynamics.derive(led, ["forward_dynamics_derivatives"])["forward_dynamics_derivatives"].entries[:6]
    assert all(entry.is_zero for entry in rows)


@pytest.mark.parametrize("led", [False, True])
def test_a_joint_that_moves_no_mass_is_named(led: bool) -> None:
    scene = symdyn.read(EXAMPLES / "two_link.toml")
    if led:
        scene = replace(scene, joints=(replace(scene.joints[0], motion=Quantity.symbol("t")), *scene.joints[1:]))
    tip = replace(scene.bodies[-1], particles=())
    with pytest.raises(DerivationError, match=f"joint {scene.joints[-1].name}, which carries {tip.name}, moves no"):
        symdyn.dynamics.derive(
            replace(scene, bodies=(*scene.bodies[:-1], tip)), ["forward_dynamics_derivatives"], "recursive"
        )


PROVED = [COUPLED[3], jointed("spherical"), jointed("custom")]


@pytest.mark.heavy("coupled3")
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("scene", PROVED, ids=lambda scene: scene.name)
def test_all_formulations_are_proved_equal(scene: Scene) -> None:
    found = certify(scene, list(FORMULATIONS))
    assert found.passed, found.findings

"""All branches of an arm as an output: proved, at poses of the arm, at singular ones, and out of reach."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import product
from math import pi
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.algebra import Array
from symdyn.dynamics import Workspace, derive_one
from symdyn.errors import ArgumentError, DerivationError
from symdyn.graph import Expr, Op, reachable
from symdyn.scene import Scene, read_text
from symdyn.verify.equality import prove
from symdyn.verify.laws import laws

REQUEST = "inverse_kinematics:tool"
PUMA = symdyn.example("puma560")

Row = tuple[object, object, str]


def by_dh(name: str, *rows: Row, more: str = "") -> Scene:
    """Return an arm of links d, a, α of six joints."""
    links = "".join(
        f'[[dh.links]]\nd = "{d}"\na = "{a}"\nalpha = "{alpha}"\nmass = 1\ncom = [0, 0, 0]\n'
        'inertia = [1, 1, 1]\ninertia_about = "com"\n'
        for d, a, alpha in rows
    )
    head = f'name = "{name}"\n{more}[dh]\nconvention = "standard"\n'
    return read_text(f'{head}{links}[points.tool]\nbody = "link{len(rows)}"\n')


WRIST: tuple[Row, ...] = ((0.62, 0, "pi/2"), (0, 0, "-pi/2"), (0.115, 0, "0"))
ARMS = {
    "puma560": PUMA,
    "base": by_dh("base", (0.4, 0.18, "-pi/2"), (0, 0.6, "0"), (0.03, 0.12, "-pi/2"), *WRIST),
    "against": by_dh("against", (0.4, 0.18, "-pi/2"), (0, 0.6, "pi"), (0.03, 0.12, "pi/2"), *WRIST),
    "slant": by_dh("slant", (0.4, 0.18, "pi/3"), (0, 0.6, "0"), (0.03, 0.12, "-pi/2"), *WRIST),
    "ur": by_dh("ur", (0.089159, 0, "pi/2"), (0, -0.425, "0"), (0, -0.39225, "0"), (0.10915, 0, "pi/2"),
                (0.09465, 0, "-pi/2"), (0.0823, 0, "0")),
}  # fmt: skip
FREE = by_dh(
    "free", ("d1", "a1", "-pi/2"), (0, "a2", "0"), ("d3", "a3", "-pi/2"), ("d4", 0, "pi/2"), *WRIST[1:],
    more="[parameters]\n" + "".join(f'{name} = {{ unit = "m" }}\n' for name in ("d1", "a1", "a2", "d3", "a3", "d4")),
)  # fmt: skip
each = pytest.mark.parametrize("scene", ARMS.values(), ids=ARMS)


def claims(scene: Scene) -> list[Any]:
    """Return that each branch has the pose."""
    w = Workspace(scene)
    derive_one(w, REQUEST)
    return laws(w, [REQUEST])


@cache
def functions(scene: Scene) -> Any:
    return symdyn.lambdify(scene, [REQUEST, "pose:tool"])


def missed(scene: Scene, q: Array, *given: Array) -> tuple[Array, Array]:
    """Return by how much each branch misses the poses of q, shape (N, 8), NaN out of reach, and the branches."""
    solve, pose = functions(scene)
    T = pose(q, *given)
    with np.errstate(invalid="ignore"):
        found = solve(T, *given)
    return np.abs(pose(found, *given) - T[:, None]).max(axis=(2, 3)), found


def turned(x: Array) -> Array:
    return x - 2 * pi * np.round(x / (2 * pi))


@pytest.mark.parametrize("scene", [PUMA, ARMS["ur"], FREE], ids=lambda scene: scene.name)
def test_every_branch_has_the_pose_over_finite_fields_with_parameters_too(scene: Scene) -> None:
    every = claims(scene)
    _, findings = prove([every[0], every[7]] if scene is not FREE else every[3:4])

    assert len(every) == 8
    assert {one.verdict for one in findings} == {"proved"}
    assert max(one.error_log10 for one in findings) < -30


@pytest.mark.parametrize("sign", [Op.ADD, Op.SUB])
def test_a_branch_with_one_wrong_sign_is_not_proved(sign: Op) -> None:
    one = claims(PUMA)[4]
    swap = {Op.ADD: lambda a, b: a - b, Op.SUB: lambda a, b: a + b}[sign]
    wrong = next(node for node in reversed(reachable(one.left)) if node.op is sign)
    known: dict[Expr, Expr] = {}
    for node in reachable(one.left):
        args = [known[arg] for arg in node.args]
        known[node] = swap(*args) if node is wrong else node.graph.copy(node, args) if args else node
    _, (finding,) = prove([replace(one, left=tuple(known[node] for node in one.left))])

    assert finding.verdict == "fails"


@each
@pytest.mark.runs("cc")
def test_every_branch_has_the_pose_in_numbers_and_one_is_the_start(scene: Scene) -> None:
    q = np.random.default_rng(2).uniform(-pi, pi, (2000, 6))
    error, found = missed(scene, q)
    reached = ~np.isnan(found).any(axis=2)

    assert error[reached].max() < 1e-12
    assert reached.any(axis=1).all()
    assert np.nanmin(np.abs(turned(found - q[:, None])).max(axis=2), axis=1).max() < 1e-7
    assert reached.mean() > 0.85


@pytest.mark.parametrize("R", [2 * np.eye(3), -np.eye(3), np.zeros((3, 3))], ids=["long", "mirrored", "zero"])
def test_a_matrix_that_is_no_rotation_is_no_pose(R: Array) -> None:
    solve = symdyn.lambdify(PUMA, REQUEST)
    with pytest.raises(ArgumentError, match="pose turns by no rotation; give"):
        solve(np.column_stack([R, [0.3, 0.2, 0.4]]))
    with pytest.raises(ArgumentError, match="R p"):
        solve(np.eye(4)[:, :3])


@each
@pytest.mark.runs("cc")
def test_singular_postures_have_branches_to_the_last_digits(scene: Scene) -> None:
    rng, elbow = np.random.default_rng(3), {"ur": 0.0, "puma560": np.arctan2(0.4318, -0.0203), "against": 1.7619547}
    every = product((0.0, 1e-16, 1e-13, 1e-10, 1e-7, 1e-4), (4, 2, None))
    for tiny, place in every:  # a straight wrist; a folded or stretched elbow; multiples of a right angle
        q = rng.uniform(-pi, pi, (40, 6))
        if place is None:
            q = np.round(q / (pi / 2)) * pi / 2
        else:
            q[:, place] = 0.0 if place == 4 else elbow.get(scene.name, -1.7619547)
        error, found = missed(scene, q + tiny)
        reached = ~np.isnan(found).any(axis=2)

        assert error[reached].max() < 1e-12
        if place or tiny < 1e-14:  # next to two singularities at once digits are lost
            assert reached.any(axis=1).all()


@pytest.mark.runs("cc")
def test_a_wrist_on_the_first_axis_takes_any_first_angle() -> None:
    arm = by_dh("above", (0.4, 0, "-pi/2"), (0, 0.6, "0"), (0, 0.02, "-pi/2"), *WRIST)
    q = np.array([[0.7, -pi / 2, pi / 2 - np.arctan2(0.62, -0.02) + pi / 2, 0.3, 0.4, 0.5]])
    error, found = missed(arm, q)
    reached = ~np.isnan(found).any(axis=2)

    assert reached.any()
    assert error[reached].max() < 1e-12


@pytest.mark.runs("cc")
def test_what_is_out_of_reach_is_nan_and_poses_come_as_matrices() -> None:
    solve = symdyn.load(PUMA, [REQUEST, "pose:tool"])
    far = np.column_stack([np.eye(3), [2.0, 0, 0]])
    with np.errstate(invalid="ignore"):
        assert np.isnan(solve.inverse_kinematics_tool(far)).any(axis=1).all()
    T = solve.pose_tool(np.full((3, 6), 0.3))
    square = np.concatenate([T, np.broadcast_to([[[0.0, 0, 0, 1]]], (3, 1, 4))], axis=1)
    rows = solve.inverse_kinematics_tool(T.reshape(3, 12))
    assert rows.shape == (3, 8, 6)
    for given in (T, square, T.tolist()):
        assert np.array_equal(solve.inverse_kinematics_tool(given), rows)
    with pytest.raises(ArgumentError, match=r"pose has 3 in its last dimension; give \[R p\]"):
        solve.inverse_kinematics_tool(T[:, :, :3])


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        (symdyn.example("arm7"), "of six joints that turn, each by itself, and there are 7; symdyn.inverse_kinematics"),
        (by_dh("bent", *[(0.1, 0.2, "pi/3")] * 6), "it is of arms with a spherical wrist, axes 4, 5, 6 that meet"),
        (by_dh("short", (0.4, 0.18, "-pi/2"), (0, 0, "0"), (0, 0.1, "-pi/2"), *WRIST), "it is of arms with a"),
        (symdyn.example("four_bar"), "is about trees; loops or rows close four_bar"),
    ],
    ids=["seven", "bent", "short", "closed"],
)
def test_arms_without_the_output_are_told_so(scene: Scene, told: str) -> None:
    place = [*scene.bodies, *scene.points][-1].name
    with pytest.raises(DerivationError, match=told):
        derive_one(Workspace(scene), f"inverse_kinematics:{place}")


@pytest.mark.slow
@pytest.mark.runs("cc")
@each
def test_the_certificate_of_an_arm_passes_with_its_files(scene: Scene) -> None:
    found = symdyn.certify(scene, [REQUEST], targets=["c", "cpp", "numpy", "js"])

    assert found.passed
    assert sum(one.verdict == "proved" for one in found.findings) == 8

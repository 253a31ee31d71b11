"""Inertias are judged of the bodies that move: what is welded together is one body, and rounding is no fault."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.errors import SceneError
from symdyn.scene import Scene, read, read_text

PLACEHOLDER = '<mass value="1e-6"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="1e-6" ixz="1e-6" iyz="1e-6"/>'
"""As ANYmal's base has it: I1 = I2 = 0, I3 = 3e-6."""

GOOD = '<mass value="6"/><inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0" ixz="0.01" iyz="0"/>'
EMPTY = '<mass value="0"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>'


def robot(base: str, trunk: str, weld: str = "fixed") -> str:
    axis = '<axis xyz="0 0 1"/>' if weld != "fixed" else ""
    return f"""<robot name="r">
    <link name="base"><inertial>{base}</inertial></link>
    <link name="trunk"><inertial>{trunk}</inertial></link>
    <link name="leg"><inertial><mass value="1"/></inertial></link>
    <joint name="weld" type="{weld}"><parent link="base"/><child link="trunk"/>{axis}
      <origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 2"/></joint>
    <joint name="hip" type="continuous"><parent link="trunk"/><child link="leg"/></joint></robot>"""


def written(tmp_path: Path, text: str) -> Path:
    (tmp_path / "r.urdf").write_text(text, encoding="utf-8")
    return tmp_path / "r.urdf"


@pytest.mark.mends("30.robots.5")
def test_a_placeholder_that_is_welded_to_a_good_body_is_read(tmp_path: Path) -> None:
    scene = read(written(tmp_path, robot(PLACEHOLDER, GOOD)), floating_base="floating")

    assert [body.name for body in scene.bodies] == ["base", "trunk", "leg"]


@pytest.mark.mends("30.robots.5")
@pytest.mark.parametrize(("trunk", "weld"), [(GOOD, "continuous"), (EMPTY, "fixed")])
def test_a_placeholder_alone_breaks_the_triangle_inequality_and_not_by_rounding(
    trunk: str, weld: str, tmp_path: Path
) -> None:
    with pytest.raises(SceneError, match=r"I1 = 0, I2 = 0, I3 = 3e-06 break the triangle .* by 100 %"):
        read(written(tmp_path, robot(PLACEHOLDER, trunk, weld)), floating_base="floating")


def test_an_inertia_that_overflows_on_the_way_to_the_common_centre_is_told(tmp_path: Path) -> None:
    huge = '<mass value="1"/><inertia ixx="1" iyy="1.797e308" izz="1" ixy="0" ixz="0" iyz="0"/>'
    with pytest.raises(SceneError, match="beyond the largest double"):
        read(written(tmp_path, robot(huge, GOOD)), floating_base="floating")


@pytest.mark.mends("30.robots.5")
@pytest.mark.parametrize(
    "moments",
    [
        "-5.42101e-20 -5.42101e-20 0 0 0 0",
        "1.10961e-18 0 0 5.42101e-20 -5.42101e-20 8.47033e-22",
        "0 4.07592e-18 0 0 0 -2.71051e-20",
    ],
)
def test_moments_below_what_anybody_can_weigh_are_rounding(moments: str, tmp_path: Path) -> None:
    values = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), moments.split(), strict=True)
    inertia = " ".join(f'{key}="{value}"' for key, value in values)
    light = f'<mass value="1e-10"/><inertia {inertia}/>'

    assert read(written(tmp_path, robot(light, GOOD, "continuous")), floating_base="floating").bodies


def test_what_is_welded_to_the_ground_moves_nowhere(tmp_path: Path) -> None:
    assert read(written(tmp_path, robot(EMPTY, PLACEHOLDER))).bodies


TWO = """
[bodies.a]
mass = {m[0]}
com = {c[0]}
inertia = {I[0]}
inertia_about = "com"
[bodies.b]
mass = {m[1]}
com = {c[1]}
inertia = {I[1]}
inertia_about = "com"
[joints.hinge]
type = "revolute"
parent = "ground"
child = "a"
[joints.weld]
type = "fixed"
parent = "a"
child = "b"
origin = {{ xyz = {p}, rpy = {rpy} }}
"""

ONE = """
[bodies.a]
mass = {m}
com = {c}
inertia = {I}
inertia_about = "com"
[joints.hinge]
type = "revolute"
parent = "ground"
child = "a"
"""


def turned(roll: float, pitch: float, yaw: float) -> np.ndarray:
    (a, b, c), (d, e, f) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    x = np.array([[1, 0, 0], [0, a, -d], [0, d, a]])
    y = np.array([[b, 0, e], [0, 1, 0], [-e, 0, b]])
    z = np.array([[c, -f, 0], [f, c, 0], [0, 0, 1]])
    return z @ y @ x


def says(text: str) -> bool:
    """Tell whether a scene is read; whatever else is wrong with it fails."""
    try:
        return isinstance(read_text(text), Scene)
    except SceneError as fault:
        assert "is not physically consistent" in str(fault)  # noqa: PT017
        return False


@pytest.mark.parametrize("seed", range(40))
def test_two_bodies_that_are_welded_are_judged_as_the_one_that_they_make(seed: int) -> None:
    """The first is any matrix, the second that of point masses; 15 of the 40 pairs make one that can be."""
    random = np.random.default_rng(seed)
    m, c, p = random.uniform(0.1, 2, 2), random.uniform(-0.5, 0.5, (2, 3)), random.uniform(-0.5, 0.5, 3)
    rpy = random.uniform(-2, 2, 3)
    any_matrix, points = random.uniform(-0.15, 0.3, (3, 3)), random.uniform(-0.5, 0.5, (4, 3))
    first = (any_matrix + any_matrix.T) / 2
    second = sum((r @ r) * np.eye(3) - np.outer(r, r) for r in points) / 4
    R = turned(*rpy)
    places = np.array([c[0], R @ c[1] + p])
    centre = m @ places / sum(m)
    merged = first + R @ second @ R.T
    for mass, d in zip(m, places - centre, strict=True):
        merged = merged + mass * ((d @ d) * np.eye(3) - np.outer(d, d))
    two = TWO.format(m=m, c=c.tolist(), I=[first.tolist(), second.tolist()], p=p.tolist(), rpy=rpy.tolist())

    assert says(two) == says(ONE.format(m=sum(m), c=centre.tolist(), I=((merged + merged.T) / 2).tolist()))


def test_hundreds_of_placeholders_are_judged_together() -> None:
    bad = 'mass = 1e-6\ncom = [0, 0, 0]\ninertia = [1e-6, 1e-6, 3e-6]\ninertia_about = "com"\n'
    links = "".join(
        f'[bodies.b{i}]\n{bad}[joints.j{i}]\ntype = "fixed"\nparent = "{f"b{i - 1}" if i else "a"}"\nchild = "b{i}"\n'
        for i in range(300)
    )

    assert len(read_text(ONE.format(m=1, c=[0, 0, 0], I=[1, 1, 1]) + links).bodies) == 301

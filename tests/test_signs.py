"""Directions, signs and points that results state, against numbers that were worked out by hand."""

from __future__ import annotations

import math

import pytest

from symdyn.draw import acting_on
from symdyn.scene import read_text


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("kind", ["spherical", "free", "point_on_line", "point_on_plane", "revolute", "planar"])
def test_a_drive_acts_along_what_its_velocity_turns_or_moves(kind: str, sense: int) -> None:
    """Drives of quaternions, which are no coordinates, were left out."""
    axis, half = ("" if kind in ("spherical", "free") else f"axis = [0, {sense}, 0]"), math.sqrt(0.5)
    text = f"""
    [bodies.b]
    mass = 1
    [joints.j]
    type = "{kind}"
    parent = "ground"
    child = "b"
    origin = [["Rz", "pi/2"]]
    {axis}
    """
    e = [half, half, 0, 0]  # a quarter turn about x, which the origin has turned to y: columns y, z, x
    moved = [(0, 1, 0), (0, 0, 1), (1, 0, 0)]
    along, (x, y) = (-sense, 0, 0), ((0, 1, 0), (0, 0, -sense))
    q, forces, couples = {
        "spherical": (e, [], moved),
        "free": ([0, 0, 0, *e], moved, moved),
        "point_on_line": ([0, *e], [along], moved),
        "point_on_plane": ([0, 0, *e], [x, y], moved),
        "revolute": ([0.3], [], [along]),
        "planar": ([0, 0, 0.3], [x, y], [along]),
    }[kind]
    drives = [w for w in acting_on(read_text(text), "b", q) if r"\tau" in w.name]

    expected = [*((w, (0, 0, 0)) for w in forces), *(((0, 0, 0), w) for w in couples)]
    assert [(w.force, w.couple) for w in drives] == [(pytest.approx(f), pytest.approx(m)) for f, m in expected]


def test_the_drive_of_a_bead_acts_along_its_wire() -> None:
    """It was drawn along the first of the joint's steps."""
    text = """
    [bodies.bead]
    mass = 1
    [joints.wire]
    type = "custom"
    parent = "ground"
    child = "bead"
    coordinate = "u"
    units = ["m"]
    drive = "F"
    steps = [["Tx", "u"], ["Ty", "u**2/2"]]
    """
    (drive,) = [w for w in acting_on(read_text(text), "bead", [0.75]) if w.name == "F"]

    assert drive.force == pytest.approx((0.8, 0.6, 0))

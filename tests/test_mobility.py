"""Mobility by (5.20), loop by loop and by rank; what is said where they differ, and about drives and idle motions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from closed_mechanisms import along_x, bricard, crank_rocker, exact, hinge, n_four_bar, rod, rssr, slider_crank

from symdyn.dynamics.loops.mobility import mobility
from symdyn.scene import Scene, read
from symdyn.scene.values import Body, Joint
from symdyn.scene.values.quantity import Quantity


@pytest.mark.parametrize(
    ("scene", "spatial", "by_loops", "by_rank"),
    [
        (crank_rocker(), -2, 1, 1),
        (slider_crank(), -2, 1, 1),
        (n_four_bar(3), -8, 1, 1),
        (rssr(), 2, 2, 2),
        (bricard(), 0, 0, 1),
    ],
    ids=lambda x: x.name if isinstance(x, Scene) else None,
)
def test_mobility_by_counting_in_space_by_loops_and_by_rank(
    scene: Scene, spatial: int, by_loops: int, by_rank: int
) -> None:
    found = mobility(scene)

    assert (found.spatial, found.by_loops, found.by_rank) == (spatial, by_loops, by_rank)


def test_a_planar_loop_tells_its_indeterminate_reactions() -> None:
    found = mobility(crank_rocker())

    assert found.planar == ("C",)
    assert found.redundant == ("C: force along z", "C: moment about x", "C: moment about y")
    assert found.not_unique == found.redundant
    assert found.notes == (
        "planar: C; counted in space (5.20) gives -2, in the plane 1; 3 reactions out of the plane are indeterminate",
    )


def test_bricards_redundant_constraint_is_named() -> None:
    found = mobility(bricard())

    assert len(found.redundant) == 1
    assert found.redundant[0].startswith("J5: ")
    assert set(found.redundant) < set(found.not_unique)
    assert found.notes[0].startswith("overconstrained: 1 by rank, 0 by counting; redundant: J5: ")


def test_the_spin_of_an_rssr_coupler_is_idle_and_not_under_driven() -> None:
    found = mobility(rssr())

    assert found.idle == ("coupler spins about the line of its joints",)
    assert len(found.drives) == 1
    assert found.notes == ("idle: coupler spins about the line of its joints; it needs no drive",)


def test_a_pendulum_beside_a_loop_is_no_idle_motion() -> None:
    scene = crank_rocker()
    bob = hinge("P", "coupler", "bob", along_x(Quantity.ONE))
    more = replace(
        scene,
        bodies=(*scene.bodies, Body("bob", Quantity.ONE, (Quantity.ONE, Quantity.ZERO, Quantity.ZERO))),
        joints=(*scene.joints, bob),
    )
    found = mobility(more)

    assert found.by_rank == 2
    assert found.idle == ()
    assert found.notes[-1] == "underactuated: 1 drive (tau) for 2 degrees of freedom; q_P_dot is passive"


def test_an_over_driven_mechanism_is_told_how_many_drives_are_too_many() -> None:
    scene = crank_rocker()
    joints = tuple(replace(joint, drives=(f"tau_{joint.name}",)) for joint in scene.joints)

    notes = mobility(replace(scene, joints=joints)).notes
    assert any(
        "over-actuated, 3 drives (tau_A of A, tau_B of B, tau_D of D) for 1 degree of freedom; leave 2 of them" in n
        for n in notes
    )


def test_a_change_point_has_more_freedoms_itself_than_round_about() -> None:
    """A square of four equal bars, folded flat."""
    scene = n_four_bar(1)
    starts = (exact(0), exact(0), exact(0))
    joints = tuple(replace(joint, start=(x,)) for joint, x in zip(scene.joints, starts, strict=True))
    found = mobility(replace(scene, joints=joints))

    assert (found.by_rank, found.here) == (1, 2)
    assert any(note.startswith("change point: at the assembled position itself 2") for note in found.notes)
    assert any("the loop C1 is at a change point" in note for note in found.notes)


def test_a_triangle_of_bars_is_a_structure() -> None:
    scene = Scene(
        "triangle",
        bodies=(rod("left", Quantity.ONE, Quantity.ONE), rod("right", Quantity.ONE, Quantity.ONE)),
        joints=(
            hinge("A", "ground", "left", start=(exact(1),)),
            hinge("B", "ground", "right", along_x(Quantity.ONE), start=(exact(2),)),
        ),
        loops=(
            Joint("C", "revolute", "left", "right", (), along_x(Quantity.ONE), tip=_back()),
        ),
    )  # fmt: skip
    found = mobility(scene)

    assert found.by_rank == 0
    assert "the loops leave no degree of freedom: it is a structure" in found.notes


def _back() -> object:
    return replace(along_x(Quantity.ONE), steps=(("Tx", exact(-1)),))


def test_every_component_of_a_rolling_contact_is_counted() -> None:
    found = mobility(read(Path(__file__).parent.parent / "examples" / "rolling_disc.toml"))

    assert (found.spatial, found.by_loops, found.by_rank) == (3, 3, 3)

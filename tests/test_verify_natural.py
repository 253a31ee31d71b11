"""What verify says of reactions: planted faults are seen, at random places or at natural ones; words and masks."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from arms import EXAMPLES
from closed_mechanisms import bricard, crank_rocker, n_four_bar, slider_crank

import symdyn
from symdyn.cli import main
from symdyn.dynamics import Workspace, derive, reactions_at, unique_reactions
from symdyn.dynamics.loops.mobility import mobility
from symdyn.dynamics.loops.partition import LoopBlock, Partition, blocks
from symdyn.verdict import Verdict
from symdyn.verify.equality import prove
from symdyn.verify.laws import laws
from symdyn.verify.natural_positions import forward_findings, natural_places, reaction_findings

ties_room = import_module(
    "symdyn.dynamics.reactions.closure_equations"
)  # a name that its package offers for something else

DATA = Path(__file__).parent / "data"


def scene_of(name):
    return symdyn.read(next(path for path in (DATA / f"{name}.toml", DATA / "found" / f"{name}.toml") if path.exists()))


def found_naturally(scene):
    return findings_of(Workspace(scene))


def findings_of(w):
    forward, absent = forward_findings(w)
    return [*forward, *reaction_findings(w)[0]], absent


# Natural positions


@pytest.mark.wide(2)
@pytest.mark.heavy("bicycle")
@pytest.mark.long
@pytest.mark.parametrize(
    "scene",
    [
        *map(scene_of, ("rolling_disc_zxy", "bicycle", "three_cranks", "ball_in_a_plane", "dead_centre", "offset_rod")),
        crank_rocker(),
        slider_crank(),
        bricard(),
        n_four_bar(2),
    ],
    ids=lambda one: one.name,
)
def test_closed_mechanisms_are_right_at_natural_positions(scene):
    findings, _ = found_naturally(scene)

    assert [one.claim.partition(":")[0] for one in findings] == ["forward dynamics", "forward_reactions", "reactions"]
    assert {(one.verdict, one.degree) for one in findings} == {(Verdict.NUMERICAL, 0)}
    assert all(one.entries for one in findings)


def test_natural_positions_are_closed_and_each_is_another():
    w = Workspace(scene_of("bicycle"))
    places = dict(natural_places(w))

    assert {"the start", "lean = 0", "equal angles"} <= places.keys()
    assert places["lean = 0"][4] == pytest.approx(0, abs=1e-12)
    assert places["lean = 0"][3] != 0
    for q in places.values():
        assert np.abs(w.loops.numbers.residual(q)).max() < 1e-9


def test_rows_picked_beforehand_are_seen_at_natural_positions_and_nowhere_else(monkeypatch):
    """λ of a disc from three of its six equations: right wherever they are independent, and no proof knows better."""
    scene = scene_of("rolling_disc_zxy")
    monkeypatch.setattr(ties_room, "blocks", lambda uses: [LoopBlock((0, 1, 2), (0, 3, 4))])
    findings, _ = found_naturally(scene)
    claims = [one for one in laws(Workspace(scene), ("reactions",)) if one.name == "reactions"]

    assert {one.verdict for one in prove(claims)[1]} == {Verdict.PROVED}  # wherever the three are independent
    (wrong,) = [one for one in findings if one.verdict == Verdict.DIFFERENT]
    assert wrong.claim.startswith("reactions: at ")
    assert "q1 = 0" in wrong.claim


@pytest.mark.parametrize("name", ["oblique_contact", "offset_rod"])
def test_a_wrench_cut_to_a_plane_is_seen_everywhere(monkeypatch, name):
    def cut(hanging, loop, twists):
        normal = ties_room.plane(hanging, loop, twists)
        return tuple(ties_room.flattened(loop.wrenches, normal))

    monkeypatch.setattr(ties_room, "taken_wrenches", cut)
    scene = scene_of(name)
    findings, _ = found_naturally(scene)
    claims = [
        one
        for one in laws(Workspace(scene), ("reactions", "forward_dynamics", "multipliers"))
        if "5.18" in one.right_name
    ]

    assert [one.verdict for one in prove(claims)[1]] == [Verdict.DIFFERENT, Verdict.DIFFERENT]
    assert {one.claim.partition(":")[0] for one in findings if one.verdict == Verdict.DIFFERENT} == {
        "reactions",
        "forward_reactions",
    }


@pytest.mark.runs
def test_a_position_without_forward_dynamics_is_told():
    """At its dead centre a slider says nothing of the crank."""
    scene = slider_crank()
    w = Workspace(scene, symdyn.dynamics.LoopChoices(("x",)))
    findings, absent = findings_of(w)

    assert {one.verdict for one in findings} == {Verdict.NUMERICAL}
    (told,) = absent
    assert told.what.startswith("forward dynamics at ")
    assert "there x_dot do not determine the other velocities: the columns of these have rank 1 of 2" in told.why


# What rigid bodies do not tell


def test_the_mask_is_that_of_the_null_space_in_every_axes():
    scene = scene_of("ball_in_a_plane")
    w = Workspace(scene)
    q = np.array(w.loops.decisions.assembly.configurations[0])

    assert (unique_reactions(scene) == reactions_at(scene, q).unique).all()
    assert (~unique_reactions(scene, "ground")).sum(axis=1).tolist() == [3, 3, 3, 1]
    assert not (unique_reactions(scene, "joint")[3, :3]).any()  # its joint frame leans
    assert unique_reactions(symdyn.read(EXAMPLES / "two_link.toml")).all()


@pytest.mark.runs
def test_names_of_loose_entries_are_in_texts_headers_and_info(tmp_path, capsys):
    path = str(EXAMPLES / "four_bar.toml")
    words = "fz, mx, my of motor, elbow, pivot and hinge"
    function = derive(symdyn.read(path), ["reactions"])["reactions"]

    assert function.text.endswith(f"not unique, statically indeterminate: {words}")
    assert function.unique == (True, True, False, False, False, True) * 4
    assert main(["info", path]) == 0
    assert f"reactions that are not unique, axes of the child: {words}" in capsys.readouterr().out
    assert main(["simulate", path, "--until", "0.01", "--every", "0.01", "--reactions"]) == 0
    header = capsys.readouterr().out.partition("\n")[0].split(",")
    assert {"reaction_motor_fx", "reaction_motor_fz_not_unique", "reaction_hinge_my_not_unique"} <= set(header)


def test_three_cranks_have_reactions_and_they_are_named():
    """A plate on three parallel cranks: which of them pulls along the others nobody can tell."""
    scene = scene_of("three_cranks")
    unique = unique_reactions(scene, "ground")

    assert not unique[:, :5].any()
    q = np.array(Workspace(scene).loops.decisions.assembly.q)
    R = symdyn.lambdify(scene, "reactions")(q, np.zeros(4), np.zeros(4))
    assert np.isfinite(R).all()


@pytest.mark.runs
def test_simulated_reactions_of_too_many_drives_are_those_of_the_drives(capsys):
    assert main(["simulate", str(DATA / "found" / "two_motors.toml"), "--until", "0.01", "--reactions"]) == 0
    assert "reaction_pin_fx" in capsys.readouterr().out


# What numbers decide


def test_digits_that_somebody_left_out_are_no_constraint():
    """Four digits of a position: the redundancy of the linkage, not that of the numbers."""
    w = Workspace(bricard())
    exact = np.array(w.loops.decisions.assembly.configurations[0])
    found = reactions_at(bricard(), np.round(exact, 4))

    assert found.redundancy == 1
    assert found.rank == found.general
    assert not found.open
    np.testing.assert_allclose(found.wrenches, reactions_at(bricard(), exact).wrenches, atol=2e-2)


def test_an_open_loop_and_a_change_point_are_told():
    far = reactions_at(crank_rocker(), [0.8, 0.1, 1.0])
    flat = n_four_bar(1)
    joints = tuple(replace(joint, start=(symdyn.scene.Quantity.number(0),)) for joint in flat.joints)
    folded = reactions_at(replace(flat, joints=joints), [0.0, 0.0, 0.0])

    assert any(line.startswith("the loops are not closed here") for line in far.words)
    assert folded.general > folded.rank
    assert any(line.startswith("change point: the equations have rank") for line in folded.words)


def test_a_door_on_two_hinges_opens():
    """All its levers are rounding: that is no length to measure constraints with."""
    found = mobility(scene_of("door"))

    assert (found.by_rank, found.here) == (1, 1)


def test_a_piston_that_starts_at_its_dead_centre_has_inverse_dynamics():
    scene = scene_of("dead_centre")
    w = Workspace(scene)

    assert w.loops.decisions.actuated is not None
    assert derive(scene, ["inverse_dynamics"]).functions


# Blocks with more equations than unknowns


def test_velocities_left_over_are_solved_with_in_least_squares():
    """λ0 is told by velocity 0 alone; λ1 and λ2 by velocities 1, 2, 3 together."""
    uses = [[0, 1], [1, 2], [2, 3]]
    assert blocks(uses) == [LoopBlock((0,), (0,)), LoopBlock((1, 2), (1, 2, 3))] or blocks(uses) == [
        LoopBlock((0, 1, 2), (0, 1, 2, 3))
    ]
    assert blocks([[0], [0, 1, 2]]) == [LoopBlock((0,), (0,)), LoopBlock((1,), (1, 2))]

    g = symdyn.graph.Graph()
    zero, two, three = g.zero, g.constant(2), g.constant(3)
    G = [[two, zero, zero], [g.one, three, g.one]]
    partition = Partition((), (0, 1, 2), (LoopBlock((0,), (0,)), LoopBlock((1,), (1, 2))))
    x = partition.solve_transposed(G, list(map(g.symbol, "abc")))
    values = dict(zip(map(g.symbol, "abc"), (2 * 5 + 7, 3 * 7, 7), strict=True))
    from symdyn.algebra.numeric import Floats
    from symdyn.graph import evaluate

    assert evaluate(x, Floats(), values) == pytest.approx([5, 7])

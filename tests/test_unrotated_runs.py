"""Runs of parallel axes on a joint of the ground: what they are, and that both ways to M give the same M."""

from __future__ import annotations

import pytest

from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.recursive.crba import crba, crba_in_runs, unrotated_runs
from symdyn.dynamics.recursive.tree_dynamics import rnea
from symdyn.scene import Scene, read_text
from symdyn.verify.equality import Claim, prove

ACROSS, ALONG, AGAINST = (0, 1, 0), (0, 0, 1), (0, 0, -1)


def arm(axis: tuple[int, ...], last: str) -> Scene:
    """Return four joints: about an axis, about two that are parallel, and across them."""
    axes = (axis, ALONG, ALONG, (1, 0, 0))
    parts = ['name = "arm"']
    for k, one in enumerate(axes, start=1):
        inertia = f"{{ xx = 1, yy = 1.{k}, zz = 1.2, xy = 0.1, xz = 0.1, yz = 0.2 }}"
        kind, parent = last if k == len(axes) else "revolute", f"b{k - 1}" if k > 1 else "ground"
        parts += [
            f'[bodies.b{k}]\nmass = {k}\ncom = [0.{k}, 0.2, 0.3]\ninertia = {inertia}\ninertia_about = "com"',
            f'[joints.j{k}]\ntype = "{kind}"\nparent = "{parent}"\nchild = "b{k}"\naxis = {[*one]}',
            f"origin = [0.{k}, 0.3, 0.1]",
        ]
    return read_text("\n".join(parts))


@pytest.mark.parametrize("last", ["revolute", "prismatic"])
@pytest.mark.parametrize("axis", [ACROSS, ALONG, AGAINST])
def test_every_way_to_the_mass_matrix_gives_the_same_one(axis, last):
    w = Workspace(arm(axis, last))
    wanted = [x for row in w.lagrange_mass for x in row]
    claims = [
        Claim("M", way.__name__, "lagrange", [x for row in way(w.reduced) for x in row], wanted)
        for way in (crba, crba_in_runs)
    ]

    assert {one.verdict for one in prove(claims, seed=1)[1]} == {"proved"}


@pytest.mark.parametrize(("axis", "joints"), [(ACROSS, {2, 3}), (ALONG, set()), (AGAINST, set())])
def test_a_run_has_unrotated_axes_where_the_ground_s_axis_lies_across_it(axis, joints):
    assert set(unrotated_runs(Workspace(arm(axis, "revolute")).reduced)) == joints


@pytest.mark.parametrize("last", ["revolute", "prismatic"])
@pytest.mark.parametrize("axis", [ACROSS, ALONG, AGAINST])
def test_driving_forces_are_the_same_whether_last_bodies_turn_with_their_joints_or_not(axis, last):
    w = Workspace(arm(axis, last))
    wanted = derive_one(w, "inverse_dynamics", "lagrange").entries
    claims = [
        Claim("tau", f"unrotated={tree is w.recursion_tree}", "lagrange", rnea(tree, w.state.qd, w.state.qdd), wanted)
        for tree in (w.reduced, w.recursion_tree)
    ]

    assert (w.recursion_tree.X[4] is not w.reduced.X[4]) == (last == "revolute")
    assert {one.verdict for one in prove(claims, seed=1)[1]} == {"proved"}

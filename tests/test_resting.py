"""Origins at rest: which axes have one, and that forces and M are those of Lagrange's equations."""

from __future__ import annotations

import pytest

from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.recursive.reduced_tree import reframe, regroup, resting
from symdyn.scene import Scene, read_text
from symdyn.verify.equality import Claim, prove

AXES = ((0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 1, 0))


def shoulder(aside: float, kind: str = "revolute") -> Scene:
    """Return an arm whose first axes meet in a point where `aside` is zero; the fourth joint is across the third."""
    origins = ([0.1, 0.2, 0.3], [0, 0, 0.5], [0, 0, aside], [0.7, 0, 0.2])
    parts = ['name = "shoulder"', "gravity = [0.3, 0.1, -9.81]"]
    for k, (axis, origin) in enumerate(zip(AXES, origins, strict=True), start=1):
        inertia = f"{{ xx = 1, yy = 1.{k}, zz = 1.2, xy = 0.1, xz = 0.1, yz = 0.2 }}"
        moves = kind if k == 3 else "revolute"
        parts += [
            f'[bodies.b{k}]\nmass = {k}\ncom = [0.{k}, 0.2, 0.3]\ninertia = {inertia}\ninertia_about = "com"',
            f'[joints.j{k}]\ntype = "{moves}"\nparent = "{f"b{k - 1}" if k > 1 else "ground"}"\nchild = "b{k}"',
            f"axis = {[*axis]}\norigin = {[*origin]}",
        ]
    return read_text("\n".join(parts))


@pytest.mark.parametrize(("aside", "kind", "rise"), [(0, "revolute", 0), (0.1, "revolute", 1), (0, "prismatic", 1)])
def test_an_origin_waits_where_its_axis_meets_those_below(aside, kind, rise):
    w = Workspace(shoulder(aside, kind))
    before = regroup(reframe(w.tree))

    assert not before.X[3].offset.is_zero
    assert resting(before).X[3].offset.is_zero == (rise == 0)


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("aside", [0, 0.1])
def test_forces_and_mass_matrix_are_those_of_lagrange(aside, kind):
    w = Workspace(shoulder(aside, kind))
    rows = [x for row in w.composite_mass for x in row], [x for row in w.lagrange_mass for x in row]
    forces = w.forces(list(w.state.qdd)), derive_one(w, "inverse_dynamics", "lagrange").entries
    claims = [Claim("M", "crba", "lagrange", *rows), Claim("tau", "rnea", "lagrange", *forces)]

    assert {one.verdict for one in prove(claims, seed=1)[1]} == {"proved"}

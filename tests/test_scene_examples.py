"""The example scenes say what their sources say."""

import json
from fractions import Fraction
from pathlib import Path

import pytest

from symdyn.algebra.numeric import Floats
from symdyn.dynamics.loops.mobility import mobility
from symdyn.dynamics.mechanism.state import State, body_placements
from symdyn.errors import SceneError
from symdyn.graph import Expr, Graph, evaluate, substitute
from symdyn.scene import Quantity, Scene, read, read_text, with_symbolic_inertia
from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.joint_table import start_of
from symdyn.scene.scene_files import Starter

ROOT = Path(__file__).parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))
PUMA = json.loads((ROOT / "tests" / "data" / "puma560_corke.json").read_text())


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_example_reads_and_is_named_after_its_file(path):
    assert read(path).name == path.stem
    assert len(with_symbolic_inertia(read(path)).bodies) == len(read(path).bodies)


def test_all_the_promised_examples_are_there():
    promised = {"arm7", "cart_pole", "double_pendulum", "pendulum", "puma560", "scara", "two_link"}
    promised |= {"four_bar", "slider_crank", "spatial_slider_crank", "rssr", "rsup", "governor", "heavy_top"}
    promised |= {"free_body", "rolling_disc", "cart_with_wheel", "gripper2", "quadruped", "bicycle", "spatial_3r"}

    assert promised <= {path.stem for path in EXAMPLES}


CLOSED = [path for path in EXAMPLES if read(path).loops]

FREEDOMS = {"four_bar": 1, "slider_crank": 1, "spatial_slider_crank": 2, "rssr": 2, "rsup": 1, "governor": 2}
"""Of RSSR and R-S-S-P one is the idle spin of the rod; of the governor one is that of the spindle."""


def residuals(scene: Scene) -> list[float]:
    """Return the residual of every loop where the scene starts, all parameters at their values; m or 1."""
    graph = Graph()
    state, poses = State.of(scene, graph), body_placements(scene, graph)
    known = {p.name: p.value.express(graph) for p in scene.parameters if p.value is not None}
    at = dict(zip(state.q, (x.express(graph) for x in start_of(scene).position), strict=True))
    entries: list[Expr] = []
    for loop in scene.loops:
        there = poses[loop.parent] @ loop.origin.transform(graph)
        here = poses[loop.child] @ loop.tip.inverse().transform(graph)
        entries += JOINTS[loop.type].forbids.residual(loop, there.inverse() @ here)
    placed = substitute(substitute(entries, at), {graph.symbol(name): x for name, x in known.items()})
    return evaluate(placed, Floats(), {})


@pytest.mark.parametrize("path", CLOSED, ids=lambda path: path.stem)
def test_a_mechanism_with_loops_starts_assembled(path):
    assert residuals(read(path)) == pytest.approx([0] * len(residuals(read(path))), abs=1e-15)


@pytest.mark.parametrize("path", CLOSED, ids=lambda path: path.stem)
def test_a_mechanism_has_the_freedoms_that_its_first_lines_say(path):
    assert mobility(read(path)).by_rank == FREEDOMS[path.stem]


def test_the_four_bar_starts_where_its_reactions_are_known():
    """Numbers of an independent program, at 60 digits; angles of coupler and rocker from the x axis."""
    start = [float(x.at({})) for x in start_of(read(ROOT / "examples" / "four_bar.toml")).position]

    assert start == pytest.approx([0.8, 0.9420089234527959928 - 0.8, 2.0260131545490214846], rel=1e-15)


def test_the_disc_begins_to_roll_without_slip():
    """v = r ω along the ground, and the lowest point of the leaning disc touches it."""
    disc = read(ROOT / "examples" / "rolling_disc.toml")
    z, w, x = (entry.at({"r": 0.3}) for entry in (*start_of(disc).position[2:3], *start_of(disc).position[3:5]))
    v, _, _, _, turn, _ = (entry.at({"r": 0.3}) for entry in start_of(disc).velocity)

    assert z == pytest.approx(0.3 * (1 - 2 * x * x))
    assert w * w + x * x == pytest.approx(1)
    assert v == pytest.approx(0.3 * turn)


def test_n_four_bars_in_a_row():
    row = read_text(Starter("row").from_template("n_four_bar", 40))

    assert (len(row.bodies), len(row.loops), len(row.coordinates)) == (81, 40, 81)
    assert residuals(read_text(Starter("row").from_template("n_four_bar", 3))) == [0] * 15


@pytest.mark.parametrize(("template", "n"), [("chain", 1025), ("n_four_bar", 1001), ("n_four_bar", 0)])
def test_a_starter_has_a_largest_n(template, n):
    with pytest.raises(SceneError, match=f"n = {n} is out of range; {template} takes 1 to"):
        Starter("x").from_template(template, n)


@pytest.mark.parametrize(
    ("name", "template"),
    [
        ("cart_pole", "cart_pole"),
        ("puma560", "puma"),
        ("arm7", "arm7"),
        ("four_bar", "four_bar"),
        ("slider_crank", "slider_crank"),
    ],
)
def test_examples_that_are_starters_are_their_text(name, template):
    assert (ROOT / "examples" / f"{name}.toml").read_text() == Starter(name).from_template(template)


def test_two_link_is_example_5_28():
    two_link = read(ROOT / "examples" / "two_link.toml")

    assert [p.name for p in two_link.free_parameters] == ["m1", "m2", "h1", "h2", "g"]
    assert all(p.positive and p.unit for p in two_link.parameters)
    assert two_link.gravity == (Quantity.number(0), -Quantity.symbol("g"), Quantity.number(0))
    assert two_link.coordinates == ("q1", "q2")
    assert [j.drive for j in two_link.joints] == ["M1", "M2"]
    assert [b.particles[0].mass for b in two_link.bodies] == [Quantity.symbol("m1"), Quantity.symbol("m2")]
    assert [b.particles[0].at[1] for b in two_link.bodies] == [-Quantity.symbol("h1"), -Quantity.symbol("h2")]


def test_puma_has_the_published_numbers():
    puma = read(ROOT / "examples" / "puma560.toml")
    assert len(puma.bodies) == len(PUMA["links"])
    for body, joint, row in zip(puma.bodies, puma.joints, PUMA["links"], strict=True):
        placed = dict(joint.origin.steps + joint.tip.steps)
        assert body.mass == Quantity.number(Fraction(row["m"]))
        assert body.com == tuple(Quantity.number(Fraction(x)) for x in row["r"])
        xx, yy, zz, xy, yz, xz = (Quantity.number(Fraction(x)) for x in row["I"])
        assert body.inertia == (xx, yy, zz, xy, xz, yz)
        assert placed.get("Tz", Quantity.number(0)) == Quantity.number(Fraction(row["d"]))
        assert placed.get("Tx", Quantity.number(0)) == Quantity.number(Fraction(row["a"]))
        assert ("Rx" in placed) == (float(row["alpha"]) != 0)


def test_only_the_puma_asks_for_inertias_that_no_body_has():
    excused = {path.stem: [b.name for b in read(path).bodies if b.allow_invalid_inertia] for path in EXAMPLES}

    assert excused.pop("puma560") == ["link1", "link3"]
    assert not any(excused.values())

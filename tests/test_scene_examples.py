"""The example scenes say what their sources say."""

import json
from fractions import Fraction
from pathlib import Path

import pytest

from symdyn.scene import number, read, with_symbolic_inertia
from symdyn.scene.quantity import symbol
from symdyn.scene.starters import starter

ROOT = Path(__file__).parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))
PUMA = json.loads((ROOT / "tests" / "data" / "puma560_corke.json").read_text())


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_example_reads_and_is_named_after_its_file(path):
    assert read(path).name == path.stem
    assert len(with_symbolic_inertia(read(path)).bodies) == len(read(path).bodies)


def test_all_the_promised_examples_are_there():
    promised = {"arm7", "cart_pole", "double_pendulum", "pendulum", "puma560", "scara", "two_link"}

    assert promised <= {path.stem for path in EXAMPLES}


@pytest.mark.parametrize(("name", "template"), [("cart_pole", "cart_pole"), ("puma560", "puma"), ("arm7", "arm7")])
def test_examples_that_are_starters_are_their_text(name, template):
    assert (ROOT / "examples" / f"{name}.toml").read_text() == starter(name, template)


def test_two_link_is_example_5_28():
    two_link = read(ROOT / "examples" / "two_link.toml")

    assert [p.name for p in two_link.free_parameters] == ["m1", "m2", "h1", "h2", "g"]
    assert all(p.positive and p.unit for p in two_link.parameters)
    assert two_link.gravity == (number(0), -symbol("g"), number(0))
    assert two_link.coordinates == ("q1", "q2")
    assert [j.drive for j in two_link.joints] == ["M1", "M2"]
    assert [b.particles[0].mass for b in two_link.bodies] == [symbol("m1"), symbol("m2")]
    assert [b.particles[0].at[1] for b in two_link.bodies] == [-symbol("h1"), -symbol("h2")]


def test_puma_has_the_published_numbers():
    puma = read(ROOT / "examples" / "puma560.toml")
    assert len(puma.bodies) == len(PUMA["links"])
    for body, joint, row in zip(puma.bodies, puma.joints, PUMA["links"], strict=True):
        placed = dict(joint.origin.steps + joint.tip.steps)
        assert body.mass == number(Fraction(row["m"]))
        assert body.com == tuple(number(Fraction(x)) for x in row["r"])
        xx, yy, zz, xy, yz, xz = (number(Fraction(x)) for x in row["I"])
        assert body.inertia == (xx, yy, zz, xy, xz, yz)
        assert placed.get("Tz", number(0)) == number(Fraction(row["d"]))
        assert placed.get("Tx", number(0)) == number(Fraction(row["a"]))
        assert ("Rx" in placed) == (float(row["alpha"]) != 0)


def test_only_the_puma_asks_for_inertias_that_no_body_has():
    excused = {path.stem: [b.name for b in read(path).bodies if b.allow_invalid_inertia] for path in EXAMPLES}

    assert excused.pop("puma560") == ["link1", "link3"]
    assert not any(excused.values())

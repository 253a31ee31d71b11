"""Reactions exist where it is said on which bodies the force of every row acts: a formula in rates does not say it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.dynamics import derive, reactions_at, unique_reactions
from symdyn.errors import SceneError, SymdynError
from symdyn.scene import Scene, read
from symdyn.scene.scene_files import read_noting, write_text
from symdyn.scene.toml import read_text
from symdyn.simulation import inverse, read_motion, simulate
from symdyn.teach import rendered, walkthrough

ROOT = Path(__file__).parent
CART = ROOT / "data" / "found" / "rolling_cart.toml"
FORMULA = CART.read_text(encoding="utf-8")
BELT = f'{FORMULA.strip()}\nacts_in = "joints"\n'
RIM = FORMULA.replace(
    'formula = "x_dot - r*phi_dot"',
    'type = "rolling"\nbody = "wheel"\naxis = [0, 1, 0]\nradius = "r"\ncomponents = ["along"]',
)
REFUSED = (
    r"there are no reactions: constraints\.slip is a formula in rates, .* type = \"rolling\" .* acts_in = \"joints\""
)


@pytest.mark.mends("30.lessons.1.0")
@pytest.mark.parametrize(("symbol", "expected"), [(r"F_{\mathrm{axle},x}", "−1.4"), (r"M_{\mathrm{track},y}", "0.31")])
def test_a_wheel_that_rolls_is_pushed_at_its_rim(symbol: str, expected: str) -> None:
    """By hand: m a = F_axle + (M + m) a + b v, at M = 10, m = 1, b = 2, v = 0.2, a = 0.1."""
    scene = read(ROOT.parent / "examples" / "cart_with_wheel.toml")
    page = str(next(iter(rendered(walkthrough(scene, formulation="dalembert"), "md").values())))
    rows = [line for line in page.splitlines() if line.startswith(f"| ${symbol}$ | ")]

    assert rows[-1].split(" | ")[1] == expected


@pytest.mark.mends("30.lessons.1.0")
@pytest.mark.parametrize("name", ["reactions", "reactions:joint", "reactions:ground", "forward_reactions"])
def test_a_scene_with_a_formula_in_rates_has_no_reactions(name: str) -> None:
    with pytest.raises(SymdynError, match=REFUSED):
        derive(read(CART), (name,))


@pytest.mark.mends("30.lessons.1.0")
@pytest.mark.runs
def test_no_run_has_columns_of_reactions_then() -> None:
    scene = read(CART)
    with pytest.raises(SymdynError, match=REFUSED):
        inverse(scene, read_motion(scene, ["x=0.1*t"]), np.linspace(0, 1, 3), reactions=True)
    with pytest.raises(SymdynError, match=REFUSED):
        simulate(scene, until=0.1, every=0.1, reactions="ground")


@pytest.mark.mends("30.lessons.1.0")
def test_nor_are_there_lessons_or_equations_by_dalembert(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SymdynError, match=REFUSED):
        walkthrough(read(CART), formulation="dalembert")
    assert main(["equations", str(CART), "--formulation", "dalembert"]) == 1
    assert "there are no reactions: constraints.slip is a formula in rates" in capsys.readouterr().err


@pytest.mark.mends("30.lessons.1.0")
def test_nor_are_there_reactions_at_a_position_or_a_mask_of_those_that_are_unique() -> None:
    for ask in (lambda scene: reactions_at(scene, [0.0, 0.0]), unique_reactions):
        with pytest.raises(SymdynError, match=REFUSED):
            ask(read(CART))


@pytest.mark.mends("30.lessons.1.0")
def test_an_output_of_a_reaction_is_refused_too() -> None:
    scene = read_text(f'{FORMULA}\n[outputs]\npush = "reaction_axle_fx"\nrow = "multiplier_slip"\n')

    with pytest.raises(SymdynError, match=REFUSED):
        derive(scene, ("outputs",))
    with pytest.raises(SymdynError, match=REFUSED):
        symdyn.linearize(scene, outputs=("reaction_axle_fx",))


def measured(text: str) -> dict[str, float]:
    scene = read_text(text)
    found = reactions_at(scene, [0.3, 0.6], [0.2, 1.0], [0.1, 0.5])
    axle, track = (found.wrenches[found.joints.index(name)] for name in ("axle", "track"))
    turn = np.array([[np.cos(0.6), np.sin(0.6)], [-np.sin(0.6), np.cos(0.6)]])  # from the wheel's axes to the cart's
    return {"axle": float((turn @ axle[[0, 2]])[0]), "track": float(track[4])}


def test_where_the_force_acts_decides_what_joints_feel() -> None:
    """The same motion: at the rim friction (M + m) a pushes the wheel; a belt from the ground pushes the cart."""
    assert measured(RIM) == pytest.approx({"axle": -10 * 0.1, "track": 0.2 * 11 * 0.1 + 0.02 * 0.5})
    assert measured(BELT) == pytest.approx({"axle": 1 * 0.1, "track": 0.02 * 0.5})


def test_the_motion_and_the_multiplier_do_not_depend_on_it() -> None:
    state = {"q": np.array([0.3, 0.6]), "qd": np.array([0.2, 1.0]), "tau": np.array([0.0, 0.7])}
    found = []
    for text in (FORMULA, BELT, RIM):
        scene = read_text(text)
        told = [symdyn.lambdify(scene, name)(*state.values()) for name in ("forward_dynamics", "multipliers")]
        found.append(np.concatenate([np.ravel(one) for one in told]))

    assert np.allclose(found, found[0], rtol=1e-12)


@pytest.mark.runs
def test_multipliers_are_measured_without_reactions() -> None:
    values = {}
    for text in (FORMULA, BELT):
        study = symdyn.sweep(
            read_text(text),
            over={"phi": [0.0, 0.3]},
            forces={"T": "0.7"},
            until=0.2,
            measure=("max(abs(multiplier_slip))",),
        )
        values[text] = study["max(abs(multiplier_slip))"]
    assert np.allclose(values[FORMULA], values[BELT])
    assert np.all(np.isfinite(values[FORMULA]))


def test_a_row_that_exerts_nothing_or_says_where_it_acts_stands_in_no_ones_way() -> None:
    for text in (FORMULA.replace("x_dot - r*phi_dot", "0*phi_dot"), BELT, RIM):
        assert unique_reactions(read_text(text)).shape == (2, 6)


def test_every_row_that_does_not_say_it_is_named() -> None:
    text = FORMULA.replace("[constraints.slip]", '[constraints.other]\nformula = "x_dot*sin(phi)"\n[constraints.slip]')
    with pytest.raises(
        SymdynError,
        match=r"constraints\.other, constraints\.slip are formulas in rates, and where the constraint force acts",
    ):
        derive(read_text(text), ("reactions",))


@pytest.mark.parametrize(
    ("formula", "suggested"),
    [
        ("x_dot - r*phi_dot", True),
        ("r*phi_dot + x_dot", True),
        ("x_dot*cos(phi) - r*phi_dot", True),
        ("phi_dot - 0*x_dot", False),
        ("x_dot", False),
    ],
)
def test_the_reader_suggests_rolling_for_a_speed_and_a_turn(formula: str, suggested: bool, tmp_path: Path) -> None:
    for text, expected in ((FORMULA.replace("x_dot - r*phi_dot", formula), suggested), (BELT, False), (RIM, False)):
        file = tmp_path / "scene.toml"
        file.write_text(text, encoding="utf-8")
        notes = read_noting(file).notes
        assert any("constraints.slip" in note and 'type = "rolling"' in note for note in notes) == expected


def test_another_place_of_a_force_is_a_fault() -> None:
    with pytest.raises(
        SceneError, match=r'constraints\.slip: acts_in = "rim" is no place of a force; write acts_in = "joints"'
    ):
        read_text(BELT.replace('"joints"', '"rim"'))


def written(scene: Scene) -> str:
    return write_text(scene, "toml").text


def test_what_a_row_says_is_written_again() -> None:
    scene, silent = read_text(BELT), read(CART)

    assert 'acts_in = "joints"' in written(scene)
    assert read_text(written(scene)) == scene
    assert "acts_in" not in written(silent)


def test_info_and_certificates_say_that_there_are_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(CART)]) == 0
    told = capsys.readouterr().err
    assert "there are no reactions: constraints.slip is a formula in rates" in told
    assert 'type = "rolling"' in told

    assert main(["verify", str(CART), "--targets", "numpy"]) == 0
    told = capsys.readouterr().out
    assert "there are no reactions: constraints.slip is a formula in rates" in told
    assert "power of reactions" not in told

"""`symdyn info` says what was left out and what that saves; values and the choice of a formulation reach all verbs."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import pytest
from arms import EXAMPLES, chain, two_link

from symdyn.cli import main
from symdyn.dynamics import Workspace, available, derive_one
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.outputs import Counts
from symdyn.emit.print.equations_text import equations_text
from symdyn.errors import DerivationError
from symdyn.graph import Op, reachable
from symdyn.program import formulate, lower, prepare, skipped
from symdyn.program.passes import DEFAULT
from symdyn.scene import bind, body, fixed, point, read, revolute, scene
from symdyn.scene.scene_files import Starter
from symdyn.scene.toml import read_text

DOOR = str(Path(__file__).parent / "data" / "door.toml")

Capture = pytest.CaptureFixture[str]


def report(one):
    outputs, _ = available(one)
    return {entry.step: entry for entry in skipped(formulate(one, outputs), outputs)}


def test_the_report_lists_what_a_scene_does_not_need():
    arm = scene(
        "arm",
        bodies=[
            body("a", mass=1, com=[1, 0, 0], inertia=[1, 2, 2], about="com"),
            body("plate", mass=1),
            body("hand"),
            body("far", mass=1, com=[1, 0, 0], inertia=[1, 2, 2], about="com"),
        ],
        joints=[
            revolute("j1", "ground", "a"),
            fixed("weld", "a", "plate", origin=[1, 0, 0]),
            revolute("j2", "plate", "hand", locked=True, position="pi/3"),
            revolute("j3", "hand", "far", origin=[1, 0, 0]),
        ],
        points=[point("tip", "far")],
        gravity=False,
    )
    steps = report(arm)

    assert "plate" in steps["fixed bodies"].why
    assert "j2" in steps["locked joints"].why
    assert "hand" in steps["massless bodies"].why
    assert "q1, q3" in steps["planar scene"].why
    assert steps["planar scene"].saved["mass_matrix"].cost > 0
    assert steps["no gravity"].saved["gravity_forces"].cost > 0
    assert "a" in steps["symmetric inertias"].why


def test_dead_operations_are_those_of_the_chosen_formulations_alone():
    one = two_link()
    (entry,) = (
        e for e in skipped(formulate(one, ["forward_dynamics"]), ["forward_dynamics"]) if e.step.startswith("dead")
    )
    (function,) = formulate(one, ["forward_dynamics"]).functions
    workspace = Workspace(one)
    alive = set(reachable(derive_one(workspace, "forward_dynamics", function.formulation).entries))
    arithmetic = (Op.ADD, Op.SUB, Op.MUL, Op.DIV)

    assert int(entry.why.split()[0]) == sum(n.op in arithmetic and n not in alive for n in workspace.graph.nodes)


def test_a_massless_body_between_two_joints_saves_its_momentum():
    cross = scene(
        "cross",
        bodies=[
            body("near", mass=1, com=[1, 0, 0], inertia=[1, 2, 2], about="com"),
            body("spider"),
            body("far", mass=1, com=[1, 0, 0], inertia=[1, 2, 2], about="com"),
        ],
        joints=[
            revolute("j0", "ground", "near", axis=[0, 1, 0]),
            revolute("j1", "near", "spider", origin=[1, 0, 0]),
            revolute("j2", "spider", "far", axis=[1, 0, 0]),
        ],
    )
    steps = report(cross)

    assert steps["massless bodies"].saved["inverse_dynamics"].cost > 0
    assert steps["symmetric inertias"].saved["inverse_dynamics"].cost > 0


def test_gravity_that_is_bound_to_zero_saves_what_it_would_cost():
    steps = report(bind(two_link(), {"g": 0}))

    assert steps["no gravity"].saved["gravity_forces"].cost > 0
    assert steps["no gravity"].saved["inverse_dynamics"].cost > 0
    assert "mass_matrix" not in steps["no gravity"].saved


def test_a_savings_number_is_the_difference_of_two_counts():
    one = read(EXAMPLES / "puma560.toml")
    outputs = ("inverse_dynamics", "mass_matrix")
    equations = formulate(one, outputs)
    steps = {entry.step: entry for entry in skipped(equations, outputs)}
    saved = sum((steps[name].saved.get("inverse_dynamics", Counts()) for name in DEFAULT), Counts())
    with_passes, without = lower(equations)["inverse_dynamics"], lower(equations, ())["inverse_dynamics"]

    assert saved == without.counts - with_passes.counts
    assert steps["regrouped inertias"].saved["inverse_dynamics"].cost > 0


def test_the_choice_of_a_formulation_is_reported_with_what_it_saves():
    steps = report(read(EXAMPLES / "rssr.toml"))

    assert "k_D by rnea instead of crba" in steps["formulation"].why
    assert steps["formulation"].saved["tree_k_D"].cost > 0
    arm = skipped(formulate(chain(6), ["forward_dynamics"]), ["forward_dynamics"])
    assert "forward_dynamics by aba instead of crba" in [one.why for one in arm if one.step == "formulation"]
    assert report(read(EXAMPLES / "spatial_3r.toml"))["parallel axes"].saved["forward_dynamics"].cost > 0


def test_info_as_json_holds_the_report(capsys: Capture) -> None:
    assert main(["info", str(EXAMPLES / "two_link.toml"), "--bind", "m1=2,m2=1/2", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["result"]
    steps = {one["step"]: one for one in facts["skipped"]}
    functions = {one["name"]: one for one in facts["functions"]}

    assert "m1, m2" in steps["bound parameters"]["why"]
    assert steps["planar scene"]["saved"]["inverse_dynamics"]["multiplications"] > 0
    assert set(functions["inverse_dynamics"]["binding"]) == {"params", "q", "q, qd", "all"}
    parts = functions["inverse_dynamics"]["binding"].values()
    assert sum(part["multiplications"] for part in parts) == (
        functions["inverse_dynamics"]["operations"]["multiplications"]
        + functions["inverse_dynamics"]["prepare"]["multiplications"]
    )


def test_info_for_people_shows_what_was_saved(capsys: Capture) -> None:
    assert main(["info", str(EXAMPLES / "two_link.toml")]) == 0
    out = capsys.readouterr().out

    assert "Left out or merged" in out
    assert "On parameters alone" in out
    assert "planar scene" in out


@pytest.mark.long
def test_info_shows_what_prepare_takes_out_of_a_call(capsys: Capture) -> None:
    assert main(["info", str(EXAMPLES / "two_link.toml"), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["result"]
    outputs, _ = available(two_link())
    first, *rest = prepare(lower(formulate(two_link(), outputs))).routines

    assert facts["prepare"]["values"] == len(first.function.entries)
    assert facts["prepare"]["operations"] == asdict(first.counts)
    assert [function["operations"] for function in facts["functions"]] == [asdict(one.counts) for one in rest]

    assert main(["info", str(EXAMPLES / "two_link.toml")]) == 0
    assert f"prepare, {len(first.function.entries)} values" in capsys.readouterr().out
    assert main(["info", str(EXAMPLES / "puma560.toml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["result"]["prepare"] is None


def test_info_and_generate_take_the_formulation_that_is_asked_for(tmp_path: Path, capsys: Capture) -> None:
    scene_file = str(EXAMPLES / "two_link.toml")
    assert main(["info", scene_file, "--formulation", "lagrange", "--json"]) == 0
    functions = {one["name"]: one["formulation"] for one in json.loads(capsys.readouterr().out)["result"]["functions"]}
    assert functions["inverse_dynamics"] == functions["k_C"] == "lagrange"
    assert functions["pose_tool"] == "recursive"

    words = ["--functions", "forward_dynamics", "--formulation", "aba", "-o", str(tmp_path)]
    assert main(["generate", scene_file, *words]) == 0
    text = (tmp_path / "two_link.py").read_text()
    assert "--functions forward_dynamics --formulation aba" in text
    assert "aba;" in text


@pytest.mark.usefixtures("numpy_alone")
def test_verify_proves_the_formulation_that_is_asked_for(capsys: Capture) -> None:
    words = ["verify", str(EXAMPLES / "two_link.toml"), "--formulation", "aba", "--functions"]
    assert main([*words, "forward_dynamics"]) == 0
    out = capsys.readouterr().out
    assert "forward_dynamics: aba = crba" in out
    assert "forward_dynamics: crba =" not in out

    assert main([*words, "mass_matrix"]) == 1
    assert "no output that was asked for has the formulation 'aba'; there are crba, lagrange" in capsys.readouterr().err


def test_generate_binds_and_stands_still(tmp_path: Path, capsys: Capture) -> None:
    scene_file = str(EXAMPLES / "two_link.toml")
    words = ["--bind", "m1 = 2, g=0", "--static", "--functions", "inverse_dynamics", "-o", str(tmp_path)]

    assert main(["generate", scene_file, *words]) == 0
    text = (tmp_path / "two_link.py").read_text()
    assert "symdyn generate two_link.toml --bind m1=2,g=0 --target numpy --functions inverse_dynamics --static" in text
    assert "def inverse_dynamics(q, qdd, params" in text


@pytest.mark.usefixtures("numpy_alone")
def test_verify_proves_a_bound_scene(capsys: Capture) -> None:
    words = ["--bind", "m1=2,m2=1,h1=1,h2=1/2,g=0", "--functions", "inverse_dynamics"]

    assert main(["verify", str(EXAMPLES / "two_link.toml"), *words]) == 0
    assert "two_link: passed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--bind", "m3=1"], '"m3" is not a parameter'),
        (["--bind", "m1=h1"], "a value may hold numbers and pi only"),
        (["--bind", " , "], '"" gives no parameter a value; write m1=2.5,h1=1'),
    ],
)
def test_a_binding_that_makes_no_sense_is_one_message(words: list[str], message: str, capsys: Capture) -> None:
    assert main(["info", str(EXAMPLES / "two_link.toml"), *words]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.mends("30.also.long_values")
@pytest.mark.parametrize("words", [["equations", "--bind"], ["info", "--bind"], ["verify", "--rigorous", "--at"]])
def test_a_value_that_is_too_long_is_told_with_its_option_and_its_letter(words: list[str], capsys: Capture) -> None:
    verb, *before = words

    assert main([verb, str(EXAMPLES / "cart_pole.toml"), *before, f"l={'1' * 10_001}"]) == 1
    assert f"{before[-1]}: l: is a formula of 10001 characters; 10000 are allowed" in capsys.readouterr().err


@pytest.mark.mends("30.class.ignored")
@pytest.mark.parametrize("format", ["latex", "text", "sympy"])
@pytest.mark.parametrize("group", ["equations", "coefficients", "matrix"])
def test_equations_hold_the_numbers_that_are_bound(format: str, group: str, capsys: Capture) -> None:
    """What `--bind` gave showed in the table of symbols of a whole document alone."""
    numbers = read_text((EXAMPLES / "cart_pole.toml").read_text().replace('"-g"', "-7"))
    words = ["equations", str(EXAMPLES / "cart_pole.toml"), "--format", format, "--as", group, "--bind", "g=7"]

    assert main(words) == 0
    assert capsys.readouterr().out.strip() == equations_text(numbers, format, group).strip()


@pytest.mark.runs("cc")
@pytest.mark.mends("30.class.ignored")
@pytest.mark.parametrize(
    "line",
    ["generate -o {0} --functions mass_matrix", "draw -o {0}/a.svg", "inverse --motion q1=t --until 0.1 -o {0}/a.csv"],
)
def test_where_names_have_the_values_of_numbers_symbolic_says_that_it_changes_nothing(
    line: str, tmp_path: Path, capsys: Capture
) -> None:
    verb, *words = line.format(tmp_path).split()

    assert main([verb, DOOR, *words, "--symbolic", "all"]) == 0
    assert "door: --symbolic all: changes nothing here" in capsys.readouterr().err


def test_where_names_are_read_symbolic_says_nothing(tmp_path: Path, capsys: Capture) -> None:
    words = ["--symbolic", "all"]

    assert main(["generate", DOOR, *words, "-o", str(tmp_path), "--functions", "inverse_dynamics_by_m1"]) == 0
    assert main(["equations", DOOR, *words]) == 0
    assert "changes nothing" not in capsys.readouterr().err


@pytest.mark.long
@pytest.mark.parametrize("template", ["rr", "cart_pole", "four_bar", "slider_crank"])
def test_starters_are_reported(template: str, tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(Starter(template).from_template(template))

    assert main(["info", str(path)]) == 0
    assert "Left out or merged" in capsys.readouterr().out


def test_a_start_without_a_real_value_costs_a_draw_of_free_parameters_and_no_more() -> None:
    """With r = 1.4 and l = 0.6, which a draw may give, sqrt(l**2 - (r*sin(pi/3))**2) is not real."""
    free = read_text(Starter("slider_crank").from_template("slider_crank"))
    free = replace(free, parameters=tuple(replace(one, value=None) for one in free.parameters))
    numbers = Numbers(free)
    draw = dict.fromkeys([one.name for one in free.parameters], 1.0)

    with pytest.raises(DerivationError, match="has no real value with these parameters"):
        numbers.bound_to(draw | {"r": 1.4, "l": 0.6}).start()
    found, assembly = numbers.witness({})
    assert found.free["l"] > found.free["r"] * 3**0.5 / 2
    assert assembly.residual < 1e-9

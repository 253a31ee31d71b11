"""What a walkthrough prints is what the graph says, in every language, on every page."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from calls import counted
from latex_reader import LatexReader, displays
from lessons import floats, lesson_of, step_of

from symdyn.algebra.form import Symbol
from symdyn.cli import main
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Expr, substitute
from symdyn.scene import Scene, read
from symdyn.scene.scene_files import Starter
from symdyn.scene.toml import read_text
from symdyn.table import Table
from symdyn.teach import Document, rendered, walkthrough
from symdyn.teach.derivations import meaning as meaning_room
from symdyn.teach.derivations.dalembert.laws import LAW
from symdyn.teach.document import ERRATA, Box, Braced, Fold, Formula, Matrix, Picture, Shares
from symdyn.teach.languages import PLACE, language_of, languages
from symdyn.teach.mathematics import Spelling
from symdyn.teach.notation import NUMBERS, READS
from symdyn.teach.render.handout import usual_formulation

EXAMPLES = Path(__file__).parent.parent / "examples"
DIGITS = {"scara": 2e-4}  # numbers of six digits
SPRUNG = """
name = "sprung"
gravity = [0, "-g", 0]
[parameters]
m = { value = 1, positive = true }
l = { value = 1, positive = true }
k = { value = 40, positive = true }
g = { value = 9.81, positive = true }
[bodies.rod]
particles = [{ mass = "m", at = [0, "l", 0] }]
[joints.pivot]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 0, 1]
coordinate = "phi"
drive = "M"
damping = 0.2
armature = 0.05
[springs.coil]
joint = "pivot"
stiffness = 1
[springs.cord]
from = { body = "ground", at = ["-l", 0, 0] }
to = { body = "rod", at = [0, "l/2", 0] }
stiffness = "k"
free = 0.5
"""
CUT = ["two_link", "cart_pole", "spatial_3r", "four_bar", "slider_crank", "governor"]
TIED = ["slider_crank", "four_bar", "governor"]
SCENES = ["pendulum", "two_link", "cart_pole", "double_pendulum", "spatial_3r", "rrp", "sprung", "scara"]


def scene(name: str) -> Scene:
    templates = {"spatial_3r": "rrr", "rrp": "rrp"}
    if name == "sprung":
        return read_text(SPRUNG, name)
    if name in templates:
        return read_text(Starter(name).from_template(templates[name]), name)
    return read(EXAMPLES / f"{name}.toml")


@cache
def lesson(name: str, language: str = "en", formulation: str = "lagrange") -> Document:
    return lesson_of(scene(name), language, formulation=formulation)


def reader(document: Document) -> LatexReader:
    graph = document.graph
    symbols = {}
    for key, latex in Spelling(document).symbols.items():
        name = document.names.get(key)
        if not key.endswith(":tied"):  # the same quantity with the conditions put in
            symbols[latex] = graph.symbol(key) if name is None or name.node is None else name.node
    return LatexReader(symbols, graph)


def is_general(document: Document, block: Formula | Braced) -> bool:
    """Whether a formula is about any coordinate q_i, which has no value."""
    named = [document.names.get(key) for key in block.form.symbols]
    return any(one is not None and one.node is None and one.look is not None for one in named)


@pytest.mark.wide(6)
@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "formulation"),
    [
        *((name, "lagrange") for name in SCENES),
        *((name, "multipliers") for name in TIED),
        *((name, "dalembert") for name in CUT),
    ],
)
def test_every_formula_of_the_latex_has_the_value_of_the_graph(name: str, formulation: str) -> None:
    document = lesson(name, formulation=formulation)
    (tex,) = rendered(document, "latex").values()
    printed = displays(str(tex))
    every = [(step, block) for step, block in document.blocks() if isinstance(block, (Formula, Braced))]
    blocks = [(step, block) for step, block in every if not step.key.startswith(ERRATA)]  # these stand in words
    assert len(printed) == len(blocks) > 5
    read_latex, solved = reader(document), dict[Expr, Expr]()
    for text, (step, block) in zip(printed, blocks, strict=True):
        if is_general(document, block):
            continue  # of any coordinate; `test_the_principle_holds_for_every_coordinate` puts each in its place
        if step.key.startswith((LAW, "solved:", "ties.solved", "eliminated")):
            continue  # tests/test_teach_dalembert.py and test_teach_tied.py look at what holds where conditions do
        left, *right = read_latex.sides(text)
        key = block.value if isinstance(block, Braced) else block.left
        if step.key == "explicit" and not key:
            (solved[left],) = right
            continue
        truth = document.names[key].node if key else left
        assert truth is not None
        if key and not isinstance(block, Braced):
            assert left is truth, text
        if formulation == "dalembert" and document.scene.loops and not key:
            continue  # A x + b = 0 holds for the x that it determines
        for side in right:
            expected, shown = floats([truth, side])
            assert shown == pytest.approx(expected, rel=DIGITS.get(name, 1e-9), abs=1e-9), text
    count = len(document.scene.velocities) if solved else 0
    equations = [[document.names[f"{side}:{i + 1}"].node for side in ("tau", "QA")] for i in range(count)]
    for balance, force in equations:  # with the accelerations put in
        assert balance is not None
        assert force is not None
        expected, shown = floats([force, *substitute([balance], solved)])
        assert shown == pytest.approx(expected, rel=DIGITS.get(name, 1e-9), abs=1e-9)


@pytest.mark.heavy("spatial_3r", "governor")
@pytest.mark.long
@pytest.mark.parametrize("name", CUT)
def test_every_bivector_of_the_latex_has_the_value_of_the_graph(name: str) -> None:
    document = lesson(name, formulation="dalembert")
    (tex,) = rendered(document, "latex").values()
    printed = re.findall(r"\\begin\{bmatrix\}(.*?)\\end\{bmatrix\}", str(tex), re.DOTALL)
    columns = [(step, block) for step, block in document.blocks() if isinstance(block, Matrix)]
    assert len(printed) == len(columns) >= 2 * len(document.scene.bodies)
    read_latex = reader(document)
    for text, (step, column) in zip(printed, columns, strict=True):
        if step.key.startswith(LAW):
            continue
        for entry, key in zip(re.split(r"\\\\|&", text), column.names, strict=True):
            (value,) = read_latex.sides(entry)
            expected, shown = floats([document.names[key].node, value])
            assert shown == pytest.approx(expected, rel=1e-9, abs=1e-9), entry


def test_a_wrong_formula_is_noticed() -> None:
    document = lesson("two_link")
    step, block = next((s, b) for s, b in document.blocks() if isinstance(b, Formula) and b.left == "k_z:1,1")
    wrong = replace(block, form=block.form.terms[0])
    left, right = Spelling(document).formula(wrong)
    truth, shown = floats([document.names["k_z:1,1"].node, reader(document).sides((left + right).replace("\v", ""))[1]])
    assert step.key == "coefficients:k_z"
    assert shown != pytest.approx(truth)


@pytest.mark.heavy("spatial_3r", "rrp", "scara", "double_pendulum")
@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_forms_are_worth_their_names(name: str) -> None:
    document = lesson(name)
    named = [block for _, block in document.blocks() if isinstance(block, Formula) and block.left]
    assert named
    for block in named:
        found = [block.form, *([block.right] if block.right is not None else [])]
        expected, *shown = floats([document.names[block.left].node, *(document.value(form) for form in found)])
        assert shown == pytest.approx([expected] * len(shown), rel=1e-9, abs=1e-9), block.left


@pytest.mark.heavy("spatial_3r")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", ["two_link", "cart_pole", "spatial_3r"])
def test_bars_add_up_to_the_torque(name: str) -> None:
    charts = [block for _, block in lesson(name).blocks() if isinstance(block, Shares)]
    assert len(charts) == len(scene(name).velocities)
    for chart in charts:
        assert sum(bar.value for bar in chart.bars) == pytest.approx(chart.value)
        assert sum(bar.share for bar in chart.bars) == pytest.approx(1)


def test_damping_is_a_bar_and_takes_its_power() -> None:
    document = lesson("sprung")  # a damper in the joint, whose drive is M
    (chart,) = (block for _, block in document.blocks() if isinstance(block, Shares))
    labels = [text_of(bar.label) for bar in chart.bars]
    assert "0.2*phi_dot" in labels
    assert chart.total == Symbol("M")
    assert chart.bars[labels.index("0.2*phi_dot")].value == pytest.approx(0.2)  # at 1 rad/s
    power = next(b for s, b in document.blocks() if s.key == "power" and isinstance(b, Formula) and b.left == "d/dt E:")
    assert text_of(power.form) == "(M - 0.2*phi_dot)*phi_dot"
    step = step_of(document, "acting")
    kinds = [row[0].parts[0] for block in step.blocks if isinstance(block, Table) for row in block.rows]
    assert kinds == ["viscous damping", "spring", "spring"]


def test_the_terms_of_a_passive_joint_cancel() -> None:
    step = step_of(lesson("cart_pole"), "torque:2")
    assert "no drive acts on" in "".join(map(str, step.claim.parts))


def test_languages_have_the_same_keys_and_places() -> None:
    english = language_of("en").lesson
    for language in languages():
        texts = language_of(language).lesson
        assert texts.keys() == english.keys(), language
        for key, text in texts.items():
            assert sorted(set(PLACE.findall(text))) == sorted(set(PLACE.findall(english[key]))), (language, key)
            assert "\\" not in text, "prose holds no LaTeX"


@pytest.mark.long(0)
def test_languages_differ_in_prose_only() -> None:
    english, slovak = lesson("two_link", "en"), lesson("two_link", "sk")
    assert [step.key for s in english.sections for step in s.steps] == [
        step.key for s in slovak.sections for step in s.steps
    ]
    (a,), (b,) = (rendered(one, "latex").values() for one in (english, slovak))
    assert displays(str(a)) == displays(str(b))
    assert "Kinetická energia" in str(b)
    assert "kinetic energy" not in str(b)


@pytest.mark.long(0)
def test_textbook_mode_numbers_every_equation() -> None:
    document = lesson("two_link")
    (tex,) = rendered(document, "latex").values()
    numbers = set(re.findall(r"\\tag\{([\d.]+)\}", str(tex)))
    assert numbers >= set(NUMBERS.values())
    boxes = [block for _, block in document.blocks() if isinstance(block, Box) and block.kind == "erratum"]
    assert len(boxes) == len(READS)
    others = {block.number for _, block in lesson("double_pendulum").blocks() if isinstance(block, Formula)}
    assert others == {"", "5.21", "5.22"}  # of every mechanism


def test_a_wrong_moment_of_inertia_stops_the_lesson(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meaning_room.Axis, "lever", lambda self, place: place)
    with pytest.raises(AssertionError, match="k_z:1,1 and J:1 differ"):
        walkthrough(scene("spatial_3r"))


@pytest.mark.long(0)
def test_until_and_detail_shorten() -> None:
    arm = scene("two_link")
    parts = [walkthrough(arm, until=until).sections for until in ("energies", "lagrangian", "equations")]
    assert [[s.key for s in found if s.key != "errata"][-1] for found in parts] == [
        "energies",
        "lagrangian",
        "equations",
    ]
    brief, full = walkthrough(arm), lesson("two_link")
    assert brief.sections == full.sections
    assert 2 * sum(len(s.steps) for s in brief.kept().sections) < sum(len(s.steps) for s in full.kept().sections)
    with pytest.raises(EmitError, match="until 'now' is no part of the formulation lagrange"):
        walkthrough(arm, until="now")


def test_long_expressions_of_large_scenes_are_folded() -> None:
    assert any(isinstance(block, Fold) for _, block in walkthrough(scene("scara"), until="equations").blocks())


def test_quaternions_are_told_what_would_work() -> None:
    for formulation in ("lagrange", "multipliers", "dalembert"):
        with pytest.raises(DerivationError, match=r'formulation="quaternions" .* orientation = "zyx"'):
            walkthrough(read(EXAMPLES / "heavy_top.toml"), formulation=formulation)


def test_closed_mechanisms_are_told_the_other_formulations() -> None:
    with pytest.raises(DerivationError, match=r'formulation="multipliers" .*, formulation="dalembert"'):
        walkthrough(read(EXAMPLES / "four_bar.toml"), formulation="lagrange")


@pytest.mark.parametrize(
    ("name", "formulation"),
    [("cart_pole", "lagrange"), ("four_bar", "multipliers"), ("heavy_top", "quaternions"), ("rssr", "quaternions")],
)
def test_a_lesson_takes_the_formulation_that_fits_its_scene(name: str, formulation: str) -> None:
    assert usual_formulation(read(EXAMPLES / f"{name}.toml")) == formulation


@pytest.mark.long(0)
def test_same_scene_same_bytes() -> None:
    first, second = (rendered(walkthrough(scene("cart_pole")), "md") for _ in range(2))
    assert first == second


@pytest.mark.long(0)
def test_command_writes_markdown_with_its_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["walkthrough", str(EXAMPLES / "cart_pole.toml"), "-o", str(tmp_path)]) == 0
    paths = capsys.readouterr().out.split()
    text = (tmp_path / "cart_pole.md").read_text(encoding="utf-8")
    for name in re.findall(r"!\[[^\]]*\]\(([^)]*)\)", text):
        assert str(tmp_path / name) in paths
        assert (tmp_path / name).read_text(encoding="utf-8").startswith("<svg")


@pytest.mark.runs("pdflatex")
def test_pdf_is_built_and_the_same_every_time(tmp_path: Path) -> None:
    ((name, first),) = rendered(lesson("two_link", "sk"), "pdf").items()
    ((_, second),) = rendered(lesson("two_link", "sk"), "pdf").items()
    assert name == "two_link.pdf"
    assert isinstance(first, bytes)
    assert first.startswith(b"%PDF")
    assert first == second


def test_pictures_have_a_text_for_those_who_cannot_see_them() -> None:
    pictures = [block for _, block in lesson("two_link").blocks() if isinstance(block, Picture)]
    assert len({one.key for one in pictures}) == len(pictures) >= 2
    assert all(one.alt and one.caption.parts for one in pictures)


@pytest.mark.long
def test_a_lesson_that_nobody_would_read_is_refused_early() -> None:
    """A seven-axis arm: told before any step is written."""
    told = r"arm7: a lesson .* format=.sliders. .* symdyn generate"
    with counted() as calls, pytest.raises(DerivationError, match=told):
        walkthrough(scene("arm7"))

    assert calls.number < 700_000


@pytest.mark.long
@pytest.mark.parametrize("angle", ["atan2(l, h) - 2*(l/h)", "2*l/h", "sqrt(l/h + 1)*(l + h)/h", "l*(1 + l/h)/h"])
def test_an_angle_that_is_a_formula_of_lengths_is_read_again_from_what_is_printed(angle: str) -> None:
    text = f"""
    name = "tilted"
    gravity = [0, "-9.81", 0]
    parameters = {{ l = {{ unit = "m" }}, h = {{ unit = "m" }} }}
    bodies.arm.particles = [{{ mass = 1, at = ["l", "h", 1] }}]
    [joints.j]
    type = "revolute"
    parent = "ground"
    child = "arm"
    axis = [0, 0, 1]
    origin = {{ rpy = ["{angle}", 0, 0] }}
    """
    document = walkthrough(read_text(text, "tilted"))
    assert any("square" in step.key for section in document.sections for step in section.steps)


def test_torques_are_called_as_the_textbook_calls_them_and_its_form_stands_beside_ours() -> None:
    document = lesson("two_link")
    text = str(rendered(document, "md")["two_link.md"])
    assert "gives rise to the inertial torque $M_{z,11}$ in the axis $o_1$" in text
    assert "$M_{z,12}$ is the reaction torque in the axis $o_1$ that the acceleration $\\ddot q_2$ induces" in text
    assert "$M_{D,11}$ is the centripetal torque in the axis $o_1$; it is zero" in text
    assert r"- k_{C,1}^{(5.40)} \dot q_1 \dot q_2 - k_{D,12}^{(5.40)} \dot q_2^2 + k_{G,1}" in text
    assert text.count("Slovak textbook") == 1
    assert "the book " not in text
    forces = next(b for _, b in document.blocks() if isinstance(b, Picture) and b.key == "centrifugal")
    assert all(f">{one}" in forces.svg for one in "FMSo")
    assert "zotrvačného krútiaceho momentu" in str(rendered(lesson("two_link", "sk"), "md"))

"""Lessons by other formulations: what they print is worth what the graph says, and what they print is proved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
import test_formulations
from lessons import floats, lesson_of, step_of

import symdyn
from symdyn.algebra.form import Form, Number, Symbol
from symdyn.cli import main
from symdyn.emit.print import FormulationPage
from symdyn.emit.print.formulations_page import PAGES as EVERY
from symdyn.errors import DerivationError, SymdynError
from symdyn.graph import gradient
from symdyn.scene import Scene, read_text
from symdyn.table import Table
from symdyn.teach import rendered, walkthrough
from symdyn.teach.derivations.formulations import UNTIL, WAYS
from symdyn.teach.document import Formula, Matrix, Questions, Step, Words
from symdyn.teach.practice.exercises import judge, with_exercises
from symdyn.verdict import Verdict
from symdyn.verify import Claim, on_unit_sphere, prove

PAGES = {name: page for name, page in EVERY.items() if name not in ("contact", "inverse-kinematics")}
"""But for pages that are no formulation: a lesson has a section of contacts, and none of angles of arms."""


PENDULUM = str(Path(__file__).parent.parent / "examples" / "pendulum.toml")
BALL = """
[bodies.b]
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
inertia_about = "com"
[joints.j]
type = "spherical"
parent = "ground"
child = "b"
drive = false
"""
CASES = [
    ("pendulum", "hamilton"),
    ("SPHERICAL", "routh"),
    ("two_link", "kane"),
    ("double_pendulum", "gibbs-appell"),
    ("ROD", "udwadia-kalaba"),
    ("cart_pole", "port-hamiltonian"),
]


def scene(name: str) -> Scene:
    return read_text(getattr(test_formulations, name), name.lower()) if name.isupper() else symdyn.example(name)


def table_of(one: Step) -> Sequence[Sequence[Words]]:
    (table,) = one.blocks
    assert isinstance(table, Table)
    return table.rows


def test_every_page_has_its_lesson() -> None:
    assert list(WAYS) == list(PAGES)


@pytest.mark.parametrize(("name", "formulation"), [one for one in CASES if one[0] != "ROD"])
def test_every_formula_is_worth_what_its_name_is(name: str, formulation: str) -> None:
    """Momenta, H, R, forces: by names whose values come from energies and velocities of the lesson's own graph."""
    document = lesson_of(scene(name), formulation=formulation)
    known = [
        (document.names[block.left].node, form)
        for one, block in document.blocks()
        if one.key.startswith(("derived", "result")) and isinstance(block, Formula) and block.left in document.names
        for form in (block.form, block.right)
        if form is not None and all(x not in document.names or document.names[x].node for x in form.symbols)
    ]

    assert len(known) >= 1
    for node, form in known:
        if node is not None:
            expected, shown = floats([node, document.value(form)])
            assert shown == pytest.approx(expected, rel=1e-9, abs=1e-9), form


@pytest.mark.parametrize(("name", "formulation"), CASES)
def test_lessons_are_written_in_every_text_format(name: str, formulation: str) -> None:
    document = lesson_of(scene(name), "sk", formulation)

    assert [part.key for part in document.sections][-3:] == ["by.equations", "by.check", "by.gains"]
    assert len({one.key for section in document.sections for one in section.steps}) == sum(
        len(section.steps) for section in document.sections
    )
    for format in ("md", "latex", "notebook"):
        (text,) = (str(x) for x in rendered(document, format).values() if "<svg" not in str(x)[:200])
        assert "{" not in document.title
        assert "⁻" not in text


@pytest.mark.parametrize("formulation", list(PAGES))
@pytest.mark.parametrize("name", ["two_link", "four_bar", "rolling_disc"])
def test_a_scene_without_a_formulation_is_refused_with_the_reason_of_the_page(name: str, formulation: str) -> None:
    chosen, said = symdyn.example(name), ""
    try:
        list(PAGES[formulation](chosen))
    except SymdynError as fault:
        said = str(fault)
    if said:
        with pytest.raises(SymdynError) as refused:
            walkthrough(chosen, formulation=formulation)
        assert str(refused.value) == said


SLIDER = (
    BALL.replace('parent = "ground"', 'parent = "cart"').replace("com = [0, 0, 0]", "com = [0, 0, 0.4]")
    + """
[bodies.cart]
mass = 3
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
damping = 0.1
"""
)


TURNED = [
    ("heavy_top", "port-hamiltonian"),
    ("heavy_top", "kane"),
    ("free_body", "gibbs-appell"),
    ("SLIDER", "hamilton"),
]


@pytest.mark.parametrize(
    ("name", "formulation"),
    [
        pytest.param(name, formulation, marks=[] if (name, formulation) in TURNED else pytest.mark.slow)
        for name in ("heavy_top", "free_body", "SLIDER")
        for formulation in ("hamilton", "kane", "gibbs-appell", "port-hamiltonian")
    ],
)
def test_bodies_that_turn_by_quaternions_have_lessons_with_proofs(name: str, formulation: str) -> None:
    """In velocities along their axes, with Lie and Poisson's terms; of the last M is too long to be inverted."""
    one = read_text(SLIDER, "slider") if name == "SLIDER" else symdyn.example(name)
    document = lesson_of(one, "sk", formulation)
    proof = step_of(document, "derived:proof")

    assert "rotations.quaternion" in [part.key for part in document.sections]
    assert "konečnými poľami" in "".join(map(str, proof.reason.parts))
    pairs = [
        (document.names[x.left].node, document.value(form))
        for _, x in document.blocks()
        if isinstance(x, Formula) and x.left in document.names
        for form in (x.form, x.right)
        if form is not None and all(name not in document.names or document.names[name].node for name in form.symbols)
    ]
    left, right = zip(*((node, shown) for node, shown in pairs if node is not None), strict=True)
    (finding,) = prove(on_unit_sphere(one, [Claim("formulas", "names", "shown", left, right)]))[1]
    assert finding.verdict == Verdict.PROVED, finding.where


def test_momenta_of_a_top_that_stay_are_told_though_no_coordinate_is_cyclic() -> None:
    kept = step_of(lesson_of(symdyn.example("heavy_top"), formulation="hamilton"), "derived:brackets")
    (row,) = kept.blocks

    assert isinstance(row, Formula)
    assert row.left == "p2_dot"


def test_a_ball_among_constraints_has_the_lesson_of_quaternions() -> None:
    tied = (
        SLIDER
        + """
[constraints.held]
formula = "m2*j_wx + q1_dot"
acts_in = "joints"
[parameters]
m2 = { value = 1, unit = "m" }
"""
    )
    with pytest.raises(DerivationError, match=r"joint j turns by a quaternion; formulation=\"quaternions\""):
        walkthrough(read_text(tied, "tied"), formulation="udwadia-kalaba")


@pytest.mark.parametrize(("name", "formulation"), [("pendulum", "hamilton"), ("four_bar", "udwadia-kalaba")])
def test_what_it_costs_is_what_the_page_of_counts_says(name: str, formulation: str) -> None:
    """Of the scene as declared, whatever letters and order of masses the lesson has."""
    declared = symdyn.example(name)
    table = table_of(step_of(lesson_of(declared, formulation=formulation), "derived:cost"))
    told = [str(row[1].parts[0]) for row in table]

    assert told == [str(FormulationPage(declared, one).operations) for one in ("lagrange", formulation)]


@pytest.mark.parametrize(("name", "formulation"), CASES)
def test_a_wrong_sign_on_the_page_is_no_lesson(name: str, formulation: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is proved is what is printed: one term with another sign, and there is no proof."""
    page = PAGES[formulation]

    def wrong(one: Scene) -> object:
        for group in page(one):
            if group.key in ("canonical", "left", "kane", "appell", "free"):
                row = group.rows[-1]
                turned = Form.product((Number.MINUS_ONE, row.form.terms[0]))
                changed = replace(row, form=Form.sum((turned, *row.form.terms[1:])))
                yield replace(group, rows=(*group.rows[:-1], changed))
            else:
                yield group

    monkeypatch.setitem(EVERY, formulation, wrong)
    with pytest.raises(AssertionError, match=f"{formulation} differs from Lagrange's equations"):
        walkthrough(scene(name), formulation=formulation, until="check")


def test_letters_are_none_of_the_scene() -> None:
    """A coordinate H and a mass p keep their letters; the Hamiltonian and the momenta take others, in prose too."""
    text = (
        test_formulations.SPHERICAL.replace('"theta"', '"H"')
        .replace("\nm = ", "\np = ")
        .replace('mass = "m"', 'mass = "p"')
    )
    (tex,) = rendered(walkthrough(read_text(text, "clash"), formulation="hamilton"), "latex").values()

    assert r"\mathcal{H} &= " in str(tex)
    assert r"one function, $\mathcal{H}$, gives them" in str(tex)
    assert r"p_1 &= \frac{\partial L}{\partial \dot{\phi}}" in str(tex)


def test_the_spherical_pendulum_has_its_effective_potential() -> None:
    """p² / (2 m l² sin² θ) - m g l cos θ (Goldstein, 3.3), and steady motions from a critical speed on."""
    found = lesson_of(scene("SPHERICAL"), formulation="routh")
    text = str(rendered(found, "md")["spherical.md"])
    assert r"V_{\mathrm{eff}} = \frac{p_1^2}{2 m l^2 \sin^2 \theta} - m l g \cos \theta" in text
    assert r"the critical speed is 2.986 rad/s" in text


def test_a_momentum_is_asked_for_and_judged() -> None:
    lesson = with_exercises(walkthrough(symdyn.example("pendulum"), formulation="hamilton"))
    asked = [block.key for _, block in lesson.blocks() if isinstance(block, Questions)]

    assert {"derived:momenta", "derived:hamiltonian", "result:canonical"} <= set(asked)
    assert judge(lesson, "derived:momenta", "m*l^2*q1'") == "Right."
    assert judge(lesson, "derived:momenta", "m*l*q1'").startswith("Not yet")


@pytest.mark.slow
def test_a_top_where_coordinates_are_singular_has_exercises() -> None:
    """Upright, its mass matrix has no inverse: the question how fast it swings there is left out."""
    lesson = with_exercises(walkthrough(symdyn.example("gyroscope"), formulation="routh"))

    assert "derived:constant:p1" in {block.key for _, block in lesson.blocks() if isinstance(block, Questions)}


@pytest.mark.parametrize("name", ["pendulum", "double_pendulum"])
def test_slopes_of_the_energy_of_accelerations_are_the_mass_matrix_that_is_shown(name: str) -> None:
    """Of one coordinate, too; and what bodies add is all of it."""
    document = lesson_of(scene(name), formulation="gibbs-appell")
    (shown,) = (block for block in step_of(document, "derived:least").blocks if isinstance(block, Matrix))
    S = document.names["gibbs:"].node
    rates = [document.graph.symbol(f"{q}_ddot") for q in document.scene.coordinates]
    slopes = [x for one in gradient(S, rates) for x in gradient(one, rates)]
    shares = [one.node for key, one in document.names.items() if key.startswith("S:")]

    assert floats([document.value(x) for x in shown.entries]) == pytest.approx(floats(slopes), rel=1e-12, abs=1e-12)
    if shares:
        assert floats([document.graph.total(shares)]) == pytest.approx(floats([S]), rel=1e-12)


def test_rows_in_rates_are_shown_before_they_are_differentiated() -> None:
    (row,) = step_of(lesson_of(scene("ROD"), formulation="udwadia-kalaba"), "derived:tied").blocks

    assert isinstance(row, Formula)
    assert str(row.form.to_sympy()) == "x*x_dot + y*y_dot"


def test_forces_of_constraints_do_no_work() -> None:
    lesson = lesson_of(scene("ROD"), formulation="udwadia-kalaba")

    forces, rates = (
        {
            row[0].parts[0]: float(str(row[1].parts[0]).split()[0].replace("−", "-"))
            for row in table_of(step_of(lesson, key))
        }
        for key in ("derived:forces", "derived:state")
    )
    assert set(forces) == {Symbol("x_dot"), Symbol("y_dot")}
    assert sum(force * rates[u] for u, force in forces.items()) == pytest.approx(0, abs=2e-3)


def test_the_command_line_writes_a_part(tmp_path: object, capsys: pytest.CaptureFixture[str]) -> None:
    page = f"{tmp_path}/p.md"
    assert main(["walkthrough", PENDULUM, "--formulation", "kane", "--until", "equations", "-o", page]) == 0
    assert main(["walkthrough", PENDULUM, "--formulation", "routh", "-o", page]) == 1
    assert "Routh's equations do not exist: no coordinate is cyclic" in capsys.readouterr().err
    assert UNTIL[0] == "equations"

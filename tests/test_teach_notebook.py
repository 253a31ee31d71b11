"""Notebooks: valid, the same in every run, and they execute."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from kernels import executed
from lessons import lesson_of

import symdyn
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import TeachError
from symdyn.scene import Scene, read, read_text
from symdyn.teach import rendered, walkthrough
from symdyn.teach.document import Blank, Document
from symdyn.teach.practice.derived import Derived
from symdyn.teach.practice.exercises import judge, with_exercises
from symdyn.teach.practice.questions import sheet

nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed (extra dev)")
EXAMPLES = Path(__file__).parent.parent / "examples"


def document(name: str, exercises: bool, language: str = "en") -> Document:
    found = lesson_of(read(EXAMPLES / f"{name}.toml"), language)
    return with_exercises(found) if exercises else found


def book(name: str, exercises: bool, language: str = "en") -> str:
    text = rendered(document(name, exercises, language), "notebook")[f"{name}.ipynb"]
    assert isinstance(text, str)
    return text


@pytest.mark.wide(3)
@pytest.mark.long(0)
@pytest.mark.parametrize("exercises", [False, True])
@pytest.mark.parametrize("name", ["two_link", "cart_pole"])
def test_a_notebook_is_valid_and_the_same_in_every_run(name: str, exercises: bool) -> None:
    text = book(name, exercises)
    again = walkthrough(read(EXAMPLES / f"{name}.toml"), detail="full")

    nbformat.validate(json.loads(text))
    assert rendered(with_exercises(again) if exercises else again, "notebook")[f"{name}.ipynb"] == text
    assert len(text) < 1_500_000


def run_cells(text: str) -> list[str]:
    """Run the cells in this process and return what each prints or shows."""
    import ast
    import contextlib
    import io

    space: dict[str, Any] = {}
    shown = []
    for cell in json.loads(text)["cells"]:
        if cell["cell_type"] == "code":
            printed = io.StringIO()
            tree = ast.parse(cell["source"])
            last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
            with contextlib.redirect_stdout(printed):
                exec(compile(tree, cell["id"], "exec"), space)
                value = eval(compile(ast.Expression(last.value), cell["id"], "eval"), space) if last else None
            shown.append(printed.getvalue() + (str(value) if value is not None else ""))
    return shown


@pytest.mark.slow
@pytest.mark.long
def test_the_cells_of_a_lesson_find_their_own_formulas_right() -> None:
    shown = "\n".join(run_cells(book("two_link", False)))

    lines = [line for line in shown.splitlines() if line]
    assert sum(": right" in line for line in lines) >= 7
    assert sum(": as symdyn has it (proved equal)" in line for line in lines) == 6 + 3 + 2 * 4 + 3
    assert all(": right" in line or "as symdyn has it" in line or line.startswith("Matrix") for line in lines)


def derived(scene: Scene, change: tuple[str, str] = ("", ""), formulation: str = "lagrange") -> list[str]:
    """Return what the cells that derive a scene print, after a change of their text."""
    text = str(next(iter(rendered(lesson_of(scene, formulation=formulation), "notebook").values())))
    cells = json.loads(text)
    cells["cells"] = [x for x in cells["cells"] if x["id"] == "setup" or x["id"].startswith("derive")]
    for cell in cells["cells"]:
        if cell["cell_type"] == "code" and cell["id"] != "setup":
            cell["source"] = cell["source"].replace(*change).replace("\nM.applyfunc(simplify)", "")
    return [line for line in "\n".join(run_cells(json.dumps(cells))).splitlines() if line]


@pytest.mark.heavy("two_link-dalembert")
@pytest.mark.long(0)
@pytest.mark.parametrize(
    ("name", "formulation"),
    [
        ("cart_pole", "lagrange"),
        pytest.param("spatial_3r", "lagrange", marks=pytest.mark.slow),
        ("slider_crank", "multipliers"),
        ("two_link", "dalembert"),
    ],
)
def test_cells_derive_what_symdyn_has(name: str, formulation: str) -> None:
    lines = derived(read(EXAMPLES / f"{name}.toml"), formulation=formulation)

    assert len(lines) > 15
    assert [line for line in lines if "as symdyn has it" not in line] == []


STRANGE = """
[parameters]
K = {}
E = {}
L = {}
W = {}
t1 = {}
I = {}
print = {}
R1 = {}

[bodies.K]
mass = "K"
first_moment = ["E*L", 0, 0]
inertia = {xx = "I", yy = "2*I", zz = "2*I", xy = "W/9"}
inertia_about = "frame"

[joints.j]
type = "revolute"
parent = "ground"
child = "K"
axis = [0, 1, 0]
origin = ["R1", 0, 0]
coordinate = "P"
armature = "t1"
damping = "print"

[bodies.N]
particles = [{ mass = "K", at = ["L", 0, 0] }, { mass = 2, at = [0, "L", 1] }]

[joints.S]
type = "prismatic"
parent = "K"
child = "N"
axis = [1, 0, 0]
coordinate = "Q"

[springs.E]
joint = "S"
stiffness = "W"
"""


@pytest.mark.long
def test_letters_of_a_scene_may_be_those_of_python_sympy_and_the_cells() -> None:
    lines = derived(read_text(STRANGE, "strange.toml"))

    assert len(lines) > 20
    assert [line for line in lines if "as symdyn has it" not in line] == []


@pytest.mark.long
def test_a_changed_line_is_told_with_what_it_changes() -> None:
    scene = read(EXAMPLES / "two_link.toml")

    lines = derived(scene, ("K2 = m2 *", "K2 = m1 *"))
    assert "K: different" in lines
    assert "P: as symdyn has it (proved equal)" in lines
    lines = derived(scene, ("momentum1.diff(t) - slope1", "momentum1.diff(t) + slope1"))
    at = lines.index("equation 1: different")
    assert "sin(q1)" in lines[at + 1]
    assert lines[at + 1].startswith("  yours less symdyn's is ")
    assert "dL/dq1: as symdyn has it (proved equal)" in lines


def test_what_has_no_meaning_is_told_in_words() -> None:
    from sympy import Function, Symbol, gamma, symbols

    scene = Derived(symdyn.example("two_link"))
    for wrong, says in [
        (gamma(Symbol("m1")), "has no meaning here"),
        (Function("z")(Symbol("t")), "has no meaning here"),
        (Symbol("m1") ** Symbol("m2"), "exponents are whole numbers"),
    ]:
        with pytest.raises(TeachError, match=says):
            scene.compare("K", wrong)
    with pytest.raises(TeachError, match=r"there is no 'Z'; .*there are x1, y1, z1, x2"):
        scene.compare("Z", symbols("m1"))


@pytest.mark.long
def test_exercises_and_sheets_derive_nothing() -> None:
    for text in (
        book("two_link", True),
        str(next(iter(rendered(sheet(document("two_link", True)), "notebook").values()))),
    ):
        assert not any(cell["id"].startswith("derive") for cell in json.loads(text)["cells"])


@pytest.mark.long
def test_the_cells_of_exercises_wait_for_an_answer() -> None:
    shown = run_cells(book("two_link", True, "sk"))

    assert set(filter(None, shown)) == {"Nič tu nie je napísané."}


@pytest.mark.long
def test_a_typed_answer_is_judged() -> None:
    lesson = document("two_link", True)
    for _, blank in lesson.blocks():
        if isinstance(blank, Blank):
            assert judge(lesson, blank.key, f"x = {text_of(blank.answer)}") == "Right."
            assert (
                judge(lesson, blank.key, f"-({text_of(blank.answer)})") == "Not yet: all of it has the opposite sign."
            )
            assert judge(lesson, blank.key, "m1") == "Not yet: it has another value."
            assert "did you mean" in judge(lesson, blank.key, "m3 h1")
    with pytest.raises(TeachError, match="there is no exercise"):
        judge(lesson, "none", "m1")


@pytest.mark.runs
@pytest.mark.slow
@pytest.mark.parametrize("exercises", [False, True])
def test_a_notebook_executes_in_jupyter(exercises: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("ipykernel", reason="ipykernel is not installed (extra dev)")
    root = str(Path(symdyn.__file__).parent.parent)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH", "")])))
    found = nbformat.reads(book("cart_pole", exercises), as_version=4)

    executed(found, kernel_name="python3")

    outputs = [output for cell in found.cells if cell.cell_type == "code" for output in cell.outputs]
    told = "".join(output.get("text", "") for output in outputs)
    assert exercises or (told.count("as symdyn has it") >= 15 and "different" not in told)
    assert all(output.output_type != "error" for output in outputs)

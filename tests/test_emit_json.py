"""The graph as a file: exact, read back to what it was, and a stranger's file refused with its place."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from formulas import every_op, one

from symdyn.cli import main
from symdyn.dynamics import derive
from symdyn.emit import TARGETS, emit, read_program
from symdyn.emit.targets.json_graph import ProgramError
from symdyn.errors import EmitError, SceneError, SymdynError
from symdyn.graph import Graph, Op
from symdyn.program import Program, formulate, lower, prepare
from symdyn.scene import read

ROOT = Path(__file__).parent.parent
DOC = ROOT / "docs" / "json.md"


def text_of(program: Program) -> str:
    (text,) = emit(program, "json").texts.values()
    return text


def pendulum() -> dict[str, Any]:
    """Return the file of the pendulum with free parameters, as Python reads it."""
    scene = read(ROOT / "examples" / "pendulum.toml")
    free = replace(scene, parameters=tuple(replace(parameter, value=None) for parameter in scene.parameters))
    whole: dict[str, Any] = json.loads(text_of(lower(derive(free, ("inverse_dynamics",)))))
    return whole


def programs() -> list[Any]:
    """Return programs of all kinds: plain, closed, prepared, at rest, with signals and with time."""
    asked = {
        "two_link": ("inverse_dynamics", "mass_matrix", "pose:tool"),
        "four_bar": ("reactions", "forward_dynamics"),
        "free_body": ("forward_dynamics",),
        "rolling_disc": ("forward_dynamics",),
        "governor": ("inverse_dynamics",),
    }
    made = [pytest.param(name, functions, False, id=name) for name, functions in asked.items()]
    return [*made, pytest.param("two_link", ("inverse_dynamics", "mass_matrix"), True, id="prepared")]


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.parametrize(("scene", "functions", "first"), programs())
def test_what_was_read_back_is_written_the_same_for_every_target(
    scene: str, functions: tuple[str, ...], first: bool
) -> None:
    program = lower(formulate(read(ROOT / "examples" / f"{scene}.toml"), functions))
    program = prepare(program) if first else program
    text = text_of(program)
    again = read_program(text)

    assert text_of(again) == text
    written = 0
    for name, target in TARGETS.items():
        for real in target.reals:
            for option in ("", *target.options):
                try:
                    wanted = emit(program, name, real, option=option).files
                except EmitError as fault:
                    with pytest.raises(EmitError, match=re.escape(str(fault))):
                        emit(again, name, real, option=option)
                else:
                    assert emit(again, name, real, option=option).files == wanted, (name, real, option)
                    written += 1
    assert written > len(TARGETS)


def test_the_scene_comes_back_whole() -> None:
    scene = read(ROOT / "examples" / "four_bar.toml")
    program = lower(derive(scene, ("mass_matrix",)))
    again = read_program(text_of(program))

    assert again.scene == scene
    assert [routine.function.labels for routine in again.routines] == [r.function.labels for r in program.routines]
    assert again.constants.keys() != program.constants.keys(), "nodes of graphs of their own"
    assert sorted(again.constants.values()) == sorted(program.constants.values())


def test_it_is_exact_ascii_and_holds_no_float() -> None:
    def refuse(digits: str) -> None:
        raise AssertionError(digits)

    text = text_of(lower(every_op()))
    whole = json.loads(text, parse_float=refuse, parse_constant=refuse)

    assert text.isascii()
    assert whole["format"] == 1
    assert {node[0] for node in whole["nodes"]} == {op.name.lower() for op in Op} - {"table"}
    assert ["constant", "37/180"] in whole["nodes"]
    assert whole["parameters"] == [{"name": "mass", "unit": "kg", "text": "of the load"}]


def test_the_command_line_writes_it(tmp_path: Path) -> None:
    path = ROOT / "examples" / "pendulum.toml"
    assert main(["generate", str(path), "--target", "json", "-o", str(tmp_path)]) == 0
    again = read_program((tmp_path / "pendulum.json").read_text(encoding="ascii"), "pendulum.json")

    assert again.scene == read(path)
    assert "mass_matrix" in again


def changed(change: Callable[[dict[str, Any]], Any]) -> str:
    whole = pendulum()
    change(whole)
    return json.dumps(whole)


def put(*path: Any, value: Any) -> str:
    """Return the file of the pendulum with another value at a place."""

    def change(whole: Any) -> None:
        for key in path[:-1]:
            whole = whole[key]
        whole[path[-1]] = value

    return changed(change)


FUNCTION = ("functions", 0)
ARGUMENT = (*FUNCTION, "arguments", 0)

FAULTS = {
    "": r"line 1, column 1: is no JSON: Expecting value",
    "{": r"line 1, column 2: is no JSON",
    "[" * 100_000: r"nests too deep",
    "9" * 5000: r"holds an integer of more digits",
    "3": r"is not an object",
    "[]": r"is not an object",
    '{"format": 1.0}': r"holds the number 1\.0; numbers are integers, or fractions in text",
    '{"format": NaN}': r"holds the number NaN",
    '{"format": 1, "format": 1}': r"has an object with a key twice",
    '{"format": 1}': r"lacks about, scene, parameters, nodes, functions",
    put("canary", value=1): r"has canary; it has format, about",
    put("format", value=2): r"format: is 2; this version reads 1",
    put("format", value=True): r"format: is True",
    put("scene", value=1): r"scene: is not a text",
    put("nodes", value={}): r"nodes: is not a list",
    put("nodes", 0, value=[]): r"nodes\[0\]: is of no operation there is",
    put("nodes", 0, value=["power", 0, 0]): r"nodes\[0\]: is of no operation there is",
    put("nodes", 0, value=[["add"], 0, 0]): r"nodes\[0\]: is of no operation there is",
    put("nodes", 0, value=["add", 1, 2]): r"nodes\[0\]: refers to 1; there are nodes 0 to -1 before it",
    put("nodes", 3, value=["add", 0, -1]): r"nodes\[3\]: refers to -1",
    put("nodes", 3, value=["add", 0, True]): r"nodes\[3\]: refers to True",
    put("nodes", 3, value=["add", 0]): r"nodes\[3\]: add takes 2, here are 1",
    put("nodes", 0, value=["constant", "1/0"]): r"nodes\[0\]: holds '1/0'; give a fraction",
    put("nodes", 0, value=["constant", "1e9"]): r"nodes\[0\]: holds '1e9'",
    put("nodes", 0, value=["constant", "9" * 9999]): r"nodes\[0\]: holds '9999",
    put("nodes", 0, value=["constant", "٣"]): r"nodes\[0\]: holds '٣'",
    put("nodes", 0, value=["constant", 1]): r"nodes\[0\]: holds 1; give a fraction",
    put("nodes", 0, value=["symbol", "q 1"]): r"nodes\[0\]: holds 'q 1'; give a name",
    put("functions", value=[]): r"functions: is empty",
    changed(lambda whole: whole["functions"].append(whole["functions"][0])): r"functions\[1\]\.name: .* earlier one",
    put(*FUNCTION, value=3): r"functions\[0\]: is not an object",
    put(*FUNCTION, "shape", value=[2]): r"functions\[0\]\.entries: are 1; shape \(2,\) has 2",
    put(*FUNCTION, "shape", value=[-1]): r"functions\[0\]\.shape: holds -1",
    put(*FUNCTION, "shape", value=[1] * 5000): r"functions\[0\]\.shape: has 5000 lengths",
    put(*FUNCTION, "entries", value=[99999]): r"functions\[0\]\.entries: refers to 99999",
    put(*FUNCTION, "name", value="a b"): r"functions\[0\]\.name: holds 'a b'; give a name of ASCII",
    put(*FUNCTION, "result", value="*/"): r"functions\[0\]\.result: holds '\*/'",
    put(*FUNCTION, "unique", value=[True, True]): r"functions\[0\]\.unique: has 2 entries, the result 1",
    put(*FUNCTION, "text", value=None): r"functions\[0\]\.text: is not a text",
    changed(lambda whole: whole["functions"][0]["arguments"].pop(0)): r"need q1, which are none of the arguments",
    changed(lambda whole: whole["functions"][0]["arguments"].append(whole["functions"][0]["arguments"][0])): "twice",
    put(*ARGUMENT, "entries", value=[]): r"arguments\[0\]\.units: are 1; there are 0 entries",
    put(*ARGUMENT, "scalar", value=1): r"arguments\[0\]\.scalar: is not true or false",
    put(*ARGUMENT, "units", value=[1]): r"arguments\[0\]\.units: is not a text",
    put("parameters", value=[]): r"parameters: are not those that params has in the scene",
    put("parameters", 0, "unit", value="lb"): r"parameters: are not those",
}  # fmt: skip


@pytest.mark.parametrize("text", FAULTS, ids=[message[:50] for message in FAULTS.values()])
def test_a_file_of_a_stranger_is_refused_with_its_place(text: str) -> None:
    with pytest.raises(ProgramError, match=rf"\Ag\.json: .*{FAULTS[text]}"):
        read_program(text, "g.json")


def test_faults_of_its_scene_and_of_its_constants_are_told_as_ever() -> None:
    with pytest.raises(SceneError, match=r"g\.json: scene"):
        read_program(put("scene", value='name = "x"'), "g.json")

    def divide_by_nothing(whole: dict[str, Any]) -> None:
        there = len(whole["nodes"])
        whole["nodes"] += [["constant", "0"], ["sqrt", there], ["div", there, there + 1]]
        whole["functions"][0]["entries"] = [len(whole["nodes"]) - 1]

    with pytest.raises(SymdynError, match="not a finite real number"):
        read_program(changed(divide_by_nothing), "g.json")


@pytest.mark.long(0)
def test_cutting_or_changing_any_part_is_read_or_refused_and_nothing_else() -> None:
    text, seen = json.dumps(pendulum()), set()
    for k in range(0, len(text), 7):
        for other in (text[:k], text[:k] + text[k + 1 :], text[:k] + "7" + text[k + 1 :], text[:k] + '"' + text[k:]):
            try:
                emit(read_program(other, "g.json"), "c")
                seen.add("read")
            except SymdynError as fault:
                seen.add(type(fault).__name__)
    assert {"read", "ProgramError", "SceneError"} <= seen


@pytest.mark.long(0)
def test_a_long_chain_of_nodes_nests_nothing() -> None:
    g = Graph()
    q = g.symbol("q1")
    x = q
    for _ in range(5_000):
        x = g.sin(x + q)
    text = text_of(lower(one([x], [q], read(ROOT / "examples" / "pendulum.toml"))))

    assert text.count("\n") > 10_000
    assert text_of(read_program(text)) == text


def test_the_page_about_it_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"```python\n(.*?)```", DOC.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 2
    assert blocks[1].count("\n") <= 25
    names: dict[str, Any] = {}
    for block in blocks:
        exec(block, names)
    (found,) = json.loads(capsys.readouterr().out)
    assert found == pytest.approx(0.25 * 0.3 + 0.5 * 9.81 * math.sin(0.1) + 0.01 * 0.2, rel=1e-15)


def test_the_page_names_every_operation_and_every_key() -> None:
    page = DOC.read_text(encoding="utf-8")
    whole = pendulum()

    assert all(f'["{op.name.lower()}"' in page for op in Op if op is not Op.TABLE)
    for keys in (whole, whole["functions"][0], whole["functions"][0]["arguments"][0], whole["parameters"][0]):
        assert all(f"`{key}`" in page for key in keys)

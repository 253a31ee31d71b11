"""Every operation has a row in every table: nothing can be built that cannot be differentiated, counted and written."""

from __future__ import annotations

import ast
import pickle
import re
from pathlib import Path

import pytest
from graphs import LEAVES
from mechanisms import jointed

import symdyn
from symdyn import scene
from symdyn.algebra.big import FUNCTIONS_OF_BALLS, SLOPES, BigFloats
from symdyn.algebra.numeric import Batches, Floats
from symdyn.draw.ground import PARTS
from symdyn.dynamics.mechanism.cost import CATEGORY
from symdyn.emit import TARGETS
from symdyn.emit.code.spelling import REALS, Spelling
from symdyn.graph import Op
from symdyn.graph.differentiate import PARTIALS
from symdyn.graph.ops import ARITY, FUNCTIONS
from symdyn.scene.declaration.joint_table import freedoms
from symdyn.scene.declaration.spanning import turned
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values.entry import Entry
from symdyn.teach.languages import languages


def test_every_operation_has_an_arity_and_a_cost():
    assert set(ARITY) == set(Op)
    assert set(CATEGORY) == set(Op)


def test_every_function_has_a_slope_in_the_error_analysis():
    assert set(SLOPES) == FUNCTIONS


def test_every_operation_but_the_leaves_has_partial_derivatives():
    assert set(PARTIALS) == set(Op) - LEAVES


@pytest.mark.parametrize(
    "table",
    [Floats.functions, Batches.functions, BigFloats().functions, FUNCTIONS_OF_BALLS],
    ids=["floats", "batches", "big floats", "balls"],
)
def test_every_function_has_a_value_in_every_numeric_algebra(table):
    assert set(table) == FUNCTIONS


@pytest.mark.parametrize(("target", "real"), [(name, real) for name, row in TARGETS.items() for real in row.reals])
def test_every_operation_has_a_spelling_with_one_place_an_operand(target, real):
    table = TARGETS[target].printer(REALS[real]).spellings
    assert set(table) | {Op.TABLE} == set(Op) - set(TARGETS[target].lacks), "a table may be other operations"
    for op, spelling in table.items():
        assert isinstance(spelling, Spelling)
        assert len(spelling.wants) == ARITY[op]
        assert spelling.pattern.count("{}") == max(ARITY[op], 1)


def test_every_joint_type_has_a_symbol_words_and_a_function_that_declares_it():
    marks = [kind.mark for kind in JOINTS.values()]
    parts = {part.shape for mark in marks for part in (*mark.parts, *mark.flat)}
    assert parts == set(PARTS), "PARTS in symdyn/draw/ground.py has each shape of a mark, and no others"
    wordless = [name for name, kind in JOINTS.items() if set(kind.words) != set(languages())]
    assert wordless == [], f"give `words` of the row for each of {', '.join(languages())}"
    undeclared = [kind for kind in JOINTS if not callable(getattr(scene, kind, None))]
    assert undeclared == [], "write a maker in symdyn/scene/build.py, and its name in symdyn/scene/__init__.pyi"


@pytest.mark.parametrize("kind", JOINTS)
def test_what_declares_a_joint_goes_by_its_name(kind):
    """In messages of Python, in `help`, where it says more than that, and in a pickle."""
    declare = getattr(scene, kind)

    with pytest.raises(TypeError, match=rf"^{kind}\(\) missing 1 .*: 'child'; call it as {kind}\(.*, child, axis="):
        declare("j", "ground")
    assert declare.__doc__.startswith("Declare ")
    assert pickle.loads(pickle.dumps(declare)) is declare


@pytest.mark.parametrize("kind", JOINTS)
def test_a_joint_type_is_complete(kind):
    joint = jointed("revolute", kind).joints[1]

    declared = {"type": kind, "coordinates": list(joint.coordinates)}
    assert freedoms(Entry("j", declared, "joints.j")) == len(joint.rates)
    if JOINTS[kind].turned is not None:
        assert turned(joint).rates == joint.rates or kind == "universal"
        assert turned(turned(joint)) == joint


def test_nobody_asks_for_a_target_by_its_name():
    """A row knows its name; all others take the row, or walk `TARGETS`."""
    asked = []
    for path in sorted(Path(symdyn.__file__).parent.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        named = any(f'"{name}"' in text for name in TARGETS) and ("emit" in text or "target" in text)
        for node in ast.walk(ast.parse(text)) if named else ():
            called = isinstance(node, ast.Call) and ast.unparse(node.func) in ("emit", "lambdify")
            compared = isinstance(node, ast.Compare) and "target" in ast.unparse(node.left)
            words = [one.value for one in ast.walk(node) if isinstance(one, ast.Constant)] if called or compared else []
            asked += [f"{path.name}:{node.lineno}: {word}" for word in words if word in TARGETS]
    assert asked == []


@pytest.mark.long(0)
def test_nobody_asks_for_a_joint_type_or_a_force_by_its_name():
    asked = []
    for path in sorted(Path(symdyn.__file__).parent.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if re.search(r"\.(type|kind)\b", text) else ():
            left = ast.unparse(node.left) if isinstance(node, ast.Compare) else ""
            if left.endswith((".type", ".kind")) and left != "mark.kind":  # pages draw a load by a mark of that name
                words = [one.value for one in ast.walk(node) if isinstance(one, ast.Constant)]
                asked += [f"{path.name}:{node.lineno}: {word}" for word in words if word in JOINTS or word in FORCES]
    assert asked == []

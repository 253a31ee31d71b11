"""Inverse dynamics of large trees as a loop over a table of joints: what it computes, when it is taken, its text."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from importlib import import_module

import numpy as np
import pytest
from mechanisms import random_tree
from oracles import BIG

import symdyn
from symdyn.dynamics import Workspace, derive_one, formulations_of, kept_in_lines, row_of
from symdyn.dynamics.outputs.named_functions import Argument, Counts, Function
from symdyn.dynamics.recursive.joint_table import JointRow, JointTable, kinds_of, lacking
from symdyn.dynamics.recursive.table_loops import TABLE_LOOPS, TableLoop, aba_loop, rnea_loop
from symdyn.emit import TARGETS, emit
from symdyn.emit.targets.c.loops import LINE, STACK, _places, room
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, evaluate
from symdyn.program import Program, formulate, in_lines, lower
from symdyn.runtime.c_module import build
from symdyn.scene import Quantity, Scene, body, revolute, scene as declared
from symdyn.verify.accuracy import measure
from symdyn.verify.building import files_of
from symdyn.verify.equality import Claim, prove
from symdyn.verify.written import READERS, languages, printed, prove_texts

pytestmark = pytest.mark.usefixtures("optimised")

ID, LOOP = "inverse_dynamics", "rnea_loop"
FD, FORWARD = "forward_dynamics", "aba_loop"
DID, DFD = f"{ID}_derivatives", f"{FD}_derivatives"
DERIVATIVES = pytest.mark.parametrize(
    ("name", "loop"), [(DID, "rnea_derivatives_loop"), (DFD, "aba_derivatives_loop")], ids=[DID, DFD]
)
BOTH = pytest.mark.parametrize(("name", "loop", "lines"), [(ID, LOOP, "rnea"), (FD, FORWARD, "aba")])

SEEDS = range(4)


def tree(seed: int, joints: int) -> Scene:
    """Return a branching tree of turns, slides and fixed joints, right and odd angles, its parameters with values."""
    return random_tree(seed, joints, free=False)


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> int:
    """Let 10 joints be enough for a loop."""
    for formulation, row in TABLE_LOOPS.items():
        assert row.fewest > 10
        monkeypatch.setitem(TABLE_LOOPS, formulation, replace(row, fewest=10))
    return 10


def with_rotors(scene: Scene) -> Scene:
    """Return a scene with a rotor at each joint that moves."""
    moving = (replace(one, armature=Quantity.number(Fraction(k + 1, 7))) for k, one in enumerate(scene.joints))
    return replace(scene, joints=tuple(a if a.moves else b for a, b in zip(moving, scene.joints, strict=True)))


@BOTH
@pytest.mark.parametrize("seed", SEEDS)
def test_a_loop_over_the_table_is_what_the_other_formulations_derive(
    seed: int, name: str, loop: str, lines: str
) -> None:
    w = Workspace(with_rotors(tree(seed, 7)))
    one, other = (derive_one(w, name, formulation).entries for formulation in (loop, lines))

    _, (found,) = prove([Claim(name, loop, lines, one, other)], seed=1)

    assert found.verdict == "proved"


@DERIVATIVES
@pytest.mark.parametrize("seed", [*SEEDS[:2], *(pytest.param(seed, marks=pytest.mark.slow) for seed in SEEDS[2:])])
def test_derivatives_over_the_table_are_those_of_lines(seed: int, name: str, loop: str) -> None:
    w = Workspace(with_rotors(tree(seed, 6)))
    one, other = (derive_one(w, name, formulation).entries for formulation in (loop, "recursive"))

    _, (found,) = prove([Claim(name, loop, "lines", one, other)], seed=1)

    assert found.verdict == "proved"


def test_without_gravity_the_ground_stands_still() -> None:
    scene = tree(1, 7).with_gravity((Quantity.number(0),) * 3)
    w = Workspace(scene)

    _, (found,) = prove(
        [Claim(ID, LOOP, "rnea", *(derive_one(w, ID, formulation).entries for formulation in (LOOP, "rnea")))], seed=1
    )

    assert all(x.is_zero for x in w.joint_table.ground)
    assert found.verdict == "proved"


@pytest.mark.wide("1-float-forward_dynamics")
@BOTH
@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("seed", SEEDS)
def test_c_as_a_loop_is_as_accurate_as_its_numbers_allow(
    seed: int, real: str, name: str, loop: str, lines: str
) -> None:
    program = lower(formulate(with_rotors(tree(seed, 12)), [name], loop))

    found = measure(program, {"c": build(emit(program, "c", real, option="batch"))}, real=real)

    assert [one.passed for one in found] == [True]


@pytest.mark.slow
@pytest.mark.wide(2)
@BOTH
@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize("seed", [SEEDS[0], *(pytest.param(seed, marks=pytest.mark.slow) for seed in SEEDS[1:])])
def test_states_in_lockstep_are_those_one_by_one_and_of_lines(seed: int, name: str, loop: str, lines: str) -> None:
    scene = with_rotors(tree(seed, 24))
    over, plain = lower(formulate(scene, [name], loop, lines=False)), lower(formulate(scene, [name], lines))
    assert "a loop over a table" in str(emit(over, "c").texts)
    assert "a loop over a table" not in str(emit(plain, "c").texts)
    module, other = (getattr(build(emit(one, "c", option="batch")), name) for one in (over, plain))
    rng = np.random.default_rng(seed)
    given = rng.uniform(-3, 3, (3, 37, len(scene.velocities)))

    many = module(*given)

    assert np.allclose(many, [module(*state) for state in given.swapaxes(0, 1)], rtol=1e-12, atol=1e-12)
    size = np.abs(many).max(axis=1, keepdims=True)
    assert np.abs(many - other(*given)).max() <= 1e-11 * size.max()


@pytest.mark.wide(2)
@BOTH
@pytest.mark.long
@pytest.mark.runs("cc")
def test_one_state_and_many_have_the_same_bits(name: str, loop: str, lines: str) -> None:
    program = lower(formulate(tree(2, 90), [name], loop, lines=False))
    module = getattr(build(emit(program, "c", option="batch")), name)
    given = np.random.default_rng(1).uniform(-3, 3, (3, 19, len(tree(2, 90).velocities)))

    one = [module(*state) for state in given.swapaxes(0, 1)]

    assert (module(*given) == one).all()


@pytest.mark.slow
@DERIVATIVES
@pytest.mark.runs("cc")
@pytest.mark.parametrize("seed", SEEDS)
def test_derivatives_in_c_are_differences_of_60_digits(seed: int, name: str, loop: str) -> None:
    """At a random state, at rest and at zero; rows and columns of many states have the bits of one."""
    scene = with_rotors(tree(seed, 12))
    n = len(scene.velocities)
    module = getattr(build(emit(lower(formulate(scene, [name], loop, lines=False)), "c", option="batch")), name)
    given = np.random.default_rng(seed).uniform(-2, 2, (3, 3, n))
    given[1:, 1], given[:, 2] = 0, 0

    many = module(*given)

    for k, state in enumerate(given.swapaxes(0, 1)):
        assert (many[k] == module(*state)).all()
        wanted = differences(scene, name.removesuffix("_derivatives"), state)
        assert np.abs(many[k] - wanted).max() <= 1e-13 * np.abs(wanted).max() * (50 if name == DFD else 1)


def differences(scene: Scene, name: str, state: np.ndarray) -> np.ndarray:
    """Return central differences of an output by its lines, in arithmetic of 60 digits."""
    (routine,) = lower(formulate(scene, [name], {ID: "rnea", FD: "crba"}[name])).routines
    symbols = [x for argument in routine.function.arguments for x in argument.symbols]
    step, at, columns = BIG.number("1e-20"), [BIG.number(float(x)) for x in state.ravel()], []
    for k in range(len(symbols)):
        ends = [[x + sign * step * (j == k) for j, x in enumerate(at)] for sign in (1, -1)]
        values = [dict(zip(symbols, end, strict=True)) for end in ends]
        up, down = (evaluate(routine.function.entries, BIG, one) for one in values)
        columns.append([float((a - b) / (2 * step)) for a, b in zip(up, down, strict=True)])
    return np.array(columns).T


@DERIVATIVES
@pytest.mark.long
@pytest.mark.runs("cc")
def test_derivatives_of_a_chain_of_64_are_those_of_pinocchio(name: str, loop: str) -> None:
    pin = pytest.importorskip("pinocchio")
    n, model = 64, pin.Model()
    model.gravity = pin.Motion(np.array([0.0, 0, -9.81, 0, 0, 0]))
    turns = [pin.JointModelRZ, pin.JointModelRY]
    inertia = pin.Inertia(1.0, np.array([0.1, 0, 0]), np.diag([0.1] * 3))
    for i in range(n):
        pin_joint = model.addJoint(i, turns[i % 2](), pin.SE3(np.eye(3), np.array([0.2, 0, 0])), f"j{i}")
        model.appendBodyToJoint(pin_joint, inertia, pin.SE3.Identity())
    bodies = [body(f"b{i}", mass=1, com=["1/10", 0, 0], inertia=["1/10"] * 3, about="com") for i in range(n)]
    joints = [
        revolute(f"j{i}", f"b{i - 1}" if i else "ground", f"b{i}", axis=[0, i % 2, 1 - i % 2], origin=["1/5", 0, 0])
        for i in range(n)
    ]
    scene = declared("chain", bodies=bodies, joints=joints, gravity=[0, 0, "-9.81"])
    state, data = np.random.default_rng(0).uniform(-1, 1, (3, n)), model.createData()

    found = getattr(symdyn.load(scene, functions=name), name)(*state)

    if name == DID:
        pin.computeRNEADerivatives(model, data, *state)
        blocks = [data.dtau_dq, data.dtau_dv, data.M]
    else:
        pin.computeABADerivatives(model, data, *state)
        blocks = [data.ddq_dq, data.ddq_dv, data.Minv]
    blocks[2] = np.triu(blocks[2]) + np.triu(blocks[2], 1).T
    for mine, theirs in zip(np.hsplit(found, 3), blocks, strict=True):
        assert np.abs(mine - theirs).max() <= 1e-10 * np.abs(theirs).max()


def long_tree(joints: int) -> Scene:
    """Return a tree of so many joints that move."""
    return next(one for one in (tree(3, n) for n in range(joints, 2 * joints)) if len(one.velocities) == joints)


@pytest.mark.slow
@pytest.mark.wide(2)
@BOTH
@pytest.mark.long
def test_a_loop_is_taken_by_count_and_what_is_asked_for_at_any(few: int, name: str, loop: str, lines: str) -> None:
    short, less, many = tree(3, 6), long_tree(few - 1), long_tree(few)
    cases = ((short, None, 0), (less, None, 0), (many, None, 1), (short, loop, 1), (many, lines, 0))
    for scene, formulation, wanted in cases:
        source = emit(lower(formulate(scene, [name], formulation, lines=False)), "c").texts[f"{scene.name}.c"]
        assert source.count("a loop over a table of") == wanted
        assert source == emit(lower(formulate(scene, [name], formulation)), "c").texts[f"{scene.name}.c"]
    assert f"from {few} joints on" in emit(lower(formulate(many, [name])), "c").texts[f"{many.name}.h"]
    assert "asked for by its formulation" in emit(lower(formulate(short, [name], loop)), "c").texts[f"{short.name}.h"]


@pytest.mark.long(0)
def test_beside_functions_that_are_no_loops_the_text_is_that_of_all_together() -> None:
    scene = tree(3, 9)
    one, both = (lower(formulate(scene, [ID, "kinetic_energy"], LOOP, lines=lines)) for lines in (False, True))

    assert emit(one, "c").texts == emit(both, "c").texts


@pytest.fixture(scope="module")
def looped_and_lines() -> tuple[Program, Program]:
    scene = tree(3, 9)
    return lower(formulate(scene, [ID], LOOP, lines=False)), lower(formulate(scene, [ID]))


@pytest.mark.wide(3)
@pytest.mark.parametrize("target", [name for name, one in TARGETS.items() if one.functions is None])
def test_languages_other_than_c_get_lines(target: str, looped_and_lines: tuple[Program, Program]) -> None:
    looped, lines = (dict(emit(one, target)) for one in looped_and_lines)

    assert (looped == lines) == (target not in ("c", "ufunc"))


def test_in_lines_nothing_is_a_loop() -> None:
    program = lower(formulate(tree(3, 9), [ID], LOOP))

    assert [bool(one.function.loop) for one in program.routines] == [True]
    assert [bool(one.function.loop) for one in in_lines(program).routines] == [False]


def test_states_stand_side_by_side_as_far_as_the_stack_has_room() -> None:
    few, many, most = (room(joints, 8, 6 * joints) for joints in (10, 1500, 10**6))

    assert (few.lanes, many.lanes, most.lanes) == (LINE // 8, LINE // 16, 0)
    assert 8 * many.lockstep <= STACK


@pytest.mark.parametrize("seed", SEEDS)
def test_a_place_is_read_before_it_is_used_again_and_none_is_left_over(seed: int) -> None:
    draw = random.Random(seed)
    parents = [draw.randrange(max(0, k - 4), k) for k in range(1, 40)]
    found, most = _places(parents)
    left = {0: 0}  # which joint's values stand in a place
    for joint, (parent, (come, go)) in enumerate(zip(parents, found, strict=True), 1):
        assert left[come] == parent
        left[go] = joint

    assert most == len(left)


def test_at_rest_there_is_no_loop() -> None:
    (function,) = formulate(tree(3, 9), [ID], LOOP).at_rest().functions

    assert function.entries
    assert not function.loop
    assert in_lines(lower(formulate(tree(3, 9), [ID], LOOP, lines=False)))[ID].function.entries


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("cart_pole", "friction"),
        ("four_bar", "close it"),
        ("two_link", "have no value"),
        ("free_body", "spherical"),
        ("arm7", ""),
        ("puma560", ""),
    ],
)
def test_what_a_table_does_not_hold_is_said(name: str, words: str) -> None:
    scene = symdyn.example(name)

    said = lacking(scene)

    assert words in said
    assert bool(words) == bool(said)
    assert (LOOP in formulations_of(ID, scene)) == (not said)


def unknown_table(kinds: list[bool], fixed: int, turned: bool) -> tuple[JointTable, tuple[list[Expr], ...]]:
    """Return a chain of joints, slides or not, of unknown numbers, and its arguments."""
    graph = Graph()

    def numbers(what: str, many: int) -> list[Expr]:
        return [graph.symbol(f"{what}_{place}") for place in range(many)]

    def row(k: int, slides: bool) -> JointRow:
        zero = numbers(f"z{k}", 2) if turned or slides else [graph.one, graph.zero]
        turn, shift, moments = numbers(f"f{k}", fixed), numbers(f"p{k}", 3), numbers(f"m{k}", 4 if slides else 7)
        rise, rotor = numbers(f"r{k}", 2)
        x, y, z = shift
        return JointRow(k, slides, tuple(turn), (x, y, z), (zero[0], zero[1]), rise, rotor, tuple(moments))

    x, y, z = numbers("g", 3)
    table = JointTable((x, y, z), tuple(row(k, slides) for k, slides in enumerate(kinds)))
    return table, tuple(numbers(name, len(kinds)) for name in ("q", "v", "a"))


@pytest.mark.parametrize(("formulation", "derive"), [(LOOP, rnea_loop), (FORWARD, aba_loop)])
@pytest.mark.parametrize(
    ("slides", "fixed", "turned"),
    [(False, 2, False), (False, 9, False), (False, 2, True), (True, 2, True), (True, 9, True)],
)
def test_the_operations_that_are_told_are_those_of_the_loop(
    slides: bool, fixed: int, turned: bool, formulation: str, derive: Callable[..., list[Expr]]
) -> None:
    """One joint more, next to one of its kind, costs as much as a row whose numbers are all unknown."""
    counts = []
    for many in (1, 2):
        kinds = [*[False] * 3, *[slides] * many, *[False] * 3]
        table, given = unknown_table(kinds, fixed, turned)
        symbols = tuple(x for some in given for x in some)
        function = Function(
            "f",
            "",
            (Argument("qdd", symbols, "", ()),),
            "f",
            (len(kinds),),
            tuple(derive(table, *given)),
            "",
            formulation,
        )
        counts.append((Counts.of(function), Counts.of_loop(TableLoop(formulation, table))))
    (fewer, told_fewer), (more, told_more) = counts
    again = Counts(
        additions=slides * (len(TABLE_LOOPS[formulation].sweeps(kinds_of(table)[0])) - 1)
    )  # rise + q, each sweep

    assert str(told_more - told_fewer) == str(more - fewer + again)


def test_every_loop_has_its_row_and_every_row_its_loop() -> None:
    formulations = {
        name
        for output in (ID, FD, DID, DFD)
        for name, formulation in row_of(output)[0].formulations.items()
        if formulation.loop
    }

    assert formulations == set(TABLE_LOOPS)


@pytest.mark.long(0)
@pytest.mark.wide("double--inverse_dynamics")
@BOTH
@pytest.mark.parametrize("option", ["", "batch", "header-only"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_the_numbers_of_the_tables_are_read_back(option: str, real: str, name: str, loop: str, lines: str) -> None:
    pytest.importorskip("tree_sitter_c")
    program = lower(formulate(with_rotors(tree(4, 12)), [name], loop))
    files = files_of(emit(program, "c", real, option=option))
    numbers = printed(program, real, loops=True)

    found = prove_texts(numbers, files, languages("c", option), files.contents)

    assert {one.passed for one in found} == {True}
    assert any(one.functions == (name,) for one in found)


@pytest.mark.long(0)
@pytest.mark.wide(2)
@pytest.mark.parametrize(
    ("name", "old", "new", "where"),
    [
        (ID, "inverse_dynamics_ground[3] = {0.0, ", "inverse_dynamics_ground[3] = {1e-9, ", "another function"),
        (ID, "{0, 0, 1, ", "{0, 1, 1, ", "fixed text"),
        (FD, "forward_dynamics_ground[3] = {0.0, ", "forward_dynamics_ground[3] = {1e-9, ", "another function"),
        (FD, "x3 = ", "x3 = 2 * ", "fixed text"),
        (ID, "x3 = ", "x3 = 2 * ", "fixed text"),
    ],
)
def test_a_changed_table_or_loop_is_found(name: str, old: str, new: str, where: str) -> None:
    pytest.importorskip("tree_sitter_c")
    program = lower(formulate(tree(4, 12), [name], {ID: LOOP, FD: FORWARD}[name]))
    files = files_of(emit(program, "c"))
    (file,) = (file for file in files.contents if file.endswith(".c"))
    source = str(files.contents[file])
    changed = source.replace(old, new, 1)
    assert changed != source

    found = prove_texts(
        printed(program, "double", loops=True),
        replace(files, contents={**files.contents, file: changed}),
        READERS["c"],
        files.contents,
    )

    assert any(where in one.where for one in found)


@pytest.mark.long
@pytest.mark.runs("cc")
def test_a_large_tree_is_loaded_without_deriving_its_lines(few: int, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = long_tree(few)
    derived = []
    monkeypatch.setattr(import_module("symdyn.program.lower"), "derive_one", lambda *given: derived.append(given))
    functions = symdyn.load(scene, functions=ID)
    given = np.random.default_rng(0).uniform(-1, 1, (3, 20, few))

    many = functions.inverse_dynamics(*given)

    assert not derived
    assert np.allclose(
        many, [functions.inverse_dynamics(*state) for state in given.swapaxes(0, 1)], rtol=1e-12, atol=1e-12
    )


@pytest.mark.parametrize("lines", [False, True])
def test_where_a_joint_moves_no_mass_there_is_no_loop(lines: bool) -> None:
    arm = declared(
        "massless",
        bodies=[body("heavy", mass=1, com=[1, 0, 0], inertia=[1, 1, 1], about="com"), body("nothing")],
        joints=[revolute("a", "ground", "heavy"), revolute("b", "heavy", "nothing")],
    )
    with pytest.raises(DerivationError, match="moves no mass"):
        formulate(arm, [FD], FORWARD, lines=lines)


@pytest.mark.wide(2)
@BOTH
@pytest.mark.long
@pytest.mark.runs("cc")
def test_a_certificate_holds_loop_and_lines_together(name: str, loop: str, lines: str) -> None:
    found = symdyn.certify(tree(5, 6), [name], formulation=loop, targets=["c"])

    assert found.passed
    assert {one.claim for one in found.findings} >= {f"{name}: {loop} = {lines}", f"{name}: {loop} = lagrange"}
    assert {one.functions for one in found.written if one.verdict == "proved"} == {(name,)}


@pytest.mark.long
def test_why_a_large_mechanism_stays_lines_is_said(few: int) -> None:
    large = long_tree(few)
    damped = replace(large, joints=(replace(large.joints[0], damping=Quantity.number(1)), *large.joints[1:]))

    assert kept_in_lines(large, [ID]) == ""
    assert "damping" in kept_in_lines(damped, [ID, "pose:tool"])
    assert kept_in_lines(damped, ["mass_matrix"]) == ""
    assert kept_in_lines(tree(3, 6), [ID]) == ""

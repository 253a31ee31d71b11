"""Work on parameters alone as a function of its own: the cut, and the same values by every way to call it."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arms import EXAMPLES, two_link
from formulas import argument, every_op, function
from mechanisms import random_tree

import symdyn
import symdyn.verify.certificate as certificate_room
from symdyn.cli import main
from symdyn.dynamics import Equations
from symdyn.dynamics.outputs import Counts
from symdyn.emit import emit
from symdyn.errors import DerivationError
from symdyn.graph import Graph
from symdyn.program import Program, formulate, lower, prepare
from symdyn.runtime import build, run_python
from symdyn.runtime.library import build_extension
from symdyn.scene import Scene, bind, read
from symdyn.scene.values import Parameter
from symdyn.verdict import Verdict
from symdyn.verify import certify

pytestmark = pytest.mark.runs("cc")

ASKED = ("inverse_dynamics", "forward_dynamics", "mass_matrix", "gravity_forces", "pose:tool")
COUNTS = (1, 3, 17, 300)
PARAMS = [1.0, 1.0, 1.0, 1.0, 9.81]
STATE = ([0.3, 0.5], [1.0, -2.0], [0.7, 1.1])


def hand_made(entries, symbols, name: str = "f") -> Program:
    """Return a program f(q, params) on q, m and n."""
    q, m, n = symbols
    scene = Scene("hand", (Parameter("m"), Parameter("n")))
    f = function(name, [argument("q", [q]), argument("params", [m, n])], (len(entries),), entries)
    return lower(Equations(scene, q.graph, (f,)), ())


def symbols():
    g = Graph()
    return tuple(g.symbol(name) for name in ("q1", "m", "n"))


def texts(program: Program) -> list[str]:
    return [line.strip().rstrip(",") for line in emit(program)["hand.py"].splitlines()]


@pytest.fixture(scope="module")
def plain() -> Program:
    return lower(formulate(two_link(), ASKED))


@pytest.fixture(scope="module")
def prepared(plain) -> Program:
    return prepare(plain)


# The cut


def test_no_operation_of_a_prepared_function_is_on_parameters_alone(plain, prepared):
    first, *rest = prepared.routines
    assert first.function.name == "prepare"
    assert first.state_counts == Counts()
    for before, after in zip(plain.routines, rest, strict=True):
        assert after.prepare == Counts()
        assert after.counts == before.state_counts
        assert [a.name for a in after.function.arguments] == [
            "prepared" if a.name == "params" else a.name for a in before.function.arguments
        ]


def test_functions_share_what_they_have_in_common(plain, prepared):
    alone = [prepare(replace(plain, routines=(routine,))).routines[0] for routine in plain.routines]
    kept = len(prepared["prepare"].function.entries)
    assert kept < sum(len(one.function.entries) for one in alone)
    assert len(set(prepared["prepare"].function.entries)) == kept
    assert prepared["prepare"].counts.cost < sum((one.counts for one in alone), Counts()).cost


def test_a_sign_is_not_kept_and_a_parameter_only_where_it_is_needed():
    q, m, n = symbols()
    program = prepare(hand_made([m * n * q, -(m * n), q - m * n, m * n + n * n], (q, m, n)))
    assert [str(e.op.name) for e in program["prepare"].function.entries] == ["MUL", "ADD"]
    assert program["prepare"].counts == Counts(2, 1)
    assert {"prepared_1 * q_1", "-prepared_1", "q_1 - prepared_1", "prepared_2"} <= set(texts(program))

    raw = prepare(hand_made([n * q], (q, m, n)))
    assert [e.value for e in raw["prepare"].function.entries] == ["n"]
    assert raw["prepare"].counts == Counts()
    assert "result of prepare(params), from n" in raw["f"].function.arguments[-1].text


def test_constants_are_not_prepared_and_angles_of_parameters_are():
    q, m, n = symbols()
    g = q.graph
    program = prepare(hand_made([g.sin(m) * q + g.sqrt(2) * q + 3, g.sin(q + n)], (q, m, n)))
    kept = [str(e.op.name) for e in program["prepare"].function.entries]
    assert sorted(kept) == ["SIN", "SYMBOL"]
    assert program["prepare"].counts.sincos == 1
    assert program["f"].counts.sincos == 1


def test_without_free_parameters_nothing_changes():
    bound = bind(two_link(), {"m1": 1, "m2": 1, "h1": 1, "h2": 1, "g": 1})
    program = lower(formulate(bound, ("mass_matrix",)))
    assert prepare(program) is program
    assert not program.is_prepared


def test_a_function_may_not_have_the_name():
    q, m, n = symbols()
    with pytest.raises(DerivationError, match="a function is called prepare already"):
        prepare(hand_made([m * q], (q, m, n), "prepare"))


def test_the_rounding_is_the_same(plain, prepared):
    before, after = run_python(emit(plain)), run_python(emit(prepared))
    rng = np.random.default_rng(2)
    params = rng.uniform(0.5, 2.0, 5)
    for routine in plain.routines:
        name = routine.function.name
        state = [rng.uniform(-2, 2, (50, 2)) for _ in routine.function.arguments[:-1]]
        wanted = getattr(before, name)(*state, params)
        np.testing.assert_array_equal(getattr(after, name)(*state, after.prepare(params)), wanted)


# Every target


def ways(program: Program, batch: bool = True) -> dict[str, object]:
    return {
        "numpy": run_python(emit(program)),
        "c": build(emit(program, "c", option="batch" if batch else "")),
        "ufunc": build_extension(emit(program, "ufunc"))[1],
    }


@pytest.fixture(scope="module")
def modules(prepared):
    return ways(prepared)


@pytest.fixture(scope="module")
def reference(plain):
    return run_python(emit(plain))


@pytest.mark.parametrize("way", ["numpy", "c", "ufunc"])
@pytest.mark.parametrize("count", COUNTS)
def test_values_are_those_of_the_unprepared_functions(way, count, modules, reference, plain):
    module = modules[way]
    rng = np.random.default_rng(count)
    params = rng.uniform(0.5, 2.0, (count, 5))
    every = module.prepare(params)
    one = module.prepare(params[0])
    assert one.shape == every.shape[1:]
    np.testing.assert_allclose(every[0], one, rtol=1e-15)
    for routine in plain.routines:
        name = routine.function.name
        state = [rng.uniform(-2, 2, (count, 2)) for _ in routine.function.arguments[:-1]]
        wanted = getattr(reference, name)
        call = getattr(module, name)
        np.testing.assert_allclose(call(*state, one), wanted(*state, params[0]), rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(call(*state, every), wanted(*state, params), rtol=1e-12, atol=1e-13)
        first = [x[0] for x in state]
        np.testing.assert_allclose(call(*first, one), wanted(*first, params[0]), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("way", ["numpy", "c", "ufunc"])
def test_every_operation_survives_the_cut(way):
    program = lower(every_op())
    module, wanted = ways(prepare(program))[way], run_python(emit(program))
    rng = np.random.default_rng(1)
    q, qd, params = rng.uniform(0.2, 2, (40, 2)), rng.uniform(0.2, 2, (40, 2)), rng.uniform(0.2, 2, 1)
    for name in ("matrix", "scalar", "nothing", "rotated"):
        found = getattr(module, name)(q, qd, module.prepare(params))
        np.testing.assert_allclose(found, getattr(wanted, name)(q, qd, params), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("more", [-1, 1])
def test_a_wrong_length_is_a_value_error_in_words_of_the_target(more, modules):
    q = np.zeros(2)
    kept = len(modules["numpy"].prepare(PARAMS))
    operand = np.ones(kept + more)
    for way in ("numpy", "c"):
        with pytest.raises(ValueError, match=rf"mass_matrix: prepared has shape .* must have length {kept}"):
            modules[way].mass_matrix(q, operand)
        with pytest.raises(ValueError, match=r"prepare: params has shape \(4,\); .* must have length 5"):
            modules[way].prepare(np.ones(4))
    with pytest.raises(ValueError, match=rf"core dimension 0, with gufunc signature \(2\),\({kept}\)->\(2,2\)"):
        modules["ufunc"].mass_matrix(q, operand)
    with pytest.raises(ValueError, match=rf"gufunc signature \(5\)->\({kept}\)"):
        modules["ufunc"].prepare(np.ones(4))


def test_one_set_for_all_states_is_prepared_and_many_sets_are_states_of_prepare(prepared):
    header = emit(prepared, "c", option="batch")["two_link.h"]
    assert "prepared is one set for all states." in header
    assert "In prepare_batch and prepare_rows the sets of params are the states." in header
    source = emit(prepared, "c", option="batch")["two_link.c"]
    assert "two_link_prepare(params + k * 5, out + k * " in source
    assert "mass_matrix_block" in source
    assert "prepare_block" not in source  # loops over all parameters and all results at once compile for minutes
    assert "two_link_mass_matrix(q + k * 2, prepared, out + k * 4);" in source


def test_functions_that_need_no_parameter_prepare_nothing():
    scene = read(EXAMPLES / "two_link.toml")
    loaded = symdyn.load(replace(scene, points=()), ["jacobian:link1"], prepare=True)
    assert loaded.signatures["prepare"] == "prepare(params) -> prepared: (5)->(0)"
    assert loaded.prepare(PARAMS).shape == (0,)
    bare = symdyn.load(scene, ["jacobian:link1"])
    q = np.random.default_rng(1).uniform(-2, 2, (7, 2))
    np.testing.assert_array_equal(loaded["jacobian:link1"](q, loaded.prepare(PARAMS)), bare.jacobian_link1(q, PARAMS))


# load


def test_load_prepares_when_it_is_asked_to_and_pickles():
    arm = symdyn.load(EXAMPLES / "two_link.toml", ASKED, prepare=True)
    assert arm.prepared
    assert not symdyn.load(EXAMPLES / "two_link.toml", ASKED).prepared
    ready = arm.prepare(PARAMS)
    np.testing.assert_allclose(arm.inverse_dynamics(*STATE, ready), [18.22932611, 9.93099658], rtol=1e-9)
    assert arm.signatures["mass_matrix"] == f"mass_matrix(q, prepared) -> M: (2),({len(ready)})->(2,2)"
    assert arm["pose:tool"] is arm.pose_tool
    assert "prepared: result of prepare(params), from m1, m2, h1, h2, g" in arm.mass_matrix.__doc__
    again = pickle.loads(pickle.dumps(arm))
    assert again.prepared
    assert again.signatures == arm.signatures
    np.testing.assert_array_equal(again.inverse_dynamics(*STATE, ready), arm.inverse_dynamics(*STATE, ready))


def test_load_without_free_parameters_has_nothing_to_prepare():
    still = symdyn.load(random_tree(1, 1, False), ["mass_matrix"], prepare=True)
    assert not still.prepared
    assert "prepare" not in still.calls


# The certificate


def test_the_certificate_covers_what_is_prepared():
    certificate = certify(two_link(), ("inverse_dynamics", "mass_matrix", "k_C"), prepare=True)
    assert certificate.passed
    verdicts = {finding.claim: finding.verdict for finding in certificate.findings}
    for name in ("inverse_dynamics", "mass_matrix", "k_C"):
        assert verdicts[f"{name}: after prepare = program"] == Verdict.PROVED
    assert {(a.function, a.module) for a in certificate.accuracy} >= {("mass_matrix", "ufunc"), ("k_C", "c")}


@pytest.mark.wide(2)
@pytest.mark.parametrize("where", ["graph", "code"])
def test_a_wrong_prepare_fails_the_certificate(where, monkeypatch):
    def wrong(program: Program) -> Program:
        good = prepare(program)
        first, *rest = good.routines
        entries = first.function.entries
        spoilt = replace(first, function=replace(first.function, entries=(*entries[1:], entries[0])))
        return replace(good, routines=(spoilt, *rest))

    if where == "graph":
        monkeypatch.setattr(certificate_room, "prepare_program", wrong)
    else:
        built = certificate_room.Building.modules
        monkeypatch.setattr(
            certificate_room.Building,
            "modules",
            lambda self, *rest: built(certificate_room.Building(wrong(lower_again()), self.real), *rest),
        )
    certificate = certify(two_link(), ("mass_matrix",), prepare=True)
    assert not certificate.passed
    differ = [f.claim for f in certificate.findings if f.verdict == Verdict.DIFFERENT]
    assert ("mass_matrix: after prepare = program" in differ) == (where == "graph")
    assert any(not a.passed for a in certificate.accuracy)


def lower_again() -> Program:
    return lower(formulate(two_link(), ("mass_matrix",)))


@pytest.mark.usefixtures("numpy_alone")
def test_a_certificate_says_where_there_is_nothing_to_prepare():
    certificate = certify(random_tree(1, 1, False), ("mass_matrix",), prepare=True)
    assert certificate.passed
    assert any("nothing to prepare" in note for note in certificate.notes)


# The command line


def test_generate_and_verify_prepare(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    scene = str(EXAMPLES / "two_link.toml")
    words = ["--functions", "mass_matrix", "--prepare"]
    assert main(["generate", scene, *words, "-o", str(tmp_path)]) == 0
    text = (tmp_path / "two_link.py").read_text()
    assert "symdyn generate two_link.toml --target numpy --functions mass_matrix --prepare" in text
    assert "def mass_matrix(q, prepared, out=None)" in text
    assert emit(prepare(lower_again()))["two_link.py"].count("--target numpy --prepare --functions mass_matrix") == 1
    capsys.readouterr()
    assert main(["verify", scene, *words]) == 0
    assert "mass_matrix: after prepare = program" in capsys.readouterr().out
    assert main(["generate", str(EXAMPLES / "puma560.toml"), *words, "-o", str(tmp_path)]) == 0
    assert "nothing to prepare" in capsys.readouterr().err

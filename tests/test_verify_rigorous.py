"""Ball arithmetic holds the true value whatever it is given, and bounds of generated code hold and are sharp."""

from __future__ import annotations

import json
import math
import random
import shutil
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb
from mechanisms import random_tree

from symdyn.algebra.big import Balls, BigFloats
from symdyn.cli import main
from symdyn.dynamics import derive
from symdyn.errors import VerifyError
from symdyn.graph import Graph, Op, evaluate
from symdyn.graph.ops import ARITY, FUNCTIONS
from symdyn.scene import read
from symdyn.verify import rigorous
from symdyn.verify.rigorous import distance

EXAMPLES = Path(__file__).parent.parent / "examples"
BIG = BigFloats(60)
MODULES = {"numpy", "c", "ufunc", *(["js"] if shutil.which("node") else [])}


def result(op: Op, *balls: arb) -> arb:
    graph = Graph()
    symbols = [graph.symbol(f"x{k}") for k in range(len(balls))]
    node = graph.function(op, *symbols)
    with Balls(100) as algebra:
        return evaluate([node], algebra, dict(zip(symbols, balls, strict=True)))[0]


@pytest.mark.parametrize("op", sorted(FUNCTIONS), ids=lambda op: op.name.lower())
@pytest.mark.parametrize("wide", [0.0, 1e-12, 0.3, 2.0])
def test_a_function_of_a_ball_holds_the_function_of_every_number_inside(op: Op, wide: float) -> None:
    rng = random.Random(f"{op}{wide}")
    for _ in range(40):
        middles = [rng.choice((-1.0, 0.0, 1e-13, 0.5, 1.0, 3.0)) + rng.choice((0.0, rng.random())) for _ in range(3)]
        middles = middles[: ARITY[op]]
        held = result(op, *(arb(x, wide) for x in middles))
        for _ in range(5):
            inside = [x + wide * rng.uniform(-1, 1) for x in middles]
            try:
                value = BIG.functions[op](*map(BIG.number, inside))
            except ValueError:
                continue
            if getattr(value, "imag", 0):
                continue
            exact = arb(BIG.context.nstr(value, 50))
            assert held.overlaps(exact) or not held.is_finite(), (op, inside, held, value)


def test_a_ball_that_says_too_little_is_not_believed() -> None:
    about_zero = arb(0, 1e-20)

    assert result(Op.SQRT, about_zero).contains(arb(0))
    assert result(Op.SQRT, about_zero).is_finite()
    assert not result(Op.SQRT, arb(-1, 0.5)).is_finite()
    assert result(Op.SIGN, about_zero).contains(arb(1))
    assert result(Op.SIGN, about_zero).contains(arb(-1))
    assert result(Op.ATAN2, about_zero, arb(-1)).contains(arb(3))
    assert not result(Op.LOG, about_zero).is_finite()
    with Balls() as algebra:
        assert not algebra.div(arb(1), about_zero).is_finite()


def test_the_precision_of_before_comes_back() -> None:
    from flint import ctx

    before = ctx.prec
    with Balls(300), Balls(77):
        assert ctx.prec == 77
    assert ctx.prec == before


def test_a_distance_is_rounded_up() -> None:
    third = result(Op.SQRT, arb(2))

    assert arb(distance(1.4, third)) >= (arb(1.4) - third).abs_upper()
    assert distance(1.0, arb(1)) == 0
    assert distance(math.nan, third) == math.inf
    assert distance(1.0, arb(-1).sqrt()) == math.inf


@pytest.mark.wide(2)
@pytest.mark.runs
@pytest.mark.parametrize("seed", range(2))
def test_bounds_hold_and_are_sharp(seed: int) -> None:
    """Against the equations at 60 digits: an independent way to the same truth."""
    scene, names = random_tree(seed, 3), ("inverse_dynamics", "forward_dynamics", "mass_matrix")
    found = rigorous(scene, names, states=2)
    equations = derive(scene, names)
    modules = {bound.module for bound in found.bounds}

    assert modules == MODULES
    assert found.passed
    for bound in found.bounds:
        function, state = equations[bound.function], found.states[bound.function][bound.state]
        values = {
            symbol: BIG.number(value)
            for argument in function.arguments
            for symbol, value in zip(argument.symbols, state[argument.name], strict=True)
        }
        exact = evaluate(function.entries, BIG, values)[int(np.ravel_multi_index(bound.index, function.shape))]
        error = float(abs(BIG.number(bound.computed) - exact))
        assert error <= bound.error <= error * (1 + 1e-12) + 1e-25


@pytest.mark.runs
def test_an_error_of_the_code_is_in_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    room = import_module("symdyn.verify.rigorous")  # not the function of that name
    from symdyn.verify.building import Modules

    scene = read(EXAMPLES / "puma560.toml")
    true = np.array([b.computed for b in rigorous(scene, ("gravity_forces",), {"q2": 0.4}).bounds[:6]])
    wrong = SimpleNamespace(gravity_forces=lambda q: true + np.array([0, 1e-9, 0, 0, -3, 0]))
    monkeypatch.setattr(room, "modules_of", lambda *_: Modules({"c": wrong}, ()))

    found = rigorous(scene, ("gravity_forces",), {"q2": 0.4})

    assert [b.error for b in found.bounds] == pytest.approx([0, 1e-9, 0, 0, 3, 0], rel=1e-4, abs=1e-13)


@pytest.mark.runs
def test_where_a_result_is_not_finite_nothing_is_promised() -> None:
    found = rigorous(read(EXAMPLES / "pendulum.toml"), ("gravity_forces",), {"q1": math.inf})

    assert not found.passed
    json.dumps(found.as_dict(), allow_nan=False)


def test_a_name_that_is_no_argument_is_told() -> None:
    with pytest.raises(VerifyError, match=r"double_pendulum: q3 is no argument; known are q1, q2, q1_dot"):
        rigorous(read(EXAMPLES / "double_pendulum.toml"), ("mass_matrix",), {"q3": 1.0})


@pytest.mark.runs
def test_the_command_prints_a_row_an_entry(capsys: pytest.CaptureFixture[str]) -> None:
    scene = str(EXAMPLES / "double_pendulum.toml")
    words = ["verify", scene, "--rigorous", "--functions", "mass_matrix", "--at", "q1=0.3,q2=pi/4"]

    assert main(words) == 0
    out = capsys.readouterr().out
    assert "mass_matrix" in out
    assert "0,1" in out
    assert "Guaranteed at 1 state" in out

    assert main([*words, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["result"]
    assert facts["states"]["mass_matrix"][0]["q"] == [0.3, math.pi / 4]
    assert {row["module"] for row in facts["bounds"]} == MODULES

    assert main(["verify", scene, "--at", "q1=1"]) == 1
    assert "--at goes with --rigorous" in capsys.readouterr().err

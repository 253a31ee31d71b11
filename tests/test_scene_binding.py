"""Binding gives parameters values; a bound zero is gone before anything is derived."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest
from arms import two_link
from graphs import Fractions
from running import call

from symdyn.cli.scene_options import read_bindings
from symdyn.dynamics import available, derive
from symdyn.errors import SceneError
from symdyn.program import formulate, lower
from symdyn.scene import Quantity, bind, body, revolute, scene


def test_a_bound_parameter_has_its_value_and_the_others_stay_free():
    arm = bind(two_link(), {"m1": "2.5", "h1": 1})

    assert [p.name for p in arm.free_parameters] == ["m2", "h2", "g"]
    assert arm.parameters[0].value == Quantity.number(Fraction(5, 2))
    assert two_link().parameters[0].value is None


def test_the_scene_that_was_bound_is_left_as_it_was():
    before = two_link()
    after = two_link()
    bind(before, {"g": 0})

    assert before == after


def test_gravity_bound_to_zero_leaves_no_gravity_forces():
    program = lower(derive(bind(two_link(), {"g": 0}), ("gravity_forces", "inverse_dynamics")))

    assert all(entry.is_zero for entry in program["gravity_forces"].function.entries)
    whole = lower(derive(two_link(), ("inverse_dynamics",)))
    assert program["inverse_dynamics"].counts.cost < whole["inverse_dynamics"].counts.cost


def test_binding_is_the_same_as_giving_the_values_at_the_call():
    q, qd, qdd = ([Fraction(k, 7), Fraction(k + 1, 5)] for k in (0, 1, 2))
    values = {"m1": 2, "m2": 3, "h1": Fraction(1, 2), "h2": Fraction(1, 3), "g": 9}

    class Rational(Fractions):
        def function(self, node, args):  # any function of the angle will do
            return Fraction(1, 3) if node.op.name == "SIN" else Fraction(2, 3)

    arguments = {"q": q, "qd": qd, "qdd": qdd, "params": list(values.values())}
    free = call(derive(two_link(), ("inverse_dynamics",)), "inverse_dynamics", Rational(), **arguments)
    bound = bind(two_link(), values)
    fixed = call(derive(bound, ("inverse_dynamics",)), "inverse_dynamics", Rational(), **arguments)

    assert fixed == free


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"mass": 1}, r'"mass" is not a parameter; .*m1'),
        ({"m1": "2*h1"}, r"parameters.m1: value = 2\*h1 uses h1; a value may hold numbers and pi only"),
        ({"m1": -1}, r"parameters.m1: value = -1 is not positive"),
        ({"m1": float("nan")}, r"parameters.m1: value .*not a finite number"),
        ({"m1": "open('x')"}, r"parameters.m1: value .*no place in a formula"),
    ],
)
def test_a_value_that_cannot_be_is_refused(values, message):
    with pytest.raises(SceneError, match=message):
        bind(two_link(), values)


def test_every_fault_is_told_at_once():
    with pytest.raises(SceneError, match=r"(?s)mass.*weight"):
        bind(two_link(), {"mass": 1, "weight": 2})


def test_a_bound_zero_below_a_fraction_is_refused():
    arm = scene(
        "arm",
        parameters={"k": None},
        bodies=[body("b", mass="1/k")],
        joints=[revolute("j", "ground", "b")],
    )
    with pytest.raises(SceneError, match=r"with k = 0 a formula has no value: 1/k of b: it divides by zero"):
        bind(arm, {"k": 0})


def test_bindings_are_read_from_text():
    assert read_bindings("m1=2.5, h1 = 1/2") == {"m1": "2.5", "h1": "1/2"}
    assert read_bindings("a=atan2(1, 2*(3+1)), b=1") == {"a": "atan2(1, 2*(3+1))", "b": "1"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("m1", '"m1" gives no parameter a value; write m1=2.5,h1=1'),
        ("m1=", '"m1=" gives no parameter a value'),
        ("m1=1,", '"" gives no parameter a value'),
        ("m1=1,m1=2", "m1 gets two values, 1 and 2; give one of them"),
        ("m1=__import__('os')", "no place in a formula"),
    ],
)
def test_bindings_that_say_nothing_are_refused(text, message):
    with pytest.raises(SceneError, match=message):
        read_bindings(text)


def with_zero(name):
    """Return the two-link arm with a zero in its file."""
    parameters = (
        replace(p, value=Quantity.ZERO, positive=False) if p.name == name else p for p in two_link().parameters
    )
    return replace(two_link(), parameters=tuple(parameters))


@pytest.mark.parametrize("name", ["m2", "h1"])
def test_a_zero_in_the_file_is_as_gone_as_a_bound_one(name):
    zero, bound = with_zero(name), bind(two_link(), {name: 0})
    outputs, left_out = available(zero)
    programs = [lower(formulate(one, outputs)) for one in (zero, bound)]

    assert (outputs, left_out) == available(bound)
    assert "forward dynamics does not exist" in left_out[-1]
    assert len({tuple(map(repr, program.outputs)) for program in programs}) == 1


def test_a_zero_in_the_file_can_be_bound_to_another_value():
    programs = [lower(formulate(bind(one, {"m2": 2}), ("mass_matrix",))) for one in (with_zero("m2"), two_link())]

    assert len({tuple(map(repr, program.outputs)) for program in programs}) == 1

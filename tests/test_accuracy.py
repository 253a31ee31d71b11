"""Generated code against the textbook in plain double: the yardstick itself, and the page that was measured."""

from __future__ import annotations

import sys
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest

from symdyn.algebra.big import BigFloats
from symdyn.dynamics import Workspace, derive_one
from symdyn.graph import evaluate, substitute

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))

import accuracy
from plain_textbook import DIGITS, big_number, textbooks

CASES = {case.text: case for case in accuracy.cases()}
NUMBERS = BigFloats(60)


def at_states(one, output, states):
    """Return an output of our derivation at states, in 60 digits, shape (N, size)."""
    w = Workspace(one)
    values = {w.graph.symbol(p.name): p.value.express(w.graph) for p in one.parameters}
    function = derive_one(w, output)
    entries = substitute(function.entries, values)
    rows = []
    for k in range(len(states["q"])):
        given = {
            symbol: NUMBERS.number(float(states[argument.name][k, i]))
            for argument in function.arguments
            if argument.name != "params"
            for i, symbol in enumerate(argument.symbols)
        }
        rows.append([big_number(value) for value in evaluate(entries, NUMBERS, given)])
    return np.array(rows, dtype=object)


@pytest.mark.parametrize("text", ["PUMA 560", "SCARA", "6 axes, each leaning by 50 deg"])
@pytest.mark.parametrize("output", accuracy.OUTPUTS)
def test_the_reference_is_the_same_function_to_forty_digits(text, output):
    one = CASES[text].scene
    big, plain = textbooks(one)
    states = accuracy.draw(one, accuracy.ANGLES[1], 2, seed=3)
    states["tau"] = plain.inverse_dynamics(states["q"], states["qd"], states["qdd"])
    with localcontext(prec=DIGITS):
        found = big.reference(**{name: accuracy.to_big(values) for name, values in states.items()})[output]
        known = at_states(one, output, states)
        gap = np.max(np.abs(found.reshape(known.shape) - known))

        assert gap < np.max(np.abs(known)) * Decimal("1e-40")


@pytest.mark.wide("SCARA")
@pytest.mark.runs
@pytest.mark.parametrize("text", ["PUMA 560", "SCARA", "7-axis arm, last link 1e-12 times as heavy"])
def test_code_is_as_accurate_as_the_textbook(text):
    """A few states only: three times the bar that the page is held to."""
    for row in accuracy.measure(CASES[text], 40):
        assert row.ratio < 3 * accuracy.BAR, accuracy.line(row)


def test_the_page_holds_every_case_within_the_bar():
    text = accuracy.PAGE.read_text("utf-8")
    rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| ")][2:]
    measured = {(row[0].removeprefix("| "), row[1], row[2]): float(row[6].removesuffix(" |")) for row in rows}

    assert {name for name, _, _ in measured} == set(CASES)
    assert {output for _, _, output in measured} == set(accuracy.OUTPUTS)
    assert max(measured.values()) <= accuracy.BAR
    assert text.startswith(accuracy.HEAD.format(count=accuracy.STATES, bar=accuracy.BAR, worst=max(measured.values())))


def test_an_error_of_a_digit_is_seen():
    reference = accuracy.to_big(np.full((100, 3), 2.0))
    found = np.full((100, 3), 2.0)
    found[:5, 1] += 1e-10

    assert accuracy.percentile(found, reference) == pytest.approx(5e-11, rel=1e-3)

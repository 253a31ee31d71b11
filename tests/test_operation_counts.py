"""Operation counts, exact, so that a regression fails; and that neither frames nor conventions change them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from counts_of_literature import state_dependent_counts

from symdyn.dynamics.roads import Counts
from symdyn.graph import Graph
from symdyn.scene import dh_table, scene, with_symbolic_inertia

from formulas import one  # isort: skip

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.append(str(BENCHMARKS))

import operation_counts  # noqa: E402
from robots_dh import ROBOTS, robot_scene  # noqa: E402

COUNTS = {  # inverse dynamics, M(q), forward dynamics: multiplications, additions, divisions, pairs of sines
    "general_6r": ((373, 316, 0, 5), (327, 262, 0, 5), (743, 627, 21, 5)),
    "puma560": ((232, 205, 0, 5), (115, 114, 0, 5), (376, 354, 21, 5)),
    "stanford": ((198, 187, 0, 4), (83, 89, 0, 4), (320, 316, 21, 4)),
    "rx90": ((222, 195, 0, 5), (100, 100, 0, 5), (353, 332, 21, 5)),
    "iiwa": ((259, 240, 0, 6), (140, 132, 0, 6), (475, 453, 28, 6)),
    "panda": ((276, 257, 0, 6), (166, 155, 0, 6), (518, 493, 28, 6)),
    "puma560_diagonal": ((193, 162, 0, 5), (104, 92, 0, 5), (329, 290, 20, 5)),
    "puma560_zeros": ((169, 137, 0, 5), (80, 75, 0, 5), (275, 246, 19, 5)),
}

EMITTED = {  # the same of generated programs
    "general_6r": ((373, 316, 0, 5), (327, 262, 0, 5), (741, 623, 21, 5)),
    "puma560": ((228, 203, 0, 5), (115, 113, 0, 5), (371, 349, 21, 5)),
    "stanford": ((196, 186, 0, 4), (83, 87, 0, 4), (317, 311, 21, 4)),
    "rx90": ((218, 193, 0, 5), (100, 96, 0, 5), (348, 325, 21, 5)),
    "iiwa": ((257, 239, 0, 6), (140, 132, 0, 6), (472, 449, 28, 6)),
    "panda": ((275, 256, 0, 6), (166, 155, 0, 6), (516, 491, 28, 6)),
    "puma560_diagonal": ((188, 160, 0, 5), (104, 89, 0, 5), (325, 285, 20, 5)),
    "puma560_zeros": ((166, 135, 0, 5), (80, 75, 0, 5), (272, 244, 19, 5)),
}

PREPARED = {  # multiplications and additions of one call of the same with prepare; values that it keeps
    "general_6r": (((373, 316), (336, 253), (745, 619)), 83),
    "puma560": (((231, 200), (120, 108), (381, 339)), 66),
    "iiwa": (((259, 237), (145, 127), (480, 441)), 68),
    "puma560_zeros": (((169, 132), (84, 71), (281, 235)), 48),
}

DERIVED = {  # [dtau/dq dtau/dqd M], [dqdd/dq dqdd/dqd 1/M], C: multiplications, additions, divisions
    "general_6r": ((1850, 1530, 0), (2657, 2238, 5), (1044, 842, 0)),
    "puma560": ((1043, 963, 0), (1740, 1577, 5), (492, 421, 0)),
    "stanford": ((823, 748, 0), (1494, 1336, 5), (345, 291, 0)),
    "rx90": ((954, 875, 0), (1645, 1481, 5), (443, 373, 0)),
    "iiwa": ((1225, 1088, 0), (2262, 2016, 6), (592, 521, 0)),
    "panda": ((1352, 1209, 0), (2405, 2154, 6), (678, 605, 0)),
    "puma560_diagonal": ((924, 801, 0), (1556, 1339, 5), (459, 380, 0)),
    "puma560_zeros": ((761, 671, 0), (1353, 1191, 5), (359, 304, 0)),
}

CASES = {name: case for name, _, _, case in operation_counts.cases()}


@pytest.mark.parametrize("name", COUNTS)
def test_counts_are_these(name):
    assert operation_counts.measured(CASES[name]) == [Counts(*numbers) for numbers in COUNTS[name]]


@pytest.mark.long(0)
@pytest.mark.parametrize("name", EMITTED)
def test_emitted_counts_are_these(name):
    assert operation_counts.emitted(CASES[name]) == [Counts(*numbers) for numbers in EMITTED[name]]


@pytest.mark.long
@pytest.mark.parametrize("name", DERIVED)
def test_counts_of_derivatives_are_these(name):
    counted = operation_counts.derived(CASES[name])[:3]
    assert [(one.multiplications, one.additions, one.divisions) for one in counted] == list(DERIVED[name])


@pytest.mark.parametrize("name", PREPARED)
def test_prepared_counts_are_these(name):
    pairs, _, values = operation_counts.prepared(CASES[name])
    after = tuple((counts.multiplications, counts.additions) for _, counts in pairs)

    assert (after, values) == PREPARED[name]


def test_every_robot_is_counted():
    assert CASES.keys() == COUNTS.keys() == EMITTED.keys() == DERIVED.keys()


@pytest.mark.long
def test_the_page_is_what_the_command_writes():
    assert operation_counts.PAGE.read_text(encoding="utf-8") == operation_counts.page()


def standard_puma():
    """The PUMA 560 in a standard table: frames at the far ends of the links, other zeros of q."""
    rows = [("pi/2", "0", "0"), ("0", "a3", "0"), ("-pi/2", "a4", "d3"), ("pi/2", "0", "d4"), ("-pi/2", "0", "0")]
    rows += [("0", "0", "0")]
    links = [{"name": f"b{k}", "alpha": al, "a": a, "theta": 0, "d": d} for k, (al, a, d) in enumerate(rows)]
    bare = scene(
        "standard",
        parameters=dict.fromkeys(("a3", "a4", "d3", "d4", "g")),
        gravity=[0, 0, "-g"],
        dh=dh_table("standard", links),
    )
    return with_symbolic_inertia(bare)


def test_a_standard_table_costs_what_a_modified_one_does():
    standard, modified = operation_counts.measured(standard_puma()), operation_counts.measured(CASES["puma560"])

    assert standard == modified


def test_no_sine_is_evaluated_twice():
    for row in ROBOTS:
        turning = sum(one.type == "revolute" for one in row.rows)

        assert all(counts.sincos < turning for counts in operation_counts.measured(robot_scene(row)))


def test_what_depends_on_parameters_alone_is_left_out_and_twice_a_number_is_a_sum():
    g = Graph()
    x, m = g.symbol("x"), g.symbol("m")
    (f,) = one([m * m * x + 2 * x, g.sin(x) * g.cos(m) / m], [x]).functions
    as_parameter = f.__class__(
        **{**f.__dict__, "arguments": (f.arguments[0], f.arguments[0].__class__("params", (m,), "", ("",)))}
    )

    assert state_dependent_counts(as_parameter) == Counts(multiplications=2, additions=2, divisions=1, sincos=1)

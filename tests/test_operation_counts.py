"""Operation counts, exact, so that a regression fails; and that neither frames nor conventions change them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from symdyn.dynamics.roads.count import state_dependent_counts
from symdyn.graph import Graph
from symdyn.program import Counts
from symdyn.scene import dh_table, scene, with_symbolic_inertia

from formulas import one  # isort: skip

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.append(str(BENCHMARKS))

import operation_counts  # noqa: E402
from robots_dh import ROBOTS, robot_scene  # noqa: E402

COUNTS = {  # inverse dynamics, M(q), forward dynamics: multiplications, additions, divisions, pairs of sines
    "general_6r": ((373, 316, 0, 5), (327, 262, 0, 5), (743, 627, 21, 5)),
    "puma560": ((230, 217, 0, 5), (115, 114, 0, 5), (385, 374, 21, 5)),
    "stanford": ((201, 197, 0, 4), (83, 91, 0, 4), (328, 332, 21, 4)),
    "rx90": ((220, 207, 0, 5), (100, 100, 0, 5), (362, 352, 21, 5)),
    "iiwa": ((260, 251, 0, 6), (140, 134, 0, 6), (481, 469, 28, 6)),
    "panda": ((277, 267, 0, 6), (166, 157, 0, 6), (524, 508, 28, 6)),
    "puma560_diagonal": ((189, 167, 0, 5), (104, 92, 0, 5), (334, 302, 20, 5)),
    "puma560_zeros": ((167, 149, 0, 5), (80, 75, 0, 5), (284, 266, 19, 5)),
}

EMITTED = {  # the same of generated programs
    "general_6r": ((373, 316, 0, 5), (322, 263, 0, 5), (736, 628, 21, 5)),
    "puma560": ((229, 217, 0, 5), (115, 113, 0, 5), (380, 367, 21, 5)),
    "stanford": ((200, 197, 0, 4), (83, 87, 0, 4), (324, 327, 21, 4)),
    "rx90": ((219, 207, 0, 5), (100, 96, 0, 5), (357, 344, 21, 5)),
    "iiwa": ((259, 251, 0, 6), (140, 132, 0, 6), (477, 464, 28, 6)),
    "panda": ((277, 267, 0, 6), (166, 157, 0, 6), (521, 505, 28, 6)),
    "puma560_diagonal": ((188, 167, 0, 5), (103, 89, 0, 5), (329, 295, 20, 5)),
    "puma560_zeros": ((167, 149, 0, 5), (79, 75, 0, 5), (280, 262, 19, 5)),
}

PREPARED = {  # multiplications and additions of one call of the same with prepare; values that it keeps
    "general_6r": (((373, 316), (332, 253), (745, 619)), 77),
    "puma560": (((231, 215), (120, 108), (389, 358)), 65),
    "iiwa": (((260, 250), (145, 127), (485, 456)), 63),
    "puma560_zeros": (((169, 147), (83, 71), (288, 254)), 45),
}

DERIVED = {  # [dtau/dq dtau/dqd M], [dqdd/dq dqdd/dqd 1/M], C: multiplications, additions, divisions
    "general_6r": ((1850, 1530, 0), (2657, 2238, 5), (1044, 842, 0)),
    "puma560": ((1043, 963, 0), (1740, 1577, 5), (475, 435, 0)),
    "stanford": ((833, 760, 0), (1506, 1354, 5), (346, 313, 0)),
    "rx90": ((954, 875, 0), (1645, 1481, 5), (426, 387, 0)),
    "iiwa": ((1235, 1098, 0), (2276, 2032, 6), (598, 528, 0)),
    "panda": ((1371, 1226, 0), (2428, 2176, 6), (693, 620, 0)),
    "puma560_diagonal": ((924, 801, 0), (1556, 1339, 5), (459, 380, 0)),
    "puma560_zeros": ((761, 671, 0), (1353, 1191, 5), (348, 312, 0)),
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

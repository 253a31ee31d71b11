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
    "general_6r": ((383, 319, 0, 5), (327, 263, 0, 5), (764, 638, 21, 5)),
    "puma560": ((241, 227, 0, 5), (122, 122, 0, 5), (414, 398, 21, 5)),
    "stanford": ((212, 205, 0, 4), (83, 92, 0, 4), (350, 349, 21, 4)),
    "rx90": ((231, 217, 0, 5), (106, 106, 0, 5), (390, 374, 21, 5)),
    "iiwa": ((271, 260, 0, 6), (140, 135, 0, 6), (503, 487, 28, 6)),
    "panda": ((288, 276, 0, 6), (166, 158, 0, 6), (546, 526, 28, 6)),
    "puma560_diagonal": ((202, 175, 0, 5), (111, 100, 0, 5), (360, 320, 20, 5)),
    "puma560_zeros": ((175, 153, 0, 5), (86, 82, 0, 5), (300, 277, 19, 5)),
}

EMITTED = {  # the same of generated programs
    "general_6r": ((382, 318, 0, 5), (322, 264, 0, 5), (757, 637, 21, 5)),
    "puma560": ((240, 226, 0, 5), (122, 122, 0, 5), (412, 392, 21, 5)),
    "stanford": ((211, 204, 0, 4), (83, 87, 0, 4), (349, 343, 21, 4)),
    "rx90": ((230, 216, 0, 5), (106, 104, 0, 5), (388, 367, 21, 5)),
    "iiwa": ((270, 259, 0, 6), (140, 132, 0, 6), (502, 481, 28, 6)),
    "panda": ((287, 275, 0, 6), (166, 158, 0, 6), (544, 520, 28, 6)),
    "puma560_diagonal": ((201, 174, 0, 5), (110, 100, 0, 5), (357, 315, 20, 5)),
    "puma560_zeros": ((174, 152, 0, 5), (85, 82, 0, 5), (296, 272, 19, 5)),
}

PREPARED = {  # multiplications and additions of one call of the same with prepare; values that it keeps
    "general_6r": (((382, 318), (332, 254), (766, 628)), 87),
    "puma560": (((242, 224), (126, 118), (420, 384)), 62),
    "iiwa": (((271, 258), (145, 127), (510, 473)), 64),
    "puma560_zeros": (((176, 150), (88, 79), (303, 265)), 49),
}

DERIVED = {  # [dtau/dq dtau/dqd M], [dqdd/dq dqdd/dqd 1/M], C: multiplications, additions, divisions
    "general_6r": ((1850, 1530, 0), (2662, 2241, 5), (1044, 842, 0)),
    "puma560": ((1043, 967, 0), (1749, 1586, 5), (494, 476, 0)),
    "stanford": ((833, 764, 0), (1515, 1363, 5), (346, 313, 0)),
    "rx90": ((954, 879, 0), (1654, 1490, 5), (458, 411, 0)),
    "iiwa": ((1235, 1104, 0), (2285, 2042, 6), (598, 528, 0)),
    "panda": ((1371, 1232, 0), (2437, 2186, 6), (693, 620, 0)),
    "puma560_diagonal": ((924, 802, 0), (1565, 1344, 5), (459, 380, 0)),
    "puma560_zeros": ((761, 672, 0), (1356, 1193, 5), (378, 329, 0)),
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

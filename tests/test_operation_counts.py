"""Operation counts, exact, so that a regression fails; and that neither frames nor conventions change them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from counts_of_literature import state_dependent_counts

from symdyn.dynamics.outputs import Counts
from symdyn.graph import Graph
from symdyn.scene import dh_table, scene, with_symbolic_inertia

from formulas import one  # isort: skip

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.append(str(BENCHMARKS))

import operation_counts  # noqa: E402
from robots_dh import ROBOTS, robot_scene  # noqa: E402

COUNTS = {  # inverse dynamics, M(q), forward dynamics: multiplications, additions, divisions, pairs of sines
    "general_6r": ((373, 317, 0, 5), (327, 262, 0, 5), (743, 628, 21, 5)),
    "puma560": ((230, 227, 0, 5), (115, 114, 0, 5), (385, 382, 21, 5)),
    "stanford": ((195, 197, 0, 4), (83, 89, 0, 4), (322, 330, 21, 4)),
    "rx90": ((220, 217, 0, 5), (100, 100, 0, 5), (362, 360, 21, 5)),
    "iiwa": ((256, 255, 0, 6), (140, 132, 0, 6), (477, 471, 28, 6)),
    "panda": ((273, 271, 0, 6), (166, 155, 0, 6), (520, 510, 28, 6)),
    "puma560_diagonal": ((189, 174, 0, 5), (104, 92, 0, 5), (334, 307, 20, 5)),
    "puma560_zeros": ((168, 158, 0, 5), (80, 75, 0, 5), (285, 273, 19, 5)),
}

EMITTED = {  # the same of generated programs
    "general_6r": ((373, 317, 0, 5), (327, 262, 0, 5), (741, 624, 21, 5)),
    "puma560": ((229, 227, 0, 5), (115, 113, 0, 5), (380, 375, 21, 5)),
    "stanford": ((194, 197, 0, 4), (83, 87, 0, 4), (318, 325, 21, 4)),
    "rx90": ((219, 217, 0, 5), (100, 96, 0, 5), (357, 352, 21, 5)),
    "iiwa": ((255, 255, 0, 6), (140, 132, 0, 6), (473, 466, 28, 6)),
    "panda": ((273, 271, 0, 6), (166, 155, 0, 6), (517, 507, 28, 6)),
    "puma560_diagonal": ((188, 174, 0, 5), (104, 89, 0, 5), (330, 299, 20, 5)),
    "puma560_zeros": ((168, 158, 0, 5), (80, 75, 0, 5), (282, 269, 19, 5)),
}

PREPARED = {  # multiplications and additions of one call of the same with prepare; values that it keeps
    "general_6r": (((373, 317), (336, 253), (745, 620)), 83),
    "puma560": (((229, 227), (120, 108), (389, 366)), 65),
    "iiwa": (((255, 255), (145, 127), (480, 459)), 65),
    "puma560_zeros": (((168, 158), (84, 71), (290, 261)), 45),
}

DERIVED = {  # [dtau/dq dtau/dqd M], [dqdd/dq dqdd/dqd 1/M], C: multiplications, additions, divisions
    "general_6r": ((1944, 1557, 0), (2751, 2266, 5), (1101, 869, 0)),
    "puma560": ((1078, 980, 0), (1775, 1600, 5), (492, 421, 0)),
    "stanford": ((829, 760, 0), (1500, 1352, 5), (345, 291, 0)),
    "rx90": ((989, 892, 0), (1680, 1504, 5), (443, 373, 0)),
    "iiwa": ((1225, 1098, 0), (2262, 2030, 6), (598, 520, 0)),
    "panda": ((1352, 1218, 0), (2405, 2167, 6), (684, 604, 0)),
    "puma560_diagonal": ((959, 814, 0), (1591, 1358, 5), (472, 386, 0)),
    "puma560_zeros": ((800, 693, 0), (1397, 1220, 5), (359, 304, 0)),
}

CASES = {name: case for name, _, _, case in operation_counts.cases()}


@pytest.mark.parametrize("name", COUNTS)
def test_counts_are_these(name):
    assert operation_counts.measured(CASES[name]) == [Counts(*numbers) for numbers in COUNTS[name]]


@pytest.mark.wide(3)
@pytest.mark.long(0)
@pytest.mark.parametrize("name", EMITTED)
def test_emitted_counts_are_these(name):
    assert operation_counts.emitted(CASES[name]) == [Counts(*numbers) for numbers in EMITTED[name]]


@pytest.mark.wide(3)
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


@pytest.mark.slow
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

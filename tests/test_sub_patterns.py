"""The search for cheaper forms of sub-patterns finds what is there, and nothing else."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.append(str(BENCHMARKS))

import operation_counts  # noqa: E402
import sub_patterns  # noqa: E402


@pytest.mark.parametrize(
    ("pattern", "steps", "found"),
    [
        ("((x0*x1)+(x0*x2))", 2, True),  # x0 (x1 + x2)
        ("((x0*x1)-(x2*x3))", 2, False),
        ("([y2!=(x0*x1)]+(x0*x2))", 2, False),  # x0 x1 is kept
        ("(x0-[y3!=(x0-[y2=(x1*x2)])])", 2, True),  # y2 and x0 - y2
        ("((x0-[y3=(x1*x2)])-(x0+y3))", 2, True),  # -2 x1 x2
        ("(((x0*x0)+(x1*x1))+((x0*x1)+(x0*x1)))", 2, True),  # (x0 + x1)^2
        ("(((x0*x0)+(x1*x1))-(x0*x1))", 3, False),
    ],
)
def test_a_cheaper_form_is_found_where_there_is_one(pattern, steps, found):
    assert sub_patterns.cheaper(*sub_patterns.values(pattern), steps) == found


def test_patterns_of_an_arm_are_told_by_what_goes_in():
    arm = next(scene for name, _, _, scene in operation_counts.cases() if name == "puma560_zeros")
    found = list(sub_patterns.patterns(arm, 3))

    assert "((x0*x1)-(x2*x3))" in found  # a turn

"""What a target from outside is worth: every law of targets holds for it.

`tests/test_recipes.py` runs this in a fresh process, where the target is one file that is imported here.
"""

import pytest
from awk_target import AWK
from test_targets import *  # noqa: F403
from test_targets_run import *  # noqa: F403

pytestmark = [pytest.mark.runs, pytest.mark.parametrize("name", [AWK.name])]


def test_it_stands_beside_the_others(name: str) -> None:
    assert list(TARGETS)[-1] == name  # noqa: F405
    assert running(name, lower(every_op()))  # noqa: F405  nothing below is skipped

"""What is generated is, byte for byte, what it was when tests/data/net.txt was written."""

from __future__ import annotations

import pytest

from tests.net import SCENES, known, lines

EVERY_RUN = ("struts", "sled", "cart_pole", "pendulum")


@pytest.mark.wide("cart_pole")
@pytest.mark.long(0)
@pytest.mark.parametrize("example", EVERY_RUN)
def test_generated_files_are_those_of_the_list(example: str) -> None:
    assert list(lines(example)) == known(example)


@pytest.mark.slow
@pytest.mark.parametrize("example", [name for name in SCENES if name not in EVERY_RUN])
def test_every_generated_file_is_that_of_the_list(example: str) -> None:
    assert list(lines(example)) == known(example)

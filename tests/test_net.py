"""What is generated from the examples is, byte for byte, what it was when tests/data/net.txt was written."""

from __future__ import annotations

import pytest

from tests.net import EXAMPLES, known, lines


@pytest.mark.parametrize("example", ["pendulum", "cart_pole"])
def test_generated_files_are_those_of_the_list(example: str) -> None:
    assert list(lines(example)) == known(example)


@pytest.mark.slow
@pytest.mark.parametrize("example", [name for name in EXAMPLES if name not in ("pendulum", "cart_pole")])
def test_every_generated_file_is_that_of_the_list(example: str) -> None:
    assert list(lines(example)) == known(example)

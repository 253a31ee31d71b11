"""Numbers that nobody here made: published and independently computed values, kept as text so that no digit is lost."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from symdyn.algebra.big import BigFloats

DATA = Path(__file__).parent / "data"

BIG = BigFloats(60)
"""Where oracles are compared; their texts carry 30 to 40 digits."""


def oracle(name: str) -> dict[str, Any]:
    """Return the oracle in data/<name>.json; its "source", "desc" or "convention" says where it comes from."""
    return json.loads((DATA / f"{name}.json").read_text(encoding="utf-8"))


def numbers(texts: Iterable[str]) -> list[Any]:
    """Return decimal texts as big floats."""
    return [BIG.number(text) for text in texts]


def flat(matrix: Iterable[Iterable[str]]) -> list[str]:
    """Return the entries of a matrix, row by row."""
    return [entry for row in matrix for entry in row]


def relative_error(found: Sequence[Any], given: Sequence[str]) -> Any:
    """Return the largest deviation over the largest given value (over 1 if all are zero)."""
    expected = numbers(given)
    assert len(found) == len(expected), f"{len(found)} values found, {len(expected)} given"
    scale = max(abs(value) for value in expected) or 1
    return max(abs(a - b) for a, b in zip(found, expected, strict=True)) / scale


def assert_digits(found: Sequence[Any], given: Sequence[str], tolerance: str | float = "1e-30") -> None:
    """Fail unless `found` has the digits of the texts `given`, to a tolerance relative to the largest."""
    error = relative_error(found, given)
    assert error <= BIG.number(tolerance), f"relative error {float(error):.3g}: {found} is not {given}"

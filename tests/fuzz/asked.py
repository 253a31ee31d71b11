"""What a page asks of a scene's text: `answer(what, text, how)`, whatever stands in the three."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random
from typing import Any

from symdyn.emit import TARGETS
from symdyn.scene import examples

from .grammar import NASTY, chance
from .mutate import spoil

NAME = "answer"
"""Stands in a case in place of a verb; behind it the file of the text, what is asked, and how, in JSON."""

OFTEN = {"scene": 8, "equations": 4, "coefficients": 4, "picture": 8, "code": 3, "motion": 1, "lesson": 0.5}
"""What is asked of a text, and how often."""

SELDOM = {"begin": 0.1, "example": 1.0, "": 0.5}
"""What is asked of no text, or is nothing that can be asked."""

LARGEST = 2**24
"""Characters of an answer to a scene of few bodies."""


def drawn(rng: Random) -> tuple[list[str], dict[str, bytes]]:
    """Return what is asked, and how, one in three times not as a page does it."""
    rows = OFTEN | SELDOM
    what = rng.choices(tuple(rows), tuple(rows.values()))[0] or str(rng.choice(NASTY))[:80]
    how: dict[str, Any] = {
        "pulled": {rng.choice(("q1", "q2", "x", "theta")): rng.uniform(-9, 9) for _ in range(rng.choice((0, 1, 2)))},
        "language": rng.choice(("en", "sk")),
        "target": rng.choice((*TARGETS, "")),
        "name": rng.choice(examples()),
    }
    return [what, json.dumps(spoil(rng, how, rng.choice((1, 2, 4)) if chance(rng, 0.35) else 0))], {}


def run(argv: Sequence[str]) -> int:
    """Ask, print all texts of the answer, and return 1 where it is a refusal; raises what is wrong with it."""
    from symdyn.playground import answers

    if len(argv) != 4:
        print("answer FILE WHAT HOW", file=sys.stderr)
        return 2
    _, file, what, said = argv
    text, how = Path(file).read_bytes().decode(errors="surrogateescape"), json.loads(said)
    found = answers.answer(what, text, how)
    if "failed" in found and what in answers.OF_NO_TEXT:
        answers.OF_NO_TEXT[what](how)  # raises it at its place
    elif "failed" in found:
        answers.ANSWERS[what](answers.Asked(text, answers.Settings()), how)
    assert "failed" not in found, found["failed"]
    written = json.dumps(found, allow_nan=False)
    if what not in ("motion", "lesson"):  # they take seconds
        assert written == json.dumps(answers.answer(what, text, how)), "another answer the second time"
    assert len(written) < LARGEST, len(written)
    lines = text.split("\n")
    for fault in found.get("faults", ()):
        assert 1 <= fault["line"] <= len(lines) + 1, fault
        assert min(fault["column"], fault["length"] + 1) >= 1, fault
    for one in texts(found):
        print(one.encode(errors="backslashreplace").decode())
    return int("faults" in found or "refused" in found)


def texts(value: Any) -> Iterator[str]:
    """Yield the texts of an answer, keys among them."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, (dict, list, tuple)):
        for one in (*value, *value.values()) if isinstance(value, dict) else value:
            yield from texts(one)

"""What a lesson says in place of what is worked out in numbers: Python in a page of a browser has no SciPy."""

from __future__ import annotations

from importlib.util import find_spec

from symdyn.teach.document import Words
from symdyn.teach.lesson import Prose


def elsewhere(lesson: Prose, what: str) -> Words | None:
    """Return the sentence that says what is left out, a key after "elsewhere.", and who shows it; None with SciPy."""
    return None if find_spec("scipy.integrate") else lesson.say("elsewhere", what=lesson.say(f"elsewhere.{what}"))

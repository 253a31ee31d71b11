"""What is worked out once has no lock that a forked child could find shut."""

from __future__ import annotations

import os
import re
import threading
from pathlib import Path

import pytest
from children import forked, status_of
from patience import HANG

import symdyn
from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs import workspace
from symdyn.unlocked import cached_property

ROOT = Path(symdyn.__file__).parent


class Counted:
    """Something that is worked out, and how often."""

    times = 0

    @cached_property
    def found(self) -> int:
        """How often it was worked out."""
        self.times += 1
        return self.times


def test_it_is_worked_out_once_an_object() -> None:
    one, other = Counted(), Counted()
    assert (one.found, one.found, one.times, other.times) == (1, 1, 1, 0)
    del one.found
    assert one.found == 2
    assert Counted.found.__doc__ == "How often it was worked out."


@pytest.mark.long(0)
def test_nobody_takes_that_of_the_standard_library() -> None:
    taken = []
    for path in ROOT.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        names = re.findall(r"^\s*from functools import (\([^)]*\)|.*)", text, re.MULTILINE)
        if any(re.search(r"\bcached_property\b", one) for one in names) and path.name != "unlocked.py":
            taken.append(str(path.relative_to(ROOT)))
    assert not taken, f"{taken}: take it from symdyn.unlocked, forked children wait for the other for ever"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
@pytest.mark.runs
def test_a_child_forked_while_a_thread_derives_derives_for_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, build = symdyn.example("four_bar"), workspace.build_tree
    inside, on = threading.Event(), threading.Event()

    def slow(*given):
        inside.set()
        assert on.wait(HANG)
        return build(*given)

    monkeypatch.setattr(workspace, "build_tree", slow)
    thread = threading.Thread(target=lambda: Workspace(scene).tree)
    thread.start()
    assert inside.wait(HANG)

    def at_once() -> object:
        workspace.build_tree = build
        return Workspace(scene).tree

    child = forked(at_once)
    try:
        assert status_of(child) == 0
    finally:
        on.set()
        thread.join()

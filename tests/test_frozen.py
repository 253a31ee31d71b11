"""A frozen dataclass of ours is one of the standard library, in all that one sees of it."""

from __future__ import annotations

import dataclasses
import inspect
import pickle
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest

import symdyn
from symdyn import frozen

ROOT = Path(symdyn.__file__).parent


def made(dataclass: Callable[..., Any]) -> tuple[type, type, type]:
    """Return three classes, of which the second has all that a field can be, and one that inherits from it."""

    @dataclass(frozen=True)
    class Point:
        x: float
        y: float = 0.0

    @dataclass(frozen=True)
    class Course:
        points: tuple[Point, ...]
        called: str = "path"
        marks: dict[str, int] = dataclasses.field(default_factory=dict, compare=False)
        seen: list[int] = dataclasses.field(default_factory=list, init=False, repr=False, compare=False, hash=False)
        COUNT: ClassVar[int] = 3

        def __post_init__(self) -> None:
            if not self.called:
                raise ValueError("a path needs a name")

    @dataclass(frozen=True)
    class Loop(Course):
        turns: int = 1

        def __hash__(self) -> int:
            return 7

    return Point, Course, Loop


OURS, THEIRS = made(frozen.dataclass), made(dataclasses.dataclass)


def looks(kind: tuple[type, type, type]) -> Iterator[object]:
    """Yield what one sees of three classes."""
    point, path, loop = kind
    a, b = path((point(1.0), point(2, y=3))), path((point(1.0), point(2.0, 3.0)), marks={"k": 1})
    yield from (str(inspect.signature(one)) for one in kind)
    yield from (repr(one) for one in (a, b, loop((), "l", turns=2)))
    yield from (a == b, hash(a) == hash(b), a == loop(a.points), loop(()) == loop((), turns=2), a != 3, hash(loop(())))
    yield from (hash(point(1.0)), a.seen, a.seen is b.seen, a.marks is b.marks, path.COUNT, path.__match_args__)
    yield from (dataclasses.replace(b, called="q"), dataclasses.asdict(b), [one.name for one in dataclasses.fields(b)])
    yield from (path.__init__.__qualname__, point.__init__.__annotations__, dataclasses.is_dataclass(point))
    for wrong in (
        point, lambda: point(1, 2, 3), lambda: point(1, z=2), lambda: path((), ""),
        lambda: setattr(a, "called", "b"), lambda: setattr(a, "other", "b"), lambda: delattr(a, "called"),
        lambda: setattr(loop(()), "called", "b"), lambda: {point([])},
    ):  # fmt: skip
        with pytest.raises((TypeError, ValueError, AttributeError)) as told:
            wrong()
        yield type(told.value), str(told.value)


def test_it_is_that_of_the_standard_library() -> None:
    for ours, theirs in zip(looks(OURS), looks(THEIRS), strict=True):
        assert repr(ours) == repr(theirs)


def test_what_is_asked_for_is_left_out_or_kept() -> None:
    @frozen.dataclass(frozen=True, eq=False, repr=False)
    class Thing:
        inside: int

    thing = Thing(1)
    assert (thing == Thing(1), thing in {thing}, repr(thing)[0], thing.inside) == (False, True, "<", 1)

    @frozen.dataclass
    class Loose:
        inside: int = 0

    loose = Loose()
    loose.inside = 2
    assert loose == Loose(2)
    with pytest.raises(TypeError, match="without a default"):
        frozen.dataclass(frozen=True)(type("Wrong", (), {"__annotations__": {"a": "int", "b": "int"}, "a": 1}))


def test_a_scene_is_pickled_and_its_classes_say_where_their_names_stand() -> None:
    scene = symdyn.example("four_bar")
    again = pickle.loads(pickle.dumps(scene))
    assert (again, hash(again)) == (scene, hash(scene))
    assert inspect.get_annotations(type(scene).__init__, eval_str=True)["name"] is str


@pytest.mark.long(0)
def test_frozen_classes_are_all_made_here() -> None:
    taken = []
    for path in ROOT.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        names = re.findall(r"^\s*from dataclasses import (\([^)]*\)|.*)", text, re.MULTILINE)
        if "dataclass(frozen=True" in text and path.stem != "frozen":
            taken += [str(path.relative_to(ROOT))] * any(re.search(r"\bdataclass\b", one) for one in names)
    assert not taken, f"{taken}: take dataclass from symdyn.frozen, where it is made in a fifth of the time"

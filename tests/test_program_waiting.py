"""What waits while registers are short: everything is at hand when it is read, no place has two tenants."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Hashable

import pytest

from symdyn.emit.code.schedule import schedule, schedule_in_turn
from symdyn.emit.code.spelling import REALS
from symdyn.emit.targets import gpu_budget
from symdyn.emit.targets.gpu_budget import Line, Plan, Task, budget, plan


def some_lines(seed: int) -> list[Line]:
    """Return lines that read what came before, some of which make two values and some none."""
    rng = random.Random(seed)
    values: list[Hashable] = [f"argument{i}" for i in range(8)]
    lines = []
    for number in range(120):
        made = tuple(f"x{number}{letter}" for letter in "abcd"[: rng.choice([0, 1, 1, 1, 2])])
        lines.append(Line(made, tuple(sorted(set(rng.choices(values, k=3)))), rng.choice([0, 0, 0, 3])))
        values += made
    return lines


def most_held(lines: list[Line], found: Plan) -> int:
    """Follow a plan, look at all that it may do wrong, and return how many values a line needs held at most.

    What waits and is held as well may be let go without a word, and is not counted unless the line reads it.
    """
    back = Counter(move.value for move in found.moves if move.line < 0 and not move.kept and move.place >= 0)
    made = {value for line in lines for value in line.makes}
    left = {value: sum(value in line.reads for line in lines) for line in lines for value in line.reads}
    held: set[Hashable] = set()
    places: dict[int, Hashable] = {}
    used: set[int] = set()
    most = 0
    for move in found.moves:
        if move.kept:
            held.remove(move.value)
            assert move.place not in places, "somebody sits there"
            places[move.place] = move.value
            used.add(move.place)
        elif move.line < 0 and move.place >= 0:
            assert places[move.place] == move.value, "somebody else sits there"
            held.add(move.value)
            back[move.value] -= 1
            if not back[move.value]:
                del places[move.place]
        elif move.line < 0:
            assert move.value not in made
            held.add(move.value)
        else:
            line = lines[move.line]
            assert held.issuperset(line.reads)
            most = max(most, len((held - set(places.values())).union(line.reads)) + line.spare)
            for value in line.reads:
                left[value] -= 1
            held = {value for value in held if left[value]} | {value for value in line.makes if left.get(value)}
    assert used == set(range(found.places))
    assert not places
    assert [move.line for move in found.moves if move.line >= 0] == list(range(len(lines)))
    return most


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("registers", [7, 12, 30])
def test_what_is_read_is_held_and_no_more_than_there_are_registers(seed: int, registers: int) -> None:
    lines = some_lines(seed)
    found = plan(lines, range(len(lines)), registers)

    assert most_held(lines, found) <= registers
    assert plan(lines, range(len(lines)), registers) == found


def test_nothing_moves_where_registers_are_enough() -> None:
    lines = some_lines(1)
    found = plan(lines, range(len(lines)), 1000)

    assert found.places == 0
    assert not any(move.kept for move in found.moves)


def test_a_value_that_waited_once_is_not_stored_again() -> None:
    lines = [Line(("a",), ("x",)), Line(("b",), ("y",)), Line((), ("b",)), Line((), ("a",)), Line(("c",), ("z",))]
    lines += [Line((), ("c",)), Line((), ("a",))]
    moves = plan(lines, range(7), 1).moves

    assert [move.kept for move in moves if move.value == "a"] == [True, False, False]


def test_results_in_turn_make_what_they_need_first() -> None:
    rng = random.Random(3)
    lines = [(f"x{i}", [f"x{rng.randrange(i)}" if i else "q"]) for i in range(60)]
    lines += [(None, [f"x{i}"]) for i in range(60)]
    groups = [[60 + i for i in range(60) if i % 4 == k] for k in (3, 2, 1, 0)]
    order = schedule_in_turn(lines, groups)

    assert sorted(order) == list(range(120))
    at = {lines[place][0]: time for time, place in enumerate(order)}
    assert all(at.get(value, -1) < time for time, place in enumerate(order) for value in lines[place][1])
    last = [max(order.index(place) for place in group) for group in groups]
    assert last == sorted(last)
    assert last != sorted(max(schedule(lines).index(place) for place in group) for group in groups)


@pytest.mark.parametrize(("real", "first"), [("double", 2), ("float", 0)])
def test_sines_of_arguments_come_first_where_they_are_calls(
    real: str, first: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gpu_budget, "REGISTERS", {real: 1})
    lines = [Line(("a",), ("x",)), Line((), ("a",)), Line(("sine",), ("q",), 40), Line((), ("a", "sine"))]
    (found,) = budget(Task(lines, [1] * 4, [[1], [3]], 2, REALS[real])).plans
    assert next(move.line for move in found.moves if move.line >= 0) == first

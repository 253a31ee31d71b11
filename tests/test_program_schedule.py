"""The order of lines: each after what it reads, and few values alive at a time."""

from __future__ import annotations

import random

import pytest
from arms import EXAMPLES
from mechanisms import random_tree

from symdyn.dynamics import derive
from symdyn.emit.code.schedule import most_alive, schedule, schedule_backwards
from symdyn.emit.code.spelling import operands
from symdyn.emit.targets.c.plan import TRIGONOMETRIC, plan
from symdyn.program import lower
from symdyn.scene import read


def alive(lines, order) -> list[int]:
    """Return how many values are alive after each line."""
    last = {value: time for time, place in enumerate(order) for value in lines[place][1]}
    held: set = set()
    counts = []
    for time, place in enumerate(order):
        made, needed = lines[place]
        held |= {*needed, made} & last.keys()
        held -= {value for value in held if last[value] <= time}
        counts.append(len(held))
    return counts


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("way", [schedule, schedule_backwards])
def test_every_line_comes_once_and_after_what_it_reads(way, seed):
    rng = random.Random(seed)
    values = [f"argument{i}" for i in range(5)]
    lines = []
    for i in range(80):
        needed = sorted(set(rng.choices(values, k=rng.randint(1, 3))))
        made = f"x{i}" if rng.random() < 0.9 else None
        lines.append((made, needed))
        values += [made] if made else []
    order = way(lines)
    assert sorted(order) == list(range(80))
    at = {lines[place][0]: time for time, place in enumerate(order)}
    assert all(at.get(value, -1) < time for time, place in enumerate(order) for value in lines[place][1])
    assert way(lines) == order


def test_a_sum_of_many_products_needs_two_places():
    lines = [(f"p{i}", [f"a{i}", f"b{i}"]) for i in range(50)]
    lines += [(f"s{i}", [f"s{i - 1}" if i else "zero", f"p{i}"]) for i in range(50)]
    lines += [(None, ["s49"])]
    assert max(alive(lines, range(101))) == 50
    for way in (schedule, schedule_backwards):
        assert max(alive(lines, way(lines))) <= 2
        assert most_alive(lines, way(lines)) == 4, "the sum, the product, and two that are read"


def lines_of(program, output):
    """Return what is made and read by the lines of a function, sines and cosines taken as arguments."""
    routine = program[output]
    steps = [step for step in routine.steps if step.node.op not in TRIGONOMETRIC]
    lines = [(step.node, operands(step.node.args, routine.names, program.constants)) for step in steps]
    return lines + [(None, operands((entry,), routine.names, program.constants)) for entry in routine.function.entries]


@pytest.mark.parametrize("output", ["inverse_dynamics", "mass_matrix"])
def test_an_arm_keeps_fewer_values_alive_than_its_program_does(output):
    program = lower(derive(read(EXAMPLES / "arm7.toml"), (output,)))
    lines = lines_of(program, output)
    assert sum(alive(lines, schedule(lines))) < 0.9 * sum(alive(lines, range(len(lines))))


@pytest.mark.parametrize(
    ("output", "better"), [("inverse_dynamics", schedule), ("forward_dynamics_derivatives", schedule_backwards)]
)
def test_neither_end_is_always_the_better_one_to_begin_at(output, better):
    lines = lines_of(lower(derive(read(EXAMPLES / "arm7.toml"), (output,))), output)
    assert min((schedule, schedule_backwards), key=lambda way: most_alive(lines, way(lines))) is better


@pytest.mark.long(0)
def test_a_long_function_is_cut_where_few_values_wait():
    program = lower(derive(random_tree(1, 16, free=False), ("inverse_dynamics",)))
    rows = plan(program["inverse_dynamics"], program.constants).rows
    assert rows <= 180, "226 in the order of the program"

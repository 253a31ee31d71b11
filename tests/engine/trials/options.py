"""What is drawn beside a mechanism: how it is told, and every option that exploits structure, pair by pair.

Two options together find what neither finds alone, three together little more; so the first cases hold every pair of
values, and later ones are random. Reference: Cohen, Dalal, Fredman, Patton, The AETG system (1997).
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from functools import cache
from itertools import combinations

OPTIONS: Mapping[str, tuple[str, ...]] = {  # what stands there more than once comes more often
    "family": ("tree", "coupled", "planar", "space", "wheels", "blades"),
    "natural": ("", "zero", "equal", "right"),  # the start: random, or angles of one kind
    "told": ("numbers", "parameters", "free", "zero"),  # free: without values; zero: some bound to zero
    "symbols": ("", "inertia", "geometry", "all", "open"),  # --symbolic; open: all of them without values
    "acting": ("nothing", "springs", "dampers", "friction", "loads", "everything"),
    "lead": ("", "motion", "locked"),
    "formulation": (
        "preferred",
        "rnea",
        "crba",
        "aba",
        "lagrange",
        "last",
    ),  # --formulation; last: the table's last formulation
    "asked": ("dynamics", "coefficients", "kinematics"),  # beside what drives, loops and joints exert and do
    "rest": ("moving", "moving", "moving", "static"),  # --static
    "prepare": ("", "prepare"),
    "real": ("double", "double", "double", "float"),
    "call": ("one", "batch", "broadcast"),
    "closing": ("", "independent", "baumgarte"),
    "axes": ("body", "joint", "ground"),
    "reading": ("text", "rewritten"),
    "hung": ("", "", "turned"),  # some joints are declared from the child towards the ground
}

PAIRED, CANDIDATES = 75, 40

Choice = dict[str, str]


def choice(seed: int) -> Choice:
    """Return the options of a case, the same every time; the first `PAIRED` hold every pair of values."""
    if seed < PAIRED:
        return covering()[seed]
    rng = random.Random(f"choice {seed}")
    return {name: rng.choice(values) for name, values in OPTIONS.items()}


@cache
def covering() -> tuple[Choice, ...]:
    """Return options of which any two values meet."""
    rng = random.Random("pairs")
    open_pairs = {((a, x), (b, y)) for a, b in combinations(OPTIONS, 2) for x in OPTIONS[a] for y in OPTIONS[b]}
    found: list[Choice] = []
    while len(found) < PAIRED:
        must = dict(min(open_pairs, default=()))  # a pair that has to come, so that none is left over
        drawn = [{name: rng.choice(values) for name, values in OPTIONS.items()} | must for _ in range(CANDIDATES)]
        best = max(drawn, key=lambda one: len(pairs(one) & open_pairs))
        open_pairs -= pairs(best)
        found.append(best)
    return tuple(found)


def pairs(choice: Choice) -> set[tuple[tuple[str, str], tuple[str, str]]]:
    """Return all pairs of values of a choice."""
    return set(combinations(((name, choice[name]) for name in OPTIONS), 2))

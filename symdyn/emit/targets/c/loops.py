"""What the template of a loop over a table of joints is given: its sweeps at a joint of each kind, and the rows.

Sweeps are printed from expressions. All loops have the rows in common, and how much room they take.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from symdyn.algebra import constants
from symdyn.dynamics import Pairs, Sweep, TableLoop
from symdyn.emit.code.spelling import Printer
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, reachable
from symdyn.scene import Scene

LINE = 64
"""Bytes of the states side by side: one vector of the widest kind. Two and four ran no faster from 256 joints on."""

STACK = 576 * 1024
"""Bytes of work space that states side by side may take: those of 1,024 joints. More joints halve the states."""

GROUP = 8
"""Sines are taken of a multiple of so many angles."""

TILE = 32
"""Rows of work space of entries of states that lie apart."""

PANEL = 4
"""Vectors of right sides that are solved together, of the widest kind: one alone waits for itself."""

NUMBERS = 9
"""Numbers of a row before those of its body: two of a turn, three of a shift, two of a turn, offset and rotor."""


@dataclass(frozen=True)
class Rows:
    """The tables of a loop.

    Attributes:
        joints, matrices: rows of the tables as C, and of fixed turns that are not about x.
        ground: acceleration of the ground, as C.
        turned: whether a joint stands turned at zero.
        places: how many places there are for what waits for others.
    """

    joints: tuple[str, ...]
    matrices: tuple[str, ...]
    ground: str
    turned: bool
    places: int


@dataclass(frozen=True)
class Room:
    """Work space, in numbers."""

    one: int  # of one state
    lanes: int  # states side by side; 0 where they would not fit on the stack
    lockstep: int  # of these, all at once


def rows_of(
    loop: TableLoop, scene: Scene, printer: Printer, kinds: Sequence[int], more: Sequence[Sequence[int]] = ()
) -> Rows:
    """Return the rows of the table of a loop; `kinds` are their kinds by number, `more` what else is told of them."""
    table = loop.table
    literals = map(printer.literal, table.in_order(scene))
    ground = braces([next(literals) for _ in table.ground])
    rows, matrices = [], 0
    places, most = _places([row.parent for row in table.rows])
    for i, (row, (come, go)) in enumerate(zip(table.rows, places, strict=True)):
        whole = (row.parent, come, go, kinds[i], matrices, int(not row.at_zero), *(more[i] if more else ()))
        matrices += len(row.fixed) > 2
        numbers = [next(literals) for _ in range(NUMBERS)]
        rows.append(braces([*map(str, whole), *numbers, braces([next(literals) for _ in range(table.MOMENTS)])]))
    turns = tuple(braces([next(literals) for _ in range(9)]) for _ in range(matrices))
    return Rows(tuple(rows), turns, ground, any(not row.at_zero for row in table.rows), most)


def room(joints: int, width: int, rows: int, besides: bool = True) -> Room:
    """Return the work space of sines and cosines of all joints and of so many rows; a number takes `width` bytes.

    States stand side by side if they do `besides`.
    """

    def work(lanes: int) -> int:
        return 2 * (-(-joints * lanes // GROUP) * GROUP) + (rows + TILE * (lanes > 1)) * lanes

    lanes = LINE // width if besides else 0
    while lanes and work(lanes) * width > STACK:
        lanes //= 2
    lanes = lanes if lanes > 1 else 0
    return Room(work(1), lanes, work(lanes))


def whole(numbers: int) -> int:
    """Return so many numbers, or the next more with which a line of the cache ends, of doubles or of floats."""
    return -(-numbers // 16) * 16


def braces(texts: Sequence[str]) -> str:
    """Return a list of C."""
    return f"{{{', '.join(texts)}}}"


def _places(parents: Sequence[int]) -> tuple[list[tuple[int, int]], int]:
    """Return where each joint finds what its parent left and leaves its own, and how many places there are.

    A place is used again when the last joint that is carried from there has read it. The ground has the first. On the
    way back the same places do for what joints hand to their parents.
    """
    last = {parent: i for i, parent in enumerate(parents, 1)}
    place, free, most = {0: 0}, list[int](), 1
    found = []
    for i, parent in enumerate(parents, 1):
        if not free:
            free.append(most)
            most += 1
        place[i] = free.pop()
        found.append((place[parent], place[i]))
        if last[parent] == i and parent:
            free.append(place[parent])
        if i not in last:
            free.append(place[i])
    return found, most


ROW = ("joint", "matrix")
"""How numbers begin that are the same for all states."""


FEW = 24
"""Rows handed on up to which registers hold them and what a step works with, in the order in which it is written."""


@dataclass(frozen=True)
class StepText:
    """A step at a joint as C: lines that give names their values, and places with what is written there.

    A line is a name, what it stands for, and whether that is one number for all states.
    """

    lines: tuple[tuple[str, str, bool], ...]
    written: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class SweepText:
    """One sweep."""

    name: str  # of the sweep
    inward: bool  # whether it goes from the tips to the ground
    steps: tuple[StepText, ...]  # at a joint of every kind, each once, however many kinds have it
    kinds: tuple[tuple[int, ...], ...]  # of each step those that do
    rows: int  # how many rows are handed on
    ground: tuple[tuple[int, int], ...]  # where it starts with the acceleration of the ground, rows and entries of that
    ones: tuple[int, ...]  # where it starts with a one
    reads: tuple[str, ...]  # arguments that it reads
    finds: str  # where it writes an entry of every joint: "out", or what later sweeps read as an argument; "" for none
    pairs: bool  # whether pairs of joints are gone through after its steps


@dataclass(frozen=True)
class PairsText:
    """Pairs of joints and all that they carry, in an order in which what one carries stands together."""

    steps: tuple[StepText, ...]  # of a parent that turns, then of one that slides, of those that there are
    pitch: int  # numbers from a row of what goes along to the next; there are as many as joints, to whole vectors
    goes: int  # rows of what goes along with a joint
    found: tuple[tuple[bool, int], ...]  # entries of a pair: rows and blocks as in `BOTH_WAYS`
    in_order: bool  # whether that order is the one of the table
    branched: bool  # whether a joint is neither carried by another one nor carries it
    solved: int  # how many columns of right sides with M are solved together at the end, 0 for none at all

    @property
    def rows(self) -> int:
        """Rows of work space, of numbers."""
        return (self.goes + len(self.found)) * self.pitch


@dataclass(frozen=True)
class LoopText:
    """A loop over a table.

    Attributes:
        rows, room: the tables and the work space.
        given: names of the arguments.
        sweeps: in order.
        turns: how many kinds are turns, which come first.
        kinds: how many kinds of joints there are.
        width: bytes of a number.
        place: rows of work space of a place, where what is handed on waits for others.
        own: rows that a joint keeps from sweep to sweep.
        found: what is found on the way and read like an argument.
        pairs: where pairs of joints are gone through.
        sincos, parts: as of functions in stages: it takes sines by a routine of our own, and is not in parts.
    """

    rows: Rows
    room: Room
    given: tuple[str, ...]
    sweeps: tuple[SweepText, ...]
    turns: int
    kinds: int
    width: int
    place: int
    own: int
    found: tuple[str, ...] = ()
    sincos: bool = True
    parts: tuple[()] = ()
    pairs: PairsText | None = None

    @property
    def behind(self) -> int:
        """Where right sides stand in the work space of one state, which begin where a vector may."""
        return whole(self.room.one)

    @property
    def numbers(self) -> int:
        """Work space of one state, with that of right sides and of a row of factors."""
        solved = self.pairs.solved if self.pairs else 0
        return self.behind + len(self.rows.joints) * (solved + 1) if solved else self.room.one

    def lanes(self, line: int) -> int:
        """Return how many states a vector of so many bytes holds, as far as there is room."""
        return min(self.room.lanes or LINE, line // self.width)

    @property
    def crowded(self) -> bool:
        """Whether steps keep more numbers than registers hold unless they come in the right order."""
        return self.place > FEW

    @property
    def slides(self) -> bool:
        return self.turns < self.kinds


def loop_text(loop: TableLoop, given: Sequence[str], scene: Scene, printer: Printer, width: int) -> LoopText:
    """Return what the template needs of a loop over a table of a scene; a number takes `width` bytes."""
    table, kinds = loop.table, loop.kinds
    known = sorted(set(kinds))
    last = {row.parent: i for i, row in enumerate(table.rows) if row.parent != i}  # of children that do not follow
    more: list[tuple[int, ...]] = [
        (int(i + 1 in last), int(last.get(row.parent) == i)) for i, row in enumerate(table.rows)
    ]
    steps = list(zip(*(loop.algorithm.sweeps(kind) for kind in known), strict=True))
    found = tuple(ways[0].finds for ways in steps if ways[0].finds)
    at = {
        **{name: f"*{name}" for name in ("cosine", "sine", *given, *found)},
        **{name: f"joint->{name}" for name in ("c", "s", "x", "y", "z", "offset", "rotor")},
        **{f"b{k}": f"joint->b[{k}]" for k in range(table.MOMENTS)},
        **{f"matrix{k}": f"matrix[{k}]" for k in range(9)},
        **{f"{ways[0].keeps}{k}": _row("kept", k) for ways in steps for k in range(len(ways[0].kept))},
    }
    sweeps = tuple(_sweep((*given, *found), ways, printer, at) for ways in steps)
    pairs = None
    if (last := steps[-1][0].pairs) is not None:
        spans = _spans(loop)
        ways = tuple(_pair(last, slides, printer) for slides in sorted({one.slides for one in known}))
        n, whole = len(spans), LINE // width
        in_order = all(joint == k for k, (_, _, joint) in enumerate(spans))
        branched = any(end < n for _, end, _ in spans)
        pitch, panel = -(-n // whole) * whole, PANEL * whole * last.solved
        pairs = PairsText(ways, pitch, len(last.starts), Pairs.BOTH_WAYS, in_order, branched, panel)
        more = [(*flags, *span) for flags, span in zip(more, spans, strict=True)]
    rows = rows_of(loop, scene, printer, [known.index(one) for one in kinds], more)
    place, own = max(one.rows for one in sweeps), max(len(ways[0].kept) for ways in steps)
    besides = (pairs.rows if pairs else 0) + len(found) * len(kinds)
    space = room(len(kinds), width, own * len(kinds) + place * (rows.places + 1) + besides, not pairs)
    turns = sum(not one.slides for one in known)
    return LoopText(rows, space, tuple(given), sweeps, turns, len(known), width, place, own, found, pairs=pairs)


def _spans(loop: TableLoop) -> list[tuple[int, int, int]]:
    """Return, by joint, its number in an order where what it carries follows it, where that ends, and who is there."""
    table = loop.table
    n, many, parents = len(table.rows), [0, *table.carried], [row.parent for row in table.rows]
    first, free = [0] * (n + 1), [0] * (n + 1)
    for i, parent in enumerate(parents, 1):
        first[i] = free[parent]
        free[parent] += many[i]
        free[i] = first[i] + 1
    who = {first[i]: i - 1 for i in range(1, n + 1)}
    return [(first[i], first[i] + many[i], who[i - 1]) for i in range(1, n + 1)]


def _sweep(given: Sequence[str], ways: Sequence[Sweep], printer: Printer, at: Mapping[str, str]) -> SweepText:
    """Return a sweep; of what might be handed on only what a joint of any kind reads is."""
    first = ways[0]
    reads = set[str]().union(*(one.reads for one in ways))
    handed = [k for k in range(len(first.handed)) if f"{first.takes}{k}" in reads]
    here = {**at, **{f"{first.takes}{k}": _row("now", place) for place, k in enumerate(handed)}}
    start = [] if first.ground is None else [(first.ground + k, k) for k in range(3)]
    kinds: dict[StepText, tuple[int, ...]] = {}
    for kind, one in enumerate(ways):
        step = _step(one, handed, printer, here)
        kinds[step] = (*kinds.get(step, ()), kind)
    return SweepText(
        first.name,
        first.inward,
        tuple(kinds),
        tuple(kinds.values()),
        len(handed),
        tuple((handed.index(row), k) for row, k in start if row in handed),
        tuple(handed.index(row) for row in first.ones if row in handed),
        tuple(name for name in given if name in reads),
        first.finds or ("" if first.result is None else "out"),
        first.pairs is not None,
    )


def _pair(pairs: Pairs, slides: bool, printer: Printer) -> StepText:
    """Return the step of pairs whose parent slides or turns, at `k` of rows that lie side by side."""
    rows = {f"{Pairs.CARRIED}{r}": f"{Pairs.CARRIED}[{r} * pitch + k]" for r in range(len(pairs.starts))}
    at = rows | {f"{name}{k}": _row(name, k) for name in (pairs.keeps, Pairs.ABOVE) for k in range(pairs.kept)}
    results = [*zip(rows.values(), pairs.goes, strict=True)]
    results += [(f"found[{r} * pitch + k]", x) for r, x in enumerate(pairs.found[slides])]
    return written(results, printer, at, (f"{pairs.keeps}[", f"{Pairs.ABOVE}["))


def _row(of: str, place: int) -> str:
    return f"{of}[{place}]"


def _step(sweep: Sweep, handed: Iterable[int], printer: Printer, at: Mapping[str, str]) -> StepText:
    """Return a step: places, and what is written there."""
    results = [(_row("now", place), sweep.handed[k]) for place, k in enumerate(handed)]
    results += [(_row("kept", k), x) for k, x in enumerate(sweep.kept)]
    results += [] if sweep.result is None else [("*result", sweep.result)]
    if sweep.pairs:
        results += [(_row("starts", k), x) for k, x in enumerate((*sweep.pairs.starts, *sweep.pairs.own))]
    return written(results, printer, at, ROW)


def written(
    results: Sequence[tuple[str, Expr]], printer: Printer, at: Mapping[str, str], same: tuple[str, ...]
) -> StepText:
    """Return lines that write results at places; what begins so is the same wherever they run side by side."""
    nodes = reachable([entry for _, entry in results])
    known = constants([node for node in nodes if node.op is Op.CONSTANT])
    symbols = {node: str(node.value) for node in nodes if node.op is Op.SYMBOL}
    work = [node for node in nodes if node.args and node.op is not Op.NEG]
    names = {node: f"{name}1" if at[name].startswith("*") else name for node, name in symbols.items()}
    names |= {node: f"x{k}" for k, node in enumerate(work, 1)}
    whole = {node for node, name in symbols.items() if at[name].startswith(same)} | set(known)
    for node in nodes:
        if node.args and whole.issuperset(node.args):
            whole.add(node)
    lines = [(names[node], at[name], node in whole) for node, name in symbols.items()]
    lines += [(names[node], printer.definition(node, names, known), node in whole) for node in work]
    written = [
        (place, "nothing" if x.is_zero else "nothing + " * (x in whole) + printer.code(x, names, known))
        for place, x in results
    ]
    return StepText(tuple(lines), tuple(written))

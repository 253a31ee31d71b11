"""What the template of forward dynamics as a loop is given: three steps a kind of joint, printed from `aba_loop`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symdyn.dynamics.recursive.aba_loop import BESIDES, INERTIA, MOTION, JointSteps, kinds_of, steps_of
from symdyn.dynamics.recursive.joint_table import JointTable
from symdyn.emit.code.operators import Printer
from symdyn.emit.targets.c.loops.rows import Room, Rows, room, rows_of
from symdyn.graph import Expr, Op, reachable
from symdyn.graph.ops import SYMBOL
from symdyn.program.constants import constants
from symdyn.scene import Scene

OWN = BESIDES + 1
"""Rows of work space that a joint keeps from step to step."""


ENTRIES = {"cosine": "*cosine", "sine": "*sine", "q": "*position", "qd": "*rate", "tau": "*force"}
"""What a step finds where."""

LOCAL = {"cosine": "c1", "sine": "s1", "q": "q1", "qd": "qd1", "tau": "tau1"}
"""What a step calls its own."""


ROW = ("joint", "matrix")
"""How numbers begin that are the same for all states."""


@dataclass(frozen=True)
class StepText:
    """A step at a joint as C: lines that give names their values, and places with what is written there.

    A line is a name, what it stands for, and whether that is one number for all states.
    """

    lines: tuple[tuple[str, str, bool], ...]
    written: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class ForwardText:
    """Forward dynamics as a loop.

    Attributes:
        rows, room: the tables and the work space.
        steps: outward, inward and besides, of every kind of joint, turns first.
        turns: how many kinds are turns.
        matrices: which kinds have matrices.
        width: bytes of a number.
        place: rows of work space of a place: of a motion, an articulated inertia or accelerations.
        motion, inertia: rows of a motion, of an articulated inertia.
        sincos, parts: as of functions in stages: it takes sines by a routine of our own, and is not in parts.
    """

    rows: Rows
    room: Room
    steps: tuple[tuple[StepText, StepText, StepText], ...]
    turns: int
    width: int
    place: int
    motion: int
    inertia: int
    own: int = OWN
    sincos: bool = True
    parts: tuple[()] = ()
    guarded: bool = True
    template: str = "c/loop_forward.c.jinja"

    def lanes(self, line: int) -> int:
        """Return how many states a vector of so many bytes holds, as far as there is room."""
        return min(self.room.lanes, line // self.width)

    @property
    def slides(self) -> bool:
        """Whether a joint slides."""
        return self.turns < len(self.steps)

    @property
    def made_of(self) -> tuple[str, ...]:
        """Endings of the functions that are its own."""
        steps = [f"{way}{k}" for way in ("outward", "inward", "besides") for k in range(len(self.steps))]
        ways = [*steps, "motion", "inertia", "more", "add", "none", "loop"]
        return ("vec", *(f"{kind}_{way}" for kind in ("one", "vec") for way in ways))


def forward_text(table: JointTable, scene: Scene, printer: Printer, width: int) -> ForwardText:
    """Return what the template needs of a table of a scene; a number takes `width` bytes."""
    kinds = kinds_of(table)
    known = sorted(set(kinds))
    last = {row.parent: i for i, row in enumerate(table.rows) if row.parent != i}  # of children that do not follow
    more = [(int(i + 1 in last), int(last.get(row.parent) == i)) for i, row in enumerate(table.rows)]
    rows = rows_of(table, scene, printer, [known.index(one) for one in kinds], more)
    steps = [steps_of(kind) for kind in known]
    motion = _read("motion", MOTION, [(*one.motion, *one.bias) for one in steps])
    inertia = _read("inertia", INERTIA, [(*one.share, *one.inertia) for one in steps])
    place = max(len(motion), len(inertia), BESIDES)
    joints = len(table.rows)
    return ForwardText(
        rows,
        room(joints, width, OWN * joints + place * (rows.places + 1)),
        tuple(_texts(one, printer, motion, inertia) for one in steps),
        sum(not one.slides for one in known),
        width,
        place,
        len(motion),
        len(inertia),
    )


def _read(name: str, many: int, results: Sequence[Sequence[Expr]]) -> list[int]:
    """Return which numbers of a place are read by any of the steps."""
    read = {str(node.value) for some in results for node in reachable(some) if node.op is SYMBOL}
    return [k for k in range(many) if f"{name}{k}" in read]


def _texts(
    steps: JointSteps, printer: Printer, motion: list[int], inertia: list[int]
) -> tuple[StepText, StepText, StepText]:
    at = {
        **ENTRIES,
        **{name: f"joint->{name}" for name in ("c", "s", "x", "y", "z", "rise", "rotor")},
        **{f"b{k}": f"joint->b[{k}]" for k in range(7)},
        **{f"matrix{k}": f"matrix[{k}]" for k in range(9)},
        **{f"motion{k}": _row("now", place) for place, k in enumerate(motion)},
        **{f"inertia{k}": _row("now", place) for place, k in enumerate(inertia)},
        **{f"bias{k}": _row("kept", k) for k in range(BESIDES)},
        **{f"share{k}": _row("kept", k) for k in range(OWN)},
        **{f"besides{k}": _row("now", k) for k in range(BESIDES)},
    }
    out = [(_row("now", place), steps.motion[k]) for place, k in enumerate(motion)]
    out += [(_row("kept", k), x) for k, x in enumerate(steps.bias)]
    back = [(_row("kept", k), x) for k, x in enumerate(steps.share)]
    back += [(_row("now", place), steps.inertia[k]) for place, k in enumerate(inertia)]
    on = [("*result", steps.qdd), *((_row("now", k), x) for k, x in enumerate(steps.besides))]
    return _text(out, printer, at), _text(back, printer, at), _text(on, printer, at)


def _row(of: str, place: int) -> str:
    return f"{of}[{place}]"


def _text(results: Sequence[tuple[str, Expr]], printer: Printer, at: Mapping[str, str]) -> StepText:
    """Return a step: places, and what is written there."""
    nodes = reachable([entry for _, entry in results])
    known = constants([node for node in nodes if node.op is Op.CONSTANT])
    symbols = {node: str(node.value) for node in nodes if node.op is SYMBOL}
    work = [node for node in nodes if node.args and node.op is not Op.NEG]
    names = {node: LOCAL.get(name, name) for node, name in symbols.items()}
    names |= {node: f"x{k}" for k, node in enumerate(work, 1)}
    whole = {node for node, name in symbols.items() if at[name].startswith(ROW)} | set(known)
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

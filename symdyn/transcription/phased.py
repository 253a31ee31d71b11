"""An optimal control problem in phases: one problem for each, and what joins them where contacts strike or part.

    z = [z of phase 1 | z of phase 2 | … | P, Λ of every passage]
    g = [g of phase 1 | g of phase 2 | … | rows of every passage | Σ T]

    rows of a passage    q⁺ = q⁻,  s⁺ = s⁻,  parameters,  momentum,  law,  g = 0 where it touches,  cones of impulses

Positions stay where phases meet, velocities change by impulses, see `contact_entries`. All durations together are the
time of the end.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from symdyn.algebra import Array
from symdyn.scene import Scene
from symdyn.transcription.grid import Places, numbered
from symdyn.transcription.local import PLACES, Local
from symdyn.transcription.nonlinear_program import NonlinearProgram
from symdyn.transcription.phases import Phase, Sides, bound_passage
from symdyn.transcription.transcribed import Collocation
from symdyn.unlocked import cached_property


@dataclass(frozen=True, eq=False)
class Passage:
    """What joins two phases.

    Attributes:
        place: of each kind of unknown of its functions, where it stands in z.
        row: of each kind of its equations, where it stands in g.
        law: α, β and ζ of each row.
        continuous: places before and behind it of what stays, shape (2, nq + ns + parameters).
    """

    place: Mapping[str, Places]
    row: Mapping[str, Places]
    law: Array
    continuous: Places

    def at(self, z: Array) -> dict[str, Array]:
        """Return the unknowns of its functions by kind, one row each."""
        found = {kind: z[place] if kind == "free" else z[None, place] for kind, place in self.place.items()}
        return {**found, "law": self.law}


@dataclass(frozen=True, eq=False)
class Phased(NonlinearProgram):
    """An optimal control problem of a scene with contacts, in phases.

    Attributes:
        scene: the mechanism, as its writer has it.
        schedule: what is closed, sticks, slips and strikes.
        problems: those of each phase.
        passages: what joins them.
        times: where the durations that are unknown stand in z.
        size, rows: number of unknowns and of equations.
        lower, upper: bounds of z, shape (size,).
        rows_lower, rows_upper: bounds of g, shape (rows,).
        guess: z of straight ways between what is given, without forces and impulses, shape (size,).
        notes: what a user should know, one line each.
    """

    scene: Scene = field(repr=False)
    schedule: tuple[Phase, ...]
    problems: tuple[Collocation, ...] = field(repr=False)
    passages: tuple[Passage, ...] = field(repr=False)
    times: Places = field(repr=False)
    size: int
    rows: int
    lower: Array = field(repr=False)
    upper: Array = field(repr=False)
    rows_lower: Array = field(repr=False)
    rows_upper: Array = field(repr=False)
    guess: Array = field(repr=False)
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        what = [", ".join((*one.closed, *one.slips)) or "open" for one in self.schedule]
        counts = f"{self.size} unknowns, {self.rows} equations"
        return f"<Phased of {self.scene.name}: {' | '.join(what)}; {counts}>"

    @property
    def parts(self) -> tuple[Collocation, ...]:
        """The problems of each phase."""
        return self.problems

    # Values

    def residual(self, z: Array) -> Array:
        """Return g(z), shape (rows,)."""
        g = np.empty(self.rows, np.result_type(z, np.float64))
        each = [one.residual(part) for one, part in zip(self.parts, self.split(z), strict=True)]
        g[: sum(map(len, each))] = np.concatenate(each)
        for one in self.passages:
            at = one.at(z)
            g[one.row["stays"]] = z[one.continuous[1]] - z[one.continuous[0]]
            for name, local in self.joining.items():
                g[one.row[name]] = local.value(at)[0]
        g[-1] = z[self.times].sum()
        return g

    def objective(self, z: Array) -> float:
        """Return f(z)."""
        return sum(one.objective(part) for one, part in zip(self.parts, self.split(z), strict=True))

    def gradient(self, z: Array) -> Array:
        """Return ∂f/∂z, shape (size,)."""
        parts = [one.gradient(part) for one, part in zip(self.parts, self.split(z), strict=True)]
        return np.concatenate([*parts, np.zeros(self.size - sum(map(len, parts)))])

    def jacobian_values(self, z: Array) -> Array:
        """Return the entries of ∂g/∂z at (`jacobian_rows`, `jacobian_columns`), shape (nonzeros,)."""
        values = [one.jacobian_values(part) for one, part in zip(self.parts, self.split(z), strict=True)]
        for one in self.passages:
            at, ones = one.at(z), np.ones(len(one.continuous[0]))
            values += [-ones, ones, *(local.slopes(at)[0] for local in self.joining.values())]
        return np.concatenate([*values, np.ones(len(self.times))])[self._entries[0]]

    @property
    def jacobian_rows(self) -> Places:
        """Rows of the entries of ∂g/∂z that are not always zero, ascending, shape (nonzeros,)."""
        return self._entries[1]

    @property
    def jacobian_columns(self) -> Places:
        """Their columns, ascending in each row; none occurs twice."""
        return self._entries[2]

    @property
    def _offsets(self) -> list[Places]:
        """Where unknowns and equations of each phase begin."""
        return [np.cumsum([0, *(getattr(one, what) for one in self.parts[:-1])]) for what in ("size", "rows")]

    @cached_property
    def _entries(self) -> tuple[Places, Places, Places]:
        """The order of the entries, and their rows and columns."""
        rows, columns = list[Places](), list[Places]()
        for one, column, row in zip(self.parts, *self._offsets, strict=True):
            rows.append(row + one.jacobian_rows)
            columns.append(column + one.jacobian_columns)
        for passage in self.passages:
            rows += [passage.row["stays"]] * 2
            columns += [*passage.continuous]
            for name, local in self.joining.items():
                rows.append(passage.row[name][[i for i, _, _ in local.pattern]])
                columns.append(np.array([passage.place[kind][k] for _, kind, k in local.pattern], dtype=np.int64))
        rows.append(np.full(len(self.times), self.rows - 1))
        down, across = np.concatenate(rows), np.concatenate([*columns, self.times])
        order = np.lexsort((across, down))
        return order, down[order], across[order]

    def time(self, z: Array) -> float:
        """Return the time of the end, s."""
        return float(sum(one.time(part) for one, part in zip(self.parts, self.split(z), strict=True)))

    @property
    def joining(self) -> dict[str, Local]:
        """The functions of passages."""
        known = self.parts[0].source.locals
        return {name: known[name] for name in PASSING if name in known}


PASSING = tuple(name for name, where in PLACES.items() if where == "passage")
"""Functions of passages."""


def joined(
    scene: Scene,
    schedule: tuple[Phase, ...],
    parts: tuple[Collocation, ...],
    span: tuple[float, float],
    notes: tuple[str, ...],
) -> Phased:
    """Return the problem of phases whose durations together are within a span, s."""
    written, passages = parts[0].source.written, list[Passage]()
    columns, rows = (np.cumsum([0, *(getattr(one, what) for one in parts)]) for what in ("size", "rows"))
    count, stays = len(parts) - 1, sum(parts[0].place[kind].shape[-1] for kind in ("q", "s", "free"))
    impulses, size = numbered({"impulse": (count, len(written.contacts.impulses))})
    shapes = {"stays": (count, stays)} | {name: (count, len(written.entries[name])) for name in PASSING}
    numbers, height = numbered({**shapes, "time": (1,)})

    def side(name: str, *more: float) -> Array:
        return np.concatenate([*(getattr(one, name) for one in parts), more])

    lower, upper = side("lower", *[-np.inf] * size), side("upper", *[np.inf] * size)
    low, high = (side(name, *[0.0] * height) for name in ("rows_lower", "rows_upper"))
    for k, (left, right) in enumerate(pairwise(parts)):
        a, b, node = columns[k], columns[k + 1], left.grid.node[-1]
        place = {"q": b + right.place["q"][0], "u": b + right.place["u"][0], "free": b + right.place["free"]}
        place |= {"before": a + left.place["u"][node], "impulse": columns[-1] + impulses["impulse"][k]}
        row = {name: rows[-1] + places[k] for name, places in numbers.items() if name != "time"}
        ends = ((left.place, a, node), (right.place, b, 0))
        stay = [at + np.concatenate([own["q"][i], own["s"][i], own["free"]]) for own, at, i in ends]
        sides = Sides(place, row, lower, upper, low, high)
        law = bound_passage(sides, written.contacts, *schedule[k : k + 2])
        passages.append(Passage(place, row, law, np.stack(stay)))
    times = np.concatenate([at + one.place["T"] for at, one in zip(columns, parts, strict=False)])
    known = sum(one.duration for one in parts if not len(one.place["T"]))
    low[-1], high[-1] = span[0] - known, span[1] - known
    guess = np.clip(side("guess", *[0.0] * size), lower, upper)
    sizes = len(lower), len(low)
    return Phased(scene, schedule, parts, tuple(passages), times, *sizes, lower, upper, low, high, guess, notes)

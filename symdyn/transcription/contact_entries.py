"""What contacts add to the functions of a place, and the functions of the passage between two phases.

    w, λ, Λ      rows n and t of contacts, their forces and impulses           g       gaps
    c, h, z      1 where a contact is closed, where it sticks as well, the sign of its slip: numbers of a phase

    balance      - Wᵀ λ;  then  c (n u̇ + γ) + (1 - c) λn  and  h (t u̇ + γ) + (1 - h) (λt + z μ λn)
    held         c g,  c n u,  h t u,  with what the end of an interval gives way by, as of loops
    cone         h (μs λn ∓ λt),  along two directions  h (μs² λn² - |λt|²)               at stages
    open         (1 - c) g,  z t u                                                        at nodes

Between two phases positions stay, and velocities change from u⁻ to u⁺ by impulses, P those of loops and rows:

    momentum     M (u⁺ - u⁻) - Gᵀ P - Wᵀ Λ
    law          α w u⁺ + β e w u⁻ + (1 - α) (Λ + ζ μ Λn)  of each row of G and W, α, β, ζ numbers of the passage
    touch        g
    struck       μ Λn ∓ Λt,  ζ s⁺,  ζ (e s⁻ + s⁺),  along two directions  μ² Λn² - |Λt|²

So a mode is numbers, and one set of compiled functions serves all phases, as in runs.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5, 6 and 8.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from operator import sub

from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs import Touch, dot, touching
from symdyn.frozen import dataclass
from symdyn.graph import Expr, tangents

Rows = Sequence[Sequence[Expr]]


@dataclass(frozen=True)
class Contacts:
    """Contacts on a graph, with the symbols of their forces.

    Attributes:
        touches: the contacts.
        forces: λ, shape (m,).
        before, impulses: u⁻, shape (nv,); P and Λ, shape (rows of G + m,).
        law: α, β and ζ of each row of G and W.
    """

    touches: tuple[Touch, ...]
    forces: tuple[Expr, ...]
    before: tuple[Expr, ...]
    impulses: tuple[Expr, ...]
    law: tuple[Expr, ...]

    @classmethod
    def of(cls, w: Workspace, held: int) -> Contacts:
        """Return those of a scene that has so many rows of loops and constraints; none of one without phases."""
        touches = touching(w) if w.scene.unilaterals else ()
        count = sum(len(one.rows) for one in touches)

        def symbols(name: str, count: int) -> tuple[Expr, ...]:
            return tuple(w.graph.symbol(f"{name}[{k}]") for k in range(count if touches else 0))

        struck = held + count
        sizes = {"contact": count, "before": w.state.n, "impulse": struck, "law": 3 * struck}
        return cls(touches, *(symbols(name, size) for name, size in sizes.items()))

    @property
    def mode(self) -> tuple[Expr, ...]:
        """c, whether it sticks, and z of each."""
        return tuple(x for one in self.touches for x in one.mode[:3])

    @property
    def rows(self) -> list[tuple[Expr, ...]]:
        """W, shape (m, nv)."""
        return [row.entries for one in self.touches for row in one.rows]

    def parts(self, of_rows: Sequence[Expr]) -> Iterator[tuple[Touch, Expr | None, Sequence[Expr]]]:
        """Yield each contact with what its rows have: of n, None where there is none, and of each t."""
        rest = iter(of_rows)
        for one in self.touches:
            yield one, next(rest) if one.normal else None, [next(rest) for _ in one.tangents]

    @property
    def holds(self) -> list[Expr]:
        """What holds each row: c, or h."""
        found = []
        for one, normal, along in self.parts(self.forces):
            closed, sticks, *_ = one.mode
            found += [*([] if normal is None else [closed]), *[closed * sticks for _ in along]]
        return found

    @property
    def gaps(self) -> list[tuple[Expr, Expr, tuple[Expr, ...]]]:
        """c, g and n of each that has a gap."""
        return [(one.mode[0], one.gap, one.normal.entries) for one in self.touches if one.normal]

    def balance(self, acceleration: Sequence[Expr]) -> list[Expr]:
        """Return the rows of the balance from w u̇ + γ."""
        pushed: list[Expr] = []
        for one, normal, along in self.parts(self.forces):
            pushed += [] if normal is None else [normal]
            slip = one.mode[2] * one.friction
            pushed += [force + slip * (1 if normal is None else normal) for force in along]
        rows = zip(self.holds, acceleration, pushed, strict=True)
        return [hold * rate + (1 - hold) * push for hold, rate, push in rows]

    def held(self, velocities: Sequence[Expr]) -> list[Expr]:
        """Return the rows that are held at nodes from u."""
        rates = [hold * dot(row, velocities) for hold, row in zip(self.holds, self.rows, strict=True)]
        return [*(closed * gap for closed, gap, _ in self.gaps), *rates]

    def pulled(self, slacks: Sequence[Expr], n: int) -> tuple[list[Expr], list[Expr]]:
        """Return Wᵀ of what positions, and of what velocities, give way by, each of shape (nv,)."""
        normals = [[closed * x for x in row] for closed, _, row in self.gaps]
        rows = [[hold * x for x in row] for hold, row in zip(self.holds, self.rows, strict=True)]
        zero = slacks[0].graph.zero
        return _across(normals, slacks[: len(normals)], n, zero), _across(rows, slacks[len(normals) :], n, zero)

    @property
    def cone(self) -> list[Expr]:
        """What is not negative where they stick."""
        found = []
        for one, normal, along in self.parts(self.forces):
            held = one.mode[0] * one.mode[1]
            found += [held * x for x in _within(one.static * (1 if normal is None else normal), along)]
        return found

    def open(self, velocities: Sequence[Expr]) -> list[Expr]:
        """Return what is not negative of gaps, then of slips along one direction."""
        slips = [one.mode[2] * dot(one.tangents[0].entries, velocities) for one in self.touches if one.tangents]
        return [*((1 - closed) * gap for closed, gap, _ in self.gaps), *slips]

    def passage(self, w: Workspace, G: Rows, forces: Sequence[Expr]) -> dict[str, list[Expr]]:
        """Return the functions between two phases; `forces` are those of inverse dynamics."""
        graph, n = w.graph, w.state.n
        rows, kicked = [*G, *self.rows], self.impulses[len(G) :]
        change = dict(zip(w.state.qdd, map(sub, w.state.qd, self.before), strict=True))
        kicks = _across(rows, self.impulses, n, graph.zero)
        rubs, bounces = [graph.zero] * len(G), [graph.zero] * len(G)
        struck: list[Expr] = []
        for one, normal, along in self.parts(kicked):
            size = graph.zero if normal is None else one.friction * normal
            rubs += [*([] if normal is None else [graph.zero]), *[size for _ in along]]
            bounces += [*([] if normal is None else [one.restitution]), *[graph.zero for _ in along]]
            struck += _within(size, along)
            if len(along) == 1:
                tangent, slips = one.tangents[0].entries, self.law[3 * len(rubs) - 1]
                ends, began = (dot(tangent, u) for u in (w.state.qd, self.before))
                struck += [slips * ends, slips * (one.restitution * began + ends)]
        law = []
        for k, row in enumerate(rows):
            ends, begins, slips = self.law[3 * k : 3 * k + 3]
            free = (1 - ends) * (self.impulses[k] + slips * rubs[k])
            law.append(ends * dot(row, w.state.qd) + begins * bounces[k] * dot(row, self.before) + free)
        return {
            "momentum": [x - kick for x, kick in zip(tangents(forces, change), kicks, strict=True)],
            "law": law,
            "touch": [gap for _, gap, _ in self.gaps],
            "struck": struck,
        }


def _within(most: Expr, along: Sequence[Expr]) -> list[Expr]:
    """Return what is not negative of a force along the plane that is no larger than that."""
    if len(along) < 2:
        return [x for force in along for x in (most - force, most + force)]
    return [most * most - most.graph.total(force * force for force in along)]


def _across(rows: Rows, x: Sequence[Expr], n: int, zero: Expr) -> list[Expr]:
    return [zero.graph.total(row[k] * one for row, one in zip(rows, x, strict=True)) for k in range(n)]

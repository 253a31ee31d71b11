"""Independent and dependent velocities of closed loops, and the order in which dependent ones are solved for.

    blocks    G_d in block triangular form: each block is coupled in itself and needs only those before it

Where more velocities are given than constraint rows, the last blocks have more velocities than rows: what determines
these rows more than once, and none of the other blocks takes part in it.

Reference: Duff, Erisman and Reid, Direct Methods for Sparse Matrices (2017), chapter 6.

Dense systems of expressions are blocks of constraint rows, and what else has no pattern. Blocks of G_d up to six rows
are solved by Cramer's rule with shared minors: a block is singular where the dependent velocities are undetermined and
nowhere else, which pivots chosen beforehand could not promise. Larger ones, and those with more equations than
unknowns, are solved by their normal equations, which are singular nowhere else either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from symdyn.dynamics.mechanism.linear_solve import Factored, factored
from symdyn.frozen import dataclass
from symdyn.graph import Expr
from symdyn.scene import Scene
from symdyn.scene.values import spell

Matrix = Sequence[Sequence[Expr]]

CRAMER = 6
"""Rows of the largest block that is solved by Cramer's rule."""


def solve_square(B: Matrix, b: Sequence[Expr]) -> list[Expr]:
    """Return B⁻¹ b: by Cramer's rule, beyond six rows by normal equations."""
    size = len(B)
    if all(one.is_zero for one in b):
        return list(b)
    if size > CRAMER:
        return solve_normal(B, b)
    minors = _Minors(B)
    every = tuple(range(size))
    det = minors.value(every, every)
    if size == 1:
        return [b[0] / det]
    inverse = 1 / det
    found = []
    for j in every:
        columns = every[:j] + every[j + 1 :]
        total = det.graph.zero
        for i in every:
            if not b[i].is_zero:
                minor = minors.value(every[:i] + every[i + 1 :], columns)
                total = total + minor * b[i] if (i + j) % 2 == 0 else total - minor * b[i]
        found.append(total * inverse)
    return found


def inverse(B: Matrix) -> list[list[Expr]]:
    """Return B⁻¹ of at most six rows, by its minors and one reciprocal."""
    minors, every = _Minors(B), tuple(range(len(B)))
    plus = 1 / minors.value(every, every)

    def entry(j: int, i: int) -> Expr:
        found = minors.value(every[:i] + every[i + 1 :], every[:j] + every[j + 1 :]) * plus
        return found if (i + j) % 2 == 0 else -found

    return [[entry(j, i) for i in every] for j in every]


class _Minors:
    """Minors of a matrix by expansion along their first rows, each computed once."""

    def __init__(self, B: Matrix) -> None:
        self.B = B
        self.known: dict[tuple[tuple[int, ...], tuple[int, ...]], Expr] = {}

    def value(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> Expr:
        """Return the determinant of the part."""
        graph = self.B[0][0].graph
        if not rows:
            return graph.one
        key = (rows, columns)
        if key not in self.known:
            total = graph.zero
            for place, c in enumerate(columns):
                entry = self.B[rows[0]][c]
                if not entry.is_zero:
                    term = entry * self.value(rows[1:], columns[:place] + columns[place + 1 :])
                    total = total + term if place % 2 == 0 else total - term
            self.known[key] = total
        return self.known[key]


def solve_normal(B: Matrix, b: Sequence[Expr]) -> list[Expr]:
    """Return x with Bᵀ B x = Bᵀ b by Lᵀ D L: B⁻¹ b, or the least squares of more equations than unknowns."""
    graph, columns = B[0][0].graph, zip(*B, strict=True)
    right = [[graph.dot(column, b)] for column in columns]
    return [row[0] for row in squared(B).solve(right)]


def squared(B: Matrix) -> Factored:
    """Return Bᵀ B factored."""
    graph, columns = B[0][0].graph, list(zip(*B, strict=True))
    square = [[graph.dot(one, other) for other in columns] for one in columns]
    return factored(graph, range(-1, len(columns)), square)


@dataclass(frozen=True)
class LoopChoices:
    """What a user may choose about closed loops.

    Attributes:
        independent: names of the independent coordinates (or velocities); () leaves the choice to conditioning.
        alpha, beta: Baumgarte's stabilisation, 1/s: G u̇ = -Ġ u - 2 alpha G u - beta² residual; zeros for none.
        parameters: values of free parameters at which the mechanism is assembled to decide; others are drawn.
    """

    independent: tuple[str, ...] = ()
    alpha: Fraction = Fraction(0)
    beta: Fraction = Fraction(0)
    parameters: tuple[tuple[str, float], ...] = ()

    @property
    def words(self) -> str:
        """What was chosen, such as "independent: phi; Baumgarte: alpha 5, beta 5 1/s"; "" where nothing was."""
        parts = [f"independent: {', '.join(self.independent)}"] if self.independent else []
        if self.alpha or self.beta:
            parts.append(f"Baumgarte: alpha {spell(self.alpha)}, beta {spell(self.beta)} 1/s")
        return "; ".join(parts)


@dataclass(frozen=True)
class LoopBlock:
    """Constraint rows, counted among the independent ones, and as many velocities, or more."""

    rows: tuple[int, ...]
    velocities: tuple[int, ...]

    def solve(self, G: Matrix, b: Sequence[Expr]) -> list[Expr]:
        """Return x of the velocities with G x = b in the rows, b of shape (rows,); as many rows as velocities."""
        return solve_square([[G[r][k] for k in self.velocities] for r in self.rows], b)


@dataclass(frozen=True)
class Partition:
    """Independent velocities in the user's order, dependent ones, and the blocks of G_d in the order of solving."""

    independent: tuple[int, ...]
    dependent: tuple[int, ...]
    blocks: tuple[LoopBlock, ...]

    def solve_dependent(self, G: Matrix, b: Sequence[Expr]) -> dict[int, Expr]:
        """Return x with G_d x = b by velocity, block by block, b of shape (independent rows,)."""
        x: dict[int, Expr] = {}
        for block in self.blocks:
            rest = [_without(b[r], G[r], x) for r in block.rows]
            x |= dict(zip(block.velocities, block.solve(G, rest), strict=True))
        return x

    def solve_normal(self, G: Matrix, b: Sequence[Expr]) -> dict[int, Expr]:
        """Return what `solve_dependent` does, by the normal equations of all rows at once."""
        square = [[row[k] for k in self.dependent] for row in G]
        return dict(zip(self.dependent, solve_normal(square, b) if G else [], strict=True))

    def solve_transposed(self, G: Matrix, f: Sequence[Expr]) -> list[Expr]:
        """Return λ with Gᵀ λ = f in the velocities of the blocks, shape (rows,), f of shape (nv,).

        Of a block with more velocities than rows λ misses least in the sum of squares; f is met where it can be.
        """
        found: dict[int, Expr] = {}
        for block in reversed(self.blocks):
            rest = [_without(f[k], [row[k] for row in G], found) for k in block.velocities]
            matrix = [[G[r][k] for r in block.rows] for k in block.velocities]
            solve_block = solve_square if len(block.rows) == len(block.velocities) else solve_normal
            found |= dict(zip(block.rows, solve_block(matrix, rest), strict=True))
        return [found[r] for r in range(len(G))]


def _without(b: Expr, row: Sequence[Expr], x: Mapping[int, Expr]) -> Expr:
    """Return b less a row times what is known, term by term in the order in which it became known."""
    zero = b.graph.zero
    return b - b.graph.total(row[k] * one for k, one in x.items() if row[k] is not zero)


def over_actuated(scene: Scene, free: int) -> str:
    """Return what a message says of more drives than degrees of freedom, which is `free`."""
    actuated = scene.actuated_velocities
    return (
        f"over-actuated, {len(actuated)} drive{'s' * (len(actuated) != 1)} ({drives_of(scene, actuated)}) for {free} "
        f"degree{'s' * (free != 1)} of freedom; leave {len(actuated) - free} of them passive (drive = false)"
    )


def drives_of(scene: Scene, velocities: Sequence[int]) -> str:
    """Return what drives velocities and in which joint, since a reader gives names such as tau7: "tau7 of hip"."""
    owners = {rate: joint.name for joint in scene.joints for rate in joint.rates}
    names = [(scene.drives[k] or scene.velocities[k], owners[scene.velocities[k]]) for k in velocities]
    return ", ".join(f"{drive} of {owner}" for drive, owner in names)


# Block triangular form


def blocks(uses: Sequence[Sequence[int]]) -> list[LoopBlock]:
    """Return the blocks of a pattern of rows that are independent: needed ones first, then those with more velocities.

    Square ones are strongly connected rows of a perfect matching. Velocities that it leaves over, and all rows and
    velocities that can be matched in place of others because of them, are the overdetermined part of Dulmage and
    Mendelsohn's decomposition. The pattern is the velocities that each row uses.
    """
    matched = _matching(uses)
    users: dict[int, list[int]] = {}
    for row, columns in enumerate(uses):
        for column in columns:
            users.setdefault(column, []).append(row)
    over = _reached([k for k in users if k not in matched.values()], users, matched)
    owner = {column: row for row, column in matched.items() if row not in over}
    needs = {
        row: [owner[k] for k in columns if k in owner and owner[k] != row]
        for row, columns in enumerate(uses)
        if row not in over
    }
    square = [_block(group, [matched[row] for row in group]) for group in _components(needs)]
    telling = {row: [k for k in uses[row] if k not in owner] for row in sorted(over)}
    sharing = {row: [other for k in columns for other in users[k] if other != row] for row, columns in telling.items()}
    tall = [_block(group, [k for row in group for k in telling[row]]) for group in _components(sharing)]
    return [*square, *tall]


def _block(rows: Sequence[int], velocities: Sequence[int]) -> LoopBlock:
    return LoopBlock(tuple(sorted(rows)), tuple(sorted(set(velocities))))


def _reached(spare: Sequence[int], users: Mapping[int, Sequence[int]], matched: Mapping[int, int]) -> set[int]:
    """Return the rows that alternating paths from spare velocities come to."""
    found: set[int] = set()
    waiting = list(spare)
    while waiting:
        new = [row for row in users[waiting.pop()] if row not in found]
        found.update(new)
        waiting += [matched[row] for row in new]
    return found


def _matching(uses: Sequence[Sequence[int]]) -> dict[int, int]:
    """Return for every row a column of its own that it uses, by augmenting paths."""
    owner: dict[int, int] = {}

    def find(first: int) -> bool:
        """Give a row a column, others their next ones; a walk without recursion, since chains of loops are long."""
        seen: set[int] = set()
        walk = [(first, iter(uses[first]))]
        asked: list[int] = []  # the column that each row but the last one would give up its own for
        while walk:
            row = walk[-1][0]
            free = next((one for one in uses[row] if one not in owner), None)
            column = next((one for one in walk[-1][1] if one not in seen), None) if free is None else free
            if column is None:
                walk.pop()
                if asked:
                    asked.pop()
                continue
            seen.add(column)
            if column in owner:
                asked.append(column)
                walk.append((owner[column], iter(uses[owner[column]])))
                continue
            for (taker, _), taken in zip(walk, [*asked, column], strict=True):
                owner[taken] = taker
            return True
        return False

    for row in range(len(uses)):
        found = find(row)
        assert found, "rows that are independent in numbers have a column each"
    return {row: column for column, row in owner.items()}


def _components(needs: Mapping[int, Sequence[int]]) -> list[list[int]]:
    """Return the strongly connected components of a graph, each after those that it needs (Tarjan)."""
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    found: list[list[int]] = []
    for root in needs:
        if root in index:
            continue
        walk = [(root, iter(needs[root]))]
        index[root] = low[root] = len(index)
        stack.append(root)
        while walk:
            node, rest = walk[-1]
            deeper = next((other for other in rest if other not in index), None)
            if deeper is not None:
                index[deeper] = low[deeper] = len(index)
                stack.append(deeper)
                walk.append((deeper, iter(needs[deeper])))
                continue
            walk.pop()
            low[node] = min([low[node], *(low[other] for other in needs[node] if other in stack)])
            if low[node] == index[node]:
                cut = stack.index(node)
                found.append(stack[cut:])
                del stack[cut:]
    return found

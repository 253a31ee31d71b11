"""The outputs that a person names: formulas of coordinates, rates, points, reactions and inputs, as rows of OUTPUTS.

    y = f(t, q, u, s, u̇, λ, R, τ, w)   u̇, λ and reactions R of the motion that the forces τ and inputs w give
    ẋ = (q̇, u̇, ṡ)                      of a scene with states s of its own

`Moving.expressed` puts what letters stand for into formulas; who looks at another motion says what it is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Mapping, Sequence
from functools import partial
from math import inf
from typing import TYPE_CHECKING

from symdyn.dynamics.mechanism import kinematics
from symdyn.dynamics.mechanism.state import STATES, body_placements, strut_way
from symdyn.dynamics.outputs import constrained_outputs as loops, result_labels as labels, tree_formulations as trees
from symdyn.dynamics.outputs.constrained_outputs import forward_reactions, unique as unique_entries
from symdyn.dynamics.outputs.output import Formulation, Output
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.wrenches import along, distance
from symdyn.errors import DerivationError, choice, suggestion
from symdyn.frozen import dataclass
from symdyn.graph import Expr, substitute, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.values import LETTERS, Element, Strut, resets_of, spell

if TYPE_CHECKING:
    from symdyn.dynamics.loops.loop_decisions import LoopDecisions
    from symdyn.dynamics.loops.loop_numbers import Numbers


@dataclass(frozen=True)
class Moving:
    """What the letters of a formula stand for, each worked out when a formula names it."""

    w: Workspace  # the workspace whose letters they are
    accelerations: Callable[[], Sequence[Expr]]  # shape (nv,)
    drives: Callable[[], Sequence[Expr]]  # driving forces, shape (nv,)
    reactions: Callable[[str], Sequence[Expr]]  # force and moment of every joint, row by row, in axes
    multipliers: Callable[[], Sequence[Expr]]  # of the independent rows

    @classmethod
    def driven(cls, w: Workspace, formulation: str = "recursive") -> Moving:
        """Return what letters stand for while driving forces move the scene, "recursive" or "lagrange"."""
        closed, reduced = w.scene.is_constrained, formulation == "recursive"
        of = {
            "accelerations": ((trees.forward, trees.lagrange_forward), (loops.forward, loops.lagrange_forward)),
            "drives": ((trees.drives_recursive, trees.drives_lagrange), (loops.drives, loops.lagrange_drives)),
            "multipliers": ((_none, _none), (loops.multipliers, loops.lagrange_multipliers)),
        }
        formulations = {name: pairs[closed][not reduced] for name, pairs in of.items()}
        return cls(
            w,
            accelerations=partial(w.once, formulations["accelerations"]),
            drives=partial(w.once, formulations["drives"]),
            reactions=partial(w.once, _REACTIONS[formulation]),
            multipliers=partial(w.once, formulations["multipliers"]),
        )

    def expressed(
        self,
        formulas: Sequence[Quantity],
        placed: Callable[[str], Sequence[Expr]] | None = None,
        inputs: Mapping[Expr, Expr] | None = None,
    ) -> list[Expr]:
        """Return formulas as entries, `placed` telling where a point is, ground axes, and `inputs` what inputs are.

        Raises:
            DerivationError: a reaction or a multiplier that there is not.
        """
        w = self.w
        named = self.check(formulas)
        graph, state = w.graph, w.state
        recursive = placed is None
        placed = placed or (lambda name: kinematics.tree_placed(w.scene, w.tree, name).p)
        found: dict[Expr, Expr] = dict(inputs or {})
        accelerations = {str(node.value): k for k, node in enumerate(state.qdd)}
        drives = {drive: k for k, drive in enumerate(w.scene.drives) if drive}
        for letters, values in ((accelerations, self.accelerations), (drives, self.drives)):
            if any(name in letters for name in named):
                known = values()
                found |= {graph.symbol(name): known[k] for name, k in letters.items() if name in named}
        found |= kinematics.point_motion(w.scene, named, state, placed, self.accelerations)
        for rope in w.scene.ropes:
            if f"{LETTERS.tension}{rope.name}" in named:
                found[graph.symbol(f"{LETTERS.tension}{rope.name}")] = self._tension(rope, recursive)
        own = {one.name for one in w.scene.parameters} | {*w.scene.plain_names, *accelerations, *drives}
        for strut in w.scene.struts:
            asked = {x: what for x, what in LETTERS.of_strut(strut).items() if x in named and x not in own}
            worth = self._strut(strut, recursive) if asked else {}
            found |= {graph.symbol(name): worth[what] for name, what in asked.items()}
        if any(name in named and name not in own for name in LETTERS.energies):
            energies = w.energies_by_momentum() if recursive else (w.energy.K, w.energy.P)
            found |= zip(map(graph.symbol, LETTERS.energies), energies, strict=True)
        axes = w.scene.reaction_axes
        for one in dict.fromkeys(axes[name] for name in named if name in axes):
            told = reaction_names(w.scene, w.once(unique_entries, one), one)
            found |= zip(map(graph.symbol, told), self.reactions(one), strict=True)
        if w.scene.is_constrained and any(name.startswith(LETTERS.multiplier) for name in named):
            told = w.once(independent_multipliers)
            found |= zip(map(graph.symbol, told), self.multipliers(), strict=False)  # of prescribed motions, others
        return substitute([one.express(graph) for one in formulas], found)

    def _tension(self, rope: Element, recursive: bool) -> Expr:
        """Return the tension of a rope, N, positive where it pulls; a length along the tree or of placements."""
        w = self.w
        if not isinstance(rope, Strut):
            told: tuple[str, ...] = w.once(independent_multipliers)
            if f"{LETTERS.multiplier}{rope.name}" not in told:
                raise DerivationError(
                    f"{w.scene.name}: the tension of rope {rope.name} is not unique: other constraints hold what it "
                    "holds; leave one of them out, or make it elastic"
                )
            return self.multipliers()[told.index(f"{LETTERS.multiplier}{rope.name}")]
        return self._strut(rope, recursive)["force"]

    def _strut(self, strut: Strut, recursive: bool) -> dict[str, Expr]:
        """Return "force" of a strut, positive where it pulls, "length", the way, and its "rate"; see `_tension`."""
        w, graph = self.w, self.w.graph
        if recursive and strut.is_rope:
            length, rates = along(strut, w.scene, w.tree)
            rate = graph.dot(rates, w.state.qd)
        elif recursive and strut.ends:
            length = graph.sqrt(distance(strut, w.tree, w.reduced).square)
            (rate,) = tangents([length], w.state.velocity)
        else:
            length = strut_way(w.scene, body_placements(w.scene, graph) if strut.ends else {}, strut, graph)
            (rate,) = tangents([length], w.state.velocity)
        return {"force": FORCES[strut.kind].pull.force(strut, length, rate), "length": length, "rate": rate}

    def check(self, formulas: Sequence[Quantity]) -> dict[str, None]:
        """Return the letters of formulas; DerivationError of a reaction or a multiplier that there is not."""
        named = dict.fromkeys(name for one in formulas for name in one.symbols)
        for letter, there in ((LETTERS.reaction, reaction_letters), (LETTERS.multiplier, independent_multipliers)):
            asked = [name for name in named if name.startswith(letter)]
            known = self.w.once(there) if asked else ()
            for name in asked:
                if name not in known:
                    raise DerivationError(f"outputs: {name} is not known; {suggestion(name, known)}")
        return named


def reaction_letters(w: Workspace) -> tuple[str, ...]:
    """Return the symbols of all reactions, those that are statically indeterminate marked as such."""
    return tuple(name for one in LETTERS.axes for name in reaction_names(w.scene, w.once(unique_entries, one), one))


def reaction_names(scene: Scene, unique: Sequence[bool], axes: str = "body") -> tuple[str, ...]:
    """Return the letters of reactions in some axes, row by row; `unique` tells which ones are, () for all."""
    ending = "" if axes == "body" else f"_{axes}"
    names = labels.joints_of(scene)
    each = (f"{LETTERS.reaction}{name}_{component}{ending}" for name in names for component in LETTERS.components)
    unique = unique or (True,) * (len(names) * len(LETTERS.components))
    return tuple(f"{name}{'' if known else LETTERS.loose}" for name, known in zip(each, unique, strict=True))


def independent_multipliers(w: Workspace) -> tuple[str, ...]:
    """Return the letters of the multipliers of independent rows."""
    if not w.scene.is_constrained:
        return ()
    decisions, numbers = w.loops.decisions, w.loops.numbers
    from symdyn.dynamics.loops.loop_decisions import indeterminate_rows  # with NumPy, which trees do without

    return multiplier_names(w.scene, decisions, numbers, indeterminate_rows(numbers, decisions.assembly))


def multiplier_names(
    scene: Scene, decisions: LoopDecisions, numbers: Numbers, indeterminate: Container[int]
) -> tuple[str, ...]:
    """Return the letters of the multipliers of independent rows; `indeterminate` are rows that nothing determines."""
    names = [_name(scene, numbers, k) for k in decisions.independent_rows]
    many, seen, found = Counter(names), Counter[str](), []
    for k, name in zip(decisions.independent_rows, names, strict=True):
        seen[name] += 1
        number = f"_{seen[name]}" if many[name] > 1 else ""
        found.append(f"{LETTERS.multiplier}{name}{number}{LETTERS.loose if k in indeterminate else ''}")
    return tuple(found)


def _name(scene: Scene, numbers: Numbers, k: int) -> str:
    label = numbers.constraints.labels[k]
    if not label.loop:
        row = next((row for row in scene.contacts if row.name == label.owner), None)
        return f"{label.owner}_{row.components[label.number]}" if row else label.owner
    entries = [x for part in label.wrench or () for x in part]
    along = [name for name, x in zip(LETTERS.components, entries, strict=True) if not x.is_zero]
    if len(along) == 1 and any(x is x.graph.one for x in entries):  # of a rod or a cross at the start it would turn
        return f"{label.owner}_{along[0]}_joint"
    return f"{label.owner}_{'moment' if all(name[0] == 'm' for name in along) else 'force'}"


# Rows of the table


def _none(w: Workspace) -> list[Expr]:
    return []


_REACTIONS: Mapping[str, Callable[..., list[Expr]]] = {
    "recursive": forward_reactions,
    "lagrange": partial(
        forward_reactions, moved=(trees.lagrange_forward, loops.lagrange_forward, loops.lagrange_multipliers)
    ),
}


def _formulas(w: Workspace, name: str = "") -> list[Quantity]:
    """Return the formulas of all outputs, or of one; DerivationError where there is no such output."""
    there = {one.name: one.formula for one in w.scene.outputs}
    if not there:
        advice = f'declare one, such as [outputs.y] formula = "{w.scene.coordinates[0]}"'
        raise DerivationError(f"{w.scene.name} has no outputs; {advice}")
    if name and name not in there:
        raise DerivationError(f"{w.scene.name}: there is no output {name!r} in [outputs]; {choice(name, there)}")
    return [there[name]] if name else list(there.values())


def _by_placements(w: Workspace, formulas: Sequence[Quantity]) -> list[Expr]:
    moving = Moving.driven(w, "lagrange")
    return moving.expressed(formulas, lambda point: kinematics.placed(w.scene, point, w.graph).p)


def _told(w: Workspace, name: str = "") -> str:
    """Return the formulas behind a text."""
    told = (
        f"{one.name} = {spell(one.formula)}{f' [{one.unit}]' if one.unit else ''}"
        for one in w.scene.outputs
        if name in ("", one.name)
    )
    return f": {'; '.join(told)}"


def _rates(formulation: str) -> Formulation:
    """Return the rates of coordinates, velocities and states by a formulation of the accelerations."""
    return Formulation(
        lambda w: [*w.state.rates, *Moving.driven(w, formulation).accelerations(), *w.state_rates],
        up_to=inf if formulation == "recursive" else 4,
    )


def _resets(w: Workspace) -> list[Expr]:
    """Return `when` of each reset, and all states behind it; DerivationError where there is none."""
    if not resets_of(w.scene.states):
        raise DerivationError(
            f'{w.scene.name} has no resets; a state may have one: reset = {{ when = "s - 1", to = 0 }}'
        )
    rows = [
        [when, *(to.get(one.name) for one in w.scene.states)] for (when, _), to in resets_of(w.scene.states).items()
    ]
    there = [None, *w.states]
    return [x if one is None else one.express(w.graph) for row in rows for one, x in zip(row, there, strict=True)]  # type: ignore[misc]


_USUAL = partial(
    Output,
    arguments=("q", "qd", "tau"),
    result="y",
    units="as their formulas have it",
    when_constrained="same",
    formulations={
        "recursive": Formulation(lambda w, name="": Moving.driven(w).expressed(_formulas(w, name))),
        "lagrange": Formulation(lambda w, name="": _by_placements(w, _formulas(w, name)), up_to=4),
    },
    may_fail="reported",
    exists=lambda scene: bool(scene.outputs),
    depends=("independent", "alpha", "beta"),
    remark=_told,
)


def _tension(w: Workspace, name: str) -> list[Quantity]:
    """Return the letter of the tension of a rope; DerivationError where there is no such rope."""
    there = [one.name for one in w.scene.ropes]
    if name not in there:
        raise DerivationError(f"{w.scene.name}: there is no rope {name!r} in [ropes]; {choice(name, there)}")
    return [Quantity.symbol(f"{LETTERS.tension}{name}")]


SIGNALS: dict[str, Output] = {
    "outputs": _USUAL("outputs", axes=(lambda w: tuple(one.name for one in w.scene.outputs),)),
    "output": _USUAL("output {name}", axes=(), place="output"),
    "state_rates": _USUAL(
        "rates of coordinates, velocities and states",
        result="xdot",
        axes=(lambda w: (*w.scene.coordinates, *w.scene.velocities, *(one.name for one in w.scene.states)),),
        units="of each, per second",
        formulations={name: _rates(name) for name in ("recursive", "lagrange")},
        exists=lambda scene: bool(scene.states),
        remark=None,
        moved=(STATES,),
    ),
    "resets": _USUAL(
        "where states jump: of each reset what passes zero there, and all states behind it",
        arguments=("q", "qd"),
        result="jumps",
        axes=(
            lambda w: tuple(f"{spell(when)}, {way}" for when, way in resets_of(w.scene.states)),
            lambda w: ("when", *(one.name for one in w.scene.states)),
        ),
        formulations={"formula": Formulation(_resets)},
        exists=lambda scene: bool(resets_of(scene.states)),
        default_in="request",
        may_fail="never",
        depends=(),
        remark=None,
    ),
    "tension": _USUAL(
        "tension of rope {name}, positive where it pulls",
        axes=(),
        units="N",
        formulations={
            "recursive": Formulation(lambda w, name: Moving.driven(w).expressed(_tension(w, name))),
            "lagrange": Formulation(lambda w, name: _by_placements(w, _tension(w, name)), up_to=4),
        },
        place="rope",
        exists=lambda scene: bool(scene.ropes),
        remark=None,
    ),
}
"""Rows of the table, about what the scene declares in [outputs] and [states]."""

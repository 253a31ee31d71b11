"""Contacts of a mechanism that is linearised in one of their modes: rows that hold, and the friction of what slips.

    closed, stick, slip    g = 0, n u = 0             stick    t u = 0           λ is a multiplier of each row
    slip+, slip-           λt = -z μ λn, z = ±1;  of dry friction of a joint -z F

Friction of what slips is no force of a row: M u̇ + h = τ + Pᵀ λ, where P is not G. What is held is the manifold on which
A and B stand. What is not named is open.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.arguments import argument
from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs import Row, touching, unilaterals_of, with_modes
from symdyn.errors import DerivationError, LinearizeError, choice
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import DryJoint, Faults, Unilateral

SLIPS = {"slip+": 1, "slip-": -1}

WORDS = ("open", "closed", "stick", *SLIPS)

Mode = tuple[tuple[str, str], ...]
"""Contacts by name, and what each does, one of `WORDS`."""


def read_mode(scene: Scene, mode: Mapping[str, str]) -> Mode:
    """Return a mode; LinearizeError with every fault."""
    laws, faults = {one.name: one for one in unilaterals_of(scene)}, Faults("")
    for name, word in mode.items():
        if name not in laws:
            faults.add("mode", f"there is no contact {name}; {choice(name, laws) if laws else 'the scene has none'}")
        elif word not in (known := _words(laws[name])):
            faults.add("mode", f"{name} cannot be {word!r:.40}; {choice(str(word), known)}")
    faults.close(LinearizeError)
    lacking = [name for name, one in laws.items() if isinstance(one, DryJoint) and name not in mode]
    if mode and lacking:
        raise LinearizeError(f"mode: {lacking[0]} sticks or slips always: say stick, slip+ or slip-")
    return tuple(mode.items())


def _words(law: Unilateral) -> Sequence[str]:
    """Return what one can do; a contact whose friction is zero is closed, and neither sticks nor slips."""
    rubs = law.friction != Quantity.ZERO or law.static is not None
    return WORDS[2:] if isinstance(law, DryJoint) else ("open", *WORDS[2:]) if rubs else WORDS[:2]


def scene_in_mode(scene: Scene, mode: Mode) -> Scene:
    """Return the scene with stops and dry friction as contacts; itself without a mode, if it has no contacts."""
    if scene.unilaterals and not mode:
        told = argument("mode", {one.name: "open" for one in scene.unilaterals})
        raise DerivationError(
            f"{scene.name}: contacts open and close, and a linear system is of one mode of theirs: say what each does "
            f"there, {told}; or closed, or of one with friction stick, slip+ or slip-"
        )
    return replace(with_modes(scene), states=scene.states) if mode else scene


@dataclass(frozen=True)
class HeldContacts:
    """What a mode holds, on a graph.

    Attributes:
        rows: of each held row the contact, n or t, g, zero of a t, and whether it holds a position.
        rubbing: of what slips the row of its n, None of a joint's friction, the factor z μ or z F, and t.
    """

    rows: tuple[tuple[str, Row, Expr, bool], ...]
    rubbing: tuple[tuple[int | None, Expr, Row], ...]

    @classmethod
    def of(cls, w: Workspace, mode: Mode) -> HeldContacts:
        """Return it; LinearizeError where something slips along a plane, and no word says which way."""
        words, held, rubbing = dict(mode), list[tuple[str, Row, Expr, bool]](), list[tuple[int | None, Expr, Row]]()
        for touch in touching(w) if mode else ():
            name, at = touch.law.name, len(held) if touch.normal else None
            word = words.get(name, "open")
            if touch.normal and word != "open":
                held.append((name, touch.normal, touch.gap, not touch.law.at_rates))
            if word == "stick":
                held += [(name, row, w.graph.zero, False) for row in touch.tangents]
            elif word in SLIPS and len(touch.tangents) > 1:
                raise LinearizeError(f"mode: {name} may slip along two directions, and {word} says no direction")
            elif word in SLIPS:
                rubbing.append((at, SLIPS[word] * touch.friction, touch.tangents[0]))
        return cls(tuple(held), tuple(rubbing))

    def friction(self, w: Workspace, multipliers: Sequence[Expr]) -> list[Expr]:
        """Return the generalized forces of what slips, shape (nv,); `multipliers` are those of the rows."""
        sizes = [factor if k is None else factor * multipliers[k] for k, factor, _ in self.rubbing]
        slips = [row.entries for _, _, row in self.rubbing]
        return [-w.graph.total(x * t[k] for x, t in zip(sizes, slips, strict=True)) for k in range(w.state.n)]

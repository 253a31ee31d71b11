"""Variants of a scene by seed: other masses, lengths, axes, springs, and another way down, so that no two hand in one.

Each row of `CHANGES` is a function (scene, random numbers) that returns the changed scene and what is said of it, or
None where it has nothing to change. Whatever is drawn is read again like any scene, and kept if it can move.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import cast

import numpy as np

from symdyn.algebra import Floats, Form, Number, Symbol
from symdyn.dynamics import Energies
from symdyn.errors import SymdynError, TeachError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.scene import Quantity, Scene, SceneUnits, read_text, write_text
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Body, Element, Joint, Load, Parameter, Place, Pose, Strut
from symdyn.teach.document import Block, Document, Step, Words
from symdyn.teach.languages import fill, language_of

FACTORS = (Fraction(2), Fraction(3), Fraction(1, 2), Fraction(3, 2))
MOST = 3  # changes of one variant
SINGULAR = 1e8  # condition number from which a mass matrix counts as singular
STIFFNESS = 5  # N m/rad or N/m, where all other parameters have values


@dataclass(frozen=True)
class Change:
    """What is said of a change: the key of a sentence, and its places."""

    key: str
    places: Mapping[str, str | Form]


@dataclass(frozen=True)
class Variant:
    """A scene that differs from another one."""

    scene: Scene  # the new one, named after the other and the seed
    of: str  # the name of the other
    changes: tuple[Change, ...]  # what differs, in words


Drawn = tuple[Scene, Change] | None
Three = tuple[Quantity, Quantity, Quantity]
Inertia = tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]


def variant(scene: Scene, seed: int) -> Variant:
    """Return the variant of a scene that a seed draws, the same in every run.

    Raises:
        TeachError: nothing in the scene can be changed.
    """
    rng = random.Random(f"{scene.name}:{seed}")
    rows = list(CHANGES)
    rng.shuffle(rows)
    changed, changes = scene, list[Change]()
    for row in rows:
        drawn = row(changed, rng)
        if drawn is None or len(changes) == MOST:
            continue
        try:
            found = read_text(write_text(drawn[0], "toml").text, scene.source or scene.name)
        except SymdynError:  # what is said of the scene elsewhere does not allow it
            continue
        if _moves(found):
            changed, changes = found, [*changes, drawn[1]]
    if not changes:
        raise TeachError(f"{scene.name}: nothing of it can be varied: it has neither masses nor joints of its own")
    return Variant(replace(changed, name=f"{scene.name}_{seed}"), scene.name, tuple(changes))


def with_changes(document: Document, drawn: Variant) -> Document:
    """Return a document about a variant that says in its first section how it differs."""
    texts = language_of(document.language).lesson
    said: list[Block] = [Words(fill(texts[one.key], one.places)) for one in drawn.changes]
    claim = Words(fill(texts["variant"], {"scene": drawn.of}))
    first, *others = document.sections
    known = {step.key for step in first.steps}
    assert "variant" not in known, "a lesson says once how it differs"
    shown = replace(first, steps=(Step("variant", claim, tuple(said)), *first.steps))
    return replace(document, sections=(shown, *others))


def _moves(scene: Scene) -> bool:
    """Whether a scene has a mass matrix that can be solved at some place: a change may leave a motion without mass."""
    if scene.is_constrained:  # where masses and springs change alone
        return True
    graph = Graph()
    entries = [x for row in Energies.of(scene, graph).mass_matrix() for x in row]
    symbols = [x for x in reachable(entries) if x.op is Op.SYMBOL]
    place = {x: random.Random(str(x.value)).uniform(0.3, 1.2) for x in symbols}
    M = np.array(evaluate(entries, Floats(), place)).reshape(len(scene.velocities), -1)
    return bool(np.linalg.cond(M) < SINGULAR)


# Masses and lengths


def _mass(scene: Scene, rng: random.Random) -> Drawn:
    heavy = [body for body in scene.bodies if body.mass != Quantity.ZERO or body.particles]
    if not heavy:
        return None
    body, factor = rng.choice(heavy), rng.choice(FACTORS)
    c = Quantity.number(factor)
    new = replace(
        body,
        mass=c * body.mass,
        first_moment=body.first_moment and _times(c, body.first_moment),
        inertia=cast(Inertia, tuple(c * x for x in body.inertia)),
        particles=tuple(replace(one, mass=c * one.mass) for one in body.particles),
    )
    said = Change("variant.mass", {"body": body.name, "factor": Number(factor)})
    return replace(scene, bodies=tuple(new if one is body else one for one in scene.bodies)), said


def _length(scene: Scene, rng: random.Random) -> Drawn:
    if _held(scene):  # its loops would not close any more
        return None
    long = [body for body in scene.bodies if _stretched(scene, body, FACTORS[0]) != scene]
    if not long:
        return None
    body, factor = rng.choice(long), rng.choice(FACTORS)
    said: dict[str, str | Form] = {"body": body.name, "factor": Number(factor), "square": Number(factor**2)}
    key = "variant.length.spun" if any(x != Quantity.ZERO for x in body.inertia) else "variant.length"
    return _stretched(scene, body, factor), Change(key, said)


def _stretched(scene: Scene, body: Body, factor: Fraction) -> Scene:
    """Return the scene with a body whose ways are longer by a factor, and its moments of inertia by its square."""
    c, square = Quantity.number(factor), factor**2

    def place(at: Place) -> Place:
        return replace(at, at=_times(c, at.at)) if at.body == body.name else at

    def element(one: Element) -> Element:
        if isinstance(one, Strut):
            return replace(one, ends=tuple(map(place, one.ends)))
        return replace(one, place=place(one.place)) if isinstance(one, Load) else one

    new = replace(
        body,
        com=body.com and _times(c, body.com),
        first_moment=body.first_moment and _times(c, body.first_moment),
        inertia=cast(Inertia, tuple(Quantity.number(square) * x for x in body.inertia)),
        particles=tuple(replace(one, at=_times(c, one.at)) for one in body.particles),
    )

    def joint(one: Joint) -> Joint:
        if one.child == body.name:
            one = replace(one, tip=_longer(one.tip, c))
        return replace(one, origin=_longer(one.origin, c)) if one.parent == body.name else one

    return replace(
        scene,
        bodies=tuple(new if one is body else one for one in scene.bodies),
        joints=tuple(map(joint, scene.joints)),
        points=tuple(replace(p, at=_longer(p.at, c)) if p.body == body.name else p for p in scene.points),
        elements=tuple(map(element, scene.elements)),
    )


def _times(c: Quantity, vector: Three) -> Three:
    return (c * vector[0], c * vector[1], c * vector[2])


def _longer(pose: Pose, c: Quantity) -> Pose:
    return Pose(tuple((step, c * x if step[0] == "T" else x) for step, x in pose.steps))


# Axes, springs, and what is down


def _sense(scene: Scene, rng: random.Random) -> Drawn:
    able = [one for one in _single(scene) if JOINTS[one.type].turned is not None and not _held(scene)]
    if not able:
        return None
    joint = rng.choice(able)
    turned = JOINTS[joint.type].turned
    assert turned is not None, "those that are able have it"
    said = Change("variant.sense", {"joint": joint.name, "q": Symbol(joint.coordinate), **_along(turned(joint).axis)})
    return _with(scene, joint, turned(joint)), said


def _direction(scene: Scene, rng: random.Random) -> Drawn:
    """Turn the axis of a slide in its plane; in space that of any joint: what moves in a plane stays there."""
    able = [one for one in _single(scene) if not _held(scene) and "axis" in dict(one.shape)]
    across = _plane(scene)
    if across is not None:
        able = [one for one in able if _units(scene)[one.coordinate] == "m"]
    able = [one for one in able if sum(x != Quantity.ZERO for x in one.axis) == 1]
    if not able:
        return None
    joint = rng.choice(able)
    (was,) = (k for k, x in enumerate(joint.axis) if x != Quantity.ZERO)
    now = rng.choice([k for k in range(3) if k not in (was, across)])
    axis = _unit(now)
    said = Change("variant.direction", {"joint": joint.name, **_along(axis)})
    return _with(scene, joint, joint.shaped(axis=axis)), said


def _gravity(scene: Scene, rng: random.Random) -> Drawn:
    along = [k for k, x in enumerate(scene.gravity) if x != Quantity.ZERO]
    if len(along) != 1 or scene.constraints or scene.unilaterals:
        return None
    size, across = scene.gravity[along[0]], _plane(scene)
    ways = [(k, sign) for k in range(3) for sign in (1, -1) if k != across and (k, sign) != (along[0], 1)]
    k, sign = rng.choice(ways)
    turned = [Quantity.ZERO] * 3
    turned[k] = size if sign > 0 else -size
    if turned[k].op is Op.NEG and turned[k].args[0].op is Op.NEG:
        turned[k] = turned[k].args[0].args[0]
    gravity = (turned[0], turned[1], turned[2])
    return scene.with_gravity(gravity), Change("variant.gravity", _along(gravity))


def _spring(scene: Scene, rng: random.Random) -> Drawn:
    held = {one.joint for one in scene.struts}
    able = [joint for joint in _single(scene) if joint.name not in held]
    if not able:
        return None
    joint = rng.choice(able)
    unit = "N/m" if _units(scene)[joint.coordinate] == "m" else "N m/rad"
    taken = {*scene.moving_names, *(one.name for one in scene.parameters)}
    k = next(name for name in ("k", "k_s", *(f"k_s{i}" for i in range(len(taken) + 1))) if name not in taken)
    value = Quantity.number(STIFFNESS) if scene.parameters and not scene.free_parameters else None
    names = {one.name for one in scene.elements}
    name = next(x for x in (k, *(f"{k}_{i}" for i in range(len(names) + 1))) if x not in names)
    added = FORCES["spring"].noun(name, joint=joint.name, stiffness=(Quantity.symbol(k),))
    said = Change("variant.spring", {"joint": joint.name, "k": Symbol(k), "q": Symbol(joint.coordinate)})
    parameters = (*scene.parameters, Parameter(k, value, positive=True, unit=unit))
    return replace(scene, parameters=parameters, elements=(added, *scene.elements)), said


def _single(scene: Scene) -> list[Joint]:
    """Return the joints with one coordinate of their own that no formula of time leads and no other joint follows."""
    followed = scene.followed
    return [x for x in scene.moving if len(x.coordinates) == 1 and x.motion is None and x.coordinate not in followed]


def _held(scene: Scene) -> bool:
    """Whether loops, rows or planes that it strikes hold places and directions."""
    return scene.is_constrained or bool(scene.unilaterals)


def _plane(scene: Scene) -> int | None:
    """Return the number of the axis that all turns have in common; None in space."""
    if any(len(joint.coordinates) != 1 for joint in scene.moving):
        return None
    turns = [joint.axis for joint in scene.moving if _units(scene)[joint.coordinate] == "rad"]
    tilted = any(step[0] == "R" for joint in scene.joints for step, _ in (*joint.origin.steps, *joint.tip.steps))
    across = [k for k in range(3) if all(x == Quantity.ZERO for axis in turns for j, x in enumerate(axis) if j != k)]
    return across[0] if turns and len(across) == 1 and not tilted else None


def _units(scene: Scene) -> dict[str, str]:
    return {q: unit for _, q, unit in SceneUnits(scene).each_coordinate()}


def _with(scene: Scene, old: Joint, new: Joint) -> Scene:
    return replace(scene, joints=tuple(new if one is old else one for one in scene.joints))


def _unit(k: int) -> Three:
    found = [Quantity.number(int(j == k)) for j in range(3)]
    return found[0], found[1], found[2]


def _along(vector: Three) -> dict[str, Form]:
    graph = Graph()
    return dict(zip("xyz", (Form.of(x.express(graph)) for x in vector), strict=True))


CHANGES: tuple[Callable[[Scene, random.Random], Drawn], ...] = (_mass, _length, _sense, _direction, _gravity, _spring)

"""Mobility of a closed mechanism: counted, by rank, and what it means when the two differ.

    u, s_t    bodies with the ground; joints of class t, those that close loops included
    spatial   n = 6 (u - 1) - Σ t s_t, eq. (5.20), less one for a joint that follows another one and
              for every constraint row of the scene, of which a rolling contact has up to three
    by loops  n = nv - Σ (d - f), f the freedoms of a cut joint; d = 6, and 3 for a planar loop. Where all loops are
              planar that is 3 (u - 1) = n + Σ (t - 3) s_t
    rank      n = nv - rank G, at the assembled position, or round about it at a change point; in angular velocities,
              since rates of angles are dependent where these are singular, and bodies are not

A planar loop counted in space has three reactions too many: those out of its plane, which no rigid body can tell.

Reference: the textbook of docs/theory.md, eq. (5.19), (5.20); Gogu, Mobility of mechanisms: a critical review,
Mechanism and Machine Theory 40 (2005), for where counting fails.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops.assembly import Assembly, seen_in_quaternions
from symdyn.dynamics.loops.loop_decisions import LoopDecisions, indeterminate_rows, loop_decisions_at
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.loops.newton import free_motions
from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Joint
from symdyn.spatial import add, cross

NOTHING = 1e-7
"""Components of unit motions and unit vectors below it are zero."""


@dataclass(frozen=True)
class Mobility:
    """Degrees of freedom of a mechanism, and what is to be said about them."""

    spatial: int  # counted by eq. (5.20)
    by_loops: int  # counted loop by loop, planar ones in their plane
    by_rank: int  # nv less the rank of G: what it is
    here: int  # the same at the assembled position itself; more at a change point
    planar: tuple[str, ...]  # names of the planar loops
    independent: tuple[str, ...]  # names of the velocities chosen as independent
    drives: tuple[str, ...]  # names of the driving forces
    idle: tuple[str, ...]  # idle motions: spins and slides of one body that move nothing else
    redundant: tuple[str, ...]  # constraints that are left out, in words
    not_unique: tuple[str, ...]  # constraints whose multipliers rigid bodies do not determine, in words
    smallest: float  # smallest singular value of the dimensionless independent constraints, where that is not zero
    notes: tuple[str, ...]  # diagnosis, one sentence each


def mobility(scene: Scene, closing: LoopChoices = LoopChoices()) -> Mobility:  # noqa: B008  frozen
    """Return the mobility of a scene with loops or constraint rows; DerivationError where they cannot be assembled."""
    whole, assembly = Numbers(scene).witness(dict(closing.parameters))
    fault = whole.singular_angles(np.array(assembly.regular), everywhere=True)
    numbers, seen = whole.in_quaternions, seen_in_quaternions(whole, assembly)
    decisions = loop_decisions_at(*((numbers, seen, LoopChoices()) if fault else (whole, assembly, closing)))
    positions = [np.array(q) for q in (seen.regular, *seen.configurations)]
    flat = [joint for joint in scene.loops if all(_is_planar(numbers, joint, q) for q in positions)]
    planar = tuple(joint.name for joint in flat)
    free = numbers.state.n - len(decisions.independent_rows)
    forbidden = sum(not label.loop for label in numbers.constraints.labels)
    counted = numbers.state.n - forbidden
    every = (*scene.joints, *scene.loops)
    taken = sum(JOINTS[joint.type].class_t(joint) + (joint.coupling is not None) for joint in every)
    for joint in scene.loops:
        counted -= JOINTS[joint.type].class_t(joint) - (3 if joint.name in planar else 0)
    found = Mobility(
        spatial=6 * len(scene.bodies) - taken - forbidden,
        by_loops=counted,
        by_rank=free,
        here=numbers.state.n - decisions.assembly.here,
        planar=planar,
        independent=() if fault else tuple(scene.velocities[k] for k in decisions.partition.independent),
        drives=tuple(drive for drive in scene.drives if drive),
        idle=tuple(dict.fromkeys(_idle(numbers, seen, decisions.zero_rows))),
        redundant=tuple(decisions.names[k] for k in sorted((*decisions.zero_rows, *decisions.redundant))),
        not_unique=tuple(decisions.names[k] for k in indeterminate_rows(numbers, seen)),
        smallest=decisions.assembly.smallest,
        notes=(),
    )
    notes = [*_notes(scene, decisions, found), *([fault] if fault else _start(whole, decisions))]
    return replace(found, notes=tuple(notes))


def _is_planar(numbers: Numbers, joint: Joint, q: Array) -> bool:
    """Whether all relative motions of a loop, those that the cut joint allows included, lie in one plane."""
    columns = numbers.constraints.columns[joint.name].values()
    moving = numbers.at([x for z, s in columns for part in (z, s) for x in part], q).reshape(-1, 6)
    labels = [one for one in numbers.constraints.labels if one.owner == joint.name and one.loop]
    wrenches = numbers.at([x for one in labels for part in one.wrench or () for x in part], q).reshape(-1, 6)
    allowed = free_motions(wrenches) if len(wrenches) else np.eye(6)
    twists = np.vstack([moving, np.hstack([allowed[:, 3:], allowed[:, :3]])])  # angular part first
    turns = twists[np.abs(twists[:, :3]).max(axis=1) > NOTHING]
    if not len(turns):
        return bool(np.linalg.matrix_rank(twists[:, 3:], tol=NOTHING) <= 2)
    normal = turns[0, :3] / np.linalg.norm(turns[0, :3])
    leaning = np.abs(np.cross(twists[:, :3], normal)).max()
    return bool(max(leaning, np.abs(twists[:, 3:] @ normal).max()) < NOTHING)


def _idle(numbers: Numbers, seen: Assembly, zero_rows: Container[int]) -> list[str]:
    """Return the idle motions, in words: what is one at one position and not at a generic one is none."""
    words: list[str] = []
    for k, at in enumerate(map(np.array, (seen.regular, *seen.configurations))):
        G = numbers.dimensionless(at, seen.length)[[i for i in range(len(numbers.constraints.G)) if i not in zero_rows]]
        here = [one for one, _ in idle_motions(numbers, G, at)]
        words = here if k == 0 else [one for one in words if one in here]
        if not words:
            break
    return words


def idle_motions(numbers: Numbers, G: Array, q: Array) -> list[tuple[str, Array]]:
    """Return motions of bodies on loops while all else and every drive rests: words, and velocities (nv,); G of q.

    What moves one body alone is a matter of the joints that it hangs and carries by, and of those that share their
    velocities: everything else rests by itself.
    """
    scene, tree = numbers.scene, numbers.tree
    on_loops = {name: None for joint in scene.loops for name in _between(numbers, joint)}
    homes = [tree.home[body.name][0] for body in scene.bodies]
    bodies, columns, joints = Counter(homes), _moved_by(numbers, q), _joints(numbers, {0, *homes})
    sharing = _sharing(joints)
    found = []
    for name in on_loops:
        home = tree.home[name][0]
        if not home or bodies[home] > 1:
            continue  # it is fixed to the ground, or to another body, which rests
        near = _near(home, joints, sharing)
        local = sorted({k for one in near for k in joints[one].velocities})
        twists = {one: _twists(numbers, one, local, columns) for one in (home, *near)}
        rows = G[:, local]
        at_drives = [row for row, k in enumerate(local) if scene.drives[k]]
        others = [twists[one] for one in near if one != home]
        rest = np.vstack([rows[np.abs(rows).max(axis=1, initial=0.0) > 0], *others, np.eye(len(local))[at_drives]])
        for part in free_motions(rest):
            twist = twists[home] @ part
            if np.abs(twist).max(initial=0.0) > NOTHING:
                how = "spins about the line of its joints" if np.abs(twist[:3]).max() > NOTHING else "slides"
                way = np.zeros(numbers.state.n)
                way[local] = part
                found.append((f"{name} {how}", way))
    return found


@dataclass(frozen=True)
class _Between:
    """What is between the frame of a body and the next one inwards that carries a body: velocities, and that frame."""

    velocities: frozenset[int]
    inner: int


def _joints(numbers: Numbers, carrying: Container[int]) -> dict[int, _Between]:
    """Return what is inwards of every frame that carries a body, by frame; the ground is 0."""
    tree, found = numbers.tree, {}
    for frame in tree.outward():
        if frame in carrying:
            inner, velocities = frame, set[int]()
            while inner == frame or inner not in carrying:
                velocities |= {k for k, _ in tree.A[inner]}
                inner = tree.parent[inner]
            found[frame] = _Between(frozenset(velocities), inner)
    return found


def _sharing(joints: dict[int, _Between]) -> dict[tuple[str, int], list[int]]:
    """Return the frames that a frame carries, ("carried", frame), and those that a velocity moves, ("moved", k)."""
    found: dict[tuple[str, int], list[int]] = {}
    for frame, joint in joints.items():
        found.setdefault(("carried", joint.inner), []).append(frame)
        for k in joint.velocities:
            found.setdefault(("moved", k), []).append(frame)
    return found


def _near(home: int, joints: dict[int, _Between], sharing: dict[tuple[str, int], list[int]]) -> list[int]:
    """Return the frames whose joints have a say when one moves alone: its own, those it carries, and who shares."""
    near: set[int] = set()
    more = [home, *sharing.get(("carried", home), ())]
    while more:
        one = more.pop()
        if one not in near:
            near.add(one)
            more += [other for k in joints[one].velocities for other in sharing["moved", k]]
    return sorted(near)


def _moved_by(numbers: Numbers, q: Array) -> list[list[tuple[int, Array]]]:
    """Return for every frame what a unit of each velocity adds to its twist, from that of its parent.

    Twists are angular first, at the ground's origin; frame 0 is the ground.
    """
    tree = numbers.tree
    entries = []
    for T, (z, s) in zip(tree.placements(), tree.S, strict=True):
        turned = T.R @ z
        entries += [*turned, *add(T.R @ s, cross(T.p, turned))]
    axes = numbers.at(entries, q).reshape(-1, 6)
    shares = iter(numbers.at([x for row in tree.A for _, x in row], q))
    return [[(k, next(shares) * axis) for k, _ in row] for axis, row in zip(axes, tree.A, strict=True)]


def _twists(numbers: Numbers, frame: int, velocities: list[int], moved: list[list[tuple[int, Array]]]) -> Array:
    """Return the twist of a frame for unit velocities, shape (6, len(velocities))."""
    J, wanted = np.zeros((6, len(velocities))), {k: column for column, k in enumerate(velocities)}
    while frame:
        for k, axis in moved[frame]:
            if k in wanted:
                J[:, wanted[k]] += axis
        frame = numbers.tree.parent[frame]
    return J


def _between(numbers: Numbers, joint: Joint) -> list[str]:
    """Return the bodies on the way round a loop, the lowest common ancestor left out."""
    tree = numbers.tree
    inner, outer = tree.paths(tree.home[joint.parent][0], tree.home[joint.child][0])
    moves = {*inner, *outer}
    return [body.name for body in numbers.scene.bodies if tree.home[body.name][0] in moves]


# Words


def _start(numbers: Numbers, decisions: LoopDecisions) -> list[str]:
    """Return why the velocities at the start do not fit, where all parameters have values of their own."""
    if numbers.scene.free_parameters:
        return []
    try:
        numbers.fitting_rates(np.array(decisions.assembly.q), numbers.declared_rates())
    except DerivationError as fault:
        return [str(fault).removeprefix(f"{numbers.scene.name}: ")]
    return []


def _notes(scene: Scene, decisions: LoopDecisions, result: Mobility) -> list[str]:
    notes = list(decisions.assembly.notes)
    if result.planar and result.spatial != result.by_loops:
        names = ", ".join(result.planar)
        notes.append(
            f"planar: {names}; counted in space (5.20) gives {result.spatial}, in the plane {result.by_loops}; "
            f"{3 * len(result.planar)} reactions out of the plane are indeterminate"
        )
    if result.by_rank > result.by_loops:
        notes.append(
            f"overconstrained: {result.by_rank} by rank, {result.by_loops} by counting; redundant: "
            f"{'; '.join(result.redundant)}; not unique: {'; '.join(result.not_unique)}"
        )
    if result.here > result.by_rank:
        notes.append(
            f"change point: at the assembled position itself {result.here} degrees of freedom by rank, "
            f"{result.by_rank} near it"
        )
    if result.by_rank == 0:
        notes.append("the loops leave no degree of freedom: it is a structure")
    notes += [f"idle: {motion}; it needs no drive" for motion in result.idle]
    drives, free = len(result.drives), result.by_rank - len(result.idle)
    if decisions.actuated is None:
        notes.append(f"inverse dynamics is not unique: {decisions.fault}")
    elif drives == 0 and free:
        notes.append("no joint is driven: inverse dynamics gives the forces at " + ", ".join(result.independent))
    elif drives < free:
        left = [name for name in result.independent if not scene.drives[scene.velocities.index(name)]]
        notes.append(
            f"underactuated: {drives} drive{'s' * (drives != 1)} ({', '.join(result.drives)}) for {free} degrees of "
            f"freedom; {', '.join(left)} {'is' if len(left) == 1 else 'are'} passive"
        )
    return notes

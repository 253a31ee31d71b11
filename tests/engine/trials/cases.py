"""A case: a mechanism with drives, loads, prescribed motions and locks, and states that it may be in."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.errors import SceneError
from symdyn.scene import parse

from ..jets import Jet, number
from ..joints import motion, pose
from ..mechanism import Array, Mechanism, NoDirection
from ..states import assemble, free_motions, moved, rank, rows
from .families import FAMILIES
from .options import PAIRED, Choice
from .scenes import COORDINATES, Drawing, Undrawable

LONGEST, LONGEST_IN_SPACE = 7, 4
"""Velocities of the largest mechanism; those of loops in space among the trials of every run, where they cost most."""

ATTEMPTS = 200

TURNABLE = ("revolute", "prismatic", "helical", "cylindrical", "fixed")

CLEAR = 1e-3
"""Smallest singular value of the rows over the largest at which forces are compared; below, digits are lost."""


@dataclass(frozen=True)
class Case:
    """One mechanism and what is done with it.

    Attributes:
        text: the scene as symdyn gets it. mechanism: as the reference does: without locks.
        values: of parameters; zeros: those that are bound to zero.
        locked: joints that are locked, with their velocities; held: velocities that cannot move.
        driven: velocities with a drive. led: velocities whose motion is prescribed. independent: names of coordinates.
        rank: of the rows at typical places.
        states: positions and velocities, (q, u).
    """

    seed: int
    choice: Choice
    text: str
    mechanism: Mechanism
    values: Mapping[str, float]
    zeros: tuple[str, ...]
    locked: Mapping[str, float]
    held: tuple[int, ...]
    driven: tuple[int, ...]
    led: tuple[int, ...]
    independent: tuple[str, ...]
    rank: int
    states: tuple[tuple[Array, Array, float], ...]


def draw(seed: int, choice: Choice) -> Case:
    """Return a case; the same seed and options, the same case."""
    for attempt in range(ATTEMPTS):
        try:
            return _drawn(seed, choice, random.Random(f"{seed}.{attempt}"))
        except (Undrawable, NoDirection):
            continue
    raise AssertionError(f"case {seed}: {ATTEMPTS} attempts gave no mechanism with {choice}")


def _drawn(seed: int, choice: Choice, rng: random.Random) -> Case:
    d = Drawing(rng, choice["told"], choice["natural"])
    d.gravity = rng.choice([[0, 0, -9.81], [0, 0, -9.81], [0, -9.81, 0], [1, -2, -9], "none"])
    q = FAMILIES[choice["family"]](d)
    m = d.mechanism()
    n = len(m.names)
    locked = _locks(d, m, q) if choice["lead"] == "locked" else {}
    held = _velocities(m, locked)
    free = [k for k in range(n) if k not in held]
    longest = LONGEST_IN_SPACE if seed < PAIRED and choice["family"] == "space" else LONGEST
    if not 1 <= len(free) <= longest or n > longest + 1:
        raise Undrawable
    places = [q, *_places(m, q, held, rng)]
    G = [rows(m.at(one))[:, free] for one in places]
    typical = max(rank(one) for one in G)
    freedoms = len(free) - typical
    state = m.at(q)
    for loop in state.contacts()[: len(m.scene.loops)]:  # not between bodies that are one
        if not np.any(abs((state.D(loop.parent, loop.child, loop.point.x) @ state.columns)[:, free]) > 1e-9):
            raise Undrawable
    closed = m.scene.is_constrained
    if freedoms < 1 or (closed and len(places) < 3) or not _clear(G[1], typical):
        raise Undrawable
    where = [one for one in G[:2] if rank(one) == typical]  # a choice is to hold at the start too, if that is typical
    driven = _drives(d, m, free, where, typical, closed)
    led = _motion(d, m, driven) if choice["lead"] == "motion" else ()
    _act(d, m, choice["acting"])
    i = 0
    for joint in m.scene.moving:
        d.tables["joints"][joint.name]["start"] = [float(x) for x in q[i : i + len(joint.coordinates)]]
        i += len(joint.coordinates)
    m = _acted(d, m)
    states = []
    for k, (place, rows_there) in enumerate(zip(places, G, strict=True)):
        if rank(rows_there) == typical and _clear(rows_there, typical):
            basis = np.zeros((n, freedoms))
            basis[free] = free_motions(rows_there)
            rest = choice["rest"] == "static" or k == 0
            size = 0.0 if rest else 1.0
            states.append((place, basis @ np.array([rng.uniform(-size, size) for _ in range(freedoms)]), 0.3 * k))
            if k == 0 and choice["rest"] != "static":  # at the start at rest, and moving
                states.append((place, basis @ np.ones(freedoms), 0.7))
    for place, u, t in states:  # every force has a direction
        m.at(place, u, t=t).pulls(), m.at(place, u, t=t).drags()
    if not states:
        raise Undrawable
    independent = ()
    if closed and choice["closing"] == "independent":
        independent = _independent(m, free, where, typical, driven, led)
    turned = _turned(d) if choice["hung"] else []
    return Case(
        seed=seed,
        choice=choice,
        text=d.text(locked, turned),
        mechanism=m,
        values=dict(d.values),
        zeros=tuple(d.zeros),
        locked=locked,
        held=tuple(held),
        driven=driven,
        led=led,
        independent=independent,
        rank=typical,
        states=tuple(states),
    )


def _clear(G: Array, count: int) -> bool:
    """Tell whether rows are far from losing their rank."""
    s = np.linalg.svd(G, compute_uv=False) if count else np.ones(1)
    return count <= len(s) and bool(s[max(count, 1) - 1] > CLEAR * max(1.0, s[0]))


def _fit(where: list[Array], others: list[int], typical: int) -> bool:
    """Tell whether rows determine these velocities, once the rest is known, wherever it is looked."""
    return all(_clear(G[:, others], typical) for G in where)


def _places(m: Mechanism, q: Array, held: list[int], rng: random.Random) -> list[Array]:
    """Return other positions, reached from the start along motions that are free."""
    closed, found = bool(m.scene.loops), []
    n = len(m.names)
    for k in range(8):
        loose = [i for i in range(n) if i not in held]
        way = np.zeros(n)
        basis = free_motions(rows(m.at(q))[:, loose]) if closed else np.eye(len(loose))
        way[loose] = basis @ np.array([rng.uniform(-1, 1) for _ in range(basis.shape[1])])
        place = assemble(m, moved(m, q, way * (0.15 + 0.1 * k if closed else 1.0)), np.array(held))
        if place is not None:
            found.append(place)
        if len(found) == 2:
            break
    return found


def _locks(d: Drawing, m: Mechanism, q: Array) -> dict[str, float]:
    """Return a joint or two that are locked where the mechanism starts."""
    found, i = {}, 0
    for joint in m.scene.moving:
        count = len(joint.coordinates)
        there = q[i : i + count]
        still = np.array([0.0] * (count - 4) + [1.0, 0, 0, 0] if count > len(joint.rates) else [0.0] * count)
        formulas = str(d.tables.get("constraints", ""))
        if (count == 1 or np.array_equal(there, still)) and not any(f"{c}_dot" in formulas for c in joint.coordinates):
            found[joint.name] = float(there[0]) if count == 1 else 0.0
        i += count
    return dict(d.rng.sample(sorted(found.items()), min(len(found), 1 + (len(found) > 3))))


def _turned(d: Drawing) -> list[str]:
    """Return joints to declare the other way round, of the types that can be."""
    able = [name for name, table in d.tables["joints"].items() if table["type"] in TURNABLE]
    return d.rng.sample(able, d.rng.randint(min(1, len(able)), len(able)))


def _velocities(m: Mechanism, joints: Mapping[str, float]) -> list[int]:
    """Return the velocities of some joints."""
    return [m.names.index(rate) for joint in m.scene.moving if joint.name in joints for rate in joint.rates]


def _drives(
    d: Drawing, m: Mechanism, free: list[int], where: list[Array], typical: int, closed: bool
) -> tuple[int, ...]:
    """Choose the drives: in a tree any; in a closed mechanism as many as freedoms at most, not against each other."""
    wanted = [k for k in free if d.rng.random() < (0.7 if not closed else 0.5)]
    driven: list[int] = []
    for k in d.rng.sample(wanted, len(wanted)):
        others = [i for i, one in enumerate(free) if one not in (*driven, k)]
        if not closed or (len(driven) < len(free) - typical and _fit(where, others, typical)):
            driven.append(k)
    for joint in m.scene.moving:
        places = [m.names.index(rate) for rate in joint.rates]
        table = d.tables["joints"][joint.name]
        if len(places) == 1 or not any(k in driven for k in places):
            table["drive"] = places[0] in driven
        else:
            table["drives"] = [k in driven for k in places]
    return tuple(sorted(driven))


def _motion(d: Drawing, m: Mechanism, driven: tuple[int, ...]) -> tuple[int, ...]:
    """Prescribe the motion of one driven joint with one velocity, if there is one."""
    able = [joint for joint in m.scene.moving if len(joint.rates) == 1 and m.names.index(joint.rates[0]) in driven]
    if not able:
        return ()
    joint = d.rng.choice(able)
    d.tables["joints"][joint.name]["motion"] = d.rng.choice(["0.3*sin(2*t) + 0.1", "0.2*t**2 - t", "exp(-t)/2", "1/2"])
    return (m.names.index(joint.rates[0]),)


def _independent(
    m: Mechanism, free: list[int], where: list[Array], typical: int, driven: tuple[int, ...], led: tuple[int, ...]
) -> tuple[str, ...]:
    """Choose independent velocities: prescribed ones, driven ones, then the last ones that do."""
    chosen: list[int] = []
    for k in [*led, *driven, *reversed(free)]:
        others = [i for i, one in enumerate(free) if one not in (*chosen, k)]
        if k not in chosen and len(chosen) < len(free) - typical and _fit(where, others, typical):
            chosen.append(k)
    return tuple(m.names[k] for k in chosen) if len(chosen) == len(free) - typical else ()


def _acted(d: Drawing, m: Mechanism) -> Mechanism:
    """Return the mechanism with what acts on it; struts are refused that never change their length, and no others."""
    struts = {f"{kind}.{name}": one for kind in ("springs", "dampers") for name, one in d.tables.get(kind, {}).items()}
    if d.zeros and any(_idle(d, m, one, d.zeros) for one in struts.values()):  # refused when these are bound
        raise Undrawable
    try:
        return d.mechanism()
    except SceneError as error:
        refused = [where for where in struts if f"{where}: an end lies where" in str(error)]
        if not refused or not all(_idle(d, m, struts[where]) for where in refused):
            raise
        raise Undrawable from error


def _idle(d: Drawing, m: Mechanism, strut: Mapping[str, Any], zeros: Sequence[str] = ()) -> bool:
    """Tell whether the joint between both bodies never changes the length, whatever parameters but zeros are."""
    if "joint" in strut:
        return False
    known = {name: 0.0 if name in zeros else math.sqrt(k + 2) for k, name in enumerate(d.values)}
    ends = (strut["from"], strut["to"])
    at = {end["body"]: np.array([number(parse(str(x)), known) for x in end["at"]]) for end in ends}
    for joint in (*m.scene.joints, *m.scene.loops):
        quaternion = dict(joint.shape).get("orientation") == "quaternion"
        count = len(joint.coordinates) or COORDINATES[joint.type] + quaternion
        if {joint.parent, joint.child} == {*at} and joint.coupling is None and count:
            lengths = []
            for q in np.random.default_rng(1).normal(size=(4, count)):
                q[-4:] /= np.linalg.norm(q[-4:]) if quaternion else 1
                T = pose(joint.origin, known) @ motion(joint, Jet(q), known) @ pose(joint.tip, known)
                lengths.append(np.linalg.norm((T.x @ [*at[joint.child], 1])[:3] - at[joint.parent]))
            if np.ptp(lengths) < 1e-9:
                return True
    return False


def _act(d: Drawing, m: Mechanism, acting: str) -> None:
    """Add springs, dampers, friction, loads."""
    rng, every = d.rng, acting == "everything"
    bodies = ["ground", *m.bodies]
    joints = d.tables["joints"]
    single = [j.name for j in m.scene.joints if j.moves and (j.coupling is not None or len(j.coordinates) == 1)]
    symbols = [*m.scene.coordinates, *m.names]

    def ends() -> dict[str, object]:
        if single and rng.random() < 0.5:
            return {"joint": rng.choice(single)}
        first, second = rng.sample(bodies, 2)
        return {"from": {"body": first, "at": d.place()}, "to": {"body": second, "at": d.place()}}

    def formula() -> object:
        x = rng.choice(symbols)
        others = [f"sqrt(1 + {x}**2)", f"exp(-{x})", f"tanh({x})", f"atan2({x}, 2)", f"log(2 + {x}**2)", f"abs({x})"]
        some = [d.small(), f"0.4*sin(2*t) + {d.small()}*{x}", f"{d.small()}*cos({x})", f"{x}*t", rng.choice(others), 0]
        return rng.choice(some)

    if acting == "springs" or every:
        d.tables["springs"] = {
            f"spring{k}": {**ends(), "stiffness": rng.choice([d.positive(), [d.positive(), d.small(), d.positive()]])}
            | ({"free": d.small()} | {"preload": d.small()} if rng.random() < 0.7 else {})
            for k in range(rng.randint(1, 2))
        }
    if acting == "dampers" or every:
        d.tables["dampers"] = {
            "damper": {**ends(), "damping": rng.choice([d.positive(), [d.positive(), d.positive()]])}
        }
        for name in single:
            joints[name]["damping"] = d.positive()
    if acting == "friction" or every:
        for name in single:
            smoothing = {} if rng.random() < 0.05 else {"smoothing": rng.choice([0.1, 0.5])}
            stribeck = {"static": d.number(3.5), "stribeck": 0.4} if rng.random() < 0.5 else {}
            joints[name]["friction"] = {"coulomb": d.positive()} | stribeck | smoothing
    if acting == "loads" or every:
        body = rng.choice(m.bodies)
        d.tables["loads"] = {
            "push": {"body": body, "at": d.place(), "force": [formula() for _ in range(3)], "frame": "ground"},
            "turn": {"body": m.bodies[-1], "force": [0, formula(), 0], "couple": [formula(), 0, 1], "frame": "body"},
        }
        for joint in m.scene.moving:
            if rng.random() < 0.4:
                joints[joint.name]["forces"] = [formula() for _ in joint.rates]

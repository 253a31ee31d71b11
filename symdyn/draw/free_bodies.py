"""The free-body diagram: one body cut loose, with every force and couple that acts on it drawn and named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from symdyn.algebra import Floats
from symdyn.draw.force_arrows import Wrench, with_corner, wrench
from symdyn.draw.ground import pushes
from symdyn.draw.outlines import strings, touching
from symdyn.draw.paint import File, check_picture
from symdyn.draw.pictures import body_names, delivered, known_body, lines, load_wrench, staged, with_descriptions
from symdyn.draw.places import Array, Frame, JointAxis, Label, Places, put, unit
from symdyn.draw.shapes import COLOURS, ENGLISH, Item, Title, dot, link, spots
from symdyn.draw.stage import View
from symdyn.draw.style import Text
from symdyn.draw.svg import Drawing
from symdyn.emit import in_latex
from symdyn.emit.print import PrintName
from symdyn.graph import Graph, evaluate
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES, without_place
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Contact, Element, Joint, velocity_name
from symdyn.spatial import Mat, Transform

SMALL = 1e-9  # of a unit vector: what lies along or across the line of sight


def free_body(
    scene: Scene,
    body: str,
    q: Sequence[float] | Array | None = None,
    wrenches: Sequence[Wrench] | None = None,
    parameters: Mapping[str, float] | None = None,
    view: tuple[float, float] | None = None,
    prefix: str = "",
    scheme: str = "auto",
    file: File | None = None,
    titles: Mapping[str, str] = ENGLISH,
    points: Mapping[str, Sequence[float]] | None = None,
) -> str:
    """Return one moving body with `wrenches`, or with what is `acting_on` it, as SVG text; the rest is as of `picture`.

    `points` are marked and named: places by their names in LaTeX, ground frame, m; shape (3,).

    Raises:
        DrawError: as of `picture`, and for a name that is no moving body.
    """
    known_body(scene, body)
    if file is not None:
        check_picture(file)
    stage = staged(scene, q, parameters, view)
    found = stage.places
    alone = replace(found, hinges=tuple(h for h in found.hinges if body in (h.joint.parent, h.joint.child)))
    seen = _closer(stage.view, alone, scene, body)
    colour = [one.name for one in scene.bodies].index(body) % COLOURS
    drawn = list(link(scene, found, found.body(body), seen, colour))
    labels: list[Label] = []
    for title, spot in _cuts(scene, alone, body):
        at, name = seen.flat(spot), title.places["name"]
        drawn.append(Item(f"cut-{name}", title, 2, np.zeros(1), (dot("joint", at, seen.size * 0.6),)))
        labels.append(Label(f"label-joint-{name}", Text.of_part(name), at, seen.size))
    for k, (name, place) in enumerate((points or {}).items(), 1):
        at = seen.flat(np.array([place], dtype=np.float64))
        drawn.append(
            Item(f"point-{k}", Title("point {name}", name=name), 2, np.zeros(1), (dot("mass", at, seen.size * 0.45),))
        )
        labels.append(Label(f"label-point-{k}", Text.of_name(name), at, seen.size))
    acting = acting_on(scene, body, q, parameters) if wrenches is None else wrenches
    forced: list[Label] = []
    for k, one in enumerate(_visible(acting, seen) if wrenches is None else acting):
        items, named = wrench(one, seen, f"wrench-{k + 1}")
        drawn += items
        forced += named
    segments = lines(drawn, 1)
    named_bodies = [label for label in body_names(found, seen) if label.id == f"label-body-{body}"]
    puts = put([*forced, *with_descriptions(scene, [*labels, *named_bodies])], segments, np.inf)
    drawing = Drawing(f"{scene.name}: {body}", tuple(drawn), puts)
    cornered = with_corner(drawing, scene, replace(found, gravity=np.zeros(3)), seen, segments)
    return delivered(cornered, prefix, scheme, file, titles)


def acting_on(
    scene: Scene, body: str, q: Sequence[float] | Array | None = None, parameters: Mapping[str, float] | None = None
) -> tuple[Wrench, ...]:
    """Return what acts on a body, with directions and names; sizes are 1 where they follow from the motion.

    Weight, loads, struts between points, ropes, the forces of contacts (of those that open, as if closed), and at every
    joint the wrenches that it transmits, along the axes of the joint frame, its drives, and Q along each velocity that
    feels more: springs, friction, rotors, stops, gears. What the parent exerts on the child, or what carries a plane on
    what touches it, is positive; so the child gets it with its own sign and the parent with the opposite one. A gap or
    a row that is a formula says not where it acts, and is left out.

    Raises:
        DrawError: as of `free_body`.
    """
    known_body(scene, body)
    found = staged(scene, q, parameters).places
    placed = found.body(body)
    acting: list[Wrench] = []
    if np.any(found.gravity):
        down = unit(found.gravity)
        declared = next(one for one in scene.bodies if one.name == body)
        masses = [] if placed.com is None else [(declared.mass.value, body, placed.com)]
        grains = enumerate(zip(declared.particles, placed.particles, strict=True), 1)
        masses += [(one.mass.value, f"{body},{k}", at) for k, (one, (_, at)) in grains]
        acting += [Wrench(f"{_mass_name(value, name)} g", _triple(at[0]), _triple(down)) for value, name, at in masses]
    acting += [load_wrench(load, found) for load in scene.loads if load.place.body == body]
    for one in strings(scene):
        acting += _pulls(one, body, found) if one in scene.elements else []  # a belt passes on a couple
    for hinge in found.hinges:
        acting += _transmitted(scene, hinge, body) if body in (hinge.joint.parent, hinge.joint.child) else []
    for row in touching(scene):
        acting += _pushed(row, body, found)
    return tuple(acting)


def _cut(hinge: JointAxis, body: str) -> Array:
    """Return where a joint is on a body: the moved frame, where its wrenches act."""
    slides = JOINTS[hinge.joint.type].slides(hinge.joint)
    return hinge.moved.p if hinge.joint.child == body or not slides else hinge.fixed.p


def _cuts(scene: Scene, alone: Places, body: str) -> list[tuple[Title, Array]]:
    """Return what a body is cut loose from: its joints and contacts, and where they are."""
    cuts = [(Title("cut at joint {name}", name=hinge.joint.name), _cut(hinge, body)) for hinge in alone.hinges]
    rows = [row for row in touching(scene) if body in (row.plane.body, row.place.body)]
    return cuts + [(Title("contact {name}", name=row.name), pushes(row, alone)[0][None]) for row in rows]


def _closer(view: View, alone: Places, scene: Scene, body: str) -> View:
    """Return a view along the same line in which the body fills the middle."""
    placed = alone.body(body)
    ends = [at[0] for _, at in _cuts(scene, alone, body)] + ([] if placed.com is None else [placed.com[0]])
    ends += [at[0] for at in spots(scene, alone, body)]
    for row in touching(scene):
        if row.name in alone.wheels and row.place.body == body:
            centre, _, radius = alone.wheels[row.name]
            ends += [centre[0] + sign * radius * way for way in (view.right, view.up) for sign in (-1, 1)]
    flat = view.lean(np.array(ends))
    low, high = flat.min(axis=0), flat.max(axis=0)
    size = float(max((high - low).max(), 1e-12 * max(1.0, float(np.abs(flat).max()))))
    scale = min(240.0 / size, view.scale * 50)
    return replace(view, scale=scale, middle=(low + high) / 2, size=8.0)


def _mass_name(value: object, body: str) -> str:
    """Return the LaTeX of a mass: its parameter, else m with the body's name."""
    return str(PrintName.of_code(value)) if isinstance(value, str) else rf"m_{{\mathrm{{{in_latex(body)}}}}}"


def _triple(x: Array) -> tuple[float, float, float]:
    return float(x[0]), float(x[1]), float(x[2])


def _pulls(one: Element, body: str, places: Places) -> list[Wrench]:
    """Return the pull of a strut between points, or of a rope, at each of its ends on the body."""
    pulls = []
    straight = places.routes.get(one, ()) or ((places.ends[one],) if one.ends else ())
    for ends, (near, far) in zip(straight, pairwise(one.ends), strict=True):
        a, b = ends[-2][0], ends[-1][0]
        for end, here, there in ((near, a, b), (far, b, a)):
            if end.body == body:
                name = rf"F_{{\mathrm{{{in_latex(one.name)}}}}}"
                pulls.append(Wrench(name, _triple(here), _triple(unit(there - here))))
    return pulls


def _pushed(row: Contact, body: str, places: Places) -> list[Wrench]:
    """Return the forces of a contact on a body, positive on what touches the plane, opposite on what carries it."""
    at, forces = pushes(row, places)
    acting = []
    for own, sense in ((row.place.body, 1.0), (row.plane.body, -1.0)):
        for k, force in enumerate(forces, 1) if own == body else ():
            index = f",{k}" if len(forces) > 1 else ""
            name = rf"{'' if sense > 0 else '-'}F_{{\mathrm{{{in_latex(row.name)}}}{index}}}"
            acting.append(Wrench(name, _triple(at), _triple(sense * force)))
    return acting


def _transmitted(scene: Scene, hinge: JointAxis, body: str) -> list[Wrench]:
    """Return the wrenches that a joint transmits to a body, its drives, and Q along velocities that feel more."""
    joint, found = hinge.joint, []
    sense = 1.0 if joint.child == body else -1.0
    at, minus = _triple(_cut(hinge, body)[0]), "" if sense > 0 else "-"
    pairs = _unit_wrenches(hinge)
    counts, numbers = [sum(np.any(part[k]) for part in pairs) for k in (0, 1)], [0, 0]
    for pair in pairs:
        names, vectors = ["", ""], [np.zeros(3), np.zeros(3)]
        for k, part in enumerate(pair):
            if np.any(part):
                numbers[k] += 1
                index = f",{numbers[k]}" if counts[k] > 1 else ""
                names[k] = rf"{minus}{'FM'[k]}_{{\mathrm{{{in_latex(joint.name)}}}{index}}}"
                vectors[k] = unit(hinge.fixed.R[0] @ part) * sense
        found.append(Wrench(names[0], at, _triple(vectors[0]), _triple(vectors[1]), names[1]))
    for k, twist in enumerate(hinge.twists):
        named = [str(PrintName.of_code(drive)) for drive in joint.drives[k : k + 1] if drive is not None]
        index = f",{k + 1}" if len(hinge.twists) > 1 else ""
        named += [rf"Q_{{\mathrm{{{in_latex(joint.name)}}}{index}}}"] if _feels(scene, joint, k) else []
        turns = bool(np.any(np.abs(twist[0, 3:]) > SMALL))
        vector = _triple(unit(twist[0, 3:] if turns else twist[0, :3]) * sense)
        found += [Wrench(minus + x, at, *(((0, 0, 0), vector) if turns else (vector,))) for x in named]
    return found


def _feels(scene: Scene, joint: Joint, k: int) -> bool:
    """Return whether more than a drive acts along a velocity of a joint: elements, rotor, stops, ties to others."""
    own = (joint.damping, joint.friction, joint.armature, *joint.forces[k : k + 1])
    tied = {velocity_name(x) for x in scene.followed}
    placed = (FORCES[row.kind].formula(row) for row in scene.constraints if row.name not in without_place(scene))
    tied |= {x for formula in placed if formula is not None for x in formula.symbols}
    more = joint.coupling or joint.dry or joint.limits.one_way or tied.intersection(joint.rates[k : k + 1])
    held = joint.limits.restitution is not None or joint.name in [one.joint for one in scene.struts]
    return held or bool(more) or any(x != Quantity.ZERO for x in own)


def _unit_wrenches(hinge: JointAxis) -> list[tuple[Array, Array]]:
    """Return the wrenches that the joint's kind can transmit, axes of the joint frame."""
    given = JOINTS[hinge.joint.type].forbids
    if given is None:
        return []
    between = Frame(np.einsum("nji,njk->nik", hinge.fixed.R, hinge.moved.R), np.zeros_like(hinge.fixed.p))
    p = np.einsum("nji,nj->ni", hinge.fixed.R, hinge.moved.p - hinge.fixed.p)[0]
    graph = Graph()
    names = [graph.symbol(f"x{k}") for k in range(12)]
    rows = [(names[k], names[k + 1], names[k + 2]) for k in range(0, 12, 3)]
    X = Transform(Mat(rows[:3]), rows[3])
    values = dict(zip(names, [*between.R[0].ravel().tolist(), *p.tolist()], strict=True))
    values |= {graph.symbol(name): 1.0 for one in Quantity.inside(hinge.joint.shape) for name in one.symbols}
    pairs = given.wrenches(hinge.joint, X)
    flat = np.array(evaluate([x for force, moment in pairs for x in (*force, *moment)], Floats(), values))
    flat[np.abs(flat) < SMALL] = 0.0
    return [(flat[k : k + 3], flat[k + 3 : k + 6]) for k in range(0, len(flat), 6)]


def _visible(wrenches: Sequence[Wrench], view: View) -> list[Wrench]:
    """Return what a planar picture shows: forces in the plane and couples about its normal."""
    if not view.planar:
        return list(wrenches)
    kept = []
    for one in wrenches:
        force, couple = np.array(one.force), np.array(one.couple)
        force = force - (force @ view.toward) * view.toward
        couple = (couple @ view.toward) * view.toward
        if np.linalg.norm(force) > SMALL or np.linalg.norm(couple) > SMALL:
            kept.append(replace(one, force=_triple(force), couple=_triple(couple)))
    return kept

"""A motion as glTF 2.0 in one binary file: a node a body, named as it is, whose place and turn the run moves.

Bodies hang on one root, which turns the ground frame so that y is up, as the format has it: a planar scene is seen
face-on, a spatial one from the side that pictures take. Each place of a body is that of its frame in the ground frame;
between two moments viewers move it straight and turn it the short way. Reference: Khronos, glTF 2.0 Specification
(2021), 3.11 Animations.

Bodies as links, joints, masses, wheels and the ground are solids, each in the frame of its body: boxes, cylinders,
balls and patches, made of triangles with normals.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.draw.ground import patches
from symdyn.draw.outlines import Outlined, gears
from symdyn.draw.places import Array, Frame, JointAxis, Placed, Places
from symdyn.draw.shapes import COLOURS, between_ends, carrier, outer, spots
from symdyn.draw.stage import View, vertical
from symdyn.draw.style import LIGHT
from symdyn.errors import DrawError
from symdyn.frozen import dataclass
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS

Triangles = np.ndarray[Any, np.dtype[np.int64]]
AROUND, DOWN = 32, 16  # corners of a circle, and of half of one


@dataclass(frozen=True)
class Solid:
    """A surface of one colour."""

    points: Array  # shape (n, 3), m
    normals: Array  # unit vectors outwards, one a point, shape (n, 3)
    triangles: Triangles  # three points each, counterclockwise from outside, shape (k, 3)
    colour: str  # #rrggbb
    alpha: float = 1.0  # from 0 (nothing is seen) to 1

    def put(self, R: Array, p: Array, scale: Array | float = 1.0) -> Solid:
        """Return the solid scaled along its axes, turned by R and moved by p."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R * np.broadcast_to(np.asarray(scale, dtype=np.float64), (3,)), p
        return self.transformed(T)

    def transformed(self, T: Array, unit: float = 1.0) -> Solid:
        """Return the solid where a matrix of shape (4, 4) takes it, which may stretch it; lengths times a unit."""
        A = T[:3, :3]
        with np.errstate(all="ignore"):
            normals = self.normals @ np.linalg.pinv(A)
            length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.where(length > 0, normals / np.where(length > 0, length, 1.0), [0.0, 0.0, 1.0])
        triangles = self.triangles[:, ::-1] if np.linalg.det(A) < 0 else self.triangles  # a mirror turns them round
        return Solid((self.points @ A.T + T[:3, 3]) * unit, normals, triangles, self.colour, self.alpha)


def box(half: Array, colour: str, alpha: float = 1.0) -> Solid:
    """Return a box around the origin with half its lengths, shape (3,)."""
    points, normals = [], []
    for axis in range(3):
        for sign in (1.0, -1.0):
            normal = sign * np.eye(3)[axis]
            u, v = np.eye(3)[(axis + 1) % 3], sign * np.eye(3)[(axis + 2) % 3]
            points += [(normal + a * u + b * v) * half for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            normals += [normal] * 4
    corners = 4 * np.arange(6)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    return Solid(np.array(points), np.array(normals), corners.reshape(-1, 3), colour, alpha)


def cylinder(radius: float, half: float, colour: str, alpha: float = 1.0) -> Solid:
    """Return a cylinder around z with half its length."""
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    round_ = np.stack([np.cos(angles), np.sin(angles), np.zeros(AROUND)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    rings = [round_ * radius + sign * half * up for sign in (-1, 1)]
    k = np.arange(AROUND)
    after = (k + 1) % AROUND
    side = np.concatenate([np.stack([k, after, AROUND + after], 1), np.stack([k, AROUND + after, AROUND + k], 1)])
    points, normals, triangles = [*rings], [round_, round_], [side]
    for sign, ring in zip((-1, 1), rings, strict=True):
        first = sum(map(len, points))
        points.append(np.concatenate([ring, [sign * half * up]]))
        normals.append(np.tile(sign * up, (AROUND + 1, 1)))
        fan = np.stack([k, after, np.full(AROUND, AROUND)], 1) + first
        triangles.append(fan if sign > 0 else fan[:, ::-1])
    return Solid(np.concatenate(points), np.concatenate(normals), np.concatenate(triangles), colour, alpha)


def ball(radius: float, colour: str, alpha: float = 1.0) -> Solid:
    """Return a ball around the origin."""
    down, around = np.linspace(0, np.pi, DOWN + 1), np.linspace(0, 2 * np.pi, AROUND + 1)
    theta, phi = (x.ravel() for x in np.meshgrid(down, around, indexing="ij"))
    normals = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(DOWN), np.arange(AROUND), indexing="ij"))
    a, b = i * (AROUND + 1) + j, (i + 1) * (AROUND + 1) + j
    triangles = np.concatenate([np.stack([a, b, b + 1], 1)[i < DOWN - 1], np.stack([a, b + 1, a + 1], 1)[i > 0]])
    return Solid(normals * radius, normals, triangles, colour, alpha)


def patch(corners: Array, colour: str, alpha: float = 1.0) -> Solid:
    """Return a flat surface with four corners, shape (4, 3)."""
    normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
    length = float(np.linalg.norm(normal))
    normals = np.tile(normal / length if length > 0 else [0.0, 0.0, 1.0], (4, 1))
    return Solid(corners.copy(), normals, np.array([[0, 1, 2], [0, 2, 3]]), colour, alpha)


def along(axis: Array) -> Array:
    """Return a rotation that takes z to a unit vector, always the same one for the same axis."""
    least = np.eye(3)[int(np.argmin(np.round(np.abs(axis), 6)))]
    x = np.cross(least, axis)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=1)


def bar(a: Array, b: Array, half: float, colour: str) -> tuple[Solid, ...]:
    """Return a box from one point to another; nothing where they are one."""
    length = float(np.linalg.norm(b - a))
    if not length > 0:
        return ()
    return (box(np.array([half, half, length / 2]), colour).put(along((b - a) / length), (a + b) / 2),)


FLOATS, WHOLES = 5126, 5125  # component types
VERTICES, INDICES = 34962, 34963  # what a view of the buffer is for
STILL = 1e-9  # of the largest extent, and of an angle in rad: what moves less stands still


def glb(
    name: str,
    bodies: Sequence[Placed],
    solids: Mapping[str, Sequence[Solid]],
    t: Array,
    view: View,
    gravity: Array,
    ground: str,
) -> bytes:
    """Return the file.

    Args:
        name: of the scene.
        bodies: their frames at every moment.
        solids: of bodies and of the ground, in the frames of bodies.
        t: times, s, shape (N,), from which equal ones of single precision are left out.
        view: how pictures look at the scene.
        gravity: shape (3,).
        ground: name of what does not move.

    Raises:
        DrawError: a number is beyond single precision, which the format has.
    """
    from pygltflib import GLTF2, Animation, Asset, Node, Scene as Shown

    file = _File(GLTF2(asset=Asset(version="2.0", generator="symdyn")), name)
    up = view.up if view.planar else vertical(gravity)
    root = Node(name=name, rotation=_turns(np.stack([view.right, up, np.cross(view.right, up)])[None])[0].tolist())
    file.gltf.nodes.append(root)
    still = Node(name=ground, mesh=file.mesh(ground, solids.get(ground, ())))
    file.gltf.nodes.append(still)
    times = (t - t[0]).astype(np.float32)
    kept = np.concatenate([[True], np.diff(np.maximum.accumulate(times)) > 0])
    extent = max((float(np.ptp(body.frame.p, axis=0).max(initial=0.0)) for body in bodies), default=0.0)
    moves = Animation(name="motion", samplers=[], channels=[])
    clock: list[int] = []
    for body in bodies:
        turns = _turns(body.frame.R)
        node = Node(name=body.name, mesh=file.mesh(body.name, solids.get(body.name, ())))
        node.translation, node.rotation = body.frame.p[0].tolist(), turns[0].tolist()
        file.gltf.nodes.append(node)
        for path, values, small in (("translation", body.frame.p, STILL * extent), ("rotation", turns, STILL)):
            if kept.sum() > 1 and float(np.abs(values - values[0]).max()) > small:
                clock = clock or [file.numbers(times[kept], "SCALAR", bounds=True)]
                _channel(moves, path, len(file.gltf.nodes) - 1, clock[0], file.numbers(values[kept], KINDS[path]))
    root.children = list(range(1, len(file.gltf.nodes)))
    file.gltf.scenes, file.gltf.scene = [Shown(name=name, nodes=[0])], 0
    file.gltf.animations = [moves] if moves.channels else []
    return file.bytes()


KINDS = {"translation": "VEC3", "rotation": "VEC4"}


def _channel(moves: Any, path: str, node: int, clock: int, values: int) -> None:
    from pygltflib import AnimationChannel, AnimationChannelTarget, AnimationSampler

    moves.samplers.append(AnimationSampler(input=clock, output=values, interpolation="LINEAR"))
    target = AnimationChannelTarget(node=node, path=path)
    moves.channels.append(AnimationChannel(sampler=len(moves.samplers) - 1, target=target))


def _turns(R: Array) -> Array:
    """Return unit quaternions (x, y, z, w) of rotations, shape (N, 4), none turned about against the one before."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_matrix(R).as_quat()
    signs = np.where(np.einsum("ni,ni->n", turns[1:], turns[:-1]) < 0, -1.0, 1.0)
    return np.asarray(turns * np.concatenate([[1.0], np.cumprod(signs)])[:, None])


class _File:
    """The tables of a file, and the bytes that they point into."""

    def __init__(self, gltf: Any, name: str) -> None:
        self.gltf, self.name = gltf, name
        self.blob = bytearray()
        self.materials: dict[tuple[str, float], int] = {}

    def mesh(self, name: str, solids: Sequence[Solid]) -> int | None:
        """Add solids as one mesh, a primitive each colour, and return its number; None without any."""
        from pygltflib import Attributes, Mesh, Primitive

        alike: dict[tuple[str, float], list[Solid]] = {}
        for one in solids:
            if len(one.triangles):
                alike.setdefault((one.colour, one.alpha), []).append(one)
        if not alike:
            return None
        primitives = []
        for look, group in alike.items():
            starts = np.cumsum([0, *(len(one.points) for one in group)])
            triangles = [one.triangles + start for one, start in zip(group, starts, strict=False)]
            points = self.numbers(np.concatenate([one.points for one in group]), "VEC3", VERTICES, bounds=True)
            normals = self.numbers(np.concatenate([one.normals for one in group]), "VEC3", VERTICES)
            indices = self.numbers(np.concatenate(triangles).ravel(), "SCALAR", INDICES)
            attributes = Attributes(POSITION=points, NORMAL=normals)
            primitives.append(Primitive(attributes=attributes, indices=indices, material=self.material(*look)))
        self.gltf.meshes.append(Mesh(name=name, primitives=primitives))
        return len(self.gltf.meshes) - 1

    def numbers(self, values: Any, kind: str, use: int | None = None, bounds: bool = False) -> int:
        """Add numbers and return the number of their accessor."""
        from pygltflib import Accessor, BufferView

        whole = use == INDICES
        with np.errstate(over="ignore"):
            stored = np.ascontiguousarray(values, dtype="<u4" if whole else "<f4")
        if not np.isfinite(stored).all():
            raise DrawError(f"{self.name}: a position is beyond single precision, which glTF has; choose other units")
        data = stored.tobytes()
        self.gltf.bufferViews.append(BufferView(buffer=0, byteOffset=len(self.blob), byteLength=len(data), target=use))
        self.blob += data
        rows = stored.reshape(len(stored), -1)
        found = Accessor(
            bufferView=len(self.gltf.bufferViews) - 1,
            componentType=WHOLES if whole else FLOATS,
            count=len(stored),
            type=kind,
        )
        if bounds:
            found.min, found.max = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
        self.gltf.accessors.append(found)
        return len(self.gltf.accessors) - 1

    def material(self, colour: str, alpha: float) -> int:
        """Return the number of a material, which is added where it is new."""
        from pygltflib import Material, PbrMetallicRoughness

        if (colour, alpha) not in self.materials:
            red, green, blue = (_linear(int(colour[k : k + 2], 16) / 255) for k in (1, 3, 5))
            surface = PbrMetallicRoughness(
                baseColorFactor=[red, green, blue, alpha], metallicFactor=0.0, roughnessFactor=0.7
            )
            mode = "OPAQUE" if alpha == 1.0 else "BLEND"
            self.gltf.materials.append(
                Material(pbrMetallicRoughness=surface, doubleSided=True, alphaMode=mode, alphaCutoff=None)
            )
            self.materials[colour, alpha] = len(self.gltf.materials) - 1
        return self.materials[colour, alpha]

    def bytes(self) -> bytes:
        from pygltflib import Buffer

        if self.blob:
            self.gltf.buffers = [Buffer(byteLength=len(self.blob))]
            self.gltf.set_binary_blob(bytes(self.blob))
        return b"".join(self.gltf.save_to_bytes())


def _linear(value: float) -> float:
    """Return a part of a colour as light, from its value on a screen (IEC 61966-2-1)."""
    return round(value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4, 6)


SEEN = 0.5  # how much of it is seen of a surface that may hide joints
JOINT, DARK, FLOOR = "#9aa4af", LIGHT["ink"], "#c5ced8"
LINK, SHAFT, THIN = 0.45, 0.7, 0.15  # half the width of a link, the radius of a joint, and of what is thin, in reaches


def standing(
    scene: Scene, places: Places, view: View, given: Mapping[str, tuple[Solid, ...]]
) -> dict[str, list[Solid]]:
    """Return the solids of every body and of the ground, by name, each in the frame of its body.

    Args:
        scene: any scene.
        places: where everything is, at every moment; solids are made at the first.
        view: says how large joints are.
        given: solids that are known of bodies, such as meshes of a robot: no link or joint is drawn in their place.
    """
    solids: dict[str, list[Solid]] = {Scene.GROUND: list(given.get(Scene.GROUND, ()))}
    for k, body in enumerate(places.bodies):
        colour = LIGHT[f"body{k % COLOURS}"]
        made = given[body.name] if body.name in given else _link(scene, places, body, view, colour)
        solids[body.name] = [*made, *_wheels(scene, places, body, view, colour)]
    frames = {Scene.GROUND: places.ground, **{body.name: body.frame for body in places.bodies}}
    for hinge in places.hinges:
        joint = hinge.joint
        if joint.child not in given:
            solids[joint.child] += _inside(frames[joint.child], _joint(hinge, view))
        if joint.parent not in given:
            solids[joint.parent] += _inside(frames[joint.parent], _rail(hinge, view))
        if (
            Scene.GROUND in (joint.parent, joint.child)
            and JOINTS[joint.type].class_t(joint)
            and Scene.GROUND not in given
        ):
            solids[Scene.GROUND] += _inside(places.ground, _stand(hinge, places, view))
    for row, corners in patches(scene, places):
        owner = row.plane.body
        solids[owner] += _inside(frames[owner], (patch(corners[0], FLOOR),))
    return solids


def _inside(frame: Frame, solids: tuple[Solid, ...]) -> tuple[Solid, ...]:
    """Return solids of the ground frame in the frame of a body, both at the first moment."""
    R, p = frame.R[0], frame.p[0]
    return tuple(one.put(R.T, -R.T @ p) for one in solids)


def _link(scene: Scene, places: Places, body: Placed, view: View, colour: str) -> tuple[Solid, ...]:
    """Return bars from the joint that carries a body to all that is on it, its centre of mass and its particles."""
    start, com = carrier(places, body.name).moved.p, body.com
    tips = outer(start, spots(scene, places, body.name), view)
    made: list[Solid] = []
    if com is not None and not tips:
        tips = outer(start, [com], view)
    elif com is not None and not any(between_ends(start, tip, com, view) for tip in tips):
        made += bar(start[0], com[0], THIN * view.reach, JOINT)
    if (outline := places.outlines.get(body.name)) is not None:
        made += _outlined(outline, body, view, colour)
    for tip in tips:
        made += bar(start[0], tip[0], LINK * view.reach, colour)
    heaviest = max((mass for one in places.bodies for mass, _ in one.particles), default=0.0)
    for mass, at in body.particles:
        share = (max(mass, 0.0) / heaviest) ** (1 / 3) if heaviest > 0 else 1.0
        made.append(ball((0.5 + 0.7 * share) * view.reach, colour).put(np.eye(3), at[0]))
    if com is not None:
        cube = box(np.full(3, 0.62 * view.reach if tips else 1.3 * view.reach), DARK if tips else colour)
        made.append(cube.put(body.frame.R[0], com[0]))
    return _inside(body.frame, tuple(made))


def _outlined(outline: Outlined, body: Placed, view: View, colour: str) -> tuple[Solid, ...]:
    """Return what a body looks like, thin in the ways that it does not extend in, and such that joints are seen."""
    sizes = np.array([*(float(np.linalg.norm(way)) for way in outline.ways), *[0.15 * view.reach] * 3][:3])
    ways = [way / size for way, size in zip(outline.ways, sizes, strict=False)]
    if len(ways) == 1:
        R = along(ways[0])
    else:
        R = np.stack([*ways[:2], np.cross(ways[0], ways[1])], axis=1) if ways else np.eye(3)
    made: dict[str, Callable[[], Solid]] = {
        "rod": lambda: box(np.array([LINK * view.reach, LINK * view.reach, sizes[0]]), colour),
        "disc": lambda: cylinder(sizes[0], sizes[2], colour, SEEN),
        "ring": lambda: cylinder(sizes[0], sizes[2], colour, SEEN / 2),
        "ball": lambda: ball(sizes[0], colour, SEEN),
        "plate": lambda: box(sizes, colour, SEEN),
        "point": lambda: ball(view.reach, colour),
    }
    return (made[outline.look]().put(body.frame.R[0] @ R, body.frame.point(outline.centre)[0]),)


def _wheels(scene: Scene, places: Places, body: Placed, view: View, colour: str) -> tuple[Solid, ...]:
    """Return rims of what rolls, with a spoke that shows how it turns."""
    made: list[Solid] = []
    for row in (*scene.contacts, *gears(scene)):
        if row.name not in places.wheels or row.place.body != body.name:
            continue
        centre, axis, radius = places.wheels[row.name]
        if axis is None:
            made.append(ball(radius, colour).put(np.eye(3), centre[0]))
            continue
        R, half = along(axis[0]), 0.25 * view.reach
        made.append(cylinder(radius, half, colour).put(R, centre[0]))
        made.append(box(np.array([0.9 * radius, 0.12 * radius, 1.2 * half]), FLOOR).put(R, centre[0]))
    return _inside(body.frame, tuple(made))


def _joint(hinge: JointAxis, view: View) -> tuple[Solid, ...]:
    """Return a cylinder about the axis of a turn, a box along a slide, a ball where it turns in more ways."""
    at, reach = hinge.moved.p[0], view.reach
    turns, slides = len(hinge.turns), len(hinge.slides)
    if turns == 1:
        return (cylinder(SHAFT * reach, reach, JOINT).put(along(hinge.turns[0][0]), at),)
    if not turns and slides:
        return (box(np.array([0.8, 0.8, 1.3]) * reach, JOINT).put(along(hinge.slides[0][0]), at),)
    if not turns or turns == slides == 3:  # welded, or held by nothing
        return ()
    return (ball(SHAFT * reach, JOINT).put(np.eye(3), at),)


def _rail(hinge: JointAxis, view: View) -> tuple[Solid, ...]:
    """Return what a slide runs on, as long as all its ways."""
    if len(hinge.slides) != 1 or len(hinge.turns) > 1:
        return ()
    axis, start = hinge.slides[0][0], hinge.fixed.p[0]
    ways = np.einsum("ni,ni->n", hinge.moved.p - hinge.fixed.p, hinge.slides[0])
    low, high = min(0.0, float(ways.min())) - 2 * view.reach, max(0.0, float(ways.max())) + 2 * view.reach
    return bar(start + low * axis, start + high * axis, THIN * view.reach, JOINT)


def _stand(hinge: JointAxis, places: Places, view: View) -> tuple[Solid, ...]:
    """Return a plate and the post on it that carries a joint."""
    up, reach = vertical(places.gravity), view.reach
    seat = (hinge.fixed if hinge.joint.parent == Scene.GROUND else hinge.moved).p[0]
    foot = seat - 2.4 * reach * up
    plate = box(np.array([1.8, 1.8, 0.12]) * reach, FLOOR).put(along(up), foot)
    return (plate, *bar(foot, seat, 2 * THIN * reach, JOINT))

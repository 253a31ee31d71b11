"""A motion as glTF 2.0 in one binary file: a node a body, named as it is, whose place and turn the run moves.

Bodies hang on one root, which turns the ground frame so that y is up, as the format has it: a planar scene is seen
face-on, a spatial one from the side that pictures take. Each place of a body is that of its frame in the ground frame;
between two moments viewers move it straight and turn it the short way. Reference: Khronos, glTF 2.0 Specification
(2021), 3.11 Animations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.draw.places import Array, Placed
from symdyn.draw.solids import Solid
from symdyn.draw.view import View, vertical
from symdyn.errors import DrawError

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
            raise DrawError(f"{self.name}: a place is beyond single precision, which glTF has; choose other units")
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
        """Return the whole file."""
        from pygltflib import Buffer

        if self.blob:
            self.gltf.buffers = [Buffer(byteLength=len(self.blob))]
            self.gltf.set_binary_blob(bytes(self.blob))
        return b"".join(self.gltf.save_to_bytes())


def _linear(value: float) -> float:
    """Return a part of a colour as light, from its value on a screen (IEC 61966-2-1)."""
    return round(value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4, 6)

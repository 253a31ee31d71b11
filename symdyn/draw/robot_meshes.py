"""What a robot file shows of its links, as solids: boxes, cylinders, balls, and meshes that lie in its folders.

A URDF says of every link what it looks like (`<visual>`) and what touches (`<collision>`); the second is taken where
the first cannot be read. Meshes are STL, OBJ and COLLADA, read by trimesh. A file comes from a stranger: no mesh is
opened outside the folder tree of the robot, none larger than is said here, and nothing that a mesh points to, such as
textures. Reference: the URDF XML specification, wiki.ros.org/urdf/XML.

How much a file shows is counted before it is loaded: STL and OBJ as their bytes tell it, COLLADA before it is unfolded,
since its nodes show nodes that show nodes.

    parts(n)      = parts of the nodes in n, of those that it names, and one a geometry
    triangles(n)  = the same of triangles

Each node is counted once, so that ten levels of ten take a hundred steps and not 10^10. What a list of corners has is
seen in its text: the `count` beside it may say anything.
"""

from __future__ import annotations

import io
import math
import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from defusedxml.ElementTree import fromstring

from symdyn.bounds import BOUNDS
from symdyn.draw.gltf import Solid, ball, box, cylinder
from symdyn.draw.places import Array
from symdyn.draw.plots import require
from symdyn.errors import DrawError, SceneError
from symdyn.scene import Scene, read_bounded
from symdyn.scene.formats import XmlElement, long_face, printable_names
from symdyn.scene.values import show

MOST_PARTS = BOUNDS["parts of a mesh"]

HEAD, RECORD = 84, 50
"""Bytes of a binary STL file before its triangles, and of each."""

FACE = re.compile(rb"^[ \t]*f[ \t]+([^\n]*)", re.MULTILINE)


def too_many(parts: int, triangles: int) -> str | None:
    """Return what is wrong with a mesh that shows so much, None for nothing."""
    if parts > MOST_PARTS:
        return f"shows {_rounded(parts)} parts; {MOST_PARTS} are the most that is read"
    if triangles > MOST_TRIANGLES:
        return f"shows some {_rounded(triangles)} triangles; {MOST_TRIANGLES} are the most that is read"
    return None


def stl_too_much(content: bytes) -> str | None:
    """Return what is wrong with an STL file, text or binary, that shows more than is read, None if it does not."""
    told = int.from_bytes(content[HEAD - 4 : HEAD], "little")
    binary = len(content) == HEAD + RECORD * told
    return too_many(1, told if binary else content.lower().count(b"endfacet"))


def obj_too_much(content: bytes) -> str | None:
    """Return what is wrong with an OBJ file that shows more than is read, None if it does not.

    Each change of the material begins a part; a face of n corners is n - 2 triangles.
    """
    parts, faces = content.count(b"usemtl"), _lines_of_faces(content)
    if fault := too_many(parts, faces) or long_face(content):
        return fault
    text = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\\\n", b" ")
    return too_many(parts, sum(max(1, len(face[1].split()) - 2) for face in FACE.finditer(text)))


def _lines_of_faces(content: bytes) -> int:
    """Return how many lines begin a face, without making them: there may be millions."""
    letters = np.frombuffer(content, dtype=np.uint8)
    blank = (letters == ord(" ")) | (letters == ord("\t"))
    ends = (letters == ord("\n")) | (letters == ord("\r")) | blank
    return int(np.count_nonzero((letters[1:-1] == ord("f")) & ends[:-2] & blank[2:])) + (content[:1] == b"f")


def _rounded(count: int) -> str:
    return str(count) if count < 10**9 else f"{count:.0e}"


DEEPEST = 100

CORNERS = {"triangles": 3, "trifans": 1, "tristrips": 1, "polylist": 1, "polygons": 1}
"""Lists of faces, and the fewest corners that a triangle of theirs takes from the list."""

NAMES = {"instance_node": "node", "instance_geometry": "geometry", "instance_controller": "controller"}
"""What names another element, and of which kind that is."""


def too_much(content: bytes) -> str | None:
    """Return what is wrong with a COLLADA file that shows more than is read, None if it does not.

    Args:
        content: of a file that the reader of XML has taken: no entities, a bounded number of elements.
    """
    unfolded = _Unfolded(fromstring(content))
    parts, triangles = unfolded.whole()
    if unfolded.deep:
        return f"shows nodes in nodes more than {DEEPEST} levels deep"
    return too_many(parts, triangles)


class _Unfolded:
    """Counts of one file; `deep` tells that it goes deeper than it may, or round in a circle."""

    def __init__(self, root: Element) -> None:
        self.root, self.deep = root, False
        self.named = {(_tag(one), one.get("id")): one for one in root.iter() if one.get("id")}
        self.counts: dict[int, tuple[int, int]] = {}

    def whole(self) -> tuple[int, int]:
        """Return the parts and triangles of all scenes."""
        scenes = [one for one in self.root.iter() if _tag(one) == "visual_scene"]
        return _sum(self.count(node, 0) for scene in scenes for node in scene if _tag(node) == "node")

    def count(self, one: Element, depth: int) -> tuple[int, int]:
        """Return the parts and triangles of a node, a geometry or a controller."""
        if id(one) not in self.counts:
            if depth > DEEPEST:
                self.deep = True
                return 0, 0
            self.counts[id(one)] = self._counted(one, depth)
        return self.counts[id(one)]

    def _counted(self, one: Element, depth: int) -> tuple[int, int]:
        if _tag(one) == "geometry":
            return 1, sum(map(_triangles, one.iter()))
        if _tag(one) == "controller":
            skins = (self._other("geometry", skin.get("source", "")) for skin in one if _tag(skin) in ("skin", "morph"))
            return _sum(self.count(skin, depth + 1) for skin in skins if skin is not None)
        inside = [child for child in one if _tag(child) == "node"]
        others = (self._other(NAMES[_tag(child)], child.get("url", "")) for child in one if _tag(child) in NAMES)
        return _sum(self.count(child, depth + 1) for child in (*inside, *others) if child is not None)

    def _other(self, kind: str, url: str) -> Element | None:
        return self.named.get((kind, url.removeprefix("#")))


def _sum(counts: Iterator[tuple[int, int]]) -> tuple[int, int]:
    parts = triangles = 0
    for more_parts, more_triangles in counts:
        parts, triangles = parts + more_parts, triangles + more_triangles
    return parts, triangles


def _triangles(faces: Element) -> int:
    """Return at most how many triangles a list of faces has, 0 of another element."""
    each = CORNERS.get(_tag(faces))
    if each is None:
        return 0
    offsets = [int(x) for one in faces if _tag(one) == "input" and (x := one.get("offset", "0")).isdecimal()]
    texts = [one.text or "" for one in faces.iter() if _tag(one) == "p"]
    return sum(map(_words, texts)) // (each * (max(offsets, default=0) + 1))


def _words(text: str) -> int:
    """Return how many words a text has, without making them: there may be millions."""
    shown = np.frombuffer(f" {text}".encode(), dtype=np.uint8) > ord(" ")
    return int(np.count_nonzero(shown[1:] & ~shown[:-1]))


def _tag(one: Element) -> str:
    return one.tag.rpartition("}")[2] if isinstance(one.tag, str) else ""


ENDINGS = {".stl": "stl", ".obj": "obj", ".dae": "dae"}
LARGEST_MESH, MOST_IN_ALL = BOUNDS["bytes of a mesh"], BOUNDS["bytes of the meshes that are shown"]
MOST_TRIANGLES = BOUNDS["triangles that are shown"]  # of all, each time that it is
TOO_MUCH: dict[str, Callable[[bytes], str | None]] = {"dae": too_much, "obj": obj_too_much, "stl": stl_too_much}
"""What is wrong with the size of a mesh, by its kind; looked at before it is loaded."""
PACKAGE, ABOVE = "package.xml", 6  # what marks the folder of a robot, and how far above its file it is looked for
PLAIN = "#9aa4af"  # where neither file says a colour


class NoMeshError(Exception):
    """A mesh that is not shown, and why."""


def robot_solids(scene: Scene, note: Callable[[str], None]) -> dict[str, tuple[Solid, ...]]:
    """Return what the file that a scene was read from shows of its bodies, in their frames; {} for other files.

    `note` takes what is not shown, and why.
    """
    path = Path(scene.source)
    try:
        if path.suffix.lower() not in (".urdf", ".xml") or not path.is_file():
            return {}
        root = XmlElement.read(path, lambda where, what: None)
    except (OSError, SceneError, ValueError):  # it has gone, or has become another file
        return {}
    if root.tag != "robot":
        return {}
    links = [link for link in root.all("link") if link.attributes.get("name", "").strip()]
    names = printable_names([link.attributes["name"].strip() for link in links], "link")
    known = {body.name for body in scene.bodies}
    shelf = _Shelf(path.resolve(), _colours(root, path.name, note))
    found: dict[str, tuple[Solid, ...]] = {}
    for link in links:
        body = names[link.attributes["name"].strip()]
        body = body if body in known else Scene.GROUND
        shown = _shown(link, shelf, note)
        if shown is not None:
            found[body] = found.get(body, ()) + shown
    return found if any(found.values()) else {}


def _shown(link: XmlElement, shelf: _Shelf, note: Callable[[str], None]) -> tuple[Solid, ...] | None:
    """Return what a link looks like, else what touches; () where it has no shape, None where none can be shown."""
    hidden = False
    for tag in ("visual", "collision"):
        try:
            solids = [solid for one in link.all(tag) for solid in shelf.solids(one)]
        except NoMeshError as fault:
            note(f"{shelf.path.name}: line {link.line}: link {show(link.attributes['name'])}: {fault}")
            hidden = True
            continue
        if solids:
            return tuple(solids)
    return None if hidden else ()


def _colours(root: XmlElement, name: str, note: Callable[[str], None]) -> dict[str, tuple[str, float]]:
    """Return the named materials of a file: colour and alpha."""
    found = {}
    for one in root.all("material"):
        try:
            colour = _colour(one)
        except NoMeshError as fault:
            note(f"{name}: line {one.line}: {fault}")
            continue
        if colour is not None:
            found[one.attributes.get("name", "")] = colour
    return found


def _colour(material: XmlElement) -> tuple[str, float] | None:
    colour = material.first("color")
    if colour is None:
        return None
    red, green, blue, alpha = (float(x) for x in np.clip(_numbers(colour, "rgba", 4, (0.6, 0.6, 0.6, 1.0)), 0, 1))
    return f"#{round(255 * red):02x}{round(255 * green):02x}{round(255 * blue):02x}", alpha


def _numbers(element: XmlElement | None, key: str, count: int, other: tuple[float, ...]) -> Array:
    """Return the numbers of an attribute, the other ones where it is not there."""
    if element is None or key not in element.attributes:
        return np.array(other)
    try:
        values = np.array([float(word) for word in element.attributes[key].split()])
    except ValueError:
        values = np.full(1, np.nan)
    if len(values) != count or not np.isfinite(values).all():
        raise NoMeshError(f"<{element.tag}> {key}={show(element.attributes[key])} are not {count} numbers")
    return values


@dataclass
class _Shelf:
    """The meshes of one robot: where they may lie, and how much of them has been read."""

    path: Path
    colours: dict[str, tuple[str, float]]
    read: dict[Path, tuple[Solid, ...]] = field(default_factory=dict)
    size: int = 0
    triangles: int = 0

    def solids(self, shown: XmlElement) -> Iterator[Solid]:
        """Yield the solids of a <visual> or <collision>, in the frame of its link."""
        geometry, origin = shown.first("geometry"), shown.first("origin")
        shape = next(iter(geometry.children), None) if geometry is not None else None
        if shape is None:
            return
        R, p = _turned(_numbers(origin, "rpy", 3, (0.0,) * 3)), _numbers(origin, "xyz", 3, (0.0,) * 3)
        look = self.look(shown)
        for one in self.shape(shape, look):
            self.triangles += len(one.triangles)
            if self.triangles > MOST_TRIANGLES:
                raise NoMeshError(f"what the file shows has more than {MOST_TRIANGLES} triangles")
            yield one.put(R, p)

    def look(self, shown: XmlElement) -> tuple[str, float] | None:
        """Return the colour that the robot file gives, None for none."""
        material = shown.first("material")
        if material is None:
            return None
        return _colour(material) or self.colours.get(material.attributes.get("name", ""))

    def shape(self, shape: XmlElement, look: tuple[str, float] | None) -> Iterator[Solid]:
        """Yield the solids of a geometry, around its origin."""
        colour, alpha = look or (PLAIN, 1.0)
        if shape.tag == "box":
            yield box(np.abs(_numbers(shape, "size", 3, (1.0,) * 3)) / 2, colour, alpha)
        elif shape.tag in ("cylinder", "capsule"):
            radius, length = (float(_numbers(shape, key, 1, (1.0,))[0]) for key in ("radius", "length"))
            yield cylinder(abs(radius), abs(length) / 2, colour, alpha)
            if shape.tag == "capsule":
                for sign in (-1, 1):
                    yield ball(abs(radius), colour, alpha).put(np.eye(3), np.array([0, 0, sign * abs(length) / 2]))
        elif shape.tag == "sphere":
            yield ball(abs(float(_numbers(shape, "radius", 1, (1.0,))[0])), colour, alpha)
        elif shape.tag == "mesh":
            scale = _numbers(shape, "scale", 3, (1.0,) * 3)
            for one in self.mesh(shape.attributes.get("filename", "").strip()):
                own = one if look is None else Solid(one.points, one.normals, one.triangles, *look)
                yield own.put(np.eye(3), np.zeros(3), scale)

    def mesh(self, name: str) -> tuple[Solid, ...]:
        """Return the solids of a mesh file, in m."""
        path = self.found(name)
        if path not in self.read:
            kind = ENDINGS[path.suffix.lower()]
            if path.stat().st_size > LARGEST_MESH or self.size > MOST_IN_ALL:
                most = f"{LARGEST_MESH >> 20} MB, and {MOST_IN_ALL >> 20} MB of all, are the most that is read"
                raise NoMeshError(f"the mesh {show(name)} has {path.stat().st_size >> 20} MB; {most}")
            try:
                data = read_bounded(path, LARGEST_MESH, "a mesh", "give a smaller one")
                self.size += len(data)
                with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore"):  # judged by what comes out
                    solids = tuple(_opened(data, kind, path))
            except (SceneError, DrawError) as fault:
                raise NoMeshError(str(fault)) from None
            self.read[path] = solids
        return self.read[path]

    def found(self, name: str) -> Path:
        """Return where a mesh lies: below the folder of the robot, whatever links lead to it.

        That is the nearest one above the robot file that has a package.xml, else the one that the file is in. A name
        package://robot/meshes/a.stl is looked for below it with and without the name of the package.
        """
        folder = self.path.parent
        above = (folder, *folder.parents)[:ABOVE]
        tree = next((one for one in above if (one / PACKAGE).is_file()), folder)
        scheme, _, rest = name.rpartition("://")
        if scheme in ("package", "model"):
            places = [tree / rest, tree / rest.partition("/")[2]]
        elif scheme in ("", "file"):
            places = [folder / rest]
        else:
            raise NoMeshError(f"the mesh {show(name)} is not beside the file; only meshes there are opened")
        try:
            real = [place.resolve() for place in places]
            inside = [place for place in real if place.is_relative_to(tree)]
            there = next((place for place in inside if place.is_file()), None)
        except (OSError, ValueError, RuntimeError):  # a name that no system allows, links in a circle
            inside, there = [], None
        if not inside:
            raise NoMeshError(f"the mesh {show(name)} is outside {tree}; only meshes below it are opened")
        if inside[0].suffix.lower() not in ENDINGS:
            raise NoMeshError(f"the mesh {show(name)} is none of {', '.join(ENDINGS)}; convert it")
        if there is None:
            raise NoMeshError(f"the mesh {show(name)} is not there; put it below {tree}")
        return there


def _turned(rpy: Array) -> Array:
    (a, b, c), (d, e, f) = (list(map(g, rpy)) for g in (math.cos, math.sin))
    return np.array([
        [c * b, c * e * d - f * a, c * e * a + f * d],
        [f * b, f * e * d + c * a, f * e * a - c * d],
        [-e, b * d, b * a],
    ])  # fmt: skip


def _opened(data: bytes, kind: str, path: Path) -> Iterator[Solid]:
    """Yield the parts of a mesh, in m; nothing that it points to is opened.

    Raises:
        DrawError: trimesh is missing.
        NoMeshError: it is broken.
    """
    require("meshes", "trimesh", *(("collada",) if kind == "dae" else ()))
    import trimesh

    try:
        unit = _unit(data, path) if kind == "dae" else 1.0
        look = TOO_MUCH.get(kind)
        if look and (fault := look(data)):
            raise NoMeshError(f"{path.name} {fault}")
        shown: Any = trimesh.load_scene(io.BytesIO(data), file_type=kind, process=False)
        parts = [(shown.graph[node][0], shown.geometry[shown.graph[node][1]]) for node in shown.graph.nodes_geometry]
        parts = [(place, part) for place, part in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)]
        if not parts:
            raise NoMeshError(f"{path.name} holds no triangles")
        for place, part in parts:
            yield _part(part, kind == "dae").transformed(np.asarray(place, dtype=np.float64), unit)
    except (NoMeshError, SceneError):
        raise
    except Exception as fault:  # whatever trimesh and its readers make of a file that is broken
        lines = str(fault).strip().splitlines() or [""]
        raise NoMeshError(f"{path.name} cannot be read ({type(fault).__name__}: {lines[0][:100]})") from None


def _part(part: Any, coloured: bool) -> Solid:
    """Return a part of a mesh: COLLADA has colours and round edges, other formats are shown with flat faces."""
    corners = part.vertices[part.faces].reshape(-1, 3)
    normals = part.vertex_normals[part.faces].reshape(-1, 3) if coloured else np.repeat(part.face_normals, 3, axis=0)
    if len(normals) != len(corners) or not (np.isfinite(corners).all() and np.isfinite(normals).all()):
        raise NoMeshError("a mesh has corners that are no numbers")
    rows, triangles = np.unique(
        np.concatenate([corners, normals], axis=1, dtype=np.float32, casting="same_kind"), axis=0, return_inverse=True
    )
    red, green, blue, alpha = _rgba(part.visual) if coloured else _rgba(None)
    points, normals = rows[:, :3].astype(np.float64), rows[:, 3:].astype(np.float64)
    return Solid(points, normals, triangles.reshape(-1, 3), f"#{red:02x}{green:02x}{blue:02x}", alpha / 255)


def _rgba(visual: Any) -> tuple[int, int, int, int]:
    """Return the colour of a part, 0 to 255 each, by whichever way trimesh tells it."""
    told = getattr(getattr(visual, "material", visual), "main_color", None)
    values = [*bytes.fromhex(PLAIN[1:]), 255] if told is None else [int(x) for x in told]
    red, green, blue, alpha = values if len(values) == 4 else (*values[:3], 255)
    return red, green, blue, alpha


def _unit(data: bytes, path: Path) -> float:
    """Return the length in m that a COLLADA file counts in, once it is known to hold no entities and no bombs."""
    root = XmlElement.parse(data, str(path))
    unit = next((one for one in root.walk() if one.tag.rpartition("}")[2] == "unit"), None)
    meters = float(_numbers(unit, "meter", 1, (1.0,))[0])
    return meters if meters > 0 else 1.0

"""How much a COLLADA file shows, counted before it is unfolded: nodes show nodes that show nodes.

    parts(n)      = parts of the nodes in n, of those that it names, and one a geometry
    triangles(n)  = the same of triangles

Each node is counted once, so that ten levels of ten take a hundred steps and not 10^10. What a list of corners has is
seen in its text: the `count` beside it may say anything.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np
from defusedxml.ElementTree import fromstring

from symdyn.draw.mesh_size import too_many

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

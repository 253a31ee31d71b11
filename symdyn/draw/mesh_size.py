"""How much STL and OBJ files show, counted before they are loaded: parts and triangles, as their bytes tell them."""

from __future__ import annotations

import re

import numpy as np

from symdyn.bounds import BOUNDS
from symdyn.scene.formats import long_face

MOST_PARTS, MOST_TRIANGLES = BOUNDS["parts of a mesh"], BOUNDS["triangles that are shown"]

HEAD, RECORD = 84, 50
"""Bytes of a binary STL file before its triangles, and of each."""

FACE = re.compile(rb"^[ \t]*f[ \t]+([^\n]*)", re.MULTILINE)


def too_many(parts: int, triangles: int) -> str | None:
    """Return what is wrong with a mesh that shows so much, None for nothing."""
    if parts > MOST_PARTS:
        return f"shows {_shown(parts)} parts; {MOST_PARTS} are the most that is read"
    if triangles > MOST_TRIANGLES:
        return f"shows some {_shown(triangles)} triangles; {MOST_TRIANGLES} are the most that is read"
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


def _shown(count: int) -> str:
    return str(count) if count < 10**9 else f"{count:.0e}"

"""Faces of OBJ files, looked at before anybody takes them apart: one face of millions of corners fills a machine."""

from __future__ import annotations

import re

from symdyn.bounds import BOUNDS

MOST_CORNERS = BOUNDS["corners of a face of a mesh"]

_LONG = re.compile(rb"^[ \t]*f[ \t][^\n]{%d,}" % (2 * MOST_CORNERS - 1), re.MULTILINE)
"""A face of more corners has at least a digit and a blank for each."""


def long_face(content: bytes) -> str | None:
    """Return what is wrong with a face of an OBJ file that has more corners than are read, None if there is none."""
    text = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\\\n", b" ")
    for face in _LONG.finditer(text):
        if len(face[0].split(None, MOST_CORNERS + 2)) > MOST_CORNERS + 1:
            line = text.count(b"\n", 0, face.start()) + 1
            return f"has a face of more than {MOST_CORNERS} corners, line {line}; make triangles of it"
    return None

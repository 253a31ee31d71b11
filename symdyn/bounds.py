"""How much is read of a file that comes from a stranger: one table, of which every reader takes its rows.

A small file must not fill a machine: what a few letters ask for (copies, heights, resolutions, instances of instances)
is counted before it is made, and what is long is refused before it is taken apart. A refusal names the bound.
`tests/test_file_bounds.py` has a file beyond every row.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

MB = 2**20

BOUNDS: Mapping[str, int] = MappingProxyType({
    "bytes of a TOML file": 4 * MB,
    "values of a TOML file": 300_000,
    "levels of a TOML file": 16,
    "parts of a dotted key": 16,
    "particles of a body": 500,
    "bytes of an XML file": 32 * MB,
    "bytes of a tag": MB,
    "levels of an XML file": 200,
    "elements of an XML file": 500_000,
    "bytes of a .par file": 4 * MB,
    "values of a list of a .par file": 2_000,
    "files that an MJCF file includes": 100,
    "elements that an MJCF file makes": 1_000_000,
    "bodies of an MJCF file": 2_000,
    "reserved by an attribute of an MJCF file": 10_000,
    "heights of the hfields of an MJCF file": 4_000_000,
    "corners of the built-in meshes of an MJCF file": 40_000,
    "bytes of a mesh": 64 * MB,
    "bytes of the meshes that give inertia": 512 * MB,
    "bytes of the meshes that are shown": 256 * MB,
    "corners of a face of a mesh": 1_000,
    "triangles that are shown": 800_000,
    "parts of a mesh": 2_000,
    "bytes of a file of numbers or formulas": 64 * MB,
    "numbers of a file of columns": 10_000_000,
    "bytes of the arrays of a file": 256 * MB,
    "characters of a program in JSON": 200_000_000,
    "runs of a sweep": 10**12,
    "blocks of a store": 1_000_000,
    "bytes of a store's own description": 64 * MB,
    "bytes of a student's file": 1_000_000,
    "lines of a student's file": 1_000,
    "bytes of a generated file": 256 * MB,
    "generated files that are read": 2_000,
})  # fmt: skip
"""By what is counted."""

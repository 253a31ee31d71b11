"""An identified scene as text: what it was made of stands on top, where a format has comments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.errors import printable
from symdyn.identification.scene import Identified
from symdyn.scene import Written, write_text


def written(identified: Identified, format: str, about: Sequence[str] = ()) -> Written:
    """Return the identified scene as text, and what the format cannot hold.

    Args:
        identified: the scene.
        format: "toml" or "urdf", a key of the table of formats.
        about: lines of a comment on top, where the format has comments, before what is written as what.

    Raises:
        SceneError: the format is not written, or cannot hold a joint.
    """
    scene = identified.scene
    if format != "toml":  # which have one number for dry friction, and no letters
        joints = tuple(
            replace(j, friction=getattr(j.dry, "coulomb", j.friction), dry=None) if j.dry is not None else j
            for j in scene.joints
        )
        scene = replace(scene, joints=joints)
    made = write_text(scene, format, lossy=True)
    lines = [printable(line, keep="") for line in (*about, *identified.notes)]
    return Written(COMMENTED.get(format, lambda text, _: text)(made.text, lines), made.lost)


def _hashes(text: str, lines: Sequence[str]) -> str:
    return "".join(f"# {line}\n" for line in lines) + ("\n" if lines else "") + text


def _xml(text: str, lines: Sequence[str]) -> str:
    head, rest = text.split("\n", 1)
    plain = [line.replace("--", "- -") for line in lines]
    return "\n".join([head, *(f"<!-- {line} -->" for line in plain), rest])


COMMENTED = {"toml": _hashes, "urdf": _xml}
"""How a format says something on top that is no part of the scene."""

"""The rooms of the house, what each may import, and a picture of it: `python tests/rooms_picture.py`."""

from __future__ import annotations

from pathlib import Path

ROOMS = {  # room: the rooms it may import, and with them those below
    "unlocked": [],
    "errors": ["unlocked"],
    "arguments": ["errors"],
    "rounding": ["errors"],
    "extras": ["rounding"],
    "resources": ["extras"],
    "shown": [],
    "bounds": [],
    "shell": [],
    "verdict": [],
    "interrupts": [],
    "graph": ["errors"],
    "algebra": ["graph"],
    "spatial": ["graph"],
    "scene": ["spatial", "resources", "shown", "arguments", "bounds"],
    "dynamics": ["scene", "algebra"],
    "program": ["dynamics"],
    "emit": ["program"],
    "build": ["emit"],
    "draw": ["emit", "shell"],
    "verify": ["build", "verdict"],
    "simulation": ["verify", "draw", "interrupts"],
    "linear": ["simulation"],
    "bench": ["simulation"],
    "transcription": ["simulation"],
    "teach": ["linear"],
    "identification": ["simulation"],
    "study": ["simulation"],
    "notebook": ["teach", "transcription", "identification", "study"],
    "watch": ["notebook"],
    "cli": ["watch", "bench", "teach"],
}

FOLDERS = {  # room: folder: the folders of the same room that it may import; "" are the room's own files
    "dynamics": {
        "mechanism": [],
        "lagrange": ["mechanism"],
        "recursive": ["mechanism"],
        "loops": ["lagrange", "mechanism"],
        "reactions": ["loops", "mechanism"],
        "roads": ["reactions", "loops", "recursive", "lagrange", "mechanism"],
        "closed_forms": ["roads", "loops", "recursive", "mechanism"],
    },
    "build": {"": [], "backends": [""]},
    "emit": {"": [], "code": [""], "targets": ["code", ""], "print": [""]},
    "scene": {
        "values": [],
        "joints": ["values"],
        "forces": ["joints", "values"],
        "checks": ["forces", "joints", "values"],
        "declaration": ["checks", "forces", "joints", "values"],
        "formats": ["declaration", "forces", "joints", "values"],
        "": ["formats", "declaration", "checks", "forces", "joints", "values"],
    },
    "simulation": {
        "prescribed": [],
        "feedback": ["prescribed"],
        "equations": ["feedback", "prescribed"],
        "integrate": ["equations", "feedback", "prescribed"],
        "": ["integrate", "equations", "feedback", "prescribed"],
        "ensemble": ["", "integrate", "equations", "feedback", "prescribed"],
    },
    "bench": {"": [], "stress": [""]},
    "teach": {
        "languages": [],
        "": ["languages"],
        "student": ["", "languages"],
        "roads": ["student", "", "languages"],
        "practice": ["student", "", "languages"],
        "interactive": ["roads", "", "languages"],
        "render": ["interactive", "practice", "roads", "", "languages"],
    },
    "program": {"passes": [], "": ["passes"]},
    "verify": {"written": [], "": ["written"]},
}

WIDTH, HEIGHT, STEP, GAP, LINE = 118, 30, 62, 24, 13


def levels() -> list[list[str]]:
    """Return the rooms by level, the lowest first."""
    depth: dict[str, int] = {}
    for room, lower in ROOMS.items():  # those below come first
        depth[room] = 1 + max((depth[one] for one in lower), default=0)
    return [[room for room in ROOMS if depth[room] == level] for level in range(1, max(depth.values()) + 1)]


def picture() -> str:
    """Return the rooms as SVG: boxes, and an arrow to each room that may be imported."""
    rows = levels()
    inner = {room: [name for name in folders if name] for room, folders in FOLDERS.items()}
    most = max(map(len, rows)) * (WIDTH + GAP) + GAP
    place: dict[str, tuple[float, float, float]] = {}
    y = float(GAP)
    for row in reversed(rows):
        tall = HEIGHT + LINE * max(len(inner.get(room, ())) for room in row)
        for k, room in enumerate(row):
            x = (most - len(row) * (WIDTH + GAP) + GAP) / 2 + k * (WIDTH + GAP)
            place[room] = (x, y, HEIGHT + LINE * len(inner.get(room, ())))
        y += tall + STEP - HEIGHT
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {most:g} {y:g}"',
        ' font-family="sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="#fff"/>',
    ]
    for room, (x, top, tall) in place.items():
        for lower in ROOMS[room]:
            left, start, _ = place[lower]
            ends = f"M{x + WIDTH / 2:g} {top + tall:g}L{left + WIDTH / 2:g} {start:g}"
            lines.append(f'<path d="{ends}" stroke="#888" fill="none"/>')
    for room, (x, top, tall) in place.items():
        middle = x + WIDTH / 2
        lines.append(
            f'<rect x="{x:g}" y="{top:g}" width="{WIDTH}" height="{tall:g}" rx="4" fill="#eef3f8" stroke="#456"/>'
        )
        lines.append(f'<text x="{middle:g}" y="{top + 19:g}" text-anchor="middle" font-weight="bold">{room}</text>')
        for k, name in enumerate(reversed(inner.get(room, []))):
            at = top + HEIGHT + LINE * k + 6
            lines.append(f'<text x="{middle:g}" y="{at:g}" text-anchor="middle" font-size="11">{name}</text>')
    return "\n".join([*lines, "</svg>", ""])


if __name__ == "__main__":
    path = Path(__file__).resolve().parent.parent / "docs" / "pictures" / "rooms.svg"
    path.write_text(picture(), encoding="utf-8")

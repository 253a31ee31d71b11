"""The packages of the house, what each may import, and a picture of it: `python tests/packages_picture.py`."""

from __future__ import annotations

from pathlib import Path

PACKAGES = {  # package: the packages it may import, and with them those below
    "unlocked": [],
    "frozen": [],
    "errors": ["unlocked", "frozen"],
    "arguments": ["errors"],
    "rounding": ["errors"],
    "extras": ["rounding"],
    "resources": ["extras"],
    "shown": ["arguments"],
    "bounds": ["frozen"],
    "shell": [],
    "verdict": ["frozen"],
    "interrupts": [],
    "graph": ["errors"],
    "algebra": ["graph"],
    "spatial": ["graph"],
    "scene": ["spatial", "resources", "shown", "bounds"],
    "dynamics": ["scene", "algebra"],
    "program": ["dynamics"],
    "emit": ["program"],
    "table": ["emit"],
    "runtime": ["emit"],
    "draw": ["emit", "shell"],
    "simulation": ["runtime", "draw", "interrupts", "table"],
    "verify": ["simulation", "verdict"],
    "linear": ["simulation"],
    "bench": ["simulation", "verdict"],
    "transcription": ["linear"],
    "teach": ["linear", "verify"],
    "identification": ["simulation"],
    "study": ["simulation"],
    "notebook": ["teach", "transcription", "identification", "study"],
    "playground": ["notebook"],
    "cli": ["playground", "bench", "teach"],
}

FOLDERS = {  # package: folder: the folders of the same package that it may import; "" are the package's own files
    "dynamics": {
        "mechanism": [],
        "recursive": ["mechanism"],
        "loops": ["mechanism"],
        "reactions": ["loops", "mechanism"],
        "outputs": ["reactions", "loops", "recursive", "mechanism"],
        "closed_forms": ["outputs", "loops", "recursive", "mechanism"],
    },
    "runtime": {"": [], "backends": [""]},
    "emit": {"": [], "code": [""], "targets": ["code", ""], "print": [""]},
    "scene": {
        "values": [],
        "joints": ["values"],
        "forces": ["joints", "values"],
        "declaration": ["forces", "joints", "values"],
        "formats": ["declaration", "forces", "joints", "values"],
        "": ["formats", "declaration", "forces", "joints", "values"],
    },
    "simulation": {
        "prescribed": [],
        "equations": ["prescribed"],
        "integrate": ["equations", "prescribed"],
        "": ["integrate", "equations", "prescribed"],
    },
    "bench": {"": [], "stress": [""]},
    "teach": {
        "languages": [],
        "": ["languages"],
        "student": ["", "languages"],
        "derivations": ["student", "", "languages"],
        "practice": ["derivations", "student", "", "languages"],
        "render": ["practice", "derivations", "", "languages"],
    },
    "verify": {"written": [], "": ["written"]},
}

WIDTH, HEIGHT, STEP, GAP, LINE = 118, 30, 62, 24, 13


def levels() -> list[list[str]]:
    """Return the packages by level, the lowest first."""
    depth: dict[str, int] = {}
    for package, lower in PACKAGES.items():  # those below come first
        depth[package] = 1 + max((depth[one] for one in lower), default=0)
    return [[package for package in PACKAGES if depth[package] == level] for level in range(1, max(depth.values()) + 1)]


def picture() -> str:
    """Return the packages as SVG: boxes, and an arrow to each package that may be imported."""
    rows = levels()
    inner = {package: [name for name in folders if name] for package, folders in FOLDERS.items()}
    most = max(map(len, rows)) * (WIDTH + GAP) + GAP
    place: dict[str, tuple[float, float, float]] = {}
    y = float(GAP)
    for row in reversed(rows):
        tall = HEIGHT + LINE * max(len(inner.get(package, ())) for package in row)
        for k, package in enumerate(row):
            x = (most - len(row) * (WIDTH + GAP) + GAP) / 2 + k * (WIDTH + GAP)
            place[package] = (x, y, HEIGHT + LINE * len(inner.get(package, ())))
        y += tall + STEP - HEIGHT
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {most:g} {y:g}"',
        ' font-family="sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="#fff"/>',
    ]
    for package, (x, top, tall) in place.items():
        for lower in PACKAGES[package]:
            left, start, _ = place[lower]
            ends = f"M{x + WIDTH / 2:g} {top + tall:g}L{left + WIDTH / 2:g} {start:g}"
            lines.append(f'<path d="{ends}" stroke="#888" fill="none"/>')
    for package, (x, top, tall) in place.items():
        middle = x + WIDTH / 2
        lines.append(
            f'<rect x="{x:g}" y="{top:g}" width="{WIDTH}" height="{tall:g}" rx="4" fill="#eef3f8" stroke="#456"/>'
        )
        lines.append(f'<text x="{middle:g}" y="{top + 19:g}" text-anchor="middle" font-weight="bold">{package}</text>')
        for k, name in enumerate(reversed(inner.get(package, []))):
            at = top + HEIGHT + LINE * k + 6
            lines.append(f'<text x="{middle:g}" y="{at:g}" text-anchor="middle" font-size="11">{name}</text>')
    return "\n".join([*lines, "</svg>", ""])


if __name__ == "__main__":
    path = Path(__file__).resolve().parent.parent / "docs" / "pictures" / "packages.svg"
    path.write_text(picture(), encoding="utf-8")

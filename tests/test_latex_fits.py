"""No page of LaTeX is wider than its paper: pdflatex's log names no box that sticks out by more than a point.

Every example, gallery scene and finding, in every grouping and as a lesson by every formulation, runs in `make slow`; a
fixed few run always: those with springs and dampers between points, wide fractions, wide matrices and wide tables.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from symdyn.emit.print.dalembert_page import dalembert_text
from symdyn.emit.print.equations_text import GROUPS, base_parameters_text, equations_text
from symdyn.errors import DerivationError, EmitError
from symdyn.scene import Scene, read

ROOT = Path(__file__).parent.parent
FOLDERS = ("examples", "examples/gallery", "tests/data/findings")
MOST = 1.0  # pt

FRAGMENT = r"""\documentclass[10pt,a4paper]{article}
\usepackage{amsmath}
\usepackage[margin=20mm]{geometry}
\allowdisplaybreaks
\begin{document}
%s
\end{document}
"""


def grouped(group: str, angles: str = "long") -> Callable[[Scene], str]:
    return lambda scene: equations_text(scene, "latex", group, angles, document=True)


def lesson(formulation: str) -> Callable[[Scene], str]:
    def written(scene: Scene) -> str:
        from symdyn.teach import rendered, walkthrough

        files = rendered(walkthrough(scene, detail="full", formulation=formulation), "latex")
        return next(str(text) for name, text in files.items() if name.endswith(".tex"))

    return written


PAGES: dict[str, Callable[[Scene], str]] = {
    **{group: grouped(group) for group in GROUPS},
    "short": grouped("equations", "short"),
    "base-parameters": lambda scene: FRAGMENT % base_parameters_text(scene),
    "dalembert": lambda scene: dalembert_text(scene, document=True),
    **{
        f"lesson-{formulation}": lesson(formulation)
        for formulation in ("lagrange", "multipliers", "quaternions", "dalembert")
    },
}

ALWAYS = (
    *(("tests/data/findings/car.toml", page) for page in ("equations", "coefficients", "textbook", "matrix", "short")),
    ("tests/data/findings/car.toml", "lesson-lagrange"),
    ("tests/data/findings/sp.toml", "equations"),
    ("tests/data/findings/sp.toml", "matrix"),
    ("tests/data/findings/sp.toml", "lesson-lagrange"),
    ("examples/spatial_slider_crank.toml", "dalembert"),
    ("examples/gripper2.toml", "matrix"),
)
SHOWS = ("car", "sp")
"""Scenes of the finding."""


def scenes() -> Iterator[str]:
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).iterdir()):
            if path.suffix in (".toml", ".urdf"):
                yield path.relative_to(ROOT).as_posix()


def too_wide(tex: str, folder: Path) -> list[float]:
    """Return by how much boxes stick out, pt; pdflatex has to come to the end."""
    (folder / "page.tex").write_text(tex, encoding="utf-8")
    command = ["pdflatex", "-draftmode", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace", check=False)
    assert done.returncode == 0, done.stdout[-2000:]
    log = (folder / "page.log").read_text(encoding="utf-8", errors="replace")
    found = [float(x) for x in re.findall(r"Overfull \\hbox \(([\d.]+)pt too wide\)", log)]
    return [x for x in found if x > MOST]


def cases(always: bool) -> list[object]:
    every = [(scene, page) for scene in scenes() for page in PAGES]
    assert set(ALWAYS) <= set(every)
    return [
        pytest.param(
            scene,
            page,
            id=f"{Path(scene).stem}-{page}",
            marks=[pytest.mark.mends("30.control.4")] if always and Path(scene).stem in SHOWS else [],
        )
        for scene, page in (ALWAYS if always else every)
    ]


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.runs("pdflatex")
@pytest.mark.parametrize(("scene", "page"), cases(always=True))
def test_no_formula_leaves_the_page(scene: str, page: str, tmp_path: Path) -> None:
    assert too_wide(PAGES[page](read(str(ROOT / scene))), tmp_path) == []


@pytest.mark.slow
@pytest.mark.runs("pdflatex")
@pytest.mark.parametrize(("scene", "page"), cases(always=False))
def test_no_formula_of_any_scene_leaves_the_page(scene: str, page: str, tmp_path: Path) -> None:
    try:
        tex = PAGES[page](read(str(ROOT / scene)))
    except (DerivationError, EmitError) as fault:
        pytest.skip(f"there is no such page: {fault}")
    assert too_wide(tex, tmp_path) == []

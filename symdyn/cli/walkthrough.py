"""`symdyn walkthrough SCENE`: the derivation of the equations of motion as a lesson, step by step."""

from __future__ import annotations

import argparse
from pathlib import Path

from symdyn.cli.scene_options import read_scene, split
from symdyn.cli.talk import Waiting, print_paths
from symdyn.emit import check_folder, write
from symdyn.emit.code import page_stem
from symdyn.errors import EmitError, choice
from symdyn.teach import Handout

SLIDERS = "sliders"
ENDINGS = {".md": "md", ".tex": "latex", ".pdf": "pdf", ".html": "html", ".ipynb": "notebook"}


def run(options: argparse.Namespace) -> int:
    """Write the files and print their paths."""
    check_output(options)
    scene = read_scene(options)
    with Waiting("deriving") as progress:
        asked = Handout(
            scene, options.language, options.detail, options.until, options.formulation, options.seed,
            practised(options), options.grade or 2, split(options.ask) or (), options.sheet or "",
            options.variants or 1, options.math_editor or "",
        )  # fmt: skip
        if options.format == (SLIDERS,):
            print_paths(*placed({f"{page_stem(asked.shown.name)}.html": asked.page()}, options.output))
            return 0
        chosen = options.format or (ENDINGS.get(Path(options.output).suffix.lower(), "md"),)
        files = asked.files(chosen, progress)
    print_paths(*placed(files, options.output))
    return 0


def formats(text: str) -> tuple[str, ...]:
    """Return the formats of a list, each once."""
    names = tuple(dict.fromkeys(split(text) or ("",)))
    for name in names:
        if name not in (known := (*ENDINGS.values(), *Handout.platforms, SLIDERS)):
            raise argparse.ArgumentTypeError(f"{name!r} is no format; {choice(name, known)}")
    if SLIDERS in names[1:] or (names[1:] and names[0] == SLIDERS):
        raise argparse.ArgumentTypeError("sliders is a page without the lesson; ask for it alone")
    return names


def practised(options: argparse.Namespace) -> bool:
    """Whether results are left out."""
    return bool(options.exercises or options.grade or options.sheet) or options.ask is not None


def check_output(options: argparse.Namespace) -> None:
    """Raise EmitError for sliders that shall ask, an ending that is no format, and one file that shall hold several."""
    if options.format == (SLIDERS,) and practised(options):
        raise EmitError("sliders is a page without the lesson, which asks nothing; give --format html for exercises")
    platforms = [name for name in options.format or () if name in Handout.platforms]
    if platforms:
        _check_platform(platforms[0], options)
    elif options.variants:
        raise EmitError(
            f"--variants are of a question for a learning platform; give --format {' or '.join(Handout.platforms)}"
        )
    target = Path(options.output)
    if target.suffix and not target.is_dir():
        check_folder(target)
    ending = ENDINGS.get(target.suffix.lower(), "md")
    if options.math_editor and not (practised(options) and "html" in (options.format or (ending,))):
        raise EmitError("--math-editor is for a page that asks; give --format html and --exercises with it")
    if target.suffix and not target.is_dir() and len(options.format or ()) > 1:
        raise EmitError(f"{target.name}: {len(options.format)} formats are that many files; give a folder with -o")
    if target.suffix and target.suffix.lower() not in ENDINGS and not options.format and not target.is_dir():
        raise EmitError(f"{target.name}: {target.suffix} is no format; end with {', '.join(ENDINGS)}, or give --format")


def _check_platform(name: str, options: argparse.Namespace) -> None:
    """Raise EmitError for a question that asks nothing, options of pages and paper, and a folder in one file."""
    if not practised(options):
        raise EmitError(f"{name} is a question for a learning platform; give --exercises, --grade or --ask with it")
    if what := "sheet" if options.sheet else "detail" if options.detail == "full" else "":
        raise EmitError(f"--{what} is for pages and paper, not for {name}; leave it out")
    if "prairielearn" in options.format and (place := Path(options.output)).suffix and not place.is_dir():
        raise EmitError(f"{place.name}: prairielearn is a folder of four files; give a folder with -o")


def placed(files: dict[str, str | bytes], output: str) -> tuple[Path, ...]:
    """Write files to a folder, or the first of them to the file that `output` names, the others beside it."""
    target = Path(output)
    if not target.suffix or target.is_dir():
        return write(files, target)
    (_, first), *others = files.items()
    return write({target.name: first, **dict(others)}, target.parent)

"""What is installed beside Python's files: the folders of other files, and the version."""

from __future__ import annotations

from pathlib import Path


def folder(name: str) -> Path:
    """Return "templates" or "examples": inside an installed package, else beside it in a checkout."""
    installed = Path(__file__).parent / name
    return installed if installed.is_dir() else Path(__file__).parent.parent / name


def example_files() -> dict[str, Path]:
    """Return the files of the scenes that come with the package, those in folders too, by the name of the scene."""
    inside = folder("examples")
    return {path.stem: path for path in (*inside.glob("*.toml"), *inside.glob("*/*"))}


def version() -> str:
    """Return the version that is installed."""
    from importlib.metadata import PackageNotFoundError, version as installed

    try:
        return installed("symdyn")
    except PackageNotFoundError:
        return "(not installed)"

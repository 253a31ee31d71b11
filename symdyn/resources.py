"""What is installed beside Python's files: the folders of other files, and the version."""

from __future__ import annotations

from pathlib import Path


def template_folder() -> Path:
    """Return the folder of the Jinja templates."""
    return _folder("templates")


def example_folder() -> Path:
    """Return the folder of the example scenes."""
    return _folder("examples")


def _folder(name: str) -> Path:
    """Return a folder of files: inside an installed package, else beside it in a checkout."""
    installed = Path(__file__).parent / name
    return installed if installed.is_dir() else Path(__file__).parent.parent / name


def version() -> str:
    """Return the version that is installed."""
    from importlib.metadata import PackageNotFoundError, version as installed

    try:
        return installed("symdyn")
    except PackageNotFoundError:
        return "(not installed)"

"""What is installed beside Python's files: the folders of other files, and the version."""

from __future__ import annotations

from pathlib import Path


def folder(name: str) -> Path:
    """Return "templates" or "examples": inside an installed package, else beside it in a checkout."""
    installed = Path(__file__).parent / name
    return installed if installed.is_dir() else Path(__file__).parent.parent / name


def version() -> str:
    """Return the version that is installed."""
    from importlib.metadata import PackageNotFoundError, version as installed

    try:
        return installed("symdyn")
    except PackageNotFoundError:
        return "(not installed)"

"""Where the files lie that are not Python."""

from __future__ import annotations

from pathlib import Path


def template_folder() -> Path:
    """Return the folder of the Jinja templates: inside an installed package, else beside it in a checkout."""
    installed = Path(__file__).parent / "templates"
    return installed if installed.is_dir() else Path(__file__).parent.parent / "templates"

"""Kernels of Jupyter that execute a notebook: reached by files and not by ports, which another may take meanwhile."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from patience import HANG


def executed(book: Any, **settings: Any) -> Any:
    """Return a notebook, whose cells have been executed; skipped where there is no nbclient."""
    client = pytest.importorskip("nbclient", reason="nbclient is not installed (extra dev)")
    config = pytest.importorskip("traitlets.config").Config()
    with TemporaryDirectory() as folder:
        config.KernelManager.transport, config.KernelManager.ip = "ipc", str(Path(folder) / "kernel")
        waits = {"timeout": HANG, "startup_timeout": HANG}
        client.NotebookClient(book, config=config, **waits, **settings).execute()
    return book

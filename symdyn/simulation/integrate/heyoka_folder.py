"""heyoka's own cache of machine code, put where only the user may write.

heyoka runs what it finds there, whoever wrote it: a folder of its own below the home, or $HEYOKA_CACHE_DIR.
"""

from __future__ import annotations

import os
from contextlib import suppress
from typing import Any

from symdyn import shell
from symdyn.build import trusted_folder
from symdyn.errors import MissingCompiler


def settle(heyoka: Any) -> None:
    """Let heyoka keep its code in our cache, in a process that is the shell's own; elsewhere its settings are others'.

    A folder that the user named in $HEYOKA_CACHE_DIR stays. Where there is none to trust, nothing is kept.
    """
    states = heyoka.llvm_state
    if shell.is_own() and not os.environ.get("HEYOKA_CACHE_DIR") and hasattr(states, "set_diskcache_path"):
        heyoka.set_logger_level_error()  # it warns where it can keep nothing, such as on a full disk
        with suppress(OSError, MissingCompiler):
            folder = trusted_folder() / "heyoka"
            folder.mkdir(mode=0o700, exist_ok=True)
            states.set_diskcache_path(str(folder))
            return
        states.set_diskcache_enabled(False)

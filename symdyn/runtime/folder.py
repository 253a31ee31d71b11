"""Folders that compiled code may stand in: the user's cache, if only the user may write there, else one of our own.

A build works in a folder aside. It holds a lock there, which the system lets go when the process ends in whatever way:
the next build takes away what killed ones left.
"""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path

from symdyn.errors import MissingCompiler
from symdyn.runtime.entry import distrust
from symdyn.runtime.warned import warn_once

try:
    import fcntl
except ImportError:  # no locks of this kind on this system
    fcntl = None  # type: ignore[assignment]

CACHE_VARIABLE = "SYMDYN_CACHE_DIR"

ASIDE = ".symdyn-build-"

DAY = 86400.0
"""Seconds after which a folder aside is nobody's, where there are no locks."""


def cache_folder() -> Path:
    """Return where libraries are kept: $SYMDYN_CACHE_DIR, else the user's cache folder."""
    chosen = os.environ.get(CACHE_VARIABLE)
    if chosen:
        return Path(chosen)
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("symdyn", appauthor=False))


def trusted_folder() -> Path:
    """Return the cache folder, made if it is missing; in its place, with a word, a private one where others may write.

    Raises:
        MissingCompiler: there is no folder to write to at all.
    """
    folder = cache_folder()
    try:
        if not folder.is_absolute() and CACHE_VARIABLE not in os.environ:
            raise OSError(0, "the user has no home")
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        reason = distrust(folder.stat())
    except OSError as fault:
        return instead(folder, fault.strerror or str(fault))
    return instead(folder, reason) if reason else folder


def instead(folder: Path, reason: str) -> Path:
    """Return a private folder in place of `folder`, and say why.

    Raises:
        MissingCompiler: there is no such folder either.
    """
    mend = f"`chmod go-w {folder}` makes it yours alone" if "others may" in reason else f"check {folder}"
    warn_once(
        f"{folder}: no compiled code is kept there ({reason}), so this process compiles for itself; "
        f"{mend}, or set {CACHE_VARIABLE} to a folder that only you may write to"
    )
    return private_folder(os.getpid())


@cache
def private_folder(process: int) -> Path:
    """Return a folder that nobody else can open and that ends with this process, whose number is given.

    Raises:
        MissingCompiler: there is no folder for temporary files.
    """
    kept = ExitStack()
    try:
        folder = kept.enter_context(folder_aside(Path(tempfile.gettempdir())))
    except OSError as fault:
        raise MissingCompiler(f"no folder to compile in ({fault.strerror}); set TMPDIR to one") from fault

    def end() -> None:
        if os.getpid() == process:  # and not a child that was forked
            kept.close()

    atexit.register(end)
    return folder


@contextmanager
def folder_aside(place: Path) -> Iterator[Path]:
    """Yield a new folder in `place` that nobody else may open and that is gone afterwards, as are those of the dead."""
    _sweep(place)
    folder, lock = _locked_folder(place)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def _locked_folder(place: Path) -> tuple[Path, int | None]:
    """Return a new folder and the lock on it; another process may sweep it away before it is locked."""
    while True:
        folder = Path(tempfile.mkdtemp(prefix=ASIDE, dir=place))
        try:
            lock = _lock(folder, wait=True)
        except FileNotFoundError:
            continue
        if folder.is_dir():
            return folder, lock
        assert lock is not None, "nobody takes a folder away without a lock before a day has passed"
        os.close(lock)


def _lock(folder: Path, wait: bool) -> int | None:
    """Return a descriptor that holds the lock on a folder, None without locks; BlockingIOError if another has it."""
    if fcntl is None:
        return None
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        os.close(descriptor)
        raise
    except OSError:  # a file system without locks
        os.close(descriptor)
        return None
    return descriptor


def _sweep(place: Path) -> None:
    """Take away folders in `place` whose builds were killed."""
    for folder in place.glob(f"{ASIDE}*"):
        with suppress(OSError):
            state = folder.lstat()
            if hasattr(os, "geteuid") and state.st_uid != os.geteuid():
                continue
            lock = _lock(folder, wait=False)
            if lock is not None or time.time() - state.st_mtime > DAY:
                shutil.rmtree(folder, ignore_errors=True)
            if lock is not None:
                os.close(lock)

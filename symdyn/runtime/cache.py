"""What is kept in the cache between processes: sealed by its maker, checked on the very bytes that are loaded.

A sealed file ends with a word and a hash of its name and of all before; linkers read from the front and do not mind. It
is opened once: owner and mode are those of the open descriptor, and what was read, hashed and found whole goes into
memory of our own, which is loaded in place of the file. So nothing that happens to the file, before or after, runs: a
file cut short ends no process with SIGBUS, one that was changed is no library any more, nor is one under another name.

The hash tells damage; who could write a library could write its hash as well. Against others stand owner and mode, here
and of the folder (`symdyn.runtime.cache`).

Compiled code stands in the user's cache, if only the user may write there, else in a folder of our own. A build works
in a folder aside. It holds a lock there, which the system lets go when the process ends in whatever way: the next build
takes away what killed ones left. A child that is forked while another thread holds a lock finds it open, for that
thread is not in the child.

Other bytes are sealed as libraries are, in the same folder: whose they are, who may change them and their hash are
looked at before anything is made of them.
"""

from __future__ import annotations

import atexit
import hashlib
import itertools
import os
import shutil
import stat
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any
from weakref import WeakSet

from symdyn.emit import Sources
from symdyn.errors import BuildError, MissingCompiler, SymdynWarning
from symdyn.frozen import dataclass


class Lock:
    """A lock that the thread that holds it may take again."""

    def __init__(self) -> None:
        self.free()
        _ALL.add(self)

    def free(self) -> None:
        """Let nobody hold it."""
        self._lock = threading.RLock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *fault: object) -> None:
        self._lock.release()


_ALL: WeakSet[Lock] = WeakSet()


def _free_all() -> None:
    for one in _ALL:
        one.free()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_free_all)


SEAL = b"\nsymdyn, whole: "
"""Between a library and its hash."""

LENGTH = len(SEAL) + hashlib.sha256().digest_size

OTHERS = stat.S_IWGRP | stat.S_IWOTH

DESCRIPTORS = Path("/proc/self/fd")


class Damaged(Exception):  # noqa: N818  a state, told and mended
    """A file in the cache that is not what was compiled; says why."""


def seal(path: Path) -> None:
    """Make a whole entry of a fresh library that only its owner may change; its name stays part of it."""
    with open(path, "r+b") as file:
        digest = _digest(path.name, file.read())
        file.write(SEAL + digest)
    path.chmod(stat.S_IMODE(path.stat().st_mode) & ~OTHERS)


def load_entry(path: Path, load: Callable[[str], Any]) -> Any:
    """Return what `load` makes of the file of a sealed library; what this process has loaded is not loaded again.

    Raises:
        FileNotFoundError: there is none.
        Damaged: it is not whole, or others may change it.
        OSError, ImportError: it is whole, yet `load` cannot use it.
    """
    content, before = _read(path)
    digest = content[-hashlib.sha256().digest_size :]
    with _LOCK:
        if digest not in _LOADED:
            _LOADED[digest] = _load(content[:-LENGTH], path, before, load)
        return _LOADED[digest]


_LOCK = Lock()

_LOADED: dict[bytes, Any] = {}
"""By hash; a loaded library stays for as long as the process."""

_NUMBER = itertools.count()


def _read(path: Path) -> tuple[bytes, os.stat_result]:
    """Return the content of an entry, checked, and the state of its file."""
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        descriptor = os.open(path, flags)  # not blocking, for a pipe would wait for its writer
    except FileNotFoundError:
        raise
    except OSError as fault:
        reason = "it is a link" if path.is_symlink() else f"it cannot be read ({fault.strerror})"
        raise Damaged(reason) from fault
    state = os.fstat(descriptor)
    reason = "" if stat.S_ISREG(state.st_mode) else "it is no file"
    reason = reason or distrust(state)
    if reason:
        os.close(descriptor)
        raise Damaged(reason)
    with open(descriptor, "rb") as file:
        file.seek(max(0, state.st_size - LENGTH))
        if file.read(len(SEAL)) != SEAL:  # so a huge file that is none of ours is not read
            raise Damaged("its end is missing")
        file.seek(0)
        content = file.read()
    if _digest(path.name, content[:-LENGTH]) != content[-hashlib.sha256().digest_size :]:
        raise Damaged("its bytes are not those that were compiled")
    return content, state


def distrust(state: os.stat_result) -> str:
    """Return why a file or folder is not to be trusted, empty where it is: another owner, or others may write to it."""
    if not hasattr(os, "geteuid"):  # no such owners and modes on this system
        return ""
    if state.st_uid not in (os.geteuid(), 0):
        return f"it belongs to another user ({state.st_uid})"
    return "others may write to it" if state.st_mode & OTHERS else ""


def _digest(name: str, content: bytes) -> bytes:
    return hashlib.sha256(name.encode() + b"\n" + content).digest()


def _load(content: bytes, path: Path, before: os.stat_result, load: Callable[[str], Any]) -> Any:
    """Load the checked bytes, from memory where the system can, else the file, if it is still the one that was read."""
    if hasattr(os, "memfd_create") and DESCRIPTORS.is_dir():
        with suppress(OSError, ImportError), open(os.memfd_create(path.stem[:100]), "wb") as file:
            file.write(content)
            file.flush()
            return load(_spelling(file.fileno()))
        # memory may not be run here; the file may
    after = os.stat(path)
    if (before.st_ino, before.st_size, before.st_mtime_ns) != (after.st_ino, after.st_size, after.st_mtime_ns):
        raise Damaged("it changed while it was read")
    return load(str(path))


def _spelling(descriptor: int) -> str:
    """Return a path of an open descriptor that was never given before.

    Linkers know libraries by their paths, and descriptors are used again: `/proc/self/fd/7` would be the library that
    was loaded from another 7. So a number, in the two spellings of "here" (`//` and `/./`), stands in between.
    """
    bits = f"{next(_NUMBER):b}".replace("0", "/").replace("1", "./")
    return f"{DESCRIPTORS}/{bits}{descriptor}"


def check_target(sources: Sources, *targets: str) -> None:
    """Raise BuildError for sources of another target."""
    if sources.target not in targets:
        way_out = f"give emit(program, {targets[0]!r})"
        raise BuildError(f"sources of target {sources.target!r} are not of target {targets[0]!r}; {way_out}")


@cache
def warn_once(message: str) -> None:
    """Warn, once a process: of what stays as it is."""
    warn(message)


def warn(message: str) -> None:
    """Warn of what happened."""
    warnings.warn(message, SymdynWarning, stacklevel=2)


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


@dataclass(frozen=True)
class Kept:
    """What is kept in the cache under a name."""

    name: str

    def content(self) -> bytes | None:
        """Return what is kept, None where nothing is that can be trusted."""
        try:
            path = trusted_folder() / self.name
            found = _read(path)[0][:-LENGTH]
            with suppress(OSError):  # a cache that may only be read serves as well
                os.utime(path)  # it was wanted last
        except Damaged as fault:
            warn(f"{path}: {fault}; it is made again")
        except (OSError, MissingCompiler):
            return None
        else:
            return found
        return None

    def keep(self, content: bytes, most: int) -> None:
        """Keep bytes, where the cache can be written to.

        Of entries with its ending those `most` stay that were wanted last.
        """
        with suppress(OSError, MissingCompiler):
            folder = trusted_folder()
            with folder_aside(folder) as aside:
                fresh = aside / self.name
                fresh.write_bytes(content)
                seal(fresh)
                os.replace(fresh, folder / self.name)
            for one in sorted(folder.glob(f"*{Path(self.name).suffix}"), key=_wanted)[:-most]:
                with suppress(OSError):
                    one.unlink()

    def folder(self) -> Path:
        """Return a folder of this name in the cache, made if missing; OSError or MissingCompiler if it cannot be."""
        folder = trusted_folder() / self.name
        folder.mkdir(mode=0o700, exist_ok=True)
        return folder


def _wanted(path: Path) -> float:
    """Return when an entry was wanted last; one that another process takes away was wanted first."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0

"""One compiled library in the cache: sealed by its maker, checked on the very bytes that are loaded.

A sealed file ends with a word and a hash of its name and of all before; linkers read from the front and do not mind. It
is opened once: owner and mode are those of the open descriptor, and what was read, hashed and found whole goes into
memory of our own, which is loaded in place of the file. So nothing that happens to the file, before or after, runs: a
file cut short ends no process with SIGBUS, one that was changed is no library any more, nor is one under another name.

The hash tells damage; who could write a library could write its hash as well. Against others stand owner and mode, here
and of the folder (`symdyn.runtime.folder`).
"""

from __future__ import annotations

import hashlib
import itertools
import os
import stat
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from symdyn.runtime.lock import Lock

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
    """Return what `load` makes of a sealed library; bytes that this process has loaded are not loaded again.

    Args:
        path: the entry.
        load: takes the path of a file with the checked bytes.

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


def read_entry(path: Path) -> bytes:
    """Return the bytes that were sealed; errors as of `load_entry`."""
    return _read(path)[0][:-LENGTH]


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

"""One case in this process, under limits, and what is wrong with how it went.

Everything that it says, through Python or beside it, goes into a file, and it runs in a folder of its own that is
searched afterwards.
"""

from __future__ import annotations

import gc
import io
import os
import pkgutil
import re
import resource
import shutil
import signal
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from types import FrameType
from typing import Any

import symdyn
import symdyn.cli
from symdyn.extras import EXTRAS

from . import asked
from .cases import ROOT, Case

SECONDS = 10.0
"""Of the processor, for a case."""

GRACE = 10
"""Seconds more until the system ends what does not hear the alarm."""

MEMORY = 2 << 30
"""Bytes beyond what a worker has before its first case."""

SMALL = 4 << 20
"""Bytes of an output that is searched whole."""

CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""What moves a terminal's cursor, or turns text round; a line break and a tab are fine."""

STATUSES = (0, 1, 2, 130)

PACKAGE = str(Path(symdyn.__file__).parent)


class Overtime(BaseException):
    """The alarm of the processor's clock."""


@dataclass(frozen=True)
class Verdict:
    """How a case went.

    Attributes:
        verb: the first word of its command line.
        sign: what is wrong, with its place, the same for the same fault; empty if nothing is.
        words: of the fault, such as a traceback.
        status: of exit.
        seconds: of the processor.
        read: whether a scene was read.
    """

    verb: str
    sign: str
    words: str
    status: int
    seconds: float
    read: bool


def judge(case: Case, folder: Path) -> Verdict:
    """Run a case in a new folder inside `folder` and return how it went."""
    work = folder / "case"
    work.mkdir()
    _READ.clear()
    start = time.process_time()
    with _captured(case.files.get("-", b"")) as said:
        sign, words, status = _run(case, work)
    seconds = time.process_time() - start
    sign, words = (sign, words) if sign else searched(case, status, said, work)
    strays = sorted({path.name for path in folder.iterdir()} - {"case", "cache"})
    if not sign and strays and not any(".." in Path(word).parts for word in case.argv):  # who asks for it has it
        sign, words = "a file outside its folder", str(strays)
    os.chdir(folder)
    shutil.rmtree(work, ignore_errors=True)
    for stray in (folder / name for name in strays):
        if stray.is_dir() and not stray.is_symlink():
            shutil.rmtree(stray, ignore_errors=True)
        else:
            stray.unlink()
    return Verdict(case.argv[0], sign, words, status, seconds, bool(_READ))


def _run(case: Case, work: Path) -> tuple[str, str, int]:
    """Return what is wrong, in words too, and the status of exit."""
    os.chdir(work)
    for name, content in case.files.items():
        if name != "-":
            (work / name).write_bytes(content)
    try:
        with _limits():
            status = asked.run(case.argv) if case.argv[0] == asked.NAME else symdyn.cli.main(list(case.argv))
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
    except Overtime as fault:
        return f"over {SECONDS:g} s: {_place(fault, first=True)}", _shown(fault), -1
    except MemoryError as fault:
        return f"over {MEMORY >> 30} GB: {_place(fault, first=True)}", _shown(fault), -1
    except BaseException as fault:
        return f"{type(fault).__name__}: {_place(fault)}", _shown(fault), -1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return "", "", status


def _place(fault: BaseException, first: bool = False) -> str:
    """Return the innermost function of ours in a traceback that knows mechanics, or the outermost below the verbs."""
    frames = [frame for frame in traceback.extract_tb(fault.__traceback__) if frame.filename.startswith(PACKAGE)]
    named = [f"{frame.filename[len(PACKAGE) + 1 :]}:{frame.name}" for frame in frames]
    if not named:
        return "?"
    below = [name for name in named if not name.startswith("cli/")]
    inner = [name for name in named if not name.startswith(("graph/", "algebra/", "spatial/"))]
    return (below or named)[0] if first else (inner or named)[-1]


def _shown(fault: BaseException) -> str:
    text = "".join(traceback.format_exception(fault))
    return text if len(text) < 6000 else text[:1500] + "\n  ...\n" + text[-3500:]


def searched(case: Case, status: int, said: Sequence[bytes], work: Path) -> tuple[str, str]:
    """Return what is wrong with what was said and written."""
    out, talk = (part.decode(errors="replace") for part in said)
    verb = ascii(case.argv[0][:20])
    if status not in STATUSES:
        return f"exit status {status}: {verb}", talk
    if "Traceback (most recent call last)" in talk:  # of a thread, or of an object at its end
        return f"traceback on stderr: {verb}", talk
    if status in (1, 2) and not talk.strip() and not out.strip():
        return f"fails without a word: {verb}", f"exit status {status}"
    written = [path for path in work.rglob("*") if path.is_file() and path.name not in case.files]
    texts = {"stdout": out, "stderr": talk}
    for path in written:
        if path.name.startswith("."):
            return f"a file left behind: {verb}", path.name
        chunk = path.suffix != ".json" and any(folder.suffix == ".zarr" for folder in path.parents)
        if path.suffix not in (".npz", ".png", ".pdf", ".fmu") and not chunk and path.stat().st_size < SMALL:
            texts[path.suffix or "a file"] = path.read_text(encoding="utf-8", errors="replace")
    for where, text in texts.items():
        found = CONTROLS.search(text)
        if found is not None:
            around = text[max(0, found.start() - 60) : found.end() + 60]
            return f"control character in {where}: {verb}", ascii(around)
    if status == 0 and verb in ("'simulate'", "'inverse'") and re.search(r"(?m)^[-\d.e]+,.*\b(nan|inf)\b", out):
        return f"a number that is none, and success: {verb}", out[-400:]
    return "", ""


@contextmanager
def _captured(given: bytes) -> Iterator[list[bytes]]:
    """Send stdout and stderr, of Python and of C, into files, and fill the list with their bytes at the end."""
    said: list[bytes] = []
    before = sys.stdin, sys.stdout, sys.stderr
    kept = [os.dup(number) for number in (1, 2)]
    with TemporaryFile() as out, TemporaryFile() as talk:
        os.dup2(out.fileno(), 1)
        os.dup2(talk.fileno(), 2)
        sys.stdin = io.TextIOWrapper(io.BytesIO(given), "utf-8")
        sys.stdout = io.TextIOWrapper(out, "utf-8")
        sys.stderr = io.TextIOWrapper(talk, "utf-8", "backslashreplace")
        try:
            yield said
        finally:
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
                stream.buffer.seek(0)
                said.append(stream.buffer.read(SMALL))
                stream.detach()
            sys.stdin, sys.stdout, sys.stderr = before
            for number, descriptor in zip((1, 2), kept, strict=True):
                os.dup2(descriptor, number)
                os.close(descriptor)


@contextmanager
def _limits() -> Iterator[None]:
    """Raise `Overtime` after so many seconds of the processor; a little later the system ends the process."""

    def alarm(number: int, frame: FrameType | None) -> None:
        raise Overtime

    before = signal.signal(signal.SIGPROF, alarm)
    used, (soft, hard) = int(time.process_time()), resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (used + int(SECONDS) + GRACE, hard))
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        resource.setrlimit(resource.RLIMIT_CPU, (soft, hard))  # or what warms the fuzzer would end it in a long run


def limit_memory() -> None:
    """Allow this process `MEMORY` bytes more than it has."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


_READ: list[bool] = []
"""Filled when a scene is read."""


def prepare() -> None:
    """Import and warm what cases share, and see when scenes are read; once, before workers are forked."""
    import symdyn.scene

    reader = symdyn.scene.read_noting

    def read(*words: Any, **more: Any) -> Any:
        reading = reader(*words, **more)
        _READ.append(True)
        return reading

    symdyn.scene.read_noting = read
    words = symdyn.cli.parser()
    symdyn.cli.parser = lambda: words  # as it is the same every time, and takes longer than many a case
    wanting = {name for extra in EXTRAS.values() for name in extra.modules}
    for module in pkgutil.walk_packages(symdyn.__path__, "symdyn."):
        if not module.name.endswith("__main__"):
            try:
                import_module(module.name)
            except ModuleNotFoundError as missing:
                if missing.name not in wanting:
                    raise
    here = Path.cwd()
    with TemporaryDirectory() as folder:
        for argv in WARMING:
            verdict = judge(Case((*argv, str(PENDULUM)), {"work.tex": b"K = 0"}), Path(folder))
            assert verdict.status in (0, 1), verdict
    os.chdir(here)
    gc.freeze()


PENDULUM = ROOT / "examples" / "pendulum.toml"

WARMING = (  # what imports all that cases need, so that it is done once
    *(
        ("info",),
        ("equations",),
        ("equations", "--formulation", "dalembert"),
        ("draw",),
        ("walkthrough", "-o", "l.html"),
    ),
    *(
        ("generate",),
        ("generate", "--target", "c"),
        ("generate", "--target", "js"),
        ("verify",),
        ("walkthrough", "--exercises"),
    ),
    *(
        ("simulate", "--until", "0.1", "--plot", "p.svg"),
        ("inverse", "--until", "0.1", "--motion=q1=sin(t)", "--plot", "p.html"),
    ),
    *(
        ("check-derivation", "work.tex"),
        ("equations", "--format", "sympy"),
        ("simulate", "--until", "0.1", "--method", "radau"),
    ),
    *(("simulate", "--until", "0.1", "--animate", "p.html"), ("walkthrough", "-o", "l.ipynb")),
)

"""Cases as real processes of `python -m symdyn`: what a worker cannot see, such as start and end."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .cases import ROOT, Case
from .judge import GRACE, MEMORY, SECONDS, searched

START = 3.0
"""Seconds of the processor that Python and its modules may take before a case begins."""

LIMITS = {
    resource.RLIMIT_CPU: int(SECONDS + START) + GRACE,
    resource.RLIMIT_AS: 2 * MEMORY,  # what libraries reserve and never touch counts too
    resource.RLIMIT_CORE: 0,
}


def run(make: Callable[[int], Case], numbers: Sequence[int], jobs: int, keep: Path, path: str) -> int:
    """Run the cases, print what is wrong with each and keep it; return whether anything is.

    Args:
        make: gives the case of a number.
        numbers: which cases.
        jobs: how many at a time.
        keep: where cases go that are found.
        path: of programs, compilers among them.
    """
    statuses: Counter[int] = Counter()
    longest, found = 0.0, 0
    with tempfile.TemporaryDirectory() as cache, ThreadPoolExecutor(jobs) as pool:
        for number, (sign, words, status, seconds) in zip(
            numbers, pool.map(lambda number: _run(make(number), cache, path), numbers), strict=True
        ):
            statuses[status] += 1
            longest = max(longest, seconds)
            if sign:
                found += 1
                keep.mkdir(parents=True, exist_ok=True)
                file = keep / f"process_{number}.json"
                file.write_text(make(number).text() + "\n", encoding="utf-8")
                print(f"case {number}: {sign}: {file}\n    {words[-1500:]}", flush=True)
    told = ", ".join(f"{count} with {status}" for status, count in statuses.most_common())
    print(f"{len(numbers)} processes ended: {told}; the longest took {longest:.1f} s of the processor; {found} faults")
    return int(found > 0)


def _run(case: Case, cache: str, path: str) -> tuple[str, str, int, float]:
    """Return what is wrong, in words too, the status of exit, and seconds of the processor."""

    with tempfile.TemporaryDirectory() as place:
        folder = Path(place, "case")
        folder.mkdir()
        for name, content in case.files.items():
            (folder / name).write_bytes(content)
        with open(folder / "-", "ab+") as given, tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as talk:
            given.seek(0)
            process = subprocess.Popen(
                [sys.executable, "-m", "symdyn", *case.argv],
                cwd=folder,
                env=os.environ | {"SYMDYN_CACHE_DIR": cache, "PYTHONPATH": str(ROOT), "PATH": path},
                stdin=given,
                stdout=out,
                stderr=talk,
            )
            for what, most in LIMITS.items():
                resource.prlimit(process.pid, what, (most, most))
            _, state, used = os.wait4(process.pid, 0)
            process.returncode = status = os.waitstatus_to_exitcode(state)
            said = []
            for file in (out, talk):
                file.seek(0)
                said.append(file.read())
        seconds = used.ru_utime + used.ru_stime
        (folder / "-").unlink()
        sign, words = searched(case, status, said, folder)
        if not sign and seconds > SECONDS + START:
            sign = f"over {SECONDS:g} s"
        if not sign and used.ru_maxrss * 1024 > MEMORY:
            sign = f"over {MEMORY >> 30} GB"
        if not sign and os.listdir(place) != ["case"]:
            sign, words = "a file outside its folder", str(os.listdir(place))
        return sign, words, status, seconds

"""Kill verbs at random moments, and look at what they leave: `python tests/kills.py [VERB ..] --times 100`.

No half file may stand under a final name, the cache must work as before, and nothing may be left behind that grows. A
process is killed by SIGKILL, SIGTERM and SIGINT in turn, at moments spread over the time that it takes undisturbed.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

EXAMPLES = ROOT / "examples"

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)

INTERRUPTED = 130
"""Status of a verb that was told to stop and did; `simulate` keeps the rows that it has then."""

LOAD = """
import sys, numpy, symdyn
call = symdyn.load(sys.argv[1], "inverse_dynamics").inverse_dynamics
print(call(*numpy.ones((3, 20, 2)), numpy.ones(5)).tobytes().hex())
"""

BOUND = "m1=1,m2=1,h1=1,h2=1,g=9.81"

VERBS: dict[str, Sequence[str]] = {
    "generate": ("-m", "symdyn", "generate", str(EXAMPLES / "two_link.toml"), "--target", "c", "-o", "out"),
    "walkthrough": ("-m", "symdyn", "walkthrough", str(EXAMPLES / "pendulum.toml"), "-o", "out/lesson.html"),
    "simulate": (
        *("-m", "symdyn", "simulate", str(EXAMPLES / "pendulum.toml"), "--until", "1", "--method", "dop853"),
        *("-o", "out/run.csv", "--plot", "out/run.svg"),
    ),
    "identify": (
        *("-m", "symdyn", "identify", str(EXAMPLES / "two_link.toml"), "given.csv", "--bind", BOUND),
        *("-o", "out/fit.html", "-o", "out/fit.toml", "-o", "out/fit.csv", "--force"),
    ),
    "sweep": (
        *("-m", "symdyn", "sweep", str(EXAMPLES / "pendulum.toml"), "--bind", "g=9.81", "--start", "q1=1"),
        *("--over", "m=linspace(1,2,2000)", "--until", "2", "--measure", "max(abs(q1_dot))", "-o", "out/study.csv"),
        *("--plot", "out/study.svg"),
    ),
    "load": ("-c", LOAD, str(EXAMPLES / "two_link.toml")),
}

GIVEN: dict[str, Sequence[str]] = {
    "identify": (
        *("-m", "symdyn", "simulate", str(EXAMPLES / "two_link.toml"), "--bind", BOUND),
        *("--forces", "M1=3*sin(2*t)", "M2=cos(5*t)", "--until", "4", "--every", "0.005", "-o", "given.csv"),
    ),
}
"""What writes the files that a verb reads, in the folder where it runs."""


@dataclass(frozen=True)
class Outcome:
    """What a row of kills left.

    Attributes:
        statuses: how the processes ended.
        halves: files under a final name that are not what an undisturbed run writes, nor the rows that an interrupted
            one keeps.
        behind: hidden files and folders that were there when all was over, and what stood in the temporary folder.
        tracebacks: of processes that were told to stop, and told of their own insides.
        talk: of an undisturbed run afterwards; the cache is whole if it does not speak of it.
    """

    statuses: Counter[int]
    halves: tuple[str, ...]
    behind: tuple[str, ...]
    tracebacks: tuple[str, ...]
    talk: str


def _emptied(folder: Path) -> None:
    """Make a folder anew; a compiler whose parent was killed may write into the old one for a while."""
    for patience in (0.1, 1.0, 10.0, None):
        try:
            shutil.rmtree(folder)
            break
        except OSError:
            if patience is None:
                raise
            time.sleep(patience)
    folder.mkdir(mode=0o700)


def kills(verb: str, times: int, seed: int = 1) -> Outcome:
    """Run a verb so many times, killing each run, then once to its end."""
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for part in ("work/out", "cache", "tmp"):
            (folder / part).mkdir(parents=True, mode=0o700)
        if verb in GIVEN:
            assert _started(GIVEN[verb], folder).wait() == 0
        start = time.monotonic()
        assert _started(VERBS[verb], folder).wait() == 0, "an undisturbed run succeeds"
        span = time.monotonic() - start
        whole = dict(_files(folder / "work"))
        statuses: Counter[int] = Counter()
        halves, tracebacks = [], []
        for k in range(times):
            if k % 2:  # so that runs with and without a compiler are met
                _emptied(folder / "cache")
            _emptied(folder / "work" / "out")
            running = _started(VERBS[verb], folder)
            time.sleep(rng.uniform(0.0, 1.1 * span))
            how = SIGNALS[k % len(SIGNALS)]
            running.send_signal(how)
            _, talk = running.communicate()
            statuses[running.returncode] += 1
            if b"Traceback" in talk and b", in main\n" in talk:  # before, Python's own start tells of itself
                tracebacks.append(f"{how.name}: {talk.decode().strip().splitlines()[-1]}")
            kept = running.returncode == INTERRUPTED
            for name, data in _files(folder / "work"):
                if data != whole.get(name) and not (kept and _is_closed(data)):
                    halves.append(f"{name} after {how.name}")
        last = _started(VERBS[verb], folder)
        _, talk = last.communicate()
        assert last.returncode == 0, talk.decode()
        behind = [path for part in ("work", "cache") for path in (folder / part).rglob(".*")]
        behind += list((folder / "tmp").iterdir())
        assert dict(_files(folder / "work")) == whole
        left = tuple(str(path.relative_to(folder)) for path in behind)
        return Outcome(statuses, tuple(halves), left, tuple(tracebacks), talk.decode())


def _started(command: Sequence[str], folder: Path) -> subprocess.Popen[bytes]:
    places = {"SYMDYN_CACHE_DIR": str(folder / "cache"), "TMPDIR": str(folder / "tmp"), "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        [sys.executable, *command],
        cwd=folder / "work",
        env=os.environ | places,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def _is_closed(data: bytes) -> bool:
    """Tell whether what an interrupted run keeps is a table of whole rows, or a picture with its end."""
    cells = {line.count(b",") for line in data.splitlines() if not line.startswith(b"#")}
    return data.endswith((b"</svg>", b"</svg>\n")) or (data.endswith(b"\n") and len(cells) == 1)


def _files(folder: Path) -> Iterator[tuple[str, bytes]]:
    """Yield name and content of every file that is not hidden."""
    for path in sorted(folder.rglob("[!.]*")):
        if path.is_file():
            yield path.name, path.read_bytes()


def main() -> int:
    """Kill, and print what was left."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it, and so would children
    ask = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ask.add_argument("verbs", nargs="*", default=list(VERBS))
    ask.add_argument("--times", type=int, default=100)
    ask.add_argument("--seed", type=int, default=1)
    given = ask.parse_args()
    wrong = 0
    for verb in given.verbs:
        found = kills(verb, given.times, given.seed)
        ended = ", ".join(f"{count} with {status}" for status, count in found.statuses.most_common())
        bad = len(found.halves) + len(found.behind) + found.talk.count("again")
        wrong += bad
        print(f"{verb}: {given.times} kills, {ended}; {len(found.halves)} half files, {len(found.behind)} left behind,")
        print(f"    {len(found.tracebacks)} tracebacks; then: {found.talk.strip()[-200:] or 'no word'}", flush=True)
        for line in (*found.halves[:5], *found.behind[:5], *Counter(found.tracebacks)):
            print(f"    {line}")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())

"""Cases: a command line and its files, made of a seed and a number alone."""

from __future__ import annotations

import argparse
import base64
import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from random import Random

from symdyn.cli import parser
from symdyn.errors import SymdynError
from symdyn.scene import write_text
from symdyn.scene.toml import read_text

from . import asked, grammar
from .grammar import NASTY, chance
from .mutate import scribble, spoil, toml

ROOT = Path(__file__).resolve().parent.parent.parent

LARGEST = 20_000
"""Bytes of a file that is mutated."""

FEW = 3
"""Bodies of a scene that is computed with."""


@dataclass(frozen=True)
class Case:
    """A command line, and what lies in the folder it runs in.

    Attributes:
        argv: the words after `symdyn`; or what a page asks, see `asked`.
        files: content by name; "-" is standard input.
    """

    argv: tuple[str, ...]
    files: Mapping[str, bytes] = field(default_factory=dict)

    def text(self) -> str:
        """Return it as JSON; content that is no text is in base 64."""
        return json.dumps({"argv": self.argv, "files": {k: _shown(v) for k, v in self.files.items()}}, indent=1)


def read_case(text: str) -> Case:
    """Return the case that `Case.text` wrote."""
    raw = json.loads(text)
    files = {k: v.encode() if isinstance(v, str) else base64.b64decode(v["base64"]) for k, v in raw["files"].items()}
    return Case(tuple(raw["argv"]), files)


def _shown(content: bytes) -> str | dict[str, str]:
    try:
        return content.decode()
    except UnicodeDecodeError:
        return {"base64": base64.b64encode(content).decode()}


@dataclass(frozen=True)
class Verb:
    """How a verb is tried.

    Attributes:
        weight: how often, a part of the sum; dear verbs are rare.
        few: whether scenes are small, for it computes with them.
        more: words and files beside the scene, drawn.
        fixed: words that keep a case short.
    """

    weight: float
    few: bool = True
    more: Callable[[Random], tuple[list[str], dict[str, bytes]]] = lambda _: ([], {})
    fixed: tuple[str, ...] = ()


def _check(rng: Random) -> tuple[list[str], dict[str, bytes]]:
    text = grammar.homework(rng) if chance(rng, 0.6) else rng.choice(seeds()["homework"]).decode()
    spoilt = scribble(rng, text.encode(), rng.choice((0, 1, 1, 2, 5)))
    return (["-"], {"-": spoilt}) if chance(rng, 0.1) else (["work.tex"], {"work.tex": spoilt})


def _convert(rng: Random) -> tuple[list[str], dict[str, bytes]]:
    return [
        rng.choice(("out.toml", "out.toml", "out.urdf", "out.sdf", "out.par", "out.xyz", "out/a.toml")),
        "--lossy",
    ], {}


def _sweep(rng: Random) -> tuple[list[str], dict[str, bytes]]:
    words: list[str] = []
    for _ in range(rng.choice((0, 1, 1, 2))):
        values = rng.choice(
            ("[0.1, 1]", "linspace(1,2,2)", "normal(1, sigma=0.1)", "tolerance(5 %)", "tolerance()", "uniform(2,1)",
             f"linspace({grammar.formula(rng, ('m1',))},2,2)", str(rng.choice(NASTY)))
        )  # fmt: skip
        words += ["--over", f"{rng.choice(('q1', 'q1_dot', 'm1', 'x', 'k', ''))}={values}"]
    drawn = not words or any(sign in " ".join(words) for sign in ("normal", "uniform", "tol"))  # else tolerances may
    words += ["--count", "3"] if drawn else []
    inside = rng.choice(("q1", "q1_dot", "kinetic_energy", grammar.formula(rng, ("t", "q1"))))
    words += ["--measure", rng.choice((f"max({inside})", f"end({inside}) - min(t)", inside, str(rng.choice(NASTY))))]
    words += ["-o", rng.choice(("a.csv", "a.zarr", "a.xyz"))] if chance(rng, 0.5) else []
    return words, {}


def _identify(rng: Random) -> tuple[list[str], dict[str, bytes]]:
    """Return a log, whole or spoilt, or what is asked of an exciting motion."""
    if chance(rng, 0.15):
        limits = rng.choice(("q1=-1..1", "q1_dot=..2", "tau1=-5..5", "q1=1..-1", "q1=..", str(rng.choice(NASTY))))
        return ["--excite", "--starts", "1", "--terms", "1", "--period", "1", "--every", "0.1", "--box", limits], {}
    names = tuple(rng.sample(("q1", "q2", "x", "theta", "q1_dot", "tau1", "tau2", "F", "M1"), rng.choice((2, 4, 9))))
    rows = rng.choice((3, 19, 20, 40, 80))
    step = rng.choice((0.01, 0.1, 1, 10))
    lines = [",".join(("t", *names))]
    for k in range(rows):
        lines.append(",".join(str(round(x, 6)) for x in (step * k, *(rng.uniform(-1, 1) for _ in names))))
    content = scribble(rng, ("\n".join(lines) + "\n").encode(), rng.choice((0, 0, 1, 3)))
    words = ["log.csv", "--friction", rng.choice(("all", "viscous", "coulomb,offset", ",", str(rng.choice(NASTY))))]
    words += ["--units", rng.choice(("t=ms", "q*=deg", "q1=", "*=deg", str(rng.choice(NASTY))))] * chance(rng, 0.2)
    words += ["--band", rng.choice(("1", "0.01", "1e9", "-1", "nan"))] * chance(rng, 0.3)
    words += ["-o", rng.choice(("a.csv", "a.html", "a.toml", "a.urdf", "a.xyz"))] * chance(rng, 0.4)
    words += ["--by", "output-error"] * chance(rng, 0.1)
    return words, {"log.csv": content}


def _over_time(option: str) -> Callable[[Random], tuple[list[str], dict[str, bytes]]]:
    """Return what draws laws over time: formulas, a TOML file or a table."""

    def draw(rng: Random) -> tuple[list[str], dict[str, bytes]]:
        names = tuple(rng.sample(("q1", "tau1", "q2", "tau2", "x"), rng.choice((1, 2))))
        kind = rng.randrange(4)
        if kind == 0:
            return [option, "laws.csv"], {
                "laws.csv": scribble(rng, grammar.table(rng, names).encode(), rng.choice((0, 0, 1, 3)))
            }
        if kind == 1:
            text = grammar.lines(rng, names, ("t", "q1", "m1"))
            return [option, "laws.toml"], {"laws.toml": scribble(rng, text.encode(), rng.choice((0, 0, 1, 3)))}
        if kind == 2 and option == "--forces":
            return [], {}
        laws = (grammar.formula(rng, ("t",)), "quintic(0, 1, 2)", "spline(0,0,1,1)", str(rng.choice(NASTY)))
        return [option, *(f"{name}={rng.choice(laws)}" for name in names)], {}

    return draw


VERBS: Mapping[str, Verb] = {
    "convert": Verb(64, few=False, more=_convert, fixed=("--force",)),
    "check-derivation": Verb(4, more=_check),
    "draw": Verb(6),
    "equations": Verb(2),
    "new": Verb(1),
    "info": Verb(0.4),
    "generate": Verb(0.6),
    "walkthrough": Verb(0.4),
    "simulate": Verb(1.2, more=_over_time("--forces"), fixed=("--until", "0.02")),
    "inverse": Verb(1, more=_over_time("--motion"), fixed=("--until", "0.2", "--every", "0.1")),
    "sweep": Verb(0.6, more=_sweep, fixed=("--until", "0.02")),
    "identify": Verb(0.3, more=_identify),
    "verify": Verb(0.1, fixed=("--functions", "gravity_forces")),
    asked.NAME: Verb(3, more=asked.drawn),
}
"""`bench` and `stress` run for minutes by their nature: their command lines are tried by `_line` alone."""

LINES = 18.0
"""Weight of command lines that are wrong or for small scenes, of all verbs."""

DEAR = (asked.NAME, "simulate", "inverse", "sweep", "identify", "info", "generate", "walkthrough", "verify")
"""Verbs that are tried on scenes that are read more often than not."""


def case(seed: str, number: int) -> Case:
    """Return case `number` of a seed."""
    rng = Random(f"{seed}:{number}")
    name = rng.choices((*VERBS, ""), (*(verb.weight for verb in VERBS.values()), LINES))[0]
    if not name:
        return _line(rng)
    verb = VERBS[name]
    if name == "new":
        return Case(("new", str(rng.choice(("arm", *NASTY)))[:300], *_options(rng, "new", 0.5)))
    file, content = _scene(rng, verb.few, 0.35 if name in DEAR else 0.65)
    words, files = verb.more(rng)
    if name == asked.NAME:
        return Case((name, file, *words), {file: content, **files})
    scene = [file]
    front = [*words, *scene] if name == "check-derivation" else [*scene, *words]
    fixed = verb.fixed if chance(rng, 0.95) or name in ("simulate", "inverse", "sweep") else ()
    return Case((name, *front, *fixed, *_options(rng, name, 0.02 if name in DEAR else 0.06)), {file: content, **files})


def _line(rng: Random) -> Case:
    """Return a command line of any verb, right or wrong, for no scene or a pendulum."""
    name = rng.choice((*sorted({*verbs()} - {*ENDLESS}), str(rng.choice(NASTY))))
    words = _options(rng, name, 0.15)
    first = int(name in ("bench", "stress"))
    if first:  # no file to work on, or they would; nothing in front, which might swallow its name
        words = ["missing.toml", *words]
    elif chance(rng, 0.8):
        words.insert(0, "scene.toml" if chance(rng, 0.9) else str(rng.choice(NASTY)))
    if chance(rng, 0.3):
        words.insert(max(first, rng.randrange(len(words) + 1)), str(rng.choice(NASTY))[:200])
    limit = (
        ["--until", str(rng.choice((0, 0.01, -1, "nan", "1e-300")))] if name in ("simulate", "inverse", "sweep") else []
    )
    argv = [word.replace("\x00", "\udcff") for word in (name, *words, *limit)]  # as the system hands over bytes
    return Case(tuple(argv), {"scene.toml": seeds()["small"][0]})


@cache
def verbs() -> dict[str, argparse.ArgumentParser]:
    """Return the parsers of the verbs."""
    (found,) = (one for one in parser()._actions if isinstance(one, argparse._SubParsersAction))
    return {name: verb.made for name, verb in found.choices.items()}


def _options(rng: Random, verb: str, share: float) -> list[str]:
    """Return some of a verb's options, each with something like its value."""
    if verb not in verbs():
        return [f"--{rng.choice(NASTY)}"] if chance(rng, share) else []
    words: list[str] = []
    for action in verbs()[verb]._actions:
        if not action.option_strings or action.dest in ENDLESS or not chance(rng, share):
            continue
        words.append(rng.choice(action.option_strings))
        if action.nargs != 0:
            words.append(_value(rng, action))
    return words


ENDLESS = ("watch", "play")
"""Options of commands, and a verb, that end with Ctrl-C alone."""


LENGTHS = ("0", "0.01", "1 ms", "-1", "nan", "inf", "1e-300", "later", "")
"""How long runs last; one of 1e30 s is refused by nobody, says when it will end, and ends with Ctrl-C."""


def _value(rng: Random, action: argparse.Action) -> str:
    """Return a value of an option, mostly one that it takes."""
    if action.dest == "until":
        return rng.choice(LENGTHS)
    if action.choices is not None and chance(rng, 0.9):
        return str(rng.choice(list(action.choices)))
    if chance(rng, 0.15):
        return str(rng.choice(NASTY))
    if action.type is not None:
        return rng.choice(("1", "0", "2", "-1", "0.5", "nan", "1e-6", "1e308", "7"))
    if "FILE" in str(action.metavar) or "DIR" in str(action.metavar):
        return rng.choice(
            ("out", "out.csv", "out.npz", "out.svg", "out.html", "out.ipynb", "out.tex", "out.md", "no/way.svg")
        )
    names = ("q1", "q2", "m1", "tau1", "j0", "tip", "arm0", "mass_matrix", "inverse_dynamics", "pose:tip", "k_z", "x")
    if chance(rng, 0.4):
        return ",".join(rng.sample(names, rng.choice((1, 1, 2, 3))))
    values = (grammar.formula(rng, ("m1", "1")), str(grammar.number(rng)), str(rng.choice(NASTY)))
    return ",".join(f"{rng.choice(names)}={rng.choice(values)}" for _ in range(rng.choice((1, 1, 2))))


def _scene(rng: Random, few: bool, spoilt: float) -> tuple[str, bytes]:
    """Return a file's name and content: a scene by grammar, or a real file; that share of them spoilt."""
    times = rng.choice((1, 1, 2, 4, 8)) if chance(rng, spoilt) else 0
    if chance(rng, 0.6):
        made = spoil(rng, grammar.scene(rng, FEW if few else 6, chance(rng, spoilt)), times)
        content = toml(made).encode(errors="surrogatepass")
        return "scene.toml", scribble(rng, content, 1) if times and chance(rng, 0.2) else content
    kind = rng.choice(
        ("small", "small", "urdf", "sdf", "xml", "par") if few else ("small", "toml", "urdf", "sdf", "xml", "par")
    )
    endings = {"urdf": ".urdf", "sdf": ".sdf", "xml": ".xml", "par": ".par"}
    content, other = rng.choice(seeds()[kind]), rng.choice(seeds()[kind])
    return f"scene{endings.get(kind, '.toml')}", scribble(rng, content, times, other)


@cache
def seeds() -> dict[str, list[bytes]]:
    """Return the files of this repository by kind; "small" are scenes of few bodies."""
    folders = [ROOT / part for part in ("examples", "tests/data", "tests/data/found")]
    found: dict[str, list[bytes]] = {kind: [] for kind in ("small", "toml", "urdf", "sdf", "xml", "par")}
    for path in sorted(path for folder in folders for path in folder.iterdir() if path.is_file()):
        kind = path.suffix[1:]
        content = path.read_bytes()
        if kind in found and len(content) < LARGEST:
            found[kind].append(content)
            if kind == "toml" and content.count(b"\n[bodies.") <= FEW and b"dh" not in content:
                found["small"].append(content)
    for kind in ("urdf", "sdf", "par"):
        found[kind] += _converted(kind)
    found["homework"] = [path.read_bytes() for path in sorted((ROOT / "docs").glob("check-derivation.md"))]
    found["small"].sort(key=len)
    return found


def _converted(kind: str, most: int = 12) -> list[bytes]:
    """Return scenes by grammar in another format, since few files of it lie here."""
    found: list[bytes] = []
    for number in range(10 * most):
        with suppress(SymdynError):  # such a scene is not right, or the format cannot hold it
            read = read_text(toml(grammar.scene(Random(number), FEW, open_ones=False)))
            found.append(write_text(read, kind, lossy=True).text.encode())
        if len(found) == most:
            break
    return found

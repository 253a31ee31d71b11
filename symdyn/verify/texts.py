"""The text of targets' files, read back and proved: what a certificate says beside graphs and numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from symdyn.algebra import Redraw
from symdyn.emit import TARGETS, Sources
from symdyn.emit.code import REALS
from symdyn.errors import MissingProgram
from symdyn.runtime import RUNNERS
from symdyn.verdict import Unclaimed
from symdyn.verify.building import Building
from symdyn.verify.written.proof import Files, Written, printed, prove_texts, unshown
from symdyn.verify.written.readers import READERS, languages

NOWHERE = "no point of a field was found at which all functions are defined"


@dataclass(frozen=True)
class Texts:
    """What is known of the files of targets.

    Attributes:
        written: a row a file.
        missing: targets whose files cannot be read on this machine, and what it lacks.
        unshown: what nothing could be compared of, and why.
    """

    written: tuple[Written, ...]
    missing: tuple[Unclaimed, ...] = ()
    unshown: tuple[Unclaimed, ...] = ()


def texts_of(building: Building, targets: Sequence[str], requested: bool, seed: int) -> Texts:
    """Return what is known of the files of `targets`.

    Args:
        building: what is written, with which number type.
        targets: keys of `TARGETS`; those that nothing reads are left out.
        requested: whether they were asked for by name: then files with each option are proved too.
        seed: of primes and points.
    """
    targets = [name for name in targets if name in READERS]
    if not targets:
        return Texts(())
    try:
        loops = {name: TARGETS[name].loops_in(REALS[building.real]) for name in targets}
        numbers = {one: printed(building.program, building.real, seed, one) for one in set(loops.values())}
    except Redraw:
        return Texts((), unshown=tuple(Unclaimed(_text_of(name), NOWHERE) for name in targets))
    found: list[Written] = []
    missing: list[Unclaimed] = []
    for name in targets:
        for option in building.options(name, requested):
            try:
                files = files_of(building.written(name, option))
                found += prove_texts(numbers[loops[name]], files, languages(name, option))
            except MissingProgram as fault:
                missing.append(Unclaimed(_text_of(name), str(fault)))
                break
    return Texts(tuple(found), tuple(missing))


def unread(targets: Sequence[str]) -> list[Unclaimed]:
    """Return the texts that nothing reads back: of these targets nothing is claimed but numbers."""
    return [Unclaimed(_text_of(name), _not_read_back(name)) for name in targets if name not in READERS]


def read_back(sources: Sources, result: Mapping[str, bytes], seed: int = 1) -> tuple[Written, ...]:
    """Return what is known of the files of a target that were found, by name: these must be `sources`, made now."""
    fresh = files_of(sources)
    files = replace(fresh, contents=result)
    try:
        loops = TARGETS[sources.target].loops_in(REALS[sources.real])
        numbers = printed(sources.program, sources.real, seed, loops)
        return prove_texts(numbers, files, languages(sources.target, sources.option), fresh.contents)
    except Redraw:
        return unshown(files, fresh.contents, NOWHERE)
    except MissingProgram as fault:
        return unshown(files, fresh.contents, str(fault))


def why_unread(target: str) -> str:
    """Return why files of a target are not read back, and what would work; "" for those that are."""
    if target in READERS:
        return ""
    measured = f", or verify the scene with --targets {target}, which measures it" if target in RUNNERS else ""
    return f"{_not_read_back(target)}; give a folder of files for {' or '.join(READERS)}{measured}"


def _not_read_back(target: str) -> str:
    return f"files of target {target} ({TARGETS[target].text}) are not read back"


def _text_of(target: str) -> str:
    return f"the text of {TARGETS[target].title}"


def files_of(sources: Sources) -> Files:
    """Return the files of a target as readers take them."""
    return Files(sources.target, sources.option, sources.stem, sources.functions, dict(sources))

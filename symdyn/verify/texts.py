"""The text of targets' files, read back and proved: what a certificate says beside graphs and numbers."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra.finite_field import Redraw
from symdyn.emit import TARGETS, Sources
from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.real import find_real
from symdyn.errors import MissingProgram
from symdyn.verify.building import Building
from symdyn.verify.written import READERS, Files, Written, languages, printed, prove_texts


def written_of(
    building: Building, targets: Sequence[str], asked: bool, notes: list[str], seed: int
) -> tuple[Written, ...]:
    """Return what is known of the files of `targets`; notes say which are not read and why.

    Args:
        building: what is written, with which number type.
        targets: keys of `TARGETS`; those that nothing reads are left out.
        asked: whether they were asked for by name: then files with each option are proved too.
        notes: added to.
        seed: of primes and points.
    """
    targets = [name for name in targets if name in READERS]
    if not targets:
        return ()
    try:
        loops = {name: TARGETS[name].loops_in(find_real(building.real)) for name in targets}
        numbers = {one: printed(building.program, building.real, seed, one) for one in set(loops.values())}
    except Redraw:
        notes.append("files were not proved: no point was found at which all functions are defined")
        return ()
    found: list[Written] = []
    for name in targets:
        for option in building.options(name, asked):
            try:
                files = files_of(building.written(name, option))
                found += prove_texts(numbers[loops[name]], files, languages(name, option))
            except MissingProgram as fault:
                notes.append(f"files of {TARGETS[name].title} were not proved: {fault}")
                break
    return tuple(found)


def files_of(sources: Sources) -> Files:
    """Return the files of a target as readers take them."""
    name = stem(sources.program.scene.name)
    return Files(sources.target, sources.option, name, sources.functions, dict(sources))

"""The certificate of a scene: what was proved, over which fields, of which files, and how far the built code is off."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from symdyn.arguments import check_arguments
from symdyn.dynamics import (
    Equations,
    Function,
    LoopChoices,
    Unasked,
    Workspace,
    derive_one,
    expected,
    of_place,
    roads_of,
    row_of,
    there,
    wanted_on,
)
from symdyn.emit.code.real import SINGLE
from symdyn.emit.code.short_sines import find_short_sines
from symdyn.errors import VerifyError
from symdyn.graph import growing
from symdyn.program import Program, choose, lower
from symdyn.program import prepare as prepare_program
from symdyn.program.formulation import chosen, known_road
from symdyn.program.prepare import is_prepared
from symdyn.scene import SceneLike, scene_of
from symdyn.shown import Shown
from symdyn.verify.accuracy import Accuracy, measure, remarks
from symdyn.verify.blocks import WAYS, Blocks, run_blocks
from symdyn.verify.building import Building, wanted_targets
from symdyn.verify.equality import DIFFERENT, Claim, Fields, Finding, prove
from symdyn.verify.in_rows import InRows
from symdyn.verify.law import Seen
from symdyn.verify.laws import laws
from symdyn.verify.laws_in_numbers import LOOKS
from symdyn.verify.program_claims import composed_claims, loop_claim, program_claims
from symdyn.verify.quaternions import on_unit_sphere
from symdyn.verify.texts import written_of
from symdyn.verify.written import Written

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Certificate(Shown):
    """What is known about a scene's equations and code.

    Attributes:
        scene: its name.
        fields: primes, points and seed of the proofs.
        findings: derivations against each other, laws, and the program against the equations.
        accuracy: built modules against 50 digits.
        notes: what was left out and why.
        refused: the words of the compiler or of Node.js if it refused the code; "" if it did not.
        written: files whose text was read back and proved.
        blocks: code for many states that was run at every length, of targets that were asked for.
    """

    scene: str
    fields: Fields
    findings: tuple[Finding, ...]
    accuracy: tuple[Accuracy, ...]
    notes: tuple[str, ...]
    refused: str = ""
    written: tuple[Written, ...] = ()
    blocks: tuple[Blocks, ...] = ()

    def __repr__(self) -> str:
        verdicts = Counter(one.verdict for one in self.findings)
        counts = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items())
        measured = len({one.function for one in self.accuracy})
        passed = "passed" if self.passed else "FAILED"
        return f"<Certificate of {self.scene}: {passed}; {counts}; {measured} functions measured>"

    @property
    def passed(self) -> bool:
        """Whether nothing differs, the code compiles, and every module is as accurate as its numbers allow."""
        sound = all(f.verdict != DIFFERENT for f in self.findings)
        sound = sound and all(one.passed for one in self.written) and all(one.passed for one in self.blocks)
        return sound and not self.refused and all(a.passed for a in self.accuracy)

    def as_dict(self) -> dict[str, Any]:
        """Return the certificate for JSON."""
        facts: dict[str, Any] = finite({**asdict(self), "passed": self.passed})
        return facts


@growing()
def certify(
    scene: SceneLike,
    outputs: Sequence[str] | None = None,
    seed: int = 1,
    progress: Progress = lambda _: None,
    real: str = "double",
    road: str | None = None,
    prepare: bool = False,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
    targets: Sequence[str] | None = None,
    accuracy: str = "",
) -> Certificate:
    """Return the certificate of a scene.

    >>> import symdyn
    >>> symdyn.certify(symdyn.example("pendulum"), ["mass_matrix"])
    <Certificate of pendulum: passed; 2 proved; 1 functions measured>

    Args:
        scene: the mechanism.
        outputs: what to certify, as for `derive`; None takes everything that the scene has.
        seed: of primes, points and states; the same seed, the same proofs.
        progress: told what is being done.
        real: "double" or "float": the number type of the modules that are measured.
        road: the derivation that becomes code, as for `formulate`.
        prepare: whether the code is that of `prepare`: each function of it, after `prepare`, is proved to be the
            function without, and is measured together with it.
        closing: what to choose about closed loops; the notes say it.
        targets: of which the code is measured, keys of `symdyn.emit.TARGETS`, and the text of the files proved, with
            every option; None takes those that run quickly, and the files that are measured.
        accuracy: as for `emit`: of code that has it, measured over many states, with what sines are off by in the
            bounds.

    Raises:
        DerivationError: an output that was asked for by name does not exist, or no output has the road.
        VerifyError: a number type that is not measured.
        EmitError: there is no such target or accuracy, or it does not have the number type.
    """
    check_arguments(certify, locals())
    if real not in SINGLE:
        raise VerifyError(f"real type {real!r} is not measured; give {' or '.join(SINGLE)}")
    asked = targets is not None
    scene, targets = scene_of(scene), wanted_targets(targets, real, accuracy)
    notes = [closing.words] if closing.words else []
    sines = find_short_sines(accuracy, real)
    if sines:
        notes.append(f"accuracy {accuracy}: bounds have sines and cosines that are off by {sines.bound:.0e} in them")
    workspace = Workspace(scene, closing)
    progress("deriving")
    outputs, preferred, left_out = taken(workspace, outputs, road)
    notes += left_out
    program = lower(Equations(scene, workspace.graph, preferred))
    code = prepare_program(program) if prepare else program
    if prepare and code is program:
        notes.append("nothing to prepare: no function has a free parameter")
    with Building(code, real, accuracy) as building:
        progress("writing files")
        building.begin(targets, WAYS if asked else ())
        progress("deriving once more, by other roads")
        claims = _claims(workspace, outputs, preferred, program) + composed_claims(program, code)
        progress("proving over finite fields")
        there = [claim for claim in claims if claim.left]  # k_C of one coordinate has no entries
        claims = on_unit_sphere(scene, there)
        fields, findings = prove(claims, seed, positive=[p.name for p in scene.parameters if p.positive])
        progress("reading files back")
        written = written_of(building, targets, asked, notes, seed)
        progress("building")
        modules, refused = building.modules(notes, targets)
        blocks: tuple[Blocks, ...] = ()
        if asked:
            progress("running blocks of states at every length")
            blocks = tuple(run_blocks(building, name, seed) for name in modules if name in WAYS)
    if sines:
        modules = {name: InRows(module, code) for name, module in modules.items()}
    if is_prepared(code):
        modules = {name: _Composed(module) for name, module in modules.items()}
    for one in LOOKS:
        if one.fits(scene, outputs):
            progress(one.doing)
            found, told = one.look(Seen(workspace, outputs, program, {} if sines else modules, seed))
            findings += found
            notes += told
    progress("measuring against 50 digits")
    measured = measure(program, modules, seed=seed, real=real, accuracy=accuracy)
    notes += remarks(measured)
    return Certificate(scene.name, fields, tuple(findings), tuple(measured), tuple(notes), refused, written, blocks)


def taken(
    workspace: Workspace, outputs: Sequence[str] | None, road: str | None
) -> tuple[tuple[str, ...], tuple[Function, ...], list[str]]:
    """Return outputs, those that become code, and why others do not: for None all that are worth certifying.

    These are what a scene has unasked, kinematics of the last body, and what no one writes unasked.
    """
    if outputs is not None:
        return tuple(outputs), choose(workspace, outputs, road), []
    scene = workspace.scene
    wanted, left_out = wanted_on(workspace)
    wanted += of_place(scene.bodies[-1].name, Unasked.PROVED)
    wanted += [name for name in expected(scene, Unasked.PROVED) if row_of(name)[0].unasked is Unasked.PROVED]
    known_road(scene, wanted, road)
    functions: list[Function] = []
    found, faults = there(workspace, wanted, lambda w, name: functions.append(chosen(w, name, road)))
    return found, tuple(functions), left_out + faults


def _claims(
    workspace: Workspace, outputs: Sequence[str], preferred: Sequence[Function], program: Program
) -> list[Claim]:
    """Return that all roads agree, that laws hold, and that the program is what the preferred roads gave."""
    roads = [
        _agreement(workspace, name, one, derive_one(workspace, name, other))
        for name, one in zip(outputs, preferred, strict=True)
        for other in roads_of(name, workspace.scene)
        if other != one.formulation
    ]
    return [*roads, *laws(workspace, outputs), *program_claims(workspace.scene, preferred, program)]


def _agreement(w: Workspace, request: str, one: Function, other: Function) -> Claim:
    """Return that two derivations agree, in what is no choice."""
    compared = row_of(request, w.scene)[0].compared
    name, of = compared or (request, lambda _, entries: entries)
    return Claim(name, one.formulation, other.formulation, tuple(of(w, one.entries)), tuple(of(w, other.entries)))


def of_files(
    equations: Equations,
    program: Program,
    written: Sequence[Written],
    seed: int = 1,
    notes: Sequence[str] = (),
) -> Certificate:
    """Return the certificate of files that were read back: they are the program, and the program is its equations.

    Args:
        equations: what was asked for.
        program: what the files must compute, prepared or not.
        written: what is known of the files.
        seed: of primes and points.
        notes: what else is said.
    """
    scene = equations.scene
    plain = lower(equations)
    claims = program_claims(scene, equations.functions, plain) + composed_claims(plain, program)
    claims += [loop_claim(function) for function in equations.functions if function.loop]
    claims = on_unit_sphere(scene, [claim for claim in claims if claim.left])
    fields, findings = prove(claims, seed, positive=[p.name for p in scene.parameters if p.positive])
    return Certificate(scene.name, fields, tuple(findings), (), tuple(notes), "", tuple(written))


class _Composed:
    """A prepared module with the functions of the module that is not: each prepares its own last argument."""

    def __init__(self, module: Any) -> None:
        """Stand before `module`."""
        self._module = module

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return the function called `name`, of params."""
        call = getattr(self._module, name)
        return lambda *operands: call(*operands[:-1], self._module.prepare(operands[-1]))


def finite(value: Any) -> Any:
    """Return `value` with infinities and NaNs, which JSON has no word for, as None."""
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value

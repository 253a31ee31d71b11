"""The certificate of a scene: what was proved, over which fields, of which files, and how far the built code is off.

Claims about quaternions are compared on the unit sphere, where they hold:

    e = u² / |u|²    is a unit quaternion for any u, rational in its four numbers

so that they can be evaluated over a field or at a random point, where no length is one by itself.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.arguments import checked, native, walked
from symdyn.dynamics import Equations, LoopChoices, Workspace
from symdyn.dynamics.mechanism import quaternions
from symdyn.emit import Sources
from symdyn.emit.code import SINGLE, ShortSines
from symdyn.errors import ArgumentError, VerifyError
from symdyn.frozen import asdict, dataclass, replace
from symdyn.graph import Expr, Graph, growing, reachable, substitute
from symdyn.program import Program, lower, prepare as prepare_program, shared
from symdyn.rounding import finite
from symdyn.scene import Scene, SceneLike, scene_of
from symdyn.shown import Shown
from symdyn.verdict import Claims, Judged, NotLookedAt, Unclaimed, Verdict
from symdyn.verify.accuracy import Accuracy, measure, remarks
from symdyn.verify.building import (
    WAYS,
    Blocks,
    Building,
    read_back,
    requested_targets,
    run_blocks,
    run_nowhere,
    texts_of,
    unmeasured,
    unread,
)
from symdyn.verify.claims import Seen, claims_of, compared, composed_claims, loop_claim, program_claims, taken
from symdyn.verify.equality import Claim, Fields, Finding, prove
from symdyn.verify.laws import laws
from symdyn.verify.natural_positions import look
from symdyn.verify.written.proof import Written, hiding_files

STATES = 32
"""More than any target computes one by one."""


class InRows:
    """The functions of a module, each of one state that stands in a row of many like it."""

    def __init__(self, module: Any, program: Program) -> None:
        """Stand before `module`, whose functions take leading dimensions."""
        self._module = module
        names = {one.function.name: [a.name for a in one.function.arguments] for one in program.routines}
        self._varying = {name: [a != shared(taken) for a in taken] for name, taken in names.items()}

    def __getattr__(self, name: str) -> Callable[..., Any]:
        call = getattr(self._module, name)

        def of_many(*operands: Any) -> Any:
            rows = [
                np.broadcast_to(given, (STATES, *np.shape(given))) if varies else given
                for given, varies in zip(operands, self._varying[name], strict=True)
            ]
            return np.asarray(call(*rows))[-1] if any(self._varying[name]) else call(*operands)

        return of_many


def on_unit_sphere(scene: Scene, claims: Sequence[Claim]) -> list[Claim]:
    """Return the claims with u² / |u|² in place of every quaternion of the scene, u named as it was."""
    groups = quaternions(scene)
    return [_on_sphere(claim, groups) for claim in claims] if groups else list(claims)


def _on_sphere(claim: Claim, groups: Sequence[tuple[str, ...]]) -> Claim:
    left, right = (_substituted(side, groups) for side in (claim.left, claim.right))
    return replace(claim, left=left, right=right)


def _substituted(entries: Sequence[Expr], groups: Sequence[tuple[str, ...]]) -> tuple[Expr, ...]:
    if not entries:
        return ()
    values: dict[Expr, Expr] = {}
    names = {node.value for node in reachable(entries)}
    for group in groups:
        if names.intersection(group):
            values |= _unit(entries[0].graph, group)
    return tuple(substitute(entries, values))


def _unit(graph: Graph, names: tuple[str, ...]) -> dict[Expr, Expr]:
    """Return u² / |u|² for u = (w, x, y, z)."""
    u = [graph.symbol(name) for name in names]
    w, x, y, z = u
    square = w * w + x * x + y * y + z * z
    e = ((w * w - x * x - y * y - z * z) / square, *(2 * w * part / square for part in (x, y, z)))
    return dict(zip(u, e, strict=True))


Progress = Callable[[str], None]


@dataclass(frozen=True)
class Certificate(Shown, Claims):
    """What is known about a scene's equations and code.

    Attributes:
        scene: its name.
        fields: primes, points and seed of the proofs.
        findings: derivations against each other, laws, and the program against the equations.
        accuracy: built modules against 50 digits.
        notes: what else is said, and what was left out unasked.
        refused: the words of the compiler or of Node.js if it refused the code; "" if it did not.
        written: files whose text was read back and proved.
        blocks: code for many states that was run at every length, of targets that were asked for.
        absent: what does not exist there, of which nothing is claimed.
        not_run: what this machine cannot run, and nobody asked for by name.
        not_looked_at: what no machine runs or reads back of targets that were asked for.
        unshown: what was asked for and cannot be looked at, or has no value anywhere.
    """

    scene: str
    fields: Fields
    findings: tuple[Finding, ...]
    accuracy: tuple[Accuracy, ...]
    notes: tuple[str, ...]
    refused: str = ""
    written: tuple[Written, ...] = ()
    blocks: tuple[Blocks, ...] = ()
    absent: tuple[Unclaimed, ...] = ()
    not_run: tuple[Unclaimed, ...] = ()
    unshown: tuple[Unclaimed, ...] = ()
    not_looked_at: tuple[Unclaimed, ...] = ()

    def __repr__(self) -> str:
        verdicts = Counter(one.verdict for one in self.findings)
        counts = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items())
        measured = len({one.function for one in self.accuracy})
        return f"<Certificate of {self.scene}: {self.word}; {counts or 'no claims'}; {measured} functions measured>"

    @property
    def claims(self) -> tuple[Judged, ...]:
        found = [*map(_of_finding, self.findings), *map(_of_written, self.written), *map(_of_blocks, self.blocks)]
        found += map(_of_accuracy, self.accuracy)
        found += [Judged("the code is taken by its compiler", Verdict.DIFFERENT, self.refused)] if self.refused else []
        found += [Judged(one.what, Verdict.NOT_SHOWN, one.why) for one in self.unshown]
        return tuple(one for one in found if one.verdict)

    @property
    def word(self) -> str:
        """Passed, fails or not shown, for people."""
        return "passed" if self.passed else self.verdict

    def as_dict(self) -> dict[str, Any]:
        facts: dict[str, Any] = asdict(self)
        for name, rows in (("accuracy", self.accuracy), ("blocks", self.blocks), ("written", self.written)):
            facts[name] = [{**asdict(one), "verdict": one.verdict, "passed": one.passed} for one in rows]
        told: dict[str, Any] = finite(facts | self._verdicts())
        return told

    @classmethod
    def of_files(
        cls,
        equations: Equations,
        program: Program,
        sources: Sources,
        result: Mapping[str, bytes],
        seed: int = 1,
        notes: tuple[str, ...] = (),
        progress: Callable[[str], None] = lambda _: None,
    ) -> Certificate:
        """Return the certificate of files, read back: they are the program, and the program is its equations.

        Args:
            equations: what was asked for.
            program: what the files must compute, prepared or not.
            sources: the files of the program, made now.
            result: those that were found, by name, which must be the same.
            seed: of primes and points.
            notes: what else is said.
            progress: called with what is being done.
        """
        written = read_back(sources, result, seed)
        progress("proving over finite fields")
        scene = equations.scene
        plain = lower(equations) if program.is_prepared else program
        claims = program_claims(scene, equations.functions, plain) + composed_claims(plain, program)
        claims += [loop_claim(function) for function in equations.functions if function.loop]
        claims, empty = compared(claims, equations.functions)
        claims = on_unit_sphere(scene, claims)
        fields, findings = prove(claims, seed, positive=[p.name for p in scene.parameters if p.positive])
        return cls(scene.name, fields, tuple(findings), (), notes, "", written, absent=tuple(empty))

    @classmethod
    def of_folder(cls, parts: Sequence[Certificate], folder: Path, names: Iterable[str]) -> Certificate:
        """Return one certificate of certificates of files; of other names in the folder, some hide what these ask for.

        Those hide it that a tool would take in place of its own; each is a file that fails.
        """
        written = tuple(one for part in parts for one in part.written)
        read = {one.file for one in written}
        return cls(
            parts[0].scene,
            parts[0].fields,
            tuple(one for part in parts for one in part.findings),
            (),
            tuple(dict.fromkeys(note for part in parts for note in part.notes)),
            "",
            written + hiding_files(folder, written, [name for name in names if name not in read]),
            absent=tuple(dict.fromkeys(one for part in parts for one in part.absent)),
        )


def _of_finding(one: Finding) -> Judged:
    return Judged(
        one.claim, one.verdict, one.why or (f"entry {one.where} differs" if one.verdict == Verdict.DIFFERENT else "")
    )


def _of_accuracy(one: Accuracy) -> Judged:
    what = f"{one.function} in {one.module} against 50 digits"
    if one.verdict == Verdict.NOT_SHOWN:
        return Judged(what, one.verdict, "real at none of the states tried")
    return Judged(what, one.verdict, "" if one.passed else "an entry is farther off than its bound allows")


def _of_written(one: Written) -> Judged:
    return Judged(f"the text of {one.file}{f' (--{one.option})' if one.option else ''}", one.verdict, one.where)


def _of_blocks(one: Blocks) -> Judged:
    where = f"{one.wrong} differ" if one.wrong else ""
    without = f"no state has a value of {', '.join(one.without)}" if one.without else "there is no function"
    return Judged(f"blocks of {one.target}", one.verdict, "" if one.passed else where or without)


@growing()
@checked(ArgumentError)
def certify(
    scene: SceneLike,
    outputs: Sequence[str] | None = None,
    seed: int = 1,
    progress: Progress = lambda _: None,
    real: str = "double",
    formulation: str | None = None,
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
        progress: called with what is being done.
        real: number type of the modules that are measured, "double" or "float".
        formulation: the derivation that becomes code wherever a function has it; "hamilton", "routh", "gibbs-appell",
            "udwadia-kalaba" or "port-hamiltonian" for the functions of these, with their laws.
        prepare: whether the code is that of `prepare`: each function of it, after `prepare`, is proved to be the
            function without, and is measured together with it.
        closing: what to choose about closed loops; the notes say it.
        targets: of which the code is measured, and the text of the files proved, with every option; None takes those
            that run quickly, and the files that are measured. Keys of `symdyn.emit.TARGETS`.
        accuracy: of code that has it, measured over many states, with what sines are off by in the bounds; "" for that
            of the number type. As for `emit`.

    Raises:
        DerivationError: an output that was asked for by name does not exist, or no output has the formulation.
        VerifyError: a number type that is not measured.
        EmitError: there is no such target or accuracy, or it does not have the number type.
    """
    if targets is not None:
        (targets,) = walked(certify, locals(), "targets")
    if real not in SINGLE:
        raise VerifyError(f"real type {real!r} is not measured; give {' or '.join(SINGLE)}")
    asked, (seed,) = targets is not None, native(int, seed)
    scene, targets = scene_of(scene), requested_targets(targets, real, accuracy)
    notes = [closing.words] if closing.words else []
    sines = ShortSines.find(accuracy, real)
    if sines:
        notes.append(f"accuracy {accuracy}: bounds have sines and cosines that are off by {sines.bound:.0e} in them")
    workspace = Workspace(scene, closing)
    progress("deriving")
    outputs, preferred, left_out, absent = taken(workspace, outputs, formulation)
    notes += left_out
    program = lower(Equations(scene, workspace.graph, preferred))
    code = prepare_program(program) if prepare else program
    if prepare and code is program:
        notes.append("nothing to prepare: no function has a free parameter")
    with Building(code, real, accuracy) as building:
        progress("writing files")
        building.begin(targets, WAYS if asked else ())
        progress("deriving once more, by other formulations")
        claims, lacking = claims_of(workspace, outputs, preferred, program, laws(workspace, outputs))
        claims, empty = compared(claims + composed_claims(program, code), preferred)
        absent += [*lacking, *empty]
        claims = on_unit_sphere(scene, claims)
        progress("proving over finite fields")
        fields, findings = prove(claims, seed, positive=[p.name for p in scene.parameters if p.positive])
        progress("reading files back")
        texts = texts_of(building, targets, asked, seed)
        progress("building")
        made = building.modules(targets)
        blocks: tuple[Blocks, ...] = ()
        if asked:
            progress("running blocks of states at every length")
            blocks = tuple(run_blocks(building, name, seed) for name in made.built if name in WAYS)
    modules = {name: InRows(module, code) for name, module in made.built.items()} if sines else made.built
    if code.is_prepared:
        modules = {name: _Composed(module) for name, module in modules.items()}
    looked, nowhere = look(Seen(workspace, outputs, program, {} if sines else modules, seed), progress)
    unseen = [one for one in nowhere if isinstance(one, NotLookedAt)]
    progress("measuring against 50 digits")
    measured = measure(program, modules, seed=seed, real=real, accuracy=accuracy)
    missing = (*texts.missing, *made.missing)
    unrun = [] if made.missing or made.refused else run_nowhere(program, targets, {one.function for one in measured})
    return Certificate(
        scene.name,
        fields,
        (*findings, *looked),
        tuple(measured),
        (*notes, *remarks(measured)),
        made.refused,
        texts.written,
        blocks,
        (*absent, *(one for one in nowhere if one not in unseen)),
        () if asked else missing,
        (*(missing if asked else ()), *texts.unshown, *unrun),
        (*unseen, *unmeasured(targets), *(unread(targets) if asked else ())),
    )


class _Composed:
    """A prepared module with the functions of the module that is not: each prepares its own last argument."""

    def __init__(self, module: Any) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Callable[..., Any]:
        call = getattr(self._module, name)
        return lambda *operands: call(*operands[:-1], self._module.prepare(operands[-1]))

"""Which questions of physics a document gets, and those about bodies that turn by quaternions."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from symdyn.algebra import Form, Symbol
from symdyn.dynamics.mechanism import TIME
from symdyn.graph import reachable, substitute
from symdyn.linear import rests
from symdyn.table import Table
from symdyn.teach.derivations.quaternion_steps import Turning
from symdyn.teach.derivations.turning_body import along_ground, kept
from symdyn.teach.document import Document, Option, Section, Step, Words
from symdyn.teach.lesson import AXES, is_tied, named
from symdyn.teach.practice.physics import MOST, PHYSICS, Asked, OpenQuestions, PhysicsQuestions
from symdyn.teach.practice.tied_questions import TiedQuestions
from symdyn.unlocked import cached_property


def with_physics(document: Document) -> tuple[Document, Section | None]:
    """Return the document with the names of quantities that are asked for, and the section of questions, if any."""
    turns = any(joint.velocities for joint in document.scene.joints)
    kind = TurningQuestions if turns else TiedQuestions if is_tied(document.scene) else OpenQuestions
    questions = kind(document)
    steps = [Step(one.key, Words(()), (one,)) for one in questions.every()][:MOST]
    if not steps:
        return document, None
    return replace(document, names=questions.names), questions.prose.section(PHYSICS, steps)


class TurningQuestions(PhysicsQuestions):
    """Of a mechanism whose bodies turn by quaternions, and that no condition ties."""

    def kinds(self) -> Iterable[Callable[[], Asked]]:
        """Return what yields questions, in their order."""
        if self.lesson.ties or "energy" not in self.steps:
            return []
        return [self.rest, self.spin, self.critical, self.conserved, self.limit, self.unit]

    @cached_property
    def lesson(self) -> Turning:
        """The mechanism on a graph of its own."""
        return Turning(self.scene, self.document.language)

    def rest(self) -> Asked:
        """Where it rests stably, of the rests that the lesson tells in words."""
        found, options = rests(self.scene), list[Option]()
        tables = [step.blocks[0] for part in self.document.sections for step in part.steps if step.key == "equilibria"]
        rows = tables[0].rows if tables and isinstance(tables[0], Table) else ()
        for row, system in zip(rows, found.systems, strict=False):
            grows = max((mode.value.real for mode in system.modes), default=0.0)
            calm = system.stability.verdict in ("stable", "oscillating")
            why = Words(()) if calm else self.say("stable.grows", rate=self.prose.written(grows))
            options.append(Option(row[0], calm, why))
        yield from self.choice("stable", self.say("stable.of", several=self.say("several")), options)

    def spin(self) -> Asked:
        """About which axes a spin is stable."""
        for part in self.document.sections:
            for step in part.steps:
                table = step.blocks[0] if step.key.startswith("spins:") else None
                if isinstance(table, Table):
                    calm = self.prose.say("equilibria.stable")
                    options = [
                        Option(
                            row[0], row[2] == calm, Words(()) if row[2] == calm else self.say("spin.no", square=row[1])
                        )
                        for row in table.rows
                    ]
                    yield from self.choice("spin", self.say("spin", several=self.say("several")), options)
                    return

    def conserved(self) -> Asked:
        """What stays: the angular momentum along axes of the ground and of the body, its size, and the energy."""
        lesson, joint = self.lesson, self.lesson.balls[0]
        found = kept(lesson, joint)
        if found is None:
            return
        options = list[Option]()
        for a in range(3):
            right = a in found.ground
            why = Words(()) if right else self.say("conserved.ground", axis=AXES[a])
            told = self.say("conserved.along", axis=AXES[a], momentum=along_ground(joint, found, a))
            options.append(Option(told, right, why))
        for k, i in enumerate(found.own):
            why = Words(()) if k in found.body else self.say("conserved.body", axis=AXES[k])
            options.append(Option(self.say("conserved.own", momentum=Symbol(f"p:{i + 1}")), k in found.body, why))
        timed = lesson.graph.symbol(TIME) in reachable([lesson.L, *lesson.acting])
        calm = not timed and all(x.is_zero for x in lesson.acting)
        total = Form.sum((Symbol("K:"), Symbol("P:")))
        why = Words(()) if calm else self.say("conserved.timed")
        options.append(Option(self.say("conserved.energy", total=total), calm, why))
        yield from self.choice("conserved", self.say("conserved", several=self.say("several")), options)

    def limit(self) -> Asked:
        """What is left without gravity."""
        lesson = self.lesson
        letters = [x for entry in self.scene.gravity for x in entry.symbols]
        if len(letters) != 1:
            return
        g = lesson.graph.symbol(letters[0])
        (P,) = substitute([lesson.energy.P], {g: lesson.graph.zero})
        free = P.is_zero or lesson.vanishes(P)
        options = [
            Option(self.say("limit.whole"), free, Words(()) if free else self.say("limit.whole.no")),
            Option(self.say("limit.anywhere"), free, Words(()) if free else self.say("limit.whole.no")),
            Option(self.say("limit.still"), False, self.say("limit.still.no")),
        ]
        yield from self.choice("limit", self.say("limit", m=named(g), several=self.say("several")), options)

    def unit(self) -> Asked:
        """Which unit a coefficient of inertia has, by what its product with an acceleration is."""
        i = self.lesson.first(self.lesson.balls[0]) + len(self.lesson.balls[0].rates) - 3
        yield from self.unit_of(i, i, named(self.lesson.state.qdd[i]))

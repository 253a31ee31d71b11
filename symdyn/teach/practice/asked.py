"""Which questions of physics a document gets, and those about quaternions, and about loops and rolling."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from scipy.linalg import null_space

from symdyn import linear
from symdyn.algebra import Symbol
from symdyn.dynamics.mechanism import TIME
from symdyn.graph import reachable, substitute, tangents
from symdyn.scene import SceneUnits, without_hidden_zeros
from symdyn.scene.values import force_unit
from symdyn.table import Table
from symdyn.teach.derivations.constrained import Constrained
from symdyn.teach.derivations.elsewhere import elsewhere
from symdyn.teach.derivations.multipliers import choose_tied_motion
from symdyn.teach.derivations.quaternion_steps import Turning
from symdyn.teach.derivations.reduced import zero
from symdyn.teach.derivations.turning_body import along_ground, kept
from symdyn.teach.document import Braced, Document, Option, Section, Step, Words
from symdyn.teach.lesson import AXES, is_tied, named
from symdyn.teach.practice.physics import MOST, PHYSICS, SLIGHT, Asked, OpenQuestions, PhysicsQuestions
from symdyn.teach.shown_state import Chosen
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
        if elsewhere(self.prose, "rests"):
            return
        tables = [step.blocks[0] for part in self.document.sections for step in part.steps if step.key == "equilibria"]
        rows = tables[0].rows if tables and isinstance(tables[0], Table) else ()
        yield from self.stably((row[0] for row in rows), linear.rests(self.scene).systems)

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
        yield from self.stays(options, Words(()) if calm else self.say("conserved.timed"))

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


class TiedQuestions(PhysicsQuestions):
    """Of a mechanism with loops or rolling."""

    def kinds(self) -> Iterable[Callable[[], Asked]]:
        """Return what yields questions, in their order."""
        if not {"equilibria", "kane"} & self.steps:
            return []
        more = [self.conserved, self.sense] if "system" in self.steps else []
        return [self.stable, *more, self.unit]

    @cached_property
    def lesson(self) -> Constrained:
        """The mechanism on a graph of its own."""
        return Constrained(without_hidden_zeros(self.scene), self.document.language)

    @cached_property
    def chosen(self) -> Chosen:
        """The state of the lesson."""
        return choose_tied_motion(self.lesson)

    def stable(self) -> Asked:
        """Which places of rest are stable, in numbers."""
        if elsewhere(self.prose, "rests"):
            return
        found = linear.rests(self.scene)
        shown = [k for k, name in enumerate(self.scene.coordinates) if name not in found.idle]
        places = (self.placed(self.value(k, float(place.q[k])) for k in shown) for place in found.places)
        yield from self.stably(places, found.systems)

    def unit(self) -> Asked:
        """Which unit the first term with a multiplier has in the equation of a coordinate."""
        rows = [b for _, b in self.document.blocks() if isinstance(b, Braced) and b.value.startswith("tau:")]
        tied = [(int(b.value[4:]) - 1, term) for b in rows for term in b.left.terms]
        terms = [(k, term) for k, term in tied if "lambda:1" in term.symbols]
        if terms and self.scene.shown_unit("kg") == "kg":
            k, term = terms[0]
            q, right = Symbol(self.scene.velocities[k]), force_unit(SceneUnits(self.scene).velocities[k])
            why = dict.fromkeys(("N", "N m", "N s", "kg m²"), self.say("unit.power", rate=q))
            yield from self.units_of(right, why, self.say("unit.term", term=term.split_sign()[1], i=str(k + 1)))

    def conserved(self) -> Asked:
        """What stays while no drive acts: what the lesson tells, and momenta that the conditions or energies change."""
        lesson, options = self.lesson, list[Option]()
        steps = {step.key: step for section in self.document.sections for step in section.steps}
        momenta = [step for key, step in steps.items() if key.startswith("conserved:")]
        options += [Option(Words(step.claim.parts[-2:-1]), True, Words(())) for step in momenta]
        rates = self.chosen.of(*tangents(lesson.momenta, lesson.state.acceleration))
        for k, q in enumerate(map(named, lesson.state.q[:3])):
            if abs(rates[k]) > SLIGHT and not lesson.scene.prescribed_velocities:
                level = zero(lesson, lesson.slopes[k])
                why = self.say("conserved.tied" if level else "conserved.slope", q=q)
                if not level or any(not zero(lesson, tie.slopes[k]) for tie in lesson.ties):
                    options.append(Option(self.say("conserved.momentum", q=q), False, why))
        yield from self.stays(options, Words(()) if "energy" in steps else self.say("conserved.outside"))

    def sense(self) -> Asked:
        """Which sign the one drive has that holds the mechanism at rest where the lesson shows it."""
        lesson, chosen, n = self.lesson, self.chosen, self.lesson.state.n
        driven = [k for k, drive in enumerate(self.scene.drives) if drive]
        ways = null_space(np.array(chosen.of(*(x for tie in lesson.ties for x in tie.slopes))).reshape(-1, n))
        if len(driven) != 1 or ways.shape[1] != 1 or abs(ways[driven[0], 0]) < SLIGHT or self.scene.free_parameters:
            return
        (k,), still = driven, dict.fromkeys((*lesson.state.qd, *lesson.state.qdd), lesson.graph.zero)
        own = {lesson.graph.symbol(str(self.scene.drives[k])): lesson.graph.zero}
        forces = np.array(chosen.of(*substitute(lesson.drives, still | own)))
        value = float(forces @ ways[:, 0] / ways[k, 0])
        if abs(value) <= SLIGHT * np.abs(forces).max(initial=0.0):
            return
        drive, sign = Symbol(str(self.scene.drives[k])), 1 if value > 0 else -1
        places = {"value": self.scene.in_shown_unit(self.prose.equals(value), force_unit(self.units[k]))}
        why = self.say("sense.tied", drive=drive, sign=self.say(f"sense.{'+' if sign > 0 else '-'}"), **places)
        q = named(lesson.state.q[k])
        yield from self.of_sign("sense.drive", sign, why, drive, q, [(k, chosen.q[k])])

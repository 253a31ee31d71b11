"""What all steps of one walkthrough share: the graph, the ring that writes short forms, the names, the language.

Formulas of a walkthrough carry the indices of what a scene weighs, one entry a particle and one a rigid body.

Loops, contacts and rows may tie nothing: a door's second hinge forbids what the first one forbids already. A mechanism
of these alone moves as the open one, by Lagrange's method; one with others as well has multipliers of the others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache

from symdyn.algebra import AngleGroup, Compactor, Form, Polynomial, Symbol, TrigonometricRing
from symdyn.arguments import argument
from symdyn.dynamics import ClosedForm, Energies, Workspace, angle_groups, closed_form
from symdyn.dynamics.mechanism import State, body_placements, strut_way, vector
from symdyn.emit.print import Letters, Printable
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Expr, Graph, evaluate, gradient, tangents
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES, elastic
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Body, Joint
from symdyn.spatial import Mat, Transform, Vec
from symdyn.table import Table
from symdyn.teach.document import Letter, Name, Rate, Section, Slope, Step, Words
from symdyn.teach.languages import Language, fill, language_of
from symdyn.teach.mathematics import about, equals, written
from symdyn.unlocked import cached_property

AXES = "xyz"


def called(scene: Scene) -> str:
    """Return what a scene is called: its description, else its name without what puts identifiers together."""
    return scene.text[:1].upper() + scene.text[1:] or scene.name.replace("_", " ")  # it begins titles and sentences


def described(scene: Scene) -> dict[str, dict[str, str]]:
    """Return descriptions of bodies, joints, elements by names, by the places of a text or table where they stand."""
    bodies = {one.name: one.text for one in scene.bodies if one.text}
    joints = {one.name: one.text for one in (*scene.joints, *scene.loops) if one.text}
    places = dict.fromkeys(("body", "bodies", "parent", "child", "on", "carries"), bodies)
    places |= dict.fromkeys(("joint", "joints", "leader"), joints)
    acting = joints | {one.name: one.text for one in scene.elements if one.text}
    places |= dict.fromkeys((*FORCES, "owner", "contact", "force", "couple"), acting)
    return places | {"scene": {scene.name: called(scene)}}


@dataclass(frozen=True)
class Mass:
    """A particle or a rigid body.

    Attributes:
        tag: its index in print: the body's number from 1, with a letter where the body has several masses.
        body: what carries it.
        particle: whether it is a point mass.
        m: kg.
        place: of the particle, the centre of mass, or (`h` given) the origin of the body frame; ground frame, m.
        inertia: about that place, body axes; kg m^2.
        h: first moment in the ground frame, kg m, where inertia is declared about the body frame's origin; else None.
    """

    tag: str
    body: Body
    particle: bool
    m: Expr
    place: Vec
    inertia: Mat
    h: Vec | None = None

    @property
    def spins(self) -> bool:
        """Whether there is a moment of inertia."""
        return not all(x.is_zero for row in self.inertia for x in row)


def masses(scene: Scene, graph: Graph, placed: Mapping[str, Transform]) -> list[Mass]:
    """Return all masses, the ground's side first; `placed` says where bodies are in the ground frame."""
    found = []
    for number, body in enumerate(scene.bodies, 1):
        T = placed[body.name]
        own = [(p.mass.express(graph), T.point(vector(p.at, graph))) for p in body.particles]
        m, inertia = body.mass.express(graph), Mat.symmetric(*(x.express(graph) for x in body.inertia))
        extended = not m.is_zero or not all(x.is_zero for row in inertia for x in row) or body.first_moment is not None
        tags = [str(number)] if len(own) + extended == 1 else [f"{number}{letter}" for letter in "abcdefgh"]
        if len(own) + extended > len(tags):
            tags = [f"{number},{k + 1}" for k in range(len(own) + extended)]
        if extended:
            tag, *tags = tags
            if body.about == "com" and body.com is not None:
                found.append(Mass(tag, body, False, m, T.point(vector(body.com, graph)), inertia))
            else:
                found.append(Mass(tag, body, False, m, T.p, inertia, T.R @ body.mass_moment(graph)))
        nothing = Mat.symmetric(*[graph.zero] * 6)
        found += [Mass(tag, body, True, m, at, nothing) for tag, (m, at) in zip(tags, own, strict=False)]
    return found


READ = 1000
"""Terms of k_z that a lesson may have, multiplied out: a PUMA 560 has 258, a 7-axis arm 3683."""

SMALL_SCENE = 3
"""Degrees of freedom up to which everything is shown in full."""


def apart(scene: Scene, language: str = "en") -> Scene:
    """Return a scene whose parameters print as no letter of the textbook, K, P, L or k_z; each says what it was."""
    shown, said = Letters(scene).apart(), language_of(language).lesson
    renamed = [
        replace(
            one,
            latex=shown[one.name],
            text=said["notation.apart"].format(text=one.text or said["notation.parameter"], name=one.name),
        )
        if one.name in shown
        else one
        for one in scene.parameters
    ]
    return replace(scene, parameters=tuple(renamed)) if shown else scene


def refuse_quaternions(scene: Scene) -> None:
    """Say where quaternions have their lesson, before anything else that a formulation asks of a scene.

    Raises:
        DerivationError: a joint turns by a quaternion.
    """
    for joint in scene.joints:
        if joint.velocities:
            raise DerivationError(
                f"{scene.name}: joint {joint.name} turns by a quaternion; "
                f"{argument('formulation', 'quaternions')} is its lesson, "
                'and orientation = "zyx" (or another sequence of axes) gives it angles, which this formulation takes'
            )


def is_tied(scene: Scene) -> bool:
    """Whether a condition of a loop or a row ties coordinates: the second hinge of a door adds none.

    Raises:
        DerivationError: its loops cannot be assembled.
    """
    return scene.is_constrained and bool(Workspace(scene).loops.decisions.independent_rows)


@dataclass
class Prose:
    """Names and words of one document while it is being written; names grow as steps name quantities."""

    scene: Scene
    language: str
    names: dict[str, Name] = field(default_factory=dict)
    told: set[str] = field(default_factory=set, repr=False)

    # Names

    @cached_property
    def letters(self) -> Letters:
        """Letters that are none of the scene's."""
        return Letters(self.scene)

    def name(self, key: str, letter: str, *index: str, node: Expr | None, dots: int = 0, power: int = 1) -> Symbol:
        """Name a quantity and return its symbol."""
        return self.called(key, Letter(letter, index, dots, power), node)

    def called(self, key: str, look: Letter, node: Expr | None = None) -> Symbol:
        """Name a quantity by its usual letter, or what stands for it here; its key has a sign such as a colon."""
        self.names[key] = Name(replace(look, letter=self.letters[look.letter]), node)
        return Symbol(key)

    def slope(self, of: str, by: str, node: Expr | None) -> Symbol:
        """Name ∂of/∂by."""
        self.names[key := f"d{of}/d{by}"] = Name(Slope(of, by), node)
        return Symbol(key)

    def rate(self, of: str, node: Expr | None) -> Symbol:
        """Name d/dt of."""
        self.names[key := f"d/dt {of}"] = Name(Rate(of), node)
        return Symbol(key)

    # Words

    def say(self, key: str, **places: str | Form | Words) -> Words:
        """Return the prose of a key in the language, its places filled; bodies and joints by their descriptions."""
        text = self.tongue.lesson[key].replace("λ", self.letters.exponent)
        springs = self.tongue.lesson["steady.springs"] if elastic(self.scene) else ""
        return Words(fill(text, {"springs": springs} | {place: self.shown(place, x) for place, x in places.items()}))

    def shown(self, place: str, value: str | Form | Words) -> str | Form | Words:
        """Return what stands in a place of a text: names of bodies and joints, commas between, as described."""
        known = self._described.get(place, {})
        return ", ".join(known.get(x, x) for x in value.split(", ")) if isinstance(value, str) else value

    @cached_property
    def _described(self) -> dict[str, dict[str, str]]:
        return described(self.scene)

    @cached_property
    def tongue(self) -> Language:
        """All words of the language."""
        return language_of(self.language)

    def once(self, key: str, **places: str | Form | Words) -> Words:
        """Return prose the first time that it is asked for; later nothing, as the reasoning is the same."""
        if key in self.told:
            return Words(())
        self.told.add(key)
        return self.say(key, **places)

    def written(self, value: float) -> str:
        """Return a number of prose, see `mathematics.written`."""
        return written(value, self.tongue.decimal)

    def about(self, value: float) -> str:
        """Return a number of prose, after ≈ where digits are left out."""
        return about(value, self.tongue.decimal)

    def equals(self, value: float) -> str:
        """Return what follows a name: "= 3", or "≈ 3.142"."""
        return equals(value, self.tongue.decimal)

    def kind(self, type: str, words: Mapping[str, str]) -> str:
        """Return what a type of joint or a kind of force is called, whose row has these words."""
        return self.tongue.kind(type, words)

    @cached_property
    def titles(self) -> Mapping[str, str]:
        """What parts of pictures are called, from English, where types are called as they are; and descriptions."""
        told = {f"{part} {name}": text for part, known in self._described.items() for name, text in known.items()}
        kinds = {type: self.kind(type, row.words) for type, row in JOINTS.items()}
        return told if self.language == "en" else {**kinds, **self.tongue.picture, **told}

    def joint_kind(self, joint: Joint) -> Words:
        """Return what the type of a joint is called."""
        return Words((self.kind(joint.type, JOINTS[joint.type].words),))

    def text(self, key: str, **places: str) -> str:
        """Return prose without formulas."""
        return "".join(str(part) for part in self.say(key, **places).parts)

    def section(self, key: str, steps: Sequence[Step]) -> Section:
        """Return steps under their heading."""
        return Section(key, self.text(f"section.{key}"), tuple(steps))

    def table(self, heads: Sequence[str | Symbol], rows: Iterable[Sequence[str | Form | Words]]) -> Table[Words]:
        """Return a table; heads are symbols or keys of words, without "table." before those of all lessons.

        Its units are shown as the scene has them: of one without dimensions radians alone.
        """
        shown = [
            Words((head,)) if isinstance(head, Symbol) else self.say(head if "." in head else f"table.{head}")
            for head in heads
        ]
        column = heads.index("unit") if "unit" in heads else -1
        plain = (
            [
                self.scene.shown_unit(x) if k == column and isinstance(x, str) else self.shown(str(heads[k]), x)
                for k, x in enumerate(row)
            ]
            for row in rows
        )
        cells = (tuple(cell if isinstance(cell, Words) else Words((cell,)) for cell in row) for row in plain)
        return Table(tuple(shown), tuple(cells))


@dataclass
class Lesson(Prose):
    """One open chain or tree on one graph while its document is being written."""

    numbers: Mapping[str, str] = field(default_factory=dict)  # equation numbers of the source by key of the formula
    graph: Graph = field(default_factory=Graph, repr=False)  # where its quantities live; one that is given is shared

    def __post_init__(self) -> None:
        """Put the symbols on the graph, parameters first, which is the order that forms print."""
        for parameter in self.scene.parameters:
            self.graph.symbol(parameter.name)
        self.state: State = State.of(self.scene, self.graph)
        self.refuse()

    def refuse(self) -> None:
        """Say what this formulation does not take.

        Raises:
            DerivationError: the scene has quaternions, or loops or other constraints.
        """
        refuse_quaternions(self.scene)
        if is_tied(self.scene):
            raise DerivationError(
                f"{self.scene.name}: Lagrange's equations (5.21) are of open mechanisms, and this one has constraints; "
                f"{argument('formulation', 'multipliers')} goes on with them, "
                f"{argument('formulation', 'dalembert')} finds all reactions"
            )

    # Derived once

    @cached_property
    def workspace(self) -> Workspace:
        """The scene's decisions about its rows."""
        return Workspace(self.scene)

    @cached_property
    def forms(self) -> ClosedForm:
        """All coefficients in closed form; raises DerivationError where there are none, or none that anyone reads."""
        found = closed_form(self.scene)
        if (terms := sum(len(entry) for row in found.M for entry in row)) > READ:
            raise DerivationError(
                f"{self.scene.name}: a lesson would be longer than anyone reads: k_z has {terms} terms, and {READ} is "
                f"the limit; with fewer moving joints there is one; {argument('format', 'sliders')} is a page that "
                "moves it and shows what every coefficient is worth, and symdyn generate writes the code"
            )
        return found

    @cached_property
    def page(self) -> Printable:
        """What is said of the equations, lengths of struts by names, which it adds to those of the document."""
        page = Printable.of(self.forms, lengths=f"{Letters.LENGTH}:")
        for one in page.lengths.named:
            node = strut_way(self.scene, self.placed, one.struts[0], self.graph)
            self.name(one.name, Letters.LENGTH, *one.index, node=node)
            self.name(one.rate, Letters.LENGTH, *one.index, node=tangents([node], self.state.velocity)[0], dots=1)
        return page

    @cached_property
    def energy(self) -> Energies:
        """K and P by differentiated positions."""
        return Energies.of(self.scene, self.graph)

    @cached_property
    def L(self) -> Expr:
        """The Lagrangian."""
        return self.energy.K - self.energy.P

    @cached_property
    def momenta(self) -> list[Expr]:
        """∂L/∂q̇_i."""
        return gradient(self.L, self.state.qd)

    @cached_property
    def momentum_rates(self) -> list[Expr]:
        """d/dt ∂L/∂q̇_i."""
        return tangents(self.momenta, self.state.acceleration)

    @cached_property
    def slopes(self) -> list[Expr]:
        """∂L/∂q_i."""
        return gradient(self.L, self.state.q)

    @cached_property
    def drives(self) -> list[Expr]:
        """Driving forces M_i of Lagrange's equations."""
        return self.energy.driving_forces()

    @cached_property
    def placed(self) -> dict[str, Transform]:
        """Placement of every body in the ground frame."""
        return body_placements(self.scene, self.graph)

    @cached_property
    def masses(self) -> list[Mass]:
        """Particles and rigid bodies, the ground's side first."""
        return masses(self.scene, self.graph, self.placed)

    def of(self, mass: Mass, whole: bool = False) -> Words:
        """Return what a mass is called behind "of": a particle by its letter, a body by its centre or as a whole."""
        if not mass.particle:
            key = "mass.whole" if whole else "mass.centre" if mass.h is None else "mass.origin"
            return self.say(key, body=mass.body.name)
        letter = Form.of(mass.m)
        if isinstance(letter, Symbol) and sum(one.m == mass.m for one in self.masses) == 1:
            return self.say("mass.point", m=letter)
        return self.say("mass.point.of", body=mass.body.name, tag=mass.tag)

    @cached_property
    def ring(self) -> TrigonometricRing:
        """The ring in which positions, velocities and what is made of them are written.

        A number such as pi or a root may stand where no energy has it: in a place along the axis of a turn.
        """
        needed = [self.graph.symbol(parameter.name) for parameter in self.scene.parameters]
        needed += [x for one in self.masses for x in (one.m, *one.place, *(one.h or ()))]
        needed += [x for one in self.masses for row in one.inertia for x in row]
        needed += vector(self.scene.gravity, self.graph)
        needed += [x for T in self.placed.values() for row in (*T.R, T.p) for x in row]
        for body in self.scene.bodies:  # where nothing moves along it, a mass's place holds what no energy knows
            centre = () if body.com is None else (body.com,)
            for at in (*centre, *(particle.at for particle in body.particles)):
                needed += self.placed[body.name].point(vector(at, self.graph))
        state = (*self.state.q, *self.state.qd, *self.state.qdd)
        return TrigonometricRing([*needed, self.energy.K + self.energy.G], state, self._parallel)

    @cached_property
    def _parallel(self) -> tuple[AngleGroup, ...]:
        return angle_groups(self.scene, self.graph)

    @cached_property
    def _compact(self) -> Compactor:
        return Compactor(self.ring, self._parallel)

    # Forms

    def short(self, node: Expr) -> Form:
        """Return a polynomial in sines of coordinates as short as the ring can write it."""
        return self._compact(self._polynomial(node))

    def vanishes(self, node: Expr) -> bool:
        """Tell whether a node is zero as a function."""
        return self.ring.is_zero(self._polynomial(node))

    @cached_property
    def _polynomial(self) -> Callable[[Expr], Polynomial]:
        return cache(lambda node: evaluate([node], self.ring, self.ring.values([node]))[0])  # reasons ask again

    def number(self, key: str) -> str:
        """Return the equation number of a formula, "" without one."""
        return self.numbers.get(key, "")

    def reference(self, *keys: str) -> str:
        """Return the equation numbers of formulas that have one: "(5.28), (5.29)"."""
        return ", ".join(dict.fromkeys(f"({self.number(key)})" for key in keys if self.number(key)))


def named(node: Expr) -> Symbol:
    """Return a symbol of the graph as a form."""
    return Symbol(str(node.value))


def together(forms: Sequence[Form]) -> Words:
    """Return forms in a row, commas between."""
    return Words(tuple(part for form in forms for part in (", ", form))[1:])


def silent_steps(lesson: Lesson) -> list[Step]:
    """Return the step that names what ties nothing, and why; none where everything ties something."""
    if not lesson.scene.is_constrained:
        return []
    loops = lesson.workspace.loops
    owners = [(one.owner, one.loop) for one in loops.recursive.labels]
    speaking = {owners[k] for k in loops.decisions.independent_rows}
    silent = ", ".join(name for name, loop in dict.fromkeys(owners) if (name, loop) not in speaking)
    claim = lesson.say("ties.silent", joints=silent)
    return [Step("ties.silent", claim, (), lesson.say("ties.silent.reason"))] if silent else []

"""The scene: what the user declared, and nothing derived from it. Frozen, exact, comparable.

Body 0 is the ground. Each moving body hangs on one joint, whose placement reads

    pose of child in parent = origin · motion(q) · tip

with `origin` from the parent's body frame to the joint frame and `tip` from the moved joint frame to the child's body
frame (the identity unless a standard Denavit-Hartenberg table or the user says otherwise).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from symdyn.arguments import check_arguments, native, walked
from symdyn.errors import SceneError, SymdynError, listed
from symdyn.frozen import dataclass, field, fields, replace
from symdyn.graph import Expr, Graph
from symdyn.scene.values.body import UNMOVED, Body, Pose
from symdyn.scene.values.folding import map_quantities, substituted
from symdyn.scene.values.grammar import CLOCK, LETTERS
from symdyn.scene.values.joint import Contact, Element, Joint, JointOrder, Load, Row, Strut, acceleration_name, order_of
from symdyn.scene.values.letters import Input, Letter, Named, Parameter, Signal, StateVariable
from symdyn.scene.values.quantity import Quantity, Vector, spell
from symdyn.scene.values.unilateral import Unilateral
from symdyn.shown import Shown
from symdyn.unlocked import cached_property

NAMING = ("", ".toml", ".par")
"""Endings of files that name their coordinates themselves, or none where Python made the scene."""

STANDARD_GRAVITY: Vector = (Quantity.ZERO, Quantity.ZERO, Quantity.number(Fraction("-9.81")))


@dataclass(frozen=True)
class Point:
    """A named frame fixed to a body, for kinematic outputs."""

    name: str
    body: str
    at: Pose = UNMOVED


_Described = TypeVar("_Described", Parameter, Input, Signal, StateVariable, Body, Joint, Element, "Scene")
DESCRIBED = ("bodies", "joints", "loops", "elements", "parameters", "derived", "inputs", "outputs", "states", "signals")
"""Lists of a scene whose members take a `text`, as the scene does: all but points."""


@dataclass(frozen=True)
class Scene(Shown):
    """A mechanism, checked and in order: every joint comes after the joint of its parent.

    >>> import symdyn
    >>> arm = symdyn.example("two_link")
    >>> arm.coordinates, arm.velocities, [body.name for body in arm.bodies]
    (('q1', 'q2'), ('q1_dot', 'q2_dot'), ['link1', 'link2'])

    Attributes:
        name: used for file and function names.
        parameters: in declared order; those without a value become the argument `params`, in this order.
        gravity: acceleration of free fall in the ground frame, m/s^2.
        bodies: bodies[i] is the child of joints[i].
        joints: parents first; the coordinates q follow this order.
        points: named frames.
        loops: joints that close loops: they carry nothing and have no coordinates.
        elements: what acts beside gravity and drives, in the order of `FORCES`.
        inputs: given over time from outside: the argument `inputs` of generated functions, in this order.
        outputs: formulas with names.
        derived: parameters that are formulas of others, which stand in place of their names.
        states: with formulas for their rates: the argument `internal` of generated functions, in this order.
        signals: formulas with names that others use; they stand in place of their names.
        dimensionless: whether it is without dimensions on purpose, `units = "none"`, so that none is checked.
        source: where it was read from, for messages; not compared.
        text, texts: a description, which lessons are titled with, and it in other languages: ("sk", description).

    Raises:
        SceneError: a field is not what it holds, such as text among the bodies.
    """

    name: str
    parameters: tuple[Parameter, ...] = ()
    gravity: Vector = STANDARD_GRAVITY
    bodies: tuple[Body, ...] = ()
    joints: tuple[Joint, ...] = ()
    points: tuple[Point, ...] = ()
    loops: tuple[Joint, ...] = ()
    elements: tuple[Element, ...] = ()
    inputs: tuple[Input, ...] = ()
    outputs: tuple[Signal, ...] = ()
    derived: tuple[Parameter, ...] = ()
    states: tuple[StateVariable, ...] = ()
    signals: tuple[Signal, ...] = ()
    dimensionless: bool = False
    source: str = field(default="", compare=False)
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()

    GROUND: ClassVar[str] = "ground"
    """The name of body 0, which does not move."""

    def __post_init__(self) -> None:
        if isinstance(self.name, str) and self.name.endswith((".toml", ".urdf", ".xml", ".par")):
            raise SceneError(f'{self.name} is a file, and a Scene is what is in it: symdyn.read("{self.name}")')
        lists = [one.name for one in fields(self) if one.type not in ("str", "bool") and one.name != "texts"]
        vars(self).update(zip(lists, map(Named, walked(Scene, vars(self), *lists, error=SceneError)), strict=True))

    def __repr__(self) -> str:
        free = [one.name for one in self.parameters if one.value is None]
        told = [f"coordinates {listed(self.coordinates)}", f"drives {listed(filter(None, self.drives))}"]
        told += [f"inputs {listed(one.name for one in self.inputs)}"] if self.inputs else []
        told += [f"states {listed(one.name for one in self.states)}"] if self.states else []
        told += [f"parameters without a value {listed(free)}"] if free else []
        bodies = f"{len(self.bodies)} {'body' if len(self.bodies) == 1 else 'bodies'}"
        loops = f", {len(self.loops)} {'loop' if len(self.loops) == 1 else 'loops'}" if self.loops else ""
        return f"<Scene {self.name}: {bodies}{loops}; {'; '.join(told)}>"

    def __str__(self) -> str:
        values = (f"{one.name} = {spell(one.value)} {one.unit}".rstrip() for one in self.parameters if one.value)
        return f"{self!r}\n    {', '.join(values)}".rstrip()

    def __hash__(self) -> int:
        return self._hash

    @cached_property  # what is kept by scenes asks for it many times
    def _hash(self) -> int:
        return hash(tuple(getattr(self, one.name) for one in fields(self) if one.compare))

    def __getstate__(self) -> dict[str, object]:
        return {one.name: getattr(self, one.name) for one in fields(self)}  # a hash of text is that of one process

    @cached_property  # these are asked for joint by joint
    def moving(self) -> tuple[Joint, ...]:
        """The joints that have coordinates, in order of q."""
        return tuple(joint for joint in self.joints if joint.coordinates)

    @cached_property
    def followed(self) -> frozenset[str]:
        """Names of the coordinates that other joints follow."""
        return frozenset(name for joint in self.joints if joint.coupling for name in joint.coupling.coordinates)

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of q, shape (nq,)."""
        return tuple(name for joint in self.joints for name in joint.coordinates)

    @cached_property
    def velocities(self) -> tuple[str, ...]:
        """Names of the velocities, shape (nv,)."""
        return tuple(name for joint in self.joints for name in joint.rates)

    @property
    def first_order(self) -> tuple[str, ...]:
        """Names of what has a formula for its rate, shape (nu,): velocities, and then states of one's own."""
        return (*self.velocities, *(one.name for one in self.states))

    @cached_property
    def drives(self) -> tuple[str | None, ...]:
        """Names of the driving forces, shape (nv,); None where a velocity is passive."""
        return tuple(drive for joint in self.joints for drive in joint.drives or (None,) * len(joint.rates))

    @cached_property
    def prescribed_velocities(self) -> tuple[int, ...]:
        """Numbers of the velocities whose motion is prescribed, ascending."""
        names = {name for joint in self.joints if joint.motion is not None for name in joint.rates}
        return tuple(k for k, name in enumerate(self.velocities) if name in names)

    @cached_property
    def actuated_velocities(self) -> tuple[int, ...]:
        """Numbers of the velocities that have a drive or a prescribed motion, ascending."""
        return tuple(k for k, drive in enumerate(self.drives) if drive or k in self.prescribed_velocities)

    @cached_property
    def passive_velocities(self) -> tuple[int, ...]:
        """Numbers of the other velocities, ascending."""
        return tuple(k for k in range(len(self.velocities)) if k not in self.actuated_velocities)

    @cached_property
    def struts(self) -> tuple[Strut, ...]:
        """The forces along one direction."""
        return tuple(one for one in self.elements if isinstance(one, Strut))

    @cached_property
    def loads(self) -> tuple[Load, ...]:
        """The wrenches on bodies."""
        return tuple(one for one in self.elements if isinstance(one, Load))

    def seated(self, load: Load) -> Load:
        """Return a load with the place that it acts at, where that is the centre of mass of its body."""
        check_arguments(Scene.seated, locals(), SceneError)
        at = next((one.centre for one in self.bodies if load.spread and one.name == load.place.body), load.place.at)
        return replace(load, place=replace(load.place, at=at))

    @cached_property
    def constraints(self) -> tuple[Row, ...]:
        """The constraints on velocities."""
        return tuple(one for one in self.elements if isinstance(one, Row))

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """The constraints that are contacts with planes."""
        return tuple(one for one in self.constraints if isinstance(one, Contact))

    @cached_property
    def unilaterals(self) -> tuple[Unilateral, ...]:
        """The contacts that open and close."""
        return tuple(one for one in self.elements if isinstance(one, Unilateral))

    @cached_property
    def ropes(self) -> tuple[Element, ...]:
        """The ropes that are taut always, elastic ones too."""
        return tuple(one for one in self.elements if one.is_taut and one not in self.unilaterals)

    @cached_property
    def lasting_ropes(self) -> tuple[Row, ...]:
        """The ropes that keep their length, which are constraints."""
        return tuple(one for one in self.constraints if one.is_taut)

    @property
    def is_constrained(self) -> bool:
        """Whether loops, contacts or other constraints constrain it."""
        return bool(self.loops or self.constraints)

    @cached_property
    def free_parameters(self) -> tuple[Parameter, ...]:
        """Parameters without a value: the argument `params` of generated functions, in this order."""
        return tuple(parameter for parameter in self.parameters if parameter.value is None)

    def order(self, names: Sequence[str], quaternion: str = "wxyz") -> JointOrder:
        """Return the joints in the order of another tool, and where its numbers stand in ours.

        >>> import symdyn
        >>> order = symdyn.example("cart_pole").order(["hinge", "rail"])
        >>> order.coordinates, order.q, order.drives
        (('theta', 'x'), array([1, 0]), (None, 'F'))

        Args:
            names: the joints as the other tool lists them, such as `list(model.names)[1:]` of Pinocchio; every one that
                moves by coordinates of its own, each once. Fixed ones may be among them.
            quaternion: how the other orders the coordinates of a quaternion, "wxyz" as here or "xyzw".

        Raises:
            SceneError: a name that no joint has or that stands twice, a joint that is missing, an unknown `quaternion`.
        """
        return order_of(self.joints, names, quaternion)

    def with_gravity(self, gravity: Vector) -> Scene:
        """Return the scene with another acceleration of free fall, m/s^2."""
        return replace(self, gravity=gravity)

    def in_si(self) -> Scene:
        """Return an equal scene that is written in SI, whatever units its writer chose; for what is generated."""
        plain, lists = map_quantities(self, lambda one: replace(one, unit="")), ("parameters", "derived", "inputs")
        every: Any = {n: tuple(replace(one, written="") for one in getattr(plain, n)) for n in lists}
        return replace(plain, **every)

    def in_language(self, code: str) -> Scene:
        """Return the scene with every description in a language, such as "sk", where it has it."""
        check_arguments(Scene.in_language, locals(), SceneError)

        def described(one: _Described) -> _Described:
            return replace(one, text=dict(one.texts).get(code, one.text))

        every: dict[str, Any] = {name: tuple(map(described, getattr(self, name))) for name in DESCRIBED}
        return replace(described(self), **every)

    def in_numbers(self, names: Collection[str]) -> Scene:
        """Return the scene with the values of these parameters in place of their names in every formula."""
        check_arguments(Scene.in_numbers, locals(), SceneError)
        values = {p.name: p.value for p in self.parameters if p.value is not None and p.name in names}
        return self.substituted(values)

    def as_parameters(self) -> Scene:
        """Return the scene without outputs, its inputs and states being parameters: for its equations at one moment.

        One whose value is zero has none then, so that it is seen where it acts. Rates of states become derived.
        """
        if not self.given:
            return replace(self, outputs=()) if self.outputs else self
        known = {one.name: one.value for one in self.parameters if one.value is not None}
        values = {x: substituted(x.value, known) for x in self.given}
        shown = {x: None if value == Quantity.ZERO or value.symbols else value for x, value in values.items()}
        more = tuple(Parameter(x.name, shown[x], False, x.unit, x.latex, x.text, x.texts, of=x.of) for x in self.given)
        told = {acceleration_name(x.name): x.rate for x in self.states} | {x.name: x.formula for x in self.signals}
        scene = replace(self, derived=(*self.derived, *(Parameter(x, formula) for x, formula in told.items())))
        return replace(scene, parameters=(*self.parameters, *more), inputs=(), outputs=(), states=(), signals=())

    def without_mechanism(self) -> Scene:
        """Return the scene's states alone: coordinates and velocities are further inputs, and nothing moves."""
        inputs = (*self.inputs, *map(Input, (*self.coordinates, *self.velocities)))
        return replace(self, bodies=(), joints=(), points=(), loops=(), elements=(), outputs=(), inputs=inputs)

    @cached_property
    def derived_formulas(self) -> dict[str, Quantity]:
        """The formulas of derived parameters in plain ones, by name; they stand in place of the names."""
        return {one.name: one.value for one in self.derived if one.value is not None}

    @cached_property
    def definitions(self) -> dict[str, Quantity]:
        """The formulas of derived parameters and of signals, by name; they stand in place of the names."""
        return self.derived_formulas | {one.name: one.formula for one in self.signals}

    @property
    def letters(self) -> tuple[Letter, ...]:
        """Parameters, inputs and states."""
        return (*self.parameters, *self.inputs, *self.states)

    @property
    def given(self) -> tuple[Input | StateVariable, ...]:
        """Inputs and states: what a function is told beside the motion and the time."""
        return (*self.inputs, *self.states)

    @property
    def rates(self) -> dict[str, str]:
        """Names of rates of inputs, by what they are rates of: {"road": "road_dot", "road_dot": "road_ddot"}."""
        letters: tuple[Letter, ...] = (*self.inputs, *self.parameters)
        return {one.of: one.name for one in letters if one.of}

    @cached_property
    def supports(self) -> tuple[tuple[Strut, Vector], ...]:
        """Where ends of struts are that move as they are told, by time or by inputs, each behind its strut."""
        told = {CLOCK, *self.rates}
        ends = ((strut, end.at) for strut in self.struts for end in strut.ends)
        return tuple((strut, at) for strut, at in ends if any(told.intersection(x.symbols) for x in at))

    def refuse_states(self, what: str, error: type[SymdynError] = SceneError) -> None:
        """Raise an error where there are states of one's own, or contacts, of which something knows nothing."""
        check_arguments(Scene.refuse_states, locals(), SceneError)
        if self.states:
            names = listed(one.name for one in self.states)
            raise error(f"{self.name}: {what} knows no states of one's own, and there is {names}; take them out")
        self.refuse_contacts(what, error)

    def refuse_contacts(self, what: str, error: type[SymdynError] = SceneError) -> None:
        """Raise an error where contacts open and close, of which something knows nothing."""
        if self.unilaterals:
            names = listed(one.name for one in self.unilaterals)
            other = 'take them out, or hold them closed by [constraints] of type "rolling"'
            raise error(f"{self.name}: {what} knows no contacts that open and close, and there is {names}; {other}")
        if free := [one.name for one in self.joints if one.limits.one_way]:
            raise error(f"{self.name}: {what} knows no joint that moves one way, as {free[0]}; take limits.one_way out")

    def derived_words(self, name: str) -> str:
        """Return why a derived parameter takes no value; "" of another name."""
        check_arguments(Scene.derived_words, locals(), SceneError)
        formula = self.derived_formulas.get(name)
        return f"{name} is derived, {name} = {spell(formula)}; give {listed(formula.symbols)}" if formula else ""

    def held(self, but: Collection[str] = ()) -> Scene:
        """Return the scene without outputs, inputs `but` some being their values; FormulaError where one has none."""
        values = {one.name: one.value for one in self.inputs if one.name not in but}
        return replace(self, inputs=tuple(x for x in self.inputs if x.name in but), outputs=()).substituted(values)

    def formula_names(self, specified: Iterable[str] = ()) -> tuple[str, ...]:
        """Return the names that formulas may use, parameters aside; of `specified`, multipliers are known later."""
        (specified,) = walked(Scene.formula_names, locals(), "specified", error=SceneError)
        accelerations = map(acceleration_name, self.velocities)
        drives = (drive for drive in self.drives if drive)
        late = (name for name in specified if name.startswith(LETTERS.multiplier) and self.is_constrained)
        pulls = (f"{LETTERS.tension}{one.name}" for one in self.ropes)
        points = (name for one in self.points for name in LETTERS.of_point(one.name))
        struts = LETTERS.of_struts(self.struts)
        names = (*self.plain_names, *accelerations, *drives, *points, *struts, *LETTERS.energies)
        return tuple(dict.fromkeys((*names, *pulls, *self.reaction_axes, *late)))

    @property
    def plain_names(self) -> tuple[str, ...]:
        """Names of time, coordinates, velocities, inputs and states, which need no derivation."""
        return (CLOCK, *self.coordinates, *self.velocities, *(one.name for one in self.given))

    def at_time(self, graph: Graph, t: float = 0.0) -> dict[Expr, float]:
        """Return the values of time, s, of inputs where none are given over time, and of states at the start."""
        check_arguments(Scene.at_time, locals(), SceneError)
        (t,) = native(float, t)
        known = {one.name: value for one in self.parameters if one.value and (value := one.value.at({})) is not None}
        values = {graph.symbol(one.name): float(one.value.known_at(known) or 0) for one in self.given}
        return {graph.symbol(CLOCK): t} | values

    def clock(self, graph: Graph) -> dict[Expr, Expr]:
        """Return seeds of d/dt for inputs that have rates, and for t where an end of a strut moves with it."""
        seeds = {graph.symbol(name): graph.symbol(rate) for name, rate in self.rates.items()}
        timed = any(CLOCK in x.symbols for _, at in self.supports for x in at)
        return seeds | ({graph.symbol(CLOCK): graph.one} if timed else {})

    @property
    def point_names(self) -> list[str]:
        """The names of coordinates of declared points, three a point."""
        return [name for one in self.points for name in LETTERS.of_point(one.name)[:3]]

    @property
    def reaction_axes(self) -> dict[str, str]:
        """The axes of every component of a reaction, by its name."""
        return {
            f"{LETTERS.reaction}{joint.name}_{component}{'' if axes == LETTERS.axes[0] else f'_{axes}'}{loose}": axes
            for axes in LETTERS.axes
            for joint in (*self.joints, *self.loops)
            for component in LETTERS.components
            for loose in ("", LETTERS.loose)
        }

    @cached_property  # every event asks for it
    def changing(self) -> tuple[str, ...]:
        """Names of the states that masses and inertias are made of."""
        used = {name for body in self.bodies for x in (body.mass, *body.inertia) for name in x.symbols}
        return tuple(one.name for one in self.states if one.name in used)

    @property
    def leaves(self) -> tuple[str, ...]:
        """The bodies that carry no other body: hands, tools, feet."""
        carrying = {joint.parent for joint in self.joints} | {Scene.GROUND}
        return tuple(body.name for body in self.bodies if body.name not in carrying)

    def coordinates_of_joints(self, most: int | None = None) -> str:
        """Return which joint each coordinate of a robot file belongs to: "q1 shoulder, q2 elbow"; "" of other scenes.

        Such a file names joints and links; coordinates are called q1, q2, ...
        """
        if Path(self.source).suffix.lower() in NAMING:
            return ""
        runs = [(one.coordinates[0], *one.coordinates[1:][-1:]) for one in self.moving[:most]]
        named = [f"{' ... '.join(run)} {one.name}" for run, one in zip(runs, self.moving, strict=False)]
        more = len(named) < len(self.moving)
        return ", ".join([*named, *([f"... ({len(self.moving)} joints in all)"] if more else [])])

    @property
    def moving_names(self) -> set[str]:
        """The names of coordinates, velocities, drives, inputs, states, signals and outputs."""
        names = {*self.coordinates, *self.velocities, *(one.name for one in self.given)}
        names |= {one.name for one in (*self.outputs, *self.signals)}
        return names | {drive for drive in self.drives if drive}

    def substituted(self, values: Mapping[str, Quantity]) -> Scene:
        """Return the scene with quantities in place of symbols in every formula.

        Raises:
            FormulaError: a formula has no value then.
        """
        check_arguments(Scene.substituted, locals(), SceneError)
        return map_quantities(self, lambda one: substituted(one, values)) if values else self

    def shown_unit(self, unit: str) -> str:
        """Return a unit that is implied, of a joint, a time or an energy, as it is shown: "" without dimensions."""
        return "" if self.dimensionless else unit

    def in_shown_unit(self, number: str, unit: str) -> str:
        """Return a number and such a unit as text, the number alone where none is shown."""
        check_arguments(Scene.in_shown_unit, locals(), SceneError)
        return f"{number} {self.shown_unit(unit)}".rstrip()

"""Rows of the table of outputs: each says what it is in loops, and every field is true of it; without it a test fails.

A check takes a row by its name and looks at what is derived. Checks pass for the table as it is; for a row that lacks
one of its fields the check of this field fails, and names the row.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import MISSING, fields, replace
from fractions import Fraction
from functools import cache
from hashlib import sha256
from itertools import zip_longest
from pathlib import Path

import pytest
from arms import chain, turning_chain, two_link

import symdyn
from symdyn.bench.reference import linear
from symdyn.bench.time_and_error import comparable
from symdyn.dynamics import OUTPUTS, Formulation, LoopChoices, Output, Workspace, derive_one, formulations_of, row_of
from symdyn.dynamics.loops import Numbers
from symdyn.dynamics.mechanism.state import has_motion
from symdyn.dynamics.outputs import Counts
from symdyn.dynamics.outputs.arm_outputs import ARMS
from symdyn.dynamics.outputs.canonical_outputs import CANONICAL
from symdyn.dynamics.outputs.configuration_outputs import CONFIGURATIONS
from symdyn.dynamics.outputs.contact_outputs import CONTACTS as OPENING
from symdyn.dynamics.outputs.derivative_outputs import derivatives
from symdyn.dynamics.outputs.held_outputs import HELD
from symdyn.dynamics.outputs.linearizing_outputs import LINEARIZING as LINEARIZED, SHAPING
from symdyn.dynamics.outputs.operator_outputs import OPERATORS
from symdyn.dynamics.outputs.output import Constrained
from symdyn.dynamics.outputs.output_table import CENTROIDAL
from symdyn.dynamics.outputs.regressor_outputs import PASSIVITY, REGRESSORS
from symdyn.dynamics.outputs.signal_outputs import SIGNALS
from symdyn.errors import DerivationError
from symdyn.graph import reachable
from symdyn.scene import Quantity, Scene, bind, read, read_text
from symdyn.scene.forces.ropes import ElasticRope
from symdyn.scene.scene_files import Starter
from symdyn.scene.values import Place, acceleration_name
from symdyn.scene.values.joint import Plane
from symdyn.scene.values.letters import Reset, Signal, StateVariable
from symdyn.scene.values.unilateral import PlaneContact
from symdyn.verdict import Verdict
from symdyn.verify import certify, laws, prove

EXAMPLES = Path(__file__).parent.parent / "examples"
DEFAULTS = {one.name: one.default for one in fields(Output) if one.default is not MISSING}
OPTIONAL = tuple(DEFAULTS)


@cache
def scene(name: str) -> Scene:
    """Return an example."""
    return read(EXAMPLES / f"{name}.toml")


def request(name: str, one: Scene) -> str:
    """Return how an output is asked for, of the last body if it is of one."""
    place = OUTPUTS[name].place
    of = {"output": "seen", "rope": "cord", "contact": "seat"}.get(place, one.bodies[-1].name)
    return f"{name}:{of}" if place else name


LINEARIZING, CONTACTS = {**LINEARIZED, **SHAPING}, {**OPENING, **HELD}
ALONG = ("output_rates", "output_rate", "decoupling_matrix", "decoupling_row", "damping_forces", "shaping_forces")
"""What outputs of a scene do along its motion."""
LED = tuple(name for name in LINEARIZING if name not in ALONG)


def looked(name: str, one: Scene) -> Scene:
    """Return the scene, for rows about what a scene declares to look at with its first acceleration, or velocity.

    Routh's function is of a scene without weight whose first coordinate is free, and so cyclic; of feedback
    linearisation every other coordinate is.
    """
    moves = one.velocities[0] if name in LINEARIZING else acceleration_name(one.velocities[0])
    seen = (Signal("seen", Quantity.symbol("kinetic_energy" if name == "shaping_forces" else moves)),)
    ends = (Place(Scene.GROUND, (Quantity.ONE, Quantity.ONE, Quantity.ONE)), Place(one.bodies[-1].name))
    cord = ElasticRope("cord", ends=ends, stiffness=(Quantity.ONE,))
    one = replace(one, elements=(*one.elements, cord)) if OUTPUTS[name].place == "rope" else one
    if name in CONTACTS:
        at = replace(ends[0], body=one.bodies[-1].name)  # no rows that hold the same, and what moves
        leans = Plane() if name in HELD else Plane(normal=(Quantity.ZERO, Quantity.ONE, Quantity.ONE))
        one = replace(one, elements=(*one.elements, PlaneContact("seat", place=at, plane=leans)))
    if name in ("state_rates", "resets"):
        rate = Quantity.symbol(one.velocities[0])
        one = replace(one, states=(StateVariable("kept", rate, reset=Reset(rate) if name == "resets" else None),))
    if name == "routhian":
        first, *rest = one.joints
        still = (Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)
        one = replace(one, gravity=still, joints=(replace(first, drives=(None,) * len(first.rates)), *rest))
    if name in LED and not one.is_constrained:
        free = (replace(joint, drives=(None,) * len(joint.rates)) for joint in one.joints[::2])
        one = replace(one, joints=tuple(x for pair in zip_longest(free, one.joints[1::2]) for x in pair if x))
    return replace(one, outputs=seen) if name in (*SIGNALS, *ALONG) else one


def at_work(name: str, one: Scene, closing: LoopChoices | None = None) -> Workspace:
    """Return a workspace of a scene that an output is about."""
    return Workspace(looked(name, one), closing or LoopChoices())


def entries(name: str, one: Scene, formulation: str | None = None) -> tuple:
    """Return the entries of an output."""
    w = at_work(name, one)
    return derive_one(w, request(name, w.scene), formulation).entries


def of_trees(name: str) -> bool:
    """Whether trees have an output."""
    return OUTPUTS[name].when_constrained != "only"


def with_formulations(row: Output, found: dict[str, Formulation], closed: bool) -> Output:
    """Return a row with other formulations, of closed scenes where it has such."""
    if closed and isinstance(row.when_constrained, Constrained):
        return replace(row, when_constrained=replace(row.when_constrained, formulations=found))
    return replace(row, formulations=found)


# Four words, or a row


@pytest.mark.parametrize("name", OUTPUTS)
def test_every_row_says_what_it_is_where_loops_close(name: str) -> None:
    row, one = OUTPUTS[name], scene("four_bar")
    assert "when_constrained" not in OPTIONAL
    assert isinstance(row.when_constrained, Constrained) or row.when_constrained in ("same", "tree", "refuse", "only")
    assert not isinstance(row.constrained.when_constrained, Constrained)
    if row.when_constrained == "refuse":
        with pytest.raises(DerivationError, match=f"{name}(:\\w+)? is about trees; loops or rows close four_bar"):
            entries(name, one)
        return
    one = looked(name, one)
    function = derive_one(Workspace(one), request(name, one))
    of_tree = row.when_constrained == "tree"
    assert of_tree == function.name.startswith("tree_") or name == "tree_forces", name
    assert of_tree == function.text.endswith("; of the spanning tree, as if nothing closed it"), name
    if of_trees(name):
        plain = looked(name, two_link())
        alone = derive_one(Workspace(plain), request(name, plain))
        assert not alone.name.startswith("tree_")
        assert "spanning tree" not in alone.text


@pytest.mark.parametrize("name", [name for name, row in OUTPUTS.items() if row.when_constrained == "tree"])
def test_what_is_of_the_tree_is_that_of_the_scene_whose_loops_are_taken_away(name: str) -> None:
    closed = scene("slider_crank")
    w, opened = Workspace(closed), Workspace(replace(closed, loops=()))

    assert printed(w, name) == printed(opened, name)


def printed(w: Workspace, name: str) -> list[str]:
    """Return entries as text of their operations, which two graphs have in common."""
    texts: dict[object, str] = {}
    found = derive_one(w, request(name, w.scene)).entries
    for node in reachable(found):
        text = f"{node.op.name}{node.value}({','.join(sorted(texts[arg] for arg in node.args))})"
        texts[node] = sha256(text.encode()).hexdigest()
    return [texts[node] for node in found]


def test_a_row_without_a_word_is_no_row() -> None:
    with pytest.raises(TypeError, match="when_constrained"):
        Output("power", (), "P", (), "W", formulations={})  # type: ignore[call-arg]
    with pytest.raises(AssertionError, match="none of"):
        Output("power", (), "P", (), "W", "perhaps", {})  # type: ignore[arg-type]


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [name for name, row in OUTPUTS.items() if row.when_constrained not in ("same", "tree", "refuse")]
)
def test_a_row_of_closed_scenes_that_says_it_is_the_same_fails(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    check = only if OUTPUTS[name].when_constrained == "only" else own
    check(name)
    monkeypatch.setitem(OUTPUTS, name, replace(OUTPUTS[name], when_constrained="same"))
    with pytest.raises((AssertionError, DerivationError, pytest.fail.Exception)):
        check(name)


@pytest.mark.runs
def test_who_asks_for_a_matrix_of_a_closed_scene_gets_that_of_the_tree() -> None:
    found = symdyn.load(scene("four_bar"), ["mass_matrix"])

    assert list(found.calls) == ["tree_mass_matrix"]
    assert found["mass_matrix"] is found["tree_mass_matrix"] is found.tree_mass_matrix


# Every field is true


MASSLESS = """
[bodies.arm]
mass = 1
com = [1, 0, 0]
[bodies.ghost]
[joints.a]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 0, 1]
[joints.b]
type = "revolute"
parent = "arm"
child = "ghost"
axis = [0, 0, 1]
"""


LOOKED_AT = ("inverse_dynamics", "mass_matrix", "forward_dynamics", "gravity_forces")
"""What benchmarks compare with peers."""


@cache
def lacking() -> tuple[Scene, ...]:
    """Return an end without mass or weight, one with a motion before it, a loop too far, one with too many drives."""
    four = scene("four_bar")
    led = read_text(MASSLESS.replace("[joints.b]", 'motion = "2*t"\n[joints.b]'), "led.toml")
    nowhere = read_text(MASSLESS.replace("[bodies.ghost]", "[bodies.ghost]\nfirst_moment = [0, 0, 0]"), "ghost.toml")
    nowhere = nowhere.with_gravity((Quantity.ZERO,) * 3)
    drives = tuple(replace(joint, drives=(f"tau{k}",)) for k, joint in enumerate(four.joints))
    return nowhere, led, bind(four, {"d": "40"}), replace(four, joints=drives)


FIVE = Fraction(5)


CART = """
[bodies.cart]
mass = 1
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
motion = "t**2/9"
[joints.motor]"""


@cache
def led_four_bar() -> Scene:
    """Return a four-bar whose crank hangs on a cart that is led: one more freedom than that of the crank."""
    text = (EXAMPLES / "four_bar.toml").read_text(encoding="utf-8")
    before, motor = text.split("[joints.motor]")
    return read_text(before + CART + motor.replace('parent = "ground"', 'parent = "cart"', 1), "four_bar.toml")


def may_fail(name: str) -> None:
    """Some scene lacks what a scene may lack; all else each has."""
    missing = []
    for one in lacking():
        if one.is_constrained or of_trees(name):
            try:
                entries(name, one)
            except DerivationError as fault:
                missing.append((one.name, str(fault)))
    if name == "gap":
        missing.append(of_rates())
    assert (OUTPUTS[name].may_fail != "never") == bool(missing), (name, missing)


def of_rates() -> str:
    """Return why a joint that moves one way, whose law is of rates, has no gap."""
    first, *rest = chain(2).joints
    one = replace(chain(2), joints=(replace(first, limits=replace(first.limits, one_way=True)), *rest))
    with pytest.raises(DerivationError, match="is a law of rates") as told:
        derive_one(Workspace(one), f"gap:{first.name}_one_way")
    return str(told.value)


def own(name: str) -> None:
    """A row of its own has other formulations than that of trees, and other entries."""
    row = OUTPUTS[name]
    assert isinstance(row.when_constrained, Constrained), name
    assert not set(row.formulations.values()) & set(row.constrained.formulations.values()), name


def only(name: str) -> None:
    """What only closed scenes have is refused of trees."""
    with pytest.raises(DerivationError, match=f"{name} is about closed loops and rows, of which two_link has none"):
        entries(name, two_link())


def place(name: str) -> None:
    """What is about a body or a point names it."""
    with pytest.raises(DerivationError, match=f"{name} needs an? {OUTPUTS[name].place}; write {name}:NAME"):
        derive_one(Workspace(two_link()), name)


def exists(name: str) -> None:
    """A scene is not given what is nothing of it: zeros, or an argument as it came."""
    plain = two_link()
    assert not OUTPUTS[name].exists(plain), f"{name}: {plain.name} has it"
    missing = {
        "routhian": "no coordinate is cyclic",
        "tension": r"there is no rope 'y' in \[ropes\]",
        "resets": "two_link has no resets",
    }
    missing |= dict.fromkeys(LED, "two_link: every joint is driven")
    missing |= dict.fromkeys(CONTACTS, r"two_link has no contacts; declare one, such as \[contacts.floor\]")
    if name == "state_rates":  # of a scene without states it is what forward dynamics gives, behind velocities
        return
    if name in {*SIGNALS, *LINEARIZING, *CONTACTS, "routhian"}:
        none = missing.get(name, r"two_link has no outputs; declare one, such as \[outputs.y\]")
        with pytest.raises(DerivationError, match=none):
            derive_one(Workspace(plain), f"{name}:y" if OUTPUTS[name].place else name)
        return
    function = derive_one(Workspace(plain), name)
    nothing = all(x.is_zero for x in function.entries)
    assert nothing or function.entries in [one.symbols for one in function.arguments], name


UNWRITTEN = {
    *CENTROIDAL, *REGRESSORS, *PASSIVITY, *CANONICAL, *LINEARIZING, *CONTACTS, *OPERATORS, *CONFIGURATIONS, *ARMS,
    "velocity", "acceleration", "constraint_forces", "resets",
}  # fmt: skip


def default_in(name: str) -> None:
    """A first look shows what benchmarks compare; coefficients are large; no one writes reactions, and of bodies, or of
    the centre of mass, or functions of other formulations."""
    row = OUTPUTS[name]
    assert (row.default_in == "overview") == (name in LOOKED_AT), name
    assert (row.default_in == "generate") == (name.startswith("k_") or row.cubic), name
    unwritten = row.unique is not None or row.place == "body" or name in UNWRITTEN
    assert (not row.is_default_in("generate")) == unwritten, name
    of_verify = row.place == "body" or name in {"reactions", *OPENING}
    assert (row.default_in == "verify") == of_verify, f"{name}: a row about a body or contacts is of verify alone"


def cubic(name: str) -> None:
    """Twice the coordinates take at least five times the operations, of others less, by the first formulation."""
    first = next(iter(OUTPUTS[name].formulations))
    sizes = [len(reachable(entries(name, chain(n), first))) for n in (4, 8)]
    assert OUTPUTS[name].cubic == (sizes[1] >= 5 * sizes[0]), (name, sizes)


def depends(name: str) -> None:
    """Formulas change with the choices that they depend on, and with no others; the text says which."""
    some, independent = tied(name)
    choices = {
        "independent": LoopChoices(independent),
        "alpha": LoopChoices(alpha=FIVE),
        "beta": LoopChoices(beta=FIVE),
    }
    for choice, closing in choices.items():
        truly = choice in OUTPUTS[name].depends
        usual, chosen = ([printed(at_work(name, one, how), name) for one in some] for how in (LoopChoices(), closing))
        assert (usual != chosen) == truly, f"{name}: {choice}"
        first = looked(name, some[0])
        said = derive_one(Workspace(first, closing), request(name, first)).text
        assert (f"; {closing.words}" in said) == truly, f"{name}: {choice}"


def tied(name: str) -> tuple[list[Scene], tuple[str, ...]]:
    """Return closed scenes that have an output, and other independent coordinates than those that are taken."""
    four = scene("four_bar")
    if OUTPUTS[name].exists is has_motion:
        return [led_four_bar()], ("x", "chi")
    undriven = replace(four, joints=tuple(replace(joint, drives=(None,)) for joint in four.joints))
    return [four] if name.startswith("reactions") else [four, undriven], ("chi",)


def prefer(name: str) -> None:
    """For a chain, a top or a ball on a crank another formulation than the first is generated from."""
    first = next(iter(OUTPUTS[name].formulations))
    some = (chain(6), scene("heavy_top"), scene("rssr"))
    assert any(row_of(name, one)[0].preferred(Workspace(one)) != first for one in some), name


def compared(name: str) -> None:
    """Formulations agree on what is no choice."""
    row, w = OUTPUTS[name], Workspace(scene("four_bar"))
    assert row.compared is not None, name
    words, of = row.compared
    assert len(of(w, derive_one(w, name).entries)) == w.state.n, name
    assert words.endswith(name)


def unique(name: str) -> None:
    """Entries that rigid bodies do not tell are marked."""
    function = derive_one(Workspace(scene("four_bar")), name)
    assert function.unique.count(False) == 12, name
    assert "fz, mx, my of motor, elbow, pivot and hinge" in function.text or ":" in name, name


def solves(name: str) -> None:
    """Benchmarks know the linear equations that are solved, of trees and of closed scenes."""
    assert [len(linear(one, name)) for one in (two_link(), scene("four_bar"))] == [2, 4], name


def multiplies(name: str) -> None:
    """What all coefficients multiply adds up to what drives of the tree exert, springs and gravity included."""
    w = Workspace(scene("governor"))
    _, (finding,) = prove(laws(w, ("tree_forces", "k_z", "k_C", "k_D", "k_G")))
    assert finding.verdict == Verdict.PROVED, name


def remark(name: str) -> None:
    """The text says of a scene what no other scene has."""
    one = looked(name, two_link())
    moves = {"shaping_forces": "kinetic_energy", **dict.fromkeys(ALONG[:-1], "q1_dot")}
    said = "cyclic: q1" if name == "routhian" else f"seen = {moves.get(name, 'q1_ddot')}"
    assert said in derive_one(Workspace(one), request(name, one)).text, name


def size(name: str) -> None:
    """What it takes is told beforehand, of joints that turn every way, within a factor of two."""
    n = 12 if "regressor" in name else 20
    told = OUTPUTS[name].size.of(range(1, n + 1))
    assert 0.5 < told / counted(name, n) < 2, name


@cache
def counted(name: str, n: int) -> int:
    return Counts.of(derive_one(at_work(name, turning_chain(n)), name)).cost


def moved(name: str) -> None:
    """Derivatives go along what moves it beside its arguments."""
    w = at_work(name, two_link())
    assert derivatives(name, OUTPUTS[name]).axes[1](w)[-1] == w.scene.states[-1].name, name


CHECKS: dict[str, Callable[[str], None]] = {
    check.__name__: check
    for check in (
        may_fail,
        place,
        exists,
        default_in,
        cubic,
        depends,
        prefer,
        compared,
        unique,
        solves,
        moved,
        multiplies,
        remark,
        size,
    )
}


SAMPLED = [name for name, row in OUTPUTS.items() if row.place != "rope"]
"""A rope of the scenes here is elastic, and depends on fewer things than one that keeps its length: test_ropes.py."""


@pytest.mark.heavy("base_regressor", "k_D")
@pytest.mark.wide(5)
@pytest.mark.long
@pytest.mark.parametrize("name", SAMPLED)
def test_every_field_of_a_row_is_true(name: str) -> None:
    for field in OPTIONAL:
        if told(OUTPUTS[name], field):
            CHECKS[field](name)


@pytest.mark.wide(5)
@pytest.mark.long
@pytest.mark.parametrize("name", SAMPLED)
def test_a_row_that_loses_a_field_fails_the_check_of_this_field(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    row = OUTPUTS[name]
    for field in OPTIONAL:
        if told(row, field):
            monkeypatch.setitem(OUTPUTS, name, replace(row, **{field: DEFAULTS[field]}))
            with pytest.raises((AssertionError, TypeError, DerivationError, pytest.fail.Exception)):
                CHECKS[field](name)
            monkeypatch.setitem(OUTPUTS, name, row)


@pytest.mark.wide(5)
@pytest.mark.long
@pytest.mark.parametrize("check", [may_fail, cubic, depends, default_in])
@pytest.mark.parametrize("name", OUTPUTS)
def test_what_a_row_does_not_say_is_not_so(name: str, check: Callable[[str], None]) -> None:
    """The other way round: a row that leaves a field alone has nothing to say there."""
    if not told(OUTPUTS[name], check.__name__) and applies(name, check.__name__):
        check(name)


def told(row: Output, field: str) -> bool:
    """Whether a row says something in a field."""
    return getattr(row, field) is not DEFAULTS[field] and getattr(row, field) != DEFAULTS[field]


def applies(name: str, field: str) -> bool:
    """Whether the scene of a check has the output."""
    row = OUTPUTS[name]
    if field == "cubic":
        return of_trees(name) and row.exists(chain(4)) and row.is_default_in("generate")
    if field == "may_fail":
        return True
    return row.exists_in(looked(name, scene("four_bar")))


GROWING = [name for name, row in OUTPUTS.items() if "lagrange" in row.formulations and row.place != "rope"]
"""Of an elastic rope, which all scenes here take, it is short; of one that keeps its length it grows."""


@pytest.mark.wide(5)
@pytest.mark.parametrize("name", GROWING)
def test_formulations_that_grow_fast_are_not_measured_for_six_coordinates(name: str) -> None:
    one = looked(name, scene("puma560"))
    if not of_trees(name) or not OUTPUTS[name].exists(one):
        return
    w = Workspace(one)
    size = len(reachable(derive_one(w, request(name, one), "lagrange").entries))
    assert ("lagrange" in comparable(one, request(name, one))) == (size < 750), (name, size)


# Every field of a formulation is true

SAYING = [
    (field.name, name, way, closed)
    for name, row in OUTPUTS.items()
    for closed in ([False, True] if isinstance(row.when_constrained, Constrained) else [False])
    for way, formulation in (row.constrained.formulations if closed else row.formulations).items()
    for field in fields(Formulation)
    if field.default is not MISSING and getattr(formulation, field.name) != field.default
]


def trees_only(name: str, way: str, closed: bool) -> None:
    """What only trees have is no formulation of a scene with a prescribed motion, which it does not know."""
    led = read_text(MASSLESS.replace("[bodies.ghost]", "[bodies.ghost]\nmass = 1\ncom = [1, 0, 0]"), "led.toml")
    led = replace(led, joints=tuple(replace(joint, motion=Quantity.number(0)) for joint in led.joints))
    assert way not in formulations_of(name, led), way


def up_to(name: str, way: str, closed: bool) -> None:
    """A formulation beyond what it pays for is not measured, and its formulas are no shorter."""
    row = OUTPUTS[name].constrained if closed else OUTPUTS[name]
    most = min(8, row.formulations[way].up_to)
    five = Starter("row").from_template("n_four_bar", 5)
    one = (
        read_text(five)
        if closed or not of_trees(name)
        else turning_chain(int(most) + 1)
        if name == "impact"  # what moves along the normal
        else chain(int(most) + 1 + (name in LED))  # as many passive as driven
    )
    w = at_work(name, one)
    asked = request(name, w.scene)
    assert way not in comparable(w.scene, asked), way
    sizes = [
        len(reachable(derive_one(w, asked, formulation).entries)) for formulation in (next(iter(row.formulations)), way)
    ]
    assert sizes[0] <= sizes[1], (way, sizes)


def loop(name: str, way: str, closed: bool) -> None:
    """What goes over a table of numbers is no formulation of a scene whose parameters have no value."""
    assert way not in formulations_of(name, two_link()), way


@pytest.mark.heavy("base_regressor")
@pytest.mark.wide(5)
@pytest.mark.long
@pytest.mark.parametrize(("field", "name", "way", "closed"), SAYING)
def test_a_formulation_that_loses_a_field_fails_the_check_of_this_field(
    field: str, name: str, way: str, closed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    check = {"trees_only": trees_only, "up_to": up_to, "loop": loop}[field]
    check(name, way, closed)
    row = OUTPUTS[name]
    default = next(one.default for one in fields(Formulation) if one.name == field)
    formulations = (row.constrained if closed else row).formulations
    lost = {**formulations, way: replace(formulations[way], **{field: default})}
    monkeypatch.setitem(OUTPUTS, name, with_formulations(row, lost, closed))
    with pytest.raises(AssertionError, match=way):
        check(name, way, closed)


# Each formulation once, and none reads what another derived


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.long(0)
def test_each_formulation_is_derived_once_and_loops_are_closed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    derived: Counter[tuple[str, str, int, Workspace]] = Counter()
    closed: Counter[str] = Counter()
    close = Numbers.decided

    def counted(name: str, way: str, formulation: Formulation) -> Formulation:
        def derive(w: Workspace, *asked: str) -> object:
            derived[name, way, hash(asked), w] += 1
            return formulation.derive(w, *asked)

        return replace(formulation, derive=derive)

    def closes(*given: object) -> object:
        closed["loops"] += 1
        return close(*given)  # type: ignore[arg-type]

    for name, row in OUTPUTS.items():
        formulations_of = {way: counted(name, way, formulation) for way, formulation in row.formulations.items()}
        of_loops = {
            way: counted(name, f"closed {way}", formulation)
            for way, formulation in row.constrained.formulations.items()
        }
        known = with_formulations(row, formulations_of, closed=False)
        own = isinstance(row.when_constrained, Constrained)
        monkeypatch.setitem(OUTPUTS, name, with_formulations(known, of_loops, closed=True) if own else known)
    monkeypatch.setattr(Numbers, "decided", closes)

    assert certify(scene("four_bar")).passed
    assert closed["loops"] == 1
    assert len(derived) > 40
    assert [one for one, times in derived.items() if times > 1] == []


def faulty(formulation: Formulation) -> Formulation:
    """Return a formulation that is wrong in its first entry."""

    def derive(w: Workspace, *asked: str) -> list[object]:
        first, *rest = formulation.derive(w, *asked)
        return [first + w.state.q[0], *rest]

    return replace(formulation, derive=derive)


@pytest.mark.wide(6)
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.long
@pytest.mark.parametrize("name", [name for name, row in OUTPUTS.items() if len(row.formulations) > 1])
def test_a_fault_in_any_one_formulation_fails_the_certificate(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    row = OUTPUTS[name]
    some = (two_link(), scene("four_bar"), led_four_bar(), scene("heavy_top"), scene("governor"))
    one = next(one for one in (looked(name, each) for each in some) if row.exists_in(one))
    assert certify(one, (request(name, one),)).passed
    known = row.constrained if one.is_constrained else row
    for way in formulations_of(request(name, one), one):
        wrong = {**known.formulations, way: faulty(known.formulations[way])}
        monkeypatch.setitem(OUTPUTS, name, with_formulations(row, wrong, one.is_constrained))
        assert not certify(one, (request(name, one),)).passed, way


def test_a_name_that_closed_scenes_show_tells_what_to_ask_for() -> None:
    with pytest.raises(DerivationError, match="ask for mass_matrix"):
        formulations_of("tree_mass_matrix")

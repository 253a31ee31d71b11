"""Matter that leaves a body or arrives at it, so that its mass changes: rockets, chains, belts, turbines.

A state of one's own is the mass, or is in it. What is there moves as a rigid body of the mass, the centre of mass and
the inertia of the moment; no derivative of the mass enters, since what leaves takes its own momentum with it. Beside
that acts, by every flow, Meshchersky's force μ u, and what it takes to carry matter from the centre of mass C to the
place P of the flow while the body turns:

    μ       rate of mass, kg/s: positive where matter arrives, negative where it leaves
    u       its velocity at P less that of P: as it is said, or v - v_P where the ground's frame sees it as v
    ρ, J    C to P; the inertia about C, J' its rate in body axes
    F = μ (u + 2 ω × ρ)         M_P = -μ ρ × (ω × ρ) - J' ω

Flows are steady, and straight between C and P. Matter of a flow without a place leaves or arrives where it is, all over
the body: it acts at C, and what leaves at rest in the body takes J' ω with it. The moment is jet damping; of two flows
at the hub and the rim of a wheel F and M are Euler's equation of turbines.

References: Meshchersky (1897); Irschik and Holl, Mechanics of variable-mass systems, Appl. Mech. Rev. 57 (2004) 145;
Thomson, Introduction to Space Dynamics (1961), section 7.5, of jet damping.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from symdyn.graph import Expr, Graph, tangents
from symdyn.scene.forces.attachments import AtBody, place_of, table_of
from symdyn.scene.forces.force_kind import ForceKind, Push, Scope
from symdyn.scene.values.entry import Entry, EntryReader, Number, Three, entry, shown
from symdyn.scene.values.joint import Load
from symdyn.scene.values.key import TIMED, Key, Stand, one_of, optional
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, Quantity, Vector, spell
from symdyn.scene.values.shape import NUMBER
from symdyn.spatial import Mat, Vec, Wrench, cross, neg, scale, sub, zero_vector

if TYPE_CHECKING:
    from symdyn.scene.values.entry import Faults


@dataclass(frozen=True)
class Flow(Load):
    """Matter that leaves a body or arrives at it.

    Attributes:
        rate: of the mass of the body, kg/s, negative where matter leaves; None: what its other flows leave of it.
        velocity: of that matter, m/s, along the axes of `frame`, in which it is seen.
        frame: "body" (velocity relative to the place) or "ground" (absolute velocity).
        spread: whether it has no place, and leaves or arrives all over the body.
        states: rates of the states that mass and inertia of the body are made of, by name.
    """

    rate: Quantity | None = None
    velocity: Vector = NULL
    frame: str = "body"
    spread: bool = False
    states: tuple[tuple[str, Quantity], ...] = ()

    kind = "flow"

    @property
    def is_spread(self) -> bool:
        """Whether it acts at the centre of mass of its body."""
        return self.spread


def flows_of(body: str, scene: Scene) -> list[Flow]:
    """Return the flows of a body."""
    return [one for one in scene.loads if isinstance(one, Flow) and one.place.body == body]


def _rates(flow: Flow, scene: Scene, graph: Graph) -> list[Expr]:
    """Return the rates of mass and inertia of a flow's body, kg/s and kg m^2/s, by those of the states."""
    body = next(one for one in scene.bodies if one.name == flow.place.body)
    seeds = {graph.symbol(name): rate.express(graph) for name, rate in flow.states}
    return tangents([x.express(graph) for x in (body.mass, *body.inertia)], seeds)


def mass_rate(flow: Flow, scene: Scene, graph: Graph) -> Expr:
    """Return μ, kg/s."""
    if flow.rate is not None:
        return flow.rate.express(graph)
    others = (one.rate.express(graph) for one in flows_of(flow.place.body, scene) if one.rate is not None)
    return _rates(flow, scene, graph)[0] - graph.total(others)


def _thrust(flow: Flow, scene: Scene, graph: Graph) -> Wrench:
    x, y, z = (x.express(graph) for x in flow.velocity)
    return Wrench(scale(mass_rate(flow, scene, graph), (x, y, z)), zero_vector(graph))


def _carried(flow: Flow, scene: Scene, v: Vec, omega: Vec) -> Wrench:
    graph, flows = v[0].graph, flows_of(flow.place.body, scene)
    body = next(one for one in scene.bodies if one.name == flow.place.body)
    x, y, z = (a.express(graph) - b.express(graph) for a, b in zip(scene.seat(flow).at, body.com or NULL, strict=True))
    mu, swing = mass_rate(flow, scene, graph), cross(omega, (x, y, z))
    force = scale(2, swing) if flow.frame == "body" else sub(scale(2, swing), v)
    moment = neg(cross((x, y, z), scale(mu, swing)))
    if flow.name == flows[0].name and not any(one.spread and one.frame == "body" for one in flows):
        spun = Mat.symmetric(*_rates(flow, scene, graph)[1:]) @ omega
        moment = sub(moment, spun)
    return Wrench(scale(mu, force), moment)


class Mouth(AtBody):
    """The place of a flow, or the body alone."""

    def fields(self, table: EntryReader, scope: Scope) -> dict[str, Any]:
        """Return the place, and whether there is none."""
        return {"place": place_of(table, scope), "spread": "at" not in table and "point" not in table}

    def raw(self, one: Any, scope: Scope) -> dict[str, object]:
        """Return body and place."""
        return {"body": one.place.body} if one.spread else table_of(one.place) | {"at": one.place.at}

    def numbers(self, one: Any, slides: bool = True) -> Any:
        """Return where it is."""
        return iter(()) if one.spread else super().numbers(one, slides)


def _check(flow: Flow, stand: Stand) -> None:
    """Report a body that has no centre of mass to flow from, and rates that are not those of its mass."""
    if flow.place.body == Scene.GROUND:
        stand.fault(f"acts on {Scene.GROUND}, which does not move; name a body")
    body = next((one for one in stand.scene.bodies if one.name == flow.place.body), None)
    if body is None:
        return
    if body.com is None or body.about != "com":
        stand.fault(f'the centre of mass of {body.name} must be known; give com, and inertia_about = "com"')
    flows = flows_of(body.name, stand.scene)
    silent = [one.name for one in flows if one.rate is None]
    if flow.rate is None and silent[0] != flow.name:
        stand.fault(f"rate is missing, as that of {silent[0]} is; one flow of a body may leave it out")
    if flow.name != flows[-1].name or len(silent) > 1:
        return
    graph, told = Graph(), f"the mass of {body.name}, {shown(body.mass)},"
    changes = _rates(flow, stand.scene, graph)[0]
    if silent and len(flows) == 1 and changes.is_zero:
        stand.fault(f"{told} does not change; write its rate, and mass by a state, or a flow that goes on elsewhere")
    elif not silent and not _same(changes, graph.total(mass_rate(one, stand.scene, graph) for one in flows)):
        rates = " + ".join(f"({spell(one.rate)})" for one in flows if one.rate is not None)
        by = ", ".join(f"{name} at {spell(rate)}" for name, rate in flow.states) or "not at all"
        stand.fault(f"{told} changes by {by}, and its flows by {rates}; leave one rate out, or correct it")


def _same(a: Expr, b: Expr) -> bool:
    """Tell whether two formulas are equal wherever random numbers are put in; what has no value there is let pass."""
    import random

    from symdyn.algebra import Floats
    from symdyn.graph import Op, evaluate, reachable

    rng = random.Random("mass")
    names = [node for node in reachable([a, b]) if node.op is Op.SYMBOL]
    for _ in range(3):
        try:
            x, y = evaluate([a, b], Floats(), {node: rng.uniform(0.5, 1.5) for node in names})
        except (ArithmeticError, ValueError):
            continue
        if abs(x - y) > 1e-9 * (abs(x) + abs(y)):
            return False
    return True


def with_flows(scene: Scene, places: Sequence[str], faults: Faults) -> Scene:
    """Return the scene whose flows know how mass and inertia change; a mass that changes without a flow is a fault."""
    rates, elements = {one.name: one.rate for one in scene.states}, []
    carried = {one.place.body for one in scene.loads if isinstance(one, Flow)}
    told = {}
    for where, body in zip(places, scene.bodies, strict=True):
        names = dict.fromkeys(name for x in (body.mass, *body.inertia) for name in x.symbols if name in rates)
        told[body.name] = tuple((name, rates[name]) for name in names)
        if names and body.name not in carried:
            key = f"mass = {shown(body.mass)}" if set(names).intersection(body.mass.symbols) else "inertia"
            faults.add(
                where,
                f"{key} changes with {', '.join(names)}, and nothing tells which matter leaves or arrives; write "
                f'[flows.jet] with body = "{body.name}" and velocity = [0, 0, 0]',
            )
    for one in scene.elements:
        elements.append(replace(one, states=told.get(one.place.body, ())) if isinstance(one, Flow) else one)
    return replace(scene, elements=tuple(elements))


FLOW = ForceKind(
    section="flows",
    noun=Flow,
    letter="m",
    parts=(
        Mouth(),
        Key(
            "rate",
            optional(EntryReader.quantity),
            None,
            unit="kg/s",
            names=TIMED,
            holds="rate of mass, {}, below zero where matter leaves; left out, what other flows leave of the body's",
            shape=NUMBER,
        ),
        Key("velocity", EntryReader.vector, NULL, unit="m/s", text="velocity of what flows", names=TIMED),
        one_of("frame", ("body", "ground"), "that sees the velocity, along whose axes it is", "body"),
    ),
    law=Push(_thrust, _carried),
    law_words=lambda flow: (
        f"rate {'that of the mass' if flow.rate is None else spell(flow.rate)}, velocity "
        f"({', '.join(map(spell, flow.velocity))}) in the {flow.frame}"
    ),
    words={"en": "flow of matter", "sk": "prúd hmoty"},
    lost="matter that leaves or arrives",
    check=_check,
)


def flow(
    name: str,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    rate: Number | None = None,
    velocity: Three | None = None,
    frame: Literal["body", "ground"] | None = None,
) -> Entry:
    """Declare matter that leaves a body or arrives at it, whose mass is a formula in a state.

    Args:
        name: of the flow.
        body: whose matter it is.
        at: where, in body coordinates, m; all over the body when left out.
        point: where, in place of body and place.
        rate: kg/s, negative where it leaves; when left out, the rate of the mass less those of other flows.
        velocity: of what leaves or arrives, m/s, a formula in what moves and t; zero when left out.
        frame: "body", so that the velocity is relative to the place, or "ground".
    """
    return entry("flows", **locals())

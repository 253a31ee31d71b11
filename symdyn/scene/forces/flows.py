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
from typing import Any, Literal

from symdyn.errors import listed
from symdyn.frozen import dataclass, replace
from symdyn.graph import Graph
from symdyn.scene.forces.attachments import AtBody, place_of, table_of
from symdyn.scene.forces.force_kind import ForceKind, Push, Scope
from symdyn.scene.values import folding
from symdyn.scene.values.entry import Entry, EntryReader, Faults, Number, Three, entry, shown
from symdyn.scene.values.joint import Load
from symdyn.scene.values.key import TIMED, Key, Stand, one_of, optional
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, Quantity, Vector, spell
from symdyn.scene.values.shape import NUMBER
from symdyn.spatial import Mat, Vec, Wrench, add, cross, neg, scale, sub, zero_vector

NOTHING = (Quantity.ZERO,) * 6


@dataclass(frozen=True)
class Flow(Load):
    """Matter that leaves a body or arrives at it.

    Attributes:
        rate: of the mass of the body, kg/s, negative where matter leaves; None: what its other flows leave of it.
        velocity: of that matter, m/s, along the axes of `frame`, in which it is seen.
        frame: "body" (velocity relative to the place) or "ground" (absolute velocity).
        spread: whether it has no place, leaves or arrives all over the body, and acts at its centre of mass.
        flux: the rate, whether it is said or not.
        spun: entries of J', kg m^2/s, where this flow is the first of its body and nothing takes J' ω along.
    """

    rate: Quantity | None = None
    velocity: Vector = NULL
    frame: str = "body"
    spread: bool = False
    flux: Quantity = Quantity.ZERO
    spun: tuple[Quantity, ...] = NOTHING

    kind = "flow"


def flows_of(body: str, scene: Scene) -> list[Flow]:
    """Return the flows of a body."""
    return [one for one in scene.loads if isinstance(one, Flow) and one.place.body == body]


def _thrust(flow: Flow, scene: Scene, graph: Graph) -> Wrench:
    x, y, z = (x.express(graph) for x in flow.velocity)
    return Wrench(scale(flow.flux.express(graph), (x, y, z)), zero_vector(graph))


def _carried(flow: Flow, scene: Scene, v: Vec, omega: Vec) -> Wrench:
    graph, body = v[0].graph, next(one for one in scene.bodies if one.name == flow.place.body)
    x, y, z = (
        a.express(graph) - b.express(graph) for a, b in zip(scene.seated(flow).place.at, body.centre, strict=True)
    )
    mu, swing = flow.flux.express(graph), cross(omega, (x, y, z))
    force = scale(2, swing) if flow.frame == "body" else sub(scale(2, swing), v)
    spun = Mat.symmetric(*(one.express(graph) for one in flow.spun)) @ omega
    return Wrench(scale(mu, force), neg(add(cross((x, y, z), scale(mu, swing)), spun)))


class Mouth(AtBody):
    """The place of a flow, or the body alone."""

    def fields(self, table: EntryReader, scope: Scope) -> dict[str, Any]:
        """Return the place, and whether there is none."""
        return {"place": place_of(table, scope), "spread": "at" not in table and "point" not in table}

    def raw(self, one: Any, scope: Scope) -> dict[str, object]:
        return {"body": one.place.body} if one.spread else table_of(one.place) | {"at": one.place.at}


def _check(flow: Flow, stand: Stand) -> None:
    """Report a body that has no centre of mass to flow from, and a mass that no flow changes, or more than one may."""
    body = next((one for one in stand.scene.bodies if one.name == flow.place.body), None)
    if flow.place.body == Scene.GROUND:
        stand.fault(f"acts on {Scene.GROUND}, which does not move; name a body")
    if body is None or stand.faults.told(f"bodies.{body.name}"):
        return
    if body.com is None or body.about != "com":
        stand.fault(f'the centre of mass of {body.name} must be known; give com, and inertia_about = "com"')
    flows = flows_of(body.name, stand.scene)
    silent = [one.name for one in flows if one.rate is None]
    if flow.name == flows[-1].name and len(silent) != 1:
        told = f"rate is missing, as of {silent[0]}" if silent else f"rate is one too many for {body.name}"
        stand.fault(f"{told}; one of its flows has none, and takes what others leave of the rate of its mass")
    elif len(flows) == 1 and flow.flux == Quantity.ZERO and flow.spun == NOTHING:
        told = f"does nothing, as the mass of {body.name}, {shown(body.mass)}, has no state in it"
        stand.fault(f"{told}; {changing(body.name, stand.scene)}")


def changing(where: str, scene: Scene) -> str:
    """Return how the mass of a body at a place of the text becomes one that changes, in words to copy."""
    of, taken = where.rpartition(".")[2], {*scene.coordinates, *(one.name for one in scene.letters)}
    state = next((name for name in (f"m_{of}", f"mass_{of}") if name not in taken), f"mass_of_{of}")
    said = f'mass = "{state}" and [states.{state}] with rate = -0.1, start = 1, unit = "kg"'
    if not flows_of(of, scene):
        said += f', and [flows.{of}] with body = "{of}", velocity = [0, 0, 0]'
    return f"a mass or an inertia changes by a state: write {said}"


def with_flows(scene: Scene, places: Sequence[str], faults: Faults) -> Scene:
    """Return the scene whose flows know how mass and inertia change; a mass that changes without a flow is a fault."""
    rates, made = {one.name: one.rate for one in scene.states}, {}
    for where, body in zip(places, scene.bodies, strict=True):
        flows = flows_of(body.name, scene)
        try:
            mass, *spun = (x.rate(rates) for x in (body.mass, *body.inertia))
        except ZeroDivisionError:  # told where all formulas are looked at; here it stands for a rate
            mass, spun = Quantity.ONE, [*NOTHING]
        if not flows and (states := rates.keys() & {name for x in (body.mass, *body.inertia) for name in x.symbols}):
            told = f"mass or inertia changes with {listed(sorted(states))}, and nothing tells what leaves or arrives"
            faults.add(where, f'{told}; write [flows.jet] with body = "{body.name}", velocity = [0, 0, 0]')
        for one in flows:
            mass = folding.sub(mass, one.rate or Quantity.ZERO)
        kept = any(one.spread and one.frame == "body" for one in flows)
        for k, one in enumerate(flows):
            own = NOTHING if k or kept else tuple(spun)
            made[one.name] = replace(one, flux=mass if one.rate is None else one.rate, spun=own)
    return replace(
        scene, elements=tuple(made.get(one.name, one) if isinstance(one, Flow) else one for one in scene.elements)
    )


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
            holds="rate of mass, {}, negative where matter leaves; of one flow of a body left out, the rest of it",
            shape=NUMBER,
        ),
        Key(
            "velocity",
            EntryReader.vector,
            NULL,
            example="velocity = [0, 0, 0] of what leaves at rest in the body, or another one, m/s",
            letters=("vx", "vy", "vz"),
            unit="m/s",
            text="velocity of {}",
            names=TIMED,
        ),
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
    velocity: Three,
    *,
    body: str | None = None,
    at: Three | None = None,
    point: str | None = None,
    rate: Number | None = None,
    frame: Literal["body", "ground"] | None = None,
    text: str = "",
) -> Entry:
    """Declare matter that leaves a body or arrives at it, whose mass is a formula in a state.

    Args:
        name: of the flow.
        velocity: of what leaves or arrives, m/s, formulas in what moves and t.
        body: whose matter it is.
        at: where, in body coordinates, m; all over the body when left out.
        point: where, in place of body and place.
        rate: kg/s, negative where it leaves; one flow of a body leaves it out, and has the rest of the mass's rate.
        frame: "body", so that the velocity is relative to the place, or "ground"; the body's when left out.
        text: as of `spring`.
    """
    return entry("flows", **locals())

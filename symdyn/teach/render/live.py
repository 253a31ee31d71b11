"""What the interactive page computes, as one program: functions of the scene, places of all that it draws, and arrows.

All parameters are arguments here, those with values too, so that each of them can be changed by hand. The textbook's
equation (5.40), row i, with what else acts on the joint:

    tau_i = Σ k_z,ij q̈_j + Σ k_C,i,jk q̇_j q̇_k + Σ k_D,ij q̇_j² + k_G,i + k_E,i - Q_i

Of a closed mechanism the equations are those of its independent velocities, and all coefficients are reduced to them.

Arrows show how every mass moves, what acts, and what joints carry, as functions of the state:

    v, a      velocity and acceleration of a particle or a centre of mass, ground frame; m/s, m/s^2
    L, L̇     angular momentum about it, and its rate I α + ω × I ω; kg m^2/s, N m

From these the page's script makes weights m g, momenta m v, inertia forces -m a and -L̇, and splits the latter as
(5.40) does: what is left of a with q̈ = 0 is quadratic in the velocities, so that with b(u) = a(q, u, 0)

    centrifugal, by q̇_j²      -m b(u_j)
    Coriolis, by q̇_j q̇_k      -m (b(u_j + u_k) - b(u_j) - b(u_k))
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from symdyn.draw import Sheet
from symdyn.dynamics import OUTPUTS, Equations, Function, LoopChoices, Workspace, coefficients, derive_one
from symdyn.dynamics.mechanism import Taut, body_placements, declared_forces, joint_resistance, pull, strut_way, vector
from symdyn.dynamics.outputs import unique
from symdyn.errors import DerivationError, TeachError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, substitute, tangents
from symdyn.program import Program, choose, lower
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Body, Element, Joint, StateVariable, Strut
from symdyn.spatial import Mat, Vec, add, cross, dot, scale, sub, zero_vector
from symdyn.teach.languages import language_of
from symdyn.teach.render.controls import ACTING, STATE, Held, function, held, reduced_functions
from symdyn.teach.shown_state import shown_state
from symdyn.verdict import Verdict
from symdyn.verify import Claim, prove

Found = Mapping[tuple[Any, ...], tuple[Expr, ...]]
"""What `symdyn.draw.outlines` finds, by a key that says what it is."""


@dataclass(frozen=True)
class Vectors:
    """Functions of the page, and whose each of their rows is.

    Attributes:
        functions: "mass_motions", shape (masses, 16): place, v, a, L, L̇, m; "actions" of (q, qd, tau), shape (K, 9):
            place, force and couple of struts, loads, drives and whatever else joints do; "carried_forces", shape
            (joints, 9): place, force and moment that parents exert on children; those without rows are left out.
        masses: bodies.
        actions: (name, body) of what acts.
        joints: (joint, body): child, or what a closing joint closes on.
    """

    functions: tuple[Function, ...]
    masses: tuple[str, ...]
    actions: tuple[tuple[str, str], ...]
    joints: tuple[tuple[str, str], ...]


def vectors(w: Workspace, result: Found) -> Vectors:
    """Return what arrows show of a scene, by its `result`; reactions only where rigid bodies determine them all."""
    moving, acting = list(_motions(w)), list(_actions(w, result))
    carried = _carried(w, result, _flat(row for _, row in moving))
    functions = []
    for name, text, rows, takes in (
        ("mass_motions", "place, v, a, L, rate of L and mass of every mass, ground frame", moving, STATE),
        ("actions", "place, force and couple of what acts, ground frame", acting, ("q", "qd", "tau")),
        ("carried_forces", "place, force and moment that joints exert on children, ground frame", carried, STATE),
    ):
        if rows:
            entries = [x for _, row in rows for x in row]
            functions.append(function(w, name, text, entries, takes, (len(rows), len(entries) // len(rows))))
    return Vectors(
        tuple(functions),
        tuple(body for body, _ in moving),
        tuple(owner for owner, _ in acting),
        tuple(owner for owner, _ in carried),
    )


def _motions(w: Workspace) -> Iterator[tuple[str, list[Expr]]]:
    """Yield body and row of "mass_motions" of every particle and every rigid body, by the tree's own recursion."""
    tree, graph = w.tree, w.graph
    placed, motion = tree.placements(), tree.motion(w.state.qd, w.state.qdd, zero_vector(graph))
    rate, velocity = tree.rates(w.state.qd), [zero_vector(graph)]
    for i in tree.outward():
        p, r = tree.parent[i], tree.T[i].p
        arrived = tree.T[i].R.T @ add(velocity[p], cross(motion[p].w, r))
        velocity.append(add(arrived, scale(rate[i], tree.S[i][1])))
    for body in w.scene.bodies:
        i, home = tree.home[body.name]
        R, own = placed[i].R, motion[i]
        for m, at, inertia in _masses(w, body):
            r = home.point(at)
            turning = [zero_vector(graph)] * 2
            if inertia is not None:
                spin, change = (home.R.T @ x for x in (own.w, own.dw))
                L = inertia @ spin
                turning = [home.R @ x for x in (L, add(inertia @ change, cross(spin, L)))]
            local = [add(velocity[i], cross(own.w, r)), own.at(r), *turning]
            yield body.name, [*placed[i].point(r), *(x for way in local for x in R @ way), m]


def _masses(w: Workspace, body: Body) -> Iterator[tuple[Expr, Vec, Mat | None]]:
    """Yield mass, place, and inertia about it of the masses of a body, body frame; None for a particle."""
    graph = w.graph
    for particle in body.particles:
        yield particle.mass.express(graph), vector(particle.at, graph), None
    m, inertia = body.mass.express(graph), Mat.symmetric(*(x.express(graph) for x in body.inertia))
    if m.is_zero and all(x.is_zero for row in inertia for x in row):
        return
    at = vector(body.com, graph) if body.com is not None else zero_vector(graph)
    if body.com is None and not m.is_zero:
        at = scale(1 / m, body.mass_moment(graph))
    if body.about != "com" or body.com is None:
        shift = Mat.identity(graph).scaled(dot(at, at)) + Mat.outer(at, at).scaled(-graph.one)
        inertia = inertia + shift.scaled(-m)
    yield m, at, inertia


def _actions(w: Workspace, result: Found) -> Iterator[tuple[tuple[str, str], list[Expr]]]:
    """Yield (name, body) and row of "actions"."""
    scene, graph = w.scene, w.graph
    still = zero_vector(graph)
    for strut in scene.struts:
        if strut.is_rope:
            placed = body_placements(scene, graph)
            length = strut_way(scene, placed, strut, graph)
            (rate,) = tangents([length], w.state.velocity)
            tension = FORCES[strut.kind].pull.force(strut, length, rate)
            for place, wrench in Taut(scene, graph).pulls(strut.ends, placed):
                if place.body != Scene.GROUND:
                    where = placed[place.body].point(vector(place.at, graph))
                    yield (strut.name, place.body), [*where, *(x for part in wrench.scaled(tension) for x in part)]
        elif strut.ends:
            a, b = (result["end", strut, k] for k in range(2))
            way = sub((b[0], b[1], b[2]), (a[0], a[1], a[2]))
            square = dot(way, way)
            (rate,) = tangents([graph.sqrt(square)], w.state.velocity)
            force = scale(pull(strut, square, rate), way)
            for sign, at, end in ((1, a, strut.ends[0]), (-1, b, strut.ends[1])):
                if end.body != Scene.GROUND:
                    yield (strut.name, end.body), [*at, *scale(sign, force), *still]
    for load in scene.loads:
        yield (
            (load.name, load.place.body),
            [*result["end", load, 0], *result["force", load], *result["couple", load]],
        )
    declared = declared_forces(scene, graph)
    for joint in scene.moving:
        moves = [x for key, x in result.items() if key[:2] == ("move", joint.name)]
        slides = [key[3] for key in result if key[:2] == ("move", joint.name)]
        if JOINTS[joint.type].quaternion(joint) is not None or len(moves) != len(joint.rates):
            continue
        for name, slide, axis in zip(joint.rates, slides, moves, strict=True):
            k = scene.velocities.index(name)
            amount = declared[k] + _resisting(w, joint, k)
            amount = amount + w.state.tau[k] if scene.drives[k] else amount
            if not amount.is_zero:
                way = scale(amount, (axis[0], axis[1], axis[2]))
                at = result["moved", joint.name][9:]
                yield (joint.name, joint.child), [*at, *((*way, *still) if slide else (*still, *way))]


def _resisting(w: Workspace, joint: Joint, k: int) -> Expr:
    """Return what struts, damping and friction in a joint add to the force at velocity k."""
    rate = w.state.qd[k]
    total = -joint_resistance(joint, rate)
    if joint.coupling is None and len(joint.rates) == 1:
        own = [strut for strut in w.scene.struts if isinstance(strut, Strut) and strut.joint == joint.name]
        (speed,) = joint.speeds(w.graph)
        for strut in own:
            total = total - FORCES[strut.kind].pull.force(strut, joint.position(w.graph), speed)
    return total


def _flat(motions: Iterable[list[Expr]]) -> int | None:
    """Return the axis of the ground, from 0, that no mass moves along; None where none or several are so."""
    rows = list(motions)
    level = [k for k in range(3) if all(row[3 + k].is_zero and row[6 + k].is_zero for row in rows)]
    return level[0] if len(level) == 1 else None


def _carried(w: Workspace, result: Found, flat: int | None) -> list[tuple[tuple[str, str], list[Expr]]]:
    """Return (joint, body) and row of "carried_forces"; none where they do not exist or are not unique.

    In a plane mechanism what does not act in its plane is left out where rigid bodies do not determine it.
    """
    aside = set() if flat is None else {flat, *(3 + k for k in range(3) if k != flat)}
    try:
        sure = w.once(unique, "ground") or (True,) * (6 * len((*w.scene.joints, *w.scene.loops)))
        if not all(one or k % 6 in aside for k, one in enumerate(sure)):
            return []
        reactions = derive_one(w, "reactions:ground").entries
    except DerivationError:
        return []
    entries = [x if one else w.graph.zero for x, one in zip(reactions, sure, strict=True)]
    joints = (*w.scene.joints, *w.scene.loops)
    return [
        ((joint.name, joint.child), [*result["moved", joint.name][9:], *entries[6 * k : 6 * k + 6]])
        for k, joint in enumerate(joints)
    ]


MOST = 8
"""Velocities of the largest mechanism that is shown."""


@dataclass(frozen=True)
class Term:
    """One term of row i.

    Attributes:
        function: a coefficient, "applied_forces" or, of a closed mechanism, "acting".
        entry: of its result, row by row.
        row: i, from 0.
        indices: those of the coefficient's name after its letter, from 0.
        rates: velocities, from 0, that it is multiplied by: ("qdd", k), or ("qd", k) once or twice.
        sign: -1 for what acts beside the drives.
    """

    function: str
    entry: int
    row: int
    indices: tuple[int, ...]
    rates: tuple[tuple[str, int], ...]
    sign: int = 1

    @property
    def of(self) -> str:
        """What it multiplies, as of a printed coefficient."""
        return self.rates[0][0] if self.rates else ""


@dataclass(frozen=True)
class Live:
    """The functions of the page and what they are for.

    Attributes:
        program: coefficients of the rows; "inverse_dynamics", "forward_dynamics" and, where something acts beside
            drives, "applied_forces", shape (nv,); the energies; "drawn_points", shape (K, 3); "own_rates" of states;
            with quaternions "coordinate_rates"; with loops or rows what `reduced_functions` says.
        sheet: what is drawn, and the rows of `drawn_points` that it uses.
        rows: velocities that the rows are about.
        terms: those that do not vanish.
        held: how loops and rows tie the state together; None for a tree.
        led: (coordinate, velocity) of each prescribed motion, in the order of "led_positions", "led_velocities" and
            "led_accelerations", functions of parameters and time.
        arrows: whose the rows of "mass_motions", "actions" and "carried_forces" are.
        stuck: why the motion cannot be computed; "" where it can.
    """

    program: Program
    sheet: Sheet
    rows: tuple[int, ...]
    terms: tuple[Term, ...]
    held: Held | None
    led: tuple[tuple[int, int], ...]
    arrows: Vectors
    stuck: str


def live(
    scene: Scene,
    parameters: Mapping[str, float] | None = None,
    named: Sequence[Expr] = (),
    outlined: Collection[str] = (),
    states: Sequence[StateVariable] = (),
    touches: Sequence[Element] = (),
) -> Live:
    """Return what the page of a scene computes, one with loops or rows without prescribed motions, see `by_hand`.

    Loops are assembled at values of parameters, those that lessons show where none are given. `named` are values of
    the state and the parameters on any graph, which the page computes too: "named_values". `outlined` names bodies that
    are drawn as what they look like at these values. `states` are parameters that change: "own_rates" is what they add
    to the power, and their rates. `touches` are drawn, and do nothing.

    Raises:
        TeachError: a scene that sliders cannot move.
        DerivationError: no equation of motion exists.
    """
    why = unmovable(scene)
    if why:
        raise TeachError(f"{scene.name}: there is no interactive page, {language_of('en').page[why].format(most=MOST)}")
    values = shown_state(scene).parameters if parameters is None else parameters
    free = replace(scene, parameters=tuple(replace(parameter, value=None) for parameter in scene.parameters))
    workspace = Workspace(free, LoopChoices(parameters=tuple(values.items())))
    functions, tied = _rows(workspace)
    stuck = ""
    try:
        functions += choose(workspace, ("forward_dynamics",), "lagrange" if tied else None)  # with no partition
    except DerivationError as fault:
        stuck = str(fault)
    functions += choose(workspace, ("kinetic_energy", "potential_energy"))
    if len(scene.coordinates) != len(scene.velocities):
        functions += choose(workspace, ("coordinate_rates",))
    if any(not force.is_zero for force in workspace.Q):
        text = "generalized forces Q of loads, dampers, friction and declared forces"
        functions.append(function(workspace, "applied_forces", text, workspace.Q, ("q", "qd")))
    sheet = Sheet(replace(free, elements=(*free.elements, *touches)), workspace.graph, values, outlined)
    text = "points and directions that are drawn, ground frame"
    entries = [x for row in sheet.rows for x in row]
    functions.append(function(workspace, "drawn_points", text, entries, ("q", "qd"), (len(sheet.rows), 3)))
    led, motions = _led(scene), workspace.prescribed
    parts = {"positions": motions.position, "velocities": motions.velocity, "accelerations": motions.acceleration}
    for name, part in parts.items() if led else ():
        functions.append(function(workspace, f"led_{name}", f"{name} that are prescribed", part, ()))
    if states:
        rates = [one.rate.express(workspace.graph) for one in states]
        energies = [x for one in choose(workspace, ("kinetic_energy", "potential_energy")) for x in one.entries]
        seeds = {workspace.graph.symbol(one.name): rate for one, rate in zip(states, rates, strict=True)}
        power = workspace.graph.total(tangents(energies, seeds))
        functions.append(function(workspace, "own_rates", "power and rates of states", [power, *rates], ("q", "qd")))
    if named:
        values_shown = substitute(list(named), {}, workspace.graph)
        functions.append(function(workspace, "named_values", "numbers under terms", values_shown, STATE))
    arrows = vectors(workspace, sheet.found)
    equations = Equations(free, workspace.graph, (*functions, *arrows.functions))
    rows = tied.velocities if tied else tuple(range(workspace.state.n))
    terms = _lasting(equations, _terms(equations, rows))
    return Live(lower(equations), sheet, rows, terms, tied, led, arrows, stuck)


def by_hand(scene: Scene) -> Scene:
    """Return the scene that a page moves: a closed one without its prescribed motions, which sliders take over."""
    if not scene.is_constrained:
        return scene
    return replace(scene, joints=tuple(replace(joint, motion=None) for joint in scene.joints))


def _led(scene: Scene) -> tuple[tuple[int, int], ...]:
    """Return coordinate and velocity of each prescribed motion, by velocity as `prescribed` has them."""
    pairs = [
        (scene.coordinates.index(joint.coordinates[0]), scene.velocities.index(joint.rates[0]))
        for joint in scene.joints
        if joint.motion is not None
    ]
    return tuple(sorted(pairs, key=lambda pair: pair[1]))


def absence(scene: Scene, language: str) -> str:
    """Return why a page has no sliders, in words; "" where it has."""
    words = language_of(language).page
    return f"{words['absent']} {words[why].format(most=MOST)}" if (why := unmovable(scene)) else ""


def unmovable(scene: Scene) -> str:
    """Return the key in the words of a page of why sliders cannot move a scene; "" where they can."""
    if not scene.coordinates:
        return "still"
    return "many" if len(scene.velocities) > MOST else ""


def _rows(workspace: Workspace) -> tuple[list[Function], Held | None]:
    """Return the functions that rows are made of, and how loops and rows of the scene tie its state together."""
    if workspace.scene.is_constrained:
        tied = held(workspace)
        if not tied.velocities:
            raise TeachError(f"{workspace.scene.name}: there is no interactive page, {language_of('en').page['still']}")
        return reduced_functions(workspace, tied), tied
    terms = [name for name in coefficients(workspace.state.n) if OUTPUTS[name].exists_in(workspace.scene)]
    return list(choose(workspace, (*terms, "inverse_dynamics"))), None


def _terms(equations: Equations, rows: Sequence[int]) -> list[Term]:
    """Return all terms of all rows, in the order of (5.40)."""
    names = [function.name for function in equations.functions]
    n = len(rows)
    acting = ACTING if equations.scene.is_constrained else "applied_forces"
    present = {name: columns for name, columns in coefficients(n).items() if name in names}
    terms = []
    for i in range(n):
        for name, columns in present.items():
            for place, rates in enumerate(columns, i * len(columns)):
                indices = (i, *dict.fromkeys(j for _, j in rates))
                terms.append(Term(name, place, i, indices, tuple((rate, rows[j]) for rate, j in rates)))
        terms += [Term(name, i, i, (i,), (), -1) for name in names if name == acting]
    return terms


def _lasting(equations: Equations, terms: Sequence[Term]) -> tuple[Term, ...]:
    """Return the terms whose coefficients do not vanish; sums that cancel are found by proof, not by their looks."""
    entries = [equations[term.function].entries[term.entry] for term in terms]
    claims = [Claim(str(k), "coefficient", "zero", (x,), (x.graph.zero,)) for k, x in enumerate(entries)]
    _, findings = prove(claims)
    return tuple(term for term, finding in zip(terms, findings, strict=True) if finding.verdict not in Verdict.HOLD)

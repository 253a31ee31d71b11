"""A mechanism whose bodies turn by quaternions while its lesson is being written.

e            unit quaternion (e0, e1, e2, e3) of a joint        R      its rotation: columns are the turned axes
u            velocities: of a ball ω, of free flight v and ω, both in the moved frame; else rates of coordinates
X_i          derivative along velocity i alone                  p_i    momentum ∂K/∂u_i
γ^l_ji       [X_j, X_i] = Σ γ^l_ji X_l                          k_G,i  X_i of the potential of gravity

τ_i = ṗ_i - Σ γ^l_ji u_j p_l - X_i K + k_G,i + k_E,i            what drives and all other forces supply

Wheels that roll on the ground, written in the axes of the body that rolls, where nothing is long.

n        the plane's normal, in the body's axes: letters n1, n2, n3, whose squares add up to 1; ṅ = n × ω
a, r, P  axis, radius and centre of the wheel                   w      |a × n|, the sine of its lean
d        from P to the lowest point: -(r/w) (n - (n·a) a)       c      velocity of that point: v_P + ω × d
t        along the track: (a × n) / w                           n × t  across it
"""

from __future__ import annotations

from dataclasses import replace

from symdyn.algebra import Compactor, Form, Symbol, TrigonometricRing
from symdyn.dynamics import angle_groups
from symdyn.dynamics.mechanism import generalized_forces, vector
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient, tangents
from symdyn.scene import Scene
from symdyn.scene.joints import unit
from symdyn.scene.values import Contact, Joint
from symdyn.spatial import Vec, add, cross, dot, scale, sub
from symdyn.teach.derivations.lagrange.rotations import angular_velocity
from symdyn.teach.derivations.multipliers.condition import Condition
from symdyn.teach.derivations.multipliers.constrained import Constrained
from symdyn.teach.document import Block, Formula, Letter
from symdyn.teach.lesson import together
from symdyn.unlocked import cached_property

WAYS = {"tie.force along the track": 0, "tie.force across the track": 1, "tie.normal force": 2}


def rolls(row: Contact) -> bool:
    """Tell whether a contact is a wheel on the ground."""
    return row.plane.body == Scene.GROUND and row.axis is not None and row.radius is not None


def name_normal(lesson: Constrained, row: Contact) -> None:
    """Name the plane's normal in the axes of the body that rolls."""
    number = str([one.name for one in lesson.scene.contacts].index(row.name) + 1)
    several = len(lesson.scene.contacts) > 1
    entries = lesson.placed[row.place.body].R.T @ unit(row.plane.normal, lesson.graph)
    for k, node in enumerate(entries, 1):
        lesson.letter(f"n:{row.name},{k}", Letter("n", (number, str(k)) if several else (str(k),)), node)


def normal(lesson: Constrained, row: Contact) -> Vec:
    """Return the letters of the plane's normal."""
    x, y, z = (lesson.graph.symbol(f"n:{row.name},{k}") for k in (1, 2, 3))
    return x, y, z


def in_letters(lesson: Constrained, row: Contact, tie: Condition, twist: tuple[Vec, Vec]) -> Condition:
    """Return a condition of a wheel with what is shown of it in letters; the body's `twist` is (v, ω), in its axes."""
    graph, u = lesson.graph, lesson.state.qd
    assert row.axis is not None, "a wheel has an axis"
    assert row.radius is not None, "a wheel has a radius"
    n, (v, omega) = normal(lesson, row), twist
    a, r, P = unit(row.axis, graph), row.radius.express(graph), vector(row.place.at, graph)
    lean = cross(a, n)
    w = graph.sqrt(dot(lean, lean))
    d = scale(-r / w, sub(n, scale(dot(n, a), a)))
    c = add(add(v, cross(omega, P)), cross(omega, d))
    t = scale(1 / w, lean)
    power = dot((t, cross(n, t), n)[WAYS[tie.words]], c)
    slopes = gradient(power, u)
    rates = dict(zip(n, cross(n, omega), strict=True)) | lesson.state.velocity
    (bias,) = tangents([power], rates)
    shown: list[Expr] = [*slopes, bias]
    if tie.residual is not None:
        height = dot(unit(row.plane.normal, graph), sub(lesson.placed[row.place.body].p, vector(row.plane.at, graph)))
        shown.append(height + dot(n, P) - r * w)
    return replace(tie, shown=tuple(shown))


MOST_VELOCITIES = 9
"""Of a scene with quaternions that has a lesson: beyond, its formulas fill books."""


class Turning(Constrained):
    """One mechanism with quaternions, tied by conditions or not."""

    def refuse(self) -> None:
        """Say what this formulation does not take.

        Raises:
            DerivationError: no joint turns by a quaternion, or there are more velocities than anyone reads.
        """
        n = len(self.scene.velocities)
        if n > MOST_VELOCITIES:
            raise DerivationError(
                f"{self.scene.name}: a lesson would be longer than anyone reads: there are {n} velocities, and "
                f"{MOST_VELOCITIES} is the limit; --format sliders is a page that moves it, and symdyn "
                "generate writes the code"
            )
        if not self.spheres:
            raise DerivationError(
                f"{self.scene.name}: no joint turns by a quaternion, so there are none to explain; --formulation "
                f"{'multipliers' if self.scene.is_closed else 'lagrange'} shows the equations of this mechanism"
            )

    @cached_property
    def balls(self) -> list[Joint]:
        """Joints that turn by a quaternion."""
        return [joint for joint in self.scene.moving if joint.velocities]

    def first(self, joint: Joint) -> int:
        """Return the number of a joint's first velocity."""
        return self.scene.velocities.index(joint.rates[0])

    # Conditions

    def tied(self) -> tuple[Condition, ...]:
        """Return the conditions, those of wheels on the ground in letters for its normal."""
        rows = {row.name: row for row in self.wheels}
        found = []
        for tie in super().tied():
            row = rows.get(tie.owner) if not tie.loop and tie.words in WAYS else None
            found.append(tie if row is None else in_letters(self, row, tie, self.twist(row.place.body)))
        return tuple(found)

    @cached_property
    def wheels(self) -> list[Contact]:
        """Wheels on the ground, the normal named for each."""
        found = [row for row in self.scene.contacts if rolls(row)]
        for row in found:
            name_normal(self, row)
        return found

    def introduced(self, owner: str) -> list[Block]:
        """Return what the normal is in the axes of a wheel's body, and its rate."""
        row = next((row for row in self.wheels if row.name == owner), None)
        if row is None:
            return []
        keys = [f"n:{row.name},{k}" for k in (1, 2, 3)]
        blocks: list[Block] = [self.say("wheel.normal", parent=self.body(row.plane.body), child=row.place.body)]
        blocks += [Formula(key, self.shape(self.node(key))) for key in keys]
        letters = together([Symbol(key) for key in keys])
        return [*blocks, self.say("wheel.turns", normal=letters, child=row.place.body)]

    @property
    def directions(self) -> list[list[Expr]]:
        """The normal of the ground in the axes of every wheel's body."""
        return [list(normal(self, row)) for row in self.wheels]

    def twist(self, name: str) -> tuple[Vec, Vec]:
        """Return velocity of the origin and angular velocity of a body, in its own axes, as short as can be."""
        T, body = self.placed[name], next(body for body in self.scene.bodies if body.name == name)
        x, y, z = tangents(T.p, self.state.velocity)
        v, omega = T.R.T @ (x, y, z), angular_velocity(self, body)
        return self._cleaned(v), self._cleaned(omega)

    def _cleaned(self, v: Vec) -> Vec:
        x, y, z = (self.shape(one).express(self.graph) for one in v)
        return x, y, z

    # Derived once

    @cached_property
    def p(self) -> list[Expr]:
        """Momenta ∂K/∂u_i."""
        return gradient(self.energy.K, self.state.qd)

    @cached_property
    def p_rates(self) -> list[Expr]:
        """Rates of the momenta."""
        return tangents(self.p, self.state.acceleration)

    @cached_property
    def along_K(self) -> list[Expr]:
        """X_i K."""
        return self.energy.directions.slopes(self.energy.K)

    @cached_property
    def weights(self) -> list[Expr]:
        """k_G: X_i of the potential of gravity."""
        return self.energy.gravity_forces()

    @cached_property
    def springs(self) -> list[Expr]:
        """k_E: X_i of the potential of springs."""
        return self.energy.elastic_forces()

    @cached_property
    def acting(self) -> list[Expr]:
        """Q_i: loads, friction and forces in joints."""
        return generalized_forces(self.scene, self.graph)

    @cached_property
    def needed(self) -> list[Expr]:
        """τ_i: the whole of drives, other forces and conditions."""
        return [a + b for a, b in zip(self.drives, self.acting, strict=True)]

    # Forms

    def node(self, key: str) -> Expr:
        """Return the value of a name."""
        node = self.names[key].node
        assert node is not None, f"{key} has no value"
        return node

    def without_inertia(self, i: int, j: int) -> bool:
        """Tell whether entry ij of the mass matrix vanishes."""
        return f"k_z:{i + 1},{j + 1}" not in self.names

    @cached_property
    def ring(self) -> TrigonometricRing:
        """The ring in which everything is written, where e0² + e1² + e2² + e3² = 1."""
        graph, state = self.graph, (*self.state.q, *self.state.qd, *self.state.qdd)
        needed = [graph.symbol(parameter.name) for parameter in self.scene.parameters]
        needed += [*state, *self.state.rates, *vector(self.scene.gravity, graph), self.energy.K, self.energy.G]
        needed += [x for one in self.masses for x in (one.m, *one.place, *(one.h or ()))]
        needed += [x for one in self.masses for row in one.inertia for x in row]
        needed += [x for T in self.placed.values() for row in (*T.R, T.p) for x in row]
        return TrigonometricRing(needed, state, angle_groups(self.scene, graph), self.spheres)

    @cached_property
    def _compact(self) -> Compactor:
        return Compactor(self.ring, angle_groups(self.scene, self.graph))

    def shape(self, node: Expr) -> Form:
        """Return a node as short as can be, as it stands where it is no polynomial."""
        try:
            return self.short(node)
        except (DerivationError, KeyError):
            return Form.of(node)

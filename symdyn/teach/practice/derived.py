"""What a student derives in SymPy against symdyn's own: energies, momenta, slopes, equations of one scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from symdyn.algebra import Compactor, Form, TrigonometricRing
from symdyn.dynamics import Energies, angle_groups
from symdyn.dynamics.mechanism import State, body_placements
from symdyn.emit.print import text_of
from symdyn.errors import DerivationError, TeachError
from symdyn.graph import Expr, Graph, evaluate, tangents
from symdyn.scene import Scene
from symdyn.teach.languages import language_of
from symdyn.teach.masses import AXES, masses
from symdyn.teach.practice.sympy_to_graph import sympy_to_graph
from symdyn.unlocked import cached_property
from symdyn.verdict import Verdict
from symdyn.verify import Claim, prove

LONGEST = 600  # characters of a difference that is told


class Derived:
    """The quantities of a scene by name, to compare SymPy expressions with.

    Names are x1, y1, z1 of each mass, K, P, L, dL/dq1_dot, d/dt dL/dq1_dot, dL/dq1, equation 1, k_z 1,2. Symbols of an
    expression go by their names; coordinates are functions of t, q1(t), velocities and accelerations their derivatives.
    """

    def __init__(self, scene: Scene, language: str = "en") -> None:
        """Put the scene on a graph."""
        self.scene, self.words = scene, language_of(language).lesson
        self.graph = Graph()
        for parameter in scene.parameters:  # first, which is the order that forms print
            self.graph.symbol(parameter.name)
        self.energies = Energies.of(scene, self.graph)
        self.state = self.energies.state

    @cached_property
    def values(self) -> Mapping[str, Expr]:
        """What every name is worth."""
        state, found = self.state, dict[str, Expr]()
        for mass in masses(self.scene, self.graph, body_placements(self.scene, self.graph)):
            found |= {f"{axis}{mass.tag}": node for axis, node in zip(AXES, mass.place, strict=True)}
        found |= {"K": self.energies.K, "P": self.energies.P, "L": self.energies.K - self.energies.P}
        p, slopes = self.energies.momenta(), self.energies.directions.slopes(found["L"])
        rates, drives = tangents(p, state.acceleration), self.energies.driving_forces()
        for i, (q, u) in enumerate(zip(self.scene.coordinates, self.scene.velocities, strict=True)):
            found |= {f"dL/d{u}": p[i], f"d/dt dL/d{u}": rates[i], f"dL/d{q}": slopes[i]}
            found[f"equation {i + 1}"] = drives[i]
        for i, row in enumerate(self.energies.mass_matrix(), 1):
            found |= {f"k_z {i},{j}": x for j, x in enumerate(row, 1)}
        return found

    def compare(self, name: str, expression: Any) -> None:
        """Print whether an expression is what symdyn has under a name, else what is too much in it.

        Raises:
            TeachError: there is no such name, or something in the expression has no meaning here.
        """
        if name not in self.values:
            raise TeachError(f"there is no {name!r}; there are {', '.join(self.values)}")
        mine, right = sympy_to_graph(expression, self.graph, self.scene.coordinates), self.values[name]
        finding = prove([Claim(name, "yours", "symdyn's", (mine,), (right,))])[1][0]
        keys: dict[str, str] = {Verdict.PROVED: "derived.proved", Verdict.NUMERICAL: "derived.numerical"}
        key = keys.get(finding.verdict, "derived.different")
        print(self.words[key].format(name=name))
        if key == "derived.different" and (more := shortest(mine - right, self.scene, self.state)) is not None:
            text = text_of(more)
            print(self.words["derived.more"].format(difference=text if len(text) <= LONGEST else f"{text[:LONGEST]} …"))


def shortest(node: Expr, scene: Scene, state: State) -> Form | None:
    """Return a node as short as the ring of sines of a scene writes it; None where it is none of that ring."""
    try:
        parallel = angle_groups(scene, node.graph)
        ring = TrigonometricRing([node], (*state.q, *state.qd, *state.qdd), parallel)
        return Compactor(ring, parallel)(evaluate([node], ring, ring.values([node]))[0])
    except DerivationError:
        return None

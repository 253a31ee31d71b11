r"""What the names in a student's formulas mean: the scene's symbols however they are spelled, and shorthands.

m_1, m_{1}, m1              the parameter m1, by its name in code and by how it is printed
\dot q_1, q_1', q1_dot, qd1, dq1           a velocity; two dots for an acceleration
q_1, \theta_1              the first coordinate, where the scene has no such symbol
c_{12}, s_2, \cos_{12}...   cos(q1 + q2), sin(q2), by joint number, where the scene has no such symbol
m_2gh_2                     names without a space between them, where they can be read in one way only
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import combinations

from symdyn.algebra import Form, Function, Symbol
from symdyn.dynamics.mechanism import body_placements
from symdyn.emit.print import latex_symbols
from symdyn.graph import Expr, Graph, Op
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import LONGEST, acceleration_name, velocity_name
from symdyn.teach.lesson import AXES, masses
from symdyn.teach.student.grammar import SHORT, plain_index
from symdyn.unlocked import cached_property

FEW = 9  # joints, while digits side by side are read as joint numbers
FEW_PLACES = 3  # degrees of freedom, while places are formulas that somebody writes
CIRCULAR = {letter: Op[name.upper()] for letter, name in SHORT.items()}


@dataclass(frozen=True)
class Target:
    """What a student's formula claims to be.

    Attributes:
        kind: "k_z", "k_C", "k_D", "k_G", "k_E", "tau", "K", "P" or "L"; "x", "y", "z" with the tag of a mass, as x1.
        index: numbers from 1; none of a place.
        key: of a quantity on the way to the equations, as documents have it: "K:2", "dL:/dq1_dot"; "" for others.
    """

    kind: str
    index: tuple[int, ...] = ()
    key: str = ""

    @property
    def course_key(self) -> str:
        """Return the key of the quantity in a course of Lagrange's derivation, "" for none."""
        if self.key or not (self.index or self.kind in ("K", "P", "L")):
            return self.key
        return f"{self.kind}:{','.join(map(str, self.index))}"

    def __str__(self) -> str:
        """Return k_z12, k_C1_12, tau2, L."""
        first, rest = "".join(map(str, self.index[:1])), "".join(map(str, self.index[1:]))
        return f"{self.kind}{first}{'_' if self.kind == 'k_C' else ''}{rest}"


@dataclass(frozen=True)
class Names:
    """The names of one scene.

    Attributes:
        scene: the mechanism.
        others: names of symbols beside it, such as multipliers, lengths of struts and their rates.
    """

    scene: Scene
    others: tuple[str, ...] = ()

    @cached_property
    def symbols(self) -> Mapping[str, str]:
        """Return the scene's name of every way to write a symbol; the scene's own spelling comes first."""
        found: dict[str, str] = {}
        printed = latex_symbols(self.scene, self.others)
        own: list[str] = [*(p.name for p in self.scene.parameters), *self.scene.coordinates]
        own += [*filter(None, self.scene.drives), *self.rates, *self.others]
        ways: list[Mapping[str, str]] = [{}, printed]
        for shown in ways:
            for name in own:
                found.setdefault(plain_index(shown.get(name, name)), name)
        for coordinate, (velocity, acceleration) in self.dotted.items():
            plain = plain_index(coordinate)
            for pattern in ("d{0}", "{1}d{2}", "{1}dot{2}"):
                head = plain.rstrip("0123456789")
                found.setdefault(pattern.format(plain, head, plain[len(head) :]), velocity)
                found.setdefault(pattern.replace("d", "dd", 1).format(plain, head, plain[len(head) :]), acceleration)
        for number, coordinate in enumerate(self.scene.coordinates, 1):
            if coordinate in self.dotted:
                for letter in ("q", "theta"):
                    found.setdefault(f"{letter}{number}", coordinate)
        found.setdefault("t", "t")
        return found

    @cached_property
    def rates(self) -> list[str]:
        """Return the names of velocities and accelerations."""
        return [*self.scene.velocities, *(acceleration_name(u) for u in self.scene.velocities)]

    @cached_property
    def dotted(self) -> Mapping[str, tuple[str, str]]:
        """Return velocity and acceleration of every coordinate that has them."""
        velocities = set(self.scene.velocities)
        pairs = ((q, velocity_name(q)) for q in self.scene.coordinates)
        return {q: (u, acceleration_name(u)) for q, u in pairs if u in velocities}

    @cached_property
    def derivatives(self) -> Mapping[str, tuple[str, ...]]:
        """Return what a symbol is with one dot, and with two, as far as these have names."""
        beside = {name: (velocity_name(name),) for name in self.symbols.values() if velocity_name(name) in self.others}
        return {u: (acceleration_name(u),) for u in self.scene.velocities} | beside | dict(self.dotted)

    def differentiated(self, name: str, dots: int) -> str | None:
        """Return the name of a symbol with dots; None if it has none."""
        chain = (name, *self.derivatives.get(name, ()))
        return chain[dots] if dots < len(chain) else None

    def moves(self, word: str) -> bool:
        """Whether a word is a coordinate, a velocity or an acceleration."""
        name = self.symbols.get(word)
        return name in self.dotted or name in self.rates

    def read(self, word: str) -> list[list[str | Form]]:
        """Return the ways to read a word, each a product of symbols, shorthands and, last, "s" or "c" of what follows.

        A symbol is its name, a coefficient or energy that of its target; one way is what a reader hopes for, none
        means that the word is unknown.
        """
        if whole := self._piece(word):
            return [[whole]]
        if word in self.targets:
            return [[str(self.targets[word])]]
        if word in CIRCULAR:
            return [[Function(CIRCULAR[word], ())]]
        ways = sorted(self._split(word), key=len)
        return [way for way in ways if len(way) == len(ways[0])]

    def _piece(self, word: str) -> str | Form | None:
        return self.symbols.get(word) or self.shorthands.get(word)

    @cached_property
    def longest(self) -> int:
        """Return how many letters the longest piece has."""
        return max(map(len, (*self.symbols, *self.shorthands, *CIRCULAR)))

    def _split(self, word: str) -> Iterator[list[str | Form]]:
        """Yield every way to cut a word into known pieces; bounded, as pieces are."""
        ways: list[list[list[str | Form]]] = [[[]]]
        for end in range(1, len(word) + 1):
            here: list[list[str | Form]] = []
            for start in range(max(0, end - self.longest), end):
                piece = self._piece(word[start:end])
                if piece is None and end == len(word) and start and word[start:end] in CIRCULAR:
                    piece = Function(CIRCULAR[word[start:end]], ())
                if piece is not None:
                    here += [[*way, piece] for way in ways[start]][:8]
            ways.append(sorted(here, key=len)[:8])
        yield from ways[-1]

    @cached_property
    def shorthands(self) -> Mapping[str, Form]:
        """Return c12 for cos(q1 + q2), and so on, as far as the scene has no symbol of that name."""
        if len(self.scene.coordinates) > FEW:
            return {}
        units = SceneUnits(self.scene).coordinates
        angles = [i for i, unit in enumerate(units) if unit == "rad"]
        found: dict[str, Form] = {}
        for count in range(1, len(angles) + 1):
            for chosen in combinations(angles, count):
                angle = Form.sum(Symbol(self.scene.coordinates[i]) for i in chosen)
                digits = "".join(str(i + 1) for i in chosen)
                for letter, op in CIRCULAR.items():
                    found.setdefault(letter + digits, Function(op, (angle,)))
        return found

    def nearest(self, word: str) -> str:
        """Return a hint for an unknown word."""
        near = len(word) <= LONGEST and get_close_matches(word, list(self.symbols), n=1, cutoff=0.5)
        if near:
            return f"did you mean {self.symbols[near[0]]}?"
        known = list(dict.fromkeys(self.symbols.values()))
        return f"known are {', '.join(known[:14])}{', ...' if len(known) > 14 else ''}"

    @cached_property
    def places(self) -> Mapping[str, Expr]:
        """Return where masses are, as lessons call it: x1, y1, z1; of few degrees of freedom, as answers are short."""
        if len(self.scene.velocities) > FEW_PLACES:
            return {}
        graph = Graph()
        found = masses(self.scene, graph, body_placements(self.scene, graph))
        return {f"{axis}{mass.tag}": node for mass in found for axis, node in zip(AXES, mass.place, strict=True)}

    @property
    def stages(self) -> Iterator[tuple[str, Target]]:
        """Yield words for what stands on the way to the equations: K_2, P_2, v_2^2, dL/dq_1, d/dt dL/dq_1'."""
        for tag in self.tags:
            for letter, kind in (("K", "K"), ("T", "K"), ("Ek", "K"), ("P", "P"), ("V", "P"), ("U", "P"), ("Ep", "P")):
                yield f"{letter}{tag}", Target(f"{kind}_{tag}", (), f"{kind}:{tag}")
            yield f"v{tag}squared", Target(f"v_{tag}^2", (), f"v2:{tag}")
        if len(self.tags) == 1:
            yield "vsquared", Target("v^2", (), f"v2:{self.tags[0]}")
        rates = dict(self.dotted.values())
        for word, name in self.symbols.items():
            ways = [(word, name), *([(f"{word}dot", self.dotted[name][0])] if name in self.dotted else [])]
            for spelled, by in ways:
                if by in self.dotted or by in rates:
                    yield f"slope{spelled}", Target(f"dL/d{by}", (), f"dL:/d{by}")
                if by in rates:
                    yield f"rate{spelled}", Target(f"d/dt dL/d{by}", (), f"d/dt dL:/d{by}")

    @cached_property
    def tags(self) -> list[str]:
        """Return the indices of masses in print."""
        graph = Graph()
        return [mass.tag for mass in masses(self.scene, graph, body_placements(self.scene, graph))]

    @cached_property
    def targets(self) -> Mapping[str, Target]:
        """Return what can be claimed, by plain name."""
        n = range(1, len(self.scene.velocities) + 1)
        found: dict[str, Target] = {}
        for i in n:
            for name in (f"tau{i}", f"k_G{i}", f"k_E{i}"):
                found[plain_index(name)] = Target(name.rstrip("0123456789"), (i,))
            for j in n:
                found[f"kz{i}{j}"] = found[f"M{i}{j}"] = Target("k_z", (i, j))
                found[f"kD{i}{j}"] = Target("k_D", (i, j))
                for k in range(j + 1, len(n) + 1):
                    found[f"kC{i}{j}{k}"] = Target("k_C", (i, j, k))
            if len(n) == 2:
                found[f"kC{i}"] = Target("k_C", (i, 1, 2))  # the only one, as (5.40) calls it
        for i, drive in enumerate(self.scene.drives, 1):
            if drive:
                found[plain_index(drive)] = Target("tau", (i,))
        for name in [name for name in self.symbols if name in found and found[name].kind in ("k_z", "k_D", "k_C")]:
            if self.symbols[name] in {p.name for p in self.scene.parameters}:
                del found[name]
        for name in self.places:
            if name not in self.symbols:
                found[name] = Target(name)
        for word, target in self.stages:
            if word not in self.symbols:
                found.setdefault(word, target)
        energies = {"K": "K", "T": "K", "Ek": "K", "P": "P", "V": "P", "U": "P", "Ep": "P", "L": "L"}
        for name, kind in energies.items():
            found.setdefault(name, Target(kind))
        return found

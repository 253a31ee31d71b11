"""Lengths of struts between points and their rates, by name in equations and defined below them.

A spring sf and a damper df between the same points share the length s_sf and the rate s_sf_dot. The letter is one that
no symbol of the scene has with such an index; of two struts that are called alike the second adds its kind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from symdyn.algebra import Form
from symdyn.dynamics import ClosedForm
from symdyn.emit.print.letters import Letters
from symdyn.scene import Scene
from symdyn.scene.values import Strut, velocity_name
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class NamedLength:
    """The distance of two points that struts pull along.

    Attributes:
        struts: those between them, in the scene's order.
        index: what stands below its letter, part by part.
        name, rate: what it and its rate are called in code.
        form: the distance, m.
        rate_form: its rate, m/s; the distance in it by its name.
    """

    struts: tuple[Strut, ...]
    index: tuple[str, ...]
    name: str
    rate: str
    form: Form
    rate_form: Form

    @property
    def defined(self) -> tuple[tuple[str, Form], tuple[str, Form]]:
        """Both names with what they stand for."""
        return (self.name, self.form), (self.rate, self.rate_form)

    @property
    def text(self) -> str:
        """What it is, in words, such as "distance of the ends of spring sf and damper df"."""
        return f"distance of the ends of {' and '.join(f'{one.kind} {one.name}' for one in self.struts)}"


@dataclass(frozen=True)
class Lengths:
    """The lengths of a scene."""

    named: tuple[NamedLength, ...] = ()

    @property
    def names(self) -> dict[Strut, tuple[str, str]]:
        """The names of the length and of its rate, by strut."""
        return {strut: (one.name, one.rate) for one in self.named for strut in one.struts}

    def used(self, forms: Iterable[Form]) -> list[tuple[str, Form]]:
        """Return names with what they stand for, those that stand in forms and those that stand in these."""
        found = {name for form in forms for name in form.symbols}
        found |= {one.name for one in self.named if one.rate in found}
        return [(name, form) for one in self.named for name, form in one.defined if name in found]

    @cached_property
    def explicit(self) -> dict[str, Form]:
        """What every name stands for, in coordinates and velocities alone."""
        ways = {one.name: one.form for one in self.named}
        return ways | {one.rate: one.rate_form.substitute(ways) for one in self.named}

    def written_out(self, form: Form) -> Form:
        """Return a form in coordinates and velocities alone."""
        return form.substitute(self.explicit) if self.named else form


def named_lengths(
    closed: ClosedForm,
    taken: Iterable[str],
    spelled: Callable[[Form], Form],
    prefix: str = "",
) -> Lengths:
    """Return the lengths of a scene.

    Args:
        closed: the mechanism, with what acts on it.
        taken: names that stand for something else.
        spelled: what is done to every form that is printed.
        prefix: what all names begin with.
    """
    scene, loads, compact = closed.scene, closed.loads, closed.compactor
    found: list[NamedLength] = []
    for struts, index, name in called(scene, loads.alongside(), taken):
        names = (f"{prefix}{name}", velocity_name(f"{prefix}{name}"))
        loads = loads.named({**loads.names, **dict.fromkeys(struts, names)})
        forms = (spelled(loads.length(struts[0], compact)), spelled(loads.rate(struts[0], compact)))
        found.append(NamedLength(struts, index, *names, *forms))
    return Lengths(tuple(found))


def called(
    scene: Scene, together: Iterable[Sequence[Strut]], taken: Iterable[str]
) -> Iterator[tuple[tuple[Strut, ...], tuple[str, ...], str]]:
    """Yield struts that share a length, what stands below its letter, and its name, which is none that is taken."""
    used, letter = set(taken), Letters(scene)[Letters.LENGTH]
    first: set[str] = set()
    for struts in together:
        one = struts[0]
        index = (*([one.kind] if one.name in first else []), *one.name.split("_"))
        first.add(one.name)
        name = "_".join((letter if letter.isalpha() and letter != Letters.LENGTH else "s", *index))
        while used & {name, velocity_name(name)}:
            name += "_"
        used |= {name, velocity_name(name)}
        yield tuple(struts), index, name

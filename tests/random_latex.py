"""LaTeX of symbols, drawn from the grammar with everything that it leaves open."""

from __future__ import annotations

import random
from collections.abc import Iterable

from symdyn.scene.values import grammar


def random_symbols(count: int, seed: int) -> list[str]:
    """Return symbols of the grammar, written in all the ways that it leaves open."""
    chance = random.Random(seed)

    def choose(names: Iterable[str]) -> str:
        return f"\\{chance.choice(sorted(names))} "

    def single() -> str:
        return chance.choice((chance.choice("abkmqIJM019"), choose(grammar.GREEK | grammar.VARIANTS | grammar.MARKS)))

    def words() -> str:
        return "{" + "".join(chance.choice("abXY 01.,()+/-") for _ in range(5)) + "}"

    def base(depth: int) -> str:
        more = [lambda: choose(grammar.LIMITS), lambda: choose(grammar.TEXTS).strip() + words()]
        more += [lambda: choose(grammar.ACCENTS) + argument(depth), lambda: choose(grammar.FONTS) + argument(depth)]
        more += [lambda: "{" + inside(depth - 1) + "}"]
        return single() if depth <= 0 or chance.random() < 0.5 else chance.choice(more)()

    def argument(depth: int) -> str:
        return chance.choice((single(), "{" + single() + single() + "}", "{" + inside(depth - 1) + "}"))

    def script(depth: int) -> str:
        more = [lambda: chance.choice(sorted(grammar.SIGNS)), lambda: "\\text" + words()]
        more += [lambda: "\\mathrm{" + inside(depth - 1) + "}", lambda: "{" + inside(depth - 1) + "}"]
        return single() if depth <= 0 or chance.random() < 0.4 else chance.choice(more)()

    def part(depth: int) -> str:
        upper = chance.choice(("", "'", "''", "^" + script(depth)))
        lower = chance.choice(("", "", "_" + chance.choice(("", " ")) + script(depth)))
        return base(depth) + "".join(chance.sample([upper, lower], 2)) + chance.choice(("", " ", "\\,"))

    def inside(depth: int) -> str:
        open_, close = chance.choice(list(grammar.BRACKETS.items()))
        more = [lambda: part(depth), lambda: chance.choice(sorted(grammar.SIGNS)), lambda: open_ + part(depth) + close]
        return "".join(chance.choice(more)() for _ in range(chance.randint(0, 3)))

    found: list[str] = []
    while len(found) < count:
        latex = "".join(part(2) for _ in range(chance.choice((1, 1, 2))))
        if grammar.check_latex(latex) is None:
            found.append(latex)
    return found

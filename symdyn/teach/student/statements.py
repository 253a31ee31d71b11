r"""From a student's text to statements: what is claimed to be what.

    k_{z,12} = k_{z,21} = m_2 h_2^2 + ...       a result: targets, then formulas
    F - b \dot x = ...                          an equation of motion

A statement goes on over line ends until it has an "=" and the next line begins with no sign.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction

from symdyn.algebra import Form
from symdyn.arguments import argument
from symdyn.emit.print import text_of
from symdyn.errors import TeachError
from symdyn.frozen import dataclass, replace
from symdyn.scene import Scene
from symdyn.teach.student.differences import half_unit
from symdyn.teach.student.grammar import Names, Target, plain_index
from symdyn.teach.student.parser import parse
from symdyn.teach.student.tokens import Source, Token, source, tokens, without_time

SPEEDS = re.compile(r"d?[xyzrv][0-9]*[a-h]?[xyz]?(?:dot)?|omega[0-9]*[xyz]?|I[0-9]*|J[0-9]*")
"""Names that a member of a chain may use before the last one is written out: speeds, rates of places."""

CALLED: Mapping[str, tuple[str, ...]] = {
    "K:": ("K", "T", "Ek", "EK", "Wk"),
    "P:": ("P", "V", "U", "Ep", "EP", "Wp"),
    "L:": ("L",),
    "dL:/d": ("p",),
}
"""What quantities are called in front of an "=", by what their keys begin with, whatever the scene's symbols are."""


def called(key: str, word: str) -> bool:
    """Whether a word calls a quantity by a letter of its own; a momentum's may have an index, p_1."""
    own = next((letters for begin, letters in CALLED.items() if key.startswith(begin)), ())
    return word in own or ("p" in own and word.startswith("p"))


@dataclass(frozen=True)
class Statement:
    """One statement, which begins at a line, from 1.

    Attributes:
        targets: what is claimed to be known; none for an equation.
        forms: one formula for a result (or more, each claimed equal to it), two sides and more for an equation.
        loose: each formula with symbols in place of its decimals of two digits or more.
        decimals: what these are as they are written, by symbol.
        stars: runs of names that are read as products, as these: m*g*l for mgl.
    """

    line: int
    targets: tuple[Target, ...]
    forms: tuple[Form, ...]
    loose: tuple[Form, ...]
    decimals: Mapping[str, Fraction]
    stars: tuple[str, ...]

    def written(self, by: Callable[[Form], Form]) -> Statement:
        """Return the statement with its formulas written in another way."""
        return replace(self, forms=tuple(map(by, self.forms)), loose=tuple(map(by, self.loose)))


def read_statements(
    text: str, scene: Scene, name: str = "text", target: Target | None = None, others: tuple[str, ...] = ()
) -> list[Statement]:
    """Return the statements of a text, LaTeX or plain.

    Args:
        text: what a student wrote; of a whole LaTeX document what stands in mathematics.
        scene: whose symbols these are.
        name: of the file, for messages.
        target: what a formula without "=" is.
        others: names of symbols beside the scene's, such as multipliers.

    Raises:
        TeachError: something cannot be read; the message has line, column and a caret.
    """
    from_text = source(text, name)
    names = Names(scene, others)
    statements = [
        statement
        for chunk in _chunks(from_text, without_time(from_text, tokens(from_text), names))
        if (statement := _statement(from_text, chunk, names, target)) is not None
    ]
    if not statements:
        raise TeachError(f"{name}: no formula is found; write k_z11 = ..., or M_1 = ...")
    return statements


def read_formula(text: str, scene: Scene, name: str = "answer") -> Form:
    """Return the one formula of a text; what stands left of an "=" is left out.

    Raises:
        TeachError: it cannot be read, or is more than one formula.
    """
    from_text = source(text, name)
    names = Names(scene)
    found = without_time(from_text, tokens(from_text), names)
    found = [t for t in found if t.kind not in ("row", "stop")]
    start = next((i + 1 for i, t in enumerate(found) if t.kind == "op" and t.text == "="), 0)
    if not found[start:]:
        raise TeachError(f"{name}: no formula is found")
    return parse(from_text, found[start:], names, len(from_text.text))


def find_target(name: str, scene: Scene) -> Target:
    """Return the quantity of a name such as k_z11, tau_2 or L.

    Raises:
        TeachError: there is none.
    """
    targets = Names(scene).targets
    found = targets.get(plain_index(name))
    if found is None:
        shown = ", ".join(dict.fromkeys(map(str, targets.values())))
        raise TeachError(f"{name} is no quantity of {scene.name}; there are {shown}")
    return found


def _chunks(from_text: Source, result: Sequence[Token]) -> Iterator[list[Token]]:
    """Yield the tokens of each statement."""
    current: list[Token] = []
    depth, row = 0, None
    for i, token in enumerate(result):
        if token.kind == "row":
            row = token if row is None or token.text != "\n" else row
            continue
        begins = row is not None and depth == 0 and _is_whole(current)
        begins = begins and row is not None and (_vanishes(current) or _begins(from_text, row, result[i:]))
        if token.kind == "stop" or begins:
            if current:
                yield current
            current, depth = [], 0
        repeated = row and current and token.kind == "op" and token.text in "+-" and current[-1].text == token.text
        if token.kind != "stop" and not repeated:  # "a + \\ + b", as books break lines
            current.append(token)
            depth += (token.kind == "open") - (token.kind == "close")
        row = None
    if current:
        yield current


def _begins(from_text: Source, row: Token, rest: Sequence[Token]) -> bool:
    r"""Whether what follows the end of a line may begin a statement.

    It does not if it begins with a sign, unless it has an "=" of its own. One that has none goes on if it is indented,
    which is \quad in LaTeX; where that marks mathematics, only its own ends of lines mean something.
    """
    if _is_indented(from_text, row):
        return False
    if rest[0].kind == "close" or (rest[0].kind == "op" and rest[0].text not in "+-"):
        return False
    plain = row.text == "\n"  # its lines go on where they are indented
    ends = next((i for i, token in enumerate(rest) if _ends(from_text, token, plain)), len(rest))
    has_equals = any(token.kind == "op" and token.text == "=" for token in rest[:ends])
    signed = rest[0].kind == "op"
    if not plain:
        return has_equals or not signed
    indented = from_text.text[row.at + 1 : rest[0].at] != ""
    return not from_text.marked and (has_equals or not indented) and not (signed and (indented or not has_equals))


def _ends(from_text: Source, token: Token, plain: bool) -> bool:
    """Whether a line ends at a token, and does not go on indented."""
    after = token.at + len(token.text)
    indented = plain and token.text == "\n" and from_text.text[after : after + 1] == " "
    goes_on = indented or _is_indented(from_text, token)
    return token.kind in ("row", "stop") and not goes_on


def _is_indented(from_text: Source, row: Token) -> bool:
    r"""Whether \quad follows the end of a line of LaTeX, as where a formula goes on that is printed in lines."""
    return INDENTED.match(from_text.text, row.at + len(row.text)) is not None


INDENTED = re.compile(r"[\s&]*\\quad(?![A-Za-z])")


def _is_whole(row: Sequence[Token]) -> bool:
    """Whether a statement may end here: it has an "=" and its end is no sign."""
    return bool(row) and row[-1].kind != "op" and any(t.kind == "op" and t.text == "=" for t in row)


def _vanishes(row: Sequence[Token]) -> bool:
    """Whether a statement ends with = 0, after which nothing is added."""
    return len(row) > 1 and row[-1].text == "0" and row[-2].text == "="


def _statement(from_text: Source, chunk: Sequence[Token], names: Names, target: Target | None) -> Statement | None:
    parts: list[list[Token]] = [[]]
    depth = 0
    ends: list[int] = []
    for token in chunk:
        depth += (token.kind == "open") - (token.kind == "close")
        if token.kind == "op" and token.text == "=" and depth == 0:
            ends.append(token.at)
            parts.append([])
        else:
            parts[-1].append(token)
    ends.append(chunk[-1].at + len(chunk[-1].text))
    line = from_text.line(chunk[0].at)
    given = [_target(part, names) for part in parts]
    if target is not None and len(parts) > 1 and _lone(parts[0]):
        word = parts[0][0].text
        if called(target.course_key, word) or not (any(given) or names.read(word)):  # a name that is usual, or new
            given[0] = target
    if from_text.marked and (len(parts) == 1 or not (any(given) or _moves(chunk, names) or _ties(chunk, names))):
        return None  # mathematics in prose: a symbol, an abbreviation, a step on the way
    targets = [found for found in given if found is not None] if len(parts) > 1 else []
    if len(parts) == 1:
        if target is None:
            named = argument("target", "k_z11")
            raise from_text.fault(chunk[0].at, f"the left-hand side is missing; write k_z11 = ..., or give {named}")
        targets = [target]
        given = [None]
    forms = []
    loose = []
    decimals = {f"#{token.at}": token.value for token in chunk if token.kind == "number" and half_unit(token.value)}
    stars: list[str] = []
    for k, (part, known, end) in enumerate(zip(parts, given, ends, strict=True)):
        if known is not None:
            continue
        if not part:
            raise from_text.fault(end, "nothing stands on this side of the =")
        if targets and None in given[k + 1 :] and _on_the_way(part, names):
            continue
        forms.append(parse(from_text, part, names, end))
        free = [replace(x, kind="constant", text=y) if (y := f"#{x.at}") in decimals else x for x in part]
        loose.append(parse(from_text, free, names, end) if decimals else forms[-1])
        stars += [starred(token.spelled, names) for token in part if token.kind == "word"]
    if not targets and len(forms) != 2:
        raise from_text.fault(ends[1], "an equation of motion has two sides; write a result as k_z11 = ... = ...")
    read = tuple(dict.fromkeys(filter(None, stars)))
    return Statement(line, tuple(targets), tuple(forms), tuple(loose), decimals, read)


def starred(word: str, names: Names) -> str:
    """Return a run of names with the stars that are read into it, m*g*l for mgl; "" for a name or none."""
    ways = names.read(word)
    pieces = ways[0] if len(ways) == 1 else []
    shown = [x if isinstance(x, str) else text_of(x) if x.symbols else f"{x.op.name.lower()}(...)" for x in pieces]  # type: ignore[attr-defined]
    return "*".join(shown) if len(pieces) > 1 else ""


def _moves(chunk: Sequence[Token], names: Names) -> bool:
    """Whether an acceleration occurs, as in an equation of motion."""
    accelerations = {names.symbols.get(token.text) for token in chunk} & {a for _, a in names.dotted.values()}
    return (
        bool(accelerations)
        or any(token.dots == 2 for token in chunk)
        or any(token.kind == "command" and token.text == "ddot" for token in chunk)
    )


def _ties(chunk: Sequence[Token], names: Names) -> bool:
    """Whether coordinates of a closed mechanism are set in relation, and nothing but its symbols stands there."""
    words = {token.text for token in chunk if token.kind == "word"}
    coordinates = {words for words in words if names.symbols.get(words) in names.dotted}
    return names.scene.is_constrained and bool(names.others) and len(coordinates) > 1 and all(map(names.read, words))


def _lone(part: Sequence[Token]) -> bool:
    return len(part) == 1 and part[0].kind == "word"


def _on_the_way(part: Sequence[Token], names: Names) -> bool:
    """Whether a member of a chain, not its last, is written in speeds and rates that it has not introduced."""
    words = {token.text for token in part if token.kind == "word" and not names.read(token.spelled)}
    return bool(words) and all(SPEEDS.fullmatch(word) for word in words)


def _target(part: Sequence[Token], names: Names) -> Target | None:
    """Return the quantity that one side names, if it does nothing else."""
    texts = [token.text for token in part]
    squared = len(part) > 2 and part[0].kind == "word" and texts[1:] in (["^", "2"], ["^", "{", "2", "}"])
    if squared and not part[0].dots:
        return names.targets.get(f"{part[0].text}squared")
    return names.targets.get(part[0].text) if _lone(part) and not part[0].dots else None

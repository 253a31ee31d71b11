"""What became of one statement of a student's text, and that in words: sentences, filled with formulas."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symdyn.algebra import Form, Number
from symdyn.emit.print import text_of
from symdyn.teach.languages import language_of
from symdyn.teach.student.differences import Difference
from symdyn.teach.student.mistakes import Mistake
from symdyn.verdict import Verdict

EQUAL = Verdict.HOLD

ROUNDED, HOLDS, EMPTY = "rounded", "holds", "empty"

MOST = 12  # differences told
LONGEST = 600  # characters of a formula that is told

SAID = {ROUNDED: "digits", HOLDS: "holds", Verdict.NOT_SHOWN: "undefined", EMPTY: "empty"}
"""Verdicts that one sentence tells."""


@dataclass(frozen=True)
class Answer:
    """What became of one statement.

    Attributes:
        line: where it stands, from 1.
        name: of the quantity, such as "k_z12", or "equation 2", "velocity row 1".
        verdict: one of `symdyn.verdict`, as of a finding; ROUNDED for equal to the digits written;
            HOLDS for a row that is none of the scene's, but true wherever the loops are closed; EMPTY for what names
            quantities in place of formulas, such as L = K - P.
        error_log10: log10 of the probability that a wrong formula would pass; 0 when not proved.
        differences: term by term; none where it is right or where no term can be told.
        turned: whether all of it has the opposite sign.
        shifted: by how much a potential energy lies elsewhere, which is free; None for not at all.
        scaled: whether an equation is the scene's times a factor.
        valued: parameters in whose place the formula has the scene's numbers.
        multiplied: multipliers that stand in an energy, each times a condition, as they may.
        forgotten: the coordinate q whose -dK/dq is all that is missing; "" for none.
        mistake: the rule that was forgotten, None for none.
    """

    line: int
    name: str
    verdict: str
    error_log10: float = 0.0
    differences: tuple[Difference, ...] = ()
    turned: bool = False
    shifted: Form | None = None
    scaled: bool = False
    valued: tuple[str, ...] = ()
    multiplied: tuple[str, ...] = ()
    forgotten: str = ""
    mistake: Mistake | None = None

    @property
    def right(self) -> bool:
        """Whether the statement is true."""
        return self.verdict in (*EQUAL, ROUNDED, HOLDS)

    def in_words(self, language: str = "en") -> list[str]:
        """Return it as lines: see `in_words`."""
        return in_words(self, language)

    def as_dict(self) -> dict[str, Any]:
        """Return what became of one statement, for JSON; formulas as text."""

        def formula(form: Form | None) -> str | None:
            return None if form is None else text_of(form)

        differences = [
            {"kind": one.kind, "found": formula(one.found), "right": formula(one.right), "symbols": list(one.symbols)}
            for one in self.differences
        ]
        told = {name: getattr(self, name) for name in ("line", "name", "verdict", "right", "error_log10", "turned")}
        told |= {
            "shifted": formula(self.shifted),
            "scaled": self.scaled,
            "valued": list(self.valued),
            "multiplied": list(self.multiplied),
        }
        return told | {"forgotten": self.forgotten, "differences": differences}


def in_words(answer: Answer, language: str = "en") -> list[str]:
    """Return an answer as lines: the verdict, then one indented line a difference."""
    spoken = language_of(language)
    say = spoken.answers
    name = _named(answer.name, say)
    if answer.verdict in SAID:
        return [say[SAID[answer.verdict]].format(name=name)]
    if answer.right:
        if answer.shifted is not None:
            return [say["shifted"].format(name=name, shift=text_of(answer.shifted))]
        if answer.multiplied:
            return [say["multiplied"].format(name=name, symbols=", ".join(answer.multiplied))]
        if answer.valued:
            return [say["valued"].format(name=name, symbols=", ".join(answer.valued))]
        if answer.scaled:
            return [say["scaled"].format(name=name)]
        how = (
            say["proved"].format(log=f"{answer.error_log10:.0f}")
            if answer.verdict == Verdict.PROVED
            else say["numerical"]
        )
        return [say["right"].format(name=name) + how]
    if answer.forgotten:
        return [say["forgotten"].format(name=name, q=answer.forgotten)]
    rule = _rule(answer, spoken.mistakes)
    if answer.turned:
        hint = say["book"] if answer.name.startswith(("k_C", "k_D")) else ""
        return [say["turned"].format(name=name) + hint, *([f"  {rule}"] if rule else [])]
    told = [f"  {_difference(d, say)}" for d in answer.differences[:MOST]] or [f"  {say['unlisted']}"]
    if len(answer.differences) > MOST:
        told.append(f"  {say['more'].format(count=len(answer.differences) - MOST)}")
    return [say["different"].format(name=name) + (f": {rule}" if rule else ""), *told]


def _rule(answer: Answer, say: Mapping[str, str]) -> str:
    """Return which rule was forgotten, "" for none that is known."""
    if answer.mistake is None:
        return ""
    of, other = answer.mistake.of, answer.mistake.other
    where = say["where"].format(of=of) if of else ""
    return say[answer.mistake.rule] + where + (say["or"] + say[other] if other else "")


def _named(name: str, say: Mapping[str, str]) -> str:
    """Return the name of an equation or a row in the language; that of a quantity as it is."""
    if found := re.fullmatch(r"(\w+ of) (.+) along ([xyz])", name):
        return say[found[1]].format(loop=found[2], axis=found[3])
    head, _, number = name.rpartition(" ")
    if name in say:
        return say[name]
    return f"{say[head]} {number}" if head in say else name


def _short(form: Form | None) -> str:
    """Return a form as text, the beginning of one that is very long."""
    text = text_of(form) if form is not None else ""
    return text if len(text) <= LONGEST else f"{text[:LONGEST]} ..."


def _difference(difference: Difference, say: Mapping[str, str]) -> str:
    found, right = _short(difference.found), _short(difference.right)
    symbols: Sequence[str] = [*difference.symbols, "", ""]
    return say[difference.kind].format(
        found=found,
        right=right,
        symbol=symbols[0],
        found_symbol=symbols[0],
        right_symbol=symbols[1],
        factor=text_of(Number(difference.factor)),
    )

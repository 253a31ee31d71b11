"""Answers to a student in words: sentences of the language, filled with formulas in plain text."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from symdyn.algebra import Form, Number
from symdyn.emit.print import text_of
from symdyn.teach.languages import language_of
from symdyn.teach.student.answer import EMPTY, HOLDS, ROUNDED, Answer
from symdyn.teach.student.differences import Difference
from symdyn.verdict import NOT_SHOWN, PROVED

MOST = 12  # differences told
LONGEST = 600  # characters of a formula that is told

SAID = {ROUNDED: "digits", HOLDS: "holds", NOT_SHOWN: "undefined", EMPTY: "empty"}
"""Verdicts that one sentence tells."""


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
        how = say["proved"].format(log=f"{answer.error_log10:.0f}") if answer.verdict == PROVED else say["numerical"]
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

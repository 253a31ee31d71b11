"""Answers to a student in words: a table of sentences for each language, filled with formulas in plain text."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from symdyn.algebra.form import Form, Number
from symdyn.emit.print.formula_text import text_of
from symdyn.teach.derivation_check import EMPTY, HOLDS, ROUNDED, Answer
from symdyn.teach.differences import Difference
from symdyn.verify.equality import PROVED, UNDEFINED

MOST = 12  # differences told
LONGEST = 600  # characters of a formula that is told

SAID = {ROUNDED: "digits", HOLDS: "holds", UNDEFINED: "undefined", EMPTY: "empty"}
"""Verdicts that one sentence tells."""

SENTENCES: Mapping[str, Mapping[str, str]] = {
    "en": {
        "right": "{name}: right",
        "proved": " (proved equal; chance of error 1e{log})",
        "numerical": " (equal at random points, in 50 digits)",
        "shifted": "{name}: right; your zero of potential energy lies elsewhere, which adds {shift} and is free",
        "scaled": "{name}: right; it is the scene's equation times a factor",
        "valued": "{name}: right, with the scene's number for {symbols}",
        "holds": "{name}: right: it vanishes wherever the loops are closed (in numbers, at assembled positions)",
        "digits": "{name}: right to the digits written",
        "undefined": "{name}: not compared: no point is found where both formulas are real",
        "empty": "{name}: this only says how it is called; write it out in the symbols of the scene",
        "different": "{name}: different",
        "turned": "{name}: different: all of it has the opposite sign",
        "book": " (the textbook's (5.40) takes this minus out; --book compares with that)",
        "forgotten": "{name}: different: what is missing is all of -dK/d{q}, the slope of the kinetic energy",
        "unlisted": "the formula has another value; its terms cannot be told apart one by one",
        "moved": "wrong symbol: {found} should be {right}: {right_symbol} in place of {found_symbol}",
        "power": "wrong power of {symbol}: {found} should be {right}",
        "sign": "wrong sign: {found} should be {right}",
        "factor": "wrong factor: {found} should be {right}, yours is {factor} times that",
        "rounded": "rounded: {found} for {right}",
        "function": "wrong function: {found} should be {right}",
        "angle": "wrong angle: {found} should be {right}",
        "other": "wrong: {found} should be {right}",
        "missing": "missing: {right}",
        "extra": "does not belong here: {found}",
        "more": "and {count} more",
        "equation": "equation",
        "position row": "position row",
        "velocity row": "velocity row",
        "acceleration row": "acceleration row",
        "position of": "position of {loop} along {axis}, axes of the ground",
        "velocity of": "velocity of {loop} along {axis}, axes of the ground",
        "acceleration of": "acceleration of {loop} along {axis}, axes of the ground",
    },
    "sk": {
        "right": "{name}: správne",
        "proved": " (rovnosť dokázaná; pravdepodobnosť omylu 1e{log})",
        "numerical": " (rovné v náhodných bodoch, na 50 číslic)",
        "shifted": "{name}: správne; nula potenciálnej energie leží inde, čo pridáva {shift} a je voľné",
        "scaled": "{name}: správne; je to rovnica scény vynásobená činiteľom",
        "valued": "{name}: správne, s číslom scény za {symbols}",
        "holds": "{name}: správne: je nulový všade, kde sú slučky uzavreté (číselne, v zostavených polohách)",
        "digits": "{name}: správne na uvedený počet číslic",
        "undefined": "{name}: neporovnané: nenašiel sa bod, v ktorom sú oba výrazy reálne",
        "empty": "{name}: toto hovorí len, ako sa to volá; vypíšte to v symboloch scény",
        "different": "{name}: nesúhlasí",
        "turned": "{name}: nesúhlasí: celý výraz má opačné znamienko",
        "book": " (učebnica v (5.40) toto mínus vyníma; s tým porovnáva --book)",
        "forgotten": "{name}: nesúhlasí: chýba celé -dK/d{q}, derivácia kinetickej energie podľa súradnice",
        "unlisted": "výraz má inú hodnotu; jeho členy sa nedajú rozlíšiť po jednom",
        "moved": "nesprávny symbol: {found} má byť {right}: {right_symbol} namiesto {found_symbol}",
        "power": "nesprávna mocnina {symbol}: {found} má byť {right}",
        "sign": "nesprávne znamienko: {found} má byť {right}",
        "factor": "nesprávny činiteľ: {found} má byť {right}, váš výraz je jeho {factor}-násobok",
        "rounded": "zaokrúhlené: {found} za {right}",
        "function": "nesprávna funkcia: {found} má byť {right}",
        "angle": "nesprávny uhol: {found} má byť {right}",
        "other": "nesprávne: {found} má byť {right}",
        "missing": "chýba: {right}",
        "extra": "nepatrí sem: {found}",
        "more": "a ďalších {count}",
        "equation": "rovnica",
        "position row": "riadok polôh",
        "velocity row": "riadok rýchlostí",
        "acceleration row": "riadok zrýchlení",
        "position of": "poloha spojenia {loop} v smere {axis}, osi rámu",
        "velocity of": "rýchlosť v spojení {loop} v smere {axis}, osi rámu",
        "acceleration of": "zrýchlenie v spojení {loop} v smere {axis}, osi rámu",
    },
}


def in_words(answer: Answer, language: str = "en") -> list[str]:
    """Return an answer as lines: the verdict, then one indented line a difference."""
    say = SENTENCES[language]
    name = _named(answer.name, say)
    if answer.verdict in SAID:
        return [say[SAID[answer.verdict]].format(name=name)]
    if answer.right:
        if answer.shifted is not None:
            return [say["shifted"].format(name=name, shift=text_of(answer.shifted))]
        if answer.valued:
            return [say["valued"].format(name=name, symbols=", ".join(answer.valued))]
        if answer.scaled:
            return [say["scaled"].format(name=name)]
        how = say["proved"].format(log=f"{answer.error_log10:.0f}") if answer.verdict == PROVED else say["numerical"]
        return [say["right"].format(name=name) + how]
    if answer.forgotten:
        return [say["forgotten"].format(name=name, q=answer.forgotten)]
    if answer.turned:
        hint = say["book"] if answer.name.startswith(("k_C", "k_D")) else ""
        return [say["turned"].format(name=name) + hint]
    told = [f"  {_difference(d, say)}" for d in answer.differences[:MOST]] or [f"  {say['unlisted']}"]
    if len(answer.differences) > MOST:
        told.append(f"  {say['more'].format(count=len(answer.differences) - MOST)}")
    return [say["different"].format(name=name), *told]


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

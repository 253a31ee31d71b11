"""The method itself, (5.1)-(5.20) as displayed equations for any body j; the bodies of a scene are put into them later.

Names of a law are worth nothing on the graph: they stand for matrices of whatever body is looked at. What a lesson says
of a body obeys them, which tests look at in numbers, matrix by matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from symdyn.algebra import Form, Number, Symbol
from symdyn.emit.print import latex_symbols
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.document import ERRATA, Block, Box, Formula, Letter, Matrix, Name, Step, Words
from symdyn.teach.mathematics import letter

LAW = "law:"
"""What stands before the keys of the steps that state the method, and of the names in them."""

IDENTITY, NOTHING, SUM = r"\mathbf{1}", r"\mathbf{0}", r"\sum"

LETTERS: dict[str, Letter] = {
    "1": Letter(IDENTITY),
    "0": Letter(NOTHING),
    "F_A": Letter("F", ("jj",), above="A"),
    "M_A": Letter("M", ("jj",), above="A"),
    "both_A": Letter("F", ("jj",), above="A", accent="bar"),
    **{f"{F}_A{axis}": Letter(F, ("jj", axis), above="A") for F in "FM" for axis in "xyz"},
    "F_A0": Letter("F", ("0j",), above="A"),
    "M_A0": Letter("M", ("0j",), above="A"),
    "x": Letter("x", ("0j",)),
    "y": Letter("y", ("0j",)),
    "z": Letter("z", ("0j",)),
    "r": Letter("r", ("0j",), accent="tilde"),
    "R": Letter("R", ("0j",), accent="bar"),
    "P": Letter("P", ("0j",)),
    "both_P": Letter("P", ("0j",), accent="bar"),
    "both_0": Letter("F", ("0j",), above="A", accent="bar"),
    "both_R": Letter("F", ("jj",), above="R", accent="bar"),
    "F_R": Letter("F", ("jj",), above="R"),
    "M_R": Letter("M", ("jj",), above="R"),
    "of_R": Letter("F", above="R", accent="bar"),
    "F_x": Letter("F", ("x",), above="R"),
    "F_y": Letter("F", ("y",), above="R"),
    "F_z": Letter("F", ("z",), above="R"),
    "M_x": Letter("M", ("x",), above="R"),
    "M_y": Letter("M", ("y",), above="R"),
    "F_e": Letter("F", ("je",), above="*R"),
    "M_e": Letter("M", ("je",), above="*R"),
    "both_e": Letter("F", ("je",), above="*R", accent="bar"),
    "P_e": Letter("P", ("je",)),
    "r_e": Letter("r", ("je",), accent="tilde"),
    "F_ee": Letter("F", ("ee",), above="R"),
    "M_ee": Letter("M", ("ee",), above="R"),
    "m": Letter("m", ("j",)),
    "a_T": Letter("r", ("0", "Tj"), dots=2),
    "a_O": Letter("r", ("0", "Oj"), dots=2),
    "F_D0": Letter("F", ("0j",), above="D"),
    "F_D": Letter("F", ("jj",), above="D"),
    "F_star": Letter("F", ("jj",), above="*D"),
    "M_D": Letter("M", ("jj",), above="D"),
    "both_D": Letter("F", ("jj",), above="D", accent="bar"),
    "back": Letter("P", ("j0",)),
    "turned": Letter("P", ("0j",), above="T"),
    "dP": Letter("P", ("0j",), dots=1),
    "w": Letter("omega", ("0j",)),
    "w~": Letter("omega", ("0j",), accent="tilde"),
    "dw": Letter("omega", ("0j",), dots=1),
    "I": Letter("I", ("jj",)),
    "r_T": Letter("r", ("j", "Tj"), accent="tilde"),
    "I_x": Letter("I", ("x",)),
    "I_y": Letter("I", ("y",)),
    "I_z": Letter("I", ("z",)),
    "D_xy": Letter("D", ("xy",)),
    "D_xz": Letter("D", ("xz",)),
    "D_yz": Letter("D", ("yz",)),
    "sum_e": Letter(SUM, ("e",)),
    "sum_t": Letter(SUM, ("t",)),
    "m_R": Letter("m", ("R",)),
    "t": Letter("t"),
    "s_t": Letter("s", ("t",)),
    "u": Letter("u"),
    "n": Letter("n"),
    "j": Letter("j"),
    "O": Letter("O", ("j",)),
    "e": Letter("e"),
}
"""How the quantities of the method are written, by our key of each."""

ERRORS = {"bivector": ("5.1b", "5.1c"), "shift": ("5.3",), "inertia": ("5.13", "5.14")}
"""Equations that the text has wrong, by the law that they belong to."""


def law_steps(lesson: Balance) -> list[Step]:
    """Return the method, from one force to the equilibrium of a body."""
    s = {key: lesson.called(LAW + key, look) for key, look in LETTERS.items()}
    if letter(LETTERS["m"]) not in latex_symbols(lesson.scene).values():  # m_1 is the scene's, m_j nobody's
        lesson.names[LAW + "m"] = Name(LETTERS["m"])
    minus = {key: Form.product((Number.MINUS_ONE, symbol)) for key, symbol in s.items()}
    bivector = (
        *(
            _matrix(f"{F}_A", [s[f"{F}_A{axis}"] for axis in "xyz"], number)
            for F, number in (("F", "5.1a"), ("M", "5.1b"))
        ),
        _matrix("both_A", [s["F_A"], s["M_A"]], "5.1c"),
    )
    turned = Form.product((s["P"], s["F_A"]))
    shifts = (
        _matrix(
            "r",
            [Number.ZERO, minus["z"], s["y"], s["z"], Number.ZERO, minus["x"], minus["y"], s["x"], Number.ZERO],
            "5.2",
            3,
        ),
        _matrix("R", [s["1"], s["0"], s["r"], s["1"]], "5.3", 2),
        _matrix("both_P", [s["P"], s["0"], s["0"], s["P"]], "5.4", 2),
        _formula("F_A0", turned, "5.5a"),
        _formula("M_A0", Form.sum((Form.product((s["P"], s["M_A"])), Form.product((s["r"], turned)))), "5.5b"),
        _formula("both_0", Form.product((s["R"], s["both_P"], s["both_A"])), "5.5c"),
    )
    reactions = (
        _matrix("both_R", [s["F_R"], s["M_R"]], "5.6"),
        _matrix("of_R", [s[key] for key in ("F_x", "F_y", "F_z", "M_x", "M_y")] + [Number.ZERO], "5.7"),
        _formula("F_e", Form.product((Number.MINUS_ONE, s["P_e"], s["F_ee"])), "5.8"),
        _formula(
            "M_e",
            Form.sum(
                (
                    Form.product((Number.MINUS_ONE, s["r_e"], s["P_e"], s["F_ee"])),
                    Form.product((Number.MINUS_ONE, s["P_e"], s["M_ee"])),
                )
            ),
            "5.9",
        ),
        _matrix("both_e", [s["F_e"], s["M_e"]], "5.10"),
    )
    spun = Form.sum((Form.product((s["I"], s["dw"])), Form.product((s["w~"], s["I"], s["w"]))))
    inertia = (
        _formula("w~", Form.product((s["turned"], s["dP"]))),
        _formula("F_D0", Form.product((Number.MINUS_ONE, s["m"], s["a_T"])), "5.11"),
        _formula("back", s["turned"], "5.12"),
        _formula("F_D", Form.product((s["back"], s["F_D0"])), "5.13"),
        _formula(
            "M_D", Form.sum((Form.product((Number.MINUS_ONE, spun)), Form.product((s["r_T"], s["F_star"])))), "5.14"
        ),
        _matrix(
            "I",
            [
                *(s["I_x"], minus["D_xy"], minus["D_xz"]),
                *(minus["D_xy"], s["I_y"], minus["D_yz"]),
                *(minus["D_xz"], minus["D_yz"], s["I_z"]),
            ],
            "5.15",
            3,
        ),
        _formula("F_star", Form.product((Number.MINUS_ONE, s["m"], s["back"], s["a_O"])), "5.16"),
        _matrix("both_D", [s["F_D"], s["M_D"]], "5.17"),
    )
    rest = (s["both_A"], s["both_D"], s["both_R"], Form.product((s["sum_e"], s["both_e"])))
    balanced = (Formula("", Form.sum(rest), "5.18", Number.ZERO),)
    counted: list[Block] = [
        _formula("m_R", Form.product((s["sum_t"], s["t"], s["s_t"])), "5.19"),
        Formula(
            "",
            Form.product((Number(Fraction(6)), Form.sum((s["u"], Number.MINUS_ONE)))),
            "5.20",
            Form.sum((s["n"], s["m_R"])),
        ),
    ]
    if lesson.empty:
        each = Number(Fraction(len(lesson.system.kept)))
        left = Form.product((each, Form.sum((s["u"], Number.MINUS_ONE))))
        plane = Formula("", left, right=Form.sum((s["n"], s["m_R"])))
        counted += [lesson.say(f"{LAW}plane", rows=lesson.empty), plane]
    steps: list[tuple[str, Sequence[Block], str]] = [
        ("bivector", bivector, "(5.1)"),
        ("shift", shifts, "(5.2)-(5.5)"),
        ("reactions", reactions, "(5.6)-(5.10)"),
        ("inertia", inertia, "(5.11)-(5.17)"),
        ("balance", balanced, "(5.18)"),
        ("count", counted, "(5.19), (5.20)"),
    ]
    places: dict[str, str | Form] = {key: s[key] for key in ("j", "P", "u", "n", "t")}
    places |= {key: s[key] for key in ("m", "w", "a_T", "a_O", "e")}
    places |= {"origin": s["O"], "s": s["s_t"]}
    return [
        Step(
            LAW + key,
            lesson.say(LAW + key, **places),
            tuple(blocks),
            lesson.say(f"{LAW}{key}.reason", **places),
            numbers,
        )
        for key, blocks, numbers in steps
    ]


def law_errata(lesson: Balance, law: str) -> list[Step]:
    """Return the boxes of words where the text has a law wrong: what it reads, what is right, the check."""
    numbers = ERRORS.get(law.removeprefix(LAW), ())
    places: dict[str, str | Form] = {
        "reads": lesson.name("text:M", "M", "jyy", node=None),
        "right": lesson.name("text:M right", "M", "jjy", node=None),
        "A": lesson.called("text:A", Letter(r"\mathcal{A}", ("1j",))),
        "Q": lesson.called("text:Q", Letter(r"\mathcal{Q}", ("j", "Tj"))),
        **{key: Symbol(LAW + key) for key in ("F_A", "both_A", "F_D", "F_star", "back")},
        **{key: Symbol(LAW + name) for key, name in (("spin", "w~"), ("arm", "r_T"), ("w", "w"))},
    }
    boxes = tuple(
        Box("erratum", lesson.say("erratum", number=number), (lesson.say(f"erratum.{number}", **places),))
        for number in numbers
    )
    return [Step(f"{ERRATA}{law}", Words(()), boxes)] if boxes else []


def _formula(left: str, form: Form, number: str = "") -> Formula:
    return Formula(LAW + left, form, number)


def _matrix(left: str, entries: Sequence[Form], number: str, width: int = 1) -> Matrix:
    names = tuple(next(iter(entry.symbols), f"{LAW}0") for entry in entries)
    return Matrix(LAW + left, tuple(entries), names, number, width)

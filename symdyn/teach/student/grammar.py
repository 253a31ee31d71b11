r"""The grammar of students' formulas as tables: Python reads them here, and the program of a page reads them as JSON.

    text        SPELLINGS      letters and spellings of others, in the one way that is parsed, row by row
    tokens      TOKENS         pattern and kind, the first that fits; COMMANDS: what a command of LaTeX is
    time        TIMES          functions of time and their derivatives are words with dots
    formula     OPERATORS      how close operators bind; FUNCTIONS, CLOSING, SHORT

A spelling, a letter, a command or a name of a function is one row. An operation that is new is a row, and what it does
in `parser` and in `templates/teach/answers.js`. Patterns mean the same in Python (`re.ASCII`) and in JavaScript ("u").
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

# Text

BY = (
    r"(?:\\d?dot ?\{(?:[^{}]|\{[^{}]*\})*\}(?:_?\{\w+\}|_?[0-9]+)?|\\d?dot ?\\?[A-Za-z]\w*(?:_\{\w+\})?"
    r"|\\?[A-Za-z]\w*(?:_\{\w+\}|\{\})?(?: ?')*)"
)
"""What a derivative is taken by, with its dots."""

PARTIAL = r"(?:\\partial ?|[d∂] ?)"
TIME = r"(?:\\frac ?\{(?:\\mathrm ?\{d\}|d)\} ?\{(?:\\mathrm ?\{d\}|d) ?t\}|d ?/ ?dt)"

NAMES_OF_LETTERS = """
alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi psi omega
Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega sigma theta phi
"""
LETTERS: Mapping[str, str] = dict(zip("αβγδεζηθικλμνξπρστυφχψωΓΔΘΛΞΠΣΥΦΨΩςϑϕ", NAMES_OF_LETTERS.split(), strict=True))

SPELLINGS: tuple[tuple[str, str], ...] = (
    (r"[\t\r\v\f\u00a0\u1680\u2000-\u200a\u2028\u2029\u202f\u205f\u3000\ufeff]", " "),
    (r" {2,}", " "),
    (r"[\u00c0-\u1eff]", "decomposed"),
    (r"([A-Za-z\u0370-\u03ff])(?:\u0308|\u0307\u0307)", r"\ddot{$1}"),
    (r"([A-Za-z\u0370-\u03ff])\u0307", r"\dot{$1}"),
    (r"[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+", "^{$k}"),
    (r"[₀₁₂₃₄₅₆₇₈₉]+", "_{$k}"),
    (r"[½⅓⅔¼¾⅕⅖⅗⅘⅙⅚⅛⅜⅝⅞]", "($k)"),
    (r"[·×∙⋅]", "*"),
    (r"[−–]", "-"),
    (r"⁄", "/"),
    (r"[′’]", "'"),
    (r"″", "''"),
    (f"[{''.join(LETTERS)}]", "letter"),
    (r"(\\[A-Za-z]+) (?=_)", "$1"),
    (r"\.(?=[*/^'])", ""),
    (r"^ *Eq ?\((.*)\) *$", "equation"),
    (r"(?<![A-Za-z\\])(?:Sin|Cos|Tan|Sqrt)(?=[ \[(])", "lower"),
    (r"('{1,2}) ?\(t\)", "$1"),
    (r"(?<=[\])}])('{1,2})(?= ?\()", "$1"),
    (r"\\[dt]?frac ?\{ ?" + PARTIAL + r"(?:L|\\mathcal ?\{L\}) ?\} ?\{ ?" + PARTIAL + "(" + BY + r") ?\}", "slope"),
    (r"(?<![A-Za-z\\])[d∂]L ?/ ?[d∂] ?(" + BY + ")", "slope"),
    (TIME + r" ?(?:\\left ?)?[(\[{]? ?slope(\w+) ?(?:(?:\\right ?)?[)\]}])?", "rate"),
)
r"""Pattern, and what stands for it: text with $1 for the first bracket and $k for plain letters (NFKD), or a word.

    θ̇₁² · ½        \dot{\theta }_{1}^{2} * (1/2)                q1'(t)    q1'
    m2.*h2.^2      m2*h2^2                                     Sin[q1]   sin[q1]
    \frac{\partial L}{\partial \dot q_1}, dL/dqd1              slopeq1dot, slopeqd1
    d/dt (dL/dqd1)                                             rateqd1
"""

# Tokens

UPRIGHT = ("mathrm", "mathit", "mathbf", "mathsf", "mathtt", "text", "textrm", "operatorname", "textit", "boldsymbol")
GROUP = r"\{(?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*\}"
INDEX = rf"_({GROUP}|\\[A-Za-z]+(?:\{{[^{{}}]*\}})?|[A-Za-z0-9]+|)"
BARE = rf"\\(?:{'|'.join(UPRIGHT)})(?![A-Za-z])|\\[,;:! ]|[\\{{}},_ ]"
"""What is left out of an index."""


def plain_index(text: str) -> str:
    """Return an index as letters and digits alone: "{C,1,12}" is "C112"."""
    return re.sub(BARE, "", text)


TOKENS: tuple[tuple[str, str], ...] = (
    (r"\\q?quad[ \n]*\([0-9]+(?:\.[0-9]+)*[a-z]?\)|\\(?:tag|label)\*?\{[^{}]*\}", ""),
    (r"\\(?:begin|end)\{[^{}]*\}(?:\{[^{}]*\})?|\$\$?|\\[\[\]()]|\n *\n", "stop"),
    (r"\\\\(?:\[[^\]]*\])?|\n", "row"),
    (r"[ ~&]+|\\[,;:! >]", ""),
    (r"[0-9]+(?:(?:\.|\{,\}|,(?=[0-9]))[0-9]+)?(?:[eE][+-]?[0-9]{1,3}(?![A-Za-z0-9_]))?|\.[0-9]+", "number"),
    (r"[A-Za-z][A-Za-z0-9]*", "word"),
    (r"\\[A-Za-z]+", "command"),
    (r"\\?[{]|[(\[]", "open"),
    (r"\\?[}]|[)\]]", "close"),
    (r"\*\*|[-+*/^=]", "op"),
    (r"[,.:;]", "stop"),
    (r"_", "sub"),
    (r"[\s\S]", "unknown"),
)

FUNCTIONS: Mapping[str, str] = {
    **{name: name for name in ("sin", "cos", "tan", "sqrt", "exp", "log", "tanh", "abs", "sign")},
    "ln": "log",
    "sgn": "sign",
}

SILENT = ("quad", "qquad", "left", "right", "displaystyle", "textstyle", "limits", "nonumber", "notag", "hfill")
SIZES = tuple(f"{size}{side}" for size in ("big", "Big", "bigg", "Bigg") for side in ("", "l", "r"))
COMMANDS: Mapping[str, tuple[str, str]] = {
    **dict.fromkeys((*SILENT, *SIZES), ("", "")),
    **{name: ("word", name) for name in LETTERS.values()},
    **{f"var{name}": ("word", name) for name in ("phi", "theta", "epsilon", "rho")},
    **{name: ("function", function) for name, function in FUNCTIONS.items()},
    **{name: ("command", name) for name in ("frac", "dot", "ddot", "underbrace", "overbrace")},
    **dict.fromkeys(("dfrac", "tfrac", "cfrac"), ("command", "frac")),
    **dict.fromkeys(("cdot", "times", "ast"), ("op", "*")),
    **dict.fromkeys(("lvert", "vert"), ("open", "\\lvert")),
    **dict.fromkeys(UPRIGHT, ("upright", "")),
    **dict.fromkeys(("partial", "int", "sum"), ("step", "")),
    "rvert": ("close", "\\rvert"),
}
"""Kind and text of the token that a command is."""

# Time: rows of tokens as rows of letters, one a token

TIME_LETTERS: Mapping[str, str] = {
    **{sign: sign for sign in "()[]{}/^,d2t"},
    **{"dt": "T", "\\frac": "f", "\\dot": ".", "\\ddot": ":"},
    **dict.fromkeys(("Derivative", "diff", "Diff", "D"), "C"),
}
"""Commands have a backslash. A word that moves is q, e if it is d, D if it does without a d in front too, else E; S is
a symbol called dt, _ an index or a number, w all else."""

MOVING = r"[.:]*[qeD]"
for _ in range(5):  # brackets in brackets
    MOVING = rf"[.:]*(?:[qeD]|[({{]{MOVING}[)}}\]])"
ONCE, SQUARED = r"(?:[de]t|[ST])", r"\^(?:2|\{2\})"
OF_TIME = r"([qeD]|[.:]\{.\}[2_]{0,2})(?:\(t\)|\{\(t\)\}|\[t\])+"
r"""What moves, with its index, and the (t) behind it: q_2(t), \dot{q}_{2}{\left(t \right)}."""

TIMES: tuple[tuple[str, int, int], ...] = (
    (rf"f\{{[de]({MOVING})\}}\{{{ONCE}\}}", 1, 0),
    (rf"f\{{[de]\}}\{{{ONCE}\}}({MOVING})?", 1, 0),
    (rf"f\{{[de]{SQUARED}({MOVING})\}}\{{{ONCE}{SQUARED}\}}", 2, 0),
    (rf"f\{{[de]{SQUARED}\}}\{{{ONCE}{SQUARED}\}}({MOVING})?", 2, 0),
    (rf"f\{{([DE])\}}\{{{ONCE}\}}", 1, 1),
    (rf"[de]/T({MOVING})?", 1, 0),
    (r"([DE])/T", 1, 1),
    (rf"C\(({MOVING}),t\)", 1, 0),
    (rf"C\(({MOVING}),(?:t,t|\(t,2\)|t,2)\)", 2, 0),
    (r"C\(", 1, 0),
)
r"""Pattern, whose bracket is what is differentiated, how often, and how many letters belong to the d in front of it.

    \frac{d}{dt} q_1, \frac{dq_1}{dt}, dq_1/dt, d/dt q_1           q_1'
    Derivative(q1(t), t), diff(q1, t, t), Derivative(q1, (t, 2))    q_1', q_1''
"""

# Formulas

OPERATORS: Mapping[str, int] = {"+": 1, "-": 1, "*": 2, "/": 2, "": 2, "^": 3}
"""How close they bind; "" is a product without a sign."""

CLOSING: Mapping[str, str] = {"(": ")", "[": "]", "{": "}", "\\{": "\\}", "\\lvert": "\\rvert"}
BEGINS = ("number", "word", "open", "command", "function", "constant")
"""Kinds of tokens that a factor begins with."""

SHORT: Mapping[str, str] = {"s": "sin", "c": "cos", "sin": "sin", "cos": "cos", "S": "sin", "C": "cos"}
"""Letters of shorthands such as c12."""

DEEPEST, LARGEST_POWER, MOST_LETTERS = 60, 32, 200
"""Brackets in brackets; an exponent; letters of a word."""

PAGE: Mapping[str, Any] = {
    "letters": LETTERS, "spellings": SPELLINGS, "group": GROUP, "index": INDEX, "bare": BARE, "tokens": TOKENS,
    "functions": FUNCTIONS, "commands": COMMANDS, "timeLetters": TIME_LETTERS, "ofTime": OF_TIME, "times": TIMES,
    "operators": OPERATORS, "closing": CLOSING, "begins": BEGINS, "short": SHORT, "deepest": DEEPEST,
    "largestPower": LARGEST_POWER, "mostLetters": MOST_LETTERS,
}  # fmt: skip
"""What the program of a page reads."""

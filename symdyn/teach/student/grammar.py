r"""The grammar of students' formulas as tables, and what names in them mean.

Python reads the tables here, and the program of a page reads them as JSON:

    text        SPELLINGS      letters and spellings of others, in the one way that is parsed, row by row
    tokens      TOKENS         pattern and kind, the first that fits; COMMANDS: what a command of LaTeX is
    time        TIMES          functions of time and their derivatives are words with dots
    formula     OPERATORS      how close operators bind; FUNCTIONS, CLOSING, SHORT

A spelling, a letter, a command or a name of a function is one row. An operation that is new is a row, and what it does
in `parser` and in `templates/teach/formulas.js`. Patterns mean the same in Python (`re.ASCII`) and in JavaScript ("u").

Names are the scene's symbols however they are spelled, and shorthands:

    m_1, m_{1}, m1              the parameter m1, by its name in code and by how it is printed
    \dot q_1, q_1', q1_dot, qd1, dq1           a velocity; two dots for an acceleration
    q_1, \theta_1              the first coordinate, where the scene has no such symbol
    c_{12}, s_2, \cos_{12}...   cos(q1 + q2), sin(q2), by joint number, where the scene has no such symbol
    m_2gh_2                     names without a space between them, where they can be read in one way only
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Set
from difflib import get_close_matches
from fractions import Fraction
from itertools import accumulate, combinations
from typing import Any

from symdyn.algebra import Form, Function, Number, Symbol
from symdyn.dynamics.mechanism import body_placements
from symdyn.emit.print import latex_symbols
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import LONGEST, acceleration_name, velocity_name
from symdyn.teach.lesson import AXES, masses
from symdyn.unlocked import cached_property

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
    (r"([A-Za-z\u0370-\u03ff][₀₁₂₃₄₅₆₇₈₉]*)(?:[\u0308\u00a8]|[\u0307\u02d9]{2})", r"\ddot $1"),
    (r"([A-Za-z\u0370-\u03ff][₀₁₂₃₄₅₆₇₈₉]*)[\u0307\u02d9]", r"\dot $1"),
    (r"(?<=dot)\{([A-Za-z])\}(?=[A-Za-z0-9])", " $1"),
    (r"(?<=dot)\{(\\[A-Za-z]+) ?\}(?=[0-9])", " $1_"),
    ("√", r"\sqrt "),
    (r"[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+", "^{$k}"),
    (r"[₀₁₂₃₄₅₆₇₈₉]+", "_{$k}"),
    (r"[½⅓⅔¼¾⅕⅖⅗⅘⅙⅚⅛⅜⅝⅞]", "($k)"),
    (r"[·×∙⋅∗]", "*"),
    (r"[ɡℊ𝑔]", "g"),
    (r"\\vert(?![A-Za-z])|\\\||∣", "|"),
    (r"\|([^|\n]*)\|", r"\lvert $1\rvert "),
    (r"[−–]", "-"),
    (r"⁄", "/"),
    (r"[′’]", "'"),
    (r"″|\^ ?(?:\\doubleprime|\{ ?(?:\\doubleprime|\\prime ?\\prime) ?\})", "''"),
    (r"\^ ?(?:\\prime(?![A-Za-z])|\{ ?\\prime ?\})", "'"),
    (f"(?<=[{''.join(LETTERS).replace('π', '')}])([0-9]+)", "_{$1}"),
    (f"[{''.join(LETTERS)}]", "letter"),
    (r"(\\[A-Za-z]+) (?=[_'])", "$1"),
    (r"\.(?=[*/^'])", ""),
    (r"^ *Eq ?\((.*)\) *$", "equation"),
    (r"(?<![A-Za-z\\])(?:Sin|Cos|Tan|Sqrt|Abs)(?=[ \[(])", "lower"),
    (r"('{1,2}) ?\(t\)", "$1"),
    (r"(?<=[\])}])('{1,2})(?= ?\()", "$1"),
    (r"\\[dt]?frac ?\{ ?" + PARTIAL + r"(?:L|\\mathcal ?\{L\}) ?\} ?\{ ?" + PARTIAL + "(" + BY + r") ?\}", "slope"),
    (r"(?<![A-Za-z\\])[d∂]L ?/ ?[d∂] ?(" + BY + ")", "slope"),
    (TIME + r" ?(?:\\left ?)?[(\[{]? ?slope(\w+) ?(?:(?:\\right ?)?[)\]}])?", "rate"),
)
r"""Pattern, and what stands for it: text with $1 for the first bracket and $k for plain letters (NFKD), or a word.

    θ̇₁² · ½        \dot \theta_{1}^{2} * (1/2)                  q1'(t)    q1'
    |q1|, \vert q_1 \vert        \lvert q1\rvert
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
    **{"ln": "log", "sgn": "sign", "tg": "tan", "sec": "sec"},
    **dict.fromkeys(("cot", "cotg", "ctg"), "cot"),
    **dict.fromkeys(("atan", "arctan", "arctg"), "atan"),
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
    **dict.fromkeys(UPRIGHT, ("upright", "")),
    **dict.fromkeys(("partial", "int", "sum"), ("step", "")),
    "lvert": ("open", "\\lvert"),
    "rvert": ("close", "\\rvert"),
}
"""Kind and text of the token that a command is."""

# Time: rows of tokens as rows of letters, one a token

TIME_LETTERS: Mapping[str, str] = {
    **{sign: sign for sign in "()[]{}/^,d2t"},
    **{"dt": "T", "\\frac": "f", "\\dot": ".", "\\ddot": ":"},
    **dict.fromkeys(("Derivative", "diff", "Diff", "D"), "C"),
}
"""Commands have a backslash. A word that moves is q, e if it is d, D if it does without a d in front too, else E; n is
a symbol that does not move, S one called dt, _ an index or a number, w all else."""

MOVING = r"[.:]*[qeD]"
for _ in range(5):  # brackets in brackets
    MOVING = rf"[.:]*(?:[qeD]|[({{]{MOVING}[)}}\]])"
ONCE, SQUARED = r"(?:[de]t|[ST])", r"\^(?:2|\{2\})"
OF_TIME = r"([qeDn]|[.:]\{.\}[2_]{0,2})(?:\(t\)|\{\(t\)\}|\[t\])+"
r"""A name, with its index, and the (t) behind it: F(t), q_2(t), \dot{q}_{2}{\left(t \right)}."""

TIMES: tuple[tuple[str, int, int], ...] = (
    (rf"f\{{[de]({MOVING})\}}\{{{ONCE}\}}", 1, 0),
    (rf"f\{{[de]\}}\{{{ONCE}\}}({MOVING})?", 1, 0),
    (rf"f\{{[de]{SQUARED}({MOVING})\}}\{{{ONCE}{SQUARED}\}}", 2, 0),
    (rf"f\{{[de]{SQUARED}\}}\{{{ONCE}{SQUARED}\}}({MOVING})?", 2, 0),
    (rf"f\{{([DE])\}}\{{{ONCE}\}}", 1, 1),
    (rf"[de]/T({MOVING})?", 1, 0),
    (rf"[de]({MOVING})/T", 1, 0),
    (rf"[de]{SQUARED}/T{SQUARED}({MOVING})?", 2, 0),
    (rf"[de]{SQUARED}({MOVING})/T{SQUARED}", 2, 0),
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


ENERGIES = tuple(zip(("K", "T", "Ek", "P", "V", "U", "Ep"), "KKKPPPP", strict=True))
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
        own += [*filter(None, self.scene.drives), *self.rates, *self.others, *self.formulas]
        for shown in ({}, printed):
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
        if "lambda1" in self.others and "lambda2" not in self.others:  # the only multiplier
            found.setdefault("lambda", "lambda1")
        return found

    @cached_property
    def formulas(self) -> Mapping[str, Form]:
        """Return what stands for names that the scene gives a formula, and for g where gravity is a plain number."""
        taken = {*(p.name for p in self.scene.parameters), *self.scene.coordinates, *self.rates, *self.others}
        formulas = ((name, x) for name, x in self.scene.definitions.items() if name not in taken)
        found = {name: Form.of(x.express(Graph())) for name, x in formulas}
        own = latex_symbols(self.scene, (*self.others, *found))
        pulls = [x for x in (one.at({}) for one in self.scene.gravity) if x != 0]
        if len(pulls) == 1 and isinstance(pulls[0], Fraction) and not {"g"} & {*own, *map(plain_index, own.values())}:
            found["g"] = Number(abs(pulls[0]))
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
        rate, known = acceleration_name, {*self.rates, *self.others, *self.formulas, *self.scene.rates.values()}
        chains = {name: (rate(name), rate(rate(name))) for name in self.symbols.values()}
        return {name: tuple(x for x in pair if x in known) for name, pair in chains.items() if pair[0] in known}

    def differentiated(self, name: str, dots: int) -> str | None:
        """Return the name of a symbol with dots; None if it has none."""
        chain = (name, *self.derivatives.get(name, ()))
        return chain[dots] if dots < len(chain) else None

    def moves(self, word: str) -> bool:
        """Whether a word is what has a derivative, or is one."""
        name = self.symbols.get(word, word)
        return name in self.derivatives or any(name in rates for rates in self.derivatives.values())

    def read(self, spelled: str) -> list[list[str | Form]]:
        """Return the ways to read a word, each a product of symbols, shorthands and, last, "s" or "c" of what follows.

        Where an underscore stands a word is not cut: m_2gh_2 is m2 g h2, and k_x is k x never.
        A symbol is its name, a coefficient or energy that of its target; one way is what a reader hopes for, none
        means that the word is unknown.
        """
        word = spelled.replace("_", "")
        if whole := self._piece(word):
            return [[whole]]
        if word in self.targets:
            return [[str(self.targets[word])]]
        if word in CIRCULAR:
            return [[Function(CIRCULAR[word], ())]]
        ways = sorted(self._split(word, set(accumulate(map(len, spelled.split("_"))))), key=len)
        return [way for way in ways if len(way) == len(ways[0])]

    def _piece(self, word: str) -> str | Form | None:
        return self.symbols.get(word) or self.shorthands.get(word)

    @cached_property
    def longest(self) -> int:
        """Return how many letters the longest piece has."""
        return max(map(len, (*self.symbols, *self.shorthands, *CIRCULAR)))

    def _split(self, word: str, whole: Set[int]) -> Iterator[list[str | Form]]:
        """Yield every way to cut a word into known pieces, nowhere at places of `whole`; bounded, as pieces are."""
        ways: list[list[list[str | Form]]] = [[[]]]
        for end in range(1, len(word) + 1):
            here: list[list[str | Form]] = []
            for start in (at for at in range(max(0, end - self.longest), end) if at not in whole):
                tangent = word[start : end + 1] == "tg"  # tgq is no product
                piece = None if tangent else self._piece(word[start:end])
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
        if near := len(word) <= LONGEST and get_close_matches(word, list(self.symbols), n=1, cutoff=0.5):
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
            for letter, kind in ENERGIES:
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
                found |= {f"kC{i}{j}{k}": Target("k_C", (i, j, k)) for k in range(j + 1, len(n) + 1)}
            if len(n) == 2:
                found[f"kC{i}"] = Target("k_C", (i, 1, 2))  # the only one, as (5.40) calls it
        for i, drive in enumerate(self.scene.drives, 1):
            if drive:
                found[plain_index(drive)] = Target("tau", (i,))
        own = {*(p.name for p in self.scene.parameters), *self.formulas}
        found = {
            x: y for x, y in found.items() if y.kind not in ("k_z", "k_D", "k_C") or self.symbols.get(x) not in own
        }
        found |= {name: Target(name) for name in self.places if name not in self.symbols}
        for word, target in self.stages:
            if word not in self.symbols:
                found.setdefault(word, target)
        for name, kind in (*ENERGIES, ("L", "L")):
            found.setdefault(name, Target(kind))
        return found

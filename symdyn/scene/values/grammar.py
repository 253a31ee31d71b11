r"""What text of a scene may hold: names, words, the LaTeX of a symbol, and the letters of formulas that look at a run.

Names survive every target: Python, C, LaTeX and formulas.

A scene may come from a stranger, and its text goes into LaTeX, HTML, Markdown, notebooks, pictures, comments of code
and terminals. Words are printable characters, which each target escapes. The LaTeX of a symbol is the one thing that
is not escaped, so it is what every target shows alike, and nothing else:

    symbol   = part {part}, with a letter in it
    part     = base ["'"..] ["_" script] ["^" script], in any order, each once; primes are an upper script
    base     = one character, \max, \hat of an argument, \mathrm of an argument, \text{words}, { inside }
    script   = one character, a sign, \mathrm{ inside }, \text{words}, { inside }
    argument = one character, { inside } without scripts
    inside   = any number of parts, signs and spaces, and of ( inside ), [ inside ], \{ inside \}

One character is a letter, a digit, \alpha or its like, \infty or its like.

Letters that formulas of outputs, events and `--outputs` may use:

    x, x_dot, x_ddot            coordinates, velocities and their rates
    tau1, u, m1, t              drives, inputs, parameters, time
    point_tip_x                 places of declared points, ground axes, m
    reaction_hinge_fx           what the parent exerts on the child at a joint or loop, axes of the child's body, N and
                                N m; `.._joint` and `.._ground` in other axes
    tension_hoist               tension of a rope, positive where it pulls, N
    spring_s_force, damper_d_rate       of spring s or damper d: force, positive where it pulls its ends together, N;
                                length, the distance of its ends, m; rate of that, m/s. At a joint it has a force
                                alone, positive against the coordinate, N m or N
    kinetic_energy, potential_energy    of the whole scene, J
    multiplier_cut_fx_joint     multipliers of rows that close loops, as `simulate --reactions` calls them

All but the last are known from the scene; which rows are kept is decided where equations are derived.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Callable, Container, Iterable, Iterator
from functools import cache
from typing import Protocol

from symdyn.errors import hint
from symdyn.frozen import dataclass

LONGEST_WORDS = 200
LONGEST_LATEX = 100
DEEPEST = 6  # braces in braces

GREEK_LETTERS = """
alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi psi omega
Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega
"""
GREEK = frozenset(GREEK_LETTERS.split())
VARIANTS = frozenset(
    ("varepsilon", "vartheta", "varpi", "varrho", "varsigma", "varphi", "ell", "hbar", "imath", "jmath", "Re", "Im")
)
MARKS = frozenset(
    ("infty", "ast", "star", "circ", "bullet", "dagger", "ddagger", "prime", "perp", "parallel", "pm", "mp", "times",
     "cdot", "partial", "nabla")
)  # fmt: skip
LIMITS = frozenset(("max", "min"))
ACCENTS = frozenset(
    ("dot", "ddot", "hat", "bar", "tilde", "vec", "check", "breve", "acute", "grave", "widehat", "widetilde",
     "overline", "underline")
)  # fmt: skip
FONTS = frozenset(("mathrm", "mathit", "mathbf", "mathsf", "mathtt", "mathcal", "boldsymbol"))
TEXTS = frozenset(("text", "textrm", "textit", "operatorname"))

SPACES = ("\\,", "\\;", "\\:")
SIGNS = frozenset("+-*/=.,:;!|") | {"\\%"}
BRACKETS = {"(": ")", "[": "]", "\\{": "\\}"}

HELP = r"a symbol has letters, digits, _ ^ ', Greek, accents such as \hat{k}, fonts such as \mathrm{a}, \text{max}"

_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|.", re.DOTALL)
_WORDS = re.compile(r"[A-Za-z0-9 .,()+/-]+")


def check_words(text: str) -> str | None:
    """Return what is wrong with text for people, such as a description, or None for one line of bearable length."""
    if not text.isprintable():
        return "holds a line break or another unprintable character; write one line"
    if len(text) > LONGEST_WORDS:
        return f"has {len(text)} characters; {LONGEST_WORDS} are enough"
    return None


def check_latex(latex: str) -> str | None:
    """Return what is wrong with the LaTeX of a symbol and what would work, or None for what every target can show."""
    try:
        read_latex(latex)
    except LatexError as refusal:
        return str(refusal)
    return None


class LatexError(ValueError):
    """LaTeX that is no symbol: what was found and what would work."""


@dataclass(frozen=True)
class SymbolPart:
    r"""One part of a symbol."""

    text: str  # written in one way only, so that m_1, m_{1} and {m} _1 are one: m_{1}
    raised: bool  # whether it has an upper script, so that no exponent may follow


def read_latex(latex: str) -> tuple[SymbolPart, ...]:
    """Return the parts of a symbol, at least one; LatexError where it is none."""
    if not latex.strip():
        raise LatexError(r"is empty; give a symbol such as \kappa_1, or leave it out")
    if any(not " " <= character <= "~" for character in latex):
        raise LatexError(r"holds a line break or a character that is not ASCII; write \kappa, not the letter itself")
    if len(latex) > LONGEST_LATEX:
        raise LatexError(f"has {len(latex)} characters; {LONGEST_LATEX} are enough")
    reader = _Reader(latex)
    parts = tuple(reader.parts(None, ()))
    if not reader.letters:
        raise LatexError(r"holds no letter; give a symbol such as \kappa_1")
    return parts


@dataclass(frozen=True)
class LatexSymbol:
    """The LaTeX of a symbol that is shown; a word of our own may be longer than those of this grammar are."""

    latex: str

    @property
    def letters(self) -> str:
        """What symbols share that look alike: m_1 and m_{1} do; of what is no symbol, all of it."""
        return "".join(part.text for part in _parts(self.latex)) or self.latex

    @property
    def takes_exponent(self) -> bool:
        """Whether an exponent may follow as it is: not behind an upper script, nor behind a product."""
        parts = _parts(self.latex)
        return not parts or (len(parts) == 1 and not parts[0].raised)


@cache
def _parts(latex: str) -> tuple[SymbolPart, ...]:
    try:
        return read_latex(latex)
    except LatexError:
        return ()


class _Reader:
    """Reads tokens from left to right."""

    def __init__(self, latex: str) -> None:
        self.tokens = _TOKEN.findall(latex)
        self.at = self.depth = 0
        self.letters = False  # whether there is one
        balance = [self.tokens[:k].count("{") - self.tokens[:k].count("}") for k in range(len(self.tokens) + 1)]
        special = next((token for token in self.tokens if token[0] in "$&%#~" or token in ("\\", "\\\\")), None)
        if special:
            raise self._unknown(special)
        if min(balance) < 0 or balance[-1]:
            raise LatexError(r"has braces that do not pair; give a symbol such as k_{\mathrm{max}}")

    def parts(self, end: str | None, signs: Container[str]) -> Iterator[SymbolPart]:
        """Yield the parts up to a token, which is read too; `signs` and brackets may stand between them."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise LatexError(f"nests deeper than {DEEPEST} levels; {HELP}")
        while (token := self._next()) != end:
            if token is None:
                raise LatexError(f"lacks a {end}; {HELP}")
            if token in signs:
                yield SymbolPart(token, False)
            elif token in BRACKETS and signs:
                yield SymbolPart(f"{token}{self._inside(BRACKETS[token])}{BRACKETS[token]}", False)
            elif token not in SPACES:
                yield self._scripted(token)
        self.depth -= 1

    def _next(self) -> str | None:
        while self.at < len(self.tokens) and self.tokens[self.at] == " ":
            self.at += 1
        self.at += 1
        return self.tokens[self.at - 1] if self.at <= len(self.tokens) else None

    def _ahead(self) -> str | None:
        return next((token for token in self.tokens[self.at :] if token != " "), None)

    def _inside(self, end: str) -> str:
        return "".join(part.text for part in self.parts(end, SIGNS))

    def _scripted(self, token: str) -> SymbolPart:
        base, scripts, primes = self._base(token), {"_": "", "^": ""}, ""
        if re.search(r"[_^']", base) and base.startswith("{") and self._ahead() in ("_", "^", "'"):
            raise LatexError(f"has a script on braces that hold scripts; give such as k_{{a,b}}; {HELP}")
        while (mark := self._ahead()) in scripts or mark == "'":
            self._next()
            if mark == "'" and not scripts["^"]:
                primes += mark
            elif mark == "'" or scripts[mark] or (mark == "^" and primes):
                raise LatexError("has two scripts at one place; put both into one, such as k^{a,b}")
            else:
                scripts[mark] = f"{mark}{{{self._script()}}}"
        return SymbolPart(f"{base}{primes}{scripts['_']}{scripts['^']}", bool(primes or scripts["^"]))

    def _base(self, token: str) -> str:
        name = token.removeprefix("\\")
        if token == name and token in ("_", "^", "'"):
            raise LatexError(f"begins with {token}, and a script needs something to stand on; give such as k{token}1")
        if token == "{":
            inside = self._inside("}")
            return inside if re.fullmatch(r"[A-Za-z0-9]|\\[A-Za-z]+ ", inside) else f"{{{inside}}}"
        if token != name and name in TEXTS:
            return self._words(token)
        if token != name and name in LIMITS:
            self.letters = True
            return f"{token} "
        if token != name and (name in ACCENTS or name in FONTS):
            return f"{token}{{{self._argument(token)}}}"
        return self._single(token)

    def _single(self, token: str) -> str:
        name = token.removeprefix("\\")
        if token == name and token.isalnum():
            self.letters |= token.isalpha()
            return token
        if token != name and name in GREEK | VARIANTS | MARKS:
            self.letters |= name not in MARKS
            return f"{token} "
        raise self._unknown(token)

    def _argument(self, of: str) -> str:
        token = self._next()
        if token is None:
            raise LatexError(f"ends behind {of}, which needs a symbol under it; give such as {of}{{k}}")
        inside = self._inside("}") if token == "{" else self._single(token)
        if re.search(r"[_^']", inside):
            raise LatexError(f"has scripts inside {of}; put them behind it, such as {of}{{k}}_1")
        return inside

    def _script(self) -> str:
        token = self._next()
        if token is None:
            raise LatexError(r"ends where a script should follow; give a symbol such as \kappa_1")
        name = token.removeprefix("\\")
        if token == "{":
            return self._inside("}")
        if token == "\\text":
            return self._words(token)
        if token.startswith("\\math") and name in FONTS and self.tokens[self.at : self.at + 1] == ["{"]:
            return f"{token}{{{self._argument(token)}}}"
        return token if token in SIGNS else self._single(token)

    def _words(self, of: str) -> str:
        closing = self.tokens.index("}", self.at) if "}" in self.tokens[self.at :] else len(self.tokens)
        text = "".join(self.tokens[self.at : closing]).lstrip(" ")
        if not _WORDS.fullmatch(text[1:]) or text[0] != "{":
            raise LatexError(f"has {of} without plain words in braces; give such as k_{of}{{max}}")
        self.at = closing + 1
        self.letters |= any(character.isalpha() for character in text)
        return f"{of}{text}}}"

    def _unknown(self, token: str) -> LatexError:
        if token in (*BRACKETS.values(), "}"):
            return LatexError("has brackets that do not pair; give a symbol such as k_{(1)}")
        return LatexError(f"holds {token}, which no symbol in a formula needs; {HELP}")


FORMULA_NAMES = (
    "pi", "deg", "sin", "cos", "tan", "sqrt", "exp", "log", "tanh", "abs", "sign", "atan2",
    "asin", "acos", "atan", "sinh", "cosh", "max", "min",
)  # fmt: skip

CLOCK = "t"
"""The time of formulas, which no letter can be called."""

C_KEYWORDS = (
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern",
    "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short",
    "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile",
    "while",
)  # fmt: skip

RESERVED = (*C_KEYWORDS, *FORMULA_NAMES)
"""Words of C and of formulas, that no name may be."""

_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")

LONGEST = 60

_FUNCTION = rf"\b({'|'.join(FORMULA_NAMES[1:])})"

_UNSURE = r"\*\*[-\d.]+[^\W\d_]|\b(ln|lg|log10|cot|sec|csc|arc[a-z]+) "  # e**2t, ln 2t

PRODUCTS = (
    (r"(?<![\w.])(\d+\.?\d*|\.\d+)(?![eE][+-]?\d)([^\W\d_])", r"\1*\2"),  # 2t
    (rf"{_FUNCTION} \(", r"\1("),
    (rf"{_FUNCTION} ([A-Za-z_]\w*)(?= *(?:[-+)]|$))", r"\1(\2)"),  # sin x, and not sin x/2
    (r"(?<=[\w)]) (?=[\w(])|(?<=\))(?=[\w(])", "*"),  # w t, (a)(b)
)


def meant(text: str, reads: Callable[[str], bool]) -> str:
    """Return what to write in a formula that breaks off: 2*sin(w*t) for 2 sin(w t), no keyword of Python; else ""."""
    known = {"and", "or", "not", "if", "else"}
    for word in (one for one in re.findall(r"\b[A-Za-z_]\w*", text) if keyword.iskeyword(one) and one not in known):
        return f', where "{word}" {check_name(word)}'
    if re.fullmatch(r"[+-]?\d+,\d+[^,()]*", text):
        return f"; write {text.replace(',', '.')}"
    product = text
    for pattern, written in PRODUCTS:
        product = re.sub(pattern, written, product)
    sure = product != text and not re.search(_UNSURE, text) and reads(product)
    return f"; write {product.replace('if_(', 'if(')}" if sure else ""


def foreign_sign(sign: str, text: str, reads: Callable[[str], bool]) -> str:
    """Return what is said of a sign that no formula has, and what to write in its place, in a text."""
    told = hint("characters", sign)
    if "{}" in told:
        power = re.sub(r"\b([a-z]+)\*\*(\d+)(\([^()]*\))", r"\1\3**\2", text.replace("^", "**"))
        cure = f"; write {power}" if reads(power) else meant(power, reads).replace(", where", "; write **, where")
        told = told.replace("; write {}", cure or "; write **")
    return told if sign in told else f"{sign!r} has no place in a formula{'; ' * bool(told)}{told}"


def check_name(name: object, letter: bool = False) -> str | None:
    """Return what is wrong with a name and what would work, or None for a good one; a `letter` is one of formulas."""
    fault = check_scene_name(name)
    if fault or not isinstance(name, str):
        return fault
    kinds = {"keyword of Python": keyword.kwlist, "keyword of C": C_KEYWORDS}
    for kind, words in (kinds | {"function or constant of formulas": FORMULA_NAMES}).items():
        if name in words:
            return f"is a {kind}; try {name}1"
    if letter and name == CLOCK:
        return f"is the time in formulas and runs; rename it, such as {name}_0"
    if name.endswith(("_dot", "_ddot")):
        return "ends like a velocity or an acceleration; leave _dot and _ddot to the coordinates"
    return None


def check_scene_name(name: object) -> str | None:
    """Return what is wrong with the name of a scene; it stands in no formula, and may be a word of any language."""
    if not isinstance(name, str):
        return f"is not text but of type {type(name).__name__}; give a name such as m1"
    if not name:
        return "is empty; give a name such as m1"
    if len(name) > LONGEST:
        return f"has {len(name)} characters; {LONGEST} are enough"
    if not _IDENTIFIER.match(name):
        better = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")
        hint = better if better and better[0].isalpha() and check_name(better, letter=True) is None else "link_1"
        return f"is not a plain identifier; use ASCII letters, digits and _ and begin with a letter, such as {hint}"
    if name.startswith("_"):
        return "begins with _, as only names inside generated code do; begin with a letter"
    return None


class _Pulling(Protocol):
    @property
    def kind(self) -> str: ...

    @property
    def name(self) -> str: ...

    @property
    def is_taut(self) -> bool: ...

    @property
    def ends(self) -> tuple[object, ...]: ...


@dataclass(frozen=True)
class SignalLetters:
    """What letters of what is looked at are made of.

    Attributes:
        reaction, multiplier, tension: what the letters of these begin with.
        components: of a reaction, force and moment.
        axes: what reactions are written in: axes of the child's body, of the joint frame on the parent, of the ground.
        loose: ends the names of what rigid bodies do not determine; their numbers are one choice among many.
        energies: of the whole scene, kinetic and potential.
        columns: what runs have beside what they are asked for.
    """

    reaction: str = "reaction_"
    multiplier: str = "multiplier_"
    tension: str = "tension_"
    components: tuple[str, ...] = ("fx", "fy", "fz", "mx", "my", "mz")
    axes: tuple[str, ...] = ("body", "joint", "ground")
    loose: str = "_not_unique"
    energies: tuple[str, ...] = ("kinetic_energy", "potential_energy")
    columns: tuple[str, ...] = (
        "kinetic_energy", "potential_energy", "energy_error", "drive_power", "other_power", "work", "loop_error",
        "loop_rate_error", "path_error",
    )  # fmt: skip

    def has_column(self, name: str) -> bool:
        """Tell whether runs have a column of this name that no person names."""
        return name in self.columns or name.startswith(
            ("point_", "momentum_", self.reaction, self.multiplier, self.tension)
        )

    @staticmethod
    def of_point(name: str) -> list[str]:
        """Return the names of a point's coordinates, velocities and accelerations, ground axes, three each."""
        return [f"point_{name}_{axis}{rate}" for rate in ("", "_dot", "_ddot") for axis in "xyz"]

    @staticmethod
    def of_strut(strut: _Pulling) -> dict[str, str]:
        """Return names of what is looked at: "force" of a spring or damper, between points its "length" and "rate"."""
        if strut.is_taut:  # of an elastic rope it is the tension
            return {}
        return {
            f"{strut.kind}_{strut.name}_{what}": what for what in ("force", "length", "rate")[: 3 if strut.ends else 1]
        }

    def of_struts(self, struts: Iterable[_Pulling]) -> tuple[str, ...]:
        """Return the names of all of them."""
        return tuple(name for one in struts for name in self.of_strut(one))

    @staticmethod
    def point_unit(name: str) -> str:
        """Return the unit of a coordinate of a point, of its velocity or acceleration, by how the name ends."""
        return {"dot": "m/s", "ddot": "m/s^2"}.get(name.rpartition("_")[2], "m")


LETTERS = SignalLetters()

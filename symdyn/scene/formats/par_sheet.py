"""The text of a Khalil parameter file: `KEY = value` and `KEY = {value, value, ...}`, comments in (* ... *).

Two programs have written such files, SYMORO+ with Mathematica's words (Pi, Cos[t1], ^) and OpenSYMORO with SymPy's
(pi, cos(t1), **). Keys are told apart without regard to case, as the two do not agree on it: Ant, ant.

The ten inertial parameters of a link about the origin of its frame, moved there exactly from a body frame.

With R and p the rotation and place of the body frame in the link frame, m, h and I those of the body about its origin:

    M = m      MS = R h + m p      J = R I Rᵀ + 2 (p·Rh) 1 - p (Rh)ᵀ - (Rh) pᵀ + m (p·p 1 - p pᵀ)
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from symdyn.bounds import BOUNDS
from symdyn.errors import SceneError
from symdyn.frozen import dataclass
from symdyn.scene.values import folding
from symdyn.scene.values.body import Body, Step, cosine_and_sine
from symdyn.scene.values.entry import Faults, shorten, show
from symdyn.scene.values.folding import UNARY_FUNCTIONS
from symdyn.scene.values.formula import split_commas
from symdyn.scene.values.quantity import NULL, Quantity, Vector

ROW_KEYS = ("ant", "sigma", "b", "d", "r", "gamma", "alpha", "mu", "theta")

LINK_KEYS = (
    "xx", "xy", "xz", "yy", "yz", "zz", "mx", "my", "mz", "m", "ia", "fv", "fs", "fx", "fy", "fz", "cx", "cy", "cz",
)  # fmt: skip

WRENCH = ("fx", "fy", "fz", "cx", "cy", "cz")

JOINT_KEYS = ("qp", "qdp", "gam", "eta", "k")

BASE_KEYS = ("w0", "wp0", "v0", "vp0", "g", "z")

SCALAR_KEYS = ("nf", "nl", "nj", "type", "is_floating", "is_mobile")

KEYS = (*SCALAR_KEYS, *ROW_KEYS, *LINK_KEYS, *JOINT_KEYS, *BASE_KEYS)

LONGEST_LIST = BOUNDS["values of a list of a .par file"]
MOST_FAULTS = 20

_SPACE = re.compile(r"\s*")
_STATEMENT = re.compile(r"([A-Za-z_]\w*)[ \t]*=[ \t]*(?:\n\s*)?(\{[^{}]*\}|[^{};\s][^{};\n]*)[ \t]*;?")
_REMARK = re.compile(r"\s*(Robotname|Link names|Joint names)\s*=\s*'([^'\n]*)'\s*\Z")
_WORDS = {"Pi": "pi", "PI": "pi", **{name.capitalize(): name for name in UNARY_FUNCTIONS}, "ArcTan2": "atan2"}


@dataclass(frozen=True)
class Sheet:
    """What a file says, value by value, in words that the formula reader takes.

    Attributes:
        remarks: "Robotname", "Link names" and "Joint names", where a comment gives them.
        values: by lower-case key; a single value is a list of one.
    """

    remarks: Mapping[str, str]
    values: Mapping[str, tuple[str, ...]]


def parse_sheet(text: str, faults: Faults) -> Sheet:
    """Return what a file says; keys that are not known are noted, what is no statement is a fault."""
    bare, comments = _without_comments(text, faults)
    remarks = {found[1]: found[2].strip() for comment in comments if (found := _REMARK.match(comment))}
    values: dict[str, tuple[str, ...]] = {}
    at = start = 0
    line = 1
    while (start := _SPACE.match(bare, at).end()) < len(bare) and len(faults.lines) < MOST_FAULTS:  # type: ignore[union-attr]
        line += bare.count("\n", at, start)
        found = _STATEMENT.match(bare, start)
        if found is None:
            what = show(bare[start : start + 200].split("\n", 1)[0])
            faults.add(f"line {line}", f"{what} is no statement; write KEY = value or KEY = {{value, value}}")
            break
        key, where, at = found[1].lower(), f"line {line}", found.end()
        line += bare.count("\n", start, at)
        if key not in KEYS:
            faults.note(where, f"{shorten(found[1])} is not a key of parameter files; it is left out")
        elif key in values:
            faults.add(where, f"{found[1]} is given twice; remove one of them")
        else:
            values[key] = _items(found[2])
            if len(values[key]) > LONGEST_LIST:
                faults.add(where, f"{found[1]} has {len(values[key])} values; {LONGEST_LIST} are allowed")
    return Sheet(remarks, values)


def _without_comments(text: str, faults: Faults) -> tuple[str, list[str]]:
    """Return the text with line breaks in place of comments, and the comments."""
    parts: list[str] = []
    comments: list[str] = []
    at = 0
    while (start := text.find("(*", at)) >= 0:
        end = text.find("*)", start + 2)
        if end < 0:
            faults.add(f"line {text.count(chr(10), 0, start) + 1}", "a comment begins that does not end; write *)")
            return "", comments
        comments.append(text[start + 2 : end])
        parts += [text[at:start], "\n" * comments[-1].count("\n")]
        at = end + 2
    return "".join([*parts, text[at:]]), comments


def _items(raw: str) -> tuple[str, ...]:
    """Return the values between commas outside brackets, in the formula reader's words."""
    text = " ".join(raw.strip().removeprefix("{").removesuffix("}").split())
    text = re.sub(r"[A-Za-z_]\w*", lambda word: _WORDS.get(word[0], word[0]), text)
    text = text.replace("[", "(").replace("]", ")").replace("^", "**")
    return tuple(split_commas(text)) or ("",)


# What a sheet must be to be read: rigid joints on a base at rest, with complete lists

IDENTITY = ("1", "0", "0", "0", "0", "1", "0", "0", "0", "0", "1", "0", "0", "0", "0", "1")


@dataclass(frozen=True)
class Counts:
    """How many frames a file has.

    Attributes:
        links: moving links, NL; their frames come first.
        joints: joints, NJ; those beyond the links are cut.
        frames: NF = 2 NJ - NL: every cut joint has a frame on either of the links that it connects.
    """

    links: int
    joints: int
    frames: int

    def lengths(self, key: str) -> tuple[int, ...]:
        """Return how many values a key may have."""
        if key in BASE_KEYS:
            return (16 if key == "z" else 3,)
        if key in SCALAR_KEYS:
            return (1,)
        most = dict.fromkeys((self.links, self.joints, self.frames))
        return (self.frames,) if key in ROW_KEYS else tuple(most)


def count_frames(sheet: Sheet, faults: Faults) -> Counts:
    """Return the numbers of links, joints and frames; those that do not fit together are refused."""
    found = {}
    for key in ("nl", "nj", "nf"):
        text = sheet.values.get(key, ("",))[0]
        if key != "nf" and key not in sheet.values:
            faults.add("", f"{key.upper()} is missing; write such as NL = 6, NJ = 6")
        elif re.fullmatch(r"\d{1,4}", text):
            found[key] = int(text)
        elif key != "nf" or text:
            faults.add("", f"{key.upper()} = {show(text)} is not a whole number; write such as NL = 6, NJ = 6")
    faults.close()
    nl, nj = found["nl"], found["nj"]
    counts = Counts(nl, nj, found.get("nf", 2 * nj - nl))
    if nj < nl or counts.frames != 2 * nj - nl:
        what = f"NL = {nl}, NJ = {nj}, NF = {counts.frames} do not fit together"
        advice = "a file of NL links and NJ joints, NJ - NL of them cut, has NF = 2 NJ - NL frames"
        raise SceneError(f"{faults.source}: {what}: {advice}; correct them")
    for key in KEYS:
        given = sheet.values.get(key)
        if given is not None and len(given) not in counts.lengths(key):
            faults.add("", f"{key} has {len(given)} values; {counts.lengths(key)[0]} are needed")
    for key in ("sigma", "theta", "m"):
        if key not in sheet.values:
            faults.add("", f"{key} is missing; give one value a frame")
    if nj > nl and "ant" not in sheet.values:
        faults.add("", "Ant is missing; where loops are closed it lists which links a cut joint connects")
    missing = [key.upper() for key in LINK_KEYS if key not in sheet.values and key not in WRENCH]
    if missing:
        faults.note("", f"{', '.join(missing)} are not given and read as zero")
    return counts


def refuse_motion_of_base(sheet: Sheet, faults: Faults) -> None:
    """Report what moves the base or bends the joints."""
    for key in ("is_floating", "is_mobile"):
        if sheet.values.get(key, ("0",))[0].lower() not in ("0", "false", ""):
            advice = "a free base is not read; write 0 to hold it, and give the scene a free joint in TOML"
            faults.add("", f"{key} = {sheet.values[key][0]}: {advice}")
    for key in ("w0", "wp0", "v0", "vp0"):
        if any(not is_zero(text) for text in sheet.values.get(key, ())):
            shown = show(list(sheet.values[key]))
            faults.add("", f"{key.upper()} = {shown}: the base of a scene is at rest; write zeros")
    for j, text in enumerate(sheet.values.get("eta", ())):
        if not is_zero(text):
            faults.add(f"frame {j + 1}", f"eta = {text}: joints of a scene are rigid; write 0")
    for j, text in enumerate(sheet.values.get("k", ())):
        if not is_zero(text):
            faults.note(f"frame {j + 1}", f"k = {text} is left out: the joint is rigid (eta = 0)")
    if sheet.values.get("z", IDENTITY) != IDENTITY:
        faults.note("", "Z, the place of frame 0 in the world, is left out: no equation depends on it")
    if "g" not in sheet.values:
        faults.add("", "G is missing; give the acceleration of free fall in frame 0, such as {0, 0, -9.81}")


def is_zero(text: str) -> bool:
    """Whether a value is left empty or a zero."""
    return re.fullmatch(r"[+-]?(0+\.?0*|\.0+)|", text) is not None


INERTIAL = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")

Matrix = list[list[Quantity]]


@dataclass(frozen=True)
class Link:
    """Inertial parameters as a parameter file names them; kg, kg m, kg m^2."""

    XX: Quantity = Quantity.ZERO
    XY: Quantity = Quantity.ZERO
    XZ: Quantity = Quantity.ZERO
    YY: Quantity = Quantity.ZERO
    YZ: Quantity = Quantity.ZERO
    ZZ: Quantity = Quantity.ZERO
    MX: Quantity = Quantity.ZERO
    MY: Quantity = Quantity.ZERO
    MZ: Quantity = Quantity.ZERO
    M: Quantity = Quantity.ZERO


NOTHING = Link()


def link(body: Body, steps: Sequence[Step]) -> Link:
    """Return the parameters of a body, whose frame is placed in the link frame by steps."""
    mass, moment, inertia = _about_frame(body)
    for kind, amount in reversed(steps):
        axis = "xyz".index(kind[1])
        if kind[0] == "R":
            moment, inertia = _turned(axis, amount, moment, inertia)
        else:
            x, y, z = (amount if k == axis else Quantity.ZERO for k in range(3))
            place = x, y, z
            inertia = _sum(inertia, _coupled(place, moment), _point(mass, place))
            moment = _plus(moment, _scaled(mass, place))
    return Link(
        XX=inertia[0][0], XY=inertia[0][1], XZ=inertia[0][2], YY=inertia[1][1], YZ=inertia[1][2], ZZ=inertia[2][2],
        MX=moment[0], MY=moment[1], MZ=moment[2], M=mass,
    )  # fmt: skip


def _about_frame(body: Body) -> tuple[Quantity, Vector, Matrix]:
    """Return mass, first moment and inertia of everything on the body about the origin of its frame."""
    xx, yy, zz, xy, xz, yz = body.inertia
    mass, inertia = body.mass, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    moment = body.first_moment or _scaled(mass, body.com or NULL)
    if body.about == "com":
        assert body.com is not None, "a first moment goes with an inertia about the frame"
        inertia = _sum(inertia, _point(mass, body.com))
    for particle in body.particles:
        mass = folding.add(mass, particle.mass)
        moment = _plus(moment, _scaled(particle.mass, particle.at))
        inertia = _sum(inertia, _point(particle.mass, particle.at))
    return mass, moment, inertia


def _turned(axis: int, angle: Quantity, moment: Vector, inertia: Matrix) -> tuple[Vector, Matrix]:
    rotation = _rotation(axis, angle)
    turned = _times(rotation, [[x] for x in moment])
    transposed = [list(column) for column in zip(*rotation, strict=True)]
    full = _times(_times(rotation, inertia), transposed)
    for i in range(3):
        for j in range(i):
            full[i][j] = full[j][i]  # equal, in another order of terms
    return (turned[0][0], turned[1][0], turned[2][0]), full


def _rotation(axis: int, angle: Quantity) -> Matrix:
    c, s = cosine_and_sine(angle)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    matrix = [[Quantity.ONE if a == b else Quantity.ZERO for b in range(3)] for a in range(3)]
    matrix[j][j], matrix[j][k], matrix[k][j], matrix[k][k] = c, folding.neg(s), s, c
    return matrix


def _point(mass: Quantity, place: Vector) -> Matrix:
    """Return m (p·p 1 - p pᵀ)."""
    x, y, z = place

    def of(a: Quantity, b: Quantity) -> Quantity:
        return folding.mul(mass, folding.mul(a, b))

    xx, yy, zz = of(x, x), of(y, y), of(z, z)
    xy, xz, yz = folding.neg(of(x, y)), folding.neg(of(x, z)), folding.neg(of(y, z))
    return [
        [folding.add(yy, zz), xy, xz],
        [xy, folding.add(xx, zz), yz],
        [xz, yz, folding.add(xx, yy)],
    ]


def _coupled(place: Vector, moment: Vector) -> Matrix:
    """Return 2 (p·h) 1 - p hᵀ - h pᵀ."""
    outer = [[folding.mul(a, b) for b in moment] for a in place]
    half = folding.add(folding.add(outer[0][0], outer[1][1]), outer[2][2])
    double = folding.mul(Quantity.number(2), half)
    return [
        [
            folding.sub(
                double if i == j else Quantity.ZERO,
                folding.add(outer[min(i, j)][max(i, j)], outer[max(i, j)][min(i, j)]),
            )
            for j in range(3)
        ]
        for i in range(3)
    ]


def _scaled(factor: Quantity, vector: Vector) -> Vector:
    x, y, z = (folding.mul(factor, part) for part in vector)
    return x, y, z


def _plus(a: Vector, b: Vector) -> Vector:
    x, y, z = (folding.add(p, q) for p, q in zip(a, b, strict=True))
    return x, y, z


def _sum(*matrices: Matrix) -> Matrix:
    total = matrices[0]
    for matrix in matrices[1:]:
        total = [[folding.add(a, b) for a, b in zip(x, y, strict=True)] for x, y in zip(total, matrix, strict=True)]
    return total


def _times(a: Matrix, b: Matrix) -> Matrix:
    return [[_dot(row, [line[j] for line in b]) for j in range(len(b[0]))] for row in a]


def _dot(a: Sequence[Quantity], b: Sequence[Quantity]) -> Quantity:
    total = Quantity.ZERO
    for x, y in zip(a, b, strict=True):
        total = folding.add(total, folding.mul(x, y))
    return total

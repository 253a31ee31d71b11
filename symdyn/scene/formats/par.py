"""Scenes from Khalil parameter files, `.par`, as SYMORO+ and OpenSYMORO write them.

Frame j hangs on frame a(j) by six parameters (Khalil & Kleinfinger 1986; Khalil & Dombre, Modeling, Identification and
Control of Robots, 2002, sections 3.2 and 4.2):

    pose of j in a(j) = Rz(γ) Tz(b) Rx(α) Tx(d) Rz(θ) Tz(r)

sigma = 0 turns about z by θ, sigma = 1 slides along z by r, sigma = 2 is fixed. The symbol that stands for θ or r of a
joint is its coordinate, a constant beside it an offset; every other symbol is a parameter without a value. Where loops
are closed, joints are cut, and each has a frame on either link: frame k beyond those of the links, with its variable,
on the one, frame k + NJ - NL on the other. Inertial parameters refer to the origin of frame j: M, MX MY MZ (mass times
centre of mass), XX XY ... ZZ (matrix entries). IA is the rotor, FV viscous and FS dry friction, GAM the driving force.
G is the acceleration of free fall in frame 0: the base accelerates by -G in SYMORO's recursion, as it does here.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from symdyn.bounds import BOUNDS
from symdyn.frozen import dataclass
from symdyn.graph import Op
from symdyn.scene.declaration.declare import Declaration, reading_of
from symdyn.scene.declaration.reading import Opened, Reading, ReadOptions, read_bounded
from symdyn.scene.formats.par_sheet import (
    SCALAR_KEYS,
    WRENCH,
    Sheet,
    count_frames,
    is_zero,
    parse_sheet,
    refuse_motion_of_base,
)
from symdyn.scene.formats.placing import printable_names, snap_angle
from symdyn.scene.values.body import Pose
from symdyn.scene.values.entry import Entry, Faults, compose, shorten, show
from symdyn.scene.values.folding import neg
from symdyn.scene.values.formula import parse, split_commas
from symdyn.scene.values.grammar import FORMULA_NAMES
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity, spell

LARGEST_FILE = BOUNDS["bytes of a .par file"]

INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")

ANGLES = ("gamma", "alpha", "theta")

UNREAD_KEYS = (*SCALAR_KEYS, *WRENCH, "qp", "qdp", "k", "z")
"""What no equation depends on; k is the stiffness of joints that bend, of which there are none."""

REVOLUTE, PRISMATIC, FIXED = 0, 1, 2

TYPES = ("revolute", "prismatic", "fixed")

_WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*")


def read(path: Path | Opened, options: ReadOptions) -> Reading:
    """Return the scene in a parameter file.

    Raises:
        SceneError: with every fault of the file, one line each.
    """
    content = read_bounded(path, LARGEST_FILE, "a parameter file such as arm.par", "no parameter file needs as much")
    return read_text(content.decode("utf-8", errors="replace"), str(path), options)


def read_text(text: str, source: str, options: ReadOptions = ReadOptions()) -> Reading:  # noqa: B008 - it is frozen
    """Return the scene in the text of a parameter file.

    Args:
        text: contents of the file.
        source: its name, for messages; its stem names a scene that has no Robotname.
        options: how to read.

    Raises:
        SceneError: with every fault of the text, one line each.
    """
    faults = Faults(source)
    sheet = parse_sheet(text, faults)
    faults.close()
    declaration = _Reader(sheet, faults, options).declaration(Path(source).stem)
    return reading_of(declaration, faults, options)


@dataclass(frozen=True)
class _Frame:
    """One frame of the file: its number from 1, its type and its antecedent."""

    j: int
    sigma: int
    ant: int


class _Reader:
    """One walk over one sheet; `parameters` are the symbols met so far that are no coordinates."""

    def __init__(self, sheet: Sheet, faults: Faults, options: ReadOptions) -> None:
        self.sheet, self.faults, self.options = sheet, faults, options
        self.symbols = self.printable(_words(sheet), "symbol")
        self.parameters: dict[str, None] = {}
        self.coordinates: dict[str, str] = {}

    def declaration(self, stem: str) -> Declaration:
        counts = count_frames(self.sheet, self.faults)
        n = counts.links
        refuse_motion_of_base(self.sheet, self.faults)
        self.faults.close()
        frames = [_Frame(j + 1, self.whole("sigma", j, 0, 2), self.whole("ant", j, 0, n)) for j in range(n)]
        bodies = self.names("Link names", "link", n)
        carriers = self.names("Joint names", "joint", counts.joints)
        variables = [self.variable(frame) for frame in frames]
        joints = [
            Entry(carriers[frame.j - 1], self.joint(frame, variable, (Scene.GROUND, *bodies)), f"frame {frame.j}")
            for frame, variable in zip(frames, variables, strict=True)
        ]
        loops = [
            Entry(carriers[j], self.loop(j, j + counts.joints - n, (Scene.GROUND, *bodies)), f"frame {j + 1}")
            for j in range(n, counts.joints)
        ]
        links = [Entry(bodies[j], self.body(j), f"frame {j + 1}") for j in range(n)]
        gravity = [self.value("g", k) for k in range(3)]
        name = self.sheet.remarks.get("Robotname") or stem
        return Declaration(
            name=printable_names([name], "robot")[name],
            gravity=gravity,
            parameters=tuple(Entry(p, {}, f"symbol {p}") for p in self.parameters if p not in self.coordinates),
            bodies=tuple(links),
            joints=tuple(joints),
            loops=tuple(loops),
        )

    def names(self, remark: str, default: str, n: int) -> list[str]:
        """Return the names that a comment gives, link1, link2, ... without one."""
        given = list(filter(None, split_commas(self.sheet.remarks.get(remark, ""))))
        if len(dict.fromkeys(given)) != n:
            return [f"{default}{j + 1}" for j in range(n)]
        return list(self.printable(given, default).values())

    def printable(self, names: Sequence[str], kind: str) -> dict[str, str]:
        """Return printable names; every change is noted."""
        chosen = printable_names(names, kind)
        for name, better in chosen.items():
            if name != better:
                self.faults.note("", f"the {kind} {shorten(name)} is called {better}")
        return chosen

    def variable(self, frame: _Frame) -> tuple[str, Quantity]:
        """Return the coordinate of a frame and its offset; ("", ZERO) for a fixed frame."""
        if frame.sigma == FIXED:
            return "", Quantity.ZERO
        key = "theta" if frame.sigma == REVOLUTE else "r"
        raw = self.value(key, frame.j - 1, declare=False)
        found = _split(raw)
        if found is None:
            example = "th1" if frame.sigma == REVOLUTE else "r1"
            advice = f"name the coordinate, such as {example}, alone or with a constant added to it"
            self.faults.add(f"frame {frame.j}", f"{key} = {spell(raw)} is no coordinate; {advice}")
            return "", Quantity.ZERO
        name, offset = found
        if name in self.coordinates:
            advice = "a joint that follows another one is not part of parameter files; give it a symbol of its own"
            self.faults.add(
                f"frame {frame.j}", f"{key} = {spell(raw)} is the coordinate of {self.coordinates[name]}; {advice}"
            )
        self.coordinates.setdefault(name, f"frame {frame.j}")
        return name, offset

    def joint(self, frame: _Frame, variable: tuple[str, Quantity], bodies: Sequence[str]) -> dict[str, object]:
        j, (coordinate, offset) = frame.j - 1, variable
        theta = offset if frame.sigma == REVOLUTE else self.value("theta", j)
        r = offset if frame.sigma == PRISMATIC else self.value("r", j)
        table: dict[str, object] = {
            "type": TYPES[frame.sigma],
            "parent": bodies[frame.ant],
            "child": bodies[frame.j],
            "origin": self.placement(j, theta, r),
        }
        if frame.sigma == FIXED:
            idle = [key.upper() for key in ("ia", "fv", "fs") if self.value(key, j) != Quantity.ZERO]
            if idle:
                self.faults.note(
                    f"frame {frame.j}", f"{', '.join(idle)} of a fixed frame: left out, nothing moves there"
                )
            return table
        table |= {"coordinate": coordinate, "drive": self.drive(frame)}
        for key, word in (("ia", "armature"), ("fv", "damping"), ("fs", "friction")):
            value = self.value(key, j)
            if value != Quantity.ZERO:
                table[word] = value
        return table

    def loop(self, j: int, other: int, bodies: Sequence[str]) -> dict[str, object]:
        """Return the table of a cut joint; `other` is the row of its frame on the other link that it connects."""
        n = len(bodies) - 1
        sigma = self.whole("sigma", j, 0, 2)
        amounts = {key: self.value(key, j, declare=key != self.variable_key(sigma)) for key in ("theta", "r")}
        if sigma != FIXED:  # its variable is no coordinate, only what stands beside it counts
            key = self.variable_key(sigma)
            found = _split(amounts[key])
            amounts[key] = found[1] if found else amounts[key]
            self.parameters.update(dict.fromkeys(amounts[key].symbols))
        back = self.placement(other, self.value("theta", other), self.value("r", other))
        return {
            "type": TYPES[sigma],
            "parent": bodies[self.whole("ant", j, 0, n)],
            "child": bodies[self.whole("ant", other, 0, n)],
            "origin": self.placement(j, amounts["theta"], amounts["r"]),
            "tip": back.inverse(),
        }

    @staticmethod
    def variable_key(sigma: int) -> str:
        """Return which of the six parameters moves."""
        return {REVOLUTE: "theta", PRISMATIC: "r"}.get(sigma, "")

    def placement(self, j: int, theta: Quantity, r: Quantity) -> Pose:
        gamma, b, alpha, d = (self.value(key, j) for key in ("gamma", "b", "alpha", "d"))
        return compose(("Rz", gamma), ("Tz", b), ("Rx", alpha), ("Tx", d), ("Rz", theta), ("Tz", r))

    def drive(self, frame: _Frame) -> str | bool:
        """Return the name of the driving force: GAM where it is a symbol; False for a passive joint."""
        if "mu" in self.sheet.values and not self.whole("mu", frame.j - 1, 0, 1):
            return False
        text = self.sheet.values.get("gam", ("",) * frame.j)[frame.j - 1]
        return self.symbols.get(text, True)

    def body(self, j: int) -> dict[str, object]:
        self.wrench(j)
        return {
            "mass": self.value("m", j),
            "first_moment": [self.value(key, j) for key in ("mx", "my", "mz")],
            "inertia": {key: self.value(key, j) for key in INERTIA},
            "inertia_about": "frame",
        }

    def wrench(self, j: int) -> None:
        """Read no external wrench: OpenSYMORO's own placeholders are noted, any other one is refused."""
        texts = [self.sheet.values[key][j] for key in WRENCH if key in self.sheet.values]
        acting = [text for text in texts if not is_zero(text)]
        placeholders = [text for text in acting if text.upper() in {f"{key}{j + 1}".upper() for key in WRENCH}]
        if acting and acting == placeholders:
            self.faults.note(f"frame {j + 1}", f"the external wrench {', '.join(acting)} is read as zero")
        elif acting:
            shown = ", ".join(text for text in acting if text not in placeholders)
            advice = "external wrenches are not read; write 0, and give the scene a load in TOML"
            self.faults.add(f"frame {j + 1}", f"an external wrench {shown} acts on the link; {advice}")

    def whole(self, key: str, j: int, least: int, most: int) -> int:
        """Return a whole number; antecedents default to a chain."""
        text = self.sheet.values[key][j] if key in self.sheet.values else str(j if key == "ant" else 0)
        if re.fullmatch(r"\d{1,4}", text) and least <= int(text) <= most:
            return int(text)
        what = f"{key} = {show(text)} is not a whole number from {least} to {most}"
        self.faults.add(f"frame {j + 1}", f"{what}; correct it")
        return least

    def value(self, key: str, j: int, declare: bool = True) -> Quantity:
        """Return a value of the file, 0 if it is not given; its symbols become parameters."""
        if key not in self.sheet.values:
            return Quantity.ZERO
        text = self.sheet.values[key][j]
        where = f"frame {j + 1}" if key != "g" else ""
        if key in ANGLES and self.options.snap and (snapped := snap_angle(text)):
            self.faults.note(where, f"{key} = {text} is read as {spell(snapped)}")
            return snapped
        try:
            found = parse(_WORD.sub(lambda word: self.symbols.get(word[0], word[0]), text))
        except FormulaError as error:
            self.faults.add(where, f"{key} = {error}")
            return Quantity.ZERO
        if declare:
            self.parameters.update(dict.fromkeys(found.symbols))
        return found


def _words(sheet: Sheet) -> list[str]:
    """Return the symbols of the file in order, each once."""
    texts = (text for key, values in sheet.values.items() if key not in UNREAD_KEYS for text in values)
    words = dict.fromkeys(word for text in texts for word in _WORD.findall(text))
    return [word for word in words if word not in FORMULA_NAMES or word == "deg"]


def _split(value: Quantity) -> tuple[str, Quantity] | None:
    """Return the symbol and the constant of symbol, symbol ± constant or constant + symbol, None for anything else."""
    if value.op is Op.SYMBOL:
        return str(value.value), Quantity.ZERO
    if value.op in (Op.ADD, Op.SUB):
        first, second = value.args
        if first.op is Op.SYMBOL and not second.symbols:
            return str(first.value), second if value.op is Op.ADD else neg(second)
        if value.op is Op.ADD and second.op is Op.SYMBOL and not first.symbols:
            return str(second.value), first
    return None

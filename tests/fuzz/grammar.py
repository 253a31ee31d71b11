"""Scenes, formulas, tables and homework by grammar: most are whole and right, and some have a hostile leaf."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

Table = dict[str, Any]

LETTERS = {
    "m1": "mass", "m2": "mass", "l": "length", "h1": "length", "g": "acceleration", "k": "stiffness", "c_1": "damping",
    "alpha": "angle", "J": "inertia", "r": "length", "T0": "force",
}  # fmt: skip
"""Parameters, and what they measure; some are open, some have values."""

NAMES = tuple(LETTERS)

UNITS = {
    "mass": ("kg", "g"), "length": ("m", "mm"), "acceleration": ("m/s^2",), "stiffness": ("N/m", "kN/m"),
    "damping": ("N s/m",), "angle": ("rad", "deg"), "inertia": ("kg m^2", "g m^2"), "force": ("N", "mN"),
    "angular rate": ("rad/s", "rpm"), "velocity": ("m/s", "mm/s"), "torque": ("N m", "mN m"),
    "rotary damping": ("N m s/rad",), "rotary stiffness": ("N m/rad",),
}  # fmt: skip

PRODUCTS = {
    "inertia": ("m1*l**2", "m2*l*r", "m1*(l**2 + h1**2)"), "torque": ("m1*g*l*sin(alpha)", "T0*r"),
    "force": ("m1*g", "k*l", "k*h1*cos(alpha)"), "length": ("l*cos(alpha)", "sqrt(l**2 + h1**2)", "r*alpha"),
    "angle": ("atan2(l, h1)", "l/r"), "rotary stiffness": ("k*l**2",), "rotary damping": ("c_1*l**2",),
}  # fmt: skip
"""What letters make that measures the same."""

BODIES = ("arm", "link", "bob")
POINTS = ("tip", "P")

FREE_KEYS = {  # what a type of joint takes beside its place
    "revolute": ("axis",),
    "prismatic": ("axis",),
    "helical": ("axis", "pitch"),
    "cylindrical": ("axis",),
    "universal": ("axis", "second_axis"),
    "spherical": ("orientation",),
    "planar": ("axis",),
    "point_on_line": ("axis", "orientation"),
    "point_on_plane": ("axis", "orientation"),
    "rod": ("length", "orientation"),
    "free": ("orientation",),
    "fixed": (),
}
WEIGHTS = (30, 20, 3, 3, 3, 6, 5, 2, 2, 2, 5, 4)
SINGLE = ("revolute", "prismatic", "helical")

AXES = ([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1], [1, 1, 0], [1, 2, 2], ["1/3", "2/3", "2/3"])

NASTY: tuple[Any, ...] = (
    *(0, -1, 1e400, -1e400, 1e-400, 1.797e308, 5e-324, 10**30, 10**400, 0.1 + 0.2, True, "", " ", [], {}, [[]], [{}]),
    *("none", "nan", "inf", "-inf", "1/0", "0/0", "0**0", "0**-1", "(-1)**0.5", "2**0.5", "log(0)", "log(1e-400)"),
    *("sqrt(-1)", "atan2(0,0)", "tan(pi/2)", "exp(1000)", "exp(exp(10))", "9**9**9", "1e999", "1e-999", "10**400"),
    *("(", ")", "((((((1))))))", "-" * 40 + "1", "sin", "sin(", "sin()", "sin(1,2)", "1 2", "1,2", "q1", "t", "x_dot"),
    *(
        "m1.a",
        "m1[0]",
        "m1 m2",
        "m1**m2",
        "m1/0",
        "1//2",
        "2^3",
        "0x10",
        "1_000",
        "٣",
        "π",
        "½",
        "é",
        "1e",
        "e5",
        ".",
        "+",
    ),
    *("500 mm", "500mm", "3 rpm", "3 Hz", "3 deg C", "1/3 kN/m", "3 m", "3 N/m s", "3 %", "1 furlong", "3 µm", "3 m^9"),
    *("1e400 mm", "3 (m", "3 1/s", "m**99", "kg m^2", "1/0 m", "/", "9" * 60 + " t", "5 m m m m m m m m m m m m"),
    *("90 deg", "90deg", "deg", "pi deg", "1 deg deg", "ground", "arm", "CON", "__class__", "import os", "lambda: 0"),
    *(
        "a\nb",
        "a\tb",
        "a\rb",
        "\x1b[31m",
        "\x00",
        "\x7f",
        "\x9b",
        "\u202e",
        "\ufeff",
        "\U0001f600",
        "a" * 70,
        "%s%n",
        "{0}",
    ),
    *(
        "\\",
        "\\input{x}",
        "\\alpha",
        "\\frac{a}{b}",
        "$x$",
        "a_b",
        "_",
        "^",
        "a^b^c",
        "{",
        "}",
        "\\left(",
        "%",
        "#",
        "&",
        "~",
    ),
    *(
        "<b>",
        "</script>",
        "&amp;",
        "*/",
        '"',
        "'",
        "`",
        "|",
        ";",
        "*",
        "../x",
        "/",
        "x.toml",
        "-o",
        "--",
        "abs(m1)",
        "sign(0)",
    ),
    *(
        [1],
        [1, 2],
        [1, 2, 3, 4],
        [0, 0, 0],
        ["none", 0, 1],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        {"xx": 1},
        {"at": [0, 0, 0]},
    ),
    *("+".join(["m1"] * 60), "*".join(["sin(m1)"] * 30), "(" * 120 + "1" + ")" * 120, "m1" + "**2" * 30),
)


ODD = 0.01
"""Share of numbers that may measure something else than what is asked for."""


def chance(rng: Random, share: float) -> bool:
    """Return True in that share of cases."""
    return rng.random() < share


def scene(rng: Random, most: int, open_ones: bool = True) -> Table:
    """Return a scene of at most so many bodies as a nested table, its parameters perhaps without values."""
    bodies = [f"{rng.choice(BODIES)}{k}" for k in range(rng.choice((1, 1, 1, 2, 2, 3, 3, most)))][:most]
    made: Table = {"name": rng.choice(("rig", "two_link", "A1"))} if chance(rng, 0.7) else {}
    if chance(rng, 0.8):
        made["gravity"] = rng.choice(([0, 0, -9.81], [0, "-g", 0], "none", [0, 0, "-g"], [0, -9.81, 0]))
    made["parameters"] = {name: _parameter(rng, name, open_ones) for name in NAMES}
    if chance(rng, 0.06):
        return made | {"dh": _denavit_hartenberg(rng, bodies)}
    made["bodies"] = {body: _body(rng) for body in bodies}
    made["joints"] = {f"j{k}": _joint(rng, bodies[:k], body) for k, body in enumerate(bodies)}
    parts: dict[str, tuple[float, Callable[[Random, list[str]], Any]]] = {
        "points": (0.4, lambda rng, bodies: {rng.choice(POINTS): {"body": rng.choice(bodies), "at": _vector(rng)}}),
        "springs": (0.2, lambda rng, bodies: {"coil": _spring(rng, bodies)}),
        "dampers": (0.15, lambda rng, bodies: {"shock": _ends(rng, bodies) | {"damping": rng.choice((1, 0.5))}}),
        "loads": (0.15, lambda rng, bodies: {"push": _load(rng, bodies)}),
        "constraints": (0.12, lambda rng, bodies: {"contact": _row(rng, bodies)}),
        "loop": (0.1, lambda rng, bodies: [_loop(rng, bodies)]),
    }
    for part, (share, make) in parts.items():
        if chance(rng, share):
            made[part] = make(rng, bodies)
    return made


def _denavit_hartenberg(rng: Random, bodies: list[str]) -> Table:
    def row(name: str) -> Table:
        keys = {"theta": "angle", "d": "length", "a": "length", "alpha": "angle"}
        numbers = {key: number(rng, measures) for key, measures in keys.items() if chance(rng, 0.6)}
        return {"name": name, "type": rng.choice(SINGLE[:2])} | numbers | (_body(rng) if chance(rng, 0.7) else {})

    return {"convention": rng.choice(("standard", "modified")), "links": [row(name) for name in bodies]}


def formula(rng: Random, names: tuple[str, ...], depth: int = 2) -> str:
    """Return a formula in `names`."""
    if depth == 0 or chance(rng, 0.3):
        return rng.choice((*names, "1", "2", "0.5", "1/3", "pi", "30 deg"))
    a, b = formula(rng, names, depth - 1), formula(rng, names, depth - 1)
    shapes = (f"{a} + {b}", f"{a}*{b}", f"({a} - {b})", f"{a}/2", f"-{a}", f"({a})**2", f"sin({a})", f"cos({a})")
    return rng.choice((*shapes, f"sqrt({a}**2 + 1)", f"tanh({a})", f"atan2({a}, {b})", f"exp(-{a}**2)", f"abs({a})"))


def number(rng: Random, measures: str = "") -> Any:
    """Return a number, as text or not, or a formula in parameters, of what it measures; now and then of anything."""
    kind = rng.randrange(8)
    if kind < 3:
        return rng.choice((0, 1, 2, 0.5, 0.25, 1.5, -1, 3))
    if kind < 5:
        return round(rng.uniform(-2, 2), rng.randrange(5))
    if not measures or chance(rng, ODD):
        return rng.choice(("1/3", "90 deg", "500 mm", "pi/2", rng.choice(NAMES), formula(rng, NAMES, 1)))
    return rng.choice(("1/3", "pi/2", "-pi/4", f"1/4 {rng.choice(UNITS[measures])}", _same(rng, measures)))


def _same(rng: Random, measures: str) -> str:
    """Return a formula in parameters that measures this."""
    fit = [name for name, own in LETTERS.items() if own == measures] + list(PRODUCTS.get(measures, ())) or ["0.7"]
    a, b = rng.choice(fit), rng.choice(fit)
    return rng.choice((a, f"{a}/2", f"2*({a})", f"{a} + {b}", f"{a} - 2*({b})", f"-({a})", f"{a}*cos(alpha)"))


def _over_time(rng: Random, measures: str) -> str:
    """Return a formula of the time that measures this."""
    size = _same(rng, measures) if chance(rng, 0.4) else "0.3"
    return rng.choice((f"({size})*sin(2*t)", f"0.2*t**2 - ({size})", f"({size})*exp(-0.5*t)", f"({size}) + t/7"))


def table(rng: Random, names: tuple[str, ...]) -> str:
    """Return a CSV table over time."""
    columns = ("t", *names)
    rows = [[0.1 * k, *(round(rng.uniform(-1, 1), 3) for _ in names)] for k in range(rng.choice((2, 3, 5, 20)))]
    return "\n".join(",".join(map(str, row)) for row in (columns, *rows)) + "\n"


def lines(rng: Random, names: tuple[str, ...], leaves: tuple[str, ...]) -> str:
    """Return a TOML file of formulas."""
    head = rng.choice(("", "[forces]\n", "[motion]\n"))
    return head + "".join(f'{name} = "{formula(rng, leaves)}"\n' for name in names)


def homework(rng: Random) -> str:
    """Return a student's formulas for a two-link arm."""
    symbols = (
        "m_1",
        "m_2",
        "h_1",
        "h_2",
        "g",
        r"\cos q_2",
        "s_1",
        "c_{12}",
        r"\dot q_1",
        "q_2'",
        "q1_dot",
        r"\ddot{q}_2",
    )
    heads = (
        "k_{z,11}",
        "k_{z12}",
        "k_{C,122}",
        "k_{G1}",
        "M_1",
        r"\tau_2",
        "tau1",
        "K",
        "P",
        "L",
        "k_z22",
        "k_{D,211}",
    )

    def term() -> str:
        factors = [rng.choice(symbols) for _ in range(rng.choice((1, 2, 3, 4)))]
        powers = [f"{one}^2" if chance(rng, 0.2) else one for one in factors]
        return rng.choice(("", "2 ", "0.5 ", r"\frac{1}{2} ", "-", "1/2 ")) + rng.choice((" ", "*", r" \, ")).join(
            powers
        )

    def equation() -> str:
        return f"{rng.choice(heads)} = {' + '.join(term() for _ in range(rng.choice((1, 2, 3))))}"

    text = "\n".join(equation() for _ in range(rng.choice((1, 1, 2, 4))))
    return rng.choice((text, f"\\[ {text} \\]", f"\\begin{{align}} {text} \\end{{align}}", f"Let {text}."))


def _parameter(rng: Random, name: str, may_be_open: bool) -> Any:
    measures = "length" if chance(rng, ODD) else LETTERS[name]
    unit = rng.choice(UNITS[measures])
    full = {"value": rng.choice((1, 2, 0.3, "1/3")), "unit": unit, "positive": True, "text": "of it", "latex": r"\mu_1"}
    said = ({"value": 5, "unit": unit}, f"3/2 {unit}", {"value": f"1.2 {UNITS[measures][0]}", "unit": unit})
    known = (1, 0.5, full, *said, said[0] | {"tolerance": 0.5})
    return rng.choice((*known, {}, {"positive": True}) if may_be_open else known)


def _mass(rng: Random) -> Any:
    return rng.choice((1, 2, 0.5, "m1", "m1 + m2", "m1/2", "2*m2"))


def _vector(rng: Random, measures: str = "length") -> list[Any]:
    if chance(rng, 0.5):
        made: list[Any] = [0, 0, 0]
        made[rng.randrange(3)] = number(rng, measures)
        return made
    return [number(rng, measures) for _ in range(3)]


def _pose(rng: Random) -> Any:
    kinds = rng.choices(("Tx", "Ty", "Tz", "Rx", "Ry", "Rz"), k=rng.choice((1, 2)))
    steps = [[kind, number(rng, "length" if kind[0] == "T" else "angle")] for kind in kinds]
    turned = {"xyz": _vector(rng), "rpy": _vector(rng, "angle")}
    return rng.choice((_vector(rng), {"xyz": _vector(rng)}, turned, steps))


def _body(rng: Random) -> Table:
    if chance(rng, 0.4):
        return {"particles": [{"mass": _mass(rng), "at": _vector(rng)} for _ in range(rng.choice((1, 1, 2)))]}
    inertia = rng.choice(
        ([1, 1, 1], ["J", "J", "J"], [2, 2, 1.5], ["m1*l**2", "m1*l**2", "m1*l**2"], {"xx": 2, "yy": 2, "zz": 2})
    )
    return {
        "mass": _mass(rng),
        "com": _vector(rng),
        "inertia": inertia,
        "inertia_about": "frame" if chance(rng, 0.1) else "com",
    }


def _shape(rng: Random, kind: str) -> Table:
    values = {
        "axis": rng.choice(AXES[:4]) if kind == "universal" else rng.choice(AXES),
        "second_axis": [1, 0, 0] if chance(rng, 0.5) else [0, 1, 0],
        "pitch": 0.1,
        "length": rng.choice((1, "l")),
        "orientation": rng.choice(("zyx", "xyz", "zxz", "quaternion")),
    }
    return {key: values[key] for key in FREE_KEYS[kind]}


def _joint(rng: Random, before: list[str], child: str) -> Table:
    kind = rng.choices(tuple(FREE_KEYS), WEIGHTS)[0]
    made: Table = {"type": kind, "parent": rng.choice(["ground", *before, *before]), "child": child} | _shape(rng, kind)
    if chance(rng, 0.4):
        made[rng.choice(("origin", "tip"))] = _pose(rng)
    if kind in SINGLE:
        slides = kind == "prismatic"
        way, rate, force = ("length", "velocity", "force") if slides else ("angle", "angular rate", "torque")
        extras: dict[str, Any] = {
            "damping": rng.choice((1, 0.5, "2*c_1" if slides else "c_1*l**2")),
            "armature": 0.1,
            "friction": rng.choice((0.1, {"coulomb": 0.4, "smoothing": 0.01})),
            "limits": {"lower": -1, "upper": 1},
            "motion": formula(rng, ("t",)) if chance(rng, ODD) else _over_time(rng, way),
            "force": formula(rng, ("t", "m1")) if chance(rng, ODD) else _over_time(rng, force),
            "start": number(rng, way),
            "start_rates": number(rng, rate),
            "rotor": {"inertia": 0.01, "gear": 50},
            "drive": rng.choice((False, f"tau_{child}")),
            "coordinate": f"{rng.choice(('x', 'phi', 'th'))}_{child}",
            "locked": True,
        }
        if before and chance(rng, 0.05):
            made["mimic"] = {"joint": "j0", "ratio": 2}
        else:
            made |= {key: value for key, value in extras.items() if chance(rng, 0.08)}
    return made


def _ends(rng: Random, bodies: list[str]) -> Table:
    place = {"body": rng.choice(bodies), "at": _vector(rng)}
    return rng.choice(({"joint": "j0"}, {"from": place, "to": "ground"}, {"from": bodies[-1], "to": "ground"}))


def _spring(rng: Random, bodies: list[str]) -> Table:
    return (
        _ends(rng, bodies)
        | {"stiffness": rng.choice((1, 20, 0.5, "3*k", [10, 1]))}
        | ({"free": 0.5} if chance(rng, 0.5) else {})
    )


def _load(rng: Random, bodies: list[str]) -> Table:
    key, measures = rng.choice((("force", "force"), ("couple", "torque")))
    push = formula(rng, ("t", "m1", "g")) if chance(rng, ODD) else _over_time(rng, measures)
    return {
        "body": rng.choice(bodies),
        "at": _vector(rng),
        key: [push, 0, 1],
        "frame": rng.choice(("ground", "body")),
    }


def _row(rng: Random, bodies: list[str]) -> Table:
    body = rng.choice(bodies)
    return rng.choice(
        (
            rng.choice(({"formula": "q1_dot - 2*q2_dot"}, {"formula": "q1_dot", "acts_in": "joints"})),
            {"type": "knife_edge", "body": body, "at": _vector(rng), "axis": rng.choice(AXES)},
            {
                "type": "rolling",
                "body": body,
                "axis": rng.choice(AXES),
                "radius": "r",
                "components": ["along", "across"],
            },
        )
    )


def _loop(rng: Random, bodies: list[str]) -> Table:
    kind = rng.choice(("revolute", "spherical", "rod", "point_on_plane", "cylindrical"))
    made = {"name": "close", "type": kind, "parent": "ground", "child": bodies[-1]} | _shape(rng, kind)
    return made | {"origin": _vector(rng), "tip": _vector(rng)}

"""Sines and cosines of several angles at once, by the steps of `templates/c/sincos.c.jinja`: the same bits.

Angles that are not below 2^20 in size, infinities and what is not a number go to Math.sin and Math.cos, each alone.
What C leaves out below 2^-240, lest a product underflow, may underflow here: nobody sees flags, and nothing changes.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.emit.targets.c.sincos import COSINE, HALF_PI, LIMIT_EXPONENT, SINE, TWO_OVER_PI, in_halves
from symdyn.emit.targets.wasm.encoding import EMPTY, F64, I32, V128, Body, Signature, at, real, signed, unsigned
from symdyn.emit.targets.wasm.instructions import Instructions

CHAINS = 3
"""Vectors of two angles that are taken at once: one waits for its own results most of the time."""

ROW = 16
"""Bytes of a vector. Results have two rows for each: sines, then cosines."""

SINES = in_halves([-coefficient for coefficient in SINE["double"]], 1)
COSINES = in_halves(COSINE["double"], 2)

CONSTANTS = {
    "LIMIT": 2.0**LIMIT_EXPONENT,
    "TWO/PI": TWO_OVER_PI,
    "SHIFT": 6755399441055744.0,  # 1.5 2^52: what is added to it loses its fraction, its last bits are an integer's
    **{f"PART{number}": part for number, part in enumerate(HALF_PI)},
    "HALF": 0.5,
    "ONE": 1.0,
    "SIGN_BIT": -0.0,
    "NO_BIT": 0.0,
    "LAST_BIT": 5e-324,
    **{f"S{number}": coefficient for number, coefficient in enumerate(SINES)},
    **{f"C{number}": coefficient for number, coefficient in enumerate(COSINES)},
}


def _horner(letter: str, coefficients: Sequence[float]) -> str:
    """Return c0 + h (c1 + h (...)) in the notation of the steps."""
    factors = " h ".join(f"{letter}{number}" for number, _ in enumerate(coefficients))
    return factors + " * +" * (len(coefficients) - 1)


STEPS = f"""
shifted = a TWO/PI * SHIFT +
n = shifted SHIFT -
t1 = a n PART0 * -
p = n PART1 *
t2 = t1 p -
e2 = n PART2 * t1 t2 - p - -
y = t2 e2 -
over = e2 t2 y - - n PART3 * +
h = HALF y y * *
sine = y h y * {_horner("S", SINES)} * over + -
w = ONE h -
cosine = w ONE w - h - h h * {_horner("C", COSINES)} * + y over * + +
sign = shifted <<62 SIGN_BIT &
swap = sine cosine ^ NO_BIT shifted LAST_BIT & i- &
s = sine swap ^ sign ^
c = cosine swap ^ sign ^ shifted <<63 ^
small = a abs LIMIT <
"""
"""One value a line, operations behind their operands; the names are those of the C."""

OPERATIONS = {
    "abs": "f64x2.abs",
    "+": "f64x2.add",
    "-": "f64x2.sub",
    "*": "f64x2.mul",
    "<": "f64x2.lt",
    "&": "v128.and",
    "^": "v128.xor",
    "i-": "i64x2.sub",
}

ANGLES = tuple(f"a{chain}" for chain in range(CHAINS))

ROWS = "rows"


def sincos(large: int) -> Body:
    """Return the function of vectors of angles, which leaves its rows at an address; `large` is the number of another.

    That one is called where an angle is large.
    """
    signature = Signature((I32, *[V128] * CHAINS), ())
    code = Instructions({ROWS: I32, **dict.fromkeys(ANGLES, V128)})
    for line in STEPS.strip().split("\n"):
        name, text = line.split(" = ")
        for chain in range(CHAINS):
            _write(code, text, chain)
            code.set(f"{name}{chain}", V128)
    for chain in range(CHAINS):
        for row, name in enumerate("sc"):
            code.get(ROWS)
            code.get(f"{name}{chain}")
            code.add("v128.store", at((2 * chain + row) * ROW))
    code.get("small0")
    for chain in range(1, CHAINS):
        code.get(f"small{chain}")
        code.add("v128.and")
    code.add("i64x2.bitmask")
    code.add("i32.const", signed(3))
    code.add("i32.ne")
    code.add("if", EMPTY)
    for chain in range(CHAINS):
        code.get(ROWS)
        code.add("i32.const", signed(2 * chain * ROW))
        code.add("i32.add")
        code.get(ANGLES[chain])
        code.add("call", unsigned(large))
    code.add("end")
    variables, encoded = code.encoded(signature, (ROWS, *ANGLES))
    return Body("sincos", signature, variables, encoded, exported=False)


def large_angles(sine: int, cosine: int) -> Body:
    """Return the function that writes the rows of one vector again, for its large angles, by those two."""
    signature = Signature((I32, V128), ())
    code = Instructions({ROWS: I32, "a": V128})
    for lane in (0, 1):
        code.get("a")
        code.add("f64x2.extract_lane", bytes([lane]))
        code.set("x", F64)
        code.get("x")
        code.add("f64.abs")
        code.add("f64.const", real(CONSTANTS["LIMIT"]))
        code.add("f64.lt")
        code.add("i32.eqz")
        code.add("if", EMPTY)
        for row, number in enumerate((sine, cosine)):
            code.get(ROWS)
            code.get("x")
            code.add("call", unsigned(number))
            code.add("f64.store", at(row * ROW + 8 * lane))
        code.add("end")
    variables, encoded = code.encoded(signature, (ROWS, "a"))
    return Body("large_angles", signature, variables, encoded, exported=False)


def _write(code: Instructions, text: str, chain: int) -> None:
    """Add what computes one value."""
    for word in text.split():
        if word in CONSTANTS:
            code.add("f64.const", real(CONSTANTS[word]))
            code.add("f64x2.splat")
        elif word in OPERATIONS:
            code.add(OPERATIONS[word])
        elif word.startswith("<<"):
            code.add("i32.const", signed(int(word[2:])))
            code.add("i64x2.shl")
        else:
            code.get(f"{word}{chain}")

"""Makes gradients.json, `python tests/data/gradients.py` (minutes): ends of runs of 1 s and their derivatives.

Equations typed by hand, by other methods than symdyn's (one equation in the crank's angle, moments about the contact),
integrated by mpmath's Taylor method at 30 digits. Derivatives are central differences of step 1e-11 of whole runs: the
error is some 1e-18, of which the differences of step 2e-11 of the first column are witnesses.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from mpmath import acos, atan2, cos, eye, lu_solve, matrix, mp, mpf, norm, odefun, pi, sin, sqrt

mp.dps = 34
H = mpf(10) ** -11
TOLERANCE = mpf(10) ** -30

Numbers = list


def integrated(rates: Callable, x: Numbers) -> Numbers:
    return list(odefun(lambda t, x: rates(x), 0, x, tol=TOLERANCE)(1))


# Pendulum: q1, q1_dot, cos q1, sin q1; m l² q̈ = -m g l sin q - b q̇


def pendulum(start: dict, p: dict) -> Numbers:
    def rates(x):
        _, w, c, s = x
        return [w, -p["g"] / p["l"] * s - p["b"] / (p["m"] * p["l"] ** 2) * w, -s * w, c * w]

    q = start["q1"]
    return integrated(rates, [q, start["q1_dot"], cos(q), sin(q)])[:2]


# Four-bar: a e^iφ + b e^iβ = d + c e^iχ; I(φ) φ̈ + I'(φ) φ̇²/2 + V'(φ) = 0, ' = d/dφ; angles, φ̇, cosines and sines


def four_bar(start: dict, p: dict) -> Numbers:
    a, b, c, d, m1, m2, m3, g = (p[name] for name in ("a", "b", "c", "d", "m1", "m2", "m3", "g"))
    J1, J2, J3, mixed = (m1 / 3 + m2) * a**2, m2 * b**2 / 3, m3 * c**2 / 3, m2 * a * b

    def ratios(cp, cb, cc, sp, sb, sc):
        """Return β', χ', β'', χ'' by the loop differentiated once and twice."""
        D = b * c * (sb * cc - cb * sc)

        def solved(x, y):  # of -b sβ β + c sχ χ = x, b cβ β - c cχ χ = y
            return (-c * cc * x - c * sc * y) / D, (-b * sb * y - b * cb * x) / D

        b1, c1 = solved(a * sp, -a * cp)
        x, y = a * cp + b * cb * b1**2 - c * cc * c1**2, a * sp + b * sb * b1**2 - c * sc * c1**2
        return (b1, c1, *solved(x, y))

    def rates(x):
        w, (cp, cb, cc, sp, sb, sc) = x[3], x[4:]
        b1, c1, b2, c2 = ratios(cp, cb, cc, sp, sb, sc)
        near, off = cb * cp + sb * sp, sb * cp - cb * sp  # of β - φ
        inertia = J1 + J2 * b1**2 + mixed * near * b1 + J3 * c1**2
        slope = J2 * b1 * b2 + mixed / 2 * (near * b2 - off * (b1 - 1) * b1) + J3 * c1 * c2
        weight = m1 * a / 2 * cp + m2 * (a * cp + b / 2 * cb * b1) + m3 * c / 2 * cc * c1
        w1 = -(slope * w**2 + g * weight) / inertia
        return [w, b1 * w, c1 * w, w1, -sp * w, -sb * b1 * w, -sc * c1 * w, cp * w, cb * b1 * w, cc * c1 * w]

    phi = start["phi"]
    x, y = d - a * cos(phi), -a * sin(phi)  # from elbow to the rocker's pivot
    far = sqrt(x**2 + y**2)
    beta = atan2(y, x) + acos((b**2 + far**2 - c**2) / (2 * b * far))
    chi = atan2(a * sin(phi) + b * sin(beta), a * cos(phi) + b * cos(beta) - d)
    angles = [phi, beta, chi]
    phi, beta, chi, w, *turns = integrated(rates, [*angles, start["phi_dot"], *map(cos, angles), *map(sin, angles)])
    b1, c1, _, _ = ratios(*turns)
    return [phi, beta - phi, chi, w, (b1 - 1) * w, c1 * w]


# Disc: n axis, c from the centre to the contact, k up; v = -ω × c, d/dt(I ω) = c × m (v̇ + g k), I = m r²/4 (1 + n nᵀ)

UP = matrix([0, 0, 1])


def cross(a, b):
    return matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def rotation(e):
    w, x, y, z = e
    return matrix([
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ])  # fmt: skip


def product(a, b):
    v = cross(a[1:], b[1:])
    return [a[0] * b[0] - dot(a[1:], b[1:]), *(a[0] * b[k + 1] + b[0] * a[k + 1] + v[k] for k in range(3))]


def disc(start: dict, p: dict) -> Numbers:
    m, r, g = p["m"], p["r"], mpf("9.81")

    def contact(n):
        s = dot(UP, n)
        return -r * (UP - s * n) / sqrt(1 - s * s)

    def rates(x):
        e, w = list(x[3:7]), matrix(x[7:])
        R = rotation(e)
        n, spin = R[:, 1], R * w
        turned = cross(spin, n)
        s, s1 = dot(UP, n), dot(UP, turned)
        c = contact(n)
        c1 = -r * ((-s1 * n - s * turned) / sqrt(1 - s * s) + (UP - s * n) * s * s1 / (1 - s * s) ** mpf("1.5"))
        inertia = m * r**2 / 4 * (eye(3) + n * n.T)
        right = m * cross(c, g * UP - cross(spin, c1)) - cross(spin, inertia * spin)
        faster = lu_solve(inertia + m * (dot(c, c) * eye(3) - c * c.T), right)
        return [*(-cross(spin, c)), *(x / 2 for x in product(e, [0, *w])), *(R.T * faster)]

    e = product([cos(pi / 24), sin(pi / 24), 0, 0], turn([start[f"along flight_w{k}"] for k in "xyz"]))
    n = rotation(e)[:, 1]
    old = rotation([cos(pi / 24), sin(pi / 24), 0, 0])
    place = matrix([0, 0, START["r"] * cos(pi / 12)])
    place = place + old * matrix([start["along flight_vx"], start["along flight_vy"], 0])
    shift = (r * sqrt(1 - dot(UP, n) ** 2) - place[2]) / old[2, 2]  # along z of the disc, until it touches
    place = place + old * matrix([0, 0, shift])
    end = integrated(rates, [*place, *e, *(start[f"flight_w{k}"] for k in "xyz")])
    R = rotation(end[3:7])
    return [*end[:7], *(R.T * -cross(R * matrix(end[7:]), contact(R[:, 1]))), *end[7:]]


def turn(v):
    size = norm(matrix(v))
    return [1, 0, 0, 0] if size == 0 else [cos(size / 2), *(sin(size / 2) * x / size for x in v)]


def on_the_group(ahead: Numbers, behind: Numbers, here: Numbers) -> Numbers:
    """Return a difference of two ends along the velocities of a free body at a third."""
    e = product([here[3], *(-x for x in here[4:7])], [x - y for x, y in zip(ahead[3:7], behind[3:7], strict=True)])
    p = rotation(here[3:7]).T * matrix([x - y for x, y in zip(ahead[:3], behind[:3], strict=True)])
    return [*p, *(2 * x for x in e[1:]), *(x - y for x, y in zip(ahead[7:], behind[7:], strict=True))]


def plain(ahead: Numbers, behind: Numbers, here: Numbers) -> Numbers:
    return [x - y for x, y in zip(ahead, behind, strict=True)]


START = {"r": mpf("0.3")}
CASES = {
    "pendulum": (pendulum, plain, {"q1": "1", "q1_dot": "0.5"}, {"m": "1", "l": "0.5", "g": "9.81", "b": "0.01"}),
    "four_bar": (
        four_bar, plain, {"phi": "0.8", "phi_dot": "2"},
        {"a": "1", "b": "3", "c": "3.5", "d": "4", "m1": "1", "m2": "3", "m3": "3.5", "g": "9.81"},
    ),
    "rolling_disc": (
        disc, on_the_group,
        {**{f"along flight_{k}": "0" for k in ("vx", "vy", "wx", "wy", "wz")},
         "flight_wx": "0.3", "flight_wy": "6", "flight_wz": "0.4"},
        {"m": "1", "r": "0.3"},
    ),
}  # fmt: skip


def made(name: str) -> dict:
    run, difference, start, p = CASES[name]
    start, p = ({key: mpf(text) for key, text in one.items()} for one in (start, p))
    here = run(start, p)

    def column(key: str, step: mpf) -> Numbers:
        varied = [[{**one, key: one[key] + h} if key in one else one for one in (start, p)] for h in (step, -step)]
        ahead, behind = (run(*one) for one in varied)
        return [x / (2 * step) for x in difference(ahead, behind, here)]

    first = next(iter(start))
    columns = {key: column(key, H) for key in (*start, *p)}
    worst = max(abs(x - y) for x, y in zip(columns[first], column(first, 2 * H), strict=True))
    assert worst < mpf(10) ** -17, (name, worst)
    return {"end": list(map(text, here)), "columns": {key: list(map(text, one)) for key, one in columns.items()}}


def text(x: mpf) -> str:
    return mp.nstr(x, 17, strip_zeros=False)


def main() -> None:
    found = {"source": "mpmath's Taylor method at 30 digits on equations typed by hand, see gradients.py"}
    for name, (_, _, start, p) in CASES.items():
        found[name] = {"start": start, "parameters": p, **made(name)}
        print(name, flush=True)
    path = Path(__file__).parent / "gradients.json"
    path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

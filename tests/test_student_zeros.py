"""Quantities that are zero at every state, terms too much, parts of a term left out: both doors tell the same."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from test_student_answers import _benchmark

from symdyn.errors import TeachError
from symdyn.graph import Graph, Op
from symdyn.scene import read_text
from symdyn.teach.languages import language_of
from symdyn.teach.student.derivation_check import check_derivation
from symdyn.teach.student.diagnosis import DRAWN, Diagnosis

FLYWHEELS = """
gravity = "none"
parameters = { J1 = "1 kg*m^2", J2 = "2 kg*m^2" }
bodies.a = { inertia = ["J1", "J1", "J1"], inertia_about = "com" }
bodies.b = { inertia = ["J2", "J2", "J2"], inertia_about = "com" }
joints.p = { type = "revolute", parent = "ground", child = "a", axis = [0, 0, 1], coordinate = "phi", drive = "M" }
joints.q = { type = "revolute", parent = "ground", child = "b", axis = [0, 0, 1], coordinate = "psi", drive = "N" }
"""
LED = FLYWHEELS.replace('drive = "N"', 'drive = "N", motion = "3*t"')
SWING = """
gravity = [0, 0, "-g"]
parameters = { m = "2 kg", I = "1 kg*m^2", r = "0.3 m", d = "0.5 m", g = "9.81 m/s^2" }
bodies.a = { mass = "m", com = [0, 0, "-d"], inertia = ["I", "I", "I"], inertia_about = "ABOUT" }
joints.p = { type = "revolute", parent = "ground", child = "a", axis = [0, 1, 0], coordinate = "phi", drive = "M" }
"""
FRAME, CENTRE = (SWING.replace("ABOUT", x) for x in ("frame", "com"))
DISC = CENTRE.replace('"-d"', "0")
FRICTION = DISC.replace('drive = "M"', 'drive = "M", damping = "c"').replace("{ m =", '{ c = "2 N*m*s", m =')
DRAG = """
gravity = "none"
parameters = { m = "2 kg", f = "3 N", s = "4 N", v = "0.1 m/s" }
bodies.b.mass = "m"
[joints.j]
type = "prismatic"
parent = "ground"
child = "b"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
force = "-(f + s*exp(-x_dot**2/v**2))*sign(x_dot)"
"""
VISCOUS = """
gravity = "none"
parameters = { m = "2 kg", b = "3 N*s/m", d = "4 N*s^2/m^2", k = "5 N/m" }
bodies.b.mass = "m"
[joints.j]
type = "prismatic"
parent = "ground"
child = "b"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
force = "-b*x_dot - d*x_dot*abs(x_dot) - k*x"
"""
CLUTCH, CART, TWO_LINK = (
    (Path(__file__).parents[1] / f"examples/{name}.toml").read_text()
    for name in ("gallery/clutch", "cart_pole", "two_link")
)
RIGHT, EXTRA, PARALLEL = (True, ()), (False, ("extra",)), (False, ("extra", "steiner"))
LAW = (False, ("law",))
TABLE = """
gravity = "none"
parameters = { m = "2 kg", J = "1 kg*m^2", a = "0.3 m", c = "1 N*m*s", d = "1 N*s/m" }
bodies.t = { inertia = ["J", "J", "J"], inertia_about = "com" }
bodies.b = { mass = "m" }
[joints.p]
type = "revolute"
parent = "ground"
child = "t"
axis = [0, 0, 1]
coordinate = "phi"
drive = "M"
damping = "c"
[joints.q]
type = "prismatic"
parent = "t"
child = "b"
axis = [1, 0, 0]
origin = ["a", 0, 0]
coordinate = "s"
drive = false
damping = "d"
"""
BOOM = FLYWHEELS.replace('parent = "ground", child = "b"', 'parent = "a", child = "b"').replace(', J2 = "2 kg*m^2"', "")
BOOM = BOOM.replace("{ J1", "{ m = 2, l = 0.5, J1", 1).replace("J2", "J1")
BOOM = BOOM.replace("bodies.b = {", 'bodies.b = { mass = "m", com = ["l", 0, 0],')
SPIN = "1/2 m l^2 (phi' + psi')^2"
CRANK = (Path(__file__).parents[1] / "examples/spatial_slider_crank.toml").read_text()
FACTOR = (False, ("termfactor",))
GEARED = """
gravity = "none"
parameters = { J1 = "1 kg*m^2", J2 = "2 kg*m^2", J3 = "3 kg*m^2", n = "4" }
bodies.motor = { inertia = ["J1", "J1", "J1"], inertia_about = "com" }
bodies.wheel = { inertia = ["J2", "J2", "J2"], inertia_about = "com" }
bodies.load = { inertia = ["J3", "J3", "J3"], inertia_about = "com" }
[joints]
p = { type = "revolute", parent = "ground", child = "motor", axis = [0, 0, 1], coordinate = "phi", drive = "M" }
q = { type = "revolute", parent = "ground", child = "wheel", axis = [0, 0, 1], mimic = { joint = "p", ratio = "1/n" } }
r = { type = "revolute", parent = "wheel", child = "load", axis = [0, 0, 1], coordinate = "psi", drive = "N" }
"""
LINKS = """
gravity = "none"
parameters = { m = "2 kg", l = "0.5 m", M = "3 kg", L = "0.7 m", k = "4 N*m", b0 = "0.3 rad" }
bodies.near = { mass = "M", com = ["L/2", 0, 0], inertia = [0, "M*L**2/12", "M*L**2/12"], inertia_about = "com" }
bodies.far = { mass = "m", com = ["l/2", 0, 0], inertia = [0, "m*l**2/12", "m*l**2/12"], inertia_about = "com" }
springs.s = { joint = "q", stiffness = "k", free = "b0" }
[joints]
p = { type = "revolute", parent = "ground", child = "near", axis = [0, 0, 1], coordinate = "alpha", drive = "T" }
q = { type = "revolute", parent = "near", child = "far", axis = [0, 0, 1], origin = ["L", 0, 0], coordinate = "beta" }
"""
LOST = "(M/3 + m) L^2 α'' + 1/2 m l L ((2 α'' + β'') cos β - (2 α' + β') β' sin β) = T"
OWN = "m l^2/3 (α'' + β'') + 1/2 m l L (α'' cos β + α'^2 sin β)"
"""Without m l^2/3 (α'' + β''), what the far link has by its own turning."""
HELD = """
gravity = "none"
parameters = { m = "2 kg", k = "50 N/m", T = "0.1 s" }
bodies.b.mass = "m"
joints.j = { type = "prismatic", parent = "ground", child = "b", axis = [1, 0, 0], coordinate = "x", drive = "F" }
springs.s = { joint = "j", stiffness = "k" }
states.e = { rate = "(x - e)/T", unit = "m" }
"""
TYPED = {
    FLYWHEELS: [
        *(("P:", text, RIGHT) for text in ("0", "P = 0", "5", "J1 - J2")),
        *(("P:", text, EXTRA) for text in ("J1 phi", "J1 phi'", "M", "J1 + M", "5 psi", "phi''")),
        ("L:", "1/2 J1 phi'^2 + 1/2 J2 psi'^2 + J1", RIGHT),
        ("L:", "1/2 J1 phi'^2 + 1/2 J2 psi'^2 + M", EXTRA),
        *((key, "0", RIGHT) for key in ("k_z:1,2", "k_C:1,1,2", "k_D:1,2", "k_G:1", "dL:/dphi")),
        *((key, text, EXTRA) for key in ("k_z:1,2", "k_C:1,1,2", "k_G:1", "dL:/dphi") for text in ("5", "J1 phi")),
    ],
    LED: [("P:", "J1", RIGHT), ("P:", "J1 t", EXTRA), ("P:", "J1 psi", EXTRA)],
    DISC: [("K:", "1/2 (I + m r^2) phi'^2", EXTRA), ("k_z:1,1", "I + m r^2", EXTRA)],
    FRAME: [
        ("K:", "1/2 (I + m d^2) phi'^2", PARALLEL),
        ("K:", "1/2 (I + m r^2) phi'^2", EXTRA),
        ("k_z:1,1", "I + m d^2", PARALLEL),
        ("tau:1", "(I + m d^2) phi'' + m g d sin(phi)", PARALLEL),
    ],
    CENTRE: [
        ("K:", "1/2 I phi'^2", (False, ("steiner",))),
        ("K:", "1/2 (I + m d^2) phi'^2", RIGHT),
        ("K:", "1/2 (I + m d^2 + m r^2) phi'^2", EXTRA),
        ("K:", "1/2 (I + 2 m d^2) phi'^2", (False, ("half", "extra"))),
        ("P:", "-g d cos(phi)", (False, ("power", "dimension"))),
        ("P:", "0", (False, ("weightless",))),
    ],
    CLUTCH: [
        ("tau:2", "J2 (phi'' + psi'') = -(Tc + Ts exp(-psi'^2)) sign(psi')", (False, ("term",))),
        ("tau:2", "J2 (phi'' + psi'') = 0", (False, ("friction",))),
        ("tau:2", "J2 (phi'' + psi'') = -Tc psi'", LAW),
    ],
    DRAG: [
        ("tau:1", "F = m x'' + (f + s exp(-x'^2/v^2)) sign(x')", RIGHT),
        ("tau:1", "F = m x'' + f sign(x')", (False, ("term",))),
        ("tau:1", "-F = m x'' + f sign(x')", (False, ("term", "termsign"))),
        ("tau:1", "F = m x'' + f + s exp(-x'^2/v^2)", LAW),
        ("tau:1", "F = m x'' + (f + s exp(-x'^2/v^2)) sign(x)", LAW),
        ("tau:1", "x'' = (F - f sign(x))/m", LAW),
        ("tau:1", "F = m x'' + f x'", LAW),
        ("tau:1", "F = 2 m x'' + f sign(x)", (False, ())),
        ("tau:1", "F = m x'' + s exp(f/s) sign(x')", (False, ())),
        ("tau:1", "F = 2 x'' + (3 + 4 exp(-x'^2/0.01)) sign(x')", RIGHT),
        ("K:", "1/2 m x'^2", RIGHT),
    ],
    VISCOUS: [
        ("tau:1", "F = m x'' + b x' + d x'^2 + k x", LAW),
        ("tau:1", "F = m x'' + b x' + d x' + k x", (False, ("friction", "extra"))),
        ("tau:1", "F = m x'' + b x' + k x", (False, ("friction",))),
        ("solved:1", "(F - k x - b x' - d x'^2)/m", LAW),
        ("solved:1", "(F - k x - b x' - d |x'|^2 sign(x'))/m", RIGHT),
    ],
    CART: [
        *((key, "0", (False, ("weightless",))) for key in ("P:", "k_G:2")),
        *((key, "0", (False, ("body",))) for key in ("K:", "k_z:1,1", "k_z:2,2")),
        ("k_z:1,2", "0", (False, ("carried", "coupling"))),
        ("k_D:1,2", "0", (False, ("product", "slope"))),
        ("dL:/dtheta", "0", (False, ("term",))),
        ("k_G:1", "0", RIGHT),
    ],
    TWO_LINK: [
        *((key, "0", RIGHT) for key in ("k_D:1,1", "k_D:2,2", "k_C:2,1,2")),
        *((key, "m1 h1", EXTRA) for key in ("k_D:1,1", "k_C:2,1,2")),
        ("dL:/dq2", "0", (False, ("carried", "term"))),
    ],
    TABLE: [
        ("K:", "1/2 J phi'^2 + 1/2 m (s'^2 + (s + a)^2 phi'^2 + a^2 phi'^2)", EXTRA),
        ("K:", "1/2 J phi'^2 + 1/2 m (s'^2 + (s^2 + 2 s a + 2 a^2) phi'^2)", FACTOR),
        ("tau:2", "m s'' - m (s + a) phi'^2 + d s' = -d s'", EXTRA),
        ("tau:2", "m s'' - m (s + a) phi'^2 + 2 d s' = 0", FACTOR),
        ("tau:1", "(J + m (s + a)^2) phi'' + 2 m (s + a) s' phi' + c phi' + m s'^2 = M", EXTRA),
        ("k_z:1,1", "J + m (s + a)^2 + m a", (False, ("extra", "dimension"))),
        ("tau:1", "M = (J + m (s + a)^2) phi'' + 2 m (s + a) s' phi' + c phi' + m s' phi'", EXTRA),
    ],
    BOOM: [
        ("K:", f"{SPIN} + J1 phi'^2 + J1 phi' psi' + 1/2 J1 psi'^2", RIGHT),
        ("K:", f"{SPIN} + J1 phi'^2 + 2 J1 phi' psi' + J1 psi'^2", FACTOR),  # no body is left out
    ],
    CRANK: [
        (
            "tau:2",  # the term that is lost is small beside the multiplier
            "2.5 x'' + 0.075 (α'' sin α cos β + β'' cos α sin β) + 0.075 (α'² + β'²) cos α cos β = λ1",
            (False, ("velocities",)),
        )
    ],
    GEARED: [
        ("K:", "1/2 J1 phi'^2 + 1/2 J2 phi'^2/n^2 + 1/2 J3 (phi'/n + psi')^2", RIGHT),
        ("K:", "1/2 J1 phi'^2 + 1/2 J2 phi'^2/n^2 + 1/2 J3 (phi' + psi')^2", (False, ("ratio",))),
        ("K:", "1/2 J1 phi'^2 + 1/2 J2 phi'^2 4^2 + 1/2 J3 (4 phi' + psi')^2", (False, ("ratio",))),
        ("k_z:1,2", "J3/n^2", (False, ("index", "power"))),  # the share that the load has in k_z11, too
        ("tau:1", "M = (J1 + (J2 + J3)/4^2) phi'' + J3/4 psi''", RIGHT),
        (
            "tau:1",
            "J1 M = (J1 + (J2 + J3)/n^2) phi'' + J3/n psi''",
            (False, ("undivided",)),
        ),  # J1 is 1 kg m², n has no unit
        ("tau:1", "M = (J1 + (J2 + J3)/n^2) phi'' + J3 psi''", (False, ("power",))),  # nothing is divided by a ratio
        ("tau:1", "M = (J1 + J2/n^2 + J3) phi'' + J3/n psi''", (False, ("power",))),
    ],
    LINKS: [
        ("P:", "1/2 k (beta - b0)^2", RIGHT),
        ("P:", "1/2 k (alpha + beta - b0)^2", (False, ("absolute",))),
        ("tau:2", f"{OWN} + k (α + β - b0) = tau2", (False, ("absolute",))),
        ("k_E:2", "k beta", (False, ())),  # b0 is no inclined plane
        ("tau:1", LOST, (False, ("carried", "relative"))),
    ],
    FRICTION: [("tau:1", "M = I phi'' + c phi", (False, ("index", "dimension")))],
    HELD: [  # a potential energy may have a constant more, and a state is none
        ("P:", "1/2 k x^2 + k T", RIGHT),
        ("P:", "1/2 k x^2 + 1/2 k e^2", (False, ("extra",))),
        ("L:", "1/2 m x'^2 - 1/2 k x^2 - k e^2", (False, ("extra",))),
    ],
}
"""By scene: what is asked, an answer, whether it is right, and the rules that both doors tell."""


@pytest.mark.runs("node")
@pytest.mark.skipif(shutil.which("node") is None, reason="the page's program runs in node")
@pytest.mark.parametrize(
    "text",
    [
        *(FLYWHEELS, FRAME, DRAG, VISCOUS, CART, TABLE, GEARED),
        *(pytest.param(x, marks=pytest.mark.slow) for x in (LED, DISC, CENTRE, CLUTCH, FRICTION)),
        *(pytest.param(x, marks=pytest.mark.slow) for x in (TWO_LINK, BOOM, CRANK, LINKS, HELD)),
    ],
    ids=[
        *("flywheels", "frame", "drag", "viscous", "cart", "table", "geared"),
        *("led", "disc", "centre", "clutch", "friction", "two_link", "boom", "crank", "links", "held"),
    ],
)  # fmt: skip
def test_zeros_and_terms_too_much_are_told_alike_at_both_doors(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    benchmark, scene, rows = _benchmark(monkeypatch), read_text(text, "scene.toml").as_parameters(), TYPED[text]

    page = benchmark.sealed_on_page([(key, typed) for key, typed, _ in rows], scene)
    shell = [benchmark.sealed_in_shell({"answer": typed}, key, scene) for key, typed, _ in rows]

    for (key, typed, told), here, (there, _) in zip(rows, shell, page, strict=True):
        assert (here.right, here.rules) == told, (key, typed)
        assert (there.right, tuple(sorted(there.rules))) == (told[0], tuple(sorted(told[1]))), (key, typed)


@pytest.mark.parametrize("language", ["en", "sk"])
def test_a_parallel_axis_term_too_much_is_no_forgotten_one(language: str) -> None:
    says = language_of(language).mistakes
    (added,) = check_derivation("K = 1/2 (I + m d^2) phi'^2", read_text(FRAME, "scene.toml"))
    (lost,) = check_derivation("K = 1/2 I phi'^2", read_text(CENTRE, "scene.toml"))

    assert says["extra.steiner"] in added.in_words(language)[0]
    assert says["steiner"] not in added.in_words(language)[0]
    assert says["steiner"] in lost.in_words(language)[0]


def test_the_size_of_a_rate_is_not_the_rate_at_the_points_of_the_first_comparison() -> None:
    """All rates were positive there: only the motions told them apart."""
    diagnosis = Diagnosis(read_text(DRAG, "scene.toml"))
    rate = Graph().symbol("x_dot")

    rates, sizes = zip(*diagnosis.points.values([rate, rate.graph.function(Op.ABS, rate)])[:DRAWN], strict=True)

    assert min(rates) < 0 < max(rates)
    assert sizes == tuple(map(abs, rates))


def test_rates_are_positive_where_a_law_has_no_value_else() -> None:
    scene = read_text(DRAG.replace("exp(-x_dot**2/v**2)", "sqrt(x_dot/v)"), "scene.toml")

    points = Diagnosis(scene).points

    assert min(point["x_dot"] for point in points.at) > 0


def test_a_rate_too_much_is_another_power_and_no_lost_term() -> None:
    text = "m s'' - m (s + a) phi'^2 s' + d s' = 0"
    (answer,) = check_derivation(text, read_text(TABLE, "scene.toml"), target="tau2")

    assert {one.kind for one in answer.differences} == {"power"}


def test_what_divides_by_zero_is_told_with_its_place() -> None:
    """They ended in a traceback: J1 - J1 typed below a line, and a symbol there that the result does not have."""
    flywheels = read_text(FLYWHEELS, "scene.toml")
    for text in ("k_G1 = phi/(J1 - J1)", "P = (phi - phi)^(-1)"):
        with pytest.raises(TeachError, match="division by zero"):
            check_derivation(text, flywheels)

    (answer,) = check_derivation("P = phi + 1/J1", flywheels)
    assert not answer.right

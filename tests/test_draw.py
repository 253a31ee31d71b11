"""Pictures: everything that a scene declares is there, where it is, under its name, and legible."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import closed_mechanisms
import numpy as np
import pytest
from arms import EXAMPLES, chain, two_link
from mechanisms import coupled_tree, jointed, random_tree

from symdyn.draw import Wrench, acting_on, free_body, picture, pose
from symdyn.draw.pictures import drawing
from symdyn.draw.places import Label, crosses, places, put
from symdyn.draw.stage import Stage
from symdyn.draw.style import SCHEMES, LetterRun, Text
from symdyn.draw.svg import Drawing, name, svg
from symdyn.errors import DrawError
from symdyn.scene import Quantity, Scene, body, prismatic, read, read_text, revolute, scene
from symdyn.scene.forces.applied_forces import Damper, Spring
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Body, Joint, Load, Place, Pose

SVG = "{http://www.w3.org/2000/svg}"


def loaded() -> Scene:
    """A cart with a pole, springs and dampers at joints and between points, a force and a couple."""
    end = Place("pole", (Quantity.number(0), Quantity.number(Fraction(1, 2)), Quantity.number(0)))
    wall = Place("ground", (Quantity.number(-1), Quantity.number(Fraction(1, 2)), Quantity.number(0)))
    one = (Quantity.number(1),)
    return replace(
        read(EXAMPLES / "cart_pole.toml"),
        elements=(
            Spring("k1", "rail", (), one),
            Spring("k2", "", (wall, end), one),
            Spring("kt", "hinge", (), one),
            Damper("c1", "rail", (), one),
            Damper("c2", "", (wall, end), one),
            Damper("ct", "hinge", (), one),
            Load(
                "F_w",
                end,
                (Quantity.number(1), Quantity.number(2), Quantity.number(0)),
                (Quantity.number(0), Quantity.number(0), Quantity.number(-1)),
            ),
        ),
    )


SCENES = {path.stem: read(path) for path in sorted(EXAMPLES.glob("*.toml"))}
SCENES |= {f"tree{seed}": random_tree(seed, 6) for seed in range(4)}
SCENES |= {f"coupled{seed}": coupled_tree(seed) for seed in range(2)}
SCENES |= {f"{kind}_twice": jointed(kind, kind) for kind in JOINTS}
SCENES |= {"zyx": jointed("free", "spherical", "rod", orientation="zyx"), "loaded": loaded(), "chain20": chain(20)}
SCENES |= {
    make.__name__: make()
    for make in (
        closed_mechanisms.crank_rocker,
        closed_mechanisms.symbolic_four_bar,
        closed_mechanisms.slider_crank,
        closed_mechanisms.rssr,
        closed_mechanisms.bricard,
    )
}
SCENES["empty"] = Scene("empty")
SCENES["point"] = Scene("point", bodies=(Body("b", Quantity.number(1)),), joints=(Joint("j", "fixed", "ground", "b"),))


@cache
def whole(one: Scene) -> Drawing:
    """Return a drawing with frames and all labels."""
    return drawing(one, frames=True, labels=("coordinates", "bodies", "joints", "points"))


@pytest.mark.wide(2)
@pytest.mark.heavy("chain20", "quadruped", "helical_twice")
@pytest.mark.long
@pytest.mark.parametrize("one", SCENES.values(), ids=SCENES)
def test_everything_is_in_the_picture_once_and_finite(one: Scene) -> None:
    root = ElementTree.fromstring(svg(whole(one)))
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    wanted = [f"body-{x.name}" for x in one.bodies] + [f"joint-{x.name}" for x in one.joints]
    wanted += [f"loop-{x.name}" for x in one.loops]
    wanted += [f"{x.kind}-{x.name}" for x in (*one.struts, *one.loads)]

    assert len(ids) == len(set(ids))
    assert set(map(name, wanted)) <= set(ids)
    for element in root.iter():
        numbers = " ".join(element.get(key, "") for key in ("d", "cx", "cy", "x", "y", "transform", "viewBox"))
        assert not re.search("nan|inf|e[+-]", numbers), numbers
    for group in root.iter(f"{SVG}g"):
        assert group.get("id", "").startswith("label") or "-label" in group.get("id", "") or group[0].text


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.parametrize("one", SCENES.values(), ids=SCENES)
def test_labels_lie_apart_and_inside(one: Scene) -> None:
    shown = whole(one)
    left, top, width, height = shown.box
    boxes = [label.box[0] for label in shown.labels]
    assert boxes
    for k, (low, high) in enumerate(boxes):
        assert low[0] >= left
        assert low[1] >= top
        assert high[0] <= left + width
        assert high[1] <= top + height
        for other in boxes[:k]:
            assert np.any((low >= other[1]) | (high <= other[0])), (shown.labels[k].label.text.plain, k)


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.parametrize("example", [path.stem for path in sorted(EXAMPLES.glob("*.toml"))])
def test_no_coordinate_and_no_body_of_an_example_goes_without_a_label(example: str) -> None:
    one = SCENES[example]
    shown = {label.label.id for label in drawing(one).labels}

    first = [joint.coordinates[0] for joint in one.moving]  # a quaternion has one label, at its first coordinate

    assert {f"label-{q}" for q in first} | {f"label-body-{x.name}" for x in one.bodies} <= shown


@pytest.mark.slow
@pytest.mark.runs
def test_the_same_scene_gives_the_same_bytes_in_any_process() -> None:
    code = f"import symdyn, symdyn.draw as d; print(d.picture(symdyn.read({str(EXAMPLES / 'puma560.toml')!r})), end='')"
    texts = {
        subprocess.run(
            [sys.executable, "-c", code], env={"PYTHONHASHSEED": seed, "PYTHONPATH": ":".join(sys.path)},
            capture_output=True, check=True,
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip

    assert texts == {picture(read(EXAMPLES / "puma560.toml")).encode()}


@pytest.mark.mends("6.svg")
def test_pictures_need_no_variables_of_css_which_browsers_alone_know() -> None:
    four_bar = read(EXAMPLES / "four_bar.toml")

    assert "var(" not in picture(four_bar)
    assert "var(" not in free_body(four_bar, "coupler")


@pytest.mark.mends("6.svg")
@pytest.mark.runs("rsvg-convert")
def test_a_program_that_is_no_browser_shows_the_colours(tmp_path: Path) -> None:
    (tmp_path / "four_bar.svg").write_text(picture(read(EXAMPLES / "four_bar.toml")), encoding="utf-8")
    png = tmp_path / "four_bar.png"
    subprocess.run(["rsvg-convert", str(tmp_path / "four_bar.svg"), "-o", str(png)], check=True)

    image = pytest.importorskip("matplotlib.image")
    shown = {tuple(np.round(255 * pixel[:3]).astype(int)) for row in image.imread(png) for pixel in row}
    for colour in ("paper", "mark", "body0", "body1", "body2"):
        assert tuple(bytes.fromhex(SCHEMES["light"][colour][1:])) in shown, colour


def test_a_picture_does_not_depend_on_the_unit_of_length() -> None:
    metres = drawing(two_link(), [0.4, 0.7], {"h1": 1.0, "h2": 0.6})
    far = drawing(two_link(), [0.4, 0.7], {"h1": 1e6, "h2": 0.6e6})

    assert metres.box == far.box


def middle(root: ElementTree.Element, id: str) -> np.ndarray:
    """Return the middle of the last circle of a group."""
    group = next(element for element in root.iter(f"{SVG}g") if element.get("id") == id)
    circle = group.findall(f"{SVG}circle")[-1]
    return np.array([float(circle.get("cx")), float(circle.get("cy"))])


def test_a_planar_scene_is_seen_face_on_with_gravity_downwards() -> None:
    q1, q2 = 0.5, 0.9
    root = ElementTree.fromstring(picture(two_link(), [q1, q2], {"h1": 2.0, "h2": 1.0}))
    shoulder, elbow, mass = (middle(root, id) for id in ("joint-shoulder", "joint-elbow", "mass-link2-1"))
    scale = np.linalg.norm(elbow - shoulder) / 2

    assert elbow - shoulder == pytest.approx(2 * scale * np.array([np.sin(q1), np.cos(q1)]), abs=0.1)
    assert mass - elbow == pytest.approx(scale * np.array([np.sin(q1 + q2), np.cos(q1 + q2)]), abs=0.2)


def view_of(one: Scene, direction: tuple[float, float] | None = None):
    q, values = pose(one)
    return Stage(one, q[None, :], values, direction).view


@pytest.mark.parametrize(
    ("example", "planar"),
    [("two_link", True), ("cart_pole", True), ("double_pendulum", True), ("scara", False), ("puma560", False)],
)
def test_planes_are_found(example: str, planar: bool) -> None:
    assert view_of(SCENES[example]).planar is planar


def test_axes_that_are_parallel_by_chance_make_no_plane() -> None:
    wrist = scene(
        "wrist",
        bodies=[body("a", mass=1), body("b", mass=1), body("c", mass=1)],
        joints=[
            revolute("j1", "ground", "a"),
            revolute("j2", "a", "b", axis=[1, 0, 0]),
            revolute("j3", "b", "c", axis=[0, 0, 1]),
        ],
    )
    alone = scene("two", bodies=[body("a", mass=1), body("b", mass=1)],
                  joints=[revolute("j1", "ground", "a"), revolute("j2", "a", "b")])  # fmt: skip

    assert not view_of(wrist).planar
    assert view_of(alone).planar


def test_slides_along_the_axis_of_a_turn_make_no_plane() -> None:
    bodies = [body("a", mass=1), body("b", mass=1)]
    across = scene("across", bodies=bodies,
                   joints=[revolute("j", "ground", "a"), prismatic("p", "a", "b", axis=[1, 0, 0])])  # fmt: skip
    along = scene("along", bodies=bodies,
                  joints=[revolute("j", "ground", "a"), prismatic("p", "a", "b", axis=[0, 0, 1])])  # fmt: skip

    assert view_of(across).planar
    assert not view_of(along).planar


def test_a_view_looks_from_where_it_is_told_to() -> None:
    above, front = view_of(SCENES["scara"], (0, 90)), view_of(SCENES["scara"], (-90, 0))

    assert above.toward == pytest.approx([0, 0, 1], abs=1e-15)
    assert front.toward == pytest.approx([0, -1, 0], abs=1e-15)
    assert front.right == pytest.approx([1, 0, 0], abs=1e-15)
    assert front.up == pytest.approx([0, 0, 1], abs=1e-15)


@pytest.mark.parametrize("q1", [0.4, -1.1, 2.5, 7.0])
def test_an_arc_spans_the_angle_from_the_zero_position(q1: float) -> None:
    shown = drawing(two_link(), [q1, 0.3])
    item = next(item for item in shown.items if item.id == "mark-q1")
    zero, head = item.shapes[0].points[0], item.shapes[-1].points[0]
    joint = next(item for item in shown.items if item.id == "joint-shoulder").shapes[-1].points[0, 0]
    start, end = zero[1] - joint, head[0] - joint
    angle = -np.arctan2(start[0] * end[1] - start[1] * end[0], start @ end)  # y is down

    assert start[0] == pytest.approx(0, abs=1e-9)
    assert (angle - q1) / (2 * np.pi) == pytest.approx(round((angle - q1) / (2 * np.pi)), abs=1e-6)


def test_a_dimension_spans_the_way_of_a_slide() -> None:
    shown = drawing(SCENES["cart_pole"], [0.4, 0.2])
    arrow = next(item for item in shown.items if item.id == "mark-x").shapes
    pole = next(item for item in shown.items if item.id == "body-pole").shapes[0].points[0]
    scale = np.linalg.norm(pole[1] - pole[0]) / 0.5

    assert arrow[-1].points[0, 0, 0] - arrow[0].points[0, 0, 0] == pytest.approx(0.4 * scale)


def test_loops_are_closed_and_an_open_one_shows_its_gap() -> None:
    one = SCENES["crank_rocker"]
    q, values = pose(one)
    closed, opened = picture(one, q, values), picture(one, q + 0.3, values)

    assert 'class="gap"' not in closed
    assert 'class="gap"' in opened
    assert pose(one, {"q_A": 1.0})[0][0] == 1.0


def test_a_wheel_has_its_rim() -> None:
    one = SCENES["rolling_disc"]
    q, values = pose(one)
    shown = drawing(one, q, values, view=(0, 0))
    rim = next(shape for item in shown.items if item.id == "body-disc" for shape in item.shapes if shape.kind == "disc")
    (centre, axis, radius) = next(iter(places(one, q[None, :], values).wheels.values()))

    assert rim.tilt[0, 0] == pytest.approx(rim.size * abs(axis[0, 0]), abs=1e-9)
    assert rim.size == pytest.approx(radius * view_of(one, (0, 0)).scale)
    assert rim.points[0, 0] == pytest.approx(view_of(one, (0, 0)).flat(centre)[0])


def test_gravity_is_drawn_along_gravity() -> None:
    def arrow(gravity: list[float]) -> np.ndarray | None:
        one = scene("p", gravity=gravity, bodies=[body("a", particles=[{"mass": 1, "at": [1, 0, 0]}])],
                    joints=[revolute("j", "ground", "a")])  # fmt: skip
        item = next((item for item in drawing(one).items if item.id == "gravity"), None)
        return None if item is None else item.shapes[0].points[0]

    down = arrow([3, -4, 0])

    assert down[1, 1] > down[0, 1]
    assert down[1, 0] == pytest.approx(down[0, 0])
    assert arrow([0, 0, -9.81]).shape == (1, 2)  # away from the viewer: a cross in a circle
    assert arrow([0, 0, 0]) is None


def test_a_label_keeps_clear_of_lines_and_one_without_room_is_left_out() -> None:
    origin, line = np.zeros((1, 2)), np.array([[[[5.0, -60.0], [5.0, 60.0]]]])
    (shown,) = put([Label("a", Text.of_name("q1"), origin, 3.0, np.array([1.0, 0.0]))], line)
    low, high = shown.box[0]
    many = put([Label(str(k), Text.of_name("quite_long"), origin, 3.0) for k in range(60)], np.zeros((1, 0, 2, 2)))
    bars = np.array([[[[x, -200.0], [x, 200.0]] for x in range(-200, 200, 5)]], dtype=float)

    assert not crosses(low[None], high[None], line).any()
    assert 3 < len(many) < 60
    assert not put([Label("a", Text.of_name("quite_long"), origin, 3.0)], bars)
    assert put([Label("a", Text.of_name("quite_long"), origin, 3.0)], bars, np.inf)


@pytest.mark.parametrize(
    ("text", "runs"),
    [
        (Text.of_name("q1"), [("q", "i", 0), ("1", "", -1)]),
        (Text.of_name("theta"), [("θ", "i", 0)]),
        (Text.of_latex(r"\kappa_{\mathrm{max}}"), [("κ", "i", 0), ("max", "", -1)]),
        (Text.of_latex(r"m_1 g"), [("m", "i", 0), ("1", "", -1), ("g", "i", 0)]),
        (Text.of_latex(r"-\Lambda^{2}"), [("−Λ", "", 0), ("2", "", 1)]),
        (Text.of_part("upper_arm"), [("upper_arm", "", 0)]),
        (Text.of_part("b1"), [("b", "i", 0), ("1", "", -1)]),
    ],
    ids=lambda value: "",
)
def test_names_are_lettered_as_in_print(text, runs) -> None:
    assert [(run.text, run.face, run.level) for run in text.runs] == runs


def test_names_cannot_break_the_file() -> None:
    joint = Joint("<j>", "revolute", "ground", 'a"&b', coordinates=("q1",))
    odd = Scene('x<y>&"z"', bodies=(Body('a"&b', Quantity.number(1)),), joints=(joint,))
    root = ElementTree.fromstring(picture(odd, prefix="fig-"))

    assert root.get("aria-label") == 'x<y>&"z"'
    assert all(element.get("id").startswith("fig-") for element in root.iter() if element.get("id"))


def test_plain_colours_need_no_variables() -> None:
    assert "var(" not in picture(two_link(), scheme="light")
    assert "var(" not in picture(two_link(), scheme="dark")
    assert "prefers-color-scheme" in picture(two_link())


@pytest.mark.parametrize(
    ("words_", "message"),
    [
        ({"q": [1.0]}, r"q = \[1.0\] is no position; give a number for each of q1, q2"),
        ({"q": [1.0, float("nan")]}, "no real value"),
        ({"parameters": {"h3": 1.0}}, '"h3" is not a parameter; known are m1'),
        ({"labels": ("links",)}, 'no labels of "links"; there are coordinates'),
        ({"view": (0, 100)}, "azimuth and elevation"),
        ({"scheme": "grey"}, "there are auto, light, dark"),
    ],
)
def test_faults_say_what_would_work(words_, message: str) -> None:
    with pytest.raises(DrawError, match=message):
        picture(two_link(), **words_)


def test_loops_that_cannot_close_say_so() -> None:
    with pytest.raises(DrawError, match="cannot be assembled"):
        pose(SCENES["slider_crank"], {"x": 40.0})


# Free bodies


def test_a_free_body_shows_every_wrench_and_its_name() -> None:
    forces = [Wrench("F_1", (0, 0, 0), (1, 0, 0)), Wrench("M", (0, -1, 0), couple=(0, 0, -2))]
    root = ElementTree.fromstring(free_body(two_link(), "link1", [0.4, 0.2], forces))
    ids = {element.get("id") for element in root.iter()}
    texts = ["".join(element.itertext()) for element in root.iter(f"{SVG}text")]

    assert {"body-link1", "cut-shoulder", "cut-elbow", "wrench-1", "wrench-2-couple"} <= ids
    assert "body-link2" not in ids
    assert {"F1", "M"} <= set(texts)


def test_every_particle_of_a_body_has_its_weight() -> None:
    places = ((1.0, 0.0, 0.0), (0.0, 0.5, 0.0))
    rod = body("rod", particles=[{"mass": 2 + k, "at": list(place)} for k, place in enumerate(places)])
    one = scene("rods", bodies=[rod], joints=[revolute("pivot", "ground", "rod")], gravity=[0, -9.81, 0])
    weights = [w for w in acting_on(one, "rod", [0.0]) if w.name.endswith("g")]

    assert [tuple(w.at) for w in weights] == [pytest.approx(place) for place in places]
    assert [tuple(w.force) for w in weights] == [(0.0, -1.0, 0.0)] * 2


def test_what_a_joint_exerts_on_its_two_bodies_is_opposite() -> None:
    one = SCENES["crank_rocker"]
    for joint, (parent, child) in {"B": ("crank", "coupler"), "C": ("coupler", "rocker")}.items():
        of = {
            name: [w for w in acting_on(one, name) if rf"\mathrm{{{joint}}}" in w.name and any(w.force)]
            for name in (parent, child)
        }
        assert len(of[parent]) == len(of[child]) == 3
        for here, there in zip(of[parent], of[child], strict=True):
            assert here.name == f"-{there.name}"
            assert np.array(here.force) == pytest.approx(-np.array(there.force))
            assert here.at == pytest.approx(there.at, abs=1e-6)


@pytest.mark.parametrize("kind", [kind for kind in JOINTS if kind != "custom"])
def test_a_joint_transmits_as_many_wrenches_as_its_class(kind: str) -> None:
    one = jointed(kind, "fixed")
    named = [w for w in acting_on(one, "b0") if r"\mathrm{j0}" in w.name + w.couple_name]

    assert len(named) == JOINTS[kind].class_t(one.joints[0])
    for letter, every in (("F", [w.name for w in named]), ("M", [w.couple_name for w in named])):
        names = [name for name in every if name]
        numbers = [f",{k}" for k in range(1, len(names) + 1)] if len(names) > 1 else [""]
        assert names == [rf"{letter}_{{\mathrm{{j0}}{number}}}" for number in numbers[: len(names)]]


def test_a_free_body_must_move() -> None:
    with pytest.raises(DrawError, match='"ground" does not move'):
        free_body(two_link(), "ground")
    with pytest.raises(DrawError, match="did you mean link"):
        free_body(two_link(), "link3")


def test_origin_placements_of_a_far_mechanism_stay_sharp() -> None:
    near = two_link()
    shoulder = replace(near.joints[0], origin=Pose((("Tx", Quantity.number(10**6)),)))
    far = replace(near, joints=(shoulder, near.joints[1]))

    assert drawing(far, [0.4, 0.7]).box == drawing(near, [0.4, 0.7]).box


def luminance(colour: str) -> float:
    """Return the relative luminance of WCAG 2.1."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    r, g, b = (x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts)
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_colour_stands_out_from_the_paper(scheme: str) -> None:
    colours = SCHEMES[scheme]
    for key, colour in colours.items():
        low, high = sorted([luminance(colour), luminance(colours["paper"])])
        if key not in ("paper", "shade"):
            assert (high + 0.05) / (low + 0.05) >= 4.5, (scheme, key)


def test_a_spring_and_a_damper_of_one_name_act_each_at_its_own_ends() -> None:
    low, high = (Place("ground", (Quantity.number(0), Quantity.number(end), Quantity.number(0))) for end in (-1, 1))
    spring = Spring("s", ends=(high, Place("pole")), stiffness=(Quantity.number(1),))
    damper = Damper("s", ends=(low, Place("pole")), damping=(Quantity.number(1),))
    one = replace(read(EXAMPLES / "cart_pole.toml"), elements=(spring, damper))

    q, values = pose(one)
    found = places(one, q[None, :], values)

    assert [found.ends[element][0][0, 1] for element in one.elements] == [1.0, -1.0]


def test_a_unit_stands_on_the_line() -> None:
    words = Text((LetterRun("F", "i", 0), LetterRun("N", "", -1))).with_unit("kN")
    assert words.plain == "FN, kN"
    assert [run.level for run in words.runs] == [0, -1, 0]


def test_planes_of_contacts_are_drawn_and_limbs_out_to_what_touches_them() -> None:
    leg = """
name = "leg"
[bodies.leg]
mass = 1
[joints.hip]
type = "revolute"
parent = "ground"
child = "leg"
axis = [0, 0, 1]
coordinate = "phi"
[contacts.floor]
body = "leg"
at = [0.6, 0, 0]
plane = { normal = [0, 1, 0], at = [0, -0.5, 0] }
"""
    shown = picture(read_text(leg))
    assert 'id="plane-floor"' in shown
    assert (
        shown.count('class="link body0"')
        == picture(read_text(leg.partition("[contacts")[0])).count('class="link body0"') + 1
    )

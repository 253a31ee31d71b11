"""Loops: declared by [[loop]], or found among the joints; the spanning tree keeps every coordinate what it is."""

from __future__ import annotations

import random
import re
from fractions import Fraction
from typing import Any

import pytest
from mechanisms import AXES, shape
from placeless import placeless

import symdyn.scene as declared
from symdyn.algebra.numeric import Floats
from symdyn.errors import SceneError
from symdyn.graph import Graph, evaluate
from symdyn.scene import Quantity, Scene, read_noting, read_text, write_text
from symdyn.scene.declaration.spanning import turned
from symdyn.scene.joints import joint_motion
from symdyn.scene.values import Joint, Pose
from symdyn.simulation import simulate

BODIES = "".join(f"[bodies.{name}]\nmass = 1\n" for name in ("crank", "coupler", "rocker"))


def joint(name, parent, child, kind="revolute", more=""):
    return f'[joints.{name}]\ntype = "{kind}"\nparent = "{parent}"\nchild = "{child}"\n{more}\n'


FOUR_BAR = (
    BODIES
    + joint("a", "ground", "crank")
    + joint("b", "crank", "coupler")
    + joint("c", "coupler", "rocker")
    + joint("d", "ground", "rocker")
)


def noting(text, tmp_path, cuts=None):
    path = tmp_path / "four_bar.toml"
    path.write_text(text)
    return read_noting(path, spanning_tree=cuts)


def faults(text, tmp_path, cuts=None):
    with pytest.raises(SceneError) as caught:
        noting(text, tmp_path, cuts)
    return [placeless(line).split("four_bar.toml: ")[1] for line in caught.value.faults]


def test_a_four_bar_is_cut_where_the_search_from_ground_meets_itself(tmp_path):
    reading = noting(FOUR_BAR, tmp_path)

    assert [one.name for one in reading.scene.joints] == ["a", "b", "d"]
    assert [(one.name, one.parent, one.child, one.coordinates) for one in reading.scene.loops] == [
        ("c", "coupler", "rocker", ())
    ]
    assert reading.scene.coordinates == ("q1", "q2", "q3")
    assert [note.split("four_bar.toml: ")[1] for note in reading.notes] == [
        'joints.c: closes a loop and is cut: it has no coordinates; spanning_tree=["d"] cuts another'
    ]


def test_the_user_says_which_joint_is_cut(tmp_path):
    reading = noting(FOUR_BAR, tmp_path, ("a",))

    assert [one.name for one in reading.scene.loops] == ["a"]
    assert [(one.name, one.parent, one.child) for one in reading.scene.joints] == [
        ("d", "ground", "rocker"),
        ("c", "rocker", "coupler"),
        ("b", "coupler", "crank"),
    ]
    assert [note.split(": ")[1:3] for note in reading.notes] == [
        ["joints.b", 'is turned round'], ["joints.c", 'is turned round']
    ]  # fmt: skip


def test_a_start_that_is_dropped_with_a_cut_joint_is_told(tmp_path):
    started = FOUR_BAR.replace(joint("a", "ground", "crank"), joint("a", "ground", "crank", more="start = 0.8"))
    reading = noting(started, tmp_path, ("a",))

    assert "joints.a: is cut and has no coordinates, and its start is not used" in "\n".join(reading.notes)
    assert "is not used" not in "\n".join(noting(started, tmp_path, ("c",)).notes)


def test_the_joint_with_most_freedoms_is_cut_unless_it_says_what_a_cut_joint_cannot(tmp_path):
    ball = FOUR_BAR.replace(joint("b", "crank", "coupler"), joint("b", "crank", "coupler", "spherical"))
    damped = FOUR_BAR.replace(joint("c", "coupler", "rocker"), joint("c", "coupler", "rocker", more="damping = 1"))
    driven = damped.replace(joint("b", "crank", "coupler"), joint("b", "crank", "coupler", more="drive = true"))
    sprung = driven.replace(joint("d", "ground", "rocker"), joint("d", "ground", "rocker", more="drive = false"))

    for text, cut in (
        (ball, "b"),
        (damped, "b"),
        (driven, "d"),
        (sprung + '[springs.s]\njoint = "d"\nstiffness = 1\n', "a"),
    ):
        assert [one.name for one in noting(text, tmp_path).scene.loops] == [cut]


def test_a_ball_that_cannot_be_turned_round_is_cut_instead(tmp_path):
    """The screw has fewer freedoms, but with it cut the ball would point towards ground."""
    text = (
        BODIES.replace("[bodies.rocker]\nmass = 1\n", "")
        + joint("screw", "ground", "crank", "cylindrical")
        + joint("ball", "coupler", "crank", "spherical")
        + joint("plane", "ground", "coupler", "point_on_plane")
    )

    scene = noting(text, tmp_path).scene

    assert [one.name for one in scene.loops] == ["ball"]
    assert [one.name for one in scene.joints] == ["screw", "plane"]


def test_a_lone_joint_that_points_towards_ground_is_turned_round(tmp_path):
    text = BODIES + joint("a", "crank", "ground") + joint("b", "crank", "coupler") + joint("c", "rocker", "coupler")

    scene = noting(text, tmp_path).scene

    assert [(one.name, one.parent, one.child) for one in scene.joints] == [
        ("a", "ground", "crank"),
        ("b", "crank", "coupler"),
        ("c", "coupler", "rocker"),
    ]
    assert scene.joints[0].axis == (Quantity.number(0), Quantity.number(0), Quantity.number(-1))


SEVERAL = [
    ("universal", {"second_axis": (Quantity.number(0), Quantity.number(1), Quantity.number(1))}, ("x", "y")),
    ("cylindrical", {}, ("x", "y")),
    ("helical", {"pitch": Quantity.number(Fraction(1, 3))}, ("x",)),
    ("revolute", {}, ("x",)),
    ("prismatic", {}, ("x",)),
    ("fixed", {}, ()),
    ("custom", {"steps": Pose((("Rz", Quantity.symbol("x")), ("Tx", Quantity.symbol("y")),
                               ("Ry", Quantity.symbol("x")))), "units": ("rad", "m")}, ("x", "y")),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "keys", "names"), SEVERAL, ids=[row[0] for row in SEVERAL])
def test_a_joint_that_is_turned_round_moves_the_bodies_as_before(kind, keys, names):
    rng = random.Random(kind)
    poses = [Pose(tuple((step, Quantity.number(Fraction(rng.randint(-9, 9), 7))) for step in steps)) for steps in
             (("Tx", "Rz", "Ry"), ("Rx", "Ty", "Rz"))]  # fmt: skip
    axis = tuple(Quantity.number(x) for x in AXES[5])
    one = Joint("j", kind, "a", "b", shape(kind, axis=axis, **keys), *poses, names)
    graph = Graph()

    there, back = (
        j.origin.transform(graph) @ joint_motion(j, graph).placement @ j.tip.transform(graph)
        for j in (one, turned(one))
    )

    entries = [*(x for row in (there @ back).R for x in row), *(there @ back).p]
    values = evaluate(entries, Floats(), {graph.symbol("x"): 0.7, graph.symbol("y"): -0.4})
    assert values == pytest.approx([1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], abs=1e-14)


def test_turning_round_twice_changes_nothing():
    for kind, _, names in SEVERAL:
        own = shape(kind, axis=tuple(Quantity.number(x) for x in AXES[5]))
        one = Joint("j", kind, "a", "b", own, Pose((("Tx", Quantity.symbol("l")),)), Pose(), names)
        assert turned(turned(one)) == one
    assert Pose((("Tx", Quantity.symbol("l")), ("Rz", Quantity.number(2)))).inverse().inverse() == Pose(
        (("Tx", Quantity.symbol("l")), ("Rz", Quantity.number(2)))
    )


def test_a_declared_loop_is_kept_as_it_is():
    text = FOUR_BAR.split("[joints.c]")[0] + joint("d", "ground", "rocker") + (
        '[[loop]]\ntype = "revolute"\nparent = "coupler"\nchild = "rocker"\norigin = [3, 0, 0]\ntip = [-4, 0, 0]\n'
        '[[loop]]\nname = "guide"\ntype = "point_on_line"\nparent = "ground"\nchild = "coupler"\naxis = [1, 0, 0]\n'
    )  # fmt: skip

    scene = read_text(text)

    assert [(one.name, one.type) for one in scene.loops] == [("loop1", "revolute"), ("guide", "point_on_line")]
    assert read_text(write_text(scene, "toml").text) == scene


@pytest.mark.parametrize(
    ("text", "cuts", "expected"),
    [
        (FOUR_BAR, ("elbow",), 'spanning_tree: "elbow" is not a joint; known are a, b, c, d'),
        (FOUR_BAR, ("a", "b"), "spanning_tree=[\"a\", \"b\"] leaves nothing that carries crank; cut others"),
        (FOUR_BAR, ("b", "c"), "spanning_tree=[\"b\", \"c\"] leaves nothing that carries coupler; cut others"),
        (
            FOUR_BAR + joint("e", "ground", "rocker", "prismatic"),
            ("e",),
            "spanning_tree=[\"e\"] leaves a loop: a -> b -> c -> d; cut one more of its joints",
        ),
        (
            FOUR_BAR.replace(joint("a", "ground", "crank"), joint("a", "ground", "crank", more="drive = true")),
            ("a",),
            'joints.a: is to be cut, but a cut joint has no drive; spanning_tree=["d"] cuts another',
        ),
        (
            FOUR_BAR.replace(joint("b", "crank", "coupler"), joint("b", "crank", "coupler", "spherical")),
            ("a",),
            "joints.b: a spherical joint cannot be turned round, as spanning_tree would need it; cut it, or swap its "
            "parent and child",
        ),
        (
            BODIES
            + joint("a", "ground", "crank")
            + joint("b", "coupler", "crank", "planar")
            + joint("c", "coupler", "rocker"),
            None,
            'joints.b: a planar joint from "coupler" to "crank" points towards ground and cannot be turned round; swap '
            "parent and child",
        ),
        (
            "".join(
                line + ("\ndamping = 1" if line.startswith("child") else "") + "\n" for line in FOUR_BAR.splitlines()
            ),
            None,
            "joints.c: closes a loop and is cut, but a cut joint has no damping; take that from one joint of the loop; "
            "a spring or damper also acts between points, by from and to",
        ),
        (
            BODIES + joint("a", "crank", "coupler") + joint("b", "coupler", "crank") + joint("c", "ground", "rocker"),
            None,
            'joints.a: parent = "crank" closes a ring, coupler -> crank -> coupler (child -> parent), that nothing '
            'joins to ground; write parent = "ground" in one of its joints',
        ),
    ],
)  # fmt: skip
def test_a_choice_that_leaves_no_tree_is_refused(text, cuts, expected, tmp_path):
    assert expected in faults(text, tmp_path, cuts)


TREE = (
    BODIES + joint("a", "ground", "crank") + joint("b", "crank", "coupler", "fixed") + joint("c", "coupler", "rocker")
)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ('type = "revolute"\nparent = "crank"\nchild = "crank"',
         'loop.loop1: joins "crank" with itself; write another parent or child'),
        ('type = "revolute"\nparent = "crank"\nchild = "coupler"',
         'loop.loop1: joins "crank" and "coupler", which fixed joints make one body; close the loop between two '
         "bodies"),
        ('type = "rod"\nparent = "ground"\nchild = "rocker"\nlength = 0',
         "loop.loop1: length = 0 is that of no rod; give the distance of its ends, or write a spherical joint"),
        ('type = "rod"\nparent = "ground"\nchild = "rocker"',
         "loop.loop1: length is missing; write length = 0.5, the distance of its ends in metres"),
        ('type = "custom"\nparent = "ground"\nchild = "rocker"\n',
         "loop.loop1: a custom joint closes no loop, since what it forbids has no formula; cut another joint"),
        ('type = "free"\nparent = "ground"\nchild = "rocker"\n',
         "loop.loop1: a free joint forbids nothing and closes no loop; leave it out"),
        ('type = "revolute"\nparent = "ground"\nchild = "roker"',
         'loop.loop1: child = "roker" is not a body; did you mean rocker?'),
        ('type = "revolute"\nparent = "ground"\nchild = "rocker"\ndrive = "M"\ncoordinate = "phi"',
         'loop.loop1: coordinate = "phi" has no meaning for a joint that closes a loop; write [joints.loop1] in its '
         "place, and [[loop]] for another joint of the loop"),
        ('name = "a"\ntype = "revolute"\nparent = "ground"\nchild = "rocker"',
         'loop.a: "a" is already the name of joints.a; choose another name'),
        ('name = 3\ntype = "revolute"\nparent = "ground"\nchild = "rocker"',
         'loop: name = 3 is not text; write one such as name = "loop1"'),
        ('type = "universal"\nparent = "ground"\nchild = "rocker"\nsecond_axis = [0, 0, -2]',
         "loop.loop1: second_axis = [0, 0, -2] is parallel to axis; give one across it, such as [1, 0, 0] for "
         "axis = [0, 0, 1]"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_loop_is_named(keys, expected, tmp_path):
    assert expected in faults(f"{TREE}\n[[loop]]\n{keys}\n", tmp_path)


def test_nothing_is_asked_of_a_joint_that_closes_no_loop(tmp_path):
    (message,) = faults(f'{TREE}\n[[loop]]\ntype = "custom"\nparent = "ground"\nchild = "rocker"\n', tmp_path)
    assert "closes no loop" in message


def test_a_loop_that_is_no_list_is_refused(tmp_path):
    text = "loop is {x = 1}, not a list of tables; write one [[loop]] and its keys below for each"
    assert text.replace("loop is", "loop: is", 1) in faults(f"loop = {{ x = 1 }}\n{TREE}", tmp_path)


def _four_bar(**place: Any) -> Scene:
    crank, coupler, rocker = (declared.body(name, mass=1) for name in ("crank", "coupler", "rocker"))
    about = {"axis": [0, 0, 1]}
    return declared.scene(
        "four_bar",
        gravity="none",
        parameters={"a": 0.08, "b": 0.26, "c": 0.2, "d": 0.25},
        bodies=[crank, coupler, rocker],
        joints=[
            declared.revolute("O", "ground", "crank", **about, coordinate="phi"),
            declared.revolute("A", "crank", "coupler", **about, origin=["a", 0, 0], drive=False),
            declared.revolute("C", "ground", "rocker", **about, origin=["d", 0, 0], drive=False),
        ],
        loops=[declared.loop("B", "revolute", "coupler", "rocker", **about, origin=["b", 0, 0], **place)],
    )


def test_the_place_of_a_joint_on_its_child_is_a_key_and_is_undone() -> None:
    """Taken for `tip`, the joint's place on the child closed a mirrored four-bar without a word."""
    assert _four_bar(child_origin=["c", 0, 0]) == _four_bar(tip=["-c", 0, 0])
    bent = _four_bar(child_origin=[["Tx", "c"], ["Rz", "0.1"]])
    assert bent == _four_bar(tip=[["Rz", "-0.1"], ["Tx", "-c"]])
    assert read_text(write_text(bent, "toml").text) == bent
    with pytest.raises(SceneError, match=r"loop\.B: tip and child_origin place .*; write one of them"):
        _four_bar(tip=["-c", 0, 0], child_origin=["c", 0, 0])


@pytest.mark.runs("cc")
def test_a_loop_whose_start_moves_far_says_how_tip_is_measured() -> None:
    for place in ({"tip": ["c", 0, 0]}, {"child_origin": ["c", 0, 0]}):
        (note,) = simulate(_four_bar(**place), until=0.01, start={"phi": 1.05}).notes
        assert note.endswith("tip is the child's frame seen from the joint, child_origin the joint from it")
    (near,) = simulate(_four_bar(child_origin=["c", 0, 0]), until=0.01, start={"phi": 1.05, "q3": 1.4}).notes
    assert "child_origin" not in near


CUT = joint("c", "coupler", "rocker")


@pytest.mark.parametrize("said", ['coordinate = "theta"', "limits = { lower = -1, upper = 2 }"])
def test_a_joint_that_names_a_coordinate_or_has_limits_is_not_cut_where_another_can_be(said, tmp_path):
    reading = noting(FOUR_BAR.replace(CUT, CUT + said + "\n"), tmp_path)
    assert [one.name for one in reading.scene.loops] == ["b"]


def _springs(*names):
    return "".join(f'[springs.{name}]\njoint = "{name}"\nstiffness = 3\n' for name in names)


@pytest.mark.parametrize(("cuts", "springs", "way"), [
    (["c"], "c", 'spanning_tree=["d"] cuts another'),
    (["c"], "cd", 'spanning_tree=["b"] cuts another'),
    (None, "abcd", "take that from one joint of the loop; a spring or damper also acts between points, by from and to"),
])  # fmt: skip
def test_a_cut_joint_with_a_spring_is_told_which_other_one_to_cut(cuts, springs, way, tmp_path):
    (told,) = faults(FOUR_BAR + _springs(*springs), tmp_path, cuts)
    assert told.startswith("joints.c: ")
    assert told.endswith(way)
    if cuts:
        noting(FOUR_BAR + _springs(*springs), tmp_path, re.findall(r'\["(.)"\]', way))


def test_a_note_of_a_cut_names_a_joint_that_can_be_cut(tmp_path):
    """Also of two loops, and where each of the others has a start; none where each has a drive, which none can lose."""
    each = FOUR_BAR.replace("type =", "MORE\ntype =").replace(CUT.replace("type =", "MORE\ntype ="), CUT)
    (note,) = noting(each.replace("MORE", "drive = true"), tmp_path).notes
    assert note.endswith("no coordinates")
    more = f"[bodies.link]\nmass = 1\n{joint('e', 'ground', 'link')}{joint('f', 'link', 'coupler')}"
    for text in (each.replace("MORE", "start = 0"), FOUR_BAR + more):
        reading = noting(text, tmp_path)
        for note in reading.notes:
            way = re.search(r"spanning_tree=\[(.*)\] cuts another", note)
            cuts = [one.strip(' "') for one in way[1].split(",")]
            assert {one.name for one in noting(text, tmp_path, cuts).scene.loops} == {*cuts}
            assert len(cuts) == len(reading.notes)


def test_what_a_cut_joint_loses_is_told(tmp_path):
    named = FOUR_BAR.replace('type = "revolute"', 'type = "revolute"\ncoordinate = "NAME"').split("NAME")
    each = "".join(f"{part}q_{k}" for k, part in enumerate(named[:-1])) + named[-1]
    (note,) = noting(each.replace('"q_2"', '"q_2"\nfriction = 0.1'), tmp_path).notes
    assert note.endswith('no coordinates, and its coordinate, friction are not used; spanning_tree=["d"] cuts another')


CLOSED = FOUR_BAR.replace(CUT, "") + CUT.replace("[joints.c]", '[[loop]]\nname = "c"')
KNOWN = "known are type, text, parent, child, origin, tip, child_origin, axis"
WAY = "write [joints.c] in its place, and [[loop]] for another joint of the loop; or give two points by from and to"


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (
            FOUR_BAR.replace(CUT, CUT + "limts = { lower = -1 }\n"),
            'joints.c: unknown key "limts"; did you mean limits?',
        ),
        (CLOSED + "limit = 1", f'loop.c: unknown key "limit"; {KNOWN}'),
        (
            f'{CLOSED}[springs.s]\njoint = "c"\nstiffness = 1',
            f'springs.s: joint = "c" is not a joint of the tree; {WAY}',
        ),
        (
            f'{CLOSED}[springs.s]\nfrom = "coupler"\nto = "rocker"\nstiffness = 1',
            "springs.s: an end lies where c does not move it, so that its length never changes; "
            "give places that it moves",
        ),
    ],
)
def test_keys_and_elements_of_a_loop_are_told_what_works_there(scene, message, tmp_path):
    assert faults(scene, tmp_path) == [message]

"""Bodies look like what they are: from their inertia where it means one thing, or from a word of the scene."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from browser import chromium, opened

import symdyn
from symdyn.draw.gltf import standing
from symdyn.draw.places import places
from symdyn.draw.stage import Stage, pose
from symdyn.errors import SceneError
from symdyn.scene import Scene, body, read_text, revolute, scene, write_text
from symdyn.scene.values import OUTLINES
from symdyn.scene.values.body import OutlineKind
from symdyn.teach.render.page import interactive_page


def pendulum(**said: object) -> Scene:
    """Return a body that hangs 0.5 m below a hinge about y."""
    said = {"mass": 3, "com": [0, 0, "-1/2"], "about": "com" if "inertia" in said else None, **said}
    return scene("hung", bodies=[body("b", **said)], joints=[revolute("j", "ground", "b", axis=[0, 1, 0])])


def look(one: Scene) -> tuple[str, list[float]] | None:
    """Return what its only body looks like, and half its lengths or its radii."""
    q, values = pose(one)
    found = places(one, q.reshape(1, -1), values).outlines.get("b")
    return found and (found.look, [round(float(np.linalg.norm(way)), 6) for way in found.ways])


@pytest.mark.parametrize(
    ("inertia", "expected"),
    [
        ([0.25, 0.25, 0], ("rod", [0.5])),  # m l^2 / 12 with l = 1
        ([0.03, 0.06, 0.03], ("disc", [0.2, 0.2])),  # m r^2 / 2 with r = 0.2
        ([0.048, 0.048, 0.048], ("ball", [0.2, 0.2, 0.2])),  # 2 m r^2 / 5
        ([0.04, 0.05, 0.01], ("plate", [0.2, 0.1])),  # m a^2 / 12 and m b^2 / 12 with a = 0.4, b = 0.2
        ([[0.02, 0.02, 0], [0.02, 0.02, 0], [0, 0, 0.04]], ("rod", [0.2])),  # along y = -x, askew in its frame
        ([0.01, 0.03, 0.035], None),  # nothing that a student would know
        ([0, 0, 0.04], None),  # a plane scene's, of anything
        ([3e4, 6e4, 3e4], None),  # a disc far larger than the mechanism
        ([1, 1, 1], None),  # a ball around its own hinge
        ([0, 0, 0], None),
        ([-1e-2, -1e-2, -1e-2], None),
        ([1e300, 1e300, 0], None),
    ],
)
def test_an_inertia_tells_what_it_is_of(inertia: list[float], expected: tuple[str, list[float]] | None):
    one = pendulum(inertia=inertia, allow_invalid_inertia=True)
    assert look(one) == expected
    assert "<svg" in symdyn.picture(one)


def test_a_body_that_carries_another_one_and_a_rolling_rim_stay_as_they_were():
    for name in ("rolling_disc", "bicycle", "governor", "four_bar", "two_link", "puma560"):
        q, values = pose(symdyn.example(name))
        assert places(symdyn.example(name), q.reshape(1, -1), values).outlines == {}, name


def test_a_frame_far_from_the_centre_of_mass_and_free_letters_tell_the_same():
    assert look(pendulum(inertia=[0.03 + 0.75, 0.06 + 0.75, 0.03], about="frame")) == ("disc", [0.2, 0.2])
    one = symdyn.example("cart_pole")
    free = replace(one, parameters=tuple(replace(p, value=None) for p in one.parameters))
    for values in ({"l": 2.0}, {"l": 0.5}):
        q, numbers = pose(free, parameters=values)
        (way,) = places(free, q.reshape(1, -1), numbers).outlines["pole"].ways
        assert float(np.linalg.norm(way)) == pytest.approx(values["l"] / 2)


@pytest.mark.parametrize("word", OUTLINES)
def test_a_word_is_drawn_with_its_sizes_and_comes_back_from_a_file(word: str):
    kind: OutlineKind = OUTLINES[word]
    said = {"type": word, **dict.fromkeys(kind.sizes, 0.3), **({"axis": [1, 2, 2]} if kind.axis is not None else {})}
    one = pendulum(shape=said)
    assert read_text(write_text(one, "toml").text).bodies == one.bodies
    assert f"bodies.b: shape = {word}: what it looks like" in write_text(one, "urdf", lossy=True).lost
    name, sizes = look(one)
    assert name == word
    assert sizes == [0.15 if kind.half else 0.3] * kind.ways
    svg = symdyn.picture(one, prefix="p-")
    assert svg != symdyn.picture(replace(one, bodies=(replace(one.bodies[0], shape=None),)), prefix="p-")
    q, values = pose(one)
    stage = Stage(one, q.reshape(1, -1), values)
    found, view = stage.places, stage.view
    plain = replace(found, outlines={})
    solids, bare = (standing(one, which, view, {})["b"] for which in (found, plain))
    assert len(solids) == len(bare) + 1


def test_a_word_takes_its_sizes_from_the_inertia():
    assert look(pendulum(inertia=[0.06, 0.12, 0.06], shape="ring")) == ("ring", [0.2, 0.2])
    plane = pendulum(inertia=[0, 0.06, 0], shape="disc", allow_invalid_inertia=True)
    assert look(plane) == ("disc", [0.2, 0.2])
    assert look(pendulum(inertia=[0.04, 0.05, 0.01], shape="point")) == ("point", [])


@pytest.mark.parametrize(
    ("shape", "told"),
    [
        ("cube", 'shape = "cube" is not known; did you mean plate? (there are rod, disc'),
        ({"type": "disc", "length": 1}, 'unknown key "length"'),
        ({"type": "disc", "radius": -1}, "radius = -1 is no length"),
        ({"type": "disc", "radius": "r"}, "r"),
        ({"type": "disc", "radius": 1, "axis": [0, 0, 0]}, "axis is no direction"),
        ("disc", "radius missing, and no inertia to compute"),
        (7, "shape = 7 is not known"),
    ],
)
def test_a_shape_that_is_none_is_told(shape: object, told: str):
    with pytest.raises(SceneError) as caught:
        pendulum(shape=shape)
    assert told in str(caught.value)


def test_sizes_that_no_double_holds_are_left_out():
    for radius in ("1e200", "1e-300"):
        assert "<svg" in symdyn.picture(pendulum(shape={"type": "disc", "radius": radius}))


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.runs("chromium")
def test_in_a_page_a_disc_seen_edge_on_is_a_line_and_turns(tmp_path: Path):
    widths = []
    with chromium() as browser:
        for k, axis in enumerate(([0, 1, 0], [1, 0, 0])):
            file = tmp_path / f"{k}.html"
            shown = pendulum(shape={"type": "disc", "radius": 0.2, "axis": axis})
            file.write_text(interactive_page(shown), encoding="utf-8")
            with opened(browser, file) as page:
                rim = page.locator(".mark[data-mark=disc] path").first
                box = rim.evaluate(WIDTH)
                widths.append(box)
                before = rim.get_attribute("d")
                page.locator("input[type=range]").first.evaluate(
                    "e => { e.value = +e.value + 0.5; e.dispatchEvent(new Event('input', { bubbles: true })); }"
                )
                assert rim.get_attribute("d") != before
    assert widths[0] > 10
    assert widths[1] < 0.05


WIDTH = """e => {
    const n = e.getTotalLength(), [a, b, c, d] = [0, .25, .5, .75].map(s => e.getPointAtLength(s * n));
    return Math.abs((c.x - a.x) * (d.y - b.y) - (c.y - a.y) * (d.x - b.x)) / n;
}"""
"""Area between the quarters of a closed line, by its length: 0 of one that goes and comes back on a straight line."""


def test_a_gimbal_is_drawn_as_rings_around_its_rotor():
    rings = [body(name, mass=1, inertia=["1/100"] * 3, about="com") for name in ("outer", "inner")]
    rotor = body("rotor", mass=1, inertia=["1/200", "1/200", "1/125"], about="com")
    axes = {"outer": ("ground", [0, 0, 1]), "inner": ("outer", [1, 0, 0]), "rotor": ("inner", [0, 0, 1])}
    joints = [revolute(f"j_{child}", parent, child, axis=axis) for child, (parent, axis) in axes.items()]
    gimbal = scene("gimbal", bodies=[*rings, rotor], joints=joints)

    q, values = pose(gimbal)
    found = places(gimbal, q.reshape(1, -1), values).outlines

    assert {name: one.look for name, one in found.items()} == {"outer": "ring", "inner": "ring", "rotor": "disc"}
    radii = [float(np.linalg.norm(found[name].ways[0])) for name in ("rotor", "inner", "outer")]
    assert radii == pytest.approx([0.016**0.5, 1.2 * 0.016**0.5, 1.44 * 0.016**0.5])
    assert interactive_page(gimbal)

"""Animations: one file, the right positions at the right times, and a script that runs."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import closed_mechanisms
import numpy as np
import pytest
from arms import EXAMPLES, two_link
from mechanisms import jointed

from symdyn.draw import animation, moving_picture, picture, pose
from symdyn.draw.animate import MOST
from symdyn.errors import DrawError
from symdyn.scene import read


def motion(nq: int, count: int = 40, until: float = 2.0):
    t = np.linspace(0, until, count)
    return t, np.stack([np.sin((1 + k) * t + k) for k in range(nq)], axis=1)


def data(page: str):
    return json.loads(re.search(r'<script id="motion" type="application/json">(.*?)</script>', page)[1])


def moved(page: str, group: str, kind: str) -> np.ndarray:
    """Return where the last element of a kind in a group is at every moment, shape (N, 2)."""
    body = re.search(rf'<g id="{group}".*?</g>', page, re.DOTALL)[0]
    k = int(re.findall(rf'data-k="(\d+)" data-kind="{kind}"', body)[-1])
    return np.array(data(page)["x"], dtype=float)[:, k : k + 2] / 10


def test_every_moment_is_where_the_mechanism_is() -> None:
    t, q = motion(2)
    page = animation(two_link(), t, q, {"h1": 2.0, "h2": 1.0})
    elbow, tip = moved(page, "joint-elbow", "dot"), moved(page, "mass-link2-1", "dot")
    sums = np.cumsum(q, axis=1)
    way = tip - elbow
    scale = np.linalg.norm(way[0])

    assert data(page)["t"] == pytest.approx(t, abs=1e-6)
    assert way / scale == pytest.approx(np.stack([np.sin(sums[:, 1]), np.cos(sums[:, 1])], axis=1), abs=0.01)
    assert elbow - elbow[0] == pytest.approx(
        2 * scale * np.stack([np.sin(q[:, 0]), np.cos(q[:, 0])], axis=1) - [0, 2 * scale], abs=0.4
    )


def test_the_page_needs_nothing_else() -> None:
    page = animation(two_link(), *motion(2))

    assert not re.search(r"(src|href)\s*=|@import|url\(|fetch\(|import\s", page)
    assert page.count("http") == page.count("http://www.w3.org/2000/svg")
    assert "prefers-reduced-motion" in page


def test_what_stands_still_is_not_repeated() -> None:
    t, q = motion(2)
    page = animation(two_link(), t, np.zeros_like(q))

    assert data(page)["x"] == [[]] * len(t)


@pytest.mark.long
def test_long_motions_are_thinned_to_what_an_eye_sees() -> None:
    t, q = motion(2, 5000, 4.0)
    kept = data(animation(two_link(), t, q))["t"]
    long = data(animation(two_link(), *motion(2, 5000, 4000.0)))["t"]

    assert len(kept) == 121
    assert kept[-1] == 4.0
    assert np.diff(kept).max() < 1.1 / 30
    assert len(long) == MOST


def test_nearer_bodies_come_in_front_as_they_turn() -> None:
    t, q = motion(7, 60)
    changes = data(animation(read(EXAMPLES / "arm7.toml"), t, q * 2))["order"]

    assert len(changes) > 1
    assert all(sorted(order) == list(range(len(order))) for _, order in changes)


@pytest.mark.parametrize("one", [jointed("free", "spherical"), closed_mechanisms.rssr(), read(EXAMPLES / "scara.toml")],
                         ids=lambda one: one.name)  # fmt: skip
def test_the_first_moment_is_the_picture_that_is_shown(one) -> None:
    q, values = pose(one)
    page = animation(one, [0.0, 1.0], [q, q + 0.01], values, (-60, 30))
    joints = re.findall(r'id="((?:joint|loop|body)-\w+)"', page)

    assert joints == re.findall(r'id="((?:joint|loop|body)-\w+)"', picture(one, q, values, (-60, 30), labels=()))


@pytest.mark.runs("node")
def test_the_script_draws_the_first_moment_as_it_was_drawn(tmp_path: Path) -> None:
    page = animation(read(EXAMPLES / "arm7.toml"), *motion(7))
    script = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)[0]
    elements = []
    for element in ElementTree.fromstring(re.search("<svg.*?</svg>", page, re.DOTALL)[0]).iter():
        if element.get("data-k"):
            dataset = {key: element.get(f"data-{key}", "") for key in ("k", "kind", "parts", "closed")}
            elements.append({"dataset": dataset, "drawn": dict(element.items())})
    stub = """
    const elements = ELEMENTS.map(e => ({...e, set: {}, setAttribute(k, v) { this.set[k] = v; }}));
    const item = {dataset: {}, setAttribute() {}, addEventListener() {}, after() {}, value: "1"};
    const groups = Array.from({length: 100}, (_, k) => ({dataset: {item: String(k)}, after() {}}));
    globalThis.document = {
      getElementById: id => id === "motion" ? {textContent: DATA} : item,
      querySelector: () => ({querySelectorAll: s => s === "[data-k]" ? elements : groups}),
      createComment: () => ({before() {}}), addEventListener() {}
    };
    globalThis.matchMedia = () => ({matches: true});
    """.replace("ELEMENTS", json.dumps(elements)).replace("DATA", json.dumps(json.dumps(data(page))))
    check = """
    for (const e of elements) {
      if (!Object.keys(e.set).length) throw new Error("stands still: " + JSON.stringify(e));
      for (const key in e.set) {
        if (String(e.set[key]) !== e.drawn[key]) throw new Error(key + " " + e.set[key] + " for " + e.drawn[key]);
      }
    }
    """
    file = tmp_path / "player.js"
    file.write_text(stub + script + check)

    done = subprocess.run(["node", str(file)], capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stderr
    assert {e["dataset"]["kind"] for e in elements} == {"path", "disc", "dot", "sign", "label"}


@pytest.mark.parametrize(
    ("times", "positions", "message"),
    [
        ([0.0, 1.0], [[0.0, 0.0]], "times have shape"),
        ([], [], "with N at least 1"),
        ([0.0, 0.0], [[0.0, 0.0]] * 2, "must be finite and increase"),
        ([0.0, 1.0], [[0.0, 0.0], [float("nan"), 0.0]], "position at t = 1 is not finite"),
        ([0.0, 1.0], [[0.0]] * 2, "positions have shape"),
    ],
)
def test_faults_say_what_would_work(times, positions, message: str) -> None:
    with pytest.raises(DrawError, match=message):
        animation(two_link(), times, positions)


def test_a_picture_that_moves_by_itself_is_where_the_page_is() -> None:
    t, q = motion(2)
    text = moving_picture(two_link(), t, q, {"h1": 2.0, "h2": 1.0})
    elbow = moved(animation(two_link(), t, q, {"h1": 2.0, "h2": 1.0}), "joint-elbow", "dot")
    root = ElementTree.fromstring(text)
    space = "{http://www.w3.org/2000/svg}"
    group = next(one for one in root.iter(f"{space}g") if one.get("id") == "joint-elbow")
    tracks = {
        one.get("attributeName"): [float(x) for x in one.get("values", "").split(";")]
        for one in [*group.iter(f"{space}circle")][-1]
    }

    assert np.stack([tracks["cx"], tracks["cy"]], axis=1) == pytest.approx(elbow)
    assert "<script" not in text
    assert "data-" not in text
    assert 'dur="2s"' in text
    assert "keyTimes" not in text  # even steps


def test_uneven_moments_have_their_times() -> None:
    text = moving_picture(two_link(), [0.0, 0.5, 2.0], [[0, 0], [0.1, 0.2], [1, 0.5]])

    assert 'keyTimes="0;0.25;1"' in text


def test_what_never_moves_is_a_picture() -> None:
    text = moving_picture(two_link(), [0.0], [[0.3, 0.2]])

    assert "<animate" not in text
    assert "data-" not in text


@pytest.mark.parametrize("one", [jointed("free", "spherical"), closed_mechanisms.rssr(), read(EXAMPLES / "scara.toml")],
                         ids=lambda one: one.name)  # fmt: skip
def test_every_kind_of_shape_moves(one) -> None:
    q, values = pose(one)
    text = moving_picture(one, [0.0, 1.0], [q, q + 0.3], values, (-60, 30))
    tags = [element.tag.split("}")[1] for element in ElementTree.fromstring(text).iter()]

    assert "data-" not in text
    assert tags.count("animateTransform") >= 2
    assert tags.count("animate") >= 2

"""Scenes in Python: ten lines say what a file says, and an editor completes every word of them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args

import pytest

from symdyn.scene import read_text
from symdyn.scene.build import Elements, FrictionKeys, JointKeys, JointType, LimitKeys, MimicKeys, RotorKeys, joint
from symdyn.scene.declaration.coupling import MIMIC
from symdyn.scene.declaration.joint_table import ROTOR, joint_keys
from symdyn.scene.forces.force_table import kinds_of, sections
from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.joint_table import LIMITS
from symdyn.scene.values.key import keys_of

ROOT = Path(__file__).parent.parent

FILE = """
name = "crane"
gravity = [0, "-g", 0]
parameters = { m = { positive = true }, l = {}, g = 9.81 }
inputs = { u = { value = 0 } }
[bodies.cart]
mass = 10
[bodies.bob]
mass = "m"
com = [0, "-l", 0]
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
drive = "F"
force = "2*u"
[joints.rope]
type = "revolute"
parent = "cart"
child = "bob"
drive = false
limits = { lower = -1, upper = 1 }
[springs.buffer]
joint = "rail"
stiffness = 100
"""

TEN_LINES = """
from symdyn.scene import body, parameter, prismatic, revolute, scene, spring
crane = scene(
    "crane", gravity=[0, "-g", 0], inputs={"u": 0},
    parameters=[parameter("m", positive=True), parameter("l"), parameter("g", 9.81)],
    bodies=[body("cart", mass=10), body("bob", mass="m", com=[0, "-l", 0])],
    joints=[prismatic("rail", "ground", "cart", axis=[1, 0, 0], drive="F", force="2*u"),
            revolute("rope", "cart", "bob", drive=False, limits={"lower": -1, "upper": 1})],
    springs=[spring("buffer", joint="rail", stiffness=100)],
)
""".strip()


def test_ten_lines_are_the_scene_of_a_file():
    made: dict[str, Any] = {}
    exec(TEN_LINES, made)

    assert len(TEN_LINES.splitlines()) <= 10
    assert made["crane"] == read_text(FILE)


def test_types_have_the_words_of_the_tables():
    where = "in symdyn/scene/build.py; it has what the tables of scenes have"
    assert set(get_args(JointType)) == set(JOINTS), f"change JointType {where}"
    keys = set(joint_keys()) - {"type", "parent", "child", "drives", "forces"}
    assert set(JointKeys.__annotations__) == keys, f"change JointKeys, and the docstring of `joint`, {where}"
    untold = [key for key in keys if f" {key}: " not in str(joint.__doc__)]
    assert untold == [], f"say what they are in the docstring of `joint` {where}"
    assert set(LimitKeys.__annotations__) == set(keys_of(LIMITS))
    assert set(MimicKeys.__annotations__) == set(keys_of(MIMIC))
    assert set(RotorKeys.__annotations__) == set(keys_of(ROTOR))
    assert set(FrictionKeys.__annotations__) == set(keys_of(kinds_of("friction")["friction"].parts))
    assert set(Elements.__annotations__) == set(sections()), f"change Elements {where}"


class Editor:
    """Speaks to Pyright's language server, as editors do."""

    def __init__(self) -> None:
        words = [sys.executable, "-m", "pyright.langserver", "--stdio"]
        self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT)
        self.asked = 0
        folder = [{"uri": ROOT.as_uri(), "name": "symdyn"}]
        may = {"workspace": {"configuration": True}}
        self.ask("initialize", {"processId": None, "workspaceFolders": folder, "capabilities": may})
        self.send({"method": "initialized", "params": {}})

    def send(self, message: dict[str, Any]) -> None:
        content = json.dumps({"jsonrpc": "2.0", **message}).encode()
        assert self.process.stdin
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(content) + content)
        self.process.stdin.flush()

    def receive(self) -> dict[str, Any]:
        assert self.process.stdout
        length = 0
        while line := self.process.stdout.readline().strip():
            name, _, value = line.partition(b":")
            length = int(value) if name.lower() == b"content-length" else length
        found: dict[str, Any] = json.loads(self.process.stdout.read(length))
        return found

    def ask(self, method: str, params: dict[str, Any]) -> Any:
        self.asked += 1
        self.send({"id": self.asked, "method": method, "params": params})
        while True:
            answer = self.receive()
            if "method" in answer and "id" in answer:  # it asks for settings
                python = {"pythonPath": sys.executable}
                items = answer.get("params", {}).get("items", [])
                told = [python if one.get("section") == "python" else {} for one in items]
                self.send({"id": answer["id"], "result": told})
            elif answer.get("id") == self.asked and "method" not in answer:
                return answer["result"]

    def completes(self, text: str) -> set[str]:
        """Return what may stand where the text says |."""
        before, _, after = text.partition("|")
        uri = (ROOT / f"asked_{self.asked}.py").as_uri()
        page = {"uri": uri, "languageId": "python", "version": 1, "text": before + after}
        self.send({"method": "textDocument/didOpen", "params": {"textDocument": page}})
        at = {"line": before.count("\n"), "character": len(before.rpartition("\n")[2])}
        found = self.ask("textDocument/completion", {"textDocument": {"uri": uri}, "position": at})
        return {one["label"] for one in (found["items"] if isinstance(found, dict) else found)}


@pytest.mark.runs("node")
@pytest.mark.long(0)
def test_an_editor_completes_the_words_of_scenes():
    pytest.importorskip("pyright")
    editor = Editor()
    try:
        of_joint = editor.completes('from symdyn.scene import revolute\nrevolute("a", "ground", "b", |)')
        of_type = editor.completes('from symdyn.scene import joint\njoint("a", "|")')
        of_scene = editor.completes('from symdyn.scene import scene\nscene("a", |)')
        of_body = editor.completes('import symdyn\nsymdyn.scene.body("a", |)')
    finally:
        editor.process.kill()
        editor.process.communicate()

    assert {f"{word}=" for word in JointKeys.__annotations__} <= of_joint
    assert {f'"{word}"' for word in JOINTS} <= of_type
    assert {"bodies=", "joints=", "inputs=", "springs=", "constraints="} <= of_scene
    assert {"mass=", "com=", "inertia=", "about="} <= of_body

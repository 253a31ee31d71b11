"""What learning platforms make of the files of exercises: Maxima walks STACK's trees, a small reader evaluates JME."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

ALG_EQUIV = """
alg_equiv(a, b) := block([d], if is(a = b) then true
  else if listp(a) or listp(b) then is(listp(a) and listp(b) and length(a) = length(b) and every(alg_equiv, a, b))
  else if setp(a) or setp(b) or member(a, [true, false]) or member(b, [true, false]) then false
  else (d: errcatch(fullratsimp(trigreduce(expand(num(fullratsimp(a - b)))))), is(d = [0])))$
"""
"""AlgEquiv as STACK's documents tell it: the difference vanishes, of lists entry by entry, of sets as sets."""


class Stack:
    """A question of STACK, read from its file."""

    def __init__(self, text: str) -> None:
        self.root = ElementTree.fromstring(text)
        (self.question,) = self.root.findall("question")
        self.variables = self.question.findtext("questionvariables/text") or ""
        self.trees = {tree.findtext("name"): tree for tree in self.question.findall("prt")}

    def notes(self, answers: Sequence[tuple[int, str]], seed: int = 1) -> list[tuple[float, str]]:
        """Return score and note of each answer to a part by number: "right", "rule3"; "" where no node says yes."""
        lines = [f"display2d: false$ stack_seed: {seed}$", ALG_EQUIV, self.variables.replace("\n", " ")]
        for number, text in answers:
            tree = self.trees[f"prt{number}"]
            feedback = (tree.findtext("feedbackvariables/text") or "").replace("\n", " ")
            chain = '""'
            for node in reversed(tree.findall("node")):
                assert node.findtext("answertest") == "AlgEquiv"
                note, score = node.findtext("trueanswernote") or "", node.findtext("truescore")
                test = f"alg_equiv({node.findtext('sans')}, {node.findtext('tans')})"
                chain = f'if {test} then "{score} {note.partition("-")[2]}" else {chain}'
            lines.append(f'kill(ans{number})$ ans{number}: {text}$ {feedback} print("NOTE", {chain})$')
        script = "\n".join(lines)
        done = subprocess.run(["maxima", "--very-quiet"], input=script, capture_output=True, text=True, timeout=500)
        told = re.findall(r"^NOTE ?(.*)$", done.stdout, re.MULTILINE)
        assert len(told) == len(answers), f"{done.stdout[-3000:]}\n{done.stderr[-500:]}"
        pairs = [one.strip().partition(" ") for one in told]
        return [(float(score or 0), note.strip()) for score, _, note in pairs]

    def value(self, name: str, seed: int = 1) -> str:
        """Return a question variable as Maxima prints it."""
        script = f"display2d: false$ stack_seed: {seed}$\n{self.variables}\nprint(\"VALUE\", string({name}))$"
        done = subprocess.run(["maxima", "--very-quiet"], input=script, capture_output=True, text=True, timeout=500)
        found = re.search(r"^VALUE (.*?)\s*$", done.stdout.replace("\\\n", ""), re.MULTILINE)
        assert found, done.stdout[-2000:]
        return found[1]


def read_stack(path: Path) -> Stack:
    """Return the question of a file."""
    return Stack(path.read_text(encoding="utf-8"))

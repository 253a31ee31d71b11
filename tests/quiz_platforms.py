"""What learning platforms make of the files of exercises: Maxima walks STACK's trees, a small reader evaluates JME."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Sequence
from xml.etree import ElementTree

ALG_EQUIV = """
alg_equiv(a, b) := block([d], if is(a = b) then true
  else if listp(a) or listp(b) then is(listp(a) and listp(b) and length(a) = length(b) and every(alg_equiv, a, b))
  else if setp(a) or setp(b) or member(a, [true, false]) or member(b, [true, false]) then false
  else (d: errcatch(fullratsimp(trigreduce(expand(num(fullratsimp(a - b)))))), is(d = [0])))$
"""
"""AlgEquiv as STACK's documents tell it: the difference vanishes, of lists entry by entry, of sets as sets."""

OWN = """
file_search_maxima: append(["{folder}/###.{{mac,mc}}"], file_search_maxima)$
file_search_lisp: append(["{folder}/###.{{lisp}}"], file_search_lisp)$
STACK_SETUP(x) := block(MAXIMA_PLATFORM: "linux", IMAGE_DIR: "/tmp/", PLOT_SIZE: [450, 300], PLOT_TERMINAL: "svg",
  PLOT_TERM_OPT: "", DEL_CMD: "rm", GNUPLOT_CMD: "gnuplot", MAXIMA_VERSION_EXPECTED: "", URL_BASE: "", true)$
load("stackmaxima.mac")$
simp: true$
alg_equiv(a, b) := is(second(ATAlgEquiv(a, b)) = true)$
"""
"""STACK's own functions, where STACK_MAXIMA is the folder stack/maxima of a copy of it."""


class Stack:
    """A question of STACK, read from its file."""

    def __init__(self, text: str) -> None:
        self.root = ElementTree.fromstring(text)
        (self.question,) = self.root.findall("question")
        self.variables = self.question.findtext("questionvariables/text") or ""
        self.trees = {tree.findtext("name"): tree for tree in self.question.findall("prt")}

    def notes(self, answers: Sequence[tuple[int, str]], seed: int = 1) -> list[tuple[float, str]]:
        """Return score and note of each answer to a part by number: "right", "rule3"; "" where no node says yes."""
        folder = os.environ.get("STACK_MAXIMA")
        tests = OWN.format(folder=folder) if folder else ALG_EQUIV
        lines = [tests, f"display2d: false$ stack_seed: {seed}$", self.variables.replace("\n", " ")]
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
        printed = maxima(script)
        told = re.findall(r"^NOTE ?(.*)$", printed, re.MULTILINE)
        assert len(told) == len(answers), printed[-3000:]
        pairs = [one.strip().partition(" ") for one in told]
        return [(float(score or 0), note.strip()) for score, _, note in pairs]


def maxima(script: str) -> str:
    """Return what Maxima prints."""
    command = ["maxima", "--very-quiet"]
    return subprocess.run(command, input=script, capture_output=True, text=True, timeout=500, check=True).stdout

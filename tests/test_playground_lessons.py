"""Lessons of the page that has Python inside: made without NumPy and SciPy, they say what other lessons say."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from patience import HANG

from symdyn.playground import answer
from symdyn.scene import examples

ROOT = Path(__file__).parent.parent
LESSON = """
import json, sys
sys.path.insert(0, sys.argv[1])
from symdyn.playground import answer
text = answer("example", "", {"name": sys.argv[2]})["text"]
told = answer("lesson", text, {"language": sys.argv[3]})
import numpy
assert "standin" in numpy.__file__ and not hasattr(numpy, "fft"), "there is a NumPy after all"
print(json.dumps(told))
"""
LEFT_OUT = {"en": "worked out in numbers, with Python and SciPy", "sk": "počíta sa číselne, Pythonom so SciPy"}
WITHOUT = ("near-",)
"""Steps for which the sentence about places of rest stands, too."""

MORE = {"states-rest"}
"""What a lesson leaves out that has found no places of rest in numbers."""

FEW = (("pendulum", "en"), ("rolling_disc", "sk"))
LONG = ("humanoid",)
"""Whose lesson takes minutes."""


def steps(page: str) -> dict[str, str]:
    """Return what a page says in each step, without the numbers by which its script finds formulas."""
    found = re.findall(r'<article class="step[^>]*? id="step-([^"]*)"(.*?)</article>', page, re.DOTALL)
    plain = {key: re.sub(r' data-n="[^"]*"', "", text) for key, text in found}
    bold = r"<tr><td><math [a-z-]*=\"𝐌\">.*?</tr>\n?"  # said only where it is used: next to places of rest
    return {key: re.sub(bold, "", text) if key == "notation" else text for key, text in plain.items()}


@pytest.mark.runs
@pytest.mark.parametrize(
    ("name", "language"),
    [
        FEW[0],
        pytest.param(*FEW[1], marks=pytest.mark.slow),
        *(
            pytest.param(name, "en", marks=pytest.mark.slow)
            for name in examples()
            if name not in (*LONG, *(few for few, _ in FEW))
        ),
    ],
)
def test_a_lesson_without_numpy_says_the_same_but_for_what_it_leaves_out_in_words(name: str, language: str) -> None:
    command = [sys.executable, "-c", LESSON, str(ROOT / "docs" / "site" / "playground" / "standin"), name, language]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT, timeout=HANG)
    other = json.loads(done.stdout)
    real = answer("lesson", answer("example", "", {"name": name})["text"], {"language": language})

    assert "failed" not in real
    if "refused" in real:
        assert other == real
        return
    told, said = steps(real["page"]), steps(other["page"])
    left_out = {key for key, text in said.items() if LEFT_OUT[language] in text}
    assert len(told) > 20
    both = (told.keys() & said.keys()) - left_out
    assert [key for key in both if told[key] != said[key]] == []
    assert said.keys() - told.keys() <= left_out | MORE
    assert all(key.startswith(WITHOUT) for key in told.keys() - said.keys())
    assert LEFT_OUT[language] not in real["page"]
    assert left_out or told.keys() == said.keys()

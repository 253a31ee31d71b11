"""What the page asks at once about its first example: what this imports travels first."""

from symdyn.playground import answer

text = answer("example", "", {"name": "two_link"})["text"]
for what in ("begin", "scene", "equations"):
    told = answer(what, text, {})
    assert "failed" not in told, told

"""A block of 2 kg on a slide without friction, that a force F drives: it begins at x = 0.5 m, at -1 m/s."""

from symdyn.scene.toml import read_text

TEXT = """
name = "block"
gravity = "none"
[bodies.block]
mass = 2
[joints.slide]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
start = 0.5
start_rates = -1
"""

BLOCK = read_text(TEXT)

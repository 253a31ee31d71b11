"""Faults of scenes without their lines, for tests of what they say; where they are: `tests/test_scene_places.py`."""

import re


def placeless(fault: object) -> str:
    """Return a fault, or several in lines, as `source: where: what`."""
    return re.sub(r"(?m)^(.*?(?:\.toml|stdin|scene)):\d+: ", r"\1: ", str(fault))

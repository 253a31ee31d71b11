"""What a joint's row may say beside what every row says: each such field has a check that fails without it.

The fields that every row says are checked on a type from outside, in `recipes/check_rack_and_pinion.py`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import MISSING, fields, replace

import pytest

from symdyn.dynamics.mechanism.angles import angles_of
from symdyn.errors import SceneError
from symdyn.scene import Scene, lock, parse, read_text
from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.joint_kind import JointKind

TEXT = """
name = "one"
[bodies.a]
mass = 1
[joints.j]
type = "TYPE"
parent = "ground"
child = "a"
"""


def one(kind: str, more: str = "") -> Scene:
    return read_text(TEXT.replace("TYPE", kind) + more)


def check_turned() -> None:
    """A joint declared from its body towards ground carries the body all the same, about the opposite axis."""
    for kind in ("revolute", "universal"):
        backwards = TEXT.replace('"ground"', '"x"').replace('"a"', '"ground"').replace('"x"', '"a"')
        (joint,) = read_text(backwards.replace("TYPE", kind)).joints

        assert (joint.parent, joint.child) == ("ground", "a")
        assert joint.axis == tuple(map(parse, ("0", "0", "-1") if kind == "revolute" else ("-1", "0", "0")))


def check_held() -> None:
    """A joint that is locked stands where its motion puts it."""
    arm = '[bodies.b]\nmass = 1\n[joints.k]\ntype = "revolute"\nparent = "a"\nchild = "b"\n'
    steps = {"revolute": (("Rz", parse("1/2")),), "prismatic": (("Tz", parse("1/2")),)}
    for kind, found in steps.items():
        assert lock(one(kind, arm), {"j": parse("1/2")}).joints[0].origin.steps == found


def check_gimbals() -> None:
    """Angles that are singular somewhere are known, with what mends it."""
    for kind, first in (("spherical", 0), ("point_on_line", 1), ("point_on_plane", 2), ("free", 3)):
        (angles,) = angles_of(one(kind, 'orientation = "zyx"\n'))

        assert angles.names == tuple(f"q{first + k}" for k in (1, 2, 3))
        assert 'orientation = "quaternion"' in angles.gimbal.remedy
        assert not list(angles_of(one(kind)))
    assert len(list(angles_of(one("rod", "length = 1\n")))) == 1


def check_fault() -> None:
    """Axes that are right one by one and parallel are refused."""
    with pytest.raises(SceneError, match=r"second_axis = .* is parallel to axis"):
        one("universal", "axis = [2, 0, 0]\n")


CHECKS: dict[str, tuple[tuple[str, ...], Callable[[], None]]] = {
    "turned": (("revolute", "universal"), check_turned),
    "held": (("revolute", "prismatic"), check_held),
    "gimbals": (("spherical", "point_on_line", "point_on_plane", "free", "rod"), check_gimbals),
    "fault": (("universal",), check_fault),
}
"""By field: the types that are looked at, and what they do by it."""

DEFAULTS = {one.name: one.default for one in fields(JointKind) if one.default is not MISSING}


def test_every_field_that_a_row_may_leave_out_has_a_check() -> None:
    assert set(CHECKS) == set(DEFAULTS)


@pytest.mark.parametrize("field", CHECKS)
def test_a_type_does_what_its_row_may_say(field: str) -> None:
    CHECKS[field][1]()


@pytest.mark.parametrize(("field", "kind"), [(field, kind) for field, (kinds, _) in CHECKS.items() for kind in kinds])
def test_a_row_without_such_a_field_fails_its_check(field: str, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(JOINTS, kind, replace(JOINTS[kind], **{field: DEFAULTS[field]}))
    monkeypatch.setattr(sys.modules[__name__], "TEXT", f"{TEXT}# without {field}\n")  # a text that nobody has read

    with pytest.raises((AssertionError, SceneError, ValueError, pytest.fail.Exception)):
        CHECKS[field][1]()

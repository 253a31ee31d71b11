"""What a joint looks like: its symbol as parts that pictures know how to draw, and its sign on pages of lessons."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MarkPart:
    """One part of a symbol.

    Attributes:
        shape: a key of `PARTS` in `symdyn.draw.joint_symbols`.
        half: its size from its middle, in halves of a symbol's width; 0 for shapes of one size.
        way: its direction: a key of the joint that is one, or "x", "y", "z" of the joint frame.
    """

    shape: str
    half: float = 0.0
    way: str = "axis"


@dataclass(frozen=True)
class PageSign:
    """How pages of lessons draw a joint.

    Attributes:
        shape: what their script draws; "" for nothing.
        slides: whether it slides on a rail, along which a spring in it lies.
        line: whether a line joins its ends.
    """

    shape: str = ""
    slides: bool = False
    line: bool = False


TURN, SLIDE, WELD, LINE = PageSign("turn"), PageSign("slide", slides=True), PageSign("weld"), PageSign(line=True)


@dataclass(frozen=True)
class JointMark:
    """The symbol of a joint: what it leaves free.

    Attributes:
        parts: of the symbol, from below.
        flat: of the symbol face-on in a planar picture; () for the same ones.
        sign: on pages of lessons.
    """

    parts: tuple[MarkPart, ...]
    flat: tuple[MarkPart, ...] = ()
    sign: PageSign = TURN

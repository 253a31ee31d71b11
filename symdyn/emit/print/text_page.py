"""Equations as plain text, one formula a paragraph, lines that fit a terminal."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

from symdyn.algebra import Form
from symdyn.emit.print.breaking import BREAK, break_lines
from symdyn.emit.print.formula_text import broken_text, text_of
from symdyn.emit.print.printable import ENTRYWISE, Lengths, Printable
from symdyn.scene import Scene

WIDTH = 110
INDENT = "    "


def text_page(page: Printable, group: str) -> str:
    """Return the equations in plain text; indices from 1."""
    motions = (equation_lines(name, broken_text(form)) for name, form in page.motions)
    lengths = length_lines(page.lengths, dict(page.definitions))
    return "\n".join([*PARAGRAPHS[group](page), *motions, *lengths, *_constraints(page, group)])


def text_definitions(scene: Scene, named: Sequence[tuple[str, Form]]) -> str:
    """Return `name = formula`, one a paragraph."""
    return "\n".join(equation_lines(name, broken_text(form)) for name, form in named)


def coefficient_name(kind: str, indices: Sequence[int]) -> str:
    """Return k_z12, k_C1_23, k_D12, k_G1, k_E1; with more than nine joints k_z1_12."""
    first, *rest = map(str, indices)
    if any(i > 9 for i in indices):
        return f"{kind}{'_'.join([first, *rest])}"
    return f"{kind}{first}{'_' if len(rest) > 1 else ''}{''.join(rest)}"


def equation_lines(left: str, right: str) -> str:
    """Return `left = right`, both with break marks, in lines; a long right-hand side starts one."""
    if BREAK not in left:  # a definition
        return _lines(f"{left} = {right}", WIDTH)
    shown = _lines(left, WIDTH)
    plain = right.replace(BREAK, "")
    if len(shown.rpartition("\n")[2]) + len(plain) + 3 <= WIDTH:
        return f"{shown} = {plain}"
    return f"{shown}\n{INDENT}{_lines(f'= {right}', WIDTH - len(INDENT))}"


def _lines(text: str, first: int) -> str:
    return f"\n{INDENT}".join(break_lines(text, first, WIDTH - len(INDENT), len))


def _equations(page: Printable) -> Iterator[str]:
    for i in range(len(page.rows)):
        yield equation_lines(broken_text(page.left(i)), broken_text(page.driving(i)))


def _textbook(page: Printable) -> Iterator[str]:
    for i, row in enumerate(page.rows):
        names = [(coefficient_name(c.kind, c.indices), c) for c in row if not c.vanishes]
        terms = (f"{name}*{text_of(c.rate)}" if c.of else name for name, c in names)
        yield equation_lines(broken_text(page.driving(i)), f" {BREAK}+ ".join(terms) or "0")
    yield ""
    yield from _coefficients(page)


def _matrix(page: Printable) -> Iterator[str]:
    yield f"M*qdd + c + g = tau{' + G^T*lambda' if page.constraints.rows else ''}"
    yield ""
    n = range(len(page.rows))
    for c in (c for i in n for c in page.inertia(i)):
        if c.indices == min(c.places):
            yield equation_lines(" = ".join(f"M[{i},{j}]" for i, j in c.places), broken_text(c.form))
    for name, entry in (("c", page.coriolis), ("g", page.gravity)):
        yield from (equation_lines(f"{name}[{i + 1}]", broken_text(entry(i))) for i in n)
    yield from (equation_lines(f"tau[{i}]", broken_text(right)) for i, right in enumerate(page.right, 1))


def length_lines(lengths: Lengths, used: Container[str]) -> Iterator[str]:
    """Yield what names of lengths are, and what they stand for, those that are used."""
    for one in lengths.named:
        if one.name in used:
            yield ""
            yield f"# {one.name}: {one.text}, m"
        yield from (equation_lines(name, broken_text(form)) for name, form in one.defined if name in used)


def _constraints(page: Printable, group: str) -> Iterator[str]:
    """Yield what the multipliers are, and the rows: in full, or entry by entry."""
    found = page.constraints
    if not found.rows:
        return
    yield ""
    for row in found.rows:
        yield f"# {row.multiplier}: {row.text}{f', {row.unit}' if row.unit else ''}"
    if found.missing:
        yield f"# G has no closed form: {found.missing}"
        return
    if ENTRYWISE[group]:
        yield ""
        if group == "matrix":
            yield "r = 0, G*qd = 0, G*qdd + Gdot*qd = 0"
            yield ""
        for k, row in enumerate(found.rows, 1):
            if row.residual is not None:
                yield equation_lines(f"r[{k}]", broken_text(row.residual))
            for i, entry in enumerate(row.G, 1):
                yield equation_lines(f"G[{k},{i}]", broken_text(entry))
            if row.bias is not None:
                yield equation_lines(f"(Gdot*qd)[{k}]", broken_text(row.bias))
        return
    blocks = (("positions", found.positions()), ("velocities", found.rates()), ("accelerations", found.accelerations()))
    for name, forms in blocks:
        if forms:
            yield ""
            yield f"# {name}"
        yield from (equation_lines(broken_text(form) + BREAK, "0").replace(BREAK, "") for form in forms)


def _coefficients(page: Printable) -> Iterator[str]:
    for c in page.written:
        yield equation_lines(" = ".join(coefficient_name(c.kind, place) for place in c.places), broken_text(c.form))
    for zero in page.vanishing:
        yield _zero_line([coefficient_name(c.kind, c.indices) for c in zero])


def _zero_line(names: list[str]) -> str:
    lines, line = [], ""
    for name in [*names, "0"]:
        if len(line) + len(name) > WIDTH:
            lines.append(line.rstrip())
            line = INDENT
        line += f"{name} = " if name != "0" else "0"
    return "\n".join([*lines, line])


PARAGRAPHS = {"equations": _equations, "coefficients": _coefficients, "textbook": _textbook, "matrix": _matrix}

"""Equations as plain text and as SymPy's text, one formula a paragraph, lines that fit a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from symdyn.algebra.form import Form
from symdyn.emit.breaking import break_lines
from symdyn.emit.equations import KINDS, Coefficient, Printable, coriolis, gravity
from symdyn.emit.formula_text import broken_text, text_of

WIDTH = 110
INDENT = "    "


def text_page(page: Printable, group: str) -> str:
    """Return the equations in plain text; indices from 1."""
    return "\n".join(_paragraphs(page, group, _wrapped))


def sympy_page(page: Printable, group: str) -> str:
    """Return the equations in SymPy's words: `name = expression`, or Eq(…) for an equation."""
    from symdyn.algebra.sympy_algebra import form_to_sympy

    def show(left: str, form: Form, right: str) -> str:
        expression = str(form_to_sympy(form))
        return f"Eq({expression}, {right})" if right else f"{left} = {expression}"

    return "\n".join(_paragraphs(page, group, show))


def coefficient_name(c: Coefficient) -> str:
    """Return k_z12, k_C1_23, k_D12, k_G1; with more than nine joints k_z1_12."""
    first, *rest = [str(i) for i in c.indices]
    if any(i > 9 for i in c.indices):
        return f"{c.kind}{'_'.join([first, *rest])}"
    return f"{c.kind}{first}{'_' if c.kind == 'k_C' else ''}{''.join(rest)}"


Show = Callable[[str, Form, str], str]  # (name, form, "") for a definition, ("", left side, right side) else


def _wrapped(left: str, form: Form, right: str) -> str:
    start, end = f"{left} = " if left else "", f" = {right}" if right else ""
    lines = break_lines(broken_text(form), WIDTH - len(start), WIDTH - len(INDENT) - len(end), len)
    return f"\n{INDENT}".join([start + lines[0], *lines[1:]]) + end


def _paragraphs(page: Printable, group: str, show: Show) -> Iterator[str]:
    if group == "coefficients":
        yield from _coefficients(page, show)
    elif group == "textbook":
        for row, right in zip(page.rows, page.right, strict=True):
            yield f"{text_of(right)} = {' '.join(_named_terms(row))}"
        yield ""
        yield from _coefficients(page, show)
    elif group == "matrix":
        n = len(page.rows)
        yield "M*qdd + c + g = tau"
        yield ""
        for i, row in enumerate(page.rows, 1):
            for c in row:
                if c.kind == "k_z" and c.indices[1] >= i:
                    mirrored = "" if c.indices[1] == i else f" = M[{c.indices[1]},{i}]"
                    yield show(f"M[{i},{c.indices[1]}]{mirrored}", c.form, "")
        for name, entry in (("c", coriolis), ("g", gravity)):
            yield from (show(f"{name}[{i + 1}]", entry(page, i), "") for i in range(n))
        yield from (f"tau[{i}] = {text_of(right)}" for i, right in enumerate(page.right, 1))
    else:
        for i, right in enumerate(page.right):
            yield show("", page.left(i), text_of(right))


def _coefficients(page: Printable, show: Show) -> Iterator[str]:
    for c in page.coefficients:
        if c.vanishes or (c.kind == "k_z" and c.indices[0] > c.indices[1]):
            continue
        mirrored = c.kind == "k_z" and c.indices[0] != c.indices[1]
        twin = f" = {coefficient_name(Coefficient(c.kind, c.indices[::-1], c.form, c.rate))}" if mirrored else ""
        yield show(coefficient_name(c) + twin, c.form, "")
    for kind in KINDS:
        zero = [coefficient_name(c) for c in page.coefficients if c.kind == kind and c.vanishes]
        if zero:
            yield _zero_line(zero)


def _zero_line(names: list[str]) -> str:
    lines, line = [], ""
    for name in [*names, "0"]:
        if len(line) + len(name) > WIDTH:
            lines.append(line.rstrip())
            line = INDENT
        line += f"{name} = " if name != "0" else "0"
    return "\n".join([*lines, line])


def _named_terms(row: tuple[Coefficient, ...]) -> Iterator[str]:
    for k, c in enumerate(c for c in row if not c.vanishes):
        name = coefficient_name(c)
        rate = text_of(c.rate)
        yield ("+ " if k else "") + (name if c.kind == "k_G" else f"{name}*{rate}")

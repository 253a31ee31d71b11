"""Loops and rows in LaTeX: what the multipliers are, and what they keep, in full or entry by entry."""

from __future__ import annotations

from symdyn.algebra.form import Form
from symdyn.emit.escape import in_latex
from symdyn.emit.print.breaking import latex_width
from symdyn.emit.print.formula_text import Latex
from symdyn.emit.print.latex_layout import LINE, align, bmatrix, definition, entry_name, lines_of, matrix_width
from symdyn.emit.print.printable import ENTRYWISE, Printable, PrintedConstraints

RATE = r"(\dot G\,\dot q)"


def constraint_page(page: Printable, group: str, write: Latex) -> str:
    """Return what every multiplier is, and r = 0, G q̇ = 0, G q̈ + Ġ q̇ = 0."""
    found = page.constraints
    named = "; ".join(
        f"${write.symbols[row.multiplier]}$ {in_latex(row.text)}{f', {in_latex(row.unit)}' if row.unit else ''}"
        for row in found.rows
    )
    lines = [f"Multipliers: {named}.\n"]
    if found.missing:
        lines.append(rf"$G$ has no closed form: {in_latex(found.missing)}.")
    elif ENTRYWISE[group]:
        lines += _entries(found, write)
    else:
        lines += _in_full(found, write)
    return "\n".join(lines)


def _in_full(found: PrintedConstraints, write: Latex) -> list[str]:
    lines = []
    blocks = (("Positions", found.positions()), ("Velocities", found.rates()), ("Accelerations", found.accelerations()))
    for name, forms in blocks:
        if forms:
            lines += [f"{name}:", *align([lines_of("", write(form), "= 0") for form in forms])]
    return lines


def _entries(found: PrintedConstraints, write: Latex) -> list[str]:
    """Return the laws with names, and below the entries: G as a matrix where it fits."""
    laws = [r"G\,\dot q = 0,", r"G\,\ddot q + \dot G\,\dot q = 0"]
    laws = [*(["r(q) = 0,"] if found.positions() else []), *laws]
    lines = list(align([["& " + r" \qquad ".join(laws)]]))
    paragraphs = []
    for k, row in enumerate(found.rows):
        if row.residual is not None:
            paragraphs.append(definition(entry_name("r", k), write(row.residual)))
    entries = [[write.unbroken(form) for form in row.G] for row in found.rows]
    whole = matrix_width(entries) + latex_width("G = ") + 30 < LINE
    if whole:
        paragraphs.append([f"G &= {bmatrix(entries)}"])
    for k, row in enumerate(found.rows):
        forms: list[tuple[str, Form]] = []
        if not whole:
            forms += [(entry_name("G", k, i), form) for i, form in enumerate(row.G)]
        if row.bias is not None:
            forms.append((entry_name(RATE, k), row.bias))
        paragraphs += [definition(name, write(form)) for name, form in forms]
    return [*lines, *align(paragraphs)]

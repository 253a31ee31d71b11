r"""Equations in LaTeX and as plain text.

LaTeX is a fragment for a text that loads amsmath, or a whole document that pdflatex compiles.

Lines of LaTeX fit an A4 page with 20 mm margins at 10 pt; they break at + and -, so brackets are \bigl( and not \left(.
A table of symbols says what each letter is, its unit and its value. Plain text has one formula a paragraph, in lines
that fit a terminal.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

from symdyn.algebra import Form
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.emit.print.breaking import (
    BREAK,
    DIGITS,
    INDENT,
    LINE,
    BMatrix,
    Line,
    align,
    break_lines,
    definitions,
    entry_name,
    equations,
    latex_width,
)
from symdyn.emit.print.formula_text import Latex, broken_text, text_of, value_text
from symdyn.emit.print.printable import ENTRYWISE, Coefficient, Lengths, Printable, PrintedConstraints, other_rates
from symdyn.emit.print.printed_names import Letters, head, latex_symbols, latex_unit
from symdyn.emit.render import in_latex
from symdyn.rounding import digits_or
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.forces import elastic
from symdyn.scene.values import acceleration_name


def symbol_table(scene: Scene, write: Latex, timed: bool) -> list[dict[str, str]]:
    """Return the rows: coordinates, drives, time, parameters."""
    rows, told = [], SceneUnits(scene).inferred
    for joint, q, unit in SceneUnits(scene).each_coordinate():
        rows.append(
            symbol_row(write.symbols[q], f"coordinate of joint {joint.name}, {joint.type}", scene.shown_unit(unit))
        )
    for joint, drive, unit in SceneUnits(scene).each_drive():
        text = f"driving {'force' if unit == 'N' else 'torque'} of joint {joint.name}"
        rows.append(symbol_row(write.symbols[drive], text, scene.shown_unit(unit)))
    if timed:
        rows.append(symbol_row(write.symbols[TIME], "time", scene.shown_unit("s")))
    for kind, letters in (("input", scene.inputs), ("state", scene.states)):
        rows += [symbol_row(write.symbols[one.name], one.text or kind, told[one.name]) for one in letters]
    for parameter in scene.parameters:
        value = in_latex(value_text(parameter.value)) if parameter.value is not None else ""
        rows.append(
            symbol_row(write.symbols[parameter.name], parameter.text or "parameter", told[parameter.name], value)
        )
    return rows


def symbol_row(symbol: str, text: str, unit: str, value: str = "") -> dict[str, str]:
    """Return one row of the table."""
    shown = latex_unit(unit)
    return {"symbol": symbol, "text": in_latex(text), "unit": f"${shown}$" if shown else "", "value": value}


BRACED = 0.45 * LINE  # a wider coefficient is named under its brace and written out below


def latex_fragment(page: Printable, group: str) -> str:
    """Return the equations as displays; short notation is explained in comments."""
    lines = [f"% {one}" for one in page.shorthands(page.writer().unbroken)] + _displays(page, group, page.definitions)
    if page.constraints.rows:
        lines.append(constraint_page(page, group, page.writer()))
    return "\n".join(lines)


def latex_document(page: Printable, group: str) -> str:
    """Return a standalone document: equations, energies, symbol table."""
    from symdyn.emit.render import render

    write, letters = page.writer(), Letters(page.scene)
    title = "Coefficients" if group == "coefficients" else "Equations"
    defined = page.lengths.used((*page.forms, page.K, page.P))
    displays = "\n".join(_displays(page, group, defined))
    sections = [{"title": title, "text": _introduction(page, group), "body": displays}]
    if page.constraints.rows:
        sections.append({"title": "Loops and rows", "text": "", "body": constraint_page(page, group, write)})
    timed = any(TIME in form.symbols for form in (*page.right, *(form for _, form in page.beside)))
    symbols = symbol_table(page.scene, write, timed)
    symbols += [symbol_row(write.symbols[row.multiplier], row.text, row.unit) for row in page.constraints.rows]
    used = dict(defined)
    symbols += [symbol_row(write.symbols[one.name], one.text, "m") for one in page.lengths.named if one.name in used]
    energies = [(head(letters[name]), write(form)) for name, form in (("K", page.K), ("P", page.P))]
    sections.append({"title": "Energies", "text": "", "body": "\n".join(definitions(energies))})
    return render(
        "latex/equations.tex.jinja",
        {
            "title": in_latex(page.scene.name),
            "comment": page.scene.name,
            "sections": sections,
            "symbols": symbols,
            "values": any(row["value"] for row in symbols),
        },
    )


def latex_definitions(scene: Scene, named: Sequence[tuple[str, Form]]) -> str:
    """Return `name = formula` of base parameters as displays."""
    write = Latex(latex_symbols(scene), digits_or(DIGITS))
    return "\n".join(definitions([(base_parameter_name(name), write(form)) for name, form in named]))


def rate_sections(scene: Scene, write: Latex) -> list[dict[str, str]]:
    """Return the rates that are no velocities as the last section of a page, none where there are none."""
    rates = [(write.symbols[name], write(form)) for name, form in other_rates(scene)]
    title, _, text = _rates_said(scene)
    return [{"title": title, "text": text, "body": "\n".join(definitions(rates))}] if rates else []


def rate_lines(scene: Scene) -> list[str]:
    """Return the same as plain text."""
    rates = [equation_lines(name, broken_text(form)) for name, form in other_rates(scene)]
    title, text, _ = _rates_said(scene)
    return ["", f"# {title}: {text}", *rates] if rates else []


def _rates_said(scene: Scene) -> tuple[str, str, str]:
    """Return title and text of these rates, and the text of LaTeX."""
    if quaternions(scene):
        return "Rates", "of coordinates that are no velocities", "Coordinates that are no velocities have the rates:"
    held = "hat the state holds beside the motion"
    return "States", f"rates of w{held}", f"W{held} has rates too:"


def base_parameter_name(name: str) -> str:
    r"""Return \mathit{ZZ}_{R1} for ZZR1 and M_{R3} for MR3."""
    letter, joint = name.split("R")
    letter = letter if len(letter) == 1 else rf"\mathit{{{letter}}}"
    return rf"{letter}_{{R{joint}}}"


def _introduction(page: Printable, group: str) -> str:
    sums = r"\sum_j k_{z,ij}\,\ddot q_j + \sum_{j<k} k_{C,i,jk}\,\dot q_j\,\dot q_k + \sum_j k_{D,ij}\,\dot q_j^2"
    pulled = " + k_{E,i}" if elastic(page.scene) else ""
    closed = bool(page.constraints.rows)
    carried = r", and $\sum_k G_{ki} \lambda_k$ of loops and rows" if closed else ""
    text = (
        rf"Lagrange's equations, joint by joint: $\displaystyle {sums} + k_{{G,i}}{pulled}$ equals the drive and the "
        f"other forces of joint $i${carried}."
    )
    if group == "matrix":
        text = "Lagrange's equations: inertia, Coriolis and centrifugal forces, gravity{}{} and the drives.".format(
            ", springs" if elastic(page.scene) else "", ", loops" if closed else ""
        )
    if short := page.shorthands(page.writer().unbroken, page.K, page.P):
        text += f" Sines and cosines go by joint number: {', '.join(f'${one}$' for one in short)}."
    digits = digits_or(DIGITS)
    if any("." in page.writer()(c.form) for c in page.coefficients):
        text += f" Decimal numbers are rounded to {digits} digits."
    return text


def _displays(page: Printable, group: str, defined: Sequence[tuple[str, Form]]) -> list[str]:
    """Return the equations, the motions that are prescribed, and below them what names in them stand for."""
    write = page.writer()

    def lines(pairs: Sequence[tuple[str, Form]]) -> list[str]:
        return definitions([(write.symbols[name], write(form)) for name, form in pairs])

    displays = [*DISPLAYS[group](page, write), *lines(page.beside)]
    return [*displays, *([AND if WHERE in displays else WHERE, *lines(defined)] if defined else [])]


WHERE, AND = "where", "and"
"""What stands between equations and definitions."""


# Coefficients


def _definitions(some: Sequence[Coefficient], write: Latex) -> list[str]:
    names = (" = ".join(c.names) for c in some)
    return definitions([(name, write(c.form)) for name, c in zip(names, some, strict=True)])


# The four groupings


def _equations(page: Printable, write: Latex) -> list[str]:
    return equations([(write(page.left(i)) or "0", write(page.driving(i))) for i in range(len(page.rows))])


def _coefficients(page: Printable, write: Latex) -> list[str]:
    """Return the coefficients, and in one line those that vanish."""
    zero = [c.names[0] for some in page.vanishing for c in some]
    last = align([Line().broken("", f" = {BREAK}".join([*zero, "0"]))]) if zero else ()
    return [*_definitions(page.written, write), *last]


def _textbook(page: Printable, write: Latex) -> list[str]:
    """Return drive = k_z1 q̈_1 + …, every coefficient written above its name, as (5.40); long ones below."""
    named: set[tuple[str, tuple[int, ...]]] = set()
    pairs = []
    for i, row in enumerate(page.rows):
        text = ""
        for c in row:
            if c.vanishes:
                continue
            sign, shown = write.underbraced(c.form, c.names[0], BRACED)
            if shown == c.names[0]:
                named.add((c.kind, min(c.places)))
            rate = rf"\, {write.unbroken(c.rate)}" if c.of else ""
            text += (f" {BREAK}{sign} " if text else "-" if sign == "-" else "") + shown + rate
        pairs.append((write(page.driving(i)), text or "0"))
    displays = definitions(pairs)
    if named:
        displays += [WHERE, *_definitions([c for c in page.written if (c.kind, c.indices) in named], write)]
    return displays


def _matrix(page: Printable, write: Latex) -> list[str]:
    """Return M(q) q̈ + c + g = τ, with the entries in place if they fit, else named and written below."""
    n = range(len(page.rows))
    M = [[c.form for c in page.inertia(i)] for i in n]
    acceleration = [write.symbols[acceleration_name(u)] for u in page.scene.velocities]
    columns = [
        BMatrix([[write.unbroken(form) for form in row] for row in M]),
        BMatrix([[x] for x in acceleration]),
        BMatrix([[write.unbroken(page.coriolis(i))] for i in n]),
        BMatrix([[write.unbroken(page.gravity(i))] for i in n]),
        BMatrix([[write.unbroken(right)] for right in page.right]),
    ]
    closed = bool(page.constraints.rows)
    if columns[0].width + 40 < LINE and not closed:
        first, q, c, g, tau = columns
        parts = [f"{first} {q}", f"+ {c}", f"+ {g}", f"= {tau}"]
        if all(column.width + 60 < LINE for column in columns):
            text = BREAK.join(part + " " for part in parts)
            widths = iter([columns[0].width + 30, *(x.width + 30 for x in columns[2:])])
            lines = break_lines(text, LINE, LINE - INDENT, lambda _: next(widths))
            return list(align([[f"& {lines[0]}", *(rf"&\quad {{}}{line}" for line in lines[1:])]]))
    carried = r" + G(q)^{\mathsf T} \lambda" if closed else ""
    law, right = r"M(q)\,\ddot q + c(q, \dot q) + g(q) = ", rf"\tau = {columns[4]}"
    room = LINE - latex_width(rf"{law} \tau{carried}, \qquad \tau = ") - 30
    short = columns[4].width < room
    force = r"\tau" if short else head(Letters(page.scene)["Q"])
    said = [rf"& {law}{force}{carried}" + (rf", \qquad {right}" if short else "")]
    upper = [(i, j) for i in n for j in n if i <= j]
    entries = [(_mirrored(i, j), write(M[i][j])) for i, j in upper if M[i][j].terms]
    entries += [(entry_name("c", i), write(page.coriolis(i))) for i in n]
    entries += [(entry_name("g", i), write(page.gravity(i))) for i in n]
    entries += [] if short else [(entry_name(force, i), write(form)) for i, form in enumerate(page.right)]
    zero = [_mirrored(i, j) for i, j in upper if i < j and not M[i][j].terms]
    if zero:
        entries.append(("", f" = {BREAK}".join([*zero, "0"])))
    return [*align([said]), *definitions(entries)]


def _mirrored(i: int, j: int) -> str:
    name = entry_name("M", i, j)
    return name if i == j else f"{name} = {entry_name('M', j, i)}"


DISPLAYS = {"equations": _equations, "coefficients": _coefficients, "textbook": _textbook, "matrix": _matrix}


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
        blocks = {"Positions": found.positions(), "Velocities": found.rates(), "Accelerations": found.accelerations()}
        for name, forms in blocks.items():
            if forms:
                lines += [f"{name}:", *align([Line().broken("", write(form), "= 0") for form in forms])]
    return "\n".join(lines)


def _entries(printed_constraints: PrintedConstraints, write: Latex) -> list[str]:
    """Return the laws with names, and below the entries: G as a matrix where it fits."""
    laws = [r"G\,\dot q = 0,", r"G\,\ddot q + \dot G\,\dot q = 0"]
    laws = [*(["r(q) = 0,"] if printed_constraints.positions() else []), *laws]
    lines = list(align([["& " + r" \qquad ".join(laws)]]))
    pairs = [
        (entry_name("r", k), write(row.residual))
        for k, row in enumerate(printed_constraints.rows)
        if row.residual is not None
    ]
    entries = BMatrix([[write.unbroken(form) for form in row.G] for row in printed_constraints.rows])
    whole = entries.width + latex_width("G = ") + 30 < LINE
    if whole:
        pairs.append(("G", str(entries)))
    for k, row in enumerate(printed_constraints.rows):
        if not whole:
            pairs += [(entry_name("G", k, i), write(form)) for i, form in enumerate(row.G)]
        if row.bias is not None:
            pairs.append((entry_name(RATE, k), write(row.bias)))
    return [*lines, *definitions(pairs)]


WIDTH = 110
TEXT_INDENT = "    "


def text_page(page: Printable, group: str) -> str:
    """Return the equations in plain text; indices from 1."""
    motions = (equation_lines(name, broken_text(form)) for name, form in page.beside)
    lengths = length_lines(page.lengths, dict(page.definitions))
    short = (f"# {one}" for one in page.shorthands(text_of))
    return "\n".join([*PARAGRAPHS[group](page), *motions, *lengths, *_constraints(page, group), *short])


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
    return f"{shown}\n{TEXT_INDENT}{_lines(f'= {right}', WIDTH - len(TEXT_INDENT))}"


def _lines(text: str, first: int) -> str:
    return f"\n{TEXT_INDENT}".join(break_lines(text, first, WIDTH - len(TEXT_INDENT), len))


def _text_equations(page: Printable) -> Iterator[str]:
    for i in range(len(page.rows)):
        yield equation_lines(broken_text(page.left(i)), broken_text(page.driving(i)))


def _text_textbook(page: Printable) -> Iterator[str]:
    for i, row in enumerate(page.rows):
        names = [(coefficient_name(c.kind, c.indices), c) for c in row if not c.vanishes]
        terms = (f"{name}*{text_of(c.rate)}" if c.of else name for name, c in names)
        yield equation_lines(broken_text(page.driving(i)), f" {BREAK}+ ".join(terms) or "0")
    yield ""
    yield from _text_coefficients(page)


def _text_matrix(page: Printable) -> Iterator[str]:
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


def _text_coefficients(page: Printable) -> Iterator[str]:
    for c in page.written:
        yield equation_lines(" = ".join(coefficient_name(c.kind, place) for place in c.places), broken_text(c.form))
    for zero in page.vanishing:
        yield _zero_line([coefficient_name(c.kind, c.indices) for c in zero])


def _zero_line(names: list[str]) -> str:
    lines, line = [], ""
    for name in [*names, "0"]:
        if len(line) + len(name) > WIDTH:
            lines.append(line.rstrip())
            line = TEXT_INDENT
        line += f"{name} = " if name != "0" else "0"
    return "\n".join([*lines, line])


PARAGRAPHS = {
    "equations": _text_equations,
    "coefficients": _text_coefficients,
    "textbook": _text_textbook,
    "matrix": _text_matrix,
}

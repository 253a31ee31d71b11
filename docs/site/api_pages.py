"""A page for each object of the API reference, a table for each group, and `llms.txt`, the same list as plain text.

Pages are made by autosummary from what `api_catalogue` reads in the fronts; they lie in docs/api, which Git ignores.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from api_catalogue import CONSTRUCTED, catalogue, examples, first_line, members, object_of
from docutils import nodes
from docutils.statemachine import StringList
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.ext.autosummary import Autosummary
from sphinx.ext.autosummary.generate import generate_autosummary_docs

FOLDER = "api"
AFTER_NAPOLEON = 600
ARRAY = re.compile(r"~?(?:numpy\.)?ndarray\[tuple\[[^\]]*\], ~?(?:numpy\.)?dtype\[[^\]]*\]\]")
CALL = re.compile(r"\b([A-Z]\w*)\((?:[^()]|\([^()]*\))*\)")


class Group(Autosummary):
    """The table of a group: `.. api-group:: Scenes`, each name with its first sentence, leading to its page."""

    required_arguments = 1
    final_argument_whitespace = True
    has_content = False

    def run(self) -> list[nodes.Node]:
        """Return the table and the hidden list of its pages."""
        names = catalogue()[self.arguments[0]]
        self.content = StringList(names, source=str(self.env.doc2path(self.env.docname)))
        self.options |= {"toctree": FOLDER, "nosignatures": True}
        return list(super().run())


def write_pages(app: Sphinx) -> None:
    """Write the page of every name, and take away those of names that are gone."""
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(exist_ok=True)
    wanted = {f"{name}.rst" for names in catalogue().values() for name in names}
    for page in folder.glob("*.rst"):
        if page.name not in wanted:
            page.unlink()
    listed = Path(app.doctreedir) / "names_of_the_api.rst"
    listed.parent.mkdir(parents=True, exist_ok=True)
    rows = [f"   {name}" for names in catalogue().values() for name in names]
    listed.write_text("\n".join([".. autosummary::", f"   :toctree: {folder}", "", *rows, ""]), encoding="utf-8")
    generate_autosummary_docs([str(listed)], app=app, overwrite=True)


def add_example(app: Sphinx, what: str, name: str, of: object, options: object, lines: list[str]) -> None:
    """Add to the text of what has no example the one that is kept for it."""
    if what in ("class", "function") and name in examples() and not any(">>>" in line for line in lines):
        lines += ["", ".. rubric:: Example", "", *examples()[name].splitlines(), ""]


def list_members(app: Sphinx, what: str, name: str, of: object, options: object, lines: list[str]) -> None:
    """Add to the text of a class a table of its methods and properties, a line each."""
    if what != "class" or not isinstance(of, type) or not of.__module__.startswith("symdyn."):
        return
    if names := list(members(of)):
        lines += ["", ".. rubric:: Methods and properties", "", ".. autosummary::", "   :nosignatures:", ""]
        lines += [f"   ~{name.rpartition('.')[2]}.{one}" for one in names]
        lines += [""]


def shorten(
    app: Sphinx, what: str, name: str, of: object, options: object, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Write defaults that are objects by their class alone, and arrays as such; results are not made by users."""
    if what == "class" and signature and isinstance(of, type) and of.__name__ not in CONSTRUCTED:
        return "", ""
    return tuple(ARRAY.sub("ndarray", CALL.sub(r"\1(...)", text)) if text else text for text in (signature, returns))


def find_public(app: Sphinx, env: BuildEnvironment, node: addnodes.pending_xref, inside: Any) -> nodes.Node | None:
    """Lead from the module where a class stands to the name by which it is listed."""
    if node.get("refdomain") != "py":
        return None
    listed = {
        f"{one.__module__}.{one.__qualname__}": name
        for names in catalogue().values()
        for name in names
        if (inspect.isclass(one := object_of(name)) or inspect.isfunction(one))
    }
    if (name := listed.get(node["reftarget"])) is None:
        return None
    domain = env.get_domain("py")
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", name, node, inside)


def write_llms(app: Sphinx, fault: Exception | None) -> None:
    """Write llms.txt: what it is, a line for each page and each name of the API, with their addresses in the site."""
    if fault or app.builder.format != "html":
        return
    text = "\n".join(llms(app.env, app.config.llms_about))
    (Path(app.outdir) / "llms.txt").write_text(text + "\n", encoding="utf-8")


def llms(env: BuildEnvironment, about: str) -> Sequence[str]:
    """Return the lines of llms.txt."""
    pages = sorted(name for name in env.found_docs if not name.startswith((f"{FOLDER}/", "index")))
    lines = ["# symdyn", "", f"> {about}", "", "## Pages", ""]
    lines += [f"- [{env.titles[name].astext()}]({name}.html){lead(env, name)}" for name in pages]
    for title, names in catalogue().items():
        lines += ["", f"## API: {title}", ""]
        for name in names:
            lines.append(f"- [{name}]({FOLDER}/{name}.html): {first_line(object_of(name))}")
            of = object_of(name)
            if inspect.isclass(of):
                lines += [f"  - `.{one}`: {first_line(member)}" for one, member in members(of).items()]
    return lines


def lead(env: BuildEnvironment, name: str) -> str:
    """Return the first sentence of a page, behind a colon."""
    first = next(iter(env.get_doctree(name).findall(nodes.paragraph)), None)
    sentence = re.split(r"(?<=[.!?])\s", first.astext().replace("\n", " "))[0] if first else ""
    return f": {sentence}" if sentence else ""


def setup(app: Sphinx) -> dict[str, bool]:
    """Make pages before they are looked for, tables while they are read, and llms.txt in the end."""
    app.add_config_value("llms_about", "", "env")
    app.add_directive("api-group", Group)
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", add_example, priority=AFTER_NAPOLEON)
    app.connect("autodoc-process-docstring", list_members, priority=AFTER_NAPOLEON)
    app.connect("autodoc-process-signature", shorten)
    app.connect("missing-reference", find_public)
    app.connect("build-finished", write_llms)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

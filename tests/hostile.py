"""Scenes of a stranger, and programs that open what we write of them. Each payload leaves a canary where it acts.

A harness opens one kind of file with its own program and returns what it saw of canaries, [] for nothing. It is shown
to see them by `unescaped`, which writes the same files with one escape taken away.
"""

from __future__ import annotations

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import cuda_on_host
import numpy
import pytest
from browser import pictured, window
from kernels import executed
from patience import HANG

ADDRESS = "http://127.0.0.1:9/canary"

PAYLOADS = {
    "docstring": '"""; open("canary", "w"); canary = """',
    "quotes": "'); open('canary', 'w'); ('",
    "triple": "''' + str(open('canary', 'w')) + '''",
    "raw": 'l"""); open("canary", "w"); (r"""',
    "escaped quote": '\\"""; open("canary", "w"); """',
    "backslash": "ends with a backslash \\",
    "comment of C": "*/ int canary = 1; /*",
    "comment of JavaScript": "*/ globalThis.canary = 1; /*",
    "line of C": "??/ // *??/ / int canary_line; /* \\",
    "pragma": '*/ _Pragma("GCC error canary") /*',
    "script": "</script><script>window.canary = 1</script>",
    "alert": "<script>alert('canary')</script>",
    "open comment": "<!--<script>",
    "image": f'<img src="{ADDRESS}" onerror="window.canary = 1">',
    "attribute": '" autofocus tabindex=1 onfocus="window.canary = 1" x="',
    "attribute in one quote": "' autofocus tabindex=1 onfocus='window.canary = 1' x='",
    "title": "</title></style><svg onload='window.canary = 1'>",
    "cell": "</td></tr></table><script>window.canary = 1</script>",
    "mathematics": "</math><mtext></mtext><script>window.canary = 1</script>",
    "link of Markdown": f"[canary]({ADDRESS})",
    "script of Markdown": "[canary](javascript:window.canary=1)",
    "image of Markdown": f"![canary]({ADDRESS}.png)",
    "mathematics of Markdown": rf"$\href{{{ADDRESS}}}{{x}}$ \(\href{{{ADDRESS}}}{{x}}\) \[\href{{{ADDRESS}}}{{x}}\] $$",
    "address of Markdown": f"<{ADDRESS}>",
    "bare address": f"{ADDRESS} www.canary.example canary@canary.example",
    "cells of Markdown": "a | b | c \\| d",
    "marks of Markdown": "**a** `b` ~~c~~ _d_ # e $f$ ![[g]] &copy;",
    "write18": r"\immediate\write18{touch canary}",
    "mathematics of TeX": r"$\immediate\write18{touch canary}$",
    "braces of TeX": r"}}\immediate\write18{touch canary}{{",
    "pipe of TeX": r"\input{|touch canary}",
    "file of TeX": r"\newwrite\x\immediate\openout\x=canary.txt ",
    "carets of TeX": "^^5cimmediate^^5cwrite18{touch canary}",
    "end of TeX": r"\end{longtable}\end{document} % & # ~ ^ _ {",
    "format": "{0.__class__.__mro__} {canary} {} %(canary)s %s {{ 7 * 7 }} {% raw %}",
    "TOML": '", value = 1 }, canary = { value = 2, text = "',
    "shell": "$(touch canary) `touch canary` ; touch canary",
    "docstring of Julia": '$(canary = 1) """\ncanary = 1'.replace("\n", "; "),
    "comment of Julia": "=# canary = 1 #=",
    "link of MATLAB": "<a href=\"matlab:fopen('canary', 'w')\">canary</a>",
    "Texinfo": "-*- texinfo -*- @include canary",
    "lines of MATLAB": "%{ %} ... %!test fopen('canary', 'w');",
    "fence of Markdown": "```rust {.canary}",
    "entities": "&lt;script&gt; &#60; &amp; ]]>",
    "letters": "длина 長さ é “q” ½ ∑ √ ẋ 😀 €",
}

NAME, SCENE = "stranger", """
name = "stranger"
gravity = [0, "-g", 0]
[parameters]
g = {{ unit = "m/s^2", positive = true }}
m = {{ unit = "kg", positive = true }}
l = {{ unit = "m", positive = true{latex} }}
{parameters}
[bodies.bob]
particles = [{{ mass = "m", at = [0, "-l", 0] }}]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
force = "{force}"
{signals}
"""  # fmt: skip


def quoted(text: str) -> str:
    """Return a TOML string, by rules of our own."""
    plain = re.sub(r'["\\\x00-\x1f\x7f-\x9f\u2028-\u202e]', lambda found: f"\\u{ord(found[0]):04x}", text)
    return f'"{plain}"'


UNIT = "Ω*m²·kg^2/(s**2 rad)"
"""With all signs that a unit may have."""


def scene_with(texts: dict[str, str], latex: str = "", units: bool = False) -> str:
    """Return a pendulum whose parameters, inputs and outputs have these descriptions, and one this LaTeX.

    `units` makes the texts units, too, which no reader takes.
    """
    said = [f"unit = {quoted(t if units else UNIT)}\ntext = {quoted(t)}" for t in texts.values()]
    signals = [f'[inputs.u{k}]\n{one}\n[outputs.y{k}]\nformula = "3*t"\n{one}' for k, one in enumerate(said)]
    force = f"2*({' + '.join(['0', *(f'u{k}' for k in range(len(said)))])})"
    rows = [f"p{k} = {{ {', '.join(one.splitlines())} }}" for k, one in enumerate(said)]
    return SCENE.format(
        latex=f", latex = {quoted(latex)}" if latex else "",
        parameters="\n".join(rows),
        force=force,
        signals="\n".join(signals),
    )


DOORS = {  # what writes files of a scene, by folder; {scene}, {folder} and {values}, of all parameters, are filled in
    "numpy": "generate {scene} -o {folder}",
    "c": "generate {scene} --target c --batch -o {folder}",
    "js": "generate {scene} --target js -o {folder}",
    "cpp": "generate {scene} --target cpp -o {folder}",
    "rust": "generate {scene} --target rust -o {folder}",
    "gpu": "generate {scene} --target gpu -o {folder}",
    "casadi": "generate {scene} --target casadi --external -o {folder}",
    "acados": "generate {scene} --target acados -o {folder}",
    "heyoka": "generate {scene} --target heyoka -o {folder}",
    "ufunc": "generate {scene} --target ufunc -o {folder}",
    "matlab": "generate {scene} --target matlab -o {folder}",
    "mex": "generate {scene} --target matlab --mex -o {folder}",
    "julia": "generate {scene} --target julia -o {folder}",
    "fmu": "generate {scene} --target fmu --bind {values} -o {folder}",
    "md": "walkthrough {scene} -o {folder}/l.md",
    "tex": "walkthrough {scene} -o {folder}/l.tex",
    "html": "walkthrough {scene} -o {folder}/l.html",
    "ipynb": "walkthrough {scene} -o {folder}/l.ipynb",
    "exercises": "walkthrough {scene} --exercises -o {folder}/l.html",
    "asked": "walkthrough {scene} --exercises --language sk -o {folder}/l.ipynb",
    "sliders": "walkthrough {scene} --format sliders -o {folder}/l.html",
    "dalembert": "walkthrough {scene} --formulation dalembert -o {folder}/l.html",
    "dalembert-tex": "walkthrough {scene} --formulation dalembert -o {folder}/l.tex",
    "svg": "draw {scene} --labels coordinates,bodies,joints,points -o {folder}/p.svg",
    "free": "draw {scene} --body bob -o {folder}/p.svg",
    "film": "simulate {scene} --until 0.1 --bind g=9,m=1,l=1 --animate {folder}/a.html",
    "toml": "convert {scene} {folder}/c.toml",
    "par": "convert {scene} --lossy {folder}/c.par",
    "urdf": "convert {scene} --lossy {folder}/c.urdf",
    "sdf": "convert {scene} --lossy {folder}/c.sdf",
}


def write(door: str, scene: Path, folder: Path) -> list[Path]:
    """Run the command of a door and return the files that it wrote."""
    from symdyn.cli import main
    from symdyn.scene import read

    folder.mkdir(parents=True, exist_ok=True)
    values = ",".join(f"{one.name}=1" for one in read(scene).parameters) if "{values}" in DOORS[door] else ""
    words = [word.format(scene=scene, folder=folder, values=values) for word in DOORS[door].split(" ")]
    assert main(words) == 0, words
    return sorted(path for path in folder.rglob("*") if path.is_file())


@contextmanager
def unescaped(name: str, instead: Any) -> Iterator[None]:
    """Let something stand in place of a function of `symdyn.emit.render`, or of a check at the door, everywhere."""
    from importlib import import_module

    from symdyn.emit import TARGETS

    render = import_module("symdyn.emit.render")

    def holders(value: Any) -> list[Any]:
        ours = [module for key, module in sys.modules.items() if key.startswith("symdyn")]
        return [module for module in ours if getattr(module, name, None) is value]

    every = [getattr(module, name, None) for key, module in list(sys.modules.items()) if key.startswith("symdyn")]
    original = next((one for one in every if callable(one)), None)
    assert original is not None, f"nothing is called {name}"
    for module in holders(original):
        setattr(module, name, instead)
    rows = {key: row for key, row in TARGETS.items() if row.comment is original}
    TARGETS.update({key: replace(row, comment=instead) for key, row in rows.items()})
    render._environment.cache_clear()
    try:
        yield
    finally:
        for module in holders(instead):  # with those that were imported meanwhile
            setattr(module, name, original)
        TARGETS.update(rows)
        render._environment.cache_clear()


# What opens files: each returns what it saw of canaries


def program(*names: str) -> str:
    """Return the path of a program; the test is skipped where there is none."""
    path = next((found for name in names if (found := shutil.which(name))), None)
    if path is None:
        pytest.skip(f"no {names[0]}")
    return path


def left_behind(folder: Path, before: set[str]) -> list[str]:
    """Return files with canaries in their names that have come into a folder."""
    return sorted(name for name in {*os.listdir(folder)} - before if "canary" in name)


def in_python(path: Path) -> list[str]:
    """Import a module where it lies, with NumPy alone."""
    before = {*os.listdir(path.parent)}
    code = f"import sys, runpy; sys.path[:] = [p for p in sys.path if 'symdyn' not in p]; runpy.run_path({path.name!r})"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], cwd=path.parent, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 or left_behind(path.parent, before), done.stderr
    return left_behind(path.parent, before)


def in_c(path: Path) -> list[str]:
    """Compile a file with every warning, and look for canaries among its symbols and in what the compiler says."""
    compiler, lister = program("gcc", "cc"), program("nm")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wcomment", "-Wtrigraphs", "-fopenmp-simd", "-c", "-o"]
    octave = [str(path.parent) for path in Path("/usr/include").glob("octave-*/octave/mex.h")]
    for headers in (sysconfig.get_paths()["include"], numpy.get_include(), *octave):
        flags = ["-isystem", headers, *flags]
    made = path.parent / f"{path.name}.o"
    done = subprocess.run(
        [compiler, *flags, made.name, path.name], cwd=path.parent, capture_output=True, text=True, check=False
    )
    if done.returncode:
        return [done.stderr]
    said = [done.stderr] if done.stderr else []
    return said + re.findall(r"(?<!\w)canary\w*", subprocess.check_output([lister, str(made)], text=True))


def in_cpp(path: Path) -> list[str]:
    """Compile a header with every warning, and look for canaries among the names and in what the compiler says."""
    command = [program("g++"), "-std=c++17", "-x", "c++", "-Wall", "-Wextra", "-S", "-o", "-", path.name]
    done = subprocess.run(command, cwd=path.parent, capture_output=True, text=True, check=False)
    return [done.stderr] if done.stderr else re.findall(r"(?<!\w)canary\w*", done.stdout)


def in_rust(path: Path) -> list[str]:
    """Compile a module, run examples of its comments, make its pages, and look for canaries among names and links."""
    before, folder = {*os.listdir(path.parent)}, path.parent / "pages"
    given = ["--edition=2021", "-Dwarnings", path.name]
    steps = [
        [
            program("rustc"),
            f"--crate-type={'bin' if path.stem == 'main' else 'lib'}",
            "--emit=llvm-ir",
            "-o",
            "-",
            *given,
        ],
        [program("rustdoc"), "--test", *given],
        [program("rustdoc"), "-o", folder.name, *given],
    ]
    done = [subprocess.run(one, cwd=path.parent, capture_output=True, text=True, check=False) for one in steps]
    pages = "".join(page.read_text(encoding="utf-8") for page in sorted(folder.rglob("*.html")))
    found = left_behind(path.parent, before) + re.findall(r"(?<!\w)canary\w*", done[0].stdout)
    found += [tag for tag in re.findall(r"<[a-z][^<>]*>", pages) if re.search(r'(href|src)="\w+:[^"]*canary', tag)]
    return found + [one.stderr or one.stdout for one in done if one.returncode or one.stderr]


def in_cuda(path: Path) -> list[str]:
    """Compile kernels of CUDA as C++, and look for canaries among the names and in what the compiler says."""
    whole = cuda_on_host.HEADER + path.read_text(encoding="utf-8")
    command = [
        program("g++"),
        "-x",
        "c++",
        "-Wall",
        "-Wextra",
        "-Wno-unused-function",
        "-Wcomment",
        "-S",
        "-o",
        "-",
        "-",
    ]
    done = subprocess.run(command, input=whole, cwd=path.parent, capture_output=True, text=True, check=False)
    return [done.stderr] if done.stderr else re.findall(r"(?<!\w)canary\w*", done.stdout)


def in_opencl(path: Path) -> list[str]:
    """Compile kernels of OpenCL, and look for canaries among the names and in what the compiler says."""
    flags = ["-x", "cl", "-cl-std=CL1.2", "-Xclang", "-finclude-default-header", "-Wall", "-Wextra", "-Wcomment"]
    command = [program("clang"), *flags, "-target", "spir64", "-emit-llvm", "-S", "-o", "-", path.name]
    done = subprocess.run(command, cwd=path.parent, capture_output=True, text=True, check=False)
    return [done.stderr] if done.stderr else re.findall(r"(?<!\w)canary\w*", done.stdout)


def in_node(path: Path) -> list[str]:
    """Run a script or import a module, and look for the variable that a canary sets."""
    load = f"await import({path.as_uri()!r})" if path.suffix == ".mjs" else f"require({str(path)!r})"
    code = f"(async () => {{ {load}; process.stdout.write(String(globalThis.canary)) }})()"
    done = subprocess.run([program("node"), "-e", code], capture_output=True, text=True, check=False)
    return [] if done.stdout == "undefined" else [done.stdout + done.stderr]


def in_octave(path: Path) -> list[str]:
    """Call a function of a package without arguments, test it, and show its help: plain text without a link."""
    before = {*os.listdir(path.parent.parent)}
    name = f"{path.parent.name[1:]}.{path.stem}"
    code = f"try, {name}(), catch fault, end; printf('%s', fault.identifier); " if path.stem != "Contents" else ""
    code += f"[text, format] = get_help_text('{path}'); printf('\\n%s\\n%s', format, text); test('{path}', 'quiet')"
    done = subprocess.run(
        [program("octave-cli"), "--quiet", "--norc", "--path", str(path.parent.parent), "--eval", code],
        cwd=path.parent.parent, capture_output=True, text=True, errors="replace", check=False,
    )  # fmt: skip
    fault, form, text = done.stdout.split("\n", 2)
    found = left_behind(path.parent.parent, before) + re.findall(r"<a\s[^>]*", text)
    found += [] if form == "plain text" else [f"{form}: {done.stderr}"]
    return found + ([] if fault in ("", f"{path.parent.name[1:]}:arguments") else [fault + done.stderr])


def in_julia(path: Path) -> list[str]:
    """Parse a module of Julia by a grammar of others, and return what is wrong, or is code, or is put into strings."""
    language = pytest.importorskip("tree_sitter").Language(pytest.importorskip("tree_sitter_julia").language())
    tree = importlib.import_module("tree_sitter").Parser(language).parse(path.read_bytes())
    found, nodes = [], [tree.root_node]
    while nodes:
        node = nodes.pop()
        wrong = node.type == "ERROR" or node.is_missing
        if wrong or (node.type == "identifier" and node.text == b"canary"):
            found.append(f"{node.type} {node.text[:60]!r}")
        nodes += node.children
    return found


def in_browser(browser: Any, path: Path) -> list[str]:
    """Open a page or picture; a canary sets a variable, opens a dialog, fetches, or is a link that leads away."""
    page, seen = window(browser, viewport={"width": 1000, "height": 800}), []
    page.on("dialog", lambda dialog: (seen.append(f"dialog {dialog.message}"), dialog.dismiss()))
    page.on("console", lambda message: seen.append(f"console {message.text}"))
    page.on("pageerror", lambda fault: seen.append(f"error {fault}"))
    page.on("request", lambda asked: seen.append(asked.url) if asked.url != path.as_uri() else None)
    page.goto(path.as_uri())
    page.evaluate("document.querySelectorAll('[tabindex]').forEach(one => one.focus())")
    pictured(page)
    if page.evaluate("window.canary !== undefined"):
        seen.append("variable")
    away = "[...document.querySelectorAll('[href], [src]')].map(x => x.getAttribute('href') || x.getAttribute('src'))"
    seen += [found for found in page.evaluate(away) if not found.startswith("#")]
    page.context.close()
    return seen


def in_pdflatex(path: Path, shell: bool = True) -> list[str]:
    """Typeset a document, with the shell open; a canary is a file that is none of TeX's own, or a complaint of TeX."""
    folder = path.parent / f"{path.stem}-{shell}"
    folder.mkdir()
    shutil.copy(path, folder / path.name)
    open_shell = ["-shell-escape"] if shell else []
    done = subprocess.run(
        [program("pdflatex"), "-interaction=nonstopmode", *open_shell, path.name],
        cwd=folder, capture_output=True, text=True, errors="replace", check=False, timeout=HANG,
    )  # fmt: skip
    own = {path.name, *(f"{path.stem}.{ending}" for ending in ("aux", "log", "pdf", "out"))}
    wrong = re.findall(r"^! .*", done.stdout, re.MULTILINE)
    return sorted({*os.listdir(folder)} - own) + wrong


def in_markdown(text: str) -> list[str]:
    """Read Markdown with HTML and tables on, and return every link, image and element that is not of ours."""
    reader = importlib.import_module("markdown_it").MarkdownIt("commonmark", {"html": True}).enable(["table"])
    own = re.compile(r"</?(details|summary|span)>.*", re.DOTALL)
    every = [token for block in reader.parse(text) for token in (block, *(block.children or ()))]
    found = [token.content for token in every if token.type.startswith("html") and not own.match(token.content)]
    for token in every:
        where = token.attrs.get("href") or token.attrs.get("src")
        if where is not None and not re.fullmatch(r"(attachment:)?[\w-]+\.svg", str(where)):
            found.append(str(where))
    mathematics = r"(?s:\$\$.*?\$\$)|\$[^$\n]+\$|\\\\\(.*?\\\\\)|\\\\\[.*?\\\\\]"  # as notebooks find it
    formulas = re.findall(mathematics, text)
    found += [formula for formula in formulas if "canary" in formula]
    linked = re.compile(r"(?<![\w/\\])(https?:|www\.|ftp:|mailto:)|(?<!\\)@\w")  # what GitHub makes links of
    return found + linked.findall(re.sub(r"\$[^$]*\$|```.*?```", "", text, flags=re.DOTALL))


def in_notebook(path: Path) -> list[str]:
    """Execute a notebook's cells one by one, and read its Markdown."""
    book = json.loads(path.read_text(encoding="utf-8"))
    importlib.import_module("nbformat").validate(book)
    prose = [cell["source"] for cell in book["cells"] if cell["cell_type"] == "markdown"]
    code = "\n".join(cell["source"] for cell in book["cells"] if cell["cell_type"] == "code")
    before = {*os.listdir(path.parent)}
    done = subprocess.run(
        [sys.executable, "-"], input=code, cwd=path.parent, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    )  # fmt: skip
    fault = [done.stderr.splitlines()[-1]] if done.returncode else []
    return left_behind(path.parent, before) + fault + [x for text in prose for x in in_markdown(text)]


def in_xml(path: Path) -> list[str]:
    """Parse a picture or a robot; what it holds is ours: no script, no event, no link."""
    found = []
    for element in ElementTree.parse(path).iter():
        tag = element.tag.rpartition("}")[2]
        found += [tag] if tag in ("script", "a", "image", "foreignObject", "use") else []
        found += [key for key in element.attrib if key.startswith("on") or key.endswith("href")]
    return found


def in_fmu(path: Path) -> list[str]:
    """Parse an FMU's descriptions, which hold elements and attributes of the standard, and compile its sources."""
    folder = path.parent / path.stem
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    known = re.compile(r"[A-Z][A-Za-z0-9]+|fmi[A-Za-z]+")
    attribute = re.compile(r"[a-z]+([A-Z][A-Za-z]*)*|K|A")
    found = [seen for file in sorted((folder / "sources").glob("fmi?-functions.c")) for seen in in_c(file)]
    for file in sorted(folder.rglob("*.xml")):
        try:
            elements = [*ElementTree.parse(file).iter()]
        except ElementTree.ParseError as fault:
            return [*found, str(fault)]
        found += [one.tag for one in elements if not known.fullmatch(one.tag) or "canary" in one.tag]
        names = [name for one in elements for name in one.attrib]
        found += [name for name in names if not attribute.fullmatch(name) or name.startswith("on")]
    return found


def in_jupyter(path: Path) -> list[str]:
    """Execute a notebook as Jupyter does, and look for files that it leaves and cells that fail."""
    nbformat = pytest.importorskip("nbformat")
    before = {*os.listdir(path.parent)}
    book = nbformat.read(path, as_version=4)
    paths = os.pathsep.join(part for part in sys.path if part)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", paths)
        where = {"metadata": {"path": str(path.parent)}}
        executed(book, resources=where, allow_errors=True)
    outputs = [output for cell in book.cells for output in cell.get("outputs", ())]
    return left_behind(path.parent, before) + [x["evalue"] for x in outputs if x["output_type"] == "error"]

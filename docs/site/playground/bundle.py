"""The playground as a folder that any server of files can offer: `python docs/site/playground/bundle.py FOLDER`.

Python itself comes from npm (Pyodide), python-flint and what is pure Python from the package index, each by a lock with
hashes. symdyn's own files are taken as they are; a small stand-in for NumPy stands beside them, in the bundle alone.
Archives are the same bytes each time, carry a hash in their name, and are listed with it in `manifest.json`, by which
the page checks what it loads. Answers about the first example are made beforehand, so that it is shown while all else
is still on its way.
"""

from __future__ import annotations

import ast
import gzip
import hashlib
import io
import json
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
ROOT = HERE.parent.parent.parent
PAGE = ROOT / "templates" / "playground"

PLATFORMS = ("pyemscripten_2026_0_wasm32", "manylinux_2_28_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64")
PYODIDE = ("pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json")

FLINT = (
    *("pyflint", "flint_base/flint_base", "flint_base/flint_context", "types/dirichlet"),
    *(f"types/{one}" for one in ("arf", "arb", "arb_poly", "arb_mat", "acb", "acb_poly", "acb_mat", "acb_theta")),
    *(f"types/fmpz{one}" for one in ("", "_vec", "_poly", "_mat", "_mpoly")),
    *(f"types/fmpq{one}" for one in ("", "_vec", "_poly", "_mat", "_mpoly")),
)
"""Extension modules of python-flint that symdyn takes, and those that they take."""

LAZY = '''"""Names of python-flint, each from its module when it is asked for."""
_PLACES = {places}


def __getattr__(name):
    from importlib import import_module

    if name not in _PLACES:
        raise AttributeError(name)
    module, there = _PLACES[name]
    import_module("flint.flint_base.flint_base")  # before fmpz, each of which takes the other
    return getattr(import_module("flint." + module), there)
'''

FIRST = "two_link"
"""The example that the page begins with."""

READ = ("symdyn/emit/targets/player.py", "symdyn/shell.py")
"""Modules that are read as texts, or looked for by name."""

IDLE = (
    *(
        "_pyio",
        "_pyrepl",
        "_sysconfigdata.*",
        "bdb",
        "compileall",
        "cProfile",
        "ctypes",
        "doctest",
        "ftplib",
        "imaplib",
    ),
    *("mailbox", "modulefinder", "multiprocessing", "optparse", "pdb", "pickletools", "poplib", "profile", "pstats"),
    *("pydoc", "smtplib", "sqlite3", "trace", "tracemalloc", "unittest", "wsgiref", "xmlrpc", "encodings/cp(?!437).*"),
    *("encodings/iso.*", "encodings/koi.*", "encodings/mac.*", "encodings/.*_codec"),
)
"""Modules of Python's own library that no question reaches without SciPy; those with it are a part of their own."""

APART = (
    *("symdyn/bench/", "symdyn/cli/", "symdyn/identification/", "symdyn/study/", "symdyn/transcription/"),
    *(f"symdyn/templates/{one}/" for one in ("bench", "ensemble", "gauss", "identify", "playground", "plot")),
)
"""Folders that no question reaches."""

NUMERICAL = ("numpy", "scipy")
"""Packages of Pyodide's distribution that the page loads when it is asked to, with what they depend on."""

POLICY = {
    "script-src 'self'": "script-src 'self' 'wasm-unsafe-eval'",
    "connect-src 'self'": "connect-src 'self' {numerical}; worker-src 'self'; manifest-src 'self'",
}
"""What the page's policy allows more where Python runs in it: of what is elsewhere those files alone."""


def packages(folder: Path) -> dict[str, bytes]:
    """Return the files of packages of Python, by path, and put those of npm into a folder."""
    shutil.copy(HERE / "package.json", folder)
    shutil.copy(HERE / "package-lock.json", folder)
    command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent"]
    subprocess.run(command, cwd=folder, check=True)
    where = [word for one in PLATFORMS for word in ("--platform", one)]
    command = [
        sys.executable,
        "-m",
        "pip",
        "download",
        "--quiet",
        "--no-deps",
        "--require-hashes",
        "--only-binary=:all:",
    ]
    command += [*where, "--python-version", "314", "--implementation", "cp", "--abi", "cp314"]
    subprocess.run([*command, "-r", str(HERE / "requirements.txt"), "-d", str(folder / "wheels")], check=True)
    found: dict[str, bytes] = {}
    for wheel in sorted((folder / "wheels").iterdir()):
        with zipfile.ZipFile(wheel) as archive:
            found |= {name: archive.read(name) for name in archive.namelist() if _taken(name)}
    found["flint/__init__.py"] = _lazy(found["flint/__init__.py"].decode()).encode()
    return found


def _taken(name: str) -> bool:
    """Tell whether a file of a wheel is needed: what is imported, and what tells a version."""
    if name.startswith("flint/") and not name.endswith(".py"):
        return any(name.startswith(f"flint/{one}.cp") for one in FLINT)
    if ".dist-info/" in name:
        return name.endswith("METADATA")
    return not re.search(r"/tests?/|^packaging/|linux-gnu\.so|\.(pyi|typed|c)$|/$", name)


def _lazy(source: str) -> str:
    """Return the module that loads a name's extension when the name is asked for, of one that loads all."""
    places: dict[str, tuple[str | None, str]] = {}
    for node in ast.parse(source).body:
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            places |= {one.asname or one.name: (node.module, one.name) for one in node.names}
    return LAZY.format(places=repr(places))


def own() -> dict[str, bytes]:
    """Return the files of symdyn as an installed package has them."""
    found = {}
    for folder, place in (
        (ROOT / "symdyn", "symdyn"),
        (ROOT / "templates", "symdyn/templates"),
        (ROOT / "examples", "symdyn/examples"),
    ):
        for path in folder.rglob("*"):
            name = f"{place}/{path.relative_to(folder).as_posix()}"
            if path.is_file() and not name.startswith(APART) and "__pycache__" not in name and path.suffix != ".typed":
                found[name] = path.read_bytes()
    for path in (HERE / "standin").rglob("*.py"):
        found[path.relative_to(HERE).as_posix()] = path.read_bytes()
    return found


def numerical(lock: bytes) -> dict[str, Any]:
    """Return where Pyodide's distribution has NumPy and SciPy, and the hashes of its files, as its lock says them."""
    version = json.loads((HERE / "package.json").read_text())["dependencies"]["pyodide"]
    known = json.loads(lock)["packages"]
    wanted = list(NUMERICAL)
    for name in wanted:
        wanted += [one for one in known[name]["depends"] if one not in wanted]
    files = {known[name]["file_name"]: known[name]["sha256"] for name in wanted}
    return {"from": f"https://cdn.jsdelivr.net/pyodide/v{version}/full/", "sha256": files}


Files = dict[str, bytes]


def compiled(every: Mapping[str, bytes], aside: Path) -> tuple[Files, Files, Files, set[str]]:
    """Return packages, what is loaded of Python's own library and what SciPy takes of it, by path, compiled.

    Last, what the first equations load. Who compiles is the Python of the page, which reads no other's modules. The
    rest of its library is with packages.
    """
    given, written = aside / "given.zip", aside / "written.zip"
    given.write_bytes(zipped(every))
    command = ["node", HERE / "compiled.mjs", aside / "node_modules" / "pyodide", HERE / "questions.py", given, written]
    subprocess.run(command, check=True)
    found: dict[str, bytes] = {name: text for name, text in every.items() if not name.endswith(".py") or name in READ}
    own = dict[str, bytes]()
    with zipfile.ZipFile(written) as out:
        loaded = json.loads(out.read("loaded.json"))
        for name in out.namelist():
            if name.startswith("packages/"):
                found[name.removeprefix("packages/")] = out.read(name)
            elif name.startswith("lib/"):
                own[name.split("/", 2)[2]] = out.read(name)
    kept = {name.split(".")[0] for name in loaded["names"]}  # a package is in one place
    pattern = rf"({'|'.join(IDLE)})[/.]"
    idle = {name: own.pop(name) for name in tuple(own) if re.match(pattern, name)}
    apart = [name for name in own if name.split("/")[0].removesuffix(".pyc") not in kept]
    found |= {name: own.pop(name) for name in apart}
    return found, own, idle, {f"{name}c".removeprefix("/packages/") for name in loaded["files"]}


def zipped(files: Mapping[str, bytes]) -> bytes:
    """Return files as a zip, the same bytes each time."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as out:
        for name in sorted(files):
            out.writestr(zipfile.ZipInfo(name), files[name], zipfile.ZIP_DEFLATED, 9)
    return packed.getvalue()


def archive(files: Mapping[str, bytes]) -> bytes:
    """Return files as a compressed tar, the same bytes each time."""
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for name in sorted(files):
            info = tarfile.TarInfo(name)
            info.size = len(files[name])
            tar.addfile(info, io.BytesIO(files[name]))
    return gzip.compress(packed.getvalue(), 9, mtime=0)


def beforehand() -> dict[str, object]:
    """Return answers by their questions: what needs no scene, all examples, and all about the first of them."""
    from symdyn.playground import answer

    begin = answer("begin", "", {})
    found: dict[str, object] = {question("begin", "", {}): begin}
    for name in begin["examples"]:
        found[question("example", "", {"name": name})] = answer("example", "", {"name": name})
    text = answer("example", "", {"name": FIRST})["text"]
    asked: list[tuple[str, dict[str, object]]] = [
        ("scene", {}),
        ("equations", {}),
        ("coefficients", {}),
        ("picture", {"pulled": {}}),
        ("code", {"target": "numpy"}),
    ]
    for what, how in asked:
        found[question(what, text, how)] = answer(what, text, how)
    for language in ("en", "sk"):
        found[question("lesson", text, {"language": language})] = answer("lesson", text, {"language": language})
    return found


def question(what: str, text: str, how: Mapping[str, object]) -> str:
    """Return a question as the page writes it."""
    return json.dumps([what, text, how], separators=(",", ":"), ensure_ascii=False)


def bundle(place: Path) -> None:
    """Write the playground into an empty folder."""
    place.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as aside:
        every, library, idle, first = compiled(packages(Path(aside)) | own(), Path(aside))
        contents: dict[str, bytes] = {
            f"pyodide/{name}": (Path(aside) / "node_modules" / "pyodide" / name).read_bytes() for name in PYODIDE
        }
    contents["pyodide/python_stdlib.zip"] = zipped(library)
    small = {name: text for name, text in every.items() if not name.startswith(("flint/", "python_flint"))}
    parts = {
        "flint": {name: text for name, text in every.items() if name not in small},
        "first": {name: text for name, text in small.items() if _is_first(name, first)},
    }
    parts["rest"] = {name: text for name, text in small.items() if name not in parts["first"]}
    parts["library"] = {name: text for name, text in idle.items() if not name.startswith("encodings/")}
    archives = {name: archive(files) for name, files in parts.items()}
    archives["before"] = gzip.compress(json.dumps(beforehand(), ensure_ascii=False).encode(), 9, mtime=0)
    named = {name: f"{name}-{hashlib.sha256(text).hexdigest()[:16]}.gz" for name, text in archives.items()}
    contents |= {named[name]: text for name, text in archives.items()}
    contents |= {path.name: path.read_bytes() for path in PAGE.iterdir() if path.suffix in (".html", ".css", ".js")}
    contents |= {name: (HERE / name).read_bytes() for name in ("carrier.js", "worker.js", "offline.js")}
    large = numerical(contents["pyodide/pyodide-lock.json"])
    files = " ".join(f"{large['from']}{name}" for name in large["sha256"])
    page = contents["index.html"].decode()
    for narrow, wide in POLICY.items():
        assert page.count(narrow) == 1, narrow
        page = page.replace(narrow, wide.format(numerical=files))
    contents["index.html"] = page.encode()
    manifest = {
        "parts": named,
        "numerical": large,
        "sha256": {name: hashlib.sha256(contents[name]).hexdigest() for name in sorted(contents)},
    }
    contents["manifest.json"] = json.dumps(manifest, indent=1).encode()
    for name, text in contents.items():
        (place / name).parent.mkdir(exist_ok=True)
        (place / name).write_bytes(text)


def _is_first(name: str, first: Iterable[str]) -> bool:
    """Tell whether a file travels first: what is imported or read, lists of fronts, versions, the stand-in."""
    beside = ("symdyn/templates/c/names_of_headers.txt", "symdyn/templates/notebook/style.css")
    return name in (*first, *beside) or name.endswith((".pyi", "METADATA")) or name.startswith("standin/")


def main(place: Path) -> None:
    """Write the playground in place of the one before, and say how large it is."""
    shutil.rmtree(place, ignore_errors=True)
    bundle(place)
    for path in sorted(place.rglob("*")):
        if path.is_file():
            text = path.read_bytes()
            sent = len(text) if path.suffix in (".gz", ".zip") else len(gzip.compress(text, 9))
            print(f"{sent / 1e6:7.3f} MB  {path.relative_to(place)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

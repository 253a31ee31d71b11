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
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

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

USED = """
import json, sys
from symdyn.playground import answer
text = answer("example", "", {"name": sys.argv[1]})["text"]
for what in ("begin", "scene", "equations"):
    answer(what, text, {})
print(json.dumps([one.__file__ for name, one in sys.modules.items() if getattr(one, "__file__", None)]))
"""
"""Prints what is imported up to the first equations, which travels first."""

APART = (
    *("symdyn/bench/", "symdyn/cli/", "symdyn/study/", "symdyn/transcription/"),
    *(f"symdyn/templates/{one}/" for one in ("bench", "ensemble", "gauss", "identify", "playground", "plot")),
)
"""Folders that no question reaches."""

POLICY = {
    "script-src 'self'": "script-src 'self' 'wasm-unsafe-eval'",
    "connect-src 'self'": "connect-src 'self'; worker-src 'self'; manifest-src 'self'",
}
"""What the page's policy allows more where Python runs in it."""


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
    return "/test/" not in name and "linux-gnu.so" not in name and not name.endswith((".pyi", ".typed", "/", ".c"))


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
        found[path.relative_to(HERE / "standin").as_posix()] = path.read_bytes()
    return found


def used() -> set[str]:
    """Return the paths, below a folder of packages, of what the first equations import."""
    done = subprocess.run([sys.executable, "-c", USED, FIRST], check=True, capture_output=True, text=True, cwd=ROOT)
    found = set()
    for name in json.loads(done.stdout.splitlines()[-1]):
        path = Path(name)
        known = path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
        parts = known.parts
        found.add("/".join(parts[parts.index("site-packages") + 1 :] if "site-packages" in parts else parts))
    return found


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
        every = packages(Path(aside)) | own()
        contents: dict[str, bytes] = {
            f"pyodide/{name}": (Path(aside) / "node_modules" / "pyodide" / name).read_bytes() for name in PYODIDE
        }
    first = used()
    small = {name: text for name, text in every.items() if not name.startswith(("flint/", "python_flint"))}
    parts = {
        "flint": {name: text for name, text in every.items() if name not in small},
        "first": {name: text for name, text in small.items() if _is_first(name, first)},
    }
    parts["rest"] = {name: text for name, text in small.items() if name not in parts["first"]}
    archives = {name: archive(files) for name, files in parts.items()}
    archives["before"] = gzip.compress(json.dumps(beforehand(), ensure_ascii=False).encode(), 9, mtime=0)
    named = {name: f"{name}-{hashlib.sha256(text).hexdigest()[:16]}.gz" for name, text in archives.items()}
    contents |= {named[name]: text for name, text in archives.items()}
    contents |= {path.name: path.read_bytes() for path in PAGE.iterdir() if path.suffix in (".html", ".css", ".js")}
    contents |= {name: (HERE / name).read_bytes() for name in ("carrier.js", "worker.js", "offline.js")}
    page = contents["index.html"].decode()
    for narrow, wide in POLICY.items():
        assert page.count(narrow) == 1, narrow
        page = page.replace(narrow, wide)
    contents["index.html"] = page.encode()
    manifest = {
        "parts": named,
        "sha256": {name: hashlib.sha256(contents[name]).hexdigest() for name in sorted(contents)},
    }
    contents["manifest.json"] = json.dumps(manifest, indent=1).encode()
    for name, text in contents.items():
        (place / name).parent.mkdir(exist_ok=True)
        (place / name).write_bytes(text)


def _is_first(name: str, first: Iterable[str]) -> bool:
    """Tell whether a file travels first: what is imported or read, lists of fronts, versions, the stand-in."""
    beside = ("symdyn/templates/c/names_of_headers.txt", "symdyn/templates/notebook/style.css")
    return name in (*first, *beside) or name.endswith((".pyi", "METADATA")) or name.startswith(("numpy/", "scipy/"))


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

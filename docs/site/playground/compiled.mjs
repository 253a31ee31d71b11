// Packages compiled by the Python that the page runs: `node compiled.mjs PYODIDE QUESTIONS.py IN.zip OUT.zip`. Beside what is
// in IN.zip, OUT.zip has the modules of Python's own library, and what the questions load of all that.

import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [pyodide, questions, given, written] = process.argv.slice(2);
const { loadPyodide } = await import(pathToFileURL(`${pyodide}/pyodide.mjs`).href);
const python = await loadPyodide({ indexURL: `${pyodide}/` });
python.FS.writeFile("/given.zip", readFileSync(given));
python.runPython(`
import sys, zipfile
sys.path[:0] = "/packages", "/packages/standin"
zipfile.ZipFile("/given.zip").extractall("/packages")
`);
python.runPython(readFileSync(questions, "utf-8"));
python.runPython(`
names = [*sys.modules]
files = [one.__file__ for one in sys.modules.values() if getattr(one, "__file__", None)]

import ast, json
from importlib._bootstrap_external import _code_to_hash_pyc

OWN = f"/lib/python{sys.version_info[0]}{sys.version_info[1]}.zip"
SAYS = ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef

def compiled(text, path):
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, SAYS) and ast.get_docstring(node, False) is not None:
            node.body = node.body[1:] or [ast.Pass()]
    code = compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True, optimize=0)
    return _code_to_hash_pyc(plain(code), bytes(8), False)  # nothing looks at the source any more

def plain(code):  # without the lines of the source, a fifth of its bytes
    inside = tuple(plain(one) if isinstance(one, type(code)) else one for one in code.co_consts)
    return code.replace(co_linetable=b"", co_consts=inside)

with zipfile.ZipFile("/written.zip", "w") as out:
    for archive, root in (("/given.zip", "/packages"), (OWN, OWN)):
        with zipfile.ZipFile(archive) as read:
            for name in sorted(read.namelist()):
                if name.endswith(".py"):
                    path = f"{root}/{name}"
                    out.writestr(f"{path}c"[1:], compiled(read.read(name), path))
    out.writestr("loaded.json", json.dumps({"names": names, "files": files}))
`);
writeFileSync(written, python.FS.readFile("/written.zip"));

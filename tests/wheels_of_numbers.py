"""Wheels that stand for NumPy and SciPy of Pyodide's distribution, which no package index has.

They are the page's own stand-in in whole, with what a lesson of a pendulum asks beside it, in pure Python: enough to
see that files are checked, installed and asked, and by what name; not that NumPy's compiled code runs in a browser.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
VERSION = "0+tests"


def wheels(standin: Path, names: dict[str, str]) -> dict[str, bytes]:
    """Return wheels by their file names.

    Args:
        standin: the folder of the stand-in.
        names: their file names, by package.
    """
    found = {path.relative_to(standin).as_posix(): path.read_text() for path in standin.rglob("*.py")}
    found["numpy/__init__.py"] += "\nfrom numpy import more\n"
    found["scipy/__init__.py"] += f'__version__ = "{VERSION}"\n'
    found["numpy/more.py"] = (HERE / "data" / "numpy_more.py").read_text()
    found["numpy/polynomial/__init__.py"] = found["numpy/polynomial/chebyshev.py"] = ""
    found["scipy/integrate.py"] = (HERE / "data" / "scipy_integrate.py").read_text()
    return {names[one]: _wheel(one, {k: v for k, v in found.items() if k.startswith(f"{one}/")}) for one in names}


def _wheel(name: str, files: dict[str, str]) -> bytes:
    folder = f"{name}-{VERSION}.dist-info"
    files |= {
        f"{folder}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {VERSION}\n",
        f"{folder}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    files[f"{folder}/RECORD"] = "".join(f"{one},,\n" for one in files)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as out:
        for path, text in files.items():
            out.writestr(zipfile.ZipInfo(path), text)
    return packed.getvalue()


def sha256(text: bytes) -> str:
    """Return a hash as locks write it."""
    return hashlib.sha256(text).hexdigest()

"""NumPy and SciPy on request: files of Pyodide's distribution, checked by its lock, in the page with Python inside.

The distribution's server is not reached from a test. A server of this machine stands in its place, under its name, with
wheels that stand for NumPy and SciPy (`wheels_of_numbers`): the address, the policy, the hashes, Pyodide's installer
and the page are the real ones.
"""

from __future__ import annotations

import json
import ssl
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from browser import chromium, window
from patience import HANG
from programs import path_of
from site_page import BUILT, bundle, edited, served, turned, until
from wheels_of_numbers import VERSION, sha256, wheels

from symdyn.playground import answer

pytestmark = pytest.mark.playground

HOST = "cdn.jsdelivr.net"
SAID = "document.querySelector('#numerical span').textContent"
STARTED = "document.documentElement.dataset.python"
LEFT_OUT = "worked out in numbers, with Python and SciPy"

ASKED = """async ([text, language]) => {
  const { ask } = await import("./carrier.js");
  return ask("lesson", text, { language });
}"""


@contextmanager
def distribution(folder: Path, files: dict[str, bytes]) -> Iterator[tuple[int, list[str]]]:
    """Yield the port of a server in place of Pyodide's distribution, and what was asked of it; the rest is 404."""
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    command = [
        path_of("openssl"),
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-subj",
        f"/CN={HOST}",
    ]
    subprocess.run([*command, "-keyout", key, "-out", certificate], check=True, capture_output=True, timeout=HANG)
    asked: list[str] = []

    class Files(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            found = files.get(self.path.rpartition("/")[2])
            self.send_response(404 if found is None else 200)
            self.send_header("Access-Control-Allow-Origin", "*")
            self.send_header("Content-Length", str(len(found or b"")))
            self.end_headers()
            self.wfile.write(found or b"")

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Files)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificate, key)
    server.socket = context.wrap_socket(server.socket, server_side=True)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield server.server_address[1], asked
    server.shutdown()


def manifest() -> dict[str, Any]:
    """Return what the page was published with."""
    found: dict[str, Any] = json.loads((BUILT / "manifest.json").read_bytes())
    return found


def made() -> dict[str, bytes]:
    """Return wheels of tests under the names that the lock says."""
    names = {name.partition("-")[0]: name for name in manifest()["numerical"]["sha256"]}
    return wheels(bundle.HERE / "standin", names)


def published(files: dict[str, bytes]) -> dict[str, bytes]:
    """Return the manifest of a page whose lock says these files."""
    found = manifest()
    found["numerical"]["sha256"] = {name: sha256(text) for name, text in files.items()}
    return {"manifest.json": json.dumps(found).encode()}


@contextmanager
def opened(folder: Path, files: dict[str, bytes], instead: dict[str, bytes]) -> Iterator[tuple[Any, list[str]]]:
    """Yield the page with Python in it, and what is asked of the distribution."""
    with (
        served(instead) as (address, _),
        distribution(folder, files) as (port, asked),
        chromium(f"--host-resolver-rules=MAP {HOST} 127.0.0.1:{port}") as browser,
    ):
        page = window(browser, ignore_https_errors=True)
        page.goto(address)
        until(page, STARTED)
        yield page, asked


def test_what_is_loaded_is_what_the_lock_says() -> None:
    """Of Pyodide's release that the page runs, with what it depends on; the policy allows those files and no others."""
    lock = json.loads((BUILT / "pyodide" / "pyodide-lock.json").read_bytes())["packages"]
    version = json.loads((bundle.HERE / "package.json").read_text())["dependencies"]["pyodide"]
    found = manifest()["numerical"]

    assert found["from"] == f"https://{HOST}/pyodide/v{version}/full/"
    assert found["sha256"] == {lock[name]["file_name"]: lock[name]["sha256"] for name in ("numpy", "scipy")}
    assert {*lock["numpy"]["depends"], *lock["scipy"]["depends"]} == {"numpy"}
    policy = (BUILT / "index.html").read_text().partition("connect-src ")[2].partition(";")[0]
    assert policy.split() == ["'self'", *(found["from"] + name for name in found["sha256"])]


@pytest.mark.runs("chromium", "openssl")
def test_on_request_they_are_loaded_once_and_a_lesson_is_that_of_symdyn_play(tmp_path: Path) -> None:
    """Byte for byte, by the wheels that stand for them; before it, nothing is asked of the distribution."""
    text = answer("example", "", {"name": "pendulum"})["text"]
    files = made()
    with opened(tmp_path, files, published(files)) as (page, asked):
        assert "small NumPy" in page.evaluate(SAID)
        assert HOST in page.evaluate(SAID)
        edited(page, text)
        turned(page, "lesson")
        until(page, "document.querySelector('#by').textContent.includes('small NumPy')")
        small = page.evaluate(ASKED, [text, "en"])
        assert LEFT_OUT in small["page"]
        assert asked == []

        page.click("#load")
        until(page, f"{SAID}.includes('SciPy {VERSION}') || document.querySelector('#numerical.bad')")
        assert page.evaluate(SAID) == f"Python here has NumPy {VERSION} and SciPy {VERSION}."
        until(page, f"document.querySelector('#by').textContent.includes('NumPy {VERSION}')")
        assert [one.rpartition("/")[2] for one in asked] == [*files]
        assert not page.is_visible("#load")
        for language in ("en", "sk"):
            large = page.evaluate(ASKED, [text, language])
            assert large["by"] == "large"
            assert large["page"] == answer("lesson", text, {"language": language})["page"]
        lesson = page.frame_locator("#lesson iframe").locator("#step-equilibria")
        lesson.wait_for(state="attached")
        assert LEFT_OUT not in lesson.text_content()

        page.evaluate("import('./carrier.js').then(({ stop }) => stop())")  # the next worker has them, too
        edited(page, text.replace('"pendulum"', '"mine"'))
        until(page, "document.querySelector('#name').textContent === 'mine.toml'")
        assert LEFT_OUT not in page.evaluate(ASKED, [text, "en"])["page"]
        page.select_option("#language", "sk")
        until(page, f"{SAID}.includes('NumPy {VERSION} a SciPy {VERSION}')")
        assert len(asked) == len(files)

        other = f"fetch('https://{HOST}/npm/other.js').then(() => 'reached', fault => fault.name)"
        assert page.evaluate(other) == "TypeError"
        assert len(asked) == len(files)


@pytest.mark.runs("chromium", "openssl")
def test_a_file_that_is_not_the_published_one_is_thrown_away_in_words(tmp_path: Path) -> None:
    """The lock is Pyodide's own here; after it nothing has changed, and what comes right then is taken."""
    text = answer("example", "", {"name": "pendulum"})["text"]
    right = made()
    with opened(tmp_path, sent := {name: b"PK" + text for name, text in right.items()}, published(right)) as (
        page,
        asked,
    ):
        page.click("#load")
        until(page, f"{SAID}.includes('SHA-256')")
        assert page.evaluate(SAID).startswith("numpy-")
        assert len(asked) == 1
        edited(page, text)
        assert LEFT_OUT in page.evaluate(ASKED, [text, "en"])["page"]
        sent.update(right)
        page.click("#load")
        until(page, f"{SAID}.includes('NumPy {VERSION}')")


@pytest.mark.runs("chromium", "openssl")
def test_what_is_not_there_or_does_not_begin_is_told_and_the_page_goes_on(tmp_path: Path) -> None:
    """So is an answer that takes SciPy, which another carrier gives here."""
    text = answer("example", "", {"name": "pendulum"})["text"]
    broken = dict.fromkeys(made(), b"no archive")
    carrier, end = (BUILT / "carrier.js").read_text(), "  return { ...answer, by"
    assert carrier.count(end) == 1
    none = (
        f"""if (what === "coefficients") return {{ failed: "No module named 'scipy.sparse'", by: "small" }};\n{end}"""
    )
    instead = published(broken) | {"carrier.js": carrier.replace(end, none).encode()}
    with opened(tmp_path, sent := dict[str, bytes](), instead) as (page, asked):
        page.click("#load")
        until(page, f"{SAID}.includes('cannot be loaded')")  # 404
        assert len(asked) == 1
        page.context.set_offline(True)
        page.select_option("#language", "sk")
        page.click("#load")
        until(page, f"{SAID}.includes('sa nedá načítať')")
        page.context.set_offline(False)
        page.select_option("#language", "en")
        sent.update(broken)
        page.click("#load")
        until(page, f"{SAID}.includes('It goes on without')")
        until(page, STARTED)
        edited(page, text)
        assert LEFT_OUT in page.evaluate(ASKED, [text, "en"])["page"]
        assert "which the page can load" in page.text_content("#coefficients")


@pytest.mark.runs("chromium")
def test_the_page_says_that_python_is_on_its_way_until_it_is_there() -> None:
    """Its largest file is held back: what was made beforehand is shown without a word, what is written is not."""
    come = threading.Event()
    state = "document.querySelector('#state').textContent"
    with served(held={"flint-": come}) as (address, _), chromium() as browser:
        page = window(browser)
        page.goto(address)
        until(page, "document.body.dataset.shown", 50)
        assert page.locator("#equations math").count() > 3
        assert "Python" not in page.evaluate(state)
        page.fill("#text", page.input_value("#text").replace('"-h2"', '"-2*h2"'))
        until(page, f"{state}.includes('loading Python')")
        page.select_option("#language", "sk")
        until(page, f"{state}.includes('načítava sa Python')")
        assert not page.evaluate(STARTED)
        come.set()
        until(page, f"{state}.endsWith(' ms')")
        assert page.evaluate(STARTED) == "ready"
        assert "4" in page.text_content("#equations")


ALONE = """
import os, subprocess, sys, threading

folder, name = sys.argv[1:]
sys.path[:0] = [folder]
for one in ("_multiprocessing", "_posixshmem", "resource", "sympy", "rich", "heyoka"):
    sys.modules[one] = None

def none(*given, **named):
    raise OSError(138, "Function not implemented")

def unstarted(self):
    raise RuntimeError("can't start new thread")

subprocess.Popen.__init__, threading.Thread.start = none, unstarted
del os.fork
import json
from symdyn.playground import answer
import symdyn
assert symdyn.__file__.startswith(folder)
print(json.dumps(answer("lesson", answer("example", "", {"name": name})["text"], {"language": "en"})))
"""
"""A lesson by the bundle's files of symdyn, without modules, processes and threads that a page has not."""


@pytest.mark.runs
@pytest.mark.parametrize("name", ["pendulum", "four_bar", "cart_with_wheel", "governor"])
def test_with_numpy_and_scipy_the_files_of_the_page_make_the_lesson_of_symdyn_play(name: str, tmp_path: Path) -> None:
    for place, text in bundle.own().items():
        if place.startswith("symdyn/"):
            (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / place).write_bytes(text)
    command = [sys.executable, "-c", ALONE, str(tmp_path), name]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path, timeout=HANG)
    real = answer("lesson", answer("example", "", {"name": name})["text"], {"language": "en"})

    assert json.loads(done.stdout) == real
    assert LEFT_OUT not in real["page"]

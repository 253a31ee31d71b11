"""`symdyn draw SCENE --watch`, as somebody has it open who edits a scene; and as a stranger on the same machine."""

from __future__ import annotations

import http.client
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from browser import chromium, opened, window
from hostile import PAYLOADS, quoted
from patience import HANG

from symdyn.cli import main
from symdyn.draw import picture
from symdyn.scene import read_noting
from symdyn.watch import Watched
from symdyn.watch.server import MOST, Drawn
from symdyn.watch.watching import EditedFile

pytestmark = [pytest.mark.runs(), pytest.mark.long]

EXAMPLES = Path(__file__).parent.parent / "examples"
PUMA, SCARA = ((EXAMPLES / f"{name}.toml").read_text() for name in ("puma560", "scara"))


@contextmanager
def watched(path: Path, draw: Drawn = picture) -> Iterator[Watched]:  # type: ignore[assignment]
    def load() -> Any:
        found = read_noting(path)
        return found.scene, found.notes

    found = Watched(path, load, draw)
    try:
        yield found
    finally:
        found.close()


def asked(
    watched: Watched, path: str = "", method: str = "GET", body: bytes | None = None, **headers: str
) -> tuple[int, dict[str, str], bytes]:
    """Return status, headers and body of an answer; `_` in names of headers is "-"."""
    host, token = watched.address.removeprefix("http://").rstrip("/").split("/")
    address = path if path[:1] in ("/", "*", "h") else f"/{token}/{path}"
    server = http.client.HTTPConnection(host, timeout=HANG)
    server.putrequest(method, address, skip_host="Host" in headers)
    for name, value in headers.items():
        server.putheader(name.replace("_", "-"), value)
    if body is not None:
        server.putheader("Content-Length", str(len(body)))
    server.endheaders(body)
    answer = server.getresponse()
    found = answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()
    server.close()
    return found


@pytest.fixture
def arm(tmp_path: Path) -> Iterator[tuple[Watched, Path]]:
    path = tmp_path / "arm.toml"
    path.write_text(PUMA)
    with watched(path) as found:
        yield found, path


def test_only_who_has_the_address_is_answered(arm: tuple[Watched, Path]) -> None:
    found, _ = arm
    host, token = found.address.removeprefix("http://").rstrip("/").split("/")
    port = host.partition(":")[2]

    assert host.startswith("127.0.0.1:")
    assert len(token) >= 32
    status, headers, page = asked(found)
    assert status == 200
    assert headers["cache-control"] == "no-store"
    assert headers["referrer-policy"] == "no-referrer"
    assert "default-src 'none'" in headers["content-security-policy"]
    assert "unsafe" not in headers["content-security-policy"]
    assert "server" not in headers
    assert b"<script nonce=" in page
    for path in ("/", "/events", f"/{token[:-1]}/", f"/{token}x/", "/%c3%a9/", "*", "http://evil.example/"):
        assert asked(found, path)[0] == 403, path
    for name in (
        "localhost",
        f"localhost:{port}",
        f"evil.example:{port}",
        "127.0.0.1",
        f"127.0.0.1:{port}.evil.example",
    ):
        assert asked(found, Host=name)[0] == 403, name
    assert asked(found, "../../etc/passwd")[0] == 404
    assert asked(found, "nothing")[0] == 404
    assert asked(found, method="PUT")[0] == 501


def test_what_changes_something_must_come_from_the_page(arm: tuple[Watched, Path]) -> None:
    found, _ = arm
    own = {"Origin": found.address.rsplit("/", 2)[0], "Content_Type": "application/json"}
    good = json.dumps({"name": "q1", "value": 0.5}).encode()

    def pulled(body: bytes, **headers: str) -> int:
        return asked(found, "pull", "POST", body, **headers)[0]

    assert pulled(good, **own) == 200
    assert found._show.sheet.sliders[0].value == 0.5
    assert pulled(good, Content_Type="application/json") == 403
    assert pulled(good, **{**own, "Origin": "http://evil.example"}) == 403
    assert pulled(good, **{**own, "Origin": "null"}) == 403
    assert pulled(good, **{**own, "Content_Type": "text/plain"}) == 403
    assert pulled(b" " * 5000, **own) == 413
    for body in (b"", b"[", b"[" * 4000, b"[]", b"{}", b'{"back": 1}', b'{"name": 1, "value": 1}', b'{"name": "q1"}'):
        assert pulled(body, **own) == 400, body
    for value in ("NaN", "Infinity", "1e10", "true", '"1"', "1" * 3000):
        assert pulled(f'{{"name": "q1", "value": {value}}}'.encode(), **own) == 400, value
    assert pulled(b'{"name": "q9", "value": 1}', **own) == 200  # a page that is older than the file
    assert found._show.sheet.sliders[0].value == 0.5
    assert pulled(b'{"back": true}', **own) == 200
    assert found._show.sheet.sliders[0].value != 0.5


def test_pages_are_not_more_than_a_machine_can_bear(arm: tuple[Watched, Path]) -> None:
    found, _ = arm
    host, token = found.address.removeprefix("http://").rstrip("/").split("/")
    pages = [http.client.HTTPConnection(host, timeout=HANG) for _ in range(MOST + 1)]
    for page in pages:
        page.request("GET", f"/{token}/events")
    statuses = [page.getresponse().status for page in pages]
    for page in pages:
        page.close()

    assert sorted(statuses) == [200] * MOST + [503]


def test_loops_stay_closed_while_they_are_pulled_and_say_where_they_cannot(tmp_path: Path) -> None:
    with watched(EXAMPLES / "four_bar.toml") as found:
        show = found._show
        before = {one.name: one.value for one in show.sheet.sliders}
        name = next(iter(before))
        show.pull(name, before[name] + 0.2)
        after = {one.name: one.value for one in show.sheet.sliders}
        kept = show.sheet
        show.pull("chi", 6.0)
        standing, refused = show._standing, show.sheet

    assert after[name] == pytest.approx(before[name] + 0.2, abs=1e-9)
    assert all(after[other] != before[other] for other in after)
    assert standing is not None
    assert standing.numbers is not None
    assert abs(standing.numbers.residual(standing.q)).max() < 1e-9
    assert refused.notes[-1].startswith("the loops do not close with chi = ")
    assert (refused.picture, refused.sliders) == (kept.picture, kept.sliders)


def test_a_fault_of_ours_is_a_message_and_the_page_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(PUMA)
    broken: list[Exception] = []

    def draw(*given: Any) -> str:
        if broken:
            raise broken[-1]
        return picture(*given)

    with watched(path, draw) as found:
        good = found._show.sheet
        for fault in (TypeError("a\x1b[2J"), RecursionError("too deep"), MemoryError()):
            broken.append(fault)
            path.write_text(PUMA + f"# {type(fault).__name__}\n")
            found.look()
            time.sleep(0.11)  # s: then it has settled
            found.look()
            sheet = found._show.sheet
            assert len(sheet.faults) == 1
            assert sheet.faults[0].startswith(f"symdyn itself has failed ({type(fault).__name__}: ")
            assert "\x1b" not in sheet.faults[0]
            assert (sheet.picture, sheet.sliders) == (good.picture, good.sliders)
            found._pulled({"name": "q1", "value": 1.0})
            assert found._show.sheet.notes[-1].startswith("symdyn itself has failed (")
        broken.clear()
        path.write_text(PUMA)
        found.look()
        assert found._show.sheet == good


def test_a_file_says_something_else_or_not(tmp_path: Path) -> None:
    path, now = tmp_path / "scene.toml", [10.0]
    path.write_text("a")
    file = EditedFile(path, lambda: now[0])

    now[0] += 1
    assert not file.changed()
    path.write_text("b")
    assert file.changed()
    assert not file.settled
    assert not file.changed()
    now[0] += 1
    assert file.settled
    os.utime(path, (1, 1))  # touched, with the same words
    assert not file.changed()
    (tmp_path / "new").write_text("c")
    (tmp_path / "new").replace(path)  # as editors save
    assert file.changed()
    path.unlink()
    assert file.changed()
    assert not file.there
    assert not file.changed()
    path.write_text("c")
    assert file.changed()
    stamp = path.stat()
    path.write_text("d")
    os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))  # twice in one tick of the clock
    assert file.changed()


def until(found: Any, true: str, seconds: float = HANG) -> float:
    """Return after how many seconds an expression of the page is true."""
    begun = time.perf_counter()
    while not found.evaluate(true):  # the page's policy lets nobody wait inside it
        assert time.perf_counter() < begun + seconds, f"{true} did not come: {found.inner_text('body')[:2000]}"
        time.sleep(0.01)
    return time.perf_counter() - begun


@contextmanager
def running(path: Path, folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Yield the command and its address."""
    command = [sys.executable, "-m", "symdyn", "draw", path.name, "--watch"]
    environment = {**os.environ, "HOME": str(folder / "home"), "PYTHONDONTWRITEBYTECODE": "1"}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, cwd=path.parent, text=True, env=environment, **pipes)  # type: ignore[call-overload]
    try:
        yield process, process.stdout.readline().strip()
    finally:
        process.kill()
        process.wait()


SHOWN = "document.querySelector('#picture img')"


@pytest.mark.runs("chromium")
def test_an_edit_a_fault_and_its_repair_are_seen_as_the_file_is_saved(tmp_path: Path) -> None:
    (tmp_path / "home").mkdir()
    work = tmp_path / "work"
    work.mkdir()
    path = work / "arm.toml"
    path.write_text(SCARA)
    with chromium() as browser, running(path, tmp_path) as (process, address):
        assert address.startswith("http://127.0.0.1:")
        with opened(browser, address) as page:
            until(page, f"{SHOWN} && document.querySelectorAll('.slider').length === 4")
            assert page.text_content("#state") == "follows the file"
            until(page, "document.querySelector('#equations math')")

            first = page.get_attribute("#picture img", "src")  # an edit, saved by another name
            (work / "arm.toml~").write_text(SCARA.replace("0.325", "0.6"))
            (work / "arm.toml~").replace(path)
            until(page, f"{SHOWN}.src !== {json.dumps(first)}")
            second = page.get_attribute("#picture img", "src")

            path.write_text(SCARA.replace('"h"', '"h/"'))  # a fault
            until(page, "document.querySelectorAll('#faults li').length > 0")
            assert "joints.shoulder: origin" in page.text_content("#faults")
            assert page.get_attribute("#picture img", "src") == second
            assert page.text_content("#state") == "the last picture without a fault"

            path.write_text(SCARA)  # and its repair
            until(page, f"document.querySelectorAll('#faults li').length === 0 && {SHOWN}.src === {json.dumps(first)}")

            path.unlink()
            until(page, "document.querySelector('#faults').textContent.includes('is not there')")
            path.write_text(SCARA)
            until(page, "document.querySelectorAll('#faults li').length === 0")

            page.locator("#slider-q2").fill("1")
            until(page, f"{SHOWN}.src !== {json.dumps(first)}")
            assert float(page.locator(".slider output").nth(1).text_content().split()[0]) == pytest.approx(1, abs=0.01)
            page.click("#back")
            until(page, f"{SHOWN}.src === {json.dumps(first)}")
            page.goto("about:blank")
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=HANG) == 0
        said = process.stderr.read()
    assert said == "symdyn: open this address in a browser; Ctrl-C ends it\n"
    assert sorted(one.name for one in work.iterdir()) == ["arm.toml"]
    assert not [one for one in (tmp_path / "home").rglob("*") if one.is_file()]


@pytest.mark.slow
@pytest.mark.runs("chromium")
def test_text_of_a_stranger_stays_text(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(SCARA)
    with chromium() as browser, watched(path) as found:
        with opened(browser, found.address) as page:
            until(page, SHOWN)
            path.write_text(
                SCARA + "".join(f"[bodies.{quoted(text)}]\n[{quoted(text)}]\n" for text in PAYLOADS.values())
            )
            found.look()
            time.sleep(0.11)  # s: then it has settled
            found.look()
            told = found._show.sheet.faults
            until(page, f"document.querySelectorAll('#faults li').length === {len(told)}")
            assert page.locator("#faults li").all_text_contents() == list(told)
            assert "<script>window.canary = 1</script>" in "".join(told)
            assert page.evaluate("window.canary === undefined && document.querySelectorAll('script').length === 1")
        page = window(browser)  # and if something were not escaped
        page.goto(found.address)
        found._board.put("equations", '<img src="x" onerror="window.canary = 1"><b>here</b>')
        until(page, "document.querySelector('#equations b')")
        time.sleep(0.1)
        assert page.evaluate("window.canary === undefined")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["-", "--watch"], "--watch follows a file"),
        (["missing.toml", "--watch"], "missing.toml is none"),
        (["{}", "--watch", "-o", "x.svg"], "leave out -o"),
        (["{}", "--watch", "--body", "link1"], "leave out --body"),
        (["{}", "--watch", "--at", "q9"], "gives no coordinate a value"),
    ],
)
def test_what_cannot_be_watched_is_one_line(words: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["draw", *(word.format(EXAMPLES / "puma560.toml") for word in words)]) == 1
    assert told in capsys.readouterr().err

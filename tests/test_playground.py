"""`symdyn play`, as somebody has it open who writes a scene; and as a stranger on the same machine, or with a link."""

from __future__ import annotations

import http.client
import json
import os
import signal
import subprocess
import sys
import threading
import time
import zlib
from base64 import urlsafe_b64encode
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from browser import OVERLAPS, chromium, opened, window
from hostile import PAYLOADS, quoted
from patience import HANG

from symdyn.cli import main
from symdyn.emit import TARGETS
from symdyn.playground import Settings, answer
from symdyn.playground.answers import ANSWERS, LONGEST, words
from symdyn.playground.following import AnsweringProcess, EditedFile, Played
from symdyn.playground.server import MOST

pytestmark = [pytest.mark.runs(), pytest.mark.long]

EXAMPLES = Path(__file__).parent.parent / "examples"
PUMA, SCARA, TWO_LINK = ((EXAMPLES / f"{name}.toml").read_text() for name in ("puma560", "scara", "two_link"))


# Answers


@pytest.mark.parametrize("name", ["two_link", "four_bar"])
def test_everything_that_can_be_asked_is_answered(name: str) -> None:
    text = answer("example", "", {"name": name})["text"]
    found = {what: answer(what, text, {"target": "js", "language": "sk"}) for what in ANSWERS if what != "lesson"}

    assert not any(key in one for one in found.values() for key in ("faults", "refused", "failed")), found
    assert found["scene"]["name"] == name
    assert "<math>" in found["equations"]["html"]
    assert "<wbr>" in found["equations"]["html"]
    assert "<math>" in found["coefficients"]["html"]
    assert found["picture"]["svg"].startswith("<svg")
    assert f"{name}.js" in found["code"]["files"]
    assert "Pohyb" in found["motion"]["page"] or 'lang="sk"' in found["motion"]["page"]


@pytest.mark.parametrize("target", TARGETS)
def test_code_is_shown_in_every_target_of_texts(target: str) -> None:
    known, found = answer("begin", "", {})["targets"], answer("code", TWO_LINK, {"target": target})

    assert "files" in found or "value" in found["refused"][0], found
    assert (target in known) == (str in TARGETS[target].files.values())


def test_a_lesson_is_a_page_in_the_language_of_the_reader_with_exercises_where_they_are_asked_for() -> None:
    page = answer("lesson", TWO_LINK, {"language": "sk", "exercises": True})["page"]

    assert page.startswith("<!DOCTYPE html>")
    assert '<html lang="sk">' in page
    assert page.count('<form class="blank') > 9


def test_faults_come_with_their_places_and_without_the_name_of_a_file() -> None:
    found = answer("equations", TWO_LINK.replace("axis =", "axi =", 1), {})["faults"]

    line = TWO_LINK.splitlines().index("axis = [0, 0, 1]") + 1
    assert found[0] == {
        "line": line, "column": 1, "length": 3, "text": 'joints.shoulder: unknown key "axi"; did you mean axis?'
    }  # fmt: skip


@pytest.mark.parametrize(
    ("what", "text", "how", "key", "told"),
    [
        ("equations", "", {}, "faults", "nothing moves"),
        ("scene", "#" * (LONGEST + 1), {}, "faults", "more than"),
        ("nothing", TWO_LINK, {}, "faults", "there is no answer to 'nothing'"),
        ("example", "", {"name": "nowhere"}, "faults", "there is no example"),
        ("example", "", {"name": "../../etc/passwd"}, "faults", "there is no example"),
        ("code", TWO_LINK, {"target": "cobol"}, "refused", "cobol"),
        ("code", TWO_LINK, {}, "refused", "target"),
        ("lesson", TWO_LINK, {"exercises": 1}, "refused", "exercises is true or false"),
        ("code", TWO_LINK, {"target": "fmu"}, "refused", "have no value"),
    ],
)
def test_what_has_no_answer_is_told(what: str, text: str, how: dict[str, Any], key: str, told: str) -> None:
    assert told in json.dumps(answer(what, text, how)[key])


def test_a_scene_reads_no_file_but_those_beside_it(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text("0,0\n1,5\n")
    text = TWO_LINK.replace("[bodies.link1]", '[tables.f]\npoints = "curve.csv"\n[bodies.link1]', 1)

    assert "there is no such file" in json.dumps(answer("scene", text, {})["faults"])
    assert "faults" not in answer("scene", text, {}, Settings(str(tmp_path / "arm.toml")))
    for path in ("/etc/passwd", "../curve.csv"):
        wrong = text.replace("curve.csv", path)
        assert "lies elsewhere" in json.dumps(answer("scene", wrong, {}, Settings(str(tmp_path / "a.toml")))["faults"])


def test_words_for_an_editor_are_those_of_the_schema() -> None:
    found = words()

    assert "revolute" in found["joints"]["type"][1]
    assert found["bodies"]["mass"][0] == "kg"
    assert {"lower", "upper"} <= found["joints.limits"].keys()
    assert {"theta", "alpha"} <= found["dh.links"].keys()
    assert len(json.dumps(found)) < 30_000


def test_loops_stay_closed_while_they_are_pulled_and_say_where_they_cannot() -> None:
    text = answer("example", "", {"name": "four_bar"})["text"]
    before = {one["name"]: one["value"] for one in answer("picture", text, {})["sliders"]}
    name = next(iter(before))
    found = answer("picture", text, {"pulled": {name: before[name] + 0.2}})
    after = {one["name"]: one["value"] for one in found["sliders"]}
    refused = answer("picture", text, {"pulled": {"chi": 6.0, "nothing": 1.0, "phi": "?"}})

    assert after[name] == pytest.approx(before[name] + 0.2, abs=1e-9)
    assert all(after[other] != before[other] for other in after)
    assert not found["unpulled"]
    assert refused["unpulled"][0].startswith("the loops do not close with chi = ")
    assert {one["name"]: one["value"] for one in refused["sliders"]} == pytest.approx(before)


def test_a_picture_is_drawn_as_the_command_line_says() -> None:
    usual = answer("picture", TWO_LINK, {})
    found = answer("picture", TWO_LINK, {}, Settings(at=(("q1", 1.0),), labels=(), scheme="light"))

    assert found["sliders"][0]["value"] == 1.0
    assert "link 1" in usual["svg"]
    assert "link 1" not in found["svg"]


def test_a_fault_of_ours_is_a_message_and_the_page_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*given: Any) -> Any:
        raise TypeError("a\x1b[2J")

    monkeypatch.setitem(ANSWERS, "scene", broken)
    told = answer("scene", TWO_LINK, {})["failed"]

    assert told.startswith("symdyn itself has failed (TypeError: a")
    assert "\x1b" not in told


def test_what_takes_too_long_is_stopped_and_the_next_question_is_answered() -> None:
    process = AnsweringProcess(Settings())
    try:
        threading.Timer(0.3, process.stop).start()
        slow = {"what": "lesson", "text": PUMA, "how": {}}
        assert "it was stopped" in process.ask(slow).decode()
        found = json.loads(process.ask({"what": "scene", "text": TWO_LINK, "how": {}}))
        assert found["name"] == "two_link"
    finally:
        process.close()


# The server


@contextmanager
def played(path: Path | None) -> Iterator[Played]:
    settings = Settings() if path is None else Settings(str(path))
    found = Played(path, None, settings)
    try:
        yield found
    finally:
        found.close()


def asked(
    played: Played, path: str = "", method: str = "GET", body: bytes | None = None, **headers: str
) -> tuple[int, dict[str, str], bytes]:
    """Return status, headers and body of an answer; `_` in names of headers is "-"."""
    host, token = played.address.removeprefix("http://").rstrip("/").split("/")
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
def arm(tmp_path: Path) -> Iterator[tuple[Played, Path]]:
    path = tmp_path / "arm.toml"
    path.write_text(TWO_LINK)
    with played(path) as found:
        yield found, path


def test_only_who_has_the_address_is_answered(arm: tuple[Played, Path]) -> None:
    found, _ = arm
    host, token = found.address.removeprefix("http://").rstrip("/").split("/")
    port = host.partition(":")[2]

    assert host.startswith("127.0.0.1:")
    assert len(token) >= 32
    status, headers, page = asked(found)
    assert status == 200
    assert headers["cache-control"] == "no-store"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["content-security-policy"] == "frame-ancestors 'none'"
    assert "server" not in headers
    policy = page.decode().partition('Content-Security-Policy" content="')[2].partition('"')[0]
    assert policy.startswith("default-src 'none'; script-src 'self'; style-src 'self';")
    assert "unsafe" not in policy
    assert b"<script>" not in page
    assert asked(found, "frame.html")[1]["content-security-policy"] == "frame-ancestors 'self'"
    for name in ("page.js", "editor.js", "markup.js", "carrier.js", "words.js", "page.css"):
        assert asked(found, name)[0] == 200
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


def test_what_asks_must_come_from_the_page(arm: tuple[Played, Path]) -> None:
    found, _ = arm
    own = {"Origin": found.address.rsplit("/", 2)[0], "Content_Type": "application/json"}
    good = json.dumps({"what": "scene", "text": TWO_LINK, "how": {}}).encode()

    def answered(body: bytes, path: str = "answer", **headers: str) -> int:
        return asked(found, path, "POST", body, **headers)[0]

    assert json.loads(asked(found, "answer", "POST", good, **own)[2])["name"] == "two_link"
    assert answered(good, Content_Type="application/json") == 403
    assert answered(good, **{**own, "Origin": "http://evil.example"}) == 403
    assert answered(good, **{**own, "Origin": "null"}) == 403  # the frame's
    assert answered(good, **{**own, "Content_Type": "text/plain"}) == 403
    assert answered(good, "elsewhere", **own) == 403
    assert asked(found, "answer", "POST", Content_Length=str(2**21 + 1), **own)[0] == 413  # what follows is not read
    for body in (b"", b"[", b"[" * 4000, b"[]", b"{}", b'{"what": 1, "text": "", "how": {}}', good[:-1] + b', "x": 1}'):
        assert answered(body, **own) == 400, body
    assert answered(b"{}", "stop", **own) == 200


def test_a_file_is_saved_unless_it_says_something_else_by_now(arm: tuple[Played, Path]) -> None:
    found, path = arm
    own = {"Origin": found.address.rsplit("/", 2)[0], "Content_Type": "application/json"}

    def saved(text: str, before: str) -> Any:
        return json.loads(asked(found, "save", "POST", json.dumps({"text": text, "before": before}).encode(), **own)[2])

    assert saved("new", TWO_LINK) == {"saved": "arm.toml"}
    assert path.read_text() == "new"
    assert "nothing was written" in saved("newer", TWO_LINK)["refused"][0]
    assert path.read_text() == "new"
    with played(None) as page:
        assert "no file" in page.save("a", "b")["refused"][0]


def test_pages_are_not_more_than_a_machine_can_bear(arm: tuple[Played, Path]) -> None:
    found, _ = arm
    host, token = found.address.removeprefix("http://").rstrip("/").split("/")
    pages = [http.client.HTTPConnection(host, timeout=HANG) for _ in range(MOST + 1)]
    for page in pages:
        page.request("GET", f"/{token}/events")
    statuses = [page.getresponse().status for page in pages]
    for page in pages:
        page.close()

    assert sorted(statuses) == [200] * MOST + [503]


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


# In a browser


@contextmanager
def running(path: Path, folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Yield the command and its address."""
    command = [sys.executable, "-m", "symdyn", "play", path.name]
    environment = {**os.environ, "HOME": str(folder / "home"), "PYTHONDONTWRITEBYTECODE": "1"}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, cwd=path.parent, text=True, env=environment, **pipes)  # type: ignore[call-overload]
    try:
        yield process, process.stdout.readline().strip()
    finally:
        process.kill()
        process.wait()


SELECTED = "at => { const t = document.querySelector('#text'); t.focus(); t.setSelectionRange(at, at + 6); }"
FAULTS = "document.querySelectorAll('#faults li').length"
SHOWN = "document.querySelector('#picture img')"


def _written_by_both(page: Any, path: Path) -> None:
    first = page.get_attribute("#picture img", "src")  # another program saves, under another name first
    path.with_name("arm.toml~").write_text(SCARA.replace("0.325", "0.6"))
    path.with_name("arm.toml~").replace(path)
    until(page, f"{SHOWN}.src !== {json.dumps(first)}")
    assert "0.6" in page.input_value("#text")

    page.keyboard.press("Control+End")  # the page saves
    page.keyboard.type("# mine")
    page.keyboard.press("Control+s")
    until(page, "document.querySelector('#told').textContent.includes('arm.toml')")
    assert path.read_text().endswith("# mine")

    page.keyboard.type("!")  # both write
    path.write_text(SCARA)
    until(page, "!document.querySelector('#reload').hidden")
    assert page.input_value("#text").endswith("# mine!")
    page.click("#reload")
    until(page, f"document.querySelector('#text').value === {json.dumps(SCARA)}")
    until(page, f"{SHOWN}.src === {json.dumps(first)}")

    path.unlink()
    until(page, "document.querySelector('#told').textContent.includes('is not there')")
    path.write_text(SCARA)
    until(page, "document.querySelector('#told').hidden")


def _pulled(page: Any) -> None:
    first = page.get_attribute("#picture img", "src")
    page.click("#pull summary")
    page.locator("#sliders input").nth(1).fill("1")
    until(page, f"{SHOWN}.src !== {json.dumps(first)}")
    assert float(page.locator("#sliders output").nth(1).text_content().split()[0]) == pytest.approx(1, abs=0.01)
    page.click("#back")
    until(page, f"{SHOWN}.src === {json.dumps(first)}")


@pytest.mark.runs("chromium")
def test_a_scene_is_written_in_the_page_and_in_another_program(tmp_path: Path) -> None:
    (tmp_path / "home").mkdir()
    work = tmp_path / "work"
    work.mkdir()
    path = work / "arm.toml"
    path.write_text(SCARA)
    with chromium() as browser, running(path, tmp_path) as (process, address):
        assert address.startswith("http://127.0.0.1:")
        with opened(browser, address) as page:
            until(page, "document.body.dataset.shown")
            assert page.text_content("#name") == "arm.toml"
            assert page.input_value("#text") == SCARA
            assert page.locator("#equations math").count() > 3

            begin = SCARA.index("parent =")  # by hand: a mistake, and the word that was meant
            page.evaluate(SELECTED, begin)
            page.keyboard.type("paren")
            until(page, f"{FAULTS} > 0")
            assert "did you mean parent?" in page.text_content("#faults")
            assert "paren" in page.locator(".shown .wrong").all_text_contents()
            assert str(SCARA.count("\n", 0, begin) + 1) in page.locator(".numbers .wrong").all_text_contents()
            page.keyboard.press("Control+ ")
            assert page.text_content("#choices li b") == "parent"
            page.keyboard.press("Enter")
            until(page, f"{FAULTS} === 0")
            assert page.input_value("#text") == SCARA

            _written_by_both(page, path)
            _pulled(page)
            page.goto("about:blank")
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=HANG) == 0
        said = process.stderr.read() if process.stderr else ""
    assert said == "symdyn: open this address in a browser; Ctrl-C ends it\n"
    assert sorted(one.name for one in work.iterdir()) == ["arm.toml"]
    assert not [one for one in (tmp_path / "home").rglob("*") if one.is_file()]


def link(text: bytes) -> str:
    """Return a text as a link holds it."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    return urlsafe_b64encode(packer.compress(text) + packer.flush()).decode().rstrip("=")


BAD_LINKS = {
    "a bomb": (link(b"#" * 10**7), "200 kB"),
    "too long": ("A" * 20001, "20,000 letters"),
    "no UTF-8": (link(b"name = '\xff'"), ""),
    "no letters": ("<script>", ""),
    "not packed": ("AAAA", ""),
}


@pytest.mark.slow
@pytest.mark.runs("chromium")
def test_a_link_holds_the_scene_and_a_bad_one_is_told(tmp_path: Path) -> None:
    with chromium() as browser, played(None) as found:
        page = window(browser)
        page.goto(f"{found.address}#s={link(SCARA.encode())}")
        until(page, "document.body.dataset.shown")
        assert page.input_value("#text") == SCARA
        page.click("#share")
        until(page, "!document.querySelector('#told').hidden")
        shared = page.evaluate("location.hash")
        again = window(browser, viewport={"width": 390, "height": 800})
        again.goto(found.address + shared)
        until(again, "document.body.dataset.shown")
        assert again.input_value("#text") == SCARA
        assert again.evaluate("document.documentElement.scrollWidth") == 390
        for letters, told in BAD_LINKS.values():
            bad = window(browser)
            bad.goto(f"{found.address}#s={letters}")
            until(bad, "!document.querySelector('#told').hidden")
            assert told in bad.text_content("#told")
            bad.close()


@pytest.mark.slow
@pytest.mark.runs("chromium")
def test_lessons_and_motion_are_shown_in_a_room_of_their_own(tmp_path: Path) -> None:
    with chromium() as browser, played(None) as found, opened(browser, found.address) as page:
        until(page, "document.body.dataset.shown")
        page.select_option("#language", "sk")
        until(page, "document.querySelector('#h-equations').textContent === 'Pohybové rovnice'")
        for name, there in (("motion", "[data-do=play]"), ("lesson", "section")):
            page.click(f"#d-{name} summary")
            until(page, f"document.querySelector('#{name} iframe')")
            frame = page.frame_locator(f"#{name} iframe")
            frame.locator(there).first.wait_for()
            assert page.evaluate(f"document.querySelector('#{name} iframe').contentDocument") is None
        page.frame_locator("#motion iframe").locator("[data-do=play]").click()
        assert not page.evaluate(OVERLAPS)
        page.goto("about:blank")


@pytest.mark.slow
@pytest.mark.runs("chromium")
def test_text_of_a_stranger_stays_text(tmp_path: Path) -> None:
    text = SCARA + "".join(f"[bodies.{quoted(one)}]\n[{quoted(one)}]\n" for one in PAYLOADS.values())
    told = [one["text"] for one in answer("scene", text, {})["faults"]]
    with chromium() as browser, played(None) as found:
        with opened(browser, found.address) as page:
            until(page, "document.body.dataset.shown")
            page.fill("#text", text)
            until(page, f"{FAULTS} === {len(told)}")
            shown = page.locator("#faults li").all_text_contents()
            assert [one.split(" ", 2)[2] for one in shown] == told
            assert "<script>window.canary = 1</script>" in "".join(told)
            assert page.evaluate("window.canary === undefined && document.querySelectorAll('script').length === 1")
            page.goto("about:blank")
        page = window(browser)  # and if something were not escaped
        page.route("**/answer", lambda route: route.fulfill(json=HOSTILE))
        page.goto(found.address)
        until(page, "document.querySelector('#equations b')")
        time.sleep(0.1)
        assert page.evaluate("window.canary === undefined && !document.querySelector('#equations img, #equations a')")


HOSTILE = {
    "html": '<img src="x" onerror="window.canary = 1"><a href="javascript:window.canary=1">x</a><b onclick="x">b</b>',
    **{"examples": [], "targets": {"c": "C"}, "words": {}, "text": "name = 1", "name": "<b>", "notes": []},
    **{"bodies": 1, "joints": 1, "loops": 0, "freedoms": 1, "svg": "<svg/>", "sliders": [], "unpulled": []},
    **{"files": {"<b>": "<b>"}, "page": "<script>parent.canary = 1</script>"},
}


@pytest.mark.parametrize(
    ("arguments", "there", "settings"),
    [
        (["play", "two_link.toml"], "", Settings("two_link.toml")),
        (["play", "two_link.toml", "--bind", "g=9.81"], "9.81", Settings("two_link.toml")),
        (["play", "two_link.toml", "--symbolic", "all"], "", Settings("two_link.toml")),
        (["play", "two_link.toml", "--no-units"], "", Settings("two_link.toml", dimensionless=True)),
        (
            ["draw", "two_link.toml", "--watch", "--at", "q1=1", "--frames", "--labels", "bodies"],
            "",
            Settings("two_link.toml", at=(("q1", 1.0),), frames=True, labels=("bodies",)),
        ),
    ],
)
def test_the_command_line_says_how_a_file_is_read_and_drawn(
    arguments: list[str], there: str, settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: list[Any] = []
    monkeypatch.setattr("symdyn.cli.play.play", lambda *given: found.extend(given))
    monkeypatch.chdir(EXAMPLES)
    assert main(arguments) == 0
    path, text_of, asked, _ = found

    assert (str(path), asked) == ("two_link.toml", settings)
    assert (text_of is None) == (not {"--bind", "--symbolic"} & {*arguments})
    if text_of is not None:  # the scene as it is read, which the page never writes
        assert there in text_of()
        assert "faults" not in answer("scene", text_of(), {})


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["draw", "-", "--watch"], "the page follows a file"),
        (["play", "missing.toml"], "missing.toml is none"),
        (["play", "-"], "the page follows a file"),
        (["play", "{}", "--json"], "leave --json out"),
        (["draw", "{}", "--watch", "-o", "x.svg"], "leave out -o"),
        (["draw", "{}", "--watch", "--body", "link1"], "leave out --body"),
        (["draw", "{}", "--watch", "--at", "q9"], "gives no coordinate a value"),
    ],
)
def test_what_cannot_be_played_is_one_line(arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([word.format(EXAMPLES / "puma560.toml") for word in arguments]) == 1
    assert told in capsys.readouterr().err

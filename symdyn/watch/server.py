"""The page's server: this machine alone, and of it only who has the address.

It listens on 127.0.0.1. Every address begins with a random token, compared in constant time; a request must name the
server as its host, so that no page of another name that points here (DNS rebinding) reads anything; what changes
something must come from the page itself. The page may run its own script and load nothing.

The page shows a picture, coordinates to pull, messages. A file with a fault leaves the last good picture.
"""

from __future__ import annotations

import hmac
import json
import math
import secrets
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.draw import Stage, pose
from symdyn.dynamics.loops import Numbers
from symdyn.emit import in_html, render
from symdyn.errors import DerivationError, DrawError, SymdynError, printable
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import velocity_name

ADDRESS = "127.0.0.1"
LONGEST = 4096
"""Bytes that the page may send at once."""

MOST = 20
"""Pages that may be open."""

ALIVE = 1.0
"""s between signs of life, by which it is seen that a page was closed."""


@dataclass
class Board:
    """What pages show, by kind: texts of JSON with the number of their change."""

    _texts: dict[str, tuple[int, str]] = field(default_factory=dict)
    _changes: int = 0
    _condition: threading.Condition = field(default_factory=threading.Condition)
    closed: bool = False

    def put(self, kind: str, value: Any) -> None:
        """Show something."""
        with self._condition:
            self._changes += 1
            self._texts[kind] = self._changes, json.dumps(value)
            self._condition.notify_all()

    def close(self) -> None:
        """Let no page wait any longer."""
        with self._condition:
            self.closed = True
            self._condition.notify_all()

    def after(self, change: int) -> tuple[int, list[tuple[str, str]]]:
        """Return the last change, and what was shown after one; nothing where nothing is for a while."""
        with self._condition:
            self._condition.wait_for(lambda: self.closed or self._changes > change, ALIVE)
            texts = sorted(self._texts.items(), key=lambda one: one[1][0])
            return self._changes, [(kind, text) for kind, (number, text) in texts if number > change]


class PageServer(ThreadingHTTPServer):
    """The server of one page."""

    daemon_threads = True
    block_on_close = False
    request_queue_size = 2 * MOST  # of fewer the system drops some that come at once, and they try again later

    def __init__(self, title: str, board: Board, changed: Callable[[dict[str, Any]], None], port: int = 0) -> None:
        """Listen on a free port; `changed` takes what the page sends."""
        super().__init__((ADDRESS, port), _Handler)
        self.title, self.board, self.changed = title, board, changed
        self.token = secrets.token_urlsafe(24)
        self.pages = threading.BoundedSemaphore(MOST)

    @property
    def host(self) -> str:
        """Its name in requests."""
        return f"{ADDRESS}:{self.server_address[1]}"

    @property
    def address(self) -> str:
        """What a person opens."""
        return f"http://{self.host}/{self.token}/"

    def server_bind(self) -> None:
        """Bind without asking for this machine's name, which may take seconds."""
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()
        self.server_name, self.server_port = ADDRESS, self.server_address[1]

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of pages that were closed."""


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    protocol_version = "HTTP/1.1"
    timeout = 60.0

    def do_GET(self) -> None:
        """Answer with the page, or with what it shows."""
        path = self._allowed()
        if path == "":
            self._page()
        elif path == "events":
            self._events()
        elif path is not None:
            self._refuse(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """Take what the page sends."""
        path = self._allowed()
        if path is None:
            return
        length = self.headers.get("Content-Length", "")
        own = self.headers.get("Origin") == f"http://{self.server.host}"
        if path != "pull" or not own or self.headers.get("Content-Type") != "application/json":
            self._refuse(HTTPStatus.FORBIDDEN)
        elif not (length.isascii() and length.isdigit() and len(length) < 9 and int(length) <= LONGEST):
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        elif not _is_pull(sent := _json(self.rfile.read(int(length)))):
            self._refuse(HTTPStatus.BAD_REQUEST)
        else:
            self.server.changed(sent)
            self._answer(HTTPStatus.OK, b"", "text/plain")

    def _allowed(self) -> str | None:
        """Return the path behind the token; None, and an answer, where the request must not be heard."""
        hosts = self.headers.get_all("Host") or []
        _, token, *rest = (self.path.partition("?")[0] + "/").split("/", 2)
        known = hmac.compare_digest(token.encode(), self.server.token.encode())
        if hosts != [self.server.host] or not known:
            self._refuse(HTTPStatus.FORBIDDEN)
            return None
        return rest[0].removesuffix("/") if rest else ""

    def _page(self) -> None:
        nonce = secrets.token_urlsafe(16)
        policy = (
            f"default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data:; "
            "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )
        text = render("watch/page.html.jinja", {"nonce": nonce, "title": in_html(self.server.title)})
        self._answer(HTTPStatus.OK, text.encode(), "text/html; charset=utf-8", {"Content-Security-Policy": policy})

    def _events(self) -> None:
        """Send what is shown, and every change of it, as long as the page listens."""
        if not self.server.pages.acquire(blocking=False):
            self._refuse(HTTPStatus.SERVICE_UNAVAILABLE)
            return
        try:
            self._answer(HTTPStatus.OK, None, "text/event-stream")
            change = 0
            while not self.server.board.closed:
                change, texts = self.server.board.after(change)
                lines = [f"event: {kind}\ndata: {text}\n\n" for kind, text in texts] or [": alive\n\n"]
                self.wfile.write("".join(lines).encode())
                self.wfile.flush()
        except OSError:  # the page was closed
            pass
        finally:
            self.server.pages.release()
            self.close_connection = True

    def _refuse(self, status: HTTPStatus) -> None:
        self._answer(status, f"{status.value} {status.phrase}\n".encode(), "text/plain; charset=utf-8")

    def _answer(self, status: HTTPStatus, body: bytes | None, kind: str, more: dict[str, str] | None = None) -> None:
        """Answer; a body of None is written by whoever asked, and ends with the connection."""
        self.send_response_only(status)
        headers = {
            "Content-Type": kind,
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Cross-Origin-Opener-Policy": "same-origin",
        } | (more or {})
        refused = status >= HTTPStatus.BAD_REQUEST  # what else it sends is not read
        headers |= {"Connection": "close"} if body is None or refused else {}
        headers |= {} if body is None else {"Content-Length": str(len(body))}
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        if body:
            self.wfile.write(body)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Answer what is no request, or one of another kind."""
        self._refuse(HTTPStatus(code))

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing: the terminal belongs to the command."""


def _json(body: bytes) -> Any:
    try:
        return json.loads(body)
    except (ValueError, RecursionError):
        return None


def _is_pull(sent: Any) -> bool:
    """Tell whether the page sent {"name": .., "value": ..} or {"back": true}."""
    if not isinstance(sent, dict):
        return False
    if sent.keys() == {"back"}:
        return sent["back"] is True
    value = sent.get("value")
    return (
        sent.keys() == {"name", "value"}
        and isinstance(sent["name"], str)
        and isinstance(value, (int, float))
        and not isinstance(value, bool)
        and abs(value) < 1e9
        and math.isfinite(value)
    )


LEG = 0.1
"""How far a coordinate of a closed mechanism is pulled at once, rad or m, so that it stays on its branch."""

LEGS = 40


@dataclass(frozen=True)
class Slider:
    """A coordinate to pull; unit and range are of its joint."""

    name: str
    unit: str
    low: float
    high: float
    value: float


@dataclass(frozen=True)
class Sheet:
    """What is shown at one moment.

    Attributes:
        title: name of the scene.
        picture: SVG text.
        sliders: one a coordinate.
        faults: why what is shown is not what the file says, one line each.
        notes: what the reader of the file, and whoever pulled, should know.
    """

    title: str
    picture: str = ""
    sliders: tuple[Slider, ...] = ()
    faults: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Standing:
    """A scene in a position: q, shape (nq,), values of all parameters, and ranges of sliders."""

    scene: Scene
    q: Array
    values: dict[str, float]
    spans: tuple[tuple[str, str, float, float], ...]
    numbers: Numbers = field(compare=False)

    def sliders(self) -> tuple[Slider, ...]:
        """Return the sliders where they are."""
        pairs = zip(self.spans, self.q.tolist(), strict=True)
        return tuple(Slider(name, unit, min(low, x), max(high, x), x) for (name, unit, low, high), x in pairs)

    def pulled(self, name: str, value: float) -> Standing:
        """Return it with a coordinate pulled as far as a value; loops stay closed on their branch.

        Raises:
            DrawError: they do not close there.
        """
        k, q = self.scene.coordinates.index(name), self.q.copy()
        if not self.scene.is_constrained:
            q[k] = value
            return replace(self, q=self.numbers.normalised(q))
        rate, names = velocity_name(name), list(self.scene.velocities)
        held = [names.index(rate)] if rate in names else []
        legs = min(LEGS, max(1, math.ceil(abs(value - q[k]) / LEG)))
        for at in np.linspace(q[k], value, legs + 1)[1:]:
            tried = q.copy()
            tried[k] = at
            try:
                tried = self.numbers.newton(self.numbers.normalised(tried), held)
                closed = self.numbers.is_closed(tried)
            except DerivationError:
                closed = False
            if not closed:
                raise DrawError(f"the loops do not close with {name} = {at:.6g}; it can be pulled as far as {q[k]:.6g}")
            q = tried
        return replace(self, q=q)


def standing(scene: Scene, at: dict[str, float]) -> Standing:
    """Return a scene in the position that a picture of it shows, coordinates `at` as they are given.

    Raises:
        DrawError: it has none.
    """
    q, values = pose(scene, at)
    wide = {"rad": math.pi, "m": Stage(scene, q[None], values).places.reach if scene.coordinates else 1.0, "1": 1.0}
    spans = []
    for joint, name, unit in SceneUnits(scene).each_coordinate():
        low, high = joint.range(values)
        low, high = (x if math.isfinite(x) else sign * wide[unit] for x, sign in ((low, -1), (high, 1)))
        spans.append((name, scene.shown_unit(unit), low, high))
    numbers = Numbers(scene).bound_to({p.name: values[p.name] for p in scene.free_parameters})
    return Standing(scene, q, values, tuple(spans), numbers)


def _lines(fault: Exception) -> tuple[str, ...]:
    """Return what a fault says; one of ours does not end the page, which goes on with the next text of the file."""
    if isinstance(fault, SymdynError):
        return tuple(getattr(fault, "faults", ()) or [str(fault)])
    told = printable(f"{type(fault).__name__}: {fault}", keep="")
    return (f"symdyn itself has failed ({told}); please report it with the file; the page goes on",)


Loaded = tuple[Scene, Sequence[str]]
Drawn = Callable[[Scene, Array, dict[str, float]], str]


class Show:
    """The sheet of a file, made anew as the file or a hand changes it.

    Attributes:
        sheet: what is shown now.
        scene: what the equations are of: the last one that could be read; None before there is one.
    """

    def __init__(self, title: str, load: Callable[[], Loaded], draw: Drawn, at: dict[str, float]) -> None:
        self._load, self._draw, self._at = load, draw, at
        self._pulled: dict[str, float] = {}
        self._standing: Standing | None = None
        self._notes: tuple[str, ...] = ()
        self.sheet = Sheet(title)
        self.scene: Scene | None = None

    def read(self) -> None:
        """Show what the file says now; its fault, where it has one, and the picture before."""
        try:
            scene, notes = self._load()
            found = standing(scene, self._at)
            for name in [name for name in self._pulled if name in scene.coordinates]:
                try:
                    found = found.pulled(name, self._pulled[name])
                except DrawError:
                    del self._pulled[name]
            picture = self._draw(scene, found.q, found.values)
        except Exception as fault:
            self.sheet = replace(self.sheet, faults=_lines(fault))
            return
        self._standing, self.scene, self._notes = found, scene, tuple(notes)
        self.sheet = Sheet(scene.name, picture, found.sliders(), (), self._notes)

    def gone(self, text: str) -> None:
        """Show that the file is not there."""
        self.sheet = replace(self.sheet, faults=(text,))

    def pull(self, name: str, value: float) -> None:
        """Pull a coordinate; where it cannot go is said, and it stays."""
        if self._standing is None or name not in self._standing.scene.coordinates or not math.isfinite(value):
            return
        try:
            found = self._standing.pulled(name, value)
            picture = self._draw(found.scene, found.q, found.values)
        except Exception as fault:
            self.sheet = replace(self.sheet, notes=(*self._notes, *_lines(fault)))
            return
        self._standing, self._pulled[name] = found, value
        self.sheet = replace(self.sheet, picture=picture, sliders=found.sliders(), notes=self._notes)

    def back(self) -> None:
        """Forget what was pulled."""
        self._pulled.clear()
        self.read()

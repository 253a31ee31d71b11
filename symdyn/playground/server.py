"""The page's server: this machine alone, and of it only who has the address.

It listens on 127.0.0.1. Every address begins with a random token, compared in constant time; a request must name the
server as its host, so that no page of another name that points here (DNS rebinding) reads anything; what asks for
something must come from the page itself. The page runs its own scripts and loads nothing from elsewhere; lessons and
what moves are shown in a frame that is nobody's origin.
"""

from __future__ import annotations

import hmac
import json
import secrets
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Protocol

from symdyn.resources import folder

ADDRESS = "127.0.0.1"
LONGEST = 2**21
"""Bytes that the page may send at once."""

MOST = 20
"""Pages that may be open."""

ALIVE = 1.0
"""s between signs of life, by which it is seen that a page was closed."""

FILES: Mapping[str, str] = {
    "": "text/html; charset=utf-8",
    "frame.html": "text/html; charset=utf-8",
    "page.css": "text/css; charset=utf-8",
    "page.js": "text/javascript; charset=utf-8",
    "editor.js": "text/javascript; charset=utf-8",
    "markup.js": "text/javascript; charset=utf-8",
    "carrier.js": "text/javascript; charset=utf-8",
    "words.js": "text/javascript; charset=utf-8",
}
"""What the page is made of, and its media types; policies stand in the files."""


class Carried(Protocol):
    """What the page asks."""

    def ask(self, sent: dict[str, Any]) -> bytes:
        """Return the answer, as JSON."""

    def stop(self) -> None:
        """Answer no longer what is being answered."""

    def save(self, text: str, before: str) -> dict[str, Any]:
        """Write the file that is followed, if it says what it said before."""


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

    def __init__(self, board: Board, carried: Carried, port: int = 0) -> None:
        """Listen on a free port."""
        super().__init__((ADDRESS, port), _Handler)
        self.board, self.carried = board, carried
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


ASKED: Mapping[str, Mapping[str, type]] = {
    "answer": {"what": str, "text": str, "how": dict},
    "stop": {},
    "save": {"text": str, "before": str},
}
"""What the page may ask, and what it says then."""


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    protocol_version = "HTTP/1.1"
    timeout = 60.0
    disable_nagle_algorithm = True  # else a body waits 40 ms for its head to be acknowledged

    def do_GET(self) -> None:
        """Answer with a file of the page, or with what is told to it."""
        path = self._allowed()
        if path is None:
            return
        if path == "events":
            self._events()
        elif path in FILES:
            body = (folder("templates") / "playground" / (path or "index.html")).read_bytes()
            framed = "'self'" if path else "'none'"
            self._answer(HTTPStatus.OK, body, FILES[path], {"Content-Security-Policy": f"frame-ancestors {framed}"})
        else:
            self._refuse(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """Answer what the page asks."""
        path = self._allowed()
        if path is None:
            return
        length = self.headers.get("Content-Length", "")
        own = self.headers.get("Origin") == f"http://{self.server.host}"
        if not (length.isascii() and length.isdigit() and len(length) < 9 and int(length) <= LONGEST):
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
            return
        body = self.rfile.read(int(length))  # of what is refused too, else its answer may be lost with the connection
        if path not in ASKED or not own or self.headers.get("Content-Type") != "application/json":
            self._refuse(HTTPStatus.FORBIDDEN)
        elif not _has(sent := _json(body), ASKED[path]):
            self._refuse(HTTPStatus.BAD_REQUEST)
        elif path == "stop":
            self.server.carried.stop()
            self._answer(HTTPStatus.OK, b"{}", "application/json")
        elif path == "save":
            found = self.server.carried.save(sent["text"], sent["before"])
            self._answer(HTTPStatus.OK, json.dumps(found).encode(), "application/json")
        else:
            self._answer(HTTPStatus.OK, self.server.carried.ask(sent), "application/json")

    def _allowed(self) -> str | None:
        """Return the path behind the token; None, and an answer, where the request must not be heard."""
        hosts = self.headers.get_all("Host") or []
        _, token, *rest = (self.path.partition("?")[0] + "/").split("/", 2)
        known = hmac.compare_digest(token.encode(), self.server.token.encode())
        if hosts != [self.server.host] or not known:
            self._refuse(HTTPStatus.FORBIDDEN)
            return None
        return rest[0].removesuffix("/") if rest else ""

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


def _has(sent: Any, kinds: Mapping[str, type]) -> bool:
    """Tell whether the page sent what belongs to what it asks, and nothing else."""
    return (
        isinstance(sent, dict)
        and sent.keys() == kinds.keys()
        and all(isinstance(sent[name], kind) for name, kind in kinds.items())
    )

"""The server: for this machine only, for its own pages only, and without a file but Bokeh's own scripts."""

import contextlib
import errno
import logging
import re
import signal
import time
import webbrowser
from collections.abc import Iterator
from typing import NoReturn

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.server.util import bind_sockets
from bokeh.settings import settings
from bokeh.util.token import get_session_id, get_token_payload
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPHeaders, HTTPServerRequest, ResponseStartLine
from tornado.ioloop import IOLoop
from tornado.routing import Rule, RuleRouter

from .page import Page, document
from .start import Start

ADDRESS = "127.0.0.1"
_HOSTS = (ADDRESS, "localhost")
_PATHS = re.compile(r"/(|ws|favicon\.ico|static/[\w./-]{0,200})", re.ASCII)
_PATIENCE = 2.0  # s, for a solve that is under way when the server ends


class _Ours:
    """Tells requests by this machine's own pages from all others, for Tornado's router."""

    def __init__(self, port: int) -> None:
        self._origins = {f"http://{host}:{port}" for host in _HOSTS}

    def match(self, request: HTTPServerRequest) -> dict[str, object] | None:
        """{} for a request that is answered, None for one that is not.

        The host's name is checked, for a page elsewhere may have its own name lead here; and the origin.
        """
        origin = request.headers.get("Origin")
        host = request.headers.get("Host", "").rpartition(":")
        known = (host[0] or host[2]) in _HOSTS and (origin is None or origin in self._origins)
        known = known and (request.path != "/ws" or _has_token(request))
        return {} if known and _PATHS.fullmatch(request.path) else None


class _Any:
    """Matches every request that is left."""

    def match(self, request: HTTPServerRequest) -> dict[str, object]:
        return {}


def _refuse(request: HTTPServerRequest) -> None:
    text = b"Only the page itself is served, to this machine's own browser.\n"
    body = None if request.method == "HEAD" else text
    headers = HTTPHeaders({"Content-Type": "text/plain", "Content-Length": str(len(text))})
    request.connection.write_headers(ResponseStartLine("HTTP/1.1", 403, "Forbidden"), headers, body)
    request.connection.finish()


def _has_token(request: HTTPServerRequest) -> bool:
    """Whether a request to talk comes from a page that was served here; Bokeh's answer to others is a traceback."""
    protocol, _, token = request.headers.get("Sec-WebSocket-Protocol", "").replace(" ", "").partition(",")
    try:
        get_session_id(token)
        return protocol == "bokeh" and bool(time.time() < get_token_payload(token)["session_expiry"])
    except Exception:  # whatever it is that is no token
        return False


class _Pages:
    """The pages that are open, one for each tab of a browser."""

    def __init__(self, start: Start, address: str) -> None:
        self._start, self._address, self._open = start, address, set[Page]()

    def make(self, doc: Document) -> None:
        """Fill a new document."""
        page = document(self._start, self._address, doc, doc.session_context.request.arguments)
        self._open.add(page)
        doc.on_session_destroyed(lambda _: self._close(page))

    def _close(self, page: Page) -> None:
        page.end()
        self._open.discard(page)

    def close_all(self) -> None:
        """Let every page's thread end."""
        pages = list(self._open)
        for patience in (0.0, _PATIENCE / max(1, len(pages))):  # all are told before one is waited for
            for page in pages:
                page.end(patience)


@contextlib.contextmanager
def served(start: Start, port: int) -> Iterator[tuple[str, IOLoop]]:
    """The address of the page, and the loop that serves it once it is started.

    port: 0 for any that is free. Raises `ValueError` for a port that cannot be had.
    """
    try:
        sockets, port = bind_sockets(ADDRESS, port)
    except (OSError, OverflowError) as error:
        taken = getattr(error, "errno", None) == errno.EADDRINUSE
        why = "which another program has" if taken else f"which cannot be had ({error})"
        raise ValueError(f"port is {port}, {why}; allowed: another one, or 0 for any that is free") from None
    address = f"http://{ADDRESS}:{port}/"
    logging.getLogger("bokeh.server").setLevel(logging.ERROR)  # a tab that is closed is nothing to warn of
    settings.resources = "server"  # whatever the environment says: no script from elsewhere
    pages = _Pages(start, address)
    origins = [f"{host}:{port}" for host in _HOSTS]
    app = BokehTornado({"/": Application(FunctionHandler(pages.make))}, extra_websocket_origins=origins)
    http = HTTPServer(RuleRouter([Rule(_Ours(port), app), Rule(_Any(), _refuse)]))
    http.add_sockets(sockets)
    loop = IOLoop.current()
    server = BaseServer(loop, app, http)
    server.start()
    try:
        yield address, loop
    finally:
        pages.close_all()
        server.stop()
        for sock in sockets:
            sock.close()


def answer_requests(loop: IOLoop) -> NoReturn:
    """Answer requests until Ctrl-C, which is taken between two of them: Tornado would log it as an error of one."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    taken = {number: handler for number, handler in handlers.items() if callable(handler)}
    for number in taken:
        signal.signal(number, lambda *_: loop.asyncio_loop.call_soon_threadsafe(loop.stop))
    try:
        loop.start()
    finally:
        for number, handler in taken.items():
            signal.signal(number, handler)
    raise KeyboardInterrupt


def open_browser(address: str) -> None:
    """Show the page in the user's browser. Raises `ValueError` if there is none but such as fill a terminal."""
    try:
        browser = webbrowser.get()
        shown = type(browser) is not webbrowser.GenericBrowser and browser.open(address)
    except webbrowser.Error:
        shown = False
    if not shown:
        raise ValueError(f"--browser is given, but none could be opened; allowed: without it, and {address} by hand")

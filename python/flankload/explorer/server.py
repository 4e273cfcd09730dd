"""The server of an explorer: Bokeh's, in a thread of its own, on the loopback device alone.

Whoever knows the token in the address uses it. The gate refuses every other request, and any whose
Host or Origin is another site's: a page in the same browser, or a name that leads to this machine.
"""

from __future__ import annotations

import asyncio
import socket
from hmac import compare_digest
from secrets import token_urlsafe
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPHeaders, HTTPMessageDelegate, ResponseStartLine
from tornado.ioloop import IOLoop
from tornado.netutil import bind_sockets
from tornado.routing import Router
from tornado.web import RequestHandler

if TYPE_CHECKING:
    from collections.abc import Callable

    from bokeh.document import Document
    from tornado.httputil import HTTPConnection, HTTPServerRequest

LOOPBACK = "127.0.0.1"
#: Bytes of the token.
TOKEN_BYTES = 24
#: Seconds after which the session of a closed page is dropped, and between two checks.
UNUSED_S = 2.0


class _Refusal(HTTPMessageDelegate):
    """Answers a request with 403 and one line."""

    def __init__(self, connection: HTTPConnection, line: str) -> None:
        self._connection, self._line = connection, f"{line}\n".encode()

    def finish(self) -> None:
        headers = HTTPHeaders({"Content-Type": "text/plain; charset=utf-8",
                               "Content-Length": str(len(self._line)),
                               "Connection": "close"})  # fmt: skip
        start = ResponseStartLine("HTTP/1.1", 403, "Forbidden")
        self._connection.write_headers(start, headers, self._line)
        self._connection.finish()


class _Gate(Router):
    """Passes requests with the token, of this host and origin, to the application."""

    def __init__(self, inside: BokehTornado, token: str, port: int) -> None:
        self._inside, self._token = inside, token
        self._hosts = tuple(f"{name}:{port}" for name in (LOOPBACK, "localhost"))

    def find_handler(self, request: HTTPServerRequest, **more: Any) -> HTTPMessageDelegate | None:
        line = self.refused(request)
        if line:
            assert request.connection is not None
            return _Refusal(request.connection, line)
        return self._inside.find_handler(request, **more)

    def refused(self, request: HTTPServerRequest) -> str:
        """Why a request is refused; empty if it is not."""
        if request.headers.get("Host", "") not in self._hosts:
            return "refused: foreign Host"
        origin = request.headers.get("Origin") or request.headers.get("Sec-Websocket-Origin")
        if origin is not None and origin.removeprefix("http://") not in self._hosts:
            return "refused: foreign Origin"
        token = request.path.split("/")[1] if request.path.startswith("/") else ""
        if not compare_digest(token.encode(), self._token.encode()):
            return "refused: no token of this explorer"
        return ""


class Server:
    """A server with one page, and further addresses for its files.

    Parameters
    ----------
    fill : callable
        Fills the document of each page, in the thread of the server.
    files : dict of str to callable
        Name of each file below the page with a function that returns its type and content, called
        in a thread of its own.
    port : int
        0: any that is free.

    Raises
    ------
    OSError
        If the port is taken.
    """

    def __init__(
        self,
        fill: Callable[[Document], None],
        files: dict[str, Callable[[], tuple[str, str]]],
        port: int,
    ) -> None:
        sockets = bind_sockets(port, LOOPBACK, family=socket.AF_INET)
        self.port = int(sockets[0].getsockname()[1])
        token = token_urlsafe(TOKEN_BYTES)
        self.url = f"http://{LOOPBACK}:{self.port}/{token}/"
        self._fill, self._files, self._token, self._sockets = fill, files, token, sockets
        self._loop: IOLoop | None = None
        self._server: BaseServer | None = None
        self._ready, self._failed = Event(), list[BaseException]()
        self._thread = Thread(target=self._run, name="flankload explorer server", daemon=True)
        self._thread.start()
        self._ready.wait()
        if self._failed:
            raise self._failed[0]

    def close(self) -> None:
        """Close all connections; the thread ends. Not to be called in that thread."""
        if self._loop is not None and self._thread.is_alive():
            self._loop.add_callback(self._stop)
            self._thread.join()

    def _run(self) -> None:
        try:
            self._serve()
        except BaseException as error:  # of the caller, who waits
            self._failed.append(error)
            self._ready.set()

    def _serve(self) -> None:
        asyncio.set_event_loop(asyncio.new_event_loop())
        self._loop = IOLoop.current()
        # a page has its address from its own request: no other origin is ever right
        inside = BokehTornado(
            {"/": Application(FunctionHandler(self._fill))},
            prefix=self._token,
            extra_websocket_origins=[f"{LOOPBACK}:{self.port}", f"localhost:{self.port}"],
            extra_patterns=[(f"/{name}", _File, {"make": make}) for name, make in
                            self._files.items()],
            use_index=False,
            check_unused_sessions_milliseconds=int(1e3 * UNUSED_S),
            unused_session_lifetime_milliseconds=int(1e3 * UNUSED_S),
        )  # fmt: skip
        http = HTTPServer(_Gate(inside, self._token, self.port))
        self._server = BaseServer(self._loop, inside, http)
        http.add_sockets(self._sockets)
        self._server.start()
        self._loop.add_callback(self._ready.set)
        self._loop.start()
        self._loop.close(all_fds=True)

    async def _stop(self) -> None:
        assert self._server is not None
        assert self._loop is not None
        self._server.stop(wait=False)
        await self._server._http.close_all_connections()
        pending = asyncio.all_tasks() - {asyncio.current_task()}
        for task in pending:
            task.cancel()
        await asyncio.gather(*pending, return_exceptions=True)
        self._loop.stop()


class _File(RequestHandler):
    """A file that is made when it is asked for."""

    def initialize(self, make: Callable[[], tuple[str, str]]) -> None:
        self._make = make

    async def get(self) -> None:
        """Send the file."""
        kind, text = await asyncio.to_thread(self._make)
        self.set_header("Content-Type", f"{kind}; charset=utf-8")
        self.finish(text)

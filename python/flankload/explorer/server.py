"""The server of an explorer: Bokeh's, in a thread of its own, on the loopback device alone.

Whoever knows the token in the address uses it. The gate refuses every other request, and any whose
Host or Origin is another site's: a page in the same browser, or a name that leads to this machine.
"""

from __future__ import annotations

import asyncio
import logging
import socket
from hmac import compare_digest
from secrets import token_urlsafe
from threading import Thread
from typing import TYPE_CHECKING, Any

from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.netutil import bind_sockets
from tornado.web import ErrorHandler, RequestHandler

if TYPE_CHECKING:
    from collections.abc import Callable

    from bokeh.document import Document
    from tornado.httputil import HTTPServerRequest

LOOPBACK = "127.0.0.1"
#: Bytes of the token.
TOKEN_BYTES = 24
#: Milliseconds after which the session of a closed page is dropped, and between two checks.
UNUSED_MS = 2000


class _Gate(BokehTornado):
    """Bokeh's application for requests with the token in their path, of this host and origin."""

    def __init__(
        self, fill: Callable[[Document], None], token: str, port: int, **more: Any
    ) -> None:
        # browsers leave out port 80
        self._hosts = tuple(
            f"{host}:{port}".removesuffix(":80") for host in (LOOPBACK, "localhost")
        )
        self._token = token.encode()
        super().__init__(
            {"/": fill}, prefix=token, extra_websocket_origins=self._hosts, use_index=False,
            check_unused_sessions_milliseconds=UNUSED_MS, log_function=lambda _: None,
            unused_session_lifetime_milliseconds=UNUSED_MS, **more,
        )  # fmt: skip

    def find_handler(self, request: HTTPServerRequest, **more: Any) -> Any:
        """Handler of a request; that of status 403 if it is refused."""
        headers, parts = request.headers, request.path.split("/")
        origin = headers.get("Origin") or headers.get("Sec-Websocket-Origin")
        own = headers.get("Host") in self._hosts
        own &= origin is None or origin.removeprefix("http://") in self._hosts
        if own and len(parts) > 1 and compare_digest(parts[1].encode(), self._token):
            return super().find_handler(request, **more)
        return self.get_handler_delegate(request, ErrorHandler, {"status_code": 403})


class _File(RequestHandler):
    """A file that is made when it is asked for."""

    def initialize(self, make: Callable[[], tuple[str, str]]) -> None:
        self._make = make

    async def get(self) -> None:
        """Send the file."""
        kind, text = await asyncio.to_thread(self._make)
        self.set_header("Content-Type", f"{kind}; charset=utf-8")
        self.finish(text)


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
        # a page that is closed while a message is sent is no concern of the user
        logging.getLogger("bokeh.server.views.ws").setLevel(logging.ERROR)
        sockets = bind_sockets(port, LOOPBACK, family=socket.AF_INET)
        port, token = int(sockets[0].getsockname()[1]), token_urlsafe(TOKEN_BYTES)
        self.url = f"http://{LOOPBACK}:{port}/{token}/"
        self._loop = IOLoop(make_current=False)
        more = [(f"/{name}", _File, {"make": make}) for name, make in files.items()]
        gate = _Gate(fill, token, port, extra_patterns=more)
        self._http = HTTPServer(gate)
        self._server = BaseServer(self._loop, gate, self._http)
        self._loop.add_callback(self._server.start)
        self._loop.add_callback(self._http.add_sockets, sockets)
        self._thread = Thread(target=self._run, name="flankload explorer server", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Close all connections; the thread ends. Not to be called in that thread."""
        if self._thread.is_alive():
            self._loop.add_callback(self._stop)
            self._thread.join()

    def _run(self) -> None:
        self._loop.start()
        self._loop.close(all_fds=True)

    async def _stop(self) -> None:
        self._server.stop(wait=False)
        await self._http.close_all_connections()
        pending = asyncio.all_tasks() - {asyncio.current_task()}
        for task in pending:
            task.cancel()
        await asyncio.gather(*pending, return_exceptions=True)
        self._loop.stop()

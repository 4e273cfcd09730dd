"""A headless Chromium that tests steer by its debugging protocol."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
import time
import urllib.request
from pathlib import Path
from typing import Any, Self

import pytest

#: Function of the page that finds elements also inside those of components.
DEEP = """window.deep = (query, root = document) => [...root.querySelectorAll(query),
  ...[...root.querySelectorAll("*")].flatMap(
    e => e.shadowRoot ? deep(query, e.shadowRoot) : [])];"""
#: Seconds until a condition must be met.
PATIENCE_S = 20.0


class Browser:
    """A tab of a browser of its own; a `with` block ends it."""

    def __init__(self, folder: Path) -> None:
        program = shutil.which("chromium") or shutil.which("chromium-browser")
        if program is None:
            pytest.skip("no Chromium")
        self._process = subprocess.Popen(
            [program, "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0",
             "--disable-background-networking", "--window-size=1300,1000",
             f"--user-data-dir={folder / 'profile'}", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert self._process.stderr is not None
        line = next(line for line in self._process.stderr if "DevTools listening" in line)
        address = line.split("//")[1].split("/")[0]
        with urllib.request.urlopen(f"http://{address}/json", timeout=PATIENCE_S) as answer:
            tab = next(tab for tab in json.load(answer) if tab["type"] == "page")
        from tornado.ioloop import IOLoop
        from tornado.websocket import websocket_connect

        self._loop = IOLoop(make_current=False)
        self._socket = self._loop.run_sync(
            lambda: websocket_connect(tab["webSocketDebuggerUrl"], max_message_size=1 << 28)
        )
        self._number = 0
        self.events: list[dict[str, Any]] = []
        for domain in ("Page", "Runtime", "Network"):
            self.call(f"{domain}.enable")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()
        self._loop.close()
        self._process.kill()
        self._process.communicate()

    def call(self, method: str, **parameters: Any) -> Any:
        """Result of a method of the protocol; events before it are kept."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        self._socket.write_message(json.dumps(message))
        while True:
            answer = json.loads(self._loop.run_sync(self._socket.read_message, PATIENCE_S))
            if answer.get("id") == self._number:
                return answer.get("result", answer)
            self.events.append(answer)

    def value(self, code: str) -> Any:
        """Value of an expression in the page, or of its promise."""
        found = self.call(
            "Runtime.evaluate", expression=code, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def wait(self, code: str) -> Any:
        """Wait until an expression is true."""
        end = time.monotonic() + PATIENCE_S
        while not (found := self.value(code)):
            assert time.monotonic() < end, code
            time.sleep(0.02)
        return found

    def open(self, url: str, ready: str) -> None:
        """Open a page and wait until an expression is true."""
        self.call("Page.navigate", url=url)
        self.wait("document.readyState === 'complete'")
        self.value(DEEP)
        self.wait(ready)

    def requests(self) -> set[str]:
        """Requested addresses outside the page."""
        self.value("1")
        asked = (e["params"] for e in self.events if e["method"] == "Network.requestWillBeSent")
        urls = {one["request"]["url"] for one in asked}
        sockets = {e["params"]["url"] for e in self.events
                   if e["method"] == "Network.webSocketCreated"}  # fmt: skip
        return {url for url in urls | sockets if not url.startswith(("data:", "about:", "blob:"))}

    def failures(self) -> list[Any]:
        """Errors of scripts."""
        consoles = ("Runtime.consoleAPICalled", "error")
        return [
            event
            for event in self.events
            if event["method"] == "Runtime.exceptionThrown"
            or (event["method"], event["params"].get("type")) == consoles
        ]

    def picture(self, path: Path, *, whole: bool = True) -> None:
        """Write a picture of the page, or of its window."""
        found = self.call("Page.captureScreenshot", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(found["data"]))

"""The command explore: a page whose sliders change a scene."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from flankload.cli.outputs import refuse
from flankload.cli.settings import scene_of
from flankload.errors import OtherProgramError

if TYPE_CHECKING:
    from argparse import Namespace

#: Largest number of a port.
LAST_PORT = 65535


def explore(arguments: Namespace) -> None:
    """Print the address of the page; end when the page is closed, or by Ctrl-C."""
    if not 0 <= arguments.port <= LAST_PORT:
        refuse("--port", f"a number from 0 to {LAST_PORT}", arguments.port)
    scene = scene_of(arguments)
    from flankload.api import explore as explore_of

    try:
        explorer = explore_of(scene, arguments.vary, open_browser=False, port=arguments.port)
    except ImportError as error:
        raise OtherProgramError(str(error)) from None
    except OSError as error:
        refuse("--port", "a port that is free", f"{arguments.port}: {error.strerror}")
    with explorer, suppress(KeyboardInterrupt):
        print(explorer.url, flush=True)
        if not arguments.no_browser:
            import webbrowser

            webbrowser.open(explorer.url)
        explorer.wait()

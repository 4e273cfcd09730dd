"""The explorer: a page in the browser whose sliders change a scene while its results follow.

Keys of the schema → sliders → runs (the newest request cancels the older) → curves of the result →
page. The server is Bokeh's, behind a gate; the page belongs to one explorer and its token.
"""

from flankload.explorer.explorer import Explorer

__all__ = ["Explorer"]

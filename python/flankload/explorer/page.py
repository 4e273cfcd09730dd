"""A page of an explorer: its widgets and pictures, and what they show of an answer.

The page acknowledges each answer when it is painted; until then only the newest one waits, so that
pictures never follow the hand by more than one answer.
"""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from bokeh.layouts import column, row
from bokeh.models import ColumnDataSource, CustomJS, InlineStyleSheet
from bokeh.models.widgets.buttons import Button, Toggle
from bokeh.models.widgets.inputs import Select, Spinner
from bokeh.models.widgets.markups import Div
from bokeh.models.widgets.sliders import Slider

from flankload.explorer import tables
from flankload.explorer.bodies import Window, position_at, window_of
from flankload.explorer.curves import curves_of, maps_of
from flankload.explorer.pictures import Bodies, Trail, pictures
from flankload.mechanisms.stage_clock import ELEMENTS

if TYPE_CHECKING:
    from bokeh.document import Document
    from bokeh.model import Model

    from flankload.explorer.explorer import Explorer
    from flankload.explorer.keys import Key
    from flankload.explorer.worker import Answer
    from flankload.result import Result

#: Milliseconds between two positions while the bodies turn.
PLAY_MS = 150
#: Margin of a slider, pixels: its handle is beyond both ends by half.
HANDLE = (5, 14, 5, 14)
#: Steps of the slider of the position.
PLACES = 64
#: Changes of models and texts, all in one message: each message of its own would be a task of the
#: browser. Its number is returned when they are painted.
RECEIVE = """
const {number, moves, changes, texts} = sent.data;
for (const [id, properties] of changes[0]) {
  // a range is drawn with its data; a signal of its own would draw all layers once more
  const silent = moves[0] && "reset_end" in properties;
  sent.document.get_model_by_id(id).setv(properties, {sync: false, silent});
}
for (const [id, text] of texts[0]) {
  document.getElementById(id).innerHTML = text;
}
requestAnimationFrame(() => setTimeout(() => {
  window.flankload_painted = number[0];
  painted.data = {number: [number[0]]};
}, 0));
"""
COPY = """
fetch("scene.toml", {cache: "no-store"}).then(answer => answer.text()).then(text => {
  window.flankload_copied = text;
  return navigator.clipboard.writeText(text);
}).then(() => {
  cb_obj.label = "copied";
  setTimeout(() => { cb_obj.label = "copy scene"; }, 1500);
}).catch(() => window.open("scene.toml"));
"""


class Page:
    """One page in a browser; all methods run in the thread of the server, those with `soon` in any.

    Parameters
    ----------
    explorer : Explorer
    document : bokeh.document.Document
    """

    def __init__(self, explorer: Explorer, document: Document) -> None:
        self._explorer, self._document = explorer, document
        self._sheet = InlineStyleSheet(css=_text("widgets.css"))
        self._values: dict[str, float] = {}
        self._inputs: dict[str, tuple[Slider, Spinner, Div]] = {}
        self._setting = self._open = True
        self._newest = self._painted_number = self._sent = 0
        self._waiting: Answer | None = None
        self._shown: Answer | None = None
        self._pinned: Answer | None = None
        self._window: Window | None = None
        self._derived: Answer | None = None
        self._changes, self._texts = dict[str, dict[str, Any]](), {"progress": "elements …"}
        self._pictures = pictures(self._change)
        self._bodies, self._trail = Bodies(self._change), Trail(self._change, self._go)
        self._message, painted = ColumnDataSource(), ColumnDataSource({"number": [0]})
        receive = CustomJS(args={"sent": self._message, "painted": painted}, code=RECEIVE)
        self._message.js_on_change("data", receive)
        document.js_on_event("document_ready", receive)
        painted.on_change("data", self._on_painted)
        document.add_root(self._named("keys", column(
            *(self._key(key) for key in explorer.shown), self._more(), sizing_mode="stretch_width",
        )))  # fmt: skip
        buttons = self._named("buttons", self._buttons())
        buttons.tags = [self._message, painted]  # parts of the document
        document.add_root(buttons)
        for name, picture in self._pictures.items():
            document.add_root(self._named(name, picture.figure))
        document.add_root(self._named("bodies", self._turning()))
        document.add_root(self._named("trail", self._trail_column()))
        document.template = _text("page.html")
        document.template_variables.update(
            name=explorer.scene.name, style=_text("style.css"), pictures=list(self._pictures)
        )
        document.title = f"{explorer.scene.name} · flankload"
        document.on_session_destroyed(self._left)
        self._setting = False
        self.mark()

    # --- answers ----------------------------------------------------------------------------------
    def take_soon(self, answer: Answer) -> None:
        """Show an answer, from another thread."""
        self._soon(partial(self.take, answer))

    def progress(self, stage: str, done: int, total: int) -> None:
        """Show the progress of long work, from another thread."""
        if stage.startswith(ELEMENTS) or stage in ("optimise", "plan"):
            self._soon(partial(self._show_progress, stage, done, total))

    def take(self, answer: Answer) -> None:
        """Show an answer, unless a newer one is shown; later if the page is still painting."""
        number = answer.request.number
        if number < self._newest:
            return
        self._newest = number
        if answer.result is None and not answer.error:
            self._derived = answer
            self.mark()
        elif self._painted_number < self._sent:
            self._waiting = answer
        else:
            self._show(answer)

    def mark(self) -> None:
        """Mark the keys that reach the elements: their sliders act when they are released."""
        derived = self._derived
        current = derived is not None and derived.request.number >= self._newest
        found = derived.sensitivity if derived is not None and current else None
        effects = tables.effects(self._explorer.keys, self._select.value, found)
        for path, (_, _, name) in self._inputs.items():
            key, reaching = self._explorer.keys[path], path in self._explorer.reaching
            text = tables.key_name(key, effects.get(path, ("", 0.0)), reaching=reaching)
            self._change(name, text=text)
        self._send(progress="")

    def _change(self, model: Model, **properties: Any) -> None:
        """Change properties of a model with the next message."""
        self._changes.setdefault(model.id, {}).update(properties)

    def _send(self, **texts: str) -> None:
        """Send all changes and texts of elements that are not known to be painted."""
        self._texts |= texts
        self._sent += 1
        changes, shown = list(self._changes.items()), list(self._texts.items())
        moves = self._shown is not None and not self._shown.at_rest
        self._message.data = {"number": [self._sent], "moves": [moves], "changes": [changes],
                              "texts": [shown]}  # fmt: skip

    def _on_painted(self, attr: str, old: Any, new: Any) -> None:
        self._painted_number = max(self._painted_number, int(new["number"][0]))
        if self._painted_number == self._sent:
            self._changes, self._texts = {}, {}
        if (answer := self._waiting) is not None:
            self._waiting = None
            self._show(answer)

    def _show(self, answer: Answer) -> None:
        """Show an answer: everything of it at once."""
        self._shown = answer
        if answer.request.source is not self:
            self._set_values(answer)
        if answer.at_rest and answer.result is not None and self._pinned is None:
            self._pin()
        self._draw(answer.result)
        if answer.at_rest and answer.result is not None:
            self._trail.show(self._explorer.trail, self._select.value, self._against.value)
        self._send(status=tables.status(answer), progress="", figures=self._figures())

    def _draw(self, result: Result | None) -> None:
        """Pictures and figures of a result; nothing of an older one remains."""
        columns = {} if result is None else {**curves_of(result), **maps_of(result)}
        for name, picture in self._pictures.items():
            picture.show(columns.get(name), result)
        if result is not None:
            assert self._shown is not None
            if self._shown.at_rest or self._window is None:
                self._window = window_of(result)
            self._offer(result)
        self._draw_bodies()

    def _figures(self) -> str:
        """The table of the key figures."""
        result = self._shown.result if self._shown else None
        return tables.figures(result, self._pinned.result if self._pinned else None)

    def _draw_bodies(self) -> None:
        result = self._shown.result if self._shown else None
        if result is None or self._window is None:
            self._bodies.clear()
            return
        self._bodies.show(result, position_at(result, self._place.value / PLACES), self._window)

    def _offer(self, result: Result) -> None:
        """Figures that the result has, to choose from."""
        known: list[Any] = tables.choices(result)
        if known != self._select.options:
            self._select.options = self._against.options = known
            names = [name for name, _ in known]
            if self._select.value not in names and names:
                self._select.value, self._against.value = names[0], names[min(2, len(names) - 1)]

    def _set_values(self, answer: Answer) -> None:
        """Sliders at the values of a design that the page did not ask for."""
        self._setting = True
        self._values = dict(answer.request.values)
        for path, (slider, spinner, _) in self._inputs.items():
            value = self._values.get(path, self._explorer.keys[path].value)
            slider.start, slider.end = min(slider.start, value), max(slider.end, value)
            slider.value = spinner.value = value
        self._setting = False

    def _show_progress(self, stage: str, done: int, total: int) -> None:
        words = "elements" if stage.startswith(ELEMENTS) else stage
        self._send(progress=f"{escape(words)}: {100 * done // max(total, 1)} %")

    # --- widgets ----------------------------------------------------------------------------------
    def _key(self, key: Key) -> Any:
        """Slider, typed value and reset of a key, below its name."""
        styles = [self._sheet]
        name = Div(stylesheets=styles, sizing_mode="stretch_width")
        slider = Slider(
            start=key.low, end=key.high, step=key.step, value=key.value, show_value=False,
            title=None, stylesheets=styles, sizing_mode="stretch_width", tooltips=False,
            margin=HANDLE,
        )  # fmt: skip
        spinner = Spinner(value=key.value, step=key.step, width=90, stylesheets=styles)
        reset = Button(label="↺", width=32, stylesheets=styles)
        for one, other in ((slider, spinner), (spinner, slider)):
            code = "if (this.value != null) other.value = this.value"
            one.js_on_change("value", CustomJS(args={"other": other}, code=code))
        self._inputs[key.path] = (slider, spinner, name)
        spinner.on_change("value", partial(self._on_value, key.path))
        for one in (slider, spinner):
            one.on_change("value_throttled", partial(self._on_release, key.path))
        reset.on_click(partial(self._reset, key.path))
        inputs = row(slider, spinner, reset, sizing_mode="stretch_width")
        return column(name, inputs, sizing_mode="stretch_width")

    def _more(self) -> Select:
        """A key that has no slider yet."""
        others: list[Any] = [("", "another key …")]
        others += [(path, f"{key.name}, {key.unit}") for path, key in self._explorer.keys.items()]
        more = Select(options=others, stylesheets=[self._sheet], sizing_mode="stretch_width")
        more.on_change("value", self._on_more)
        return more

    def _buttons(self) -> Any:
        made = {}
        for label, action in (
            ("pin", self._pin_shown), ("undo", self._explorer.undo), ("optimise", self._optimise),
            ("copy scene", None), ("report", None), ("close", self._explorer.close_soon),
        ):  # fmt: skip
            made[label] = Button(label=label, name=label, stylesheets=[self._sheet])
            if action is not None:
                made[label].on_click(action)
        made["copy scene"].js_on_click(CustomJS(code=COPY))
        made["report"].js_on_click(CustomJS(code='window.open("report")'))
        return row(*made.values(), styles={"flex-wrap": "wrap"})

    def _turning(self) -> Any:
        """The bodies with the slider of their position."""
        self._place = Slider(start=0, end=PLACES - 1, value=0, step=1, title=None, show_value=False,
                             tooltips=False, margin=HANDLE, stylesheets=[self._sheet],
                             name="position", sizing_mode="stretch_width")  # fmt: skip
        self._place.on_change("value", self._on_place)
        play = Toggle(label="▶", width=40, stylesheets=[self._sheet], name="play")
        play.on_change("active", self._on_play)
        line = row(play, self._place, sizing_mode="stretch_width")
        return column(self._bodies.figure, line, sizing_mode="stretch_width")

    def _trail_column(self) -> Any:
        options: dict[str, Any] = {
            "stylesheets": [self._sheet],
            "sizing_mode": "stretch_width",
        }
        self._select = Select(title="figure", name="figure", **options)
        self._against = Select(title="and", name="against", **options)
        for select in (self._select, self._against):
            select.on_change("value", self._on_figure)
        line = row(self._select, self._against, sizing_mode="stretch_width")
        return column(self._trail.figure, line, sizing_mode="stretch_width")

    # --- events -----------------------------------------------------------------------------------
    def _on_value(self, path: str, attr: str, old: Any, new: Any) -> None:
        if path not in self._explorer.reaching:
            self._ask(path, new, moves=True)

    def _on_release(self, path: str, attr: str, old: Any, new: Any) -> None:
        if path in self._explorer.reaching:
            self._ask(path, new, moves=False)

    def _ask(self, path: str, value: Any, *, moves: bool) -> None:
        if self._setting or value is None or isinstance(value, str):
            return
        number = self._explorer.keys[path].number(value) if value == value else value
        if self._values.get(path, self._explorer.keys[path].value) != number:
            self._values[path] = number
            self._explorer.ask(self._values, moves=moves, source=self)

    def _reset(self, path: str) -> None:
        self._values.pop(path, None)
        self._explorer.ask(self._values)

    def _on_more(self, attr: str, old: Any, new: str) -> None:
        if new and new not in self._inputs:
            keys = self._document.get_model_by_name("keys")
            assert keys is not None
            keys.children.insert(-1, self._key(self._explorer.keys[new]))
            self.mark()

    def _on_place(self, attr: str, old: Any, new: Any) -> None:
        self._draw_bodies()
        self._send()

    def _on_figure(self, attr: str, old: Any, new: str) -> None:
        self._trail.show(self._explorer.trail, self._select.value, self._against.value)
        self.mark()

    def _on_play(self, attr: str, old: Any, new: bool) -> None:
        if new:
            self._turn = self._document.add_periodic_callback(self._next_place, PLAY_MS)
        else:
            self._document.remove_periodic_callback(self._turn)

    def _next_place(self) -> None:
        self._place.value = (self._place.value + 1) % PLACES

    def _pin_shown(self) -> None:
        if self._shown is not None and self._shown.result is not None:
            self._pin()
            self._draw(self._shown.result)
            self._send(figures=self._figures())

    def _pin(self) -> None:
        """Keep the curves that are shown behind those to come."""
        assert self._shown is not None
        assert self._shown.result is not None
        self._pinned = self._shown
        for name, columns in curves_of(self._shown.result).items():
            self._pictures[name].pin(columns)

    def _optimise(self) -> None:
        if not self._select.value:
            return
        self._explorer.optimise(self._select.value).add_done_callback(self._optimised)

    def _optimised(self, future: Any) -> None:
        if not future.cancelled() and (error := future.exception()) is not None:
            line = f'<span class="line">{escape(f"optimise: {error}")}</span>'
            self._soon(partial(self._send, progress=line))

    def _go(self, values: dict[str, float]) -> None:
        """Go to a design of the trail."""
        self._explorer.ask(values)

    def _left(self, session: Any) -> None:
        self._open = False
        self._explorer.leave(self)

    def _soon(self, call: Any) -> None:
        if self._open:
            with suppress(AttributeError):  # of a document that is destroyed, before `_left`
                self._document.add_next_tick_callback(call)

    def _named(self, name: str, model: Any) -> Any:
        model.name = name
        return model


def _text(name: str) -> str:
    return files("flankload.explorer").joinpath(name).read_text(encoding="utf-8")

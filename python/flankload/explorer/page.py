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
from flankload.explorer.bodies import drawing_of, windows_of
from flankload.explorer.curves import curves_of, maps_of
from flankload.explorer.pictures import PICTURES, Picture, Trail
from flankload.mechanisms.stage_clock import ELEMENTS

if TYPE_CHECKING:
    from bokeh.document import Document
    from bokeh.model import Model

    from flankload.explorer.explorer import Explorer
    from flankload.explorer.keys import Key
    from flankload.explorer.worker import Answer
    from flankload.result import Result

#: Margin of a slider, pixels: its handle is beyond both ends by half.
HANDLE = (5, 14, 5, 14)
#: Steps of the slider of the position.
PLACES = 64


class Page:
    """One page in a browser; all methods run in the thread of the server, but for `take_soon`.

    Parameters
    ----------
    explorer : Explorer
    document : bokeh.document.Document
    """

    def __init__(self, explorer: Explorer, document: Document) -> None:
        self._explorer, self._document = explorer, document
        self._look: dict[str, Any] = {"stylesheets": [InlineStyleSheet(css=_text("widgets.css"))]}
        self._wide = {**self._look, "sizing_mode": "stretch_width"}
        self._values: dict[str, float] = {}
        self._inputs: dict[str, tuple[Slider, Spinner, Div]] = {}
        self._setting = self._open = True
        self._newest = self._painted_number = self._sent = 0
        self._windows: tuple[Any, ...] = ()
        self._waiting: Answer | None = None
        self._shown: Answer | None = None
        self._pinned: Answer | None = None
        self._derived: Answer | None = None
        self._changes, self._texts = dict[str, dict[str, Any]](), {"progress": "elements …"}
        self._pictures = {name: Picture(name, self._change) for name in PICTURES}
        self._trail = Trail(self._change, explorer.ask)
        self._message, painted = ColumnDataSource(), ColumnDataSource({"number": [0]})
        receive = CustomJS(
            args={"sent": self._message, "painted": painted},
            code="flankload.receive(sent, painted)",
        )
        self._message.js_on_change("data", receive)
        document.js_on_event("document_ready", receive)
        painted.on_change("data", self._on_painted)
        document.js_on_event("connection_lost", CustomJS(code="flankload.end()"))
        roots = {
            "keys": _column(*(self._key(key) for key in explorer.shown), self._more()),
            "buttons": self._buttons(),
            **{name: picture.figure for name, picture in self._pictures.items()},
            "turning": self._turning(),
            "trail": _column(self._trail.figure, self._choice()),
        }
        for name, root in roots.items():
            root.name = name
            document.add_root(root)
        roots["buttons"].tags = [self._message, painted]  # parts of the document
        document.template = _text("page.html")
        document.template_variables.update(
            name=explorer.scene.name, style=_text("style.css"), pictures=list(self._pictures)
        )
        document.title = f"{explorer.scene.name} · flankload"
        document.on_session_destroyed(self._left)
        self._setting = False
        self._mark()

    # --- answers ----------------------------------------------------------------------------------
    def take_soon(self, answer: Answer) -> None:
        """Show an answer, from another thread."""
        self._soon(partial(self.take, answer))

    def progress(self, stage: str, done: int, total: int) -> None:
        """Show the progress of long work, from another thread."""
        if stage.startswith(ELEMENTS) or stage in ("optimise", "plan"):
            words = "elements" if stage.startswith(ELEMENTS) else stage
            text = f"{escape(words)}: {100 * done // max(total, 1)} %"
            self._soon(partial(self._send, progress=text))

    def take(self, answer: Answer) -> None:
        """Show an answer, unless a newer one is shown; later if the page is still painting."""
        number = answer.request.number
        if number < self._newest:
            return
        self._newest = number
        if answer.result is None and not answer.error:
            self._derived = answer
            self._mark()
        elif self._painted_number < self._sent:
            self._waiting = answer
        else:
            self._show(answer)

    def _mark(self) -> None:
        """Show which keys reach the elements, and by how much each one changes the figure."""
        derived = self._derived
        current = derived is not None and derived.request.number >= self._newest
        found = derived.sensitivity if derived is not None and current else None
        effects = tables.effects(self._explorer.keys, self._select.value, found)
        for path, (_, _, name) in self._inputs.items():
            key, reaching = self._explorer.keys[path], path in self._explorer.worker.reaching
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
        if answer.at_rest and answer.result is not None:
            self._offer(answer.result)
            self._trail.show(self._explorer.trail, self._select.value, self._against.value)
            if self._pinned is None:
                self._pin()
        self._draw(answer, status=tables.status(answer), progress="")

    def _draw(self, answer: Answer, **texts: str) -> None:
        """Pictures and figures of an answer; nothing of an older one remains."""
        result = answer.result
        columns = {} if result is None else {**curves_of(result), **maps_of(result)}
        for name, picture in self._pictures.items():
            picture.show(columns.get(name), result)
        if result is not None and (answer.at_rest or not self._windows):
            self._windows = windows_of(result)  # fixed while a key moves
        pinned = self._pinned.result if self._pinned else None
        self._send(figures=tables.figures(result, pinned), bodies=self._drawing(), **texts)

    def _drawing(self) -> str:
        """The bodies at the position of the slider."""
        assert self._shown is not None
        return drawing_of(self._shown.result, self._place.value / PLACES, self._windows)

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

    # --- widgets ----------------------------------------------------------------------------------
    def _key(self, key: Key) -> Any:
        """Slider, typed value and reset of a key, below its name."""
        name = Div(**self._wide)
        slider = self._slider(key.name, key.low, key.high, key.step, key.value)
        spinner = Spinner(value=key.value, step=key.step, width=90, **self._named(key.name))
        reset = Button(label="↺", width=32, **self._named(f"reset {key.name}"))
        for one, other in ((slider, spinner), (spinner, slider)):
            code = "if (this.value != null) other.value = this.value"
            one.js_on_change("value", CustomJS(args={"other": other}, code=code))
            one.on_change("value_throttled", partial(self._on_value, key.path, released=True))
        self._inputs[key.path] = (slider, spinner, name)
        spinner.on_change("value", partial(self._on_value, key.path, released=False))
        reset.on_click(partial(self._reset, key.path))
        return _column(name, _row(slider, spinner, reset))

    def _slider(self, name: str, low: float, high: float, step: float, value: float) -> Slider:
        return Slider(start=low, end=high, step=step, value=value, show_value=False, title=None,
                      tooltips=False, margin=HANDLE, sizing_mode="stretch_width",
                      **self._named(name))  # fmt: skip

    def _named(self, name: str) -> dict[str, Any]:
        """Look and accessible name of a widget without a label."""
        return {**self._look, "html_attributes": {"role": "group", "aria-label": name}}

    def _more(self) -> Select:
        """A key that has no slider yet."""
        others: list[Any] = [("", "another key …")]
        keys = self._explorer.keys.values()
        others += [(key.path, key.name) for key in keys if not key.is_entry]
        more = Select(options=others, sizing_mode="stretch_width", **self._named("another key"))
        more.on_change("value", self._on_more)
        return more

    def _buttons(self) -> Any:
        actions = {
            "pin": self._on_pin, "undo": self._explorer.undo, "optimise": self._on_optimise,
            "copy scene": CustomJS(code="flankload.copy(cb_obj.origin)"),
            "report": CustomJS(code='window.open("report")'), "close": self._explorer.close_soon,
        }  # fmt: skip
        if not self._explorer.worker.has_elements:
            del actions["optimise"]
        made = [Button(label=label, name=label, **self._look) for label in actions]
        for button, action in zip(made, actions.values(), strict=True):
            listen = button.js_on_click if isinstance(action, CustomJS) else button.on_click
            listen(action)
        return row(*made, styles={"flex-wrap": "wrap"})

    def _turning(self) -> Any:
        """The slider of the position of the bodies."""
        self._place = self._slider("position", 0, PLACES - 1, 1, 0)
        self._place.on_change("value", self._on_place)
        play = Toggle(label="▶", width=40, **self._named("turn the bodies"))
        play.js_on_change(
            "active", CustomJS(args={"place": self._place}, code="flankload.play(this, place)")
        )
        return _row(play, self._place)

    def _choice(self) -> Any:
        """The choice of two figures."""
        self._select, self._against = (Select(title=one, **self._wide) for one in ("figure", "and"))
        for select in (self._select, self._against):
            select.on_change("value", self._on_figure)
        return _row(self._select, self._against)

    # --- events -----------------------------------------------------------------------------------
    def _on_value(self, path: str, attr: str, old: Any, new: Any, *, released: bool) -> None:
        """A value of a key; those that reach the elements act when they are released."""
        reaching = path in self._explorer.worker.reaching
        if self._setting or released != reaching or not isinstance(new, int | float):
            return
        number = self._explorer.keys[path].number(new) if new == new else new
        if self._values.get(path, self._explorer.keys[path].value) != number:
            self._values[path] = number
            self._explorer.ask(self._values, moves=not released, source=self)

    def _reset(self, path: str) -> None:
        self._values.pop(path, None)
        self._explorer.ask(self._values)

    def _on_more(self, attr: str, old: Any, new: str) -> None:
        if new and new not in self._inputs:
            keys = self._document.get_model_by_name("keys")
            assert keys is not None
            keys.children.insert(-1, self._key(self._explorer.keys[new]))
            self._mark()

    def _on_place(self, attr: str, old: Any, new: int) -> None:
        if self._shown is not None:
            self._send(bodies=self._drawing())

    def _on_figure(self, attr: str, old: Any, new: str) -> None:
        self._trail.show(self._explorer.trail, self._select.value, self._against.value)
        self._mark()

    def _on_pin(self) -> None:
        if self._shown is not None and self._shown.result is not None:
            self._pin()
            self._draw(self._shown)

    def _pin(self) -> None:
        """Keep the curves that are shown behind those to come."""
        assert self._shown is not None
        assert self._shown.result is not None
        self._pinned = self._shown
        for name, columns in curves_of(self._shown.result).items():
            self._pictures[name].pin(columns)

    def _on_optimise(self) -> None:
        if self._select.value:
            self._explorer.optimise(self._select.value).add_done_callback(self._optimised)

    def _optimised(self, future: Any) -> None:
        if not future.cancelled() and (error := future.exception()) is not None:
            line = f'<span class="line">{escape(f"optimise: {error}")}</span>'
            self._soon(partial(self._send, progress=line))

    def _left(self, session: Any) -> None:
        self._open = False
        self._explorer.leave(self)

    def _soon(self, call: Any) -> None:
        if self._open:
            with suppress(AttributeError):  # of a document that is destroyed, before `_left`
                self._document.add_next_tick_callback(call)


def _column(*children: Any) -> Any:
    return column(*children, sizing_mode="stretch_width")


def _row(*children: Any) -> Any:
    return row(*children, sizing_mode="stretch_width")


def _text(name: str) -> str:
    return files("flankload.explorer").joinpath(name).read_text(encoding="utf-8")

"""Progress of long work, on the terminal or in a notebook; nothing elsewhere, and nothing for work shorter than a second."""

from __future__ import annotations

import html
import sys
import time
from types import TracebackType
from typing import Any

# Time before anything is shown, between two drawings, and between two lines where there is no terminal; s.
_PATIENCE = 1.0
_REDRAW = 0.25
_LINES = 10.0

_WIDTH = 30


class Progress:
    """A progress bar for `what`, with the remaining time if `total` is known. Call it with the number of steps done; it disappears at the end.

    `wanted`: None shows the bar on a terminal and in a notebook, True also elsewhere as lines on stderr, False nowhere.
    """

    def __init__(self, what: str, total: int | None = None, wanted: bool | None = None) -> None:
        self.what = what
        self.total = total
        self._notebook = _in_notebook()
        self._terminal = sys.stderr is not None and sys.stderr.isatty()
        self._shown = (self._notebook or self._terminal) if wanted is None else wanted
        self._began = time.monotonic()
        self._drawn = self._began + _PATIENCE - _REDRAW
        self._base = self._done = 0
        self._handle: Any = None

    def __call__(self, done: int) -> None:
        self._done = self._base + done
        now = time.monotonic()
        pause = _REDRAW if self._notebook or self._terminal else _LINES
        if self._shown and now - self._drawn >= pause:
            self._drawn = now
            self._draw()

    def settle(self) -> None:
        """Count further calls from the steps done so far."""
        self._base = self._done

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._handle is not None:
            self._handle.update(_Html(""))
        elif self._terminal and self._shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    def _draw(self) -> None:
        if self._notebook:
            self._draw_in_notebook()
            return
        line = self._text(_bar(self._done, self.total))
        ends = {"end": ""} if self._terminal else {}
        print(f"\r\x1b[K{line}" if self._terminal else line, file=sys.stderr, flush=True, **ends)

    def _draw_in_notebook(self) -> None:
        from IPython.display import display

        of = "" if self.total is None else f' value="{self._done}" max="{self.total}"'
        shown = _Html(f"<progress{of}></progress> {html.escape(self._text(''))}")
        if self._handle is None:
            self._handle = display(shown, display_id=True)
        else:
            self._handle.update(shown)

    def _text(self, bar: str) -> str:
        passed = time.monotonic() - self._began
        if self.total is None:
            return f"{self.what}: {passed:.0f} s"
        left = f", {passed / self._done * (self.total - self._done):.0f} s left" if self._done else ""
        return f"{self.what} {bar}{self._done}/{self.total}{left}"


class _Html:
    """A piece of HTML."""

    def __init__(self, text: str) -> None:
        self._text = text

    def _repr_html_(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return ""


def _bar(done: int, total: int | None) -> str:
    if not total:
        return ""
    full = _WIDTH * min(done, total) // total
    return f"[{'#' * full}{'.' * (_WIDTH - full)}] "


def _in_notebook() -> bool:
    shell = sys.modules.get("IPython")
    running = shell.get_ipython() if shell is not None else None
    return type(running).__name__ == "ZMQInteractiveShell"

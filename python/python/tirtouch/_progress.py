"""A bar for ``progress=True``."""

from __future__ import annotations

from typing import Any


class Bar:
    """Shows how far the work is; nothing where tqdm is not installed."""

    def __init__(self) -> None:
        self._bar: Any = None
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return
        self._bar = tqdm(total=1.0, bar_format="{l_bar}{bar}| {elapsed}<{remaining}")

    def __call__(self, what: str, done: float) -> None:
        """Shows the share ``done`` (0 to 1) of ``what``."""
        if self._bar is not None:
            self._bar.set_description(what, refresh=False)
            # One piece of work follows another, each from 0.
            self._bar.n = done
            self._bar.refresh()

    def close(self) -> None:
        """Ends the bar."""
        if self._bar is not None:
            self._bar.close()

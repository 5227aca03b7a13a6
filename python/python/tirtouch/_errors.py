"""Exceptions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._tirtouch import Press


class TirtouchError(Exception):
    """What went wrong, in one line: what, where, and what would be right.

    ``file``, ``line`` (from 1) and ``key`` say where, each None where that is unknown or makes no sense. ``others`` are
    the other mistakes of a file that has several, a line each.
    """

    file: str | None
    """The file that is to blame."""
    line: int | None
    """Its line, from 1."""
    key: str | None
    """The key of the scene or sweep that is to blame."""
    others: tuple[str, ...]
    """The other mistakes of the file, a line each."""

    def __init__(
        self,
        message: str,
        file: str | None = None,
        line: int | None = None,
        key: str | None = None,
        others: tuple[str, ...] = (),
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.key = key
        self.others = others


class SceneError(TirtouchError):
    """A scene that cannot be used: its text, its keys, a file that it names, or a press that cannot be computed.

    So is a file of a sweep or of a calibration that cannot be used.
    """


class PressError(TirtouchError):
    """A press that stopped early. ``reached`` is the press with the loads before; pickled, it is None."""

    reached: Press | None
    """The press with the loads before the one that failed; None where it was pickled."""

    def __init__(self, message: str, reached: Press | None = None, **place: Any) -> None:
        super().__init__(message, **place)
        self.reached = reached

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"reached": None}

    def __reduce__(self) -> tuple[Any, ...]:
        # BaseException takes all of __dict__ with it.
        return type(self), self.args, self.__getstate__()


class DeviceError(TirtouchError):
    """What computes is to blame: no adapter, a lost device, too little of its memory, a driver that refuses."""


class Stopped(TirtouchError):
    """The caller's ``progress`` returned False."""

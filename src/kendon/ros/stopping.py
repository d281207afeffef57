"""Ctrl-C and SIGTERM: the first one asks to end in order, a later one ends at once."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Self

#: Launchers and terminals each send one when somebody presses Ctrl-C once: so soon after the first,
#: another one is the same [s].
_SAME = 1.0


class Stopping:
    """Takes the signals while it is entered; the step in hand is finished.

    Args:
        ask: called at the first signal, in its handler.

    Raises:
        KeyboardInterrupt: at a second signal, wherever the process is.
    """

    def __init__(self, ask: Callable[[], None] = lambda: None) -> None:
        self._ask = ask
        self._asked: float | None = None  # [s], when
        self._before: dict[int, Any] = {}

    @property
    def asked(self) -> bool:
        """Whether the process is to end."""
        return self._asked is not None

    def __enter__(self) -> Self:
        """Take the signals."""
        for number in (signal.SIGINT, signal.SIGTERM):  # launchers send both
            self._before[number] = signal.signal(number, self._take)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Give them back."""
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _take(self, number: int, frame: FrameType | None) -> None:
        del number, frame
        now = time.monotonic()
        if self._asked is None:
            self._asked = now
            self._ask()
        elif now - self._asked > _SAME:
            raise KeyboardInterrupt

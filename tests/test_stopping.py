"""Signals that ask a node to end."""

from __future__ import annotations

import os
import signal
import time

import pytest

from kendon.ros.stopping import Stopping


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_signal_asks_and_a_later_one_ends(
    number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    before, asked = signal.getsignal(number), []
    with Stopping(lambda: asked.append(clock[0])) as stop:
        assert not stop.asked
        for after in (0.0, 0.01, 0.5):  # a terminal and a launcher both send it
            clock[0] = 100.0 + after
            os.kill(os.getpid(), number)
        assert stop.asked
        assert asked == [100.0]
        clock[0] = 102.0
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), number)
    assert signal.getsignal(number) is before

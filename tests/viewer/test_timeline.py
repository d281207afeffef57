"""The lines of an encounter in the terminal."""

from __future__ import annotations

import io
import itertools
import math
import re
from collections.abc import Sequence

import numpy as np
import pytest
from rich.console import Console

from kendon.geometry import ORIGIN
from kendon.greeter import Greeter, Moment
from kendon.models import Belief, load_model
from kendon.observations import Observation
from kendon.phases import Phase
from kendon.robots import PointRobot
from kendon.sources import open_source
from kendon.viewer.timeline import Timeline

#: The numbers of a person who stands three metres away.
STANDS = (3.0, 0.0, 1.0, 1.0)


def _told(numbers: Sequence[Sequence[float]], phases: list[Phase]) -> list[float]:
    """When a line is printed of observations like these, five a second [s]."""
    console = Console(file=io.StringIO(), width=120)
    timeline = Timeline(console)
    for i, ((distance, speed, gaze, smile), phase) in enumerate(zip(numbers, phases, strict=True)):
        seen = Observation(0.2 * (i + 1), distance, speed, gaze, smile)
        belief = Belief(np.array([float(p is phase) for p in Phase]))
        timeline.show(Moment(seen.t, None, seen, belief, True, ORIGIN, (), 1.0))
    assert isinstance(console.file, io.StringIO)
    return [float(line.split()[0]) for line in console.file.getvalue().splitlines()]


def test_what_stays_the_same_is_told_once_a_second() -> None:
    assert _told([STANDS] * 12, [Phase.IA] * 12) == [0.2, 1.2, 2.2]


def test_another_phase_is_told_at_once() -> None:
    phases = [Phase.IA] * 2 + [Phase.APP] * 2 + [Phase.IA]
    assert _told([STANDS] * 5, phases) == [0.2, 0.6, 1.0]


@pytest.mark.parametrize("column", range(4))
@pytest.mark.parametrize("change", [1.0, math.nan])
def test_what_is_seen_anew_is_told_at_once(column: int, change: float) -> None:
    changed = list(STANDS)
    changed[column] += change
    rows = [STANDS, STANDS, tuple(changed), tuple(changed), STANDS]
    assert _told(rows, [Phase.IA] * 5) == [0.2, 0.6, 1.0]


def test_a_slow_change_is_told_when_it_has_added_up() -> None:
    rows = [(3.0 - 0.13 * i, 0.0, 1.0, 1.0) for i in range(9)]
    assert _told(rows, [Phase.IA] * 9) == [0.2, 1.0, 1.8]


def test_a_greeting_is_told_with_all_phases_and_commands_and_no_more() -> None:
    console = Console(file=io.StringIO(), width=120)
    timeline = Timeline(console)
    moments = list(Greeter(open_source("simulated"), load_model("kendon"), PointRobot()).run())
    for moment in moments:
        timeline.show(moment)
    assert isinstance(console.file, io.StringIO)
    lines = console.file.getvalue().splitlines()
    assert len(lines) < sum(moment.is_new for moment in moments) / 2
    told = [re.findall(r" (IA|DS|HD|APP|FA|CS) ", line)[-1] for line in lines]
    read = [m.belief.phase.name for m in moments if m.is_new and m.belief is not None]
    assert [name for name, _ in itertools.groupby(told)] == [
        name for name, _ in itertools.groupby(read)
    ]
    for words in ("wave", "handshake", "“Pleased to meet you”"):
        assert sum(words in line for line in lines) == 1

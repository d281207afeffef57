"""Who means to greet: people whose ways are known."""

from __future__ import annotations

import math

import pytest

from kendon.models.intent import Intent
from kendon.observations import Observation


def walk(
    x: float, y: float, course: float, speed: float = 1.2, gaze: float = math.nan,
    seconds: float = 2.0, dsal: float = 0.0,
) -> float:  # fmt: skip
    """The probability after so many seconds of a straight way past a robot at the origin."""
    intent = Intent()
    for i in range(1, round(seconds * 30) + 1):
        t = i / 30
        intent.see(t, x + speed * t * math.cos(course), y + speed * t * math.sin(course))
        if i % 6 == 0:
            intent.step(Observation(t, gaze=gaze, dsal=dsal), (0.0, 0.0))
    return intent.probability


@pytest.mark.parametrize("bearing", [0.0, 1.0, -2.0])
def test_whoever_walks_straight_up_greets(bearing: float) -> None:
    x, y = 5 * math.cos(bearing), 5 * math.sin(bearing)
    assert walk(x, y, bearing + math.pi) > 0.8


@pytest.mark.parametrize("miss", [0.9, 1.5, 3.0, -2.0])
def test_whoever_walks_past_does_not(miss: float) -> None:
    assert walk(5.0, miss, math.pi) < 0.3


def test_nor_does_whoever_walks_off() -> None:
    assert walk(3.0, 0.0, 0.0) < 0.1


def test_a_person_who_stands_tells_little_but_by_looks_and_waves() -> None:
    assert walk(4.0, 0.0, 0.0, speed=0.0) == pytest.approx(0.5, abs=0.1)
    assert walk(4.0, 0.0, 0.0, speed=0.0, gaze=0.2) > 0.6
    assert walk(4.0, 0.0, 0.0, speed=0.0, gaze=1.8) < 0.4
    assert walk(4.0, 0.0, 0.0, speed=0.0, dsal=1.0) > 0.85


def test_where_the_robot_stands_matters_not_where_the_world_begins() -> None:
    def after(dx: float) -> float:
        intent = Intent()
        for i in range(1, 61):
            intent.see(i / 30, 5 + dx - 1.2 * i / 30, 0.4)
            if i % 6 == 0:
                intent.step(Observation(i / 30), (dx, 0.0))
        return intent.probability

    assert after(0.0) == pytest.approx(after(7.0))


def test_a_reset_forgets() -> None:
    intent = Intent()
    intent.step(Observation(0.2, dsal=1.0), (0.0, 0.0))
    assert intent.probability > 0.5
    intent.reset()
    assert intent.probability == pytest.approx(0.5)


def test_a_look_on_the_rim_of_the_cone_tells_nothing_however_it_is_rounded() -> None:
    on_the_rim = [
        walk(5.0, 0.0, math.pi, gaze=g) for g in (1.0, math.nextafter(1.0, 0.0), 1 + 1e-9)
    ]
    assert on_the_rim == [walk(5.0, 0.0, math.pi)] * 3
    assert walk(5.0, 0.0, math.pi, 0.1, gaze=0.9) > 0.5 > walk(5.0, 0.0, math.pi, 0.1, gaze=1.1)

"""Beats of a course, by laws that hold for any."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kendon.features.gestures.beats import LASTS, SMOOTH, beat, steps
from kendon.features.gestures.series import Series

HEIGHTS = st.floats(0.5, 20.0)


def triangle(height: float, turns: int, half: int = 2, length: int = 12) -> list[float]:
    """Level, then down to a height in so many steps and back, then level."""
    return [height * max(0.0, 1.0 - abs(step - turns) / half) for step in range(length)]


@given(HEIGHTS, st.integers(2, 9), st.sampled_from([-1.0, 1.0]), st.floats(-90.0, 90.0))
def test_a_beat_is_as_large_as_it_goes_wherever_it_lies_and_either_way(
    height: float, turns: int, sign: float, level: float
) -> None:
    found = beat([level + sign * step for step in triangle(height, turns)])
    assert found.size == pytest.approx(height, abs=1e-9)
    assert found.ago == 11 - turns


@given(st.lists(st.floats(0.0, 10.0), min_size=4, max_size=12), st.sampled_from([-1.0, 1.0]))
def test_what_goes_one_way_has_no_beat(ways: list[float], sign: float) -> None:
    assert beat((sign * np.cumsum(ways)).tolist()).size == 0.0


@given(st.lists(st.floats(-30.0, 30.0), min_size=4, max_size=12))
def test_no_beat_is_larger_than_the_course_and_a_limit_only_takes_away(course: list[float]) -> None:
    free, limited = beat(course).size, beat(course, 10.0, 10.0).size
    assert 0.0 <= free <= max(course) - min(course)
    assert limited in (0.0, free)
    assert limited <= 10.0


@given(HEIGHTS, st.integers(2, 9))
def test_what_goes_too_far_hides_what_is_beside_it(height: float, turns: int) -> None:
    assert beat(triangle(height, turns), height / 2).size == 0.0


def test_a_nod_that_stays_down_is_none_and_a_toss_may_be_held() -> None:
    held = [0.0, 4.0, 8.0, 8.0, 8.0, 8.0, 8.0, 8.0, 8.0, 4.0, 0.0]
    assert beat(held).size == 0.0
    assert beat([-step for step in held]).size == 8.0


def test_too_short_a_course_tells_nothing() -> None:
    assert math.isnan(beat([0.0, 5.0, 0.0]).size)


@pytest.mark.parametrize("rate", [10.0, 15.0, 30.0, 60.0])
def test_steps_are_the_medians_of_a_tenth_of_a_second(rate: float) -> None:
    series = Series()
    for k in range(round(3 * rate)):
        series.add(k / rate, k / rate)
    found = steps(series, 3.0)
    assert found == sorted(found)
    assert len(found) == round(LASTS / SMOOTH) + 1
    assert np.diff(found) == pytest.approx(SMOOTH, abs=0.5 / rate + 1e-9)
    assert steps(Series(), 3.0) == []

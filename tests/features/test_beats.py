"""Beats of a course, by laws that hold for any."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kendon.features.gestures.beats import (
    LASTS,
    NO_BEAT,
    NOD,
    SMOOTH,
    TOSS,
    Kind,
    beat,
    course_of,
    too_far,
)
from kendon.features.gestures.series import Series

HEIGHTS = st.floats(0.5, 20.0)


def triangle(height: float, turns: int, half: int = 2, length: int = 12) -> list[float]:
    """Level, then down to a height in so many steps and back, then level."""
    return [height * max(0.0, 1.0 - abs(step - turns) / half) for step in range(length)]


def test_a_gap_takes_its_time_and_is_bridged_in_a_straight_line() -> None:
    series, whole = Series(), Series()
    for k in range(120):
        t = k / 100
        whole.add(t, 10.0 * t)
        if not 0.5 <= t < 0.9:
            series.add(t, 10.0 * t)
    steps = course_of(series, 1.2, 0.0).steps
    np.testing.assert_allclose(steps, course_of(whole, 1.2, 0.0).steps)
    # Nothing is known of what comes after it was last seen: it stays.
    later = course_of(whole, 1.5, 0.0).steps
    assert later[-3:] == [later[-4]] * 3


@given(HEIGHTS, st.integers(2, 9), st.sampled_from([NOD, TOSS]), st.floats(-90.0, 90.0))
def test_a_beat_is_as_large_as_it_goes_wherever_it_lies_and_either_way(
    height: float, turns: int, kind: Kind, level: float
) -> None:
    found = beat([level + kind.sign * step for step in triangle(height, turns)], kind)
    assert found.size == pytest.approx(height, abs=1e-9)
    assert found.ago == 11 - turns


@given(st.lists(st.floats(0.0, 10.0), min_size=4, max_size=12), st.sampled_from([-1.0, 1.0]))
def test_what_goes_one_way_has_no_beat(ways: list[float], sign: float) -> None:
    course = (sign * np.cumsum(ways)).tolist()
    assert beat(course, NOD) == beat(course, TOSS) == NO_BEAT


@given(st.lists(st.floats(-30.0, 30.0), min_size=4, max_size=12), st.sampled_from([NOD, TOSS]))
def test_no_beat_is_larger_than_the_course_or_than_what_goes_too_far(
    course: list[float], kind: Kind
) -> None:
    found = beat(course, kind).size
    assert 0.0 <= found <= max(course) - min(course)
    assert found <= 10.0 or too_far(course, 10.0, 10.0)


@given(st.lists(st.floats(-30.0, 30.0), min_size=4, max_size=12), st.floats(-30.0, 30.0))
def test_what_goes_up_counts_as_far_as_it_comes_above_the_level(
    course: list[float], level: float
) -> None:
    found = beat(course, TOSS, level).size
    assert found <= max(0.0, level - min(course))
    # What is above the level may be short where all of it is too long for a toss.
    assert found <= beat(course, TOSS._replace(away=len(course))).size
    assert beat(course, NOD, level) == beat(course, NOD)


def test_a_nod_that_stays_down_is_none_and_a_toss_may_be_held_but_not_for_long() -> None:
    held = [0.0, 4.0, 8.0, 8.0, 8.0, 8.0, 4.0, 0.0]
    longer = [0.0, 4.0, 8.0, 8.0, 8.0, 8.0, 8.0, 8.0, 8.0, 4.0, 0.0]
    assert beat(held, NOD) == beat(longer, NOD) == NO_BEAT
    assert beat([-step for step in held], TOSS).size == 8.0
    assert beat([-step for step in longer], TOSS) == NO_BEAT


def test_too_short_a_course_tells_nothing() -> None:
    assert math.isnan(beat([0.0, 5.0, 0.0], NOD).size)


@pytest.mark.parametrize("rate", [10.0, 15.0, 30.0, 60.0])
def test_steps_are_the_medians_of_a_tenth_of_a_second(rate: float) -> None:
    series = Series()
    for k in range(round(3 * rate)):
        series.add(k / rate, k / rate)
    found, error = course_of(series, 3.0, 1.0)
    assert list(found) == sorted(found)
    assert len(found) == round(LASTS / SMOOTH) + 1
    assert np.diff(found) == pytest.approx(SMOOTH, abs=0.5 / rate + 1e-9)
    # The standard error of a median of so many independent values, which is a tenth of a second's.
    assert error == pytest.approx(1.25 * math.sqrt(1 / max(1.0, rate / 10)), rel=0.1)
    assert course_of(Series(), 3.0, 1.0).steps == []

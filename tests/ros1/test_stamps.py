from __future__ import annotations

import itertools
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kendon.sources.ros_stamps import StreamClock, seconds


def test_stamps_of_both_generations_are_seconds() -> None:
    assert seconds(SimpleNamespace(secs=3, nsecs=500_000_000)) == 3.5
    assert seconds(SimpleNamespace(sec=3, nanosec=500_000_000)) == 3.5


def test_messages_count_at_their_stamps_not_when_they_came() -> None:
    clock = StreamClock("/faces")
    times = [clock.take(stamp, now) for stamp, now in [(10.0, 10.05), (10.1, 10.4), (10.2, 10.41)]]
    assert times == [10.0, 10.1, 10.2]
    assert clock.notes == []


def test_late_messages_and_doubles_are_left_out() -> None:
    clock = StreamClock("/faces")
    stamps = [1.0, 1.2, 1.1, 1.2, 1.3]
    assert [clock.take(s, 2.0) for s in stamps] == [1.0, 1.2, None, None, 1.3]
    assert clock.late == 2
    assert clock.notes == ["Messages of /faces come late or twice; the newer ones count."]


def test_messages_without_stamps_count_as_they_come() -> None:
    clock = StreamClock("/faces")
    assert [clock.take(0.0, now) for now in (5.0, 5.5)] == [5.0, 5.5]
    assert "not stamped" in clock.notes[0]


def test_two_clocks_are_named() -> None:
    clock = StreamClock("/faces")
    for i in range(20):
        assert clock.take(100.0 + i / 10, 1.7e9 + i / 10) == 100.0 + i / 10
    assert len(clock.notes) == 1
    assert "behind this node's clock: these are two clocks (is use_sim_time" in clock.notes[0]


def test_a_clock_that_begins_again_goes_on() -> None:
    clock = StreamClock("/faces")
    for i in range(10):
        clock.take(1000 + i / 10, 1000 + i / 10)
    times = [clock.take(0.1 + i / 10, 1001 + i / 10) for i in range(5)]
    assert times[:2] == [None, None]
    assert times[2] == pytest.approx(1001.2)  # 1.3 s by the node's clock after 1000.9 came ...
    assert times[4] == pytest.approx(1001.4)
    assert clock.restarts == 1
    assert "went from 1000.9 s to 0.3 s: it began again" in clock.notes[-1]


def test_one_wild_stamp_does_no_harm() -> None:
    clock = StreamClock("/faces")
    stamps = [1.0, 1.1, 1e9, 1.2, 1.3]
    assert [clock.take(s, s if s < 9 else 1.15) for s in stamps] == [1.0, 1.1, None, 1.2, 1.3]
    assert (clock.strange, clock.restarts) == (1, 0)


@pytest.mark.parametrize("leap", [1.5, 6.0, 9.5])
def test_one_stamp_seconds_ahead_does_no_harm(leap: float) -> None:
    clock = StreamClock("/faces")
    stamps = [1.0, 1.1, 1.15 + leap, 1.2, 1.3, 1.35 + leap, 1.4]
    times = [clock.take(s, s if s < 2 else s - leap) for s in stamps]
    assert times == [1.0, 1.1, None, 1.2, 1.3, None, 1.4]
    assert (clock.strange, clock.restarts, clock.notes) == (2, 0, [])


def test_messages_that_were_held_up_no_more_count_but_for_the_first() -> None:
    clock = StreamClock("/faces")
    held_up = [(10 + i / 10, 14 + i / 10) for i in range(5)]
    in_time = [(14.5 + i / 10, 14.5 + i / 10) for i in range(4)]
    times = [clock.take(stamp, now) for stamp, now in held_up + in_time]
    assert times == [10.0, 10.1, 10.2, 10.3, 10.4, None, *(stamp for stamp, _ in in_time[1:])]
    assert clock.restarts == 0


def test_a_pause_is_no_leap() -> None:
    clock = StreamClock("/faces")
    assert [clock.take(s, s) for s in (1.0, 1.1, 8.0, 8.1)] == [1.0, 1.1, 8.0, 8.1]


def test_two_clocks_on_one_topic_are_named_and_the_first_counts() -> None:
    clock = StreamClock("/faces")
    times = []
    for i in range(10):
        now = 50 + i / 10
        times += [clock.take(now, now), clock.take(1.7e9 + i / 10, now)]
    assert times[1::2] == [None] * 10
    assert None not in times[::2]
    assert any("carry two clocks" in note for note in clock.notes)


@given(st.lists(st.tuples(st.floats(0, 1e10), st.floats(0, 1e10)), max_size=40))
def test_times_always_grow(messages: list[tuple[float, float]]) -> None:
    clock = StreamClock("/faces")
    times = [t for stamp, now in messages if (t := clock.take(stamp, now)) is not None]
    assert all(a < b for a, b in itertools.pairwise(times))

"""When messages came, by when they were sent."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kendon.ros.arrivals import Arrivals

SECOND = 10**9


def test_what_waited_counts_when_it_came() -> None:
    arrivals = Arrivals()
    ahead = 5 * SECOND  # of this computer's clock, the sender's
    assert arrivals.take(ahead + 100, 1100) == 1100  # the quickest: a microsecond
    arrivals.pass_time(2000)
    late = 3 * SECOND
    came = [arrivals.take(ahead + t, late + t) for t in (5000, 7000, late)]
    # Meanwhile, 6 s of this computer's clock, the clocks may have drifted by a ten-thousandth.
    assert came == pytest.approx([6000, 8000, late + 1000], abs=6.001 * SECOND * 1e-4)


def test_without_a_time_of_sending_it_counts_when_it_is_taken_in() -> None:
    arrivals = Arrivals()
    assert [arrivals.take(0, now) for now in (7, 9, 9, 8)] == [7, 9, 10, 11]


@given(
    st.lists(st.tuples(st.integers(0, 10**12), st.integers(0, 10**12), st.booleans()), max_size=30)
)
def test_times_grow_and_no_message_comes_after_it_was_taken_in(
    steps: list[tuple[int, int, bool]],
) -> None:
    arrivals, newest, clock = Arrivals(), 0, 0
    for sent, passed, is_message in steps:
        clock += passed + 1
        came = arrivals.take(sent, clock) if is_message else arrivals.pass_time(clock - passed // 2)
        assert newest < came <= clock
        newest = came

"""Where a hand has been, against paths whose places and speeds are known."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kendon.features.gestures.arm import (
    ACROSS,
    ARM,
    BELIEVED,
    KEPT,
    LAST,
    RAISED,
    TOWARD,
    UP,
    Arm,
    leaps,
)
from kendon.geometry import UNKNOWN_POINT, Vec3

SHOULDER: Vec3 = (3.0, 0.2, 1.4)
HEAD: Vec3 = (2.9, 0.0, 1.55)
OTHER: Vec3 = (3.0, -0.2, 0.85)
RATES = (10.0, 15.0, 30.0, 60.0)

Path3 = Callable[[float], tuple[float, ...]]  # of a time to toward, across and up [m]


def arm_of(place: Path3, rate: float, seconds: float = 3.0) -> tuple[Arm, float]:
    """An arm whose wrist goes along a path from the shoulder, toward the robot, left and up."""
    arm = Arm()
    way = math.hypot(*SHOULDER[:2])
    ux, uy = -SHOULDER[0] / way, -SHOULDER[1] / way  # toward the robot
    t = 0.0
    for k in range(round(seconds * rate) + 1):
        t = k / rate
        toward, across, up = place(t)
        wrist = (
            SHOULDER[0] + toward * ux - across * uy,
            SHOULDER[1] + toward * uy + across * ux,
            SHOULDER[2] + up,
        )
        elbow = (
            (SHOULDER[0] + wrist[0]) / 2, (SHOULDER[1] + wrist[1]) / 2,
            (SHOULDER[2] + wrist[2]) / 2,
        )  # fmt: skip
        arm.add(t, SHOULDER, elbow, wrist, HEAD, OTHER)
    return arm, t


@pytest.mark.parametrize("rate", RATES)
@given(speeds=st.tuples(*[st.floats(-2, 2)] * 3))
def test_the_speed_of_a_straight_way_is_its_slope_at_any_rate(
    rate: float, speeds: tuple[float, float, float]
) -> None:
    arm, end = arm_of(lambda t: tuple(v * t for v in speeds), rate, 1.0)
    toward, across, up = speeds
    assert arm.speed(end, UP) == pytest.approx(up, abs=1e-9)
    assert arm.speed(end, TOWARD) == pytest.approx(toward, abs=1e-9)
    assert abs(arm.speed(end, ACROSS)) == pytest.approx(abs(across), abs=1e-9)


@pytest.mark.parametrize("where", [-3, -2, -1])
def test_one_wild_place_changes_no_speed_much(where: int) -> None:
    wild = {31 + where: 5.0}
    arm, end = arm_of(lambda t: (0.1, 0.0, t + wild.get(round(t * 30), 0.0)), 30.0, 1.0)
    assert arm.speed(end, UP) == pytest.approx(1.0, abs=0.5)


def test_the_speed_of_a_hand_that_was_seen_once_is_unknown() -> None:
    arm, end = arm_of(lambda t: (0.1, 0.0, 0.0), 30.0, 0.0)
    assert math.isnan(arm.speed(end, UP))
    assert math.isnan(arm.reached(end, UP))


@given(high=st.floats(-0.2, 0.5), low=st.floats(-0.5, -0.3))
def test_where_a_hand_came_before_does_not_count_what_it_does_now(high: float, low: float) -> None:
    """It was low until the last 0.8 s, and rises then as hands do, or the other way round."""

    def up(t: float, first: float, then: float) -> float:
        share = min(1.0, max(0.0, (t - (3.0 - LAST)) / 0.25))
        return first + share * (then - first)

    arm, end = arm_of(lambda t: (0.1, 0.0, up(t, low, high)), 30.0)
    assert arm.reached(end, UP) == pytest.approx(low)
    later, end = arm_of(lambda t: (0.1, 0.0, up(t, high, low)), 30.0)
    assert later.reached(end, UP) == pytest.approx(high)


@pytest.mark.parametrize("rate", RATES)
@given(amplitude=st.floats(0.1, 0.5), phase=st.floats(0, 2 * math.pi))
def test_an_arm_that_swings_comes_no_farther_than_it_has_just_come(
    rate: float, amplitude: float, phase: float
) -> None:
    """Half a stride and more was seen before: each swing is like the last."""
    arm, end = arm_of(
        lambda t: (amplitude * math.sin(2 * math.pi * t + phase), 0.0, -0.4), rate, 2 * KEPT
    )
    latest = arm.lately(end, end - 0.2, ARM)
    assert latest.toward * ARM <= arm.reached(end, TOWARD) + 0.25 * amplitude


def test_a_hand_is_where_it_is_for_longer_the_less_sure_its_bones_are() -> None:
    """A straight arm that rises: its place is the median of a tenth of a second, or a quarter."""

    def up(t: float) -> float:
        return -0.5 * math.cos(0.5 + 0.5 * t)

    def place(t: float) -> tuple[float, float, float]:
        return 0.5 * math.sin(0.5 + 0.5 * t), 0.0, up(t)

    arm, end = arm_of(place, 60.0, 2.0)
    sure = arm.lately(end, end - 0.2, ARM)
    assert sure.up * ARM == pytest.approx(up(end - 0.05), abs=0.002)
    assert sure.noise < 1e-9
    arm, rng = Arm(), np.random.default_rng(3)
    for k in range(121):
        t = k / 60
        wrist = np.add(SHOULDER, (-place(t)[0], 0.0, up(t)))
        x, y, z = (wrist + np.array(SHOULDER)) / 2 + rng.normal(0, 0.1, 3)
        arm.add(t, SHOULDER, (x, y, z), tuple(wrist), HEAD, OTHER)
    unsure = arm.lately(end, end - 0.2, ARM)
    assert unsure.up * ARM == pytest.approx(up(end - 0.125), abs=0.002)
    assert unsure.noise > 0.01


def test_when_a_hand_was_last_down_is_kept_in_mind() -> None:
    arm = Arm()
    for k in range(91):
        t = k / 30
        up = -0.5 if t < 1.0 else 0.1  # [m]; a hand at -0.5 arms is neither up nor down
        arm.add(t, SHOULDER, SHOULDER, (2.9, 0.2, 1.4 + up), HEAD, OTHER)
        if k % 6 == 0 and k:
            arm.lately(t, t - 0.2, ARM)
    assert arm.low == pytest.approx(1.0, abs=0.2)
    assert RAISED * ARM > -0.5


def test_a_hand_whose_elbow_is_unknown_is_looked_at_for_the_longest() -> None:
    arm = Arm()
    for k in range(61):
        t = k / 60
        wrist = (SHOULDER[0] - 0.1, SHOULDER[1], SHOULDER[2] + 0.5 * t - 0.5)
        arm.add(t, SHOULDER, UNKNOWN_POINT, wrist, HEAD, OTHER)
    assert arm.lately(1.0, 0.8, ARM).up * ARM == pytest.approx(0.5 * (1.0 - 0.125) - 0.5, abs=1e-6)


def test_one_frame_before_a_gap_does_not_tell_where_a_hand_usually_comes() -> None:
    arm = Arm()
    for t in [0.0] + [1.0 + k / 30 for k in range(16)]:
        arm.add(t, SHOULDER, SHOULDER, (2.9, 0.2, 1.4), HEAD, OTHER)
    assert math.isnan(arm.reached(1.5, UP))


@pytest.mark.parametrize("rate", [15.0, 30.0, 60.0])
@given(frames=st.integers(1, BELIEVED - 1), aside=st.floats(0.75, 1.5))
def test_what_is_taken_for_a_hand_for_a_frame_or_two_is_passed_over(
    rate: float, frames: int, aside: float
) -> None:
    first = round(1.5 * rate)
    wild = range(first, first + frames)
    arm, end = arm_of(lambda t: (0.1, aside if round(t * rate) in wild else 0.0, -0.3), rate, 2.0)
    assert all(abs(row.across) < 1e-9 for row in arm.since(0.0))
    assert len(arm.since(0.0)) == round(end * rate) + 1 - frames


@pytest.mark.parametrize("rate", [15.0, 30.0, 60.0])
@given(aside=st.floats(0.75, 1.5))
def test_of_a_hand_that_has_leapt_nothing_before_is_known(rate: float, aside: float) -> None:
    arm, _ = arm_of(lambda t: (0.1, aside if t > 1.5 else 0.0, -0.3), rate, 2.0)
    kept = arm.since(0.0)
    assert all(abs(abs(row.across) - aside) < 1e-9 for row in kept)
    assert len(kept) == round(0.5 * rate)
    assert math.isnan(arm.reached(2.0, ACROSS))


@given(
    before=st.tuples(*[st.floats(-0.5, 0.5)] * 3), way=st.tuples(*[st.floats(-1, 1)] * 3),
    seconds=st.floats(0.01, 0.2),
)  # fmt: skip
def test_no_hand_leaps_that_goes_as_fast_as_hands_go(
    before: Vec3, way: Vec3, seconds: float
) -> None:
    fastest = 5.0 * seconds / max(1.0, math.hypot(*way))
    x, y, z = (a + fastest * b for a, b in zip(before, way, strict=True))
    assert not leaps(before, (x, y, z), seconds)


def test_a_shoulder_that_is_lost_makes_no_hand_leap() -> None:
    """The other one, 0.36 m aside, stands in for it."""
    arm, wrist = Arm(), (SHOULDER[0] - 0.2, SHOULDER[1], SHOULDER[2] - 0.2)
    other = (SHOULDER[0], SHOULDER[1] + 0.36, SHOULDER[2])
    for k in range(90):
        shoulder = other if 30 <= k < 60 else SHOULDER
        arm.add(k / 30, shoulder, SHOULDER, wrist, HEAD, OTHER)
    assert len(arm.since(0.0)) == 90


def test_no_bones_are_measured_from_a_shoulder_that_stands_in() -> None:
    own, lost = Arm(), Arm()
    wrist = (SHOULDER[0] - 0.2, SHOULDER[1], SHOULDER[2] - 0.3)
    elbow = (SHOULDER[0], SHOULDER[1], SHOULDER[2] - 0.3)
    for k in range(10):
        own.add(k / 30, SHOULDER, elbow, wrist, HEAD, OTHER)
        lost.add(k / 30, SHOULDER, elbow, wrist, HEAD, OTHER, own=False)
    assert own.length(0.0) == pytest.approx(0.5)
    assert math.isnan(lost.length(0.0))


def test_a_hand_that_is_still_does_not_stir_however_noisy_its_joints() -> None:
    rng = np.random.default_rng(5)
    arm, stirring = Arm(), Arm()
    for k in range(90):
        noise = rng.normal(0.0, 0.02, (3, 3))
        shoulder, elbow, wrist = (
            tuple(np.add(place, off).tolist())
            for place, off in zip(
                (SHOULDER, (SHOULDER[0], SHOULDER[1], SHOULDER[2] - 0.3),
                 (SHOULDER[0] - 0.25, SHOULDER[1], SHOULDER[2] - 0.3)), noise, strict=True,
            )
        )  # fmt: skip
        arm.add(k / 30, shoulder, elbow, wrist, HEAD, OTHER)
        # About the elbow, which keeps the bones as long as they are.
        turn = 0.6 * math.sin(2 * math.pi * 1.5 * k / 30)
        x, y, z = elbow
        turned = (x - 0.25 * math.cos(turn), y + 0.25 * math.sin(turn), z)
        stirring.add(k / 30, shoulder, elbow, turned, HEAD, OTHER)
    assert arm.stirs(3.0, ARM) < 0.08
    assert stirring.stirs(3.0, ARM) > 0.2

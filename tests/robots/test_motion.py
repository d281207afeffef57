"""Motions of joints: laws of planned and of chasing set-points."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kendon.robots.mujoco.motion import SPEED_SHARE, Chaser, plan

CYCLE = 0.02
angles = st.floats(-1.0, 1.0)
times = st.lists(st.floats(0.2, 1.5), min_size=1, max_size=5)
FREE = np.array([-2.0, -2.0]), np.array([2.0, 2.0])


@given(
    steps=times, data=st.data(), start=st.tuples(angles, angles),
    speeds=st.tuples(st.floats(0.3, 4.0), st.floats(0.3, 4.0)),
)  # fmt: skip
def test_a_motion_is_slow_enough_meets_its_last_keyframe_and_never_swings_beyond(
    steps: list[float], data: st.DataObject, start: tuple[float, float],
    speeds: tuple[float, float],
) -> None:  # fmt: skip
    t = np.cumsum(steps).tolist()
    keyframes = [(when, {j: data.draw(angles) for j in (0, 1)}) for when in t]
    motion = plan(keyframes, np.array(start), np.zeros(2), *FREE, np.array(speeds), CYCLE)
    points = np.vstack([start, motion.points])
    fastest = np.abs(np.diff(points, axis=0)).max(axis=0) / CYCLE
    assert (fastest <= SPEED_SHARE * np.array(speeds) * (1 + 1e-9)).all()
    assert points[-1] == pytest.approx([keyframes[-1][1][j] for j in (0, 1)])
    for j in (0, 1):
        named = [start[j], *(points_at[j] for _, points_at in keyframes)]
        assert points[:, j].min() >= min(named) - 1e-9
        assert points[:, j].max() <= max(named) + 1e-9


def test_a_motion_passes_through_its_keyframes_and_waits_where_joints_are_held() -> None:
    keyframes = [(1.0, {0: 0.5}), (2.0, {0: 0.5, 1: -0.4}), (3.0, {0: 0.0})]
    motion = plan(keyframes, np.zeros(2), np.zeros(2), *FREE, np.full(2, 9.0), CYCLE)
    assert motion.points.shape == (150, 2)
    column = dict(zip(motion.joints.tolist(), motion.points.T, strict=True))
    assert column[0][49] == pytest.approx(0.5)
    assert column[0][49:99] == pytest.approx(np.full(50, 0.5))
    assert column[1][99] == pytest.approx(-0.4)
    assert column[1][-1] == pytest.approx(-0.4)
    taken = 0
    while not motion.over:
        motion.next()
        taken += 1
    assert taken == 150
    assert motion.next() == pytest.approx([0.0, -0.4])


def test_a_step_next_to_nothing_is_a_motion_as_any_other() -> None:
    keyframes = [(1.0, {0: 0.0}), (2.0, {0: 2.2e-309})]
    motion = plan(keyframes, np.zeros(2), np.zeros(2), *FREE, np.full(2, 9.0), CYCLE)
    assert motion.points == pytest.approx(np.zeros((100, 1)))


def test_a_motion_goes_on_from_the_present_speed() -> None:
    keyframes = [(1.0, {0: 0.5})]
    motion = plan(keyframes, np.zeros(2), np.array([0.8, 0.0]), *FREE, np.full(2, 9.0), CYCLE)
    assert motion.points[0, 0] / CYCLE == pytest.approx(0.8, rel=0.03)
    assert motion.points[-1, 0] == pytest.approx(0.5)


def test_a_motion_stays_within_the_joints_ranges() -> None:
    low, high = np.full(2, -0.1), np.full(2, 0.2)
    motion = plan([(1.0, {0: 0.2})], np.zeros(2), np.array([2.0, 0.0]), low, high,
                  np.full(2, 9.0), CYCLE)  # fmt: skip
    assert motion.points.max() <= 0.2


@given(start=angles, target=angles, speed=st.floats(0.2, 5.0), acceleration=st.floats(0.5, 50.0))
def test_a_chaser_takes_the_time_of_its_trapezoid_and_does_not_overshoot(
    start: float, target: float, speed: float, acceleration: float
) -> None:
    chaser = Chaser(start, speed, acceleration)
    way = abs(target - start)
    if way < speed**2 / acceleration:
        least = 2 * math.sqrt(way / acceleration)
    else:
        least = way / speed + speed / acceleration
    steps = 0
    before = 0.0
    while abs(chaser.position - target) > 1e-4 or abs(chaser.rate) > 1e-3:
        chaser.step(target, CYCLE)
        steps += 1
        assert abs(chaser.rate) <= speed + 1e-9
        assert abs(chaser.rate - before) <= acceleration * CYCLE + 1e-9
        assert min(start, target) - 1e-3 <= chaser.position <= max(start, target) + 1e-3
        before = chaser.rate
        assert steps * CYCLE < least + 20 * CYCLE + 0.1 * least
    assert steps * CYCLE >= least - 2 * CYCLE - 0.02 / acceleration


def test_a_chaser_without_a_target_brakes() -> None:
    chaser = Chaser(0.0, 1.0, 2.0)
    for _ in range(100):
        chaser.step(5.0, CYCLE)
    here = chaser.position
    for _ in range(60):
        chaser.step(None, CYCLE)
    assert chaser.rate == 0.0
    assert chaser.position - here == pytest.approx(1.0 / (2 * 2.0), rel=0.05)

"""Distance and speed: a robot that drives, a person who walks, both at known speeds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from people import angles, metres, points, poses

from kendon.features import observe
from kendon.features.proxemics import closing_speed, distance, to_world
from kendon.geometry import Pose2D, Vec3
from kendon.person import PersonFrame, Track


def watch(rate: float, seconds: float, person: Vec3, velocity: Vec3, robots: list[Pose2D]) -> Track:
    """A person who walks in the world, as a robot on its own way sees them."""
    times = np.arange(round(rate * seconds) + 1) / rate
    frames = []
    for i, t in enumerate(times.tolist()):
        place = (
            person[0] + t * velocity[0], person[1] + t * velocity[1], person[2] + t * velocity[2]
        )  # fmt: skip
        robot = robots[i % len(robots)]
        frames.append(PersonFrame(t, robot.to_local(place), robot=robot))
    return Track.from_frames(frames)


def test_distance_is_on_the_ground() -> None:
    heads = np.array([[3.0, 4.0, 1.7], [0.0, -2.0, 9.0], [np.nan, 1.0, 1.0], [1.0, 0.0, np.nan]])
    np.testing.assert_array_equal(distance(heads), [5, 2, np.nan, 1])


@given(poses, points)
def test_to_world_is_the_robots_pose_applied(robot: Pose2D, head: Vec3) -> None:
    got = to_world(np.array(head), np.array(robot))
    np.testing.assert_allclose(got, robot.to_world(head)[:2], atol=1e-9)


def test_speed_by_hand() -> None:
    # From 5 m to 4 m away from the robot's previous place in half a second.
    assert closing_speed((3.0, 4.0), (4.0, 0.0), (0.0, 0.0), 0.5) == pytest.approx(2.0)


@pytest.mark.parametrize("rate", [10, 12.5, 25, 30, 60])
def test_who_walks_at_1_3_metres_a_second_has_that_speed(rate: float) -> None:
    track = watch(rate, 4, (7.0, 0.0, 1.6), (-1.3, 0.0, 0.0), [Pose2D(0, 0, 0)])
    seen = observe(track).values
    np.testing.assert_allclose(seen[:, 1], 1.3, atol=1e-9)


def test_who_walks_away_has_a_negative_speed_and_who_walks_around_has_none() -> None:
    away = watch(30, 2, (1.0, 1.0, 1.6), (0.6, 0.8 - 0.2, 0.0), [Pose2D(-5.0, -5.0, 1.0)])
    direction = (0.6 + 0.6) / math.sqrt(2)  # the part of the velocity along the diagonal
    np.testing.assert_allclose(observe(away).values[1:, 1], -direction, atol=1e-9)
    t = np.arange(61) / 30
    circle = np.stack([2 * np.cos(t), 2 * np.sin(t), np.full(61, 1.6)], axis=1)
    speeds = observe(Track.build(t, circle)).values[1:, 1]
    np.testing.assert_allclose(speeds, 0, atol=0.02)


@pytest.mark.parametrize("drive", [0.5, -0.5])
def test_a_robot_that_drives_adds_nothing_to_the_persons_speed(drive: float) -> None:
    # Both on one line: the distance changes by both speeds, the person's speed is their own.
    robots = [Pose2D(drive * i / 30, 0.0, 0.0) for i in range(91)]
    seen = observe(watch(30, 3, (8.0, 0.0, 1.6), (-1.0, 0.0, 0.0), robots))
    np.testing.assert_allclose(seen.values[1:, 1], 1.0, atol=1e-9)
    np.testing.assert_allclose(np.diff(seen.values[1:, 0]), -(1 + drive) * 0.2, atol=1e-9)


def test_speed_is_toward_where_the_robot_was() -> None:
    # Three frames an interval; the person walks at one speed, so that the line through the frames
    # is their way. The robot, which drives across it, was where the frame 0.2 s before found it.
    robots = [Pose2D(0.0, 0.2 * i, 0.1 * i) for i in range(16)]
    seen = observe(watch(15, 1, (5.0, 0.0, 1.6), (-1.5, 0.0, 0.0), robots)).values

    def x(frame: int) -> float:
        return 5 - 1.5 * frame / 15

    for k in (2, 3, 4):
        was = math.hypot(x(3 * k), 0.2 * 3 * k)
        now = math.hypot(x(3 * k + 3), 0.2 * 3 * k)
        assert seen[k, 1] == pytest.approx((was - now) / 0.2)


@given(points, st.lists(poses, min_size=31, max_size=31))
def test_who_stands_still_has_speed_0_whatever_the_robot_does(
    person: Vec3, robots: list[Pose2D]
) -> None:
    seen = observe(watch(30, 1, person, (0.0, 0.0, 0.0), robots)).values
    np.testing.assert_allclose(seen[1:, 1], 0, atol=1e-9)


@given(points, st.tuples(metres, metres), angles, st.tuples(metres, metres, angles))
def test_moving_robot_and_person_together_changes_nothing(
    person: Vec3, velocity: tuple[float, float], yaw: float, motion: tuple[float, float, float]
) -> None:
    robots = [Pose2D(0.03 * i, -0.01 * i, yaw + 0.02 * i) for i in range(31)]
    here = watch(30, 1, person, (*velocity, 0.0), robots)
    moved = Pose2D(*motion)
    c, s = math.cos(moved.yaw), math.sin(moved.yaw)
    x, y = velocity
    there = watch(
        30,
        1,
        moved.to_world(person),
        (c * x - s * y, s * x + c * y, 0.0),
        [Pose2D(*moved.to_world((r.x, r.y, 0.0))[:2], r.yaw + moved.yaw) for r in robots],
    )
    np.testing.assert_allclose(observe(there).values, observe(here).values, atol=1e-8)


def test_distance_is_measured_from_where_the_robot_is_now() -> None:
    robots = [Pose2D(0.1 * i, 0.0, 0.3 * i) for i in range(16)]
    seen = observe(watch(15, 1, (5.0, 0.0, 1.6), (0.0, 0.0, 0.0), robots)).values
    # Frames 1 to 3 make the first interval but for frame 0; 4 to 6 the second; and so on.
    np.testing.assert_allclose(seen[1:, 0], [4.5, 4.2, 3.9, 3.6], atol=1e-9)


def test_an_unknown_robot_pose_leaves_the_distance_known_and_the_speed_unknown() -> None:
    robot = np.zeros((31, 3))
    robot[10:21] = np.nan
    t = np.arange(31) / 30
    seen = observe(Track.build(t, np.tile([3.0, 0.0, 1.6], (31, 1)), robot=robot)).values
    np.testing.assert_array_equal(seen[:, 0], 3.0)
    assert np.isnan(seen[2, 1])
    assert seen[-1, 1] == pytest.approx(0)

"""Algorithms 3 and 4 in closed form and as laws."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from trees.tree_fakes import close

from kendon.errors import TreeError
from kendon.geometry import Pose2D, quaternion_yaw, yaw_quaternion
from kendon.trees.poses import (
    BASE_FRAME,
    WORLD_FRAME,
    Pose,
    approach_goal,
    gaze_down,
    ground_pose,
    parse_pose,
    turn_goal,
)

metres = st.floats(-10, 10)
angles = st.floats(-math.pi, math.pi)
poses = st.builds(Pose2D, metres, metres, angles)
points = st.tuples(metres, metres, st.floats(0.5, 2.2))


def person(x: float, y: float, yaw: float | None = None) -> Pose:
    rotation = yaw_quaternion(yaw) if yaw is not None else Pose((0, 0, 0)).rotation
    return Pose((x, y, 1.7), rotation, WORLD_FRAME)


def test_turn_goal_in_closed_form() -> None:
    robot = Pose2D(1.0, 2.0, 0.3)
    assert turn_goal((1.0, 5.0, 1.7), robot) == Pose2D(1.0, 2.0, math.pi / 2)
    assert turn_goal((0.0, 1.0, 1.7), robot) == Pose2D(1.0, 2.0, -3 * math.pi / 4)
    assert turn_goal((1.0, 2.0, 1.7), robot) == robot


@given(points, poses)
def test_the_turned_robot_has_the_person_straight_ahead(
    face: tuple[float, float, float], robot: Pose2D
) -> None:
    goal = turn_goal(face, robot)
    assert (goal.x, goal.y) == (robot.x, robot.y)
    distance = math.hypot(face[0] - robot.x, face[1] - robot.y)
    if distance > 1e-6:
        x, y, z = goal.to_local(face)
        assert (x, z) == pytest.approx((distance, face[2]))
        assert y == pytest.approx(0, abs=1e-9)


def test_approach_goal_in_closed_form() -> None:
    # Figure 4.8: the person looks along -x, at the robot; the robot stops 1 m before the face.
    goal = approach_goal(person(4, 0, math.pi), Pose2D(0, 0, 0), 1.0)
    assert close(goal, Pose2D(3, 0, 0))
    # The person looks along -y: the robot comes round to their front and looks along +y.
    goal = approach_goal(person(4, 0, -math.pi / 2), Pose2D(0, 0, 0), 1.5)
    assert close(goal, Pose2D(4, -1.5, math.pi / 2))
    # No heading: on the line between the two.
    goal = approach_goal(person(3, 4), Pose2D(0, 0, 0), 1.0)
    assert close(goal, Pose2D(2.4, 3.2, math.atan2(4, 3)))


@given(points, angles, poses, st.floats(0.1, 2.0))
def test_the_robot_stands_in_front_at_the_distance_and_looks_back(
    face: tuple[float, float, float], heading: float, robot: Pose2D, distance: float
) -> None:
    facing = Pose(face, yaw_quaternion(heading), WORLD_FRAME)
    goal = approach_goal(facing, robot, distance, retreat=True)
    assert goal.to_local(face)[:2] == pytest.approx((distance, 0), abs=1e-9)
    seen = Pose2D(face[0], face[1], heading).to_local((goal.x, goal.y, 0))
    assert seen[:2] == pytest.approx((distance, 0), abs=1e-9)


@given(points, poses, st.floats(0.1, 2.0))
def test_without_a_heading_the_goal_lies_on_the_line(
    face: tuple[float, float, float], robot: Pose2D, distance: float
) -> None:
    away = math.hypot(robot.x - face[0], robot.y - face[1])
    goal = approach_goal(Pose(face, frame=WORLD_FRAME), robot, distance)
    assert goal.to_local(face)[1] == pytest.approx(0, abs=1e-6)
    if away > distance:
        gone = math.hypot(goal.x - robot.x, goal.y - robot.y)
        assert gone == pytest.approx(away - distance, abs=1e-6)
    else:
        assert (goal.x, goal.y) == pytest.approx((robot.x, robot.y), abs=1e-6)


def test_a_robot_that_is_near_enough_keeps_its_place_unless_told_to_retreat() -> None:
    near, robot = person(0.6, 0, math.pi), Pose2D(0, 0, 0.4)
    assert approach_goal(near, robot, 1.0) == Pose2D(0, 0, 0)
    assert close(approach_goal(near, robot, 1.0, retreat=True), Pose2D(-0.4, 0, 0))


def test_a_robot_on_the_persons_spot_steps_back() -> None:
    robot = Pose2D(1, 1, 0)
    assert close(approach_goal(person(1, 1), robot, 1.0, retreat=True), Pose2D(0, 1, 0))


@given(points, angles, poses)
def test_frames_there_and_back(face: tuple[float, float, float], yaw: float, robot: Pose2D) -> None:
    seen = Pose(face, yaw_quaternion(yaw), BASE_FRAME)
    world = seen.in_world(robot)
    assert world.frame == WORLD_FRAME
    assert world.position == pytest.approx(robot.to_world(face))
    assert math.remainder(world.yaw - yaw - robot.yaw, 2 * math.pi) == pytest.approx(0, abs=1e-9)
    back = world.in_base(robot)
    assert back.frame == BASE_FRAME
    assert back.position == pytest.approx(face, abs=1e-9)


def test_the_frame_that_is_not_said_is_the_readers() -> None:
    robot = Pose2D(1, 0, 0)
    assert Pose((1, 0, 0)).in_world(robot).position == (1, 0, 0)
    assert Pose((1, 0, 0)).in_world(robot, BASE_FRAME).position == (2, 0, 0)
    with pytest.raises(TreeError, match="'odom'; valid: map, base_footprint"):
        Pose((1, 0, 0), frame="odom").in_world(robot)


def test_gaze_down_halves_the_height_only() -> None:
    assert gaze_down(person(3, 1, 0.2)) == person(3, 1, 0.2)._replace(position=(3, 1, 0.85))


def test_ground_pose() -> None:
    pose = ground_pose(Pose2D(1, 2, 0.5))
    assert pose.position == (1, 2, 0)
    assert quaternion_yaw(pose.rotation) == pytest.approx(0.5)


@pytest.mark.parametrize("text", ["", "1;2", "1;2;x", "1;2;nan", "1;2;3;0;0;0;0", "1,2,3"])
def test_poses_that_cannot_be_read(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011  float's own message
        parse_pose(text)


def test_a_written_rotation_is_normalised() -> None:
    assert parse_pose("1;2;3;0;0;2;0").rotation == (0, 0, 1, 0)

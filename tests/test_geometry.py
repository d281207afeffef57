"""Planar geometry: laws, and scipy as a second opinion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from people import angles, points, poses, quaternion
from scipy.spatial.transform import Rotation

from kendon.geometry import (
    ORIGIN,
    UNKNOWN_ROTATION,
    Pose2D,
    Quaternion,
    Vec3,
    compose,
    quaternion_yaw,
    wrap_angle,
    yaw_quaternion,
)

rotations = st.builds(quaternion, angles, angles, angles)


@given(st.floats(-1000, 1000))
def test_a_wrapped_angle_points_the_same_way(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [(0, 0), (math.pi, -math.pi), (-math.pi, -math.pi), (7, 7 - math.tau), (-4, math.tau - 4)],
)
def test_angles_at_and_past_the_half_turn(angle: float, wrapped: float) -> None:
    assert wrap_angle(angle) == pytest.approx(wrapped)


@given(angles)
def test_the_yaw_of_a_turn_about_z(yaw: float) -> None:
    assert wrap_angle(quaternion_yaw(yaw_quaternion(yaw)) - yaw) == pytest.approx(0, abs=1e-9)


@given(angles, st.floats(-1.5, 1.5), angles)
def test_yaw_is_where_the_x_axis_points_whatever_pitch_and_roll(
    yaw: float, pitch: float, roll: float
) -> None:
    off = quaternion_yaw(quaternion(yaw, pitch, roll)) - yaw
    assert wrap_angle(off) == pytest.approx(0, abs=1e-6)


def test_an_unknown_rotation_has_no_yaw() -> None:
    assert math.isnan(quaternion_yaw(UNKNOWN_ROTATION))


@given(rotations, rotations)
def test_composing_is_scipys_product(first: Quaternion, second: Quaternion) -> None:
    expected = Rotation.from_quat(first) * Rotation.from_quat(second)
    got = Rotation.from_quat(compose(first, second))
    np.testing.assert_allclose(got.as_matrix(), expected.as_matrix(), atol=1e-9)


def test_a_pose_by_hand() -> None:
    pose = Pose2D(1.0, 2.0, math.pi / 2)  # looks along +y
    assert pose.to_world((3.0, 0.5, 1.2)) == pytest.approx((0.5, 5.0, 1.2))
    assert pose.to_local((1.0, 7.0, 0.0)) == pytest.approx((5.0, 0.0, 0.0))
    assert pose.to_local((0.0, 2.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0))  # to its left


@given(poses, points)
def test_to_local_undoes_to_world(pose: Pose2D, point: Vec3) -> None:
    assert pose.to_local(pose.to_world(point)) == pytest.approx(point, abs=1e-9)
    assert pose.to_world(pose.to_local(point)) == pytest.approx(point, abs=1e-9)
    assert ORIGIN.to_world(point) == point


@given(poses, poses)
def test_the_distance_of_two_poses_is_that_of_their_origins(a: Pose2D, b: Pose2D) -> None:
    x, y, _ = a.to_local((b.x, b.y, 0.0))
    assert a.distance_to(b) == pytest.approx(math.hypot(x, y), abs=1e-9)
    assert a.distance_to(b) == b.distance_to(a)

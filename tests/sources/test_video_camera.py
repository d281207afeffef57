"""The pinhole camera and its place on the robot."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kendon.errors import ParameterError
from kendon.sources.base import CameraMount
from kendon.sources.camera_geometry import DEFAULT_FOV, Intrinsics, MountedCamera


def test_the_rim_of_the_image_is_half_the_field_of_view_away() -> None:
    camera = Intrinsics.from_fov(640, 360, math.radians(90))
    assert camera.focal == pytest.approx(320)
    left, middle = camera.rays(np.array([[0.0, 180.0], [320.0, 180.0]]))
    assert left == pytest.approx([-1, 0, 1])
    assert middle == pytest.approx([0, 0, 1])


def test_the_default_field_of_view_is_sixty_degrees() -> None:
    assert math.degrees(DEFAULT_FOV) == pytest.approx(60)
    assert Intrinsics.from_fov(640, 480) == Intrinsics.from_fov(640, 480, math.pi / 3)


@given(
    st.floats(-1, 1),
    st.floats(-1, 1),
    st.floats(0.1, 10),
    st.floats(0.3, 2.5),
)
def test_a_ray_through_a_projected_point_meets_the_point(
    x: float, y: float, z: float, fov: float
) -> None:
    camera = Intrinsics.from_fov(1280, 720, fov)
    point = np.array([x, y, z])
    pixel = camera.project(point)
    assert camera.rays(pixel) * z == pytest.approx(point, abs=1e-9)
    homogeneous = camera.matrix @ point
    assert homogeneous[:2] / homogeneous[2] == pytest.approx(pixel)


@pytest.mark.parametrize("fov", [0.0, -1.0, math.nan, math.inf, math.pi, 60.0])
def test_an_impossible_field_of_view_is_refused_with_the_valid_range(fov: float) -> None:
    with pytest.raises(ParameterError, match=r"0\.09 to 2\.79 rad \(5 to 160 degrees"):
        Intrinsics.from_fov(640, 480, fov)


@pytest.mark.parametrize("size", [(0, 480), (640, 0), (-1, -1)])
def test_an_empty_image_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(ParameterError, match="shows nothing"):
        Intrinsics.from_fov(*size)


def test_a_level_camera_looks_along_the_robot() -> None:
    mounted = MountedCamera.from_mount(CameraMount(position=(0.1, 0.2, 1.3)))
    ahead = mounted.points(np.array([0.0, 0.0, 2.0]))
    assert ahead == pytest.approx([2.1, 0.2, 1.3])
    # The image's right is the robot's right (-y); the image's bottom is down (-z).
    assert mounted.directions(np.array([1.0, 0.0, 0.0])) == pytest.approx([0, -1, 0])
    assert mounted.directions(np.array([0.0, 1.0, 0.0])) == pytest.approx([0, 0, -1])


def test_a_positive_yaw_turns_the_camera_to_the_left() -> None:
    mounted = MountedCamera.from_mount(CameraMount(yaw=math.radians(90)))
    assert mounted.directions(np.array([0.0, 0.0, 1.0])) == pytest.approx([0, 1, 0])


def test_a_positive_pitch_tilts_the_camera_down() -> None:
    mounted = MountedCamera.from_mount(CameraMount(pitch=math.radians(30)))
    half, rest = 0.5, math.sqrt(3) / 2
    assert mounted.directions(np.array([0.0, 0.0, 1.0])) == pytest.approx([rest, 0, -half])


def test_yaw_turns_a_tilted_camera_about_the_vertical() -> None:
    tilt = math.radians(20)
    mounted = MountedCamera.from_mount(CameraMount(yaw=math.radians(90), pitch=tilt))
    axis = mounted.directions(np.array([0.0, 0.0, 1.0]))
    assert axis == pytest.approx([0, math.cos(tilt), -math.sin(tilt)])


@given(st.floats(-3, 3), st.floats(-1.5, 1.5))
def test_mounting_is_a_rotation(yaw: float, pitch: float) -> None:
    rotation = MountedCamera.from_mount(CameraMount(yaw=yaw, pitch=pitch)).rotation
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)


def test_a_quaternion_of_a_face_toward_a_level_camera_turns_half_around() -> None:
    # Head axes in the optical frame: out of the face = toward the camera, left = image right.
    facing = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
    x, y, z, w = MountedCamera.from_mount(CameraMount()).quaternion(facing)
    assert (x, y, abs(z), w) == pytest.approx((0, 0, 1, 0), abs=1e-12)

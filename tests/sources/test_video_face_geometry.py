"""Head, eyes and smile from landmarks, against faces that are projected and so are known."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kendon.errors import MissingExtraError
from kendon.sources.base import CameraMount
from kendon.sources.camera_geometry import FloatArray, Intrinsics, MountedCamera
from kendon.sources.face_geometry import (
    EYE_CORNERS,
    EYE_OFFSET,
    FACE_POINTS,
    IRIS_CENTRES,
    IRIS_DEPTH,
    LANDMARKS,
    action_units,
    eyes,
    head_pose,
    lids_down,
    smile_intensity,
)

pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")

#: Head axes in the optical frame of a person who looks into the camera, as columns.
FACING = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
CAMERA = Intrinsics.from_fov(640, 360, math.radians(60))


def turned(yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0) -> FloatArray:
    """A head turned in its own frame: yaw > 0 to the person's left, pitch > 0 down."""
    head = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    return np.asarray(FACING @ head)


def eye_centres(rotation: FloatArray, position: FloatArray) -> FloatArray:
    """Both eyes' centres of rotation, left first, (2, 3) [m]."""
    centres = []
    for corners, side in zip(EYE_CORNERS, (1, -1), strict=True):
        middle = np.mean([FACE_POINTS[i] for i in corners], axis=0) / 1000
        back, outward, up = EYE_OFFSET
        centres.append(rotation @ (middle + np.array([back, side * outward, up])) + position)
    return np.array(centres)


def photograph(
    rotation: FloatArray,
    position: FloatArray,
    gaze: FloatArray | None = None,
    camera: Intrinsics = CAMERA,
) -> FloatArray:
    """Landmarks (478, 2) [px] of a face of model shape; gaze (2, 3) in the optical frame."""
    pixels = np.full((LANDMARKS, 2), np.nan)
    for i, point in FACE_POINTS.items():
        pixels[i] = camera.project(rotation @ (np.array(point) / 1000) + position)
    if gaze is not None:
        iris = eye_centres(rotation, position) + IRIS_DEPTH * gaze
        pixels[list(IRIS_CENTRES)] = camera.project(iris)
    return pixels


@settings(deadline=None, max_examples=60)
@given(
    yaw=st.floats(-60, 60),
    pitch=st.floats(-35, 35),
    roll=st.floats(-35, 35),
    x=st.floats(-0.4, 0.4),
    y=st.floats(-0.2, 0.2),
    z=st.floats(0.35, 5),
    fov=st.floats(30, 100),
)
def test_the_pose_of_a_projected_face_is_recovered(
    yaw: float, pitch: float, roll: float, x: float, y: float, z: float, fov: float
) -> None:
    camera = Intrinsics.from_fov(1280, 720, math.radians(fov))
    rotation = turned(*np.radians([yaw, pitch, roll]))
    position = np.array([x * z, y * z, z])
    pose = head_pose(photograph(rotation, position, camera=camera), camera)
    assert pose is not None
    assert pose.position == pytest.approx(position, abs=1e-4 * z)
    assert pose.rotation == pytest.approx(rotation, abs=2e-3)
    assert pose.misfit < 0.01


def test_a_pixel_of_noise_moves_a_face_at_one_metre_by_little() -> None:
    rng = np.random.default_rng(0)
    pixels = photograph(turned(0.2), np.array([0.1, 0.0, 1.0]))
    depths, errors = [], []
    for _ in range(50):
        pose = head_pose(pixels + rng.normal(0, 0.5, pixels.shape), CAMERA)
        assert pose is not None
        depths.append(pose.position[2])
        errors.append(Rotation.from_matrix(pose.rotation.T @ turned(0.2)).magnitude())
    assert np.mean(depths) == pytest.approx(1.0, abs=0.01)
    assert np.std(depths) < 0.02
    assert np.degrees(np.median(errors)) < 4


def test_a_wrong_field_of_view_scales_the_distance_by_the_focal_lengths() -> None:
    pixels = photograph(turned(), np.array([0.0, 0.0, 2.0]))
    wide = Intrinsics.from_fov(640, 360, math.radians(90))
    pose = head_pose(pixels, wide)
    assert pose is not None
    assert pose.position[2] == pytest.approx(2.0 * wide.focal / CAMERA.focal, rel=0.03)


def test_unknown_landmarks_give_no_pose() -> None:
    assert head_pose(np.full((LANDMARKS, 2), np.nan), CAMERA) is None


def test_landmarks_on_top_of_each_other_give_no_pose() -> None:
    assert head_pose(np.full((LANDMARKS, 2), 100.0), CAMERA) is None


def test_a_head_turned_to_its_left_points_to_the_persons_left_in_base() -> None:
    # Facing the robot, the person's left is the robot's right: -y.
    mounted = MountedCamera.from_mount(CameraMount())
    pose = head_pose(photograph(turned(yaw=0.5), np.array([0.0, 0.0, 1.0])), CAMERA)
    assert pose is not None
    out, left, up = (mounted.directions(pose.rotation[:, axis]) for axis in range(3))
    assert out == pytest.approx([-math.cos(0.5), -math.sin(0.5), 0], abs=1e-4)
    assert left[1] == pytest.approx(-math.cos(0.5), abs=1e-4)
    assert up == pytest.approx([0, 0, 1], abs=1e-4)


def test_the_left_eye_is_on_the_images_right_and_on_the_robots_right() -> None:
    pixels = photograph(FACING, np.array([0.0, 0.0, 1.0]), np.tile([0.0, 0.0, -1.0], (2, 1)))
    pose = head_pose(pixels, CAMERA)
    assert pose is not None
    both = eyes(pixels, pose, CAMERA)
    assert both.centres[0, 0] > 0.02 > -0.02 > both.centres[1, 0]
    in_base = MountedCamera.from_mount(CameraMount()).points(both.centres)
    assert in_base[0, 1] < -0.02 < 0.02 < in_base[1, 1]


@settings(deadline=None, max_examples=60)
@given(
    side=st.floats(-25, 25),
    down=st.floats(-15, 15),
    yaw=st.floats(-30, 30),
    pitch=st.floats(-15, 15),
    z=st.floats(0.4, 1.5),
)
def test_gaze_is_recovered_from_the_iris(
    side: float, down: float, yaw: float, pitch: float, z: float
) -> None:
    rotation, position = turned(*np.radians([yaw, pitch])), np.array([0.05, 0.02, z])
    # In a turned head the eyes turn up to 40 degrees from straight ahead of the head.
    in_head = Rotation.from_euler("ZY", np.radians([side, down])).apply([1.0, 0.0, 0.0])
    gaze = np.tile(rotation @ in_head, (2, 1))
    if (gaze @ position > -0.5 * np.linalg.norm(position)).any():
        return  # past 60 degrees from the camera the iris is seen too much from the side
    pixels = photograph(rotation, position, gaze)
    pose = head_pose(pixels, CAMERA)
    assert pose is not None
    both = eyes(pixels, pose, CAMERA)
    assert both.centres == pytest.approx(eye_centres(rotation, position), abs=5e-4)
    between = np.degrees(np.arccos(np.clip(np.sum(both.gaze * gaze, axis=1), -1, 1)))
    assert between.max() < 4  # the middle of the corners is taken in the image, not in space


def test_an_iris_beside_the_globe_gives_the_nearest_direction() -> None:
    pixels = photograph(FACING, np.array([0.0, 0.0, 0.6]), np.tile([0.0, 0.0, -1.0], (2, 1)))
    pixels[IRIS_CENTRES[0]] += [60.0, 0.0]
    pose = head_pose(pixels, CAMERA)
    assert pose is not None
    left = eyes(pixels, pose, CAMERA).gaze[0]
    assert np.linalg.norm(left) == pytest.approx(1)
    assert left[0] > 0.95


def shapes(smile: float = 0.0, squint: float = 0.0, blink: float = 0.0) -> dict[str, float]:
    values = {"mouthSmile": smile, "eyeSquint": squint, "eyeBlink": blink}
    return {f"{name}{side}": v for name, v in values.items() for side in ("Left", "Right")}


@given(st.floats(0, 1), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
def test_a_wider_smile_never_lowers_the_feature(
    a: float, b: float, squint: float, c: float
) -> None:
    low, high = sorted((a, b))
    weak, strong = (smile_intensity(shapes(s, squint, c)) for s in (low, high))
    assert 0 <= weak <= strong <= 5


@given(st.floats(0, 1), st.floats(0, 1))
def test_without_pulled_lip_corners_nothing_smiles(squint: float, blink: float) -> None:
    assert smile_intensity(shapes(0.0, squint, blink)) == 0


def test_the_scale_of_smiles() -> None:
    # Scores as the network gives them for a neutral face, a plain smile and a laugh.
    assert smile_intensity(shapes(0.05, 0.3, 0.1)) < 0.1
    assert 2 < smile_intensity(shapes(0.82, 0.38, 0.12)) < 3
    assert smile_intensity(shapes(1.0, 1.0, 0.0)) == 5


def test_a_blink_does_not_raise_the_cheeks() -> None:
    open_eyes, closing_eyes = shapes(0.87, 0.40, 0.15), shapes(0.87, 0.61, 0.52)
    assert action_units(closing_eyes)[0] == pytest.approx(action_units(open_eyes)[0], abs=0.25)


def test_missing_scores_make_the_smile_unknown() -> None:
    assert math.isnan(smile_intensity({}))
    assert not lids_down({})


def test_closed_lids_are_down() -> None:
    assert lids_down(shapes(blink=0.8))
    assert not lids_down(shapes(blink=0.3))


def test_without_opencv_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(MissingExtraError, match=r"kendon\[camera\]"):
        head_pose(np.zeros((LANDMARKS, 2)), CAMERA)

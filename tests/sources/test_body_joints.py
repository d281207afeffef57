"""Joints from a body that is projected and so is known, as the Pose Landmarker would give it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from sources.painted_faces import face_at, seen

from kendon.errors import ModelFileError
from kendon.person import JOINTS
from kendon.sources.base import CameraMount
from kendon.sources.body_joints import (
    JOINT_LANDMARKS,
    LANDMARKS,
    BodyReading,
    body_joints,
    match_bodies,
)
from kendon.sources.camera_geometry import FloatArray, Intrinsics, MountedCamera
from kendon.sources.face_finder import FaceBox
from kendon.sources.face_person import PersonReader
from kendon.sources.pose_landmarks import bodies_of, check_pose_model

pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")

CAMERA = Intrinsics.from_fov(1280, 720, np.radians(75))

#: A person 1.75 m tall who waves with the right hand, about the middle of the hips [m]: x to the
#: person's left as the camera sees it (right in the image), y down, z away from the camera.
BODY: dict[int, tuple[float, float, float]] = {
    0: (0.0, -0.66, -0.16), 2: (0.032, -0.70, -0.13), 5: (-0.032, -0.70, -0.13),
    7: (0.075, -0.68, -0.03), 8: (-0.075, -0.68, -0.03),
    11: (0.18, -0.48, 0.0), 12: (-0.18, -0.48, 0.0), 13: (0.24, -0.20, 0.02),
    14: (-0.40, -0.42, -0.12), 15: (0.25, 0.05, -0.04), 16: (-0.42, -0.70, -0.18),
    23: (0.10, 0.0, 0.0), 24: (-0.10, 0.0, 0.0), 25: (0.11, 0.42, -0.02), 26: (-0.11, 0.42, -0.02),
}  # fmt: skip


def body(
    place: FloatArray, *, turn: float = 0.0, size: float = 1.0, guessed: float = 1.0,
    camera: Intrinsics = CAMERA,
) -> tuple[BodyReading, FloatArray]:  # fmt: skip
    """A person's landmarks, and where their points truly are in the optical frame (33, 3) [m].

    Args:
        place: the middle of the hips, optical frame [m].
        turn: of the body about the vertical [rad].
        size: of the person, beside one of 1.75 m.
        guessed: the size that the network takes them to have.
        camera: that sees them.
    """
    points = np.zeros((LANDMARKS, 3))
    points[list(BODY)] = list(BODY.values())
    points = points @ Rotation.from_euler("y", turn).as_matrix().T
    true = size * points + place
    visible = np.zeros(LANDMARKS)
    visible[list(BODY)] = 0.95
    return BodyReading(camera.bend(camera.project(true)), guessed * points, visible), true


def eyes(true: FloatArray) -> FloatArray:
    return np.asarray(true[[2, 5]].mean(axis=0))


@settings(deadline=None, max_examples=50)
@given(
    st.floats(-0.5, 0.5), st.floats(2.2, 5.0), st.floats(-0.7, 0.7), st.floats(0.75, 1.15),
    st.floats(0.9, 1.1),
)  # fmt: skip
def test_joints_are_where_they_are_whatever_size_the_network_guesses(
    x: float, z: float, turn: float, size: float, guessed: float
) -> None:
    reading, true = body(np.array([x * z / 3, 0.3, z]), turn=turn, size=size, guessed=guessed)
    joints = body_joints(reading, eyes(true), CAMERA)
    inside = [
        name for name, i in JOINT_LANDMARKS.items()
        if (reading.image[i] >= 0).all() and (reading.image[i] <= (1280, 720)).all()
    ]  # fmt: skip
    assert list(joints) == inside
    assert set(joints) <= set(JOINTS)
    for name, place in joints.items():
        assert place == pytest.approx(true[JOINT_LANDMARKS[name]], abs=0.01)


def test_noise_of_a_few_pixels_moves_joints_by_centimetres() -> None:
    rng = np.random.default_rng(0)
    errors = []
    for _ in range(40):
        reading, true = body(np.array([0.2, 0.3, 2.5]), turn=0.3)
        noisy = BodyReading(
            reading.image + rng.normal(0, 3, reading.image.shape),
            reading.world + rng.normal(0, 0.02, reading.world.shape),
            reading.visibility,
        )
        joints = body_joints(noisy, eyes(true), CAMERA)
        errors += [np.linalg.norm(joints[n] - true[JOINT_LANDMARKS[n]]) for n in joints]
    assert np.median(errors) < 0.10


def test_joints_that_are_hidden_or_outside_the_picture_are_left_out() -> None:
    reading, true = body(np.array([0.0, 0.3, 2.5]))
    hidden = reading.visibility.copy()
    hidden[16] = 0.2
    joints = body_joints(BodyReading(reading.image, reading.world, hidden), eyes(true), CAMERA)
    assert "r_wrist" not in joints
    assert "r_elbow" in joints
    close, true = body(np.array([0.0, 0.6, 1.1]))
    assert "l_hip" not in body_joints(close, eyes(true), CAMERA)
    assert "l_shoulder" in body_joints(close, eyes(true), CAMERA)


def test_too_little_of_a_body_gives_no_joints() -> None:
    reading, true = body(np.array([0.0, 0.3, 2.5]))
    few = np.where(np.isin(np.arange(LANDMARKS), [2, 5, 11, 12]), 0.9, 0.1)
    assert body_joints(BodyReading(reading.image, reading.world, few), eyes(true), CAMERA) == {}
    unknown = np.full_like(reading.world, np.nan)
    bad = BodyReading(reading.image, unknown, reading.visibility)
    assert body_joints(bad, eyes(true), CAMERA) == {}


def test_a_body_that_contradicts_itself_or_the_face_gives_no_joints() -> None:
    reading, true = body(np.array([0.0, 0.3, 2.5]))
    shuffled = reading.image.copy()
    shuffled[[11, 12, 13, 14, 15, 16]] = shuffled[[16, 15, 23, 11, 12, 13]]
    mixed = BodyReading(shuffled, reading.world, reading.visibility)
    assert body_joints(mixed, eyes(true), CAMERA) == {}
    assert body_joints(reading, 2.0 * eyes(true), CAMERA) == {}


def test_a_lens_that_bends_is_straightened() -> None:
    lens = (-0.25, 0.08, 0.0, 0.0)
    camera = Intrinsics(1280, 720, CAMERA.focal, CAMERA.focal, CAMERA.centre, lens)
    reading, true = body(np.array([0.9, 0.3, 3.0]), camera=camera)
    joints = body_joints(reading, eyes(true), camera)
    assert joints["l_shoulder"] == pytest.approx(true[11], abs=0.01)


def test_a_body_belongs_to_the_face_that_its_eyes_are_in() -> None:
    left, _ = body(np.array([-0.8, 0.3, 3.0]))
    right, _ = body(np.array([0.8, 0.3, 3.0]))
    boxes = {
        n: FaceBox(one.face[0] - 20, one.face[1] - 25, 40, 50) for n, one in ((3, right), (7, left))
    }
    matched = match_bodies([left, right], boxes)
    assert matched == {3: right, 7: left}
    assert match_bodies([left], {3: boxes[3]}) == {}


def test_joints_come_into_the_robots_frame() -> None:
    """A whole person: the face by its own landmarks, the body by the pose's."""
    reading, true = body(np.array([0.3, 0.3, 2.5]))
    x, y, z = eyes(true).tolist()
    face = seen(1, face_at(x, y, z, camera=CAMERA))
    mounted = MountedCamera.from_mount(CameraMount((0.1, 0.0, 1.0)))
    reader = PersonReader(CAMERA, mounted)
    found = reader.pose(face)
    assert found is not None
    joints = body_joints(reading, found[1].position, CAMERA)
    frame = reader.read([face], 0.0, {1: joints}).frame
    assert set(frame.joints) == set(JOINTS)
    wrist = true[JOINT_LANDMARKS["r_wrist"]]
    expected = (0.1 + wrist[2], -wrist[0], 1.0 - wrist[1])
    assert frame.joints["r_wrist"] == pytest.approx(expected, abs=0.03)
    assert frame.joints["r_wrist"][2] > frame.joints["r_shoulder"][2] + 0.2  # it is raised


def test_a_recorded_result_of_the_network_is_understood() -> None:
    reading, _ = body(np.array([0.0, 0.3, 2.5]))

    def landmark(xyz: Any, visibility: float) -> SimpleNamespace:
        x, y, z = (float(v) for v in xyz)
        return SimpleNamespace(x=x, y=y, z=z, visibility=visibility)

    shares = np.column_stack([reading.image / (1280, 720), np.zeros(LANDMARKS)])
    result = SimpleNamespace(
        pose_landmarks=[[landmark(*one) for one in zip(shares, reading.visibility, strict=True)]],
        pose_world_landmarks=[[landmark(xyz, 0.0) for xyz in reading.world]],
    )
    (again,) = bodies_of(result, 1280, 720)
    assert again.image == pytest.approx(reading.image)
    assert again.world == pytest.approx(reading.world)
    assert again.visibility == pytest.approx(reading.visibility)


def test_a_missing_pose_model_says_where_to_get_one(tmp_path: Any) -> None:
    with pytest.raises(ModelFileError, match=r"no such file; get pose_landmarker_lite\.task"):
        check_pose_model(tmp_path / "none.task")

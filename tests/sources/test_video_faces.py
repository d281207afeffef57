"""Real faces: what the camera says must be what a person sees in the picture.

Each test reads some two seconds of video.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shared_data import shared_file

from kendon.errors import ModelFileError
from kendon.features import eye_gaze, head_gaze
from kendon.person import PersonFrame
from kendon.sources.base import CameraMount, SourceOptions, open_source
from kendon.sources.camera_geometry import Intrinsics, MountedCamera
from kendon.sources.face_geometry import EYE_CORNERS
from kendon.sources.face_landmarks import FaceLandmarker
from kendon.sources.face_person import PersonReader

cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")
pytest.importorskip("mediapipe", reason="MediaPipe is not installed (the 'camera' extra)")

ROBOT_FACE = np.array([0.0, 0.0, 1.2])


def model() -> Path:
    return shared_file("models/face_landmarker.task")


def options(**values: Any) -> SourceOptions:
    return SourceOptions(model_files=model().parent, **values)


def read_images(
    path: Path, first: int, count: int, change: Callable[[Any], Any] = lambda image: image
) -> list[PersonFrame]:
    """Persons in `count` frames of a video from frame `first` on, each image changed before."""
    capture = cv2.VideoCapture(str(path))
    capture.set(cv2.CAP_PROP_POS_FRAMES, first)
    camera = Intrinsics.from_fov(int(capture.get(3)), int(capture.get(4)))
    reader = PersonReader(camera, MountedCamera.from_mount(CameraMount()))
    persons = []
    with FaceLandmarker(model()) as landmarker:
        for i in range(count):
            good, image = capture.read()
            assert good
            rgb = np.ascontiguousarray(change(cv2.cvtColor(image, cv2.COLOR_BGR2RGB)))
            persons.append(reader.read(landmarker.detect(rgb, i / 24), i / 24))
    capture.release()
    return persons


def eyes_on_robot(frames: list[PersonFrame]) -> float:
    """The median gaze by the eyes of the frames in which they are seen."""
    return float(
        np.median(
            [
                eye_gaze(np.array(f.eyes), np.array(f.eye_gaze), ROBOT_FACE)
                for f in frames
                if f.eye_gaze is not None
            ]
        )
    )


def head_axis(frame: PersonFrame) -> Any:
    """Where the face points, in the base frame (3,)."""
    return Rotation.from_quat(frame.head_rotation).apply([1.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def man() -> list[PersonFrame]:
    """All 2.4 s of a man with a phone: a neutral face, a broad smile, and back at the very end."""
    source = open_source(shared_file("data/faces/single_face.mp4"), options())
    return list(source.frames())


def test_every_frame_shows_him_at_the_files_own_times(man: list[PersonFrame]) -> None:
    assert len(man) == 72
    assert all(frame.seen for frame in man)
    assert [frame.t for frame in man] == pytest.approx([i / 30 for i in range(72)], abs=1e-3)


def test_he_is_at_arms_length_at_the_cameras_height(man: list[PersonFrame]) -> None:
    x, y, z = np.median([frame.head for frame in man], axis=0)
    assert 0.4 < x < 0.7
    assert abs(y) < 0.1
    assert abs(z - 1.2) < 0.1


def test_his_eyes_are_as_far_apart_as_eyes_are(man: list[PersonFrame]) -> None:
    apart = [np.linalg.norm(np.subtract(*frame.eyes)) for frame in man if frame.eyes]
    assert 0.058 < np.median(apart) < 0.070


def test_he_looks_into_the_camera_with_head_and_eyes(man: list[PersonFrame]) -> None:
    assert eyes_on_robot(man) < 0.4
    heads = [
        head_gaze(np.array(frame.head), np.array(frame.head_rotation), ROBOT_FACE) for frame in man
    ]
    assert np.median(heads) < 0.2


def test_his_neutral_face_and_his_smile_lie_on_the_scale(man: list[PersonFrame]) -> None:
    neutral = [frame.smile for frame in (*man[:15], man[-1])]
    smiling = [frame.smile for frame in man if 0.8 < frame.t < 2.2]
    assert max(neutral) < 0.7
    assert 2.0 < np.median(smiling) < 3.5
    assert min(smiling) > 1.5


def test_the_mount_moves_him_along(man: list[PersonFrame]) -> None:
    mount = CameraMount(position=(0.1, 0.0, 0.5), yaw=math.radians(90))
    source = open_source(shared_file("data/faces/single_face.mp4"), options(camera=mount))
    moved = next(iter(source.frames()))
    straight = man[0]
    assert moved.head[1] == pytest.approx(straight.head[0], abs=1e-6)
    assert moved.head[2] == pytest.approx(straight.head[2] - 0.7, abs=1e-6)


def test_a_mirrored_face_is_a_mirrored_person() -> None:
    path = shared_file("data/faces/WolfgangLanger_Pexels.mp4")
    as_seen = read_images(path, 232, 8)[-1]
    mirrored = read_images(path, 232, 8, lambda image: image[:, ::-1])[-1]
    assert mirrored.head == pytest.approx(np.array(as_seen.head) * [1, -1, 1], abs=0.02)
    assert head_axis(mirrored) == pytest.approx(head_axis(as_seen) * [1, -1, 1], abs=0.1)
    assert as_seen.eye_gaze is not None
    assert mirrored.eye_gaze is not None
    ours, theirs = np.mean(as_seen.eye_gaze, axis=0), np.mean(mirrored.eye_gaze, axis=0)
    assert theirs == pytest.approx(ours * [1, -1, 1], abs=0.2)
    # She stands on the image's right, the robot's right, and looks farther to her left.
    assert as_seen.head[1] < -0.03
    assert ours[1] < -0.2


def test_looking_at_the_camera_and_beside_it_are_told_apart() -> None:
    path = shared_file("data/faces/WolfgangLanger_Pexels.mp4")
    frames = read_images(path, 230, 62)
    beside, at, beside_again = frames[2:9], frames[26:36], frames[52:60]
    assert eyes_on_robot(at) < 0.5
    assert eyes_on_robot(beside) > 0.8
    assert eyes_on_robot(beside_again) > 0.8
    # Meanwhile the head hardly moves: only the eyes can tell.
    turns = [math.degrees(math.atan2(*head_axis(f)[1::-1])) % 360 for f in (*beside, *at)]
    assert max(turns) - min(turns) < 15


def test_lowered_lids_look_down_and_not_at_the_robot() -> None:
    source = open_source(shared_file("data/faces/WolfgangLanger_Pexels.mp4"), options())
    frames = list(islice(source.frames(), 48))
    assert all(frame.seen and frame.eyes is not None for frame in frames)
    assert frames[5].eye_gaze is None  # it could still be a blink
    lowered = frames[20:]
    assert eyes_on_robot(lowered) > 0.4
    down = [np.mean(frame.eye_gaze, axis=0)[2] for frame in lowered if frame.eye_gaze]
    assert len(down) == len(lowered)
    assert np.median(down) < -0.15


def test_of_several_people_the_nearest_is_followed() -> None:
    image = cv2.imread(str(shared_file("data/faces/multi_face.jpg")))
    assert image is not None
    height, width = image.shape[:2]
    camera = Intrinsics.from_fov(width, height)
    rgb = cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
    with FaceLandmarker(model()) as landmarker:
        faces = landmarker.detect(rgb, 0.0)
    assert len(faces) >= 2
    mounted = MountedCamera.from_mount(CameraMount())
    alone = [PersonReader(camera, mounted).read([face], 0.0) for face in faces]
    together = PersonReader(camera, mounted).read(faces, 0.0)
    assert np.linalg.norm(np.subtract(together.head, ROBOT_FACE)) == pytest.approx(
        min(np.linalg.norm(np.subtract(person.head, ROBOT_FACE)) for person in alone)
    )


def test_a_picture_without_a_face_gives_an_unknown_head() -> None:
    with FaceLandmarker(model()) as landmarker:
        faces = landmarker.detect(np.zeros((120, 160, 3), dtype=np.uint8), 0.0)
    assert faces == []
    reader = PersonReader(Intrinsics.from_fov(160, 120), MountedCamera.from_mount(CameraMount()))
    person = reader.read(faces, 1.5)
    assert person.t == 1.5
    assert not person.seen


def test_landmarks_come_with_iris_and_blendshapes() -> None:
    path = shared_file("data/faces/single_face.mp4")
    capture = cv2.VideoCapture(str(path))
    image = capture.read()[1]
    capture.release()
    with FaceLandmarker(model()) as landmarker:
        (face,) = landmarker.detect(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), 0.0)
    assert face.landmarks.shape == (478, 2)
    assert {"mouthSmileLeft", "eyeSquintRight", "eyeBlinkLeft"} <= face.blendshapes.keys()
    # The person's left eye is on the image's right, its outer corner still farther right.
    inner, outer = (face.landmarks[i, 0] for i in EYE_CORNERS[0])
    assert face.landmarks[133, 0] < inner < outer


def test_a_file_that_is_no_model_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "face_landmarker.task"
    path.write_bytes(b"no model")
    with pytest.raises(ModelFileError, match=r"face_landmarker\.task: MediaPipe cannot read"):
        FaceLandmarker(path)


def test_the_terminal_stays_clean(capfd: pytest.CaptureFixture[str]) -> None:
    source = open_source(shared_file("data/faces/single_face.mp4"), options())
    next(iter(source.frames()))
    assert capfd.readouterr() == ("", "")

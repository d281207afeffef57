"""Real faces: what the camera says must be what a person sees in the picture.

Each test reads some two seconds of video.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import closing
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shared_data import shared_file

from kendon.errors import ModelFileError
from kendon.features import eye_gaze, head_gaze
from kendon.models import load_model
from kendon.person import PersonFrame
from kendon.sources.base import CameraMount, SourceOptions, open_source
from kendon.sources.camera_geometry import Intrinsics, MountedCamera
from kendon.sources.face_finder import YuNet
from kendon.sources.face_geometry import EYE_CORNERS
from kendon.sources.face_landmarks import FaceLandmarker, Window
from kendon.sources.face_person import PersonReader
from kendon.sources.face_reader import FaceReader
from kendon.sources.video import VideoSource
from kendon.viewer.overlay import OverlayVideo
from kendon.watch import Watch

cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")
pytest.importorskip("mediapipe", reason="MediaPipe is not installed (the 'camera' extra)")

ROBOT_FACE = np.array([0.0, 0.0, 1.2])


def model() -> Path:
    return shared_file("models/face_landmarker.task")


def faces() -> FaceReader:
    """Finds and reads faces with the networks lent for testing."""
    finder = YuNet(shared_file("models/face_detection_yunet_2026may.onnx"))
    return FaceReader(finder, FaceLandmarker(model()))


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
    with closing(faces()) as detector:
        for i in range(count):
            good, image = capture.read()
            assert good
            changed = np.ascontiguousarray(change(image))
            persons.append(reader.read(detector.detect(changed, i / 24), i / 24).frame)
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


def test_of_several_people_the_nearest_who_faces_the_robot_is_greeted() -> None:
    image = cv2.imread(str(shared_file("data/faces/multi_face.jpg")))
    assert image is not None
    height, width = image.shape[:2]
    camera = Intrinsics.from_fov(width, height)
    with closing(faces()) as detector:
        seen = detector.detect(image, 0.0)
    assert len(seen) >= 4  # the largest four of seven
    assert [face.number for face in seen] == list(range(1, len(seen) + 1))
    mounted = MountedCamera.from_mount(CameraMount())
    scene = PersonReader(camera, mounted).read(seen, 0.0)
    alone = [PersonReader(camera, mounted).read([face], 0.0).frame for face in seen]
    facing = [
        person
        for person in alone
        if head_gaze(np.array(person.head), np.array(person.head_rotation), ROBOT_FACE) < 0.9
    ]
    assert len(facing) >= 2
    assert np.linalg.norm(np.subtract(scene.frame.head, ROBOT_FACE)) == pytest.approx(
        min(np.linalg.norm(np.subtract(person.head, ROBOT_FACE)) for person in facing)
    )


def test_a_picture_without_a_face_gives_an_unknown_head() -> None:
    with closing(faces()) as detector:
        seen = detector.detect(np.zeros((120, 160, 3), dtype=np.uint8), 0.0)
    assert seen == []
    reader = PersonReader(Intrinsics.from_fov(160, 120), MountedCamera.from_mount(CameraMount()))
    person = reader.read(seen, 1.5).frame
    assert person.t == 1.5
    assert not person.seen


def shrunk(image: Any, scale: float, width: int = 1280, height: int = 720) -> Any:
    """A picture `scale` times as large, in the middle of a grey scene with a sensor's noise."""
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    scene = np.full((height, width, 3), 110.0)
    top, left = (height - small.shape[0]) // 2, (width - small.shape[1]) // 2
    scene[top : top + small.shape[0], left : left + small.shape[1]] = small
    noise = np.random.default_rng(0).normal(0, 3, scene.shape)
    return np.clip(scene + noise, 0, 255).astype(np.uint8)


def first_image(path: Path) -> Any:
    capture = cv2.VideoCapture(str(path))
    image = capture.read()[1]
    capture.release()
    return image


def test_a_face_as_small_as_at_four_metres_is_as_far_away() -> None:
    image = first_image(shared_file("data/faces/single_face.mp4"))
    mounted = MountedCamera.from_mount(CameraMount())
    near_camera, camera = Intrinsics.from_fov(640, 360), Intrinsics.from_fov(1280, 720)
    with closing(faces()) as detector:
        near = PersonReader(near_camera, mounted).read(detector.detect(image, 0.0), 0.0).frame
    for wanted in (2.0, 4.0):
        scale = near.head[0] * camera.focal / near_camera.focal / wanted
        with closing(faces()) as detector:
            seen = detector.detect(shrunk(image, scale), 0.0)
        person = PersonReader(camera, mounted).read(seen, 0.0).frame
        assert person.head[0] == pytest.approx(wanted, rel=0.08)
        assert head_axis(person) == pytest.approx(head_axis(near), abs=0.2)


def test_past_the_range_nobody_is_placed() -> None:
    image = first_image(shared_file("data/faces/single_face.mp4"))
    camera = Intrinsics.from_fov(1280, 720)
    with closing(faces()) as detector:
        seen = detector.detect(shrunk(image, 0.15), 0.0)  # as at 6.8 m
    scene = PersonReader(camera, MountedCamera.from_mount(CameraMount())).read(seen, 0.0)
    assert not scene.frame.seen
    assert math.isnan(scene.frame.smile)


def test_landmarks_come_with_iris_and_blendshapes() -> None:
    path = shared_file("data/faces/single_face.mp4")
    rgb = cv2.cvtColor(first_image(path), cv2.COLOR_BGR2RGB)
    with closing(FaceLandmarker(model())) as landmarker:
        face = landmarker.read(rgb, Window(140, 0, 360))
        nothing = landmarker.read(rgb, Window(2000, 0, 50))
    assert nothing is None
    assert face is not None
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


def test_the_overlay_of_a_real_video_shows_his_box(tmp_path: Path) -> None:
    path = tmp_path / "seen.mp4"
    source = open_source(shared_file("data/faces/single_face.mp4"), options())
    assert isinstance(source, VideoSource)
    with OverlayVideo(path, source.rate) as video:
        for watched in Watch(source, load_model()).run(seconds=0.5):
            video.add(watched)
    capture = cv2.VideoCapture(str(path))
    assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == 16
    assert capture.get(cv2.CAP_PROP_FPS) == pytest.approx(30)
    assert source.look is not None
    (man,) = source.look.scene.people
    assert man.face.number == source.look.scene.greeted == 1
    assert 0.15 < man.face.box.width / source.look.camera.width < 0.35

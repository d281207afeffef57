"""The overlay: what is drawn where, and a video that is whole or not there."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sources.painted_faces import face_at, seen

from kendon.errors import DataError
from kendon.models import load_model
from kendon.observations import Observation
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.sources.base import CameraMount
from kendon.sources.camera_geometry import Intrinsics, MountedCamera
from kendon.sources.face_person import PersonReader
from kendon.sources.pictures import Look, Picture
from kendon.viewer.overlay import OverlayVideo, check_overlay, draw_overlay, frame_gaze, gaze_ray
from kendon.watch import WatchedFrame

cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")

CAMERA = Intrinsics.from_fov(960, 540)
FACE = (0.0, 0.0, 1.2)


def watched(
    t: float = 0.0, *, yaw: float = 0.0, z: float = 1.0, belief: bool = True
) -> WatchedFrame:
    """Somebody in a black picture."""
    reader = PersonReader(CAMERA, MountedCamera.from_mount(CameraMount()))
    scene = reader.read([seen(1, face_at(0.1, 0, z, yaw=yaw, camera=CAMERA))], t)
    picture = Picture(t, np.zeros((540, 960, 3), dtype=np.uint8), 0.0)
    look = Look(picture, CAMERA, MountedCamera.from_mount(CameraMount()), scene)
    observation = Observation(0.2, z, 0.0, 0.1, 2.5)
    tracker = load_model().tracker()
    return WatchedFrame(
        scene.frame, look, observation if belief else None,
        tracker.step(observation) if belief else None,
    )  # fmt: skip


def colours(image: Any) -> set[tuple[int, ...]]:
    return {tuple(c) for c in image.reshape(-1, 3).tolist()}


def test_the_box_is_around_the_face_and_the_panel_beside_the_picture() -> None:
    frame = watched()
    image = draw_overlay(frame)
    assert image.shape == (540, 960 + 296, 3)
    assert frame.look is not None
    box = frame.look.scene.people[0].face.box
    middle = round(box.y + box.height / 2)
    assert image[middle, round(box.x)].min() > 200
    assert image[middle, round(box.x + box.width)].min() > 200
    assert image[middle, round(box.x) - 20].max() == 0
    assert frame.look.picture.image is not None
    assert frame.look.picture.image.max() == 0  # the source's own picture is left alone


def test_belief_bars_have_the_phases_colours_and_lengths() -> None:
    frame = watched()
    assert frame.belief is not None
    panel = draw_overlay(frame)[:, 960:]
    for phase in Phase:
        red, green, blue = (int(phase.color[i : i + 2], 16) for i in (1, 3, 5))
        length = int((panel == (blue, green, red)).all(axis=2).sum(axis=1).max())
        expected = frame.belief.probabilities[phase.index] * 114  # the bar's whole width
        if expected > 10:
            assert length == pytest.approx(expected, abs=4)


def test_unknown_values_have_no_bar() -> None:
    known, unknown = draw_overlay(watched()), draw_overlay(watched(belief=False))
    bar = (200, 180, 120)
    assert bar in colours(known)
    assert bar not in colours(unknown)


def test_who_looks_at_the_robot_has_a_green_ray_and_who_looks_aside_has_not() -> None:
    at, aside = watched(yaw=-0.1), watched(yaw=0.9, z=2.6)  # so far away the head decides
    assert at.look is not None
    assert frame_gaze(at.frame, FACE) < 1
    assert (90, 220, 90) in colours(draw_overlay(at))
    assert frame_gaze(aside.frame, FACE) > 1
    assert (60, 150, 255) in colours(draw_overlay(aside))
    assert (90, 220, 90) not in colours(draw_overlay(aside))


@pytest.mark.parametrize("z", [1.0, 2.0, 2.6])
def test_the_ray_goes_the_way_the_face_does(z: float) -> None:
    look = watched(yaw=0.3, z=z).look
    assert look is not None
    start, direction = gaze_ray(look.scene.people[0])
    assert np.linalg.norm(direction) == pytest.approx(1)
    assert direction[0] > 0.1  # to the person's left, the image's right
    assert np.linalg.norm(start - (0.1, 0, z)) < 0.05


def test_a_frame_without_eyes_has_the_heads_gaze() -> None:
    assert math.isnan(frame_gaze(PersonFrame(0.0), FACE))


@pytest.mark.parametrize("name", ["seen.mp4", "seen.avi"])
def test_the_video_lasts_as_long_as_what_was_watched(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with OverlayVideo(path, math.nan) as video:
        for t in (0.0, 0.1, 0.15, 0.5, 1.0):  # as frames come from a camera
            video.add(watched(t))
        video.add(WatchedFrame(PersonFrame(1.1), None, None, None))
    assert list(tmp_path.iterdir()) == [path]
    capture = cv2.VideoCapture(str(path))
    assert capture.get(cv2.CAP_PROP_FPS) == pytest.approx(20)
    images = []
    while (read := capture.read())[0]:
        images.append(read[1])
    assert len(images) == 21
    assert images[0].shape == (540, 1256, 3)


def test_a_video_that_fails_half_way_leaves_nothing(tmp_path: Path) -> None:
    def fail() -> Iterator[float]:
        yield 0.0
        raise RuntimeError("inside")

    def draw() -> None:
        with OverlayVideo(tmp_path / "seen.avi", 10.0) as video:
            for t in fail():
                video.add(watched(t))

    with pytest.raises(RuntimeError, match="inside"):
        draw()
    assert list(tmp_path.iterdir()) == []


def test_a_codec_that_is_not_there_offers_another_ending(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class NoCodec(SimpleNamespace):
        fourcc = staticmethod(cv2.VideoWriter.fourcc)

        def __call__(self, *arguments: object) -> Any:
            return SimpleNamespace(isOpened=lambda: False)

    monkeypatch.setattr(cv2, "VideoWriter", NoCodec())
    with (
        pytest.raises(DataError, match=r"seen\.mp4: .*codec mp4v.* or name an \.avi instead"),
        OverlayVideo(tmp_path / "seen.mp4", 10.0) as video,
    ):
        video.add(watched())
    assert list(tmp_path.iterdir()) == []


def test_other_endings_and_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"\.mp4 or \.avi"):
        check_overlay(tmp_path / "seen.gif")
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match="file is not a folder"):
        check_overlay(tmp_path / "file" / "seen.mp4")

"""The video source, with a painted video and a detector that sees what it is told."""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sources.painted_faces import CAMERA, HEIGHT, WIDTH, ToldDetector, face_at, seen

from kendon.errors import DataError, MissingExtraError, ParameterError
from kendon.sources import video
from kendon.sources.base import CameraMount, SourceOptions, open_source, registered_sources
from kendon.sources.camera import CameraSource
from kendon.sources.camera_geometry import MountedCamera
from kendon.sources.face_person import PersonReader
from kendon.sources.quiet import quiet_stderr
from kendon.sources.video import VideoSource

cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")


def paint(path: Path, frames: int = 10, fps: float = 10.0, codec: str = "MJPG") -> Path:
    """A video of noise with a red upper half."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), fps, (WIDTH, HEIGHT))
    assert writer.isOpened()
    image = np.random.default_rng(0).integers(0, 80, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    image[: HEIGHT // 2] = (0, 0, 255)
    for _ in range(frames):
        writer.write(image)
    writer.release()
    return path


class FakeCapture:
    """A `cv2.VideoCapture` of black frames."""

    def __init__(
        self, frames: int, opened: bool = True, stamps: float = math.nan, fps: float = 0.0
    ) -> None:
        self.left, self.opened, self.stamps, self.fps = frames, opened, stamps, fps
        self.released = False

    def isOpened(self) -> bool:  # noqa: N802 - OpenCV's name
        return self.opened

    def read(self) -> tuple[bool, Any]:
        self.left -= 1
        if self.left < 0:
            return False, None
        return True, np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)

    def get(self, prop: int) -> float:
        return {cv2.CAP_PROP_POS_MSEC: self.stamps, cv2.CAP_PROP_FPS: self.fps}.get(prop, 0.0)

    def set(self, prop: int, value: float) -> bool:
        return True

    def release(self) -> None:
        self.released = True


@pytest.fixture
def no_models(monkeypatch: pytest.MonkeyPatch) -> ToldDetector:
    """Sources make this detector instead of MediaPipe's."""
    detector = ToldDetector([seen(1, face_at(0, 0, 1))])
    monkeypatch.setattr(video, "detector_maker", lambda options: lambda: detector.both)
    return detector


@pytest.mark.parametrize("name", ["a.mp4", "A.MOV", "b.avi", "c.mkv", "d.webm", "e.m4v"])
def test_videos_are_recognised_by_their_ending(name: str) -> None:
    assert VideoSource.recognises(name)
    assert not CameraSource.recognises(name)


@pytest.mark.parametrize("name", ["a.csv", "mp4", "camera", "camera:0", "a.mp4.csv"])
def test_other_files_are_no_videos(name: str) -> None:
    assert not VideoSource.recognises(name)


def test_cameras_are_recognised_by_their_word() -> None:
    assert CameraSource.recognises("camera")
    assert CameraSource.recognises("camera:2")
    assert not CameraSource.recognises("cameraman.csv")
    assert CameraSource.live
    assert not VideoSource.live


def test_both_are_registered() -> None:
    assert registered_sources()["video"] is VideoSource
    assert registered_sources()["camera"] is CameraSource


def test_each_video_frame_is_one_person_frame(tmp_path: Path, no_models: ToldDetector) -> None:
    source = open_source(paint(tmp_path / "a.avi"))
    frames = list(source.frames())
    assert [f.t for f in frames] == pytest.approx([i / 10 for i in range(10)])
    assert frames[0].head == pytest.approx((1, 0, 1.2), abs=1e-3)
    assert frames[0].smile > 1
    assert frames[0].eye_gaze is not None
    assert not any(f.seen for f in frames[1:])
    assert no_models.closed


def test_the_detector_gets_blue_green_red(tmp_path: Path, no_models: ToldDetector) -> None:
    list(open_source(paint(tmp_path / "a.avi", frames=1)).frames())
    assert no_models.images[0][10, 10] == pytest.approx([0, 0, 255], abs=12)


def test_an_assumed_field_of_view_is_noted(tmp_path: Path, no_models: ToldDetector) -> None:
    path = paint(tmp_path / "a.avi", frames=1)
    assert "60 degrees" in open_source(path).notes[0]
    assert open_source(path, SourceOptions(fov=1.2)).notes == ()


def test_a_video_can_be_read_twice(tmp_path: Path, no_models: ToldDetector) -> None:
    source = open_source(paint(tmp_path / "a.avi", frames=3))
    assert len(list(source.frames())) == len(list(source.frames())) == 3


def test_a_missing_video_and_a_folder_say_so(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"none\.mp4: there is no such video"):
        open_source(tmp_path / "none.mp4")
    (tmp_path / "dir.mp4").mkdir()
    with pytest.raises(DataError, match="folder"):
        open_source(tmp_path / "dir.mp4")


@pytest.mark.parametrize("content", [b"", b"not a video at all" * 100])
def test_what_is_no_video_is_refused(
    tmp_path: Path, content: bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.mp4"
    path.write_bytes(content)
    with pytest.raises(DataError, match=r"a\.mp4: this is no video"):
        open_source(path)
    assert capfd.readouterr().err == ""  # FFmpeg's own complaints stay off the terminal


def test_a_torn_mp4_without_its_index_is_refused(tmp_path: Path) -> None:
    path = paint(tmp_path / "a.mp4", codec="mp4v")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(DataError, match=r"a\.mp4: this is no video"):
        open_source(path)


def test_a_video_that_breaks_off_is_an_error_at_its_end(
    tmp_path: Path, no_models: ToldDetector
) -> None:
    path = paint(tmp_path / "a.avi", frames=40)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    frames = open_source(path).frames()
    assert next(frames).t == 0
    with pytest.raises(DataError, match=r"breaks off after [12]\.\d of 4\.0 s"):
        list(frames)


def test_a_video_without_frames_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, no_models: ToldDetector
) -> None:
    path = paint(tmp_path / "a.avi", frames=1)
    source = open_source(path)
    monkeypatch.setattr(video, "_open_file", lambda path: FakeCapture(0))
    with pytest.raises(DataError, match="no frame of this video can be read"):
        list(source.frames())


def test_frames_without_times_follow_the_frame_rate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, no_models: ToldDetector
) -> None:
    path = paint(tmp_path / "a.avi", frames=1)
    source = open_source(path)
    monkeypatch.setattr(video, "_open_file", lambda path: FakeCapture(3, stamps=0.0, fps=25.0))
    assert [f.t for f in source.frames()] == pytest.approx([0, 0.04, 0.08])
    told = open_source(path.rename(tmp_path / "b.avi"), SourceOptions(fps=50))
    monkeypatch.setattr(video, "_open_file", lambda path: FakeCapture(3, stamps=math.nan))
    assert [f.t for f in told.frames()] == pytest.approx([0, 0.02, 0.04])
    with pytest.raises(DataError, match="neither frame times nor a frame rate"):
        list(source.frames())


def test_an_impossible_field_of_view_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="field of view"):
        open_source(paint(tmp_path / "a.avi", frames=1), SourceOptions(fov=60))


@pytest.mark.parametrize("package", ["cv2", "mediapipe"])
def test_a_missing_package_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, package: str
) -> None:
    path = paint(tmp_path / "a.avi", frames=1)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError, match=r"kendon\[camera\]"):
        open_source(path)


def person_reader() -> PersonReader:
    mounted = MountedCamera.from_mount(CameraMount())
    return PersonReader(CAMERA, mounted)


def test_a_blink_hides_the_gaze_but_not_the_eyes() -> None:
    frame = person_reader().read([seen(1, face_at(0, 0, 1, blink=0.9))], 0.0).frame
    assert frame.eye_gaze is None
    assert frame.eyes is not None
    left, right = frame.eyes
    assert left[1] < -0.02 < 0.02 < right[1]


def test_lids_down_for_longer_than_a_blink_are_a_gaze() -> None:
    reader = person_reader()
    lids = [0.1, 0.9, 0.9, 0.1, 0.9, 0.9, 0.9, 0.9]
    times = [0.0, 0.1, 0.4, 0.5, 0.6, 0.9, 1.01, 1.1]
    gaze = [
        reader.read([seen(1, face_at(0, 0, 1, blink=b))], t).frame.eye_gaze
        for b, t in zip(lids, times, strict=True)
    ]
    assert [g is None for g in gaze] == [
        b > 0.5 and t < 1.005 for b, t in zip(lids, times, strict=True)
    ]


def test_quiet_stderr_gives_the_stream_back(capfd: pytest.CaptureFixture[str]) -> None:
    def noisy() -> None:
        with quiet_stderr():
            os.write(2, b"noise of native code\n")
            raise ValueError("inside")

    with pytest.raises(ValueError, match="inside"):
        noisy()
    os.write(2, b"after\n")
    assert capfd.readouterr().err == "after\n"

"""The live camera, one that drops frames and loses its plug, by a clock that is told the time."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import pytest
from fake_camera import PERIOD, Clock, Everywhere, FakeCamera
from sources.painted_faces import HEIGHT, WIDTH, ToldDetector

from kendon.errors import DataError, ParameterError
from kendon.person import PersonFrame
from kendon.sources import camera
from kendon.sources.base import SourceOptions, open_source
from kendon.sources.camera import DROPPED, RECONNECT, CameraSource
from kendon.sources.face_finder import ByteImage
from kendon.sources.face_reader import SeenFace

cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")


def source(*script: tuple[float, str]) -> tuple[CameraSource, FakeCamera, Everywhere]:
    clock, detector = Clock(), Everywhere()
    device = FakeCamera(clock, *script)
    made = CameraSource(
        2, SourceOptions(fov=1.0), lambda: detector.both, device.open, clock=clock,
        sleep=clock.sleep,
    )  # fmt: skip
    return made, device, detector


def stamps(frames: list[PersonFrame]) -> list[float]:
    return [frame.t for frame in frames]


def test_a_camera_needs_a_number() -> None:
    with pytest.raises(DataError, match="'camera:front' names no camera; write camera"):
        open_source("camera:front")


def test_an_absent_camera_says_what_to_check(monkeypatch: pytest.MonkeyPatch) -> None:
    class Absent:
        released = False

        def isOpened(self) -> bool:  # noqa: N802 - OpenCV's name
            return False

        def release(self) -> None:
            self.released = True

    absent = Absent()
    monkeypatch.setattr(cv2, "VideoCapture", lambda index: absent)
    monkeypatch.setattr(camera, "detector_maker", lambda options: lambda: ToldDetector().both)
    with pytest.raises(DataError, match="camera 7 does not open; check that it is plugged in"):
        open_source("camera:7")
    assert absent.released


def test_an_impossible_field_of_view_is_refused_before_the_camera_is_opened() -> None:
    with pytest.raises(ParameterError, match="field of view"):
        open_source("camera", SourceOptions(fov=60))


def test_frames_are_stamped_from_the_first_ones_arrival_on() -> None:
    made, _, detector = source((0.95, "fine"))
    frames, arrived = [], []
    for frame in made.frames():
        if made.look is not None:
            frames.append(frame)
            arrived.append(made.look.picture.arrived)
    assert stamps(frames) == pytest.approx([i * PERIOD for i in range(10)])
    assert arrived == pytest.approx([50.1 + i * PERIOD for i in range(10)])
    assert detector.closed


def test_dropped_frames_are_passed_over_without_a_word() -> None:
    made, device, _ = source((0.45, "fine"), (0.8, "dropping"), (1.5, "fine"), (60, "unplugged"))
    frames = list(made.frames())
    seen_at = [frame.t for frame in frames if frame.seen]
    gaps = [b - a for a, b in pairwise(seen_at)]
    assert max(gaps) == pytest.approx(0.4, abs=0.05)
    assert sorted(gaps)[-2] == pytest.approx(PERIOD)
    assert device.opened == 1
    assert len(made.notes) == 1  # of the end


def test_a_camera_that_comes_back_is_read_on_and_time_goes_on_meanwhile() -> None:
    made, device, detector = source((1, "fine"), (4, "unplugged"), (6, "fine"), (99, "unplugged"))
    frames = list(made.frames())
    assert all(b > a for a, b in pairwise(stamps(frames)))
    away = [frame for frame in frames if 1.1 < frame.t < 3.8]
    assert len(away) > 20  # nobody is seen, about ten times a second
    assert not any(frame.seen for frame in away)
    assert sum(frame.seen for frame in frames if 4.6 < frame.t < 5.8) >= 10
    assert device.opened == 2
    assert device.released == 2
    assert "camera 2 gave nothing from 0.9 to 4." in made.notes[0]
    assert "stopped giving pictures at 5." in made.notes[1]
    assert detector.closed


@pytest.mark.parametrize("end", ["unplugged", "dropping", "broken"])
def test_a_camera_that_stays_away_ends_cleanly(end: str) -> None:
    made, device, detector = source((1, "fine"), (1000, end))
    frames = list(made.frames())
    assert frames[-1].t == pytest.approx(1.0 + RECONNECT, abs=0.3)
    assert made.notes == (
        f"camera 2 stopped giving pictures at 0.9 s and did not come back within {RECONNECT:g} s;"
        " what was read until then counts",
    )
    assert device.released >= 1
    assert detector.closed


def test_a_camera_that_never_gives_a_picture_is_an_error() -> None:
    made, device, _ = source((1000, "dropping"))
    with pytest.raises(DataError, match="camera 2 opens but gives no picture within 10 s"):
        list(made.frames())
    assert device.released == device.opened > 1
    assert DROPPED < RECONNECT


def test_pictures_of_another_size_after_a_pause_are_read_by_their_own_size() -> None:
    made, device, _ = source((1, "fine"), (3, "unplugged"), (4, "fine"))
    sizes = set()
    for frame in made.frames():
        if frame.t > 2:
            device.size = (2 * HEIGHT, 2 * WIDTH)
        if made.look is not None:
            sizes.add((made.look.camera.width, round(made.look.camera.focal)))
    focal = WIDTH / 2 / math.tan(0.5)
    assert sizes == {(WIDTH, round(focal)), (2 * WIDTH, round(2 * focal))}


def stops_early(device: FakeCamera, made: CameraSource) -> None:
    frames = made.frames()
    next(frames)
    frames.close()  # type: ignore[attr-defined]


def detector_fails(device: FakeCamera, made: CameraSource) -> None:
    def fail(bgr: ByteImage, t: float) -> list[SeenFace]:
        raise RuntimeError("no more memory")

    faces = made._make_detectors().faces
    faces.detect = fail  # type: ignore[method-assign]
    with pytest.raises(RuntimeError, match="no more memory"):
        list(made.frames())


@pytest.mark.parametrize("ends", [stops_early, detector_fails])
def test_everything_is_closed_however_the_reading_ends(
    ends: Callable[[FakeCamera, CameraSource], None],
) -> None:
    made, device, detector = source((1000, "fine"))
    ends(device, made)
    assert device.released == 1
    assert detector.closed


def test_a_camera_may_take_its_time_for_the_first_frame() -> None:
    made, device, _ = source((2.0, "dropping"), (4.0, "fine"))
    assert sum(frame.seen for frame in made.frames()) == 20
    assert device.opened == 1

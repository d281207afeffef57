"""`kendon estimate` live: a camera that is stopped, interrupted, unplugged, or never there."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from command_line import Kendon, Run
from fake_camera import Clock, Everywhere, FakeCamera
from sources.painted_faces import HEIGHT, WIDTH, ToldDetector

from kendon.sources import CameraSource, SourceOptions, camera, video

cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")


@pytest.fixture
def kendon(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Kendon:
    return Kendon(capsys, monkeypatch)


def plug_in(monkeypatch: pytest.MonkeyPatch, *script: tuple[float, str]) -> FakeCamera:
    """Put a camera with a script where `camera:N` is opened."""
    clock, detector = Clock(), Everywhere()
    device = FakeCamera(clock, *script)

    def opened(spec: str, options: SourceOptions) -> CameraSource:
        index = int(spec.removeprefix("camera:"))
        return CameraSource(
            index, options, lambda: detector.both, device.open, clock=clock, sleep=clock.sleep
        )

    monkeypatch.setattr(CameraSource, "open", opened)
    return device


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "camera-0.csv").open() as file:
        return list(csv.DictReader(file))


def assert_refused(run: Run, words: str) -> None:
    assert run.code == 2
    assert run.err.startswith("kendon: ")
    assert run.err.count("\n") == 1
    assert words in run.err


def test_the_seconds_asked_for_are_read(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    device = plug_in(monkeypatch, (1000, "fine"))
    run = kendon("estimate", "--camera", "0", "--seconds", "3", "--out", tmp_path / "out")
    assert run.code == 0
    read = rows(tmp_path / "out")
    assert len(read) == 15
    assert [float(row["distance"]) for row in read] == pytest.approx([1.0] * 15, abs=1e-3)
    assert "ms in the median, 95 % within" in run.err
    assert device.released == 1


def test_ctrl_c_ends_it_and_what_was_read_counts(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    device = plug_in(monkeypatch, (2.05, "fine"), (99, "interrupted"))
    overlay = tmp_path / "seen.avi"
    run = kendon("estimate", "--camera", "0", "--out", tmp_path / "out", "--overlay", overlay)
    assert run.code == 0
    assert "until Ctrl-C" in run.err
    assert "stopped; what was read until then counts" in run.err
    assert len(rows(tmp_path / "out")) == 10
    assert cv2.VideoCapture(str(overlay)).get(cv2.CAP_PROP_FRAME_COUNT) == 41
    assert device.released == 1


def test_a_camera_that_disappears_is_told_and_what_was_read_counts(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plug_in(monkeypatch, (2, "fine"), (5, "unplugged"), (8, "fine"))
    run = kendon("estimate", "--camera", "0", "--out", tmp_path / "out")
    assert run.code == 0
    assert run.err.count("camera 0 gave nothing from 1.9 to") == 1
    assert run.err.count("camera 0 stopped giving pictures") == 1
    read = rows(tmp_path / "out")
    assert sum(row["distance"] == "" for row in read) > 50  # unknown, not the last value
    assert sum(row["distance"] != "" for row in read) > 20


def test_greet_tells_it_too(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plug_in(monkeypatch, (2, "fine"), (5, "unplugged"), (8, "fine"))
    run = kendon("greet", "camera:0", "--quiet", "--out", tmp_path / "out")
    assert run.code == 0
    assert run.err.count("camera 0 gave nothing from 1.9 to") == 1
    assert run.err.count("camera 0 stopped giving pictures") == 1


def test_a_camera_that_is_not_there_is_one_sentence(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(camera, "open_capture", lambda index: None)
    monkeypatch.setattr(camera, "detector_maker", lambda options: lambda: ToldDetector().both)
    assert_refused(kendon("estimate", "--camera", "9", "--out", tmp_path / "out"),
                   "camera 9 does not open")  # fmt: skip
    assert list(tmp_path.iterdir()) == []


def paint(path: Path, frames: int = 10) -> Path:
    """A black video."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10, (WIDTH, HEIGHT))
    for _ in range(frames):
        writer.write(np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8))
    writer.release()
    return path


def test_a_video_without_faces_says_so(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(video, "detector_maker", lambda options: lambda: ToldDetector().both)
    run = kendon("estimate", paint(tmp_path / "a.avi"), "--fov", "60", "--out", tmp_path / "out")
    assert run.code == 2
    assert "nobody is seen in it" in run.err.splitlines()[-1]
    assert not (tmp_path / "out").exists()
    run = kendon("estimate", tmp_path / "a.avi", "--fov", "60", "--person", "7")
    assert run.code == 2
    assert "person 7 is never seen in it" in run.err.splitlines()[-1]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--calibration", "none.yaml"], "none.yaml: there is no such calibration file"),
        (["--calibration", "wide.yaml"], "160 x 90 pixels, but the images have 320 x 240"),
        (["--pose-model", "none.task"], "get pose_landmarker_lite.task"),
        (["--overlay", "a.avi"], "--overlay would overwrite"),
    ],
)
def test_what_does_not_fit_the_video_is_one_sentence(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wide.yaml").write_text(
        "image_width: 160\nimage_height: 90\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
        "  data: [100., 0., 80., 0., 100., 45., 0., 0., 1.]\n"
    )
    paint(Path("a.avi"))
    if "--pose-model" not in options:
        monkeypatch.setattr(video, "detector_maker", lambda options: lambda: ToldDetector().both)
    else:
        monkeypatch.setattr("kendon.sources.pictures.find_model_file", lambda *a: Path("a.avi"))
        pytest.importorskip("mediapipe", reason="MediaPipe is not installed")
    before = sorted(tmp_path.iterdir())
    assert_refused(kendon("estimate", "a.avi", *options, "--out", "out"), words)
    assert sorted(tmp_path.iterdir()) == before

"""Calibration files as OpenCV and ROS write them, torn, and of other images."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from people import assert_one_sentence

from kendon.errors import DataError
from kendon.sources.calibration import calibrated, read_calibration
from kendon.sources.camera_geometry import Intrinsics

cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")

MATRIX = np.array([[600.5, 0.0, 322.0], [0.0, 598.0, 241.5], [0.0, 0.0, 1.0]])
LENS = (-0.31, 0.12, 0.001, -0.0005, 0.02)
ROS = """\
image_width: 640
image_height: 480
camera_name: narrow
camera_matrix:
  rows: 3
  cols: 3
  data: [600.5, 0.000000, 322.0, 0.000000, 598.0, 241.5, 0.000000, 0.000000, 1.000000]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.31, 0.12, 0.001, -0.0005, 0.02]
"""


def opencv_file(path: Path, *, size: bool = True, matrix: object = MATRIX) -> Path:
    """A calibration as OpenCV's sample writes it."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    if size:
        storage.write("image_width", 640)
        storage.write("image_height", 480)
    storage.write("camera_matrix", matrix)
    storage.write("distortion_coefficients", np.array([LENS]).T)
    storage.release()
    return path


@pytest.mark.parametrize("ending", ["yml", "yaml", "xml", "json"])
def test_opencvs_own_files_are_read(tmp_path: Path, ending: str) -> None:
    camera = read_calibration(opencv_file(tmp_path / f"camera.{ending}"))
    # kendon counts pixels from the outer corner of the first, OpenCV from its middle.
    assert camera == Intrinsics(640, 480, 600.5, 598.0, (322.5, 242.0), LENS)


def test_a_camera_file_of_ros_says_the_same(tmp_path: Path) -> None:
    path = tmp_path / "camera.yaml"
    path.write_text(ROS)
    assert read_calibration(path) == read_calibration(opencv_file(tmp_path / "o.yml"))


def test_a_point_that_opencv_projects_is_found_again(tmp_path: Path) -> None:
    camera = read_calibration(opencv_file(tmp_path / "camera.yml"))
    points = np.array([[0.4, -0.3, 2.0], [-0.6, 0.2, 1.5], [0.0, 0.0, 3.0]])
    shown = cv2.projectPoints(points, np.zeros(3), np.zeros(3), MATRIX, np.array(LENS))[0]
    straight = camera.straighten(shown.reshape(-1, 2) + 0.5)
    assert camera.rays(straight) * points[:, 2:] == pytest.approx(points, abs=1e-4)


@given(st.floats(-0.35, 0.2), st.floats(-0.4, 0.4), st.floats(-0.3, 0.3))
def test_bending_undoes_straightening(k1: float, x: float, y: float) -> None:
    camera = Intrinsics(640, 480, 600.0, 600.0, (320.0, 240.0), (k1, 0.05, 0.0, 0.0))
    shown = camera.bend(camera.project(np.array([[x, y, 1.0]])))
    again = camera.bend(camera.straighten(shown))
    assert again == pytest.approx(shown, abs=0.01)


def test_larger_images_of_the_same_shape_scale_it(tmp_path: Path) -> None:
    path = opencv_file(tmp_path / "camera.yml")
    doubled = calibrated(read_calibration(path), 1280, 960, path)
    assert doubled == Intrinsics(1280, 960, 1201.0, 1196.0, (645.0, 484.0), LENS)


def test_images_of_another_shape_are_refused(tmp_path: Path) -> None:
    path = opencv_file(tmp_path / "camera.yml")
    with pytest.raises(DataError, match=r"640 x 480 pixels, but the images have 1280 x 720") as e:
        calibrated(read_calibration(path), 1280, 720, path)
    assert_one_sentence(e.value, path)


def test_a_calibration_without_a_size_is_taken_for_the_images(tmp_path: Path) -> None:
    path = opencv_file(tmp_path / "camera.yml", size=False)
    camera = read_calibration(path)
    assert calibrated(camera, 640, 480, path).width == 640
    with pytest.raises(DataError, match="does not fit images of 4000 x 3000"):
        calibrated(camera, 4000, 3000, path)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "no camera_matrix"),
        ("hello", "no calibration that OpenCV can read"),
        (ROS[:55], "no camera_matrix of 3 x 3"),
        (ROS[: ROS.index("598")], "no calibration that OpenCV can read"),
        ("<?xml version='1.0'?><opencv_storage><camera_m", "no calibration that OpenCV can read"),
        (ROS.replace("camera_matrix", "left"), "no camera_matrix"),
        (ROS.replace("plumb_bob", "equidistant"), "'equidistant' is not read; valid: plumb_bob"),
        (ROS.replace("600.5", "-600.5"), "positive focal lengths"),
        (ROS.replace("600.5", "6005000"), "does not fit images of 640 x 480"),
        (ROS.replace("600.5", ".nan"), "positive focal lengths"),
        (ROS.replace("-0.31, 0.12, 0.001,", ""), "4, 5, 8, 12, 14 finite numbers, not 2"),
        (ROS.replace("640", "-640"), "positive number of pixels"),
    ],
)
def test_what_is_torn_or_no_camera_is_refused(tmp_path: Path, content: str, words: str) -> None:
    path = tmp_path / "camera.yaml"
    path.write_text(content)
    with pytest.raises(DataError, match=words) as refused:
        read_calibration(path)
    assert_one_sentence(refused.value, path)


def test_a_missing_file_and_a_folder_say_so(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no such calibration file"):
        read_calibration(tmp_path / "none.yaml")
    with pytest.raises(DataError, match="cannot be read"):
        read_calibration(tmp_path)
    (tmp_path / "binary.yaml").write_bytes(bytes(range(128, 256)))
    with pytest.raises(DataError, match="cannot be read"):
        read_calibration(tmp_path / "binary.yaml")

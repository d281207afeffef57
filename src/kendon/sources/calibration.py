"""One camera's calibration, from OpenCV's FileStorage (YAML, XML, JSON) or ROS's camera YAML.

Both call the numbers alike: ``camera_matrix``, ``distortion_coefficients``, ``image_width`` and
``image_height``; ROS adds ``distortion_model``. OpenCV's own calibration sample and ROS's
``cameracalibrator`` write such files.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kendon.errors import DataError
from kendon.sources.camera_geometry import MAX_FOV, MIN_FOV, FloatArray, Intrinsics, import_cv2
from kendon.sources.quiet import quiet_stderr

#: What ROS calls the lens models that are OpenCV's (REP-104 and image_geometry).
_MODELS = ("plumb_bob", "rational_polynomial", "thin_prism")
#: How many distortion coefficients OpenCV's lens models have.
_COEFFICIENTS = (0, 4, 5, 8, 12, 14)
#: A calibration counts pixels from the middle of the first one, kendon from its outer corner [px].
_HALF_PIXEL = 0.5
_HEADER = "%YAML:1.0\n---\n"


def read_calibration(path: Path) -> Intrinsics:
    """Read a calibration; width and height are 0 where the file does not tell them.

    Raises:
        DataError: the file is missing, torn, of another camera model, or no camera's.
        MissingExtraError: OpenCV is not installed.
    """
    storage = _open(path)
    matrix = _numbers(storage, "camera_matrix", path)
    if matrix is None or matrix.size != 9:
        raise DataError(
            "there is no camera_matrix of 3 x 3 numbers in this calibration; OpenCV's"
            " calibration sample and ROS's cameracalibrator write one",
            file=path,
        )
    model = storage.getNode("distortion_model")
    if not model.empty() and model.string() not in _MODELS:
        raise DataError(
            f"the distortion_model {model.string()!r} is not read; valid: {', '.join(_MODELS)}"
            " (for a fish-eye lens, rectify its images first)",
            file=path,
        )
    found = _numbers(storage, "distortion_coefficients", path)
    distortion = () if found is None else tuple(found.tolist())
    if len(distortion) not in _COEFFICIENTS or not all(map(math.isfinite, distortion)):
        raise DataError(
            f"distortion_coefficients are {', '.join(map(str, _COEFFICIENTS[1:]))} finite numbers,"
            f" not {len(distortion)}",
            file=path,
        )
    focal, skew, x, zero, focal_y, y, *last = matrix.tolist()
    width, height = (_size(storage, side, path) for side in ("image_width", "image_height"))
    if not (
        np.isfinite(matrix).all() and focal > 0 and focal_y > 0 and [zero, *last] == [0, 0, 0, 1]
    ):
        raise DataError(
            "camera_matrix is fx 0 cx, 0 fy cy, 0 0 1 with positive focal lengths [px], not"
            f" {matrix.tolist()}",
            file=path,
        )
    if abs(skew) > 0.01 * focal:
        raise DataError(f"a camera with skewed pixels (skew {skew:g}) is not read", file=path)
    camera = Intrinsics(
        width, height, focal, focal_y, (x + _HALF_PIXEL, y + _HALF_PIXEL), distortion
    )
    if width and height:
        _check(camera, path)
    return camera


def calibrated(camera: Intrinsics, width: int, height: int, path: Path) -> Intrinsics:
    """The calibration for images of a size: scaled where they have the same shape.

    Args:
        camera: from `read_calibration`.
        width: of the images [px].
        height: of the images [px].
        path: where the calibration was read, for the message.

    Raises:
        DataError: it was made with images of another shape, so that what they show of the scene
            is not known, or it does not fit the images.
    """
    if not (camera.width and camera.height):
        fitting = replace(camera, width=width, height=height)
        _check(fitting, path)
        return fitting
    resized = camera.resized(width, height)
    if resized is None:
        raise DataError(
            f"this calibration was made with {camera.width} x {camera.height} pixels, but the"
            f" images have {width} x {height}, another shape: set the camera to"
            f" {camera.width} x {camera.height}, or calibrate it as it is used",
            file=path,
        )
    return resized


def _check(camera: Intrinsics, path: Path) -> None:
    """Refuse numbers that cannot be this camera's.

    Raises:
        DataError: the field of view or the optical axis is not one of a camera with such images.
    """
    fov = 2.0 * math.atan(camera.width / 2.0 / camera.focal)
    x, y = camera.centre[0] / camera.width, camera.centre[1] / camera.height
    if not (MIN_FOV <= fov <= MAX_FOV and 0.2 < x < 0.8 and 0.2 < y < 0.8):
        raise DataError(
            f"camera_matrix does not fit images of {camera.width} x {camera.height} pixels: it"
            f" would see {math.degrees(fov):.0f} degrees with its axis at"
            f" ({camera.centre[0]:.0f}, {camera.centre[1]:.0f})",
            file=path,
        )


def _open(path: Path) -> Any:
    cv2 = import_cv2("reading a calibration")
    if path.is_dir():
        raise DataError("this calibration cannot be read, as it is a folder", file=path)
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise DataError("there is no such calibration file", file=path) from None
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"this calibration cannot be read ({error})", file=path) from None
    # OpenCV wants its header on YAML, which ROS leaves out.
    if not text.lstrip().startswith(("%YAML", "<", "{")):
        text = _HEADER + text.removeprefix("---")
    try:
        with quiet_stderr():
            storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        opened = bool(storage.isOpened())
    except (cv2.error, SystemError):  # what OpenCV's bindings raise for a file that is torn
        opened = False
    if not opened:
        raise DataError(
            "this is no calibration that OpenCV can read (YAML, XML or JSON); it may be torn",
            file=path,
        )
    return storage


def _numbers(storage: Any, name: str, path: Path) -> FloatArray | None:
    """The numbers of a matrix, flat; None where there is none of that name."""
    node = storage.getNode(name)
    if node.empty():
        return None
    data = node.getNode("data") if node.isMap() else node
    values = [data.at(i) for i in range(data.size())] if data.isSeq() else []
    if not all(value.isReal() or value.isInt() for value in values):
        raise DataError("a matrix holds numbers only", file=path, column=name)
    return np.array([value.real() for value in values], dtype=np.float64)


def _size(storage: Any, name: str, path: Path) -> int:
    node = storage.getNode(name)
    if node.empty():
        return 0
    if not node.isInt() or not 1 <= node.real() <= 100_000:
        raise DataError("the size of an image is a positive number of pixels", file=path,
                        column=name)  # fmt: skip
    return int(node.real())

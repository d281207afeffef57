"""The calibration of two cameras side by side, from OpenCV's FileStorage (YAML, XML) or NPZ.

Keys as in OpenCV's own examples: ``K1 D1 K2 D2`` (or ``M1``, ``M2`` for the camera matrices),
``R T`` from the first camera to the second, ``image_size`` (width, height) or ``width`` and
``height``, all of them at that size; optionally ``Q`` (disparity to depth), ``unit`` of T and Q
(``mm``, ``cm`` or ``m``) and ``rectified`` (1 = the images are, 0 = they are not).
"""

from __future__ import annotations

import math
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from kendon.errors import DataError, UnknownNameError
from kendon.person import FloatArray
from kendon.sources.camera_geometry import import_cv2
from kendon.sources.quiet import quiet_stderr
from kendon.tables import check_readable

#: Metres in a unit of length.
UNITS: Mapping[str, float] = {"mm": 0.001, "cm": 0.01, "m": 1.0}
#: OpenCV's stereo calibration counts in the unit of the chessboard, mostly millimetres; so did
#: the thesis's (3.5.1).
DEFAULT_UNIT = "mm"
#: Cameras nearer together or farther apart see no room in depth; a unit is mistaken then [m].
_BASELINE = (0.01, 3.0)
#: Images are scaled, not cropped, when their shape stays the same to this share.
_SAME_SHAPE = 0.01
_ALIASES = {"M1": "K1", "M2": "K2", "imageSize": "image_size"}
_SHAPES = {"K1": (3, 3), "K2": (3, 3), "R": (3, 3), "Q": (4, 4)}


@dataclass(frozen=True, eq=False)
class StereoCalibration:
    """Two pinhole cameras; a value that the file does not hold is None."""

    path: Path
    size: tuple[int, int]  # [px], width and height that K and Q refer to
    K1: FloatArray | None = None  # (3, 3) [px]
    D1: FloatArray | None = None  # (n,), distortion in OpenCV's order
    K2: FloatArray | None = None  # (3, 3) [px]
    D2: FloatArray | None = None  # (n,)
    R: FloatArray | None = None  # (3, 3), first camera -> second camera
    T: FloatArray | None = None  # (3,) [m], likewise
    Q: FloatArray | None = None  # (4, 4), (x, y, disparity, 1) -> homogeneous metres (3.12)
    rectified: bool | None = None  # whether the images are rectified already

    def scaled(self, size: tuple[int, int]) -> StereoCalibration:
        """The calibration of the same images at another size.

        Args:
            size: width and height [px].

        Raises:
            DataError: the shape is another one, so that the images are not merely scaled.
        """
        if size == self.size:
            return self
        factor = size[0] / self.size[0]
        if abs(size[1] / self.size[1] / factor - 1) > _SAME_SHAPE:
            raise DataError(
                f"calibrated at {self.size[0]} x {self.size[1]} pixels, but the video has"
                f" {size[0]} x {size[1]}, which is another shape: it was cropped",
                file=self.path,
            )

        def camera(matrix: FloatArray | None) -> FloatArray | None:
            if matrix is None:
                return None
            scaled = matrix * np.array([[factor], [factor], [1]])
            scaled[:2, 2] += (factor - 1) / 2  # pixels are counted from the middle of the first
            return np.asarray(scaled)

        q = self.Q
        if q is not None:
            q = q.copy()
            q[:2, 3] = q[:2, 3] * factor - (factor - 1) / 2
            q[2, 3] *= factor
            q[3, 3] *= factor
        return replace(self, size=size, K1=camera(self.K1), K2=camera(self.K2), Q=q)

    def require(self, *keys: str) -> None:
        """Refuse a calibration without these keys, naming all that are missing.

        Raises:
            DataError: some are missing.
        """
        missing = [key for key in keys if getattr(self, key) is None]
        if missing:
            raise DataError(f"{', '.join(missing)} missing in this calibration", file=self.path)

    def disparity_to_depth(self) -> FloatArray:
        """Q of images that are rectified already, (4, 4): the file's own, or from K1, K2, T.

        Raises:
            DataError: the file holds neither.
        """
        if self.Q is not None:
            return self.Q
        if self.K1 is None or self.K2 is None or self.T is None:
            raise DataError("neither Q nor K1, K2 and T in this calibration", file=self.path)
        across = float(self.T[0])
        if abs(across) < 0.9 * float(np.linalg.norm(self.T)):
            raise DataError(
                "T does not point along the image rows, so the images cannot be rectified"
                " already; read them with rectify=True",
                file=self.path,
            )
        (_, _, cx), (_, _, cy) = self.K1[0], self.K1[1]
        return np.array(
            [
                [1, 0, 0, -cx],
                [0, 1, 0, -cy],
                [0, 0, 0, self.K1[0, 0]],
                [0, 0, -1 / across, (cx - self.K2[0, 2]) / across],
            ]
        )


def read_stereo_calibration(path: str | Path, *, unit: str | None = None) -> StereoCalibration:
    """Read a calibration from .yml, .yaml, .xml (OpenCV's FileStorage) or .npz.

    Args:
        path: of the file.
        unit: of T and Q, ``mm``, ``cm`` or ``m``; by default what the file says, else ``mm``.

    Raises:
        DataError: the file is missing, unreadable, or holds what cannot be right; also when the
            cameras would be nearer than 1 cm or farther than 3 m apart, which is a wrong unit.
        UnknownNameError: there is no such unit.
        MissingExtraError: OpenCV is not installed, and the file is none of NumPy's.
    """
    path = Path(path)
    check_readable(path)
    raw = _read_npz(path) if path.suffix.lower() == ".npz" else _read_storage(path)
    raw = {_ALIASES.get(key, key): value for key, value in raw.items()}
    unit = str(raw.get("unit", DEFAULT_UNIT)) if unit is None else unit
    if unit not in UNITS:
        raise UnknownNameError("unit of length", unit, UNITS)
    arrays = {
        key: _array(path, key, raw[key])
        for key in ("K1", "D1", "K2", "D2", "R", "T", "Q")
        if key in raw
    }
    if "T" in arrays:
        arrays["T"] = arrays["T"] * UNITS[unit]
        _check_baseline(path, float(np.linalg.norm(arrays["T"])), unit)
    if "Q" in arrays:
        if not arrays["Q"][3, 2]:
            raise DataError("Q knows no distance between the cameras", file=path, column="Q")
        arrays["Q"][3] /= UNITS[unit]
        _check_baseline(path, 1 / abs(float(arrays["Q"][3, 2])), unit)
    rectified = bool(int(raw["rectified"])) if "rectified" in raw else None
    return StereoCalibration(path, _size(path, raw), **arrays, rectified=rectified)


def _check_baseline(path: Path, baseline: float, unit: str) -> None:
    if not _BASELINE[0] <= baseline <= _BASELINE[1]:
        raise DataError(
            f"the cameras would be {baseline:g} m apart, read in {unit}; valid:"
            f" {_BASELINE[0]:g} to {_BASELINE[1]:g} m; say unit: mm, cm or m in the file",
            file=path,
        )


def _array(path: Path, key: str, value: Any) -> FloatArray:
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise DataError("this is no array of numbers", file=path, column=key) from None
    if key in ("D1", "D2", "T"):
        array = array.ravel()
    expected = _SHAPES.get(key, (3,) if key == "T" else array.shape)
    if array.shape != expected:
        raise DataError(f"the shape must be {expected}, not {array.shape}", file=path, column=key)
    if key in ("D1", "D2") and len(array) not in (4, 5, 8, 12, 14):
        raise DataError(
            f"{len(array)} distortion coefficients; OpenCV knows 4, 5, 8, 12 or 14",
            file=path,
            column=key,
        )
    if not np.isfinite(array).all():
        raise DataError("a number is not finite", file=path, column=key)
    if key in ("K1", "K2") and not (array[0, 0] > 0 and array[1, 1] > 0):
        raise DataError("the focal lengths must be positive", file=path, column=key)
    if key == "R" and not np.allclose(array @ array.T, np.eye(3), atol=1e-3):
        raise DataError("this is no rotation", file=path, column=key)
    return array


def _size(path: Path, raw: Mapping[str, Any]) -> tuple[int, int]:
    if "image_size" in raw:
        numbers = np.array(raw["image_size"], dtype=float).ravel().tolist()
    else:
        numbers = [float(raw[key]) for key in ("width", "height") if key in raw]
    if len(numbers) != 2 or not all(math.isfinite(n) and n >= 1 for n in numbers):
        raise DataError(
            "image_size (width, height) is missing or none; a calibration holds for one size",
            file=path,
        )
    return int(numbers[0]), int(numbers[1])


def _read_npz(path: Path) -> dict[str, Any]:
    try:
        with np.load(path, allow_pickle=False) as file:
            return {key: file[key] for key in file.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, AttributeError):
        raise DataError("this is no NPZ file of arrays, or it is torn", file=path) from None


def _read_storage(path: Path) -> dict[str, Any]:
    cv2 = import_cv2("reading a stereo calibration")
    with quiet_stderr():
        try:
            storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
            nodes = {key: storage.getNode(key) for key in storage.root().keys()}  # noqa: SIM118
            values = {key: _value(node) for key, node in nodes.items()}
        # OpenCV 5 raises SystemError where the file cannot be parsed at all.
        except (cv2.error, SystemError):
            raise DataError("OpenCV cannot read this calibration file", file=path) from None
        storage.release()
    return values


def _value(node: Any) -> Any:
    if node.isMap():
        return node.mat()
    if node.isSeq():
        return [node.at(i).real() for i in range(node.size())]
    return node.string() if node.isString() else node.real()

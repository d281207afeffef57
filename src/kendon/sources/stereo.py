"""Depth from two cameras side by side (thesis 3.5.1, 3.12-3.13).

Disparities come from semi-global block matching (Hirschmüller 2008, OpenCV's StereoSGBM), points
from Q: (X, Y, Z, W) = Q (x, y, disparity, 1), divided by W. Points are in the left camera's
optical frame, after rectification where that is done: x right, y down, z forward.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.geometry import UNKNOWN_POINT, Vec3
from kendon.person import FloatArray
from kendon.sources.camera_geometry import import_cv2
from kendon.sources.quiet import quiet_stderr
from kendon.sources.stereo_calibration import UNITS, StereoCalibration

ByteImage = NDArray[np.uint8]

#: Nothing nearer to the cameras is looked for; disparities grow without bound there [m].
NEAREST = 0.8
#: Rooms end before this; a point farther away is a mistaken disparity [m].
_FARTHEST = 30.0
#: The side of the blocks compared [px]; with it the penalties for a change of disparity by one
#: and by more, as OpenCV recommends for one channel.
_BLOCK = 5
_PENALTIES = (8 * _BLOCK**2, 32 * _BLOCK**2)
#: StereoSGBM counts disparities in sixteenths of a pixel.
_FINE = 16
#: So many points must be found in both images before their rows are compared.
_MATCHES = 20


def depth_map(
    left: ByteImage, right: ByteImage, Q: FloatArray, *, unit: str = "m", nearest: float = NEAREST
) -> FloatArray:
    """The place of every pixel of the left image of a rectified pair (thesis 3.12-3.13).

    Args:
        left: shape (H, W) or (H, W, 3).
        right: likewise.
        Q: disparity to depth, (4, 4).
        unit: of the lengths in Q: ``mm``, ``cm`` or ``m``.
        nearest: the smallest depth looked for [m].

    Returns:
        Shape (H, W, 3) [m]; NaN where no disparity was found, or one of less than `nearest`.

    Raises:
        ParameterError: the images differ in size, or `nearest` is not positive.
        UnknownNameError: there is no such unit.
        MissingExtraError: OpenCV is not installed.
    """
    cv2 = import_cv2("depth from two cameras")
    if left.shape[:2] != right.shape[:2]:
        raise ParameterError(
            f"the two images must have one size, not {left.shape[:2]} and {right.shape[:2]}"
        )
    if unit not in UNITS:
        raise UnknownNameError("unit of length", unit, UNITS)
    if not nearest > 0:
        raise ParameterError(f"the smallest depth must be positive, not {nearest:g} m")
    Q = np.array(Q, dtype=float)
    Q[3] /= UNITS[unit]
    # Z = Q[2,3] / (Q[3,2] d + Q[3,3]): the disparities of the nearest point and of infinity.
    ends = sorted((w - Q[3, 3]) / Q[3, 2] for w in (0.0, Q[2, 3] / nearest))
    first = math.floor(ends[0])
    count = _FINE * math.ceil((ends[1] - first) / _FINE)  # StereoSGBM wants a multiple of 16
    # What the right image sees beyond the rim is matched nowhere: without a margin, a strip as
    # wide as the largest disparity would be lost.
    margins = max(0, first + count), max(0, -first)
    grey = [
        cv2.copyMakeBorder(
            cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image,
            0, 0, *margins, cv2.BORDER_REPLICATE,
        )
        for image in (left, right)
    ]  # fmt: skip
    matcher = cv2.StereoSGBM_create(
        minDisparity=first,
        numDisparities=count,
        blockSize=_BLOCK,
        P1=_PENALTIES[0],
        P2=_PENALTIES[1],
        disp12MaxDiff=1,
        uniquenessRatio=10,
        speckleWindowSize=100,
        speckleRange=2,
        mode=cv2.STEREO_SGBM_MODE_SGBM_3WAY,
    )
    fixed = matcher.compute(*grey)[:, margins[0] : margins[0] + left.shape[1]]
    disparity = fixed.astype(np.float32) / _FINE
    with np.errstate(divide="ignore", invalid="ignore"):
        points = np.asarray(cv2.reprojectImageTo3D(disparity, Q), dtype=float)
        z = points[:, :, 2]
        points[(fixed < first * _FINE) | ~((z >= nearest) & (z < _FARTHEST))] = math.nan
    return points


def point_at(
    points: FloatArray, pixel: tuple[float, float], *, radius: int = 3, least: int = 8
) -> Vec3:
    """Where what a pixel shows is: the median over a small window of known neighbours [m].

    Args:
        points: from `depth_map`, shape (H, W, 3) [m].
        pixel: x and y, NaN = unknown.
        radius: of the square window [px].
        least: how many known neighbours there must be.

    Returns:
        The point; unknown where the pixel is, lies outside the image, or has too few neighbours.
    """
    height, width = points.shape[:2]
    if not (0 <= pixel[0] + 0.5 < width and 0 <= pixel[1] + 0.5 < height):  # NaN fails as well
        return UNKNOWN_POINT
    x, y = round(pixel[0]), round(pixel[1])
    window = points[
        max(0, y - radius) : y + radius + 1, max(0, x - radius) : x + radius + 1
    ].reshape(-1, 3)
    known = window[np.isfinite(window).all(axis=1)]
    if len(known) < least:
        return UNKNOWN_POINT
    px, py, pz = np.median(known, axis=0).tolist()
    return px, py, pz


class StereoRig:
    """Two calibrated cameras: from a pair of images to points, and from pixels to pixels.

    Args:
        calibration: scaled to the images' size here.
        size: of the images, width and height [px].
        rectify: whether the images must be rectified first.

    Raises:
        DataError: the calibration lacks what is needed, or is one of cropped images.
        MissingExtraError: OpenCV is not installed.
    """

    def __init__(
        self, calibration: StereoCalibration, size: tuple[int, int], *, rectify: bool
    ) -> None:
        self._cv2 = import_cv2("depth from two cameras")
        scaled = calibration.scaled(size)
        self._maps: list[Any] = []
        if not rectify:
            self.Q = scaled.disparity_to_depth()
            return
        scaled.require("K1", "K2", "R", "T")
        none = np.zeros(5)
        cameras = [
            (scaled.K1, none if scaled.D1 is None else scaled.D1),
            (scaled.K2, none if scaled.D2 is None else scaled.D2),
        ]
        R1, R2, P1, P2, Q, *_ = self._cv2.stereoRectify(
            *cameras[0], *cameras[1], size, scaled.R, np.asarray(scaled.T).reshape(3, 1),
            flags=self._cv2.CALIB_ZERO_DISPARITY, alpha=0,
        )  # fmt: skip
        if abs(P2[1, 3]) > abs(P2[0, 3]):
            raise DataError(
                "the cameras stand above each other; kendon reads cameras side by side",
                file=scaled.path,
            )
        self.Q = np.asarray(Q, dtype=float)
        self._undistort = (*cameras[0], R1, P1)
        for (K, D), R, P in zip(cameras, (R1, R2), (P1, P2), strict=True):
            self._maps.append(
                self._cv2.initUndistortRectifyMap(K, D, R, P, size, self._cv2.CV_16SC2)
            )

    def images(self, left: ByteImage, right: ByteImage) -> tuple[ByteImage, ByteImage]:
        """The pair with every point in the same row of both."""
        if not self._maps:
            return left, right
        one, two = (
            self._cv2.remap(image, *maps, self._cv2.INTER_LINEAR)
            for image, maps in zip((left, right), self._maps, strict=True)
        )
        return one, two

    def pixels(self, pixels: FloatArray) -> FloatArray:
        """Where pixels (N, 2) of the left image lie in its rectified one, (N, 2)."""
        if not self._maps:
            return pixels
        result = np.full(pixels.shape, math.nan)
        known = np.isfinite(pixels).all(axis=1)
        if known.any():
            K, D, R, P = self._undistort
            flat = self._cv2.undistortPoints(pixels[known].reshape(-1, 1, 2), K, D, R=R, P=P)
            result[known] = flat.reshape(-1, 2)
        return result

    def depth(self, left: ByteImage, right: ByteImage, *, nearest: float = NEAREST) -> FloatArray:
        """`depth_map` of a pair as the cameras gave it, (H, W, 3) [m]."""
        return depth_map(*self.images(left, right), self.Q, nearest=nearest)


def row_offset(left: ByteImage, right: ByteImage) -> float:
    """How many rows the same point differs in between two images, the median; NaN = too few.

    Of a rectified pair it is less than a pixel, up to the precision of the ORB corners used.
    """
    cv2 = import_cv2("depth from two cameras")
    finder = cv2.ORB_create(1000)
    (points1, marks1), (points2, marks2) = (
        finder.detectAndCompute(image, None) for image in (left, right)
    )
    if marks1 is None or marks2 is None:
        return math.nan
    matches = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(marks1, marks2)
    best = sorted(matches, key=lambda m: m.distance)[: max(_MATCHES, len(matches) // 4)]
    if len(best) < _MATCHES:
        return math.nan
    rows = [points1[m.queryIdx].pt[1] - points2[m.trainIdx].pt[1] for m in best]
    return float(np.median(np.abs(rows)))


class StereoVideo:
    """Two videos of the same instants, frame by frame.

    Args:
        left: path of the left camera's video.
        right: path of the right camera's video.

    Raises:
        DataError: one is missing or no video, or their sizes differ.
        MissingExtraError: OpenCV is not installed.
    """

    def __init__(self, left: Path, right: Path) -> None:
        self._cv2 = import_cv2("reading stereo videos")
        self.paths = left, right
        sizes = []
        for path in self.paths:
            capture = self._open(path)
            sizes.append(
                (
                    int(capture.get(self._cv2.CAP_PROP_FRAME_WIDTH)),
                    int(capture.get(self._cv2.CAP_PROP_FRAME_HEIGHT)),
                )
            )
            self.fps = float(capture.get(self._cv2.CAP_PROP_FPS))  # [1/s], as the file claims
            capture.release()
        if sizes[0] != sizes[1]:
            raise DataError(
                f"{sizes[1][0]} x {sizes[1][1]} pixels, but {left.name} has"
                f" {sizes[0][0]} x {sizes[0][1]}",
                file=right,
            )
        self.size = sizes[0]  # [px], width and height

    def frames(self, wanted: list[int]) -> Iterator[tuple[int, ByteImage, ByteImage]]:
        """The frames of these numbers, counted from 0 and in order, with both images.

        Raises:
            DataError: a video ends before the last of them.
        """
        captures = [self._open(path) for path in self.paths]
        try:
            at = 0
            for number in wanted:
                while at < number:
                    for capture in captures:
                        capture.grab()
                    at += 1
                images = []
                for path, capture in zip(self.paths, captures, strict=True):
                    good, image = capture.read()
                    if not good:
                        raise DataError(
                            f"the video ends before frame {number + 1}, in which people are marked",
                            file=path,
                        )
                    images.append(image)
                at += 1
                yield number, images[0], images[1]
        finally:
            for capture in captures:
                capture.release()

    def _open(self, path: Path) -> Any:
        if not path.is_file():
            raise DataError("there is no such video", file=path)
        with quiet_stderr():
            capture = self._cv2.VideoCapture(str(path))
        if not capture.isOpened():
            raise DataError("this is no video that OpenCV can read", file=path)
        return capture

"""From an image to the robot: a pinhole camera, and how it sits on ``base_footprint``.

Three frames meet here, all right-handed, metres and radians.

- *image*: pixels, x right, y down, the origin at the outer corner of the top left pixel.
- *optical*: the camera's own frame (REP-103 suffix ``_optical``): x right, y down, z forward.
- *base*: the robot's ``base_footprint``: x forward, y left, z up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kendon.errors import MissingExtraError, ParameterError
from kendon.sources.base import CameraMount

FloatArray = NDArray[np.float64]

#: The horizontal field of view where the user names none [rad]: that of a common webcam.
DEFAULT_FOV = math.radians(60.0)

#: What a lens without a fish eye can have [rad]; outside it, degrees were meant, or half an angle.
MIN_FOV, MAX_FOV = math.radians(5.0), math.radians(160.0)

#: Sizes are whole pixels: 1920 x 1080 and 854 x 480 are the same shape.
_SAME_SHAPE = 0.01

#: The axes of a level camera's optical frame in a body frame (x forward, y left, z up), as columns.
_BODY_FROM_OPTICAL: FloatArray = np.array(
    [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], dtype=np.float64
)


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera, and how its lens bends the picture.

    `project` and `rays` are those of the ideal pinhole; `straighten` takes what the lens did out
    of pixels, once, so that all other geometry may forget about it.
    """

    width: int  # [px]
    height: int  # [px]
    focal: float  # [px], across
    focal_y: float  # [px], down
    centre: tuple[float, float]  # [px], where the optical axis meets the image
    distortion: tuple[float, ...] = ()  # OpenCV's k1 k2 p1 p2 [k3 [k4 k5 k6 ...]]; empty = none

    @classmethod
    def from_fov(cls, width: int, height: int, fov: float | None = None) -> Intrinsics:
        """The camera that sees `fov` from the left to the right rim of its image.

        Its pixels are square, its axis goes through the image's middle, its lens is perfect.

        Args:
            width: of the image [px].
            height: of the image [px].
            fov: horizontal field of view [rad]; None for `DEFAULT_FOV`.

        Raises:
            ParameterError: the image is empty, or no pinhole camera has such a field of view.
        """
        if width < 1 or height < 1:
            raise ParameterError(f"an image of {width} x {height} pixels shows nothing")
        focal = width / 2.0 / math.tan(check_fov(fov) / 2.0)
        return cls(width, height, focal, focal, (width / 2.0, height / 2.0))

    @property
    def matrix(self) -> FloatArray:
        """The camera matrix K, (3, 3) [px]: optical to homogeneous image coordinates."""
        x, y = self.centre
        return np.array([[self.focal, 0.0, x], [0.0, self.focal_y, y], [0.0, 0.0, 1.0]])

    @property
    def _focals(self) -> FloatArray:
        return np.array([self.focal, self.focal_y])

    def project(self, points: FloatArray) -> FloatArray:
        """Where a pinhole shows points of the optical frame (..., 3) [m], (..., 2) [px]."""
        return np.asarray(self._focals * points[..., :2] / points[..., 2:] + self.centre)

    def rays(self, pixels: FloatArray) -> FloatArray:
        """Directions through a pinhole's pixels (..., 2), optical frame with z = 1, (..., 3)."""
        flat = (np.asarray(pixels, dtype=np.float64) - self.centre) / self._focals
        return np.concatenate([flat, np.ones((*flat.shape[:-1], 1))], axis=-1)

    def straighten(self, pixels: FloatArray) -> FloatArray:
        """Where a pinhole would have shown what the lens shows at pixels (N, 2), (N, 2) [px].

        Raises:
            MissingExtraError: the lens is not perfect and OpenCV is not installed.
        """
        if not any(self.distortion) or not len(pixels):
            return pixels
        cv2 = import_cv2("reading a calibrated camera")
        # As many rounds as the wide lenses of webcams need at their corners.
        rounds = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-8)
        ideal = cv2.undistortImagePoints(
            np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2),
            self.matrix,
            np.array(self.distortion),
            arg1=rounds,
        )
        return np.asarray(ideal, dtype=np.float64).reshape(-1, 2)

    def bend(self, pixels: FloatArray) -> FloatArray:
        """The inverse of `straighten`: where the lens shows a pinhole's pixels (N, 2), (N, 2)."""
        if not any(self.distortion) or not len(pixels):
            return pixels
        cv2 = import_cv2("reading a calibrated camera")
        nothing = np.zeros(3)
        shown = cv2.projectPoints(
            self.rays(pixels), nothing, nothing, self.matrix, np.array(self.distortion)
        )[0]
        return np.asarray(shown, dtype=np.float64).reshape(-1, 2)

    def resized(self, width: int, height: int) -> Intrinsics | None:
        """The same camera giving smaller or larger images; None where the shape is another."""
        x, y = width / self.width, height / self.height
        if abs(x / y - 1.0) > _SAME_SHAPE:
            return None
        centre = (self.centre[0] * x, self.centre[1] * y)
        return Intrinsics(width, height, self.focal * x, self.focal_y * y, centre, self.distortion)


def check_fov(fov: float | None) -> float:
    """The field of view, or the default one where it is None [rad].

    Raises:
        ParameterError: it lies outside `MIN_FOV` to `MAX_FOV`.
    """
    if fov is None:
        return DEFAULT_FOV
    if not MIN_FOV <= fov <= MAX_FOV:  # NaN fails the comparison as well
        raise ParameterError(
            f"a horizontal field of view of {fov:g} rad is not one of a camera; valid:"
            f" {MIN_FOV:.2f} to {MAX_FOV:.2f} rad ({math.degrees(MIN_FOV):.0f} to"
            f" {math.degrees(MAX_FOV):.0f} degrees; 60 degrees are {DEFAULT_FOV:.3f} rad)"
        )
    return fov


@dataclass(frozen=True)
class MountedCamera:
    """A camera's optical frame placed in the robot's base frame."""

    rotation: FloatArray  # (3, 3), directions: optical -> base
    position: FloatArray  # (3,) [m], the optical centre in base

    @classmethod
    def from_mount(cls, mount: CameraMount) -> MountedCamera:
        """Place a level camera at the mount, tilt it by `pitch`, then turn it by `yaw`."""
        from scipy.spatial.transform import Rotation  # half a second: not for those who need none

        body = Rotation.from_euler("ZY", [mount.yaw, mount.pitch]).as_matrix()
        return cls(body @ _BODY_FROM_OPTICAL, np.asarray(mount.position, dtype=np.float64))

    def points(self, optical: FloatArray) -> FloatArray:
        """Points (..., 3) [m] of the optical frame, in base."""
        return np.asarray(optical @ self.rotation.T + self.position)

    def directions(self, optical: FloatArray) -> FloatArray:
        """Directions (..., 3) of the optical frame, in base."""
        return np.asarray(optical @ self.rotation.T)

    def quaternion(self, rotation: FloatArray) -> tuple[float, float, float, float]:
        """The rotation (3, 3) of something in the optical frame, in base: x y z w, w >= 0."""
        from scipy.spatial.transform import Rotation  # half a second: not for those who need none

        x, y, z, w = Rotation.from_matrix(self.rotation @ rotation).as_quat(canonical=True)
        return (float(x), float(y), float(z), float(w))


def import_cv2(what: str) -> Any:
    """OpenCV, imported only when it is needed.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import cv2
    except ImportError as error:
        raise MissingExtraError(what, "camera", "opencv-contrib-python") from error
    return cv2

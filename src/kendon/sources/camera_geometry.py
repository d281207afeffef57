"""From an image to the robot: a pinhole camera, and how it sits on ``base_footprint``.

Three frames meet here, all right-handed, metres and radians.

- *image*: pixels, x right, y down, the origin at the outer corner of the top left pixel.
- *optical*: the camera's own frame (REP-103 suffix ``_optical``): x right, y down, z forward.
- *base*: the robot's ``base_footprint``: x forward, y left, z up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kendon.errors import ParameterError
from kendon.sources.base import CameraMount

FloatArray = NDArray[np.float64]

#: The horizontal field of view where the user names none [rad]: that of a common webcam.
DEFAULT_FOV = math.radians(60.0)

#: What a lens without a fish eye can have [rad]; outside it, degrees were meant, or half an angle.
MIN_FOV, MAX_FOV = math.radians(5.0), math.radians(160.0)

#: The axes of a level camera's optical frame in a body frame (x forward, y left, z up), as columns.
_BODY_FROM_OPTICAL: FloatArray = np.array(
    [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], dtype=np.float64
)


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera with square pixels, its axis through the image's middle, no distortion."""

    width: int  # [px]
    height: int  # [px]
    focal: float  # [px]

    @classmethod
    def from_fov(cls, width: int, height: int, fov: float | None = None) -> Intrinsics:
        """The camera that sees `fov` from the left to the right rim of its image.

        Args:
            width: of the image [px].
            height: of the image [px].
            fov: horizontal field of view [rad]; None for `DEFAULT_FOV`.

        Raises:
            ParameterError: the image is empty, or no pinhole camera has such a field of view.
        """
        if width < 1 or height < 1:
            raise ParameterError(f"an image of {width} x {height} pixels shows nothing")
        fov = check_fov(fov)
        return cls(width, height, width / 2.0 / math.tan(fov / 2.0))

    @property
    def matrix(self) -> FloatArray:
        """The camera matrix K, (3, 3) [px]: optical to homogeneous image coordinates."""
        return np.array(
            [
                [self.focal, 0.0, self.width / 2.0],
                [0.0, self.focal, self.height / 2.0],
                [0.0, 0.0, 1.0],
            ]
        )

    def project(self, points: FloatArray) -> FloatArray:
        """Where points of the optical frame (..., 3) [m] appear in the image, (..., 2) [px]."""
        middle = np.array([self.width, self.height]) / 2.0
        return np.asarray(self.focal * points[..., :2] / points[..., 2:] + middle)

    def rays(self, pixels: FloatArray) -> FloatArray:
        """Directions through pixels (..., 2), in the optical frame with z = 1, (..., 3)."""
        middle = np.array([self.width, self.height]) / 2.0
        flat = (np.asarray(pixels, dtype=np.float64) - middle) / self.focal
        return np.concatenate([flat, np.ones((*flat.shape[:-1], 1))], axis=-1)


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

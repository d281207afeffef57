"""The gaze of many people or instants at once, with arrays: the numbers of `kendon.features.gaze`.

Ten times as fast as one by one where there are hundreds of rays, as in a recording. The two are
held to the same numbers by ``tests/features/test_gaze.py``.
"""

from __future__ import annotations

import numpy as np

from kendon.features.gaze import EYES_ONLY_WITHIN, GAZE_CEILING, HEAD_ONLY_BEYOND, RIM
from kendon.geometry import Vec3
from kendon.person import FloatArray

#: Rays that run along the plane, or are unknown, pass through inf and NaN on the way to their
#: answer.
_quiet = np.errstate(over="ignore", divide="ignore", invalid="ignore")


@_quiet
def head_gaze(head: FloatArray, rotation: FloatArray, robot_face: Vec3 | FloatArray) -> FloatArray:
    """`gaze_of_head` of many faces.

    Args:
        head: faces in ``base_footprint``, shape (..., 3) [m].
        rotation: orientations of the heads, quaternions x y z w of any length, shape (..., 4).
        robot_face: the robot's face in the same frame [m].

    Returns:
        Shape (...), between 0 and `GAZE_CEILING`; NaN = unknown.
    """
    x, y, z, w = (rotation[..., i] for i in range(4))
    # The rotated x axis times the quaternion's squared length.
    direction = np.stack([w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)])
    origin = np.moveaxis(head, -1, 0)
    return _ray_gaze(origin, _pierce(origin, direction, robot_face), robot_face)


@_quiet
def eye_gaze(eyes: FloatArray, directions: FloatArray, robot_face: Vec3 | FloatArray) -> FloatArray:
    """`gaze_of_eyes` of many people.

    Args:
        eyes: centres of both eyes, shape (..., 2, 3) [m].
        directions: directions out of them, any length, shape (..., 2, 3).
        robot_face: the robot's face in the same frame [m].

    Returns:
        Shape (...), between 0 and `GAZE_CEILING`; NaN = unknown.
    """
    origins = np.moveaxis(eyes, -1, 0)  # (3, ..., 2)
    points = _pierce(origins, np.moveaxis(directions, -1, 0), robot_face)
    left, right = np.moveaxis(np.isnan(points[0]), -1, 0)
    # One known eye decides alone, as if both were where it is.
    which = np.stack([np.where(left, 1, 0), np.where(right, 0, 1)], axis=-1)

    def middle(pair: FloatArray) -> FloatArray:
        chosen = np.take_along_axis(pair, np.broadcast_to(which, pair.shape), axis=-1)
        return np.asarray((chosen[..., 0] + chosen[..., 1]) / 2)

    return _ray_gaze(middle(origins), middle(points), robot_face)


@_quiet
def blended(eye: FloatArray, head: FloatArray, distance: FloatArray) -> FloatArray:
    """`kendon.features.gaze.blend` of many gazes, all of one shape."""
    weight = (HEAD_ONLY_BEYOND - distance) / (HEAD_ONLY_BEYOND - EYES_ONLY_WITHIN)
    between = weight * eye + (1 - weight) * head
    near = np.where((weight >= 1) | np.isnan(head), eye, between)
    return np.where((weight > 0) & ~np.isnan(eye), near, head)


def _pierce(origin: FloatArray, direction: FloatArray, face: Vec3 | FloatArray) -> FloatArray:
    """Where rays, (3, ...), pierce the plane: y and z, (2, ...); inf for none, NaN for unknown."""
    x, y, z = origin
    dx, dy, dz = direction
    unknown = np.isnan(x + y + z + dx + dy + dz) | ((dx == 0) & (dy == 0) & (dz == 0))
    steps = (face[0] - x) / dx
    points = np.stack([y + steps * dy, z + steps * dz])
    missed = (dx >= 0) | (x <= face[0]) | ~np.isfinite(points[0] + points[1])
    points[:, missed] = np.inf
    points[:, unknown] = np.nan
    return points


def _ray_gaze(origin: FloatArray, points: FloatArray, face: Vec3 | FloatArray) -> FloatArray:
    """The gaze ratio of gaze points y and z, (2, ...), seen from (3, ...) (thesis 3.7-3.8)."""
    (x, y, z), (to_y, to_z) = origin, points
    radius = RIM * np.hypot(np.hypot(x - face[0], y - to_y), z - to_z)
    beside = np.hypot(to_y - face[1], to_z - face[2])
    gaze = np.where(beside < GAZE_CEILING * radius, beside / radius, GAZE_CEILING)
    return np.where(np.isnan(to_y), np.nan, gaze)

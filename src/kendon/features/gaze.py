"""How far beside the robot's face a person looks (thesis 3.3.3).

A gaze ray pierces the robot's frontal plane, the vertical plane through its face across its
forward axis, in the gaze point. Gaze is the distance from there to the robot's face in units
of the radius that a cone of 60 degrees around the ray has at that point (3.7-3.8): 0 is
straight at the face, 1 is on the rim of the cone, where looking and not looking are equally
likely.
"""

from __future__ import annotations

import math

import numpy as np

from kendon.person import FloatArray

#: The opening angle of the cone of visual attention (thesis 3.3.3) [rad].
CONE_ANGLE = math.radians(60)

#: What a ray that runs away from the plane gets, and the most any ray gets. A ray parallel to
#: the plane reaches 1 / tan 30 degrees = 1.73 as seen from straight ahead; 2 lies just above it
#: and is as good as certain not to be a look at the robot.
GAZE_CEILING = 2.0

#: Nearer than this the eyes decide alone; farther than `HEAD_ONLY_BEYOND` the head does [m].
#: An iris is 11.7 mm wide: at 1.5 m it still covers about six pixels of a 640-pixel image of
#: 60 degrees, at 2.5 m three, too few to tell where it sits in the eye.
EYES_ONLY_WITHIN = 1.5
HEAD_ONLY_BEYOND = 2.5


def ray_gaze(origin: FloatArray, gaze_point: FloatArray, robot_face: FloatArray) -> FloatArray:
    """The gaze ratio of gaze points seen from origins (thesis 3.7-3.8).

    Args:
        origin: where the rays start, shape (..., 3) [m].
        gaze_point: where they pierce the plane, shape (..., 3) [m]; infinite where they do not.
        robot_face: the robot's face, shape (3,) [m].

    Returns:
        Shape (...), between 0 and `GAZE_CEILING`; NaN where the input is unknown.
    """
    # A ray that all but runs along the plane pierces it too far away for floating point.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        way = np.linalg.norm(gaze_point - origin, axis=-1)
        beside = np.linalg.norm(gaze_point - robot_face, axis=-1)
        radius = math.tan(CONE_ANGLE / 2) * way
        ratio = np.minimum(beside / radius, GAZE_CEILING)
    unknown = np.isnan(gaze_point).any(axis=-1) | np.isnan(origin).any(axis=-1)
    return np.where(np.isnan(ratio) & ~unknown, GAZE_CEILING, np.where(unknown, np.nan, ratio))


def pierce(origin: FloatArray, direction: FloatArray, robot_face: FloatArray) -> FloatArray:
    """Where rays pierce the plane x = the robot face's x (thesis 3.4-3.5, 3.9-3.10).

    Returns:
        Shape (..., 3) [m]; infinite where a ray runs along the plane or away from it, NaN where
        it is unknown; a direction of length 0, which detectors give for none, is unknown.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        steps = (robot_face[0] - origin[..., 0]) / direction[..., 0]
        point = origin + steps[..., None] * direction
    unknown = np.isnan(origin).any(axis=-1) | np.isnan(direction).any(axis=-1)
    unknown |= (direction == 0).all(axis=-1)
    pierces = (steps > 0) & np.isfinite(point).all(axis=-1)
    point[~pierces] = np.inf
    point[unknown] = np.nan
    return np.asarray(point)


def head_gaze(head: FloatArray, rotation: FloatArray, robot_face: FloatArray) -> FloatArray:
    """Gaze from the orientation of the head (thesis 3.3.3, Gaze Detector 2).

    The ray starts at the face and runs along the head's x axis; (3.9) and (3.10) are its
    intersection with the plane written with tangents.

    Args:
        head: faces in ``base_footprint``, shape (..., 3) [m].
        rotation: orientations of the head, quaternions x y z w of any length, shape (..., 4).
        robot_face: the robot's face in the same frame, shape (3,) [m].

    Returns:
        Shape (...), between 0 and `GAZE_CEILING`; NaN = unknown.
    """
    # The rotated x axis times the quaternion's squared length, written out: this is the hot path,
    # and scipy's rotations alone would double the time that kendon takes to start.
    x, y, z, w = (rotation[..., i] for i in range(4))
    direction = np.stack(
        [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1
    )
    return ray_gaze(head, pierce(head, direction, robot_face), robot_face)


def eye_gaze(eyes: FloatArray, directions: FloatArray, robot_face: FloatArray) -> FloatArray:
    """Gaze from the eyes (thesis 3.4-3.6, Gaze Detector 1).

    The gaze point is the mean of both eyes' (3.6); one known eye decides alone.

    Args:
        eyes: centres of both eyes, shape (..., 2, 3) [m].
        directions: directions out of them, any length, shape (..., 2, 3).
        robot_face: the robot's face in the same frame, shape (3,) [m].

    Returns:
        Shape (...), between 0 and `GAZE_CEILING`; NaN = unknown.
    """
    points = pierce(eyes, directions, robot_face)
    known = ~np.isnan(points).any(axis=-1, keepdims=True)
    count = known.sum(axis=-2)
    with np.errstate(invalid="ignore", divide="ignore"):
        between = np.where(known, eyes, 0).sum(axis=-2) / count
        point = np.where(known, points, 0).sum(axis=-2) / count
    return ray_gaze(between, point, robot_face)


def blend(eye: FloatArray, head: FloatArray, distance: FloatArray) -> FloatArray:
    """The eyes' gaze near, the head's gaze far, a straight hand-over between.

    Past `HEAD_ONLY_BEYOND` the eyes are never used: their direction is noise there (thesis
    3.3.3). Where one of the two is unknown the other decides, with that exception.

    Args:
        eye: from `eye_gaze`, shape (...).
        head: from `head_gaze`, shape (...).
        distance: of the face, shape (...) [m].
    """
    weight = (HEAD_ONLY_BEYOND - distance) / (HEAD_ONLY_BEYOND - EYES_ONLY_WITHIN)
    weight = np.clip(weight, 0, 1)
    usable = np.where(weight > 0, eye, np.nan)
    mixed = np.where(weight > 0, weight * eye + (1 - weight) * head, head)
    return np.where(np.isnan(usable), head, np.where(np.isnan(head), usable, mixed))

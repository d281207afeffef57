"""How far beside the robot's face a person looks (thesis 3.3.3).

A gaze ray pierces the robot's frontal plane, the vertical plane through its face across its
forward axis, in the gaze point. Gaze is the distance from there to the robot's face in units
of the radius that a cone of 60 degrees around the ray has at that point (3.7-3.8): 0 is
straight at the face, 1 is on the rim of the cone, where looking and not looking are equally
likely. The plane has a front: who stands behind it cannot look at the robot's face.

One person at a time, in plain numbers: this runs for every frame of a flow, and a single ray is
too little for array arithmetic to pay. Arrays of people: `kendon.features.gaze_of_track`.
"""

from __future__ import annotations

import math

from kendon.geometry import UNKNOWN_POINT, Quaternion, Vec3

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

#: Where a ray that runs away from the plane pierces it.
_NOWHERE: Vec3 = (math.inf, math.inf, math.inf)
#: The radius of the cone of visual attention, one metre along its axis.
RIM = math.tan(CONE_ANGLE / 2)


def pierce(origin: Vec3, direction: Vec3, robot_face: Vec3) -> Vec3:
    """Where a ray pierces the plane x = the robot face's x from ahead (thesis 3.4-3.5, 3.9-3.10).

    Returns:
        A point [m]; infinite for a ray that starts behind the plane, runs along it or away from
        it; NaN for an unknown one. A direction of length 0, which detectors give for none, is
        unknown.
    """
    x, y, z = origin
    dx, dy, dz = direction
    known = x + y + z + dx + dy + dz  # NaN if one of them is, and then unequal to itself
    if known != known or (dx == 0 and dy == 0 and dz == 0):
        return UNKNOWN_POINT
    if dx >= 0 or x <= robot_face[0]:
        return _NOWHERE
    steps = (robot_face[0] - x) / dx
    point = (robot_face[0], y + steps * dy, z + steps * dz)
    # A ray that all but runs along the plane pierces it too far away for floating point.
    return point if math.isfinite(point[1] + point[2]) else _NOWHERE


def ray_gaze(origin: Vec3, gaze_point: Vec3, robot_face: Vec3) -> float:
    """The gaze ratio of a gaze point seen from the ray's origin (thesis 3.7-3.8).

    Args:
        origin: where the ray starts, ahead of the plane [m].
        gaze_point: where it pierces the plane [m]; infinite where it does not.
        robot_face: the robot's face [m].

    Returns:
        Between 0 and `GAZE_CEILING`; NaN where the gaze point is unknown.
    """
    if gaze_point[0] != gaze_point[0]:
        return math.nan
    if gaze_point[0] == math.inf:
        return GAZE_CEILING
    radius = RIM * math.dist(origin, gaze_point)
    beside = math.dist(gaze_point, robot_face)
    # Not divided first: both may be too large for floating point.
    return beside / radius if beside < GAZE_CEILING * radius else GAZE_CEILING


def gaze_of_head(head: Vec3, rotation: Quaternion, robot_face: Vec3) -> float:
    """Gaze from the orientation of the head (thesis 3.3.3, Gaze Detector 2).

    The ray starts at the face and runs along the head's x axis; (3.9) and (3.10) are its
    intersection with the plane written with tangents.

    Args:
        head: the face in ``base_footprint`` [m].
        rotation: the orientation of the head, a quaternion x y z w of any length.
        robot_face: the robot's face in the same frame [m].

    Returns:
        Between 0 and `GAZE_CEILING`; NaN = unknown.
    """
    x, y, z, w = rotation
    # The rotated x axis times the quaternion's squared length.
    direction = (w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y))
    return ray_gaze(head, pierce(head, direction, robot_face), robot_face)


def gaze_of_eyes(eyes: tuple[Vec3, Vec3], directions: tuple[Vec3, Vec3], robot_face: Vec3) -> float:
    """Gaze from the eyes (thesis 3.4-3.6, Gaze Detector 1).

    The gaze point is the mean of both eyes' (3.6); one known eye decides alone.

    Args:
        eyes: centres of both eyes [m].
        directions: directions out of them, any length.
        robot_face: the robot's face in the same frame [m].

    Returns:
        Between 0 and `GAZE_CEILING`; NaN = unknown.
    """
    left, right = eyes
    left_point = pierce(left, directions[0], robot_face)
    right_point = pierce(right, directions[1], robot_face)
    if left_point[0] != left_point[0]:
        return ray_gaze(right, right_point, robot_face)
    if right_point[0] != right_point[0]:
        return ray_gaze(left, left_point, robot_face)
    return ray_gaze(_mean(left, right), _mean(left_point, right_point), robot_face)


def _mean(a: Vec3, b: Vec3) -> Vec3:
    return ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2)


def blend(eye: float, head: float, distance: float) -> float:
    """The eyes' gaze near, the head's gaze far, a straight hand-over between.

    Past `HEAD_ONLY_BEYOND` the eyes are never used: their direction is noise there (thesis
    3.3.3). Where one of the two is unknown the other decides, with that exception.

    Args:
        eye: from `gaze_of_eyes`.
        head: from `gaze_of_head`.
        distance: of the face [m].
    """
    weight = (HEAD_ONLY_BEYOND - distance) / (HEAD_ONLY_BEYOND - EYES_ONLY_WITHIN)
    if not weight > 0 or eye != eye:
        return head
    if weight >= 1 or head != head:
        return eye
    return weight * eye + (1 - weight) * head

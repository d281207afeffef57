"""Small planar geometry in REP-103 frames: x forward, y left, z up, radians, metres."""

from __future__ import annotations

import math
from typing import NamedTuple

#: A point or direction, x y z [m].
Vec3 = tuple[float, float, float]
#: A rotation as a unit quaternion, x y z w.
Quaternion = tuple[float, float, float, float]

UNKNOWN_POINT: Vec3 = (math.nan, math.nan, math.nan)
UNKNOWN_ROTATION: Quaternion = (math.nan, math.nan, math.nan, math.nan)


def wrap_angle(angle: float) -> float:
    """The same angle in [-pi, pi) [rad].

    >>> wrap_angle(3 * math.pi / 2) == -math.pi / 2
    True
    """
    return (angle + math.pi) % (2 * math.pi) - math.pi


def yaw_quaternion(yaw: float) -> Quaternion:
    """The rotation by `yaw` [rad] about z."""
    return (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))


def quaternion_yaw(q: Quaternion) -> float:
    """Where the rotated x axis points in the ground plane [rad]; NaN when unknown."""
    x, y, z, w = q
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def compose(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation that applies `b`, then `a` (Hamilton product a b)."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


class Pose2D(NamedTuple):
    """A pose on the ground: the pose of `base_footprint` in `map`, unless said otherwise."""

    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad]

    def to_world(self, point: Vec3) -> Vec3:
        """A point of this pose's frame, in the frame this pose is given in [m]."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        x, y, z = point
        return (self.x + c * x - s * y, self.y + s * x + c * y, z)

    def to_local(self, point: Vec3) -> Vec3:
        """The inverse of `to_world` [m]."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        dx, dy, z = point[0] - self.x, point[1] - self.y, point[2]
        return (c * dx + s * dy, -s * dx + c * dy, z)

    def distance_to(self, other: Pose2D) -> float:
        """Ground-plane distance between the two origins [m]."""
        return math.hypot(other.x - self.x, other.y - self.y)


ORIGIN = Pose2D(0.0, 0.0, 0.0)

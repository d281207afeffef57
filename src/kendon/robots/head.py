"""A pan-tilt head with joint and rate limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from kendon.errors import ParameterError
from kendon.geometry import Pose2D, Vec3


@dataclass(frozen=True, slots=True)
class HeadLimits:
    """What a head can do. Pan is positive to the left, tilt is positive up.

    The pan range is Vizzy's neck. Vizzy's tilt joint turns further than a face should (to
    -2.0 and 2.5 rad from a zero of its own), so the tilt range is a person's neck, about 60
    degrees either way. Vizzy's motors do 5 rad/s; the default is chosen slower, the pace of
    an unhurried turn of a person's head.

    Raises:
        ParameterError: a range is empty or does not hold 0, or the rate is not positive.
    """

    pan: tuple[float, float] = (-2.03, 2.03)  # [rad]
    tilt: tuple[float, float] = (-1.05, 1.05)  # [rad]
    rate: float = 2.0  # [rad/s], each joint
    tolerance: float = 0.01  # [rad], of each joint; 2 cm at 2 m

    def __post_init__(self) -> None:
        for name, (low, high) in (("pan", self.pan), ("tilt", self.tilt)):
            if not -math.pi <= low <= 0 <= high <= math.pi:
                raise ParameterError(
                    f"a head's {name} range runs from within [-pi, 0] to within [0, pi],"
                    f" not from {low} to {high}"
                )
        for name in ("rate", "tolerance"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ParameterError(f"a head's {name} is a positive, finite number, not {value}")


class PanTiltHead:
    """Two joints whose axes meet in the face, so that turning the head leaves the face in place.

    Args:
        face: where the axes meet, in the base frame [m].
        limits: the joints' ranges and rate.
    """

    __slots__ = ("face", "limits", "pan", "tilt")

    def __init__(self, face: Vec3, limits: HeadLimits) -> None:
        self.face = face
        self.limits = limits
        self.pan = 0.0  # [rad], to the left
        self.tilt = 0.0  # [rad], up

    def angles_to(self, point: Vec3, base: Pose2D) -> tuple[float, float, bool]:
        """Pan and tilt that point the face at a world point [rad], and whether it can.

        Out of the joints' ranges the angles are those at the limit.
        """
        x, y, z = base.to_local(point)
        x, y, z = x - self.face[0], y - self.face[1], z - self.face[2]
        pan, tilt = math.atan2(y, x), math.atan2(z, math.hypot(x, y))
        (pan_low, pan_high), (tilt_low, tilt_high) = self.limits.pan, self.limits.tilt
        sent_pan = min(max(pan, pan_low), pan_high)
        sent_tilt = min(max(tilt, tilt_low), tilt_high)
        return sent_pan, sent_tilt, sent_pan == pan and sent_tilt == tilt

    def turn(self, pan: float, tilt: float, dt: float) -> bool:
        """Turn the joints toward two angles for `dt` [s]; True when both are there."""
        reach = self.limits.rate * dt
        self.pan += min(max(pan - self.pan, -reach), reach)
        self.tilt += min(max(tilt - self.tilt, -reach), reach)
        near = self.limits.tolerance
        return abs(pan - self.pan) <= near and abs(tilt - self.tilt) <= near

    def direction(self, yaw: float) -> Vec3:
        """Where the face points in the world, a unit vector, on a base that heads `yaw`."""
        level = math.cos(self.tilt)
        heading = yaw + self.pan
        return (level * math.cos(heading), level * math.sin(heading), math.sin(self.tilt))

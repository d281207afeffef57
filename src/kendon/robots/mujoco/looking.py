"""Head and eyes of a robot with a body: where they turn for a point, and how fast."""

from __future__ import annotations

import math

from kendon.geometry import Vec3
from kendon.person import FloatArray
from kendon.robots.head import HeadLimits
from kendon.robots.mujoco.body import CYCLE, Body
from kendon.robots.mujoco.description import HeadJoints
from kendon.robots.mujoco.gaze import local_point
from kendon.robots.mujoco.motion import Chaser

#: How quickly eyes gather speed [rad/s^2]: they reach 5 rad/s within a tenth of a second.
_EYE_ACCELERATION = 60.0


class Looking:
    """Turns head and eyes to points, one control cycle after the other.

    Args:
        body: whose.
        head: its limits beyond those of the joints.
    """

    def __init__(self, body: Body, head: HeadJoints) -> None:
        self._body = body
        ranges = []
        for joint, sign in ((body.pan, body.pan_sign), (body.tilt, body.tilt_sign)):
            ends = sorted((sign * float(body.low[joint]), sign * float(body.high[joint])))
            ranges.append((max(ends[0], -math.pi), min(ends[1], math.pi)))
        if head.tilt_range is not None:
            low, high = (math.radians(a) for a in head.tilt_range)
            ranges[1] = max(low, ranges[1][0]), min(high, ranges[1][1])
        rate = min(head.rate, float(body.speeds[[body.pan, body.tilt]].min()))
        self.limits = HeadLimits(ranges[0], ranges[1], rate)
        self._pan = Chaser(float(body.rest[body.pan]), rate, head.acceleration)
        self._tilt = Chaser(float(body.rest[body.tilt]), rate, head.acceleration)
        self._eyes = [
            Chaser(float(body.rest[eye]), float(body.speeds[eye]), _EYE_ACCELERATION)
            for eye in body.eyes
        ]
        self._eye_ranges = [(float(body.low[eye]), float(body.high[eye])) for eye in body.eyes]
        self.target = (0.0, 0.0)  # [rad], to the left and up
        self.reachable = True  # whether the head's joints let it point there
        self.done = False  # whether head and eyes have nothing left to do for a point

    @property
    def turning(self) -> bool:
        """Whether the head or an eye is on its way."""
        return any(chaser.rate for chaser in (self._pan, self._tilt, *self._eyes))

    def aim(self, point: Vec3) -> None:
        """Work out where the head must turn for a point, from where the body is now [m]."""
        body, limits = self._body, self.limits
        pan, tilt = body.head.angles(body.data, point)
        pan, tilt = pan * body.pan_sign, tilt * body.tilt_sign
        sent_pan = min(max(pan, limits.pan[0]), limits.pan[1])
        sent_tilt = min(max(tilt, limits.tilt[0]), limits.tilt[1])
        self.target = sent_pan, sent_tilt
        self.reachable = sent_pan == pan and sent_tilt == tilt

    def step(self, point: Vec3 | None) -> None:
        """Turn on for a cycle, toward a point [m], or to a stand where there is none."""
        body = self._body
        if point is None:
            for chaser in (self._pan, self._tilt, *self._eyes):
                if chaser.rate:
                    chaser.step(None, CYCLE)
            return
        self.aim(point)
        pan, tilt = self.target
        self._pan.step(pan * body.pan_sign, CYCLE)
        self._tilt.step(tilt * body.tilt_sign, CYCLE)
        local: dict[int, Vec3] = {}  # eyes that hang in the same body see it at the same place
        for pointer, (low, high), chaser in zip(
            body.eye_pointers, self._eye_ranges, self._eyes, strict=True
        ):
            if pointer.parent not in local:
                local[pointer.parent] = local_point(body.data, pointer.parent, point)
            chaser.step(min(max(pointer.angle(local[pointer.parent]), low), high), CYCLE)
        self.done = not self.turning

    def pose(self, targets: FloatArray) -> None:
        """Set the eyes' set-points [rad], and add to what a gesture has the head do."""
        body = self._body
        targets[body.pan] += self._pan.position
        targets[body.tilt] += self._tilt.position
        for eye, chaser in zip(body.eyes, self._eyes, strict=True):
            targets[eye] = chaser.position

    def is_at(self, point: Vec3, posed: FloatArray) -> bool:
        """Whether the head points at a point [m], or as near as its joints let it.

        Args:
            point: in the world.
            posed: what a gesture adds to each joint [rad or m].
        """
        body, near = self._body, self.limits.tolerance
        self.aim(point)
        pan, tilt = self.target
        angles = body.angles
        return bool(
            abs(angles[body.pan] - posed[body.pan] - pan * body.pan_sign) <= near
            and abs(angles[body.tilt] - posed[body.tilt] - tilt * body.tilt_sign) <= near
        )

"""From a person's body to the gesture probabilities of an interval (thesis 3.3.5)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from kendon.features.gestures.evidence import either, logistic
from kendon.features.gestures.hands import ARM, Arm, HandGestures, shoulder_of
from kendon.features.gestures.head import Head
from kendon.features.gestures.trunk import Trunk
from kendon.geometry import UNKNOWN_POINT, Quaternion, Vec3

#: Two arms' reach and a little lean: nearer than this a salutation is a close one [m].
HANDSHAKE_DISTANCE = 1.3
#: How soft that border is [m].
_SOFTNESS = 0.12
#: How long a new estimate of the arm's length takes to count [intervals].
_SLOWNESS = 5.0


class Gestures(NamedTuple):
    """Probabilities of gestures in one interval; NaN = unknown."""

    dsal: float  # a distance salutation: wave, head toss, nod or bow from afar
    csal: float  # a close salutation: handshake, or one of those at handshake distance
    hdip: float  # a head dip
    wave: float = math.nan  # with either hand
    handshake: float = math.nan  # with either hand
    nod: float = math.nan  # a nod or a head toss
    bow: float = math.nan


#: What is known of an interval in which nobody is seen.
NOTHING = Gestures(math.nan, math.nan, math.nan)


class GestureDetector:
    """Reads gestures from frames as they come, and tells them for an interval."""

    def __init__(self) -> None:
        self._left, self._right = Arm(), Arm()
        self._head, self._trunk = Head(), Trunk()
        self.clear()

    def clear(self) -> None:
        """The person has been lost: forget everything."""
        for part in (self._left, self._right, self._head, self._trunk):
            part.clear()
        self._arm = ARM
        self._distance = math.nan

    def add(
        self, t: float, head: Vec3, rotation: Quaternion, joints: Mapping[str, Vec3]
    ) -> None:
        """Take in what is seen at an instant, in the robot's base frame.

        Args:
            t: later than the last [s].
            head: the face [m].
            rotation: of the head.
            joints: by their names in `kendon.person.JOINTS` [m].
        """
        self._head.add(t, rotation)
        if joints:
            left = joints.get("l_shoulder", UNKNOWN_POINT)
            right = joints.get("r_shoulder", UNKNOWN_POINT)
            self._left.add(
                t, shoulder_of(left, right, head),
                joints.get("l_elbow", UNKNOWN_POINT), joints.get("l_wrist", UNKNOWN_POINT),
            )  # fmt: skip
            self._right.add(
                t, shoulder_of(right, left, head),
                joints.get("r_elbow", UNKNOWN_POINT), joints.get("r_wrist", UNKNOWN_POINT),
            )  # fmt: skip
            self._add_trunk(t, head, left, right, joints)

    def _add_trunk(
        self, t: float, head: Vec3, left: Vec3, right: Vec3, joints: Mapping[str, Vec3]
    ) -> None:
        hip_left = joints.get("l_hip", UNKNOWN_POINT)
        hip_right = joints.get("r_hip", UNKNOWN_POINT)
        # The way ahead is across the line through the shoulders.
        ahead_x, ahead_y = left[1] - right[1], right[0] - left[0]
        size = math.sqrt(ahead_x * ahead_x + ahead_y * ahead_y)
        if size > 0.0:
            self._trunk.add(
                t, head, _middle(left, right), _middle(hip_left, hip_right),
                (ahead_x / size, ahead_y / size, 0.0),
            )  # fmt: skip

    def complete(
        self, given: Sequence[float], end: float, since: float, distance: float
    ) -> tuple[float, float, float]:
        """The three probabilities of an observation: those given by hand, else the detected ones.

        Args:
            given: dsal, csal and hdip; NaN where they are not given.
            end: of the interval [s].
            since: its first frame [s].
            distance: of the person from the robot [m]; NaN when unknown.
        """
        dsal, csal, hdip = given
        if dsal == dsal and csal == csal and hdip == hdip:
            return dsal, csal, hdip
        found = self.gestures(end, since, distance)
        return (
            dsal if dsal == dsal else found.dsal,
            csal if csal == csal else found.csal,
            hdip if hdip == hdip else found.hdip,
        )

    def gestures(self, end: float, since: float, distance: float) -> Gestures:
        """The gestures of an interval.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            distance: of the person from the robot [m]; NaN when unknown.
        """
        lengths = [arm.length(since) for arm in (self._left, self._right)]
        known = [length for length in lengths if length == length]
        if known:
            self._arm += (sum(known) / len(known) - self._arm) / _SLOWNESS
        left, right = (
            one.gestures(end, since, self._arm, other, distance)
            for one, other in ((self._left, self._right), (self._right, self._left))
        )
        trunk = self._trunk.gestures(end, since)
        head = self._head.gestures(end, since, trunk.flexion)
        return _salutations(left, right, trunk.bow, head.nod, head.dip, distance)


def _salutations(
    left: HandGestures, right: HandGestures, bow: float, nod: float, dip: float, distance: float
) -> Gestures:
    wave = either(left.wave, right.wave)
    handshake = either(left.handshake, right.handshake)
    salutation = either(wave, bow, nod)
    if wave != wave and not salutation > 0.5:
        # Most salutations are made with the hands: a head that does nothing says little.
        salutation = math.nan
    close = logistic((HANDSHAKE_DISTANCE - distance) / _SOFTNESS) if distance == distance else 0.5
    return Gestures(
        dsal=salutation * (1.0 - close),
        csal=either(salutation * close, handshake),
        hdip=dip,
        wave=wave,
        handshake=handshake,
        nod=nod,
        bow=bow,
    )


def _middle(a: Vec3, b: Vec3) -> Vec3:
    return ((a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0, (a[2] + b[2]) / 2.0)

"""From a person's body to the gesture probabilities of an interval (thesis 3.3.5)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from kendon.features.gestures.arm import ARM, Arm, shoulder_of
from kendon.features.gestures.evidence import either, posterior, surer
from kendon.features.gestures.hands import (
    NO_WAVE,
    HandshakeEvidence,
    WaveEvidence,
    hand_evidence,
    near_enough,
)
from kendon.features.gestures.head import DipEvidence, Head
from kendon.features.gestures.nods import NodEvidence, TossEvidence
from kendon.features.gestures.series import KEPT
from kendon.features.gestures.talk import Talk
from kendon.features.gestures.trunk import BowEvidence, Trunk
from kendon.features.gestures.weights import WEIGHTS
from kendon.geometry import UNKNOWN_POINT, Quaternion, Vec3

#: Frames older than this need not be shown to a detector that is asked again after a pause [s].
READ_BACK = 2 * KEPT
#: How long a new estimate of the arm's length takes to count [intervals].
SLOWNESS = 5.0
#: From this probability on a wave may have begun; two to four times what it usually is.
BEGUN = 0.2
#: From this on something is read: hands greet, and do not talk; a head alone salutes.
READ = 0.5
#: A hand that is up again so soon goes on with the same wave [s]; ours.
PAUSE = 0.7


#: The probability that a hand waves that hangs.
_HANGING = posterior(NO_WAVE, WEIGHTS.wave)


class Gestures(NamedTuple):
    """Probabilities of gestures in one interval; NaN = unknown."""

    dsal: float  # a distance salutation: wave, head toss, nod or bow from afar
    csal: float  # a close salutation: handshake, or one of those at handshake distance
    hdip: float  # a head dip
    wave: float = math.nan  # with either hand
    handshake: float = math.nan  # with either hand
    nod: float = math.nan  # a nod or a head toss
    bow: float = math.nan


class Evidence(NamedTuple):
    """What speaks for each gesture in one interval; None where nothing of it is seen."""

    hands: tuple[tuple[WaveEvidence, HandshakeEvidence] | None, ...]  # left and right
    nod: NodEvidence | None
    toss: TossEvidence | None
    dip: DipEvidence | None
    bow: BowEvidence | None


def _dipped(evidence: DipEvidence) -> float:
    """The probability of a dip.

    A head that is told by the middle of the skull hardly sinks, which must not speak against a
    dip: the pitch may tell it alone.
    """
    dip = posterior(evidence, WEIGHTS.dip)
    of_pitch = posterior(evidence.of_pitch, WEIGHTS.dip_of_pitch)
    return max(dip, of_pitch)  # the first where the second is unknown


def _bowed(evidence: BowEvidence) -> float:
    """The probability of a bow: of the trunk, or of what goes down with it."""
    if evidence.flexion == evidence.flexion:
        return posterior(evidence.of_trunk, WEIGHTS.bow)
    return posterior(evidence.of_height, WEIGHTS.bow_of_height)


class GestureDetector:
    """Reads gestures from frames as they come, and tells them for an interval."""

    def __init__(self) -> None:
        self._left, self._right = Arm(), Arm()
        self._head, self._trunk, self._talk = Head(), Trunk(), Talk()
        self._arm = ARM  # [m], the arms' length
        self._begun = math.nan  # how surely close the wave began that goes on
        self._waved = -math.inf  # when it was last seen [s]

    def clear(self) -> None:
        """The person has been lost: forget everything."""
        for part in (self._left, self._right, self._head, self._trunk, self._talk):
            part.clear()
        self._arm, self._begun, self._waved = ARM, math.nan, -math.inf

    def add(self, t: float, head: Vec3, rotation: Quaternion, joints: Mapping[str, Vec3]) -> None:
        """Take in what is seen at an instant, in the robot's base frame.

        Args:
            t: later than the last [s].
            head: the face [m].
            rotation: of the head.
            joints: by their names in `kendon.person.JOINTS` [m].
        """
        self._head.add(t, head, rotation)
        if not joints:
            return
        known = joints.get
        left, right = known("l_shoulder", UNKNOWN_POINT), known("r_shoulder", UNKNOWN_POINT)
        left_wrist, right_wrist = known("l_wrist", UNKNOWN_POINT), known("r_wrist", UNKNOWN_POINT)
        self._left.add(
            t, shoulder_of(left, right, head),
            known("l_elbow", UNKNOWN_POINT), left_wrist, head, right_wrist,
            own=left[2] == left[2],
        )  # fmt: skip
        self._right.add(
            t, shoulder_of(right, left, head),
            known("r_elbow", UNKNOWN_POINT), right_wrist, head, left_wrist,
            own=right[2] == right[2],
        )  # fmt: skip
        self._head.add_shoulders(t, head, left, right)
        hips = known("l_hip", UNKNOWN_POINT), known("r_hip", UNKNOWN_POINT)
        self._trunk.add(t, head, left, right, hips)

    def evidence(self, end: float, since: float, distance: float) -> Evidence:
        """What speaks for gestures in an interval; the arguments are those of `gestures`."""
        arms = ((self._left, self._right), (self._right, self._left))
        lengths = [length for one, _ in arms if (length := one.length(since)) == length]
        if lengths:
            self._arm += (sum(lengths) / len(lengths) - self._arm) / SLOWNESS
        aside = self._aside(end, since)
        hands = tuple(
            hand_evidence(one, other, self._talk, end, since, self._arm, distance, aside)
            if one.seen(since)
            else None
            for one, other in arms
        )
        if any(one.seen(since) for one, _ in arms):
            self._talk.add(end, (self._left, self._right), self._arm, distance)
        flexion, bow = math.nan, None
        if self._trunk.seen(since):
            flexion = self._trunk.flexion(end, since)
            bow = self._trunk.evidence(end, since, flexion)
        dip, nod, toss = None, None, None
        if self._head.seen(since):
            dip, nod, toss = self._head.evidence(end, since, flexion)
        return Evidence(hands, nod, toss, dip, bow)

    def greeted(self, end: float) -> None:
        """The hands have greeted in the interval that ended then [s]; it is asked about already."""
        self._talk.greeted(end)

    def _aside(self, end: float, since: float) -> float:
        """How far from the robot the head is turned, or the chest if that is less [rad].

        NaN when neither is known.
        """
        head, chest = self._head.aside(end, since), self._trunk.aside(end, since)
        return chest if head != head or chest < head else head

    def gestures(self, end: float, since: float, distance: float) -> Gestures:
        """The gestures of an interval; to be asked once for each, in their order.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            distance: of the person from the robot [m]; NaN when unknown.
        """
        found = self.evidence(end, since, distance)
        hands = [hand for hand in found.hands if hand]
        # What both hands do they do together: two of them are no two greetings.
        wave = surer(
            *[
                _HANGING if hand[0] is NO_WAVE else posterior(hand[0], WEIGHTS.wave)
                for hand in hands
            ]
        )
        handshake = surer(*[posterior(hand[1], WEIGHTS.handshake) for hand in hands])
        if wave > READ or handshake > READ:
            self.greeted(end)
        nod = either(
            posterior(found.nod, WEIGHTS.nod) if found.nod else math.nan,
            posterior(found.toss, WEIGHTS.toss) if found.toss else math.nan,
        )
        dip = _dipped(found.dip) if found.dip else math.nan
        bow = _bowed(found.bow) if found.bow else math.nan
        others = either(bow, nod)
        if wave != wave and not others > READ:
            # Most salutations are made with the hands: a head that does nothing says little.
            others = math.nan
        close = near_enough(distance)
        begun = self._begun_close(end, wave, close)
        return Gestures(
            dsal=either(wave * (1.0 - begun), others * (1.0 - close)),
            csal=either(wave * begun, others * close, handshake),
            hdip=dip * (1.0 - bow) if bow == bow else dip,  # who bows takes the head along
            wave=wave,
            handshake=handshake,
            nod=nod,
            bow=bow,
        )

    def _begun_close(self, end: float, wave: float, close: float) -> float:
        """How surely a wave is a close salutation: as surely as where it began.

        Who walks up waving from afar goes on with the distance salutation, also where the hand
        comes down for a moment.
        """
        if wave > BEGUN:
            if end - self._waved > PAUSE:
                self._begun = close
            self._waved = end
            return self._begun
        return close

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

"""Whether somebody has been talking with their hands, told from hands that are fully known."""

from __future__ import annotations

import math

from kendon.features.gestures.arm import Arm
from kendon.features.gestures.talk import LEAST, NEAR, TALKED, Talk

ARM = 0.55


def beating(until: float) -> Arm:
    """A hand before the belly that beats up and down by 0.3 m until an instant [s]."""
    arm = Arm()
    for k in range(round(30 * until)):
        t = k / 30
        z = 1.15 + 0.15 * math.sin(2 * math.pi * 1.5 * t)
        arm.add(
            t, (1.0, 0.2, 1.4), (1.0, 0.2, 1.1), (0.75, 0.2, z), (1.0, 0, 1.6), (1.0, -0.2, 0.8)
        )
    return arm


def talk_of(ends: list[float], distance: float) -> Talk:
    """Of hands that beat in the intervals that end then."""
    talk = Talk()
    for end in ends:
        talk.add(end, (beating(end), Arm()), ARM, distance)
    return talk


STEADY = [0.2 * k for k in range(5, 25)]


def test_hands_that_have_stirred_near_by_have_talked() -> None:
    talk = talk_of(STEADY, 1.0)
    assert talk.evidence(5.0) == TALKED.least
    assert math.isnan(talk_of(STEADY, NEAR + 0.1).evidence(5.0))


def test_what_was_a_greeting_was_no_talk() -> None:
    talk = Talk()
    for end in STEADY:
        talk.add(end, (beating(end), Arm()), ARM, 1.0)
        talk.greeted(end)
    assert talk.evidence(5.0) == TALKED.most


def test_neither_was_the_way_to_it_but_what_was_before_hands_rested() -> None:
    talk = Talk()
    rests = STEADY[10]
    for end in STEADY:
        hands = (Arm() if end == rests else beating(end), Arm())
        talk.add(end, hands, ARM, 1.0)
    talk.greeted(STEADY[-1])
    assert talk.evidence(rests) == TALKED.least
    assert TALKED.least < talk.evidence(5.0) < TALKED.most
    later = Talk()
    for end in STEADY:
        later.add(end, (Arm(), Arm()) if end == STEADY[0] else (beating(end), Arm()), ARM, 1.0)
    later.greeted(STEADY[-1])
    assert later.evidence(5.0) == TALKED.most


def test_too_little_that_is_known_tells_nothing_also_where_somebody_was_there_long_ago() -> None:
    assert math.isnan(talk_of([1.0, 9.0, 9.2, 9.4], 1.0).evidence(9.6))
    few = STEADY[: LEAST - 1]
    assert math.isnan(talk_of(few, 1.0).evidence(few[-1] + 0.2))

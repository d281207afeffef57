"""Waves and handshakes: evidence from one hand.

A wave is a hand held up beside the head, forearm upright, mostly swinging to and fro once to
three times a second; at the turning points of a wide one the forearm lies level for a moment.
What looks like it for a moment is the arm swing of a brisk walk: there the hand comes up for less
than half a second, and the other hand has just been as high. A handshake is a hand held out to
the partner between waist and chest, to about halfway, and shaken up and down; an arm that swings
forward in a walk goes back soon.

Both begin when the hand is half way there, and end when it is half way back: a hand that goes
where it has not been for a stride is on its way, and one that falls, and does not swing aside
meanwhile, waves no more.

Who talks holds up hands, too. Those are held together or near the own face and shoulder, or stay
up for long without stirring, which no salutation does.

A hand that talks is held out, too, and taken back at once: what goes down or back fast is given
to nobody.

Lengths are in units of the arm, shoulder to wrist (`kendon.features.gestures.arm`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from kendon.features.gestures.arm import (
    ACROSS,
    HANGS,
    HOLD,
    OF_SPEED,
    OUT,
    TOWARD,
    UP,
    Arm,
    Lately,
    Row,
)
from kendon.features.gestures.evidence import Weighing, logistic
from kendon.features.gestures.series import quantile, spread, to_and_fro
from kendon.features.gestures.talk import Talk

#: Swings to and fro are looked for over so long: three strokes of a slow wave [s].
SWINGS = 1.5
#: All but this share of the while a hand must have been up, and all but that one out, to be held
#: there: waves turn, handshakes do not.
LET_GO, DRAWN_BACK = 0.25, 0.15
#: Waves turn above this height; a hand that is lower by that much more is on its way down [arms].
TURNS, FALLS = -0.25, 0.2
#: Where a hand turns is told by where it will be so long after now [s].
AHEAD = 0.1
#: How far noise alone seems to go to and fro, in its standard deviations.
FRAYED = 2.0
#: Handshakes are so high [arms over the shoulder].
CHEST = -0.35
#: Two arms' reach and a little lean: nearer than this a salutation is a close one, and how soft
#: that border is [m].
HANDSHAKE_DISTANCE, SOFTNESS = 1.3, 0.12
#: Nearer than this people embrace, and how soft that border is [m].
EMBRACE, EMBRACE_SOFTNESS = 0.75, 0.25


class WaveEvidence(NamedTuple):
    """What speaks for a wave with one hand."""

    height: float
    lasting: float
    upright: float
    sway: float
    alone: float
    opened: float
    parted: float
    fresh: float
    still: float
    faces: float
    risen: float
    falls: float
    talked: float


class HandshakeEvidence(NamedTuple):
    """What speaks for a handshake with one hand."""

    reach: float
    held: float
    halfway: float
    shake: float
    near: float
    level: float
    steady: float
    parted: float
    fresh: float
    faces: float
    reaches: float
    reached: float
    taken_back: float
    talked: float


# Waves.
HEIGHT = Weighing(-0.25, 0.15, -3.0, 2.5)  # of the wrist over the shoulder [arms]
LASTING = Weighing(-0.40, 0.10, -2.0, 2.5)  # the same, where it lasts
UPRIGHT = Weighing(0.30, 0.25, -2.0, 2.0)  # forearm: -1 hangs, 0 horizontal, 1 upright
SWAY = Weighing(0.12, 0.06, -1.0, 3.0)  # to and fro of a hand that is up [arms]
ALONE = Weighing(0.20, 0.08, -4.0, 1.0)  # height over the other hand's highest [arms]
AT_HEAD = Weighing(0.38, -0.08, 0.0, 1.0)  # wrist from the face, as seen from the robot [arms]
#: Wrist from shoulder [arms]. With the elbow bent by 145 degrees, the most that elbows bend, it is
#: 0.32 (Winter 2009, AAOS 1965): a wrist that is nearer is misplaced, or something else.
OPENED = Weighing(0.33, 0.04, -6.0, 1.0)
RISEN = Weighing(0.30, 0.10, 0.0, 3.0)  # over where it came in the stride before [arms]
FALLING = Weighing(0.0, 0.6, -4.0, 0.0)  # up just now, and aside [arms/s]

# Handshakes.
REACH = Weighing(0.50, 0.10, -3.0, 2.0)  # toward the robot [arms]
HELD_REACH = Weighing(0.40, 0.10, -3.0, 2.0)  # the same, where it is held
HALFWAY = Weighing(0.35, 0.10, -2.0, 1.5)  # share of the way to the robot the hand is out
SHAKE = Weighing(0.06, 0.04, -0.7, 1.5)  # up and down of a hand that is out [arms]
NEAR = Weighing(1.8, -0.2, -7.0, 1.0)  # the person from the robot [m]
STEADY = Weighing(0.08, -0.03, -3.0, 1.0)  # toward the robot and back, standard dev. [arms]
LEVEL = Weighing(0.35, -0.07, -4.0, 0.5)  # higher or lower than `CHEST` [arms]
REACHES = Weighing(0.0, 0.5, -3.0, 3.0)  # toward the robot just now [arms/s]
REACHED = Weighing(0.20, 0.10, 0.0, 3.0)  # beyond where it came in the stride before [arms]
LOWERED = Weighing(-1.0, 0.5, -4.0, 0.0)  # up just now: shakes are seldom so wide and fast [arms/s]
WITHDRAWN = Weighing(-0.4, 0.4, -4.0, 0.0)  # toward the robot just now [arms/s]

#: A hand that is held up and does not swing greets from afar, not in a talk.
STILL = Weighing(1.5, 0.1, -5.0, 1.0)  # the person from the robot [m]

# Both.
PARTED = Weighing(0.75, 0.12, -3.0, 1.0)  # wrist from wrist [arms]
FRESH = Weighing(1.8, -0.4, -4.0, 0.5)  # up, or out, without a pause for so long [s]
FACES = Weighing(math.radians(45), math.radians(-15), -3.0, 1.0)  # turned from the robot [rad]

#: How far the hands are apart, in a row.
_PARTED = Row._fields.index("parted")

#: Of a hand that hangs all is said.
NO_WAVE = WaveEvidence(
    HEIGHT.least, LASTING.least, UPRIGHT.least, 0.0, ALONE.least,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
)  # fmt: skip


def _no_handshake(near: float) -> HandshakeEvidence:
    """Of a hand that is not out."""
    return HandshakeEvidence(
        REACH.least, HELD_REACH.least, HALFWAY.least, 0.0, near,
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    )  # fmt: skip


def hand_evidence(
    hand: Arm,
    other: Arm,
    talk: Talk,
    end: float,
    since: float,
    arm: float,
    distance: float,
    aside: float,
) -> tuple[WaveEvidence, HandshakeEvidence]:
    """What a hand does in an interval in which it is seen; asked of intervals in order.

    Args:
        hand: the arm.
        other: the other one.
        talk: whether hands have been talking.
        end: of the interval [s].
        since: its first frame [s].
        arm: the arms' length [m].
        distance: of the person from the robot; NaN when unknown [m].
        aside: how far from the robot the person is turned; NaN when unknown [rad].
    """
    lately = hand.lately(end, since, arm)
    near = NEAR.evidence(distance)
    if not (lately.raised or lately.out):
        return NO_WAVE, _no_handshake(near)
    parted = lately.columns[_PARTED][lately.now :]
    parts = PARTED.evidence(quantile(parted, 0.5) / arm, lately.noise_now)
    asked = _Asked(hand, other, talk, lately, end, arm, distance, parts, FACES.evidence(aside))
    return (
        _wave(asked) if lately.raised else NO_WAVE,
        _handshake(asked, near) if lately.out else _no_handshake(near),
    )


class _Asked(NamedTuple):
    """What both gestures are told from."""

    hand: Arm
    other: Arm
    talk: Talk
    lately: Lately
    end: float  # of the interval [s]
    arm: float  # the arms' length [m]
    distance: float  # of the person from the robot [m]
    parts: float  # the evidence of how far apart the hands are
    faces: float  # and of how far from the robot the person is turned


def _wave(asked: _Asked) -> WaveEvidence:
    """What speaks for a wave of a hand that has been up."""
    hand, other, talk, lately, end, arm, distance, parts, faces = asked
    ups, _, across, forearm, _, apart, opened, _ = lately.columns
    noise, noise_now, now, held = lately.noise, lately.noise_now, lately.now, lately.held
    rises = hand.speed(end, UP) / arm
    height, upright = lately.up, quantile(forearm[now:], 0.5)
    # A hand that turns is as high, and the forearm as upright, as it just was: it goes down no
    # farther than aside.
    soon = height + (AHEAD * rises if rises == rises else 0.0)
    highest = max(range(min(held, now), len(ups)), key=ups.__getitem__)
    soon += abs(quantile(across[now:], 0.5) - across[highest]) / arm
    turning = min(1.0, max(0.0, (soon - TURNS) / FALLS + 1.0))
    if turning:
        height += turning * max(0.0, _kept(ups[held:], 1.0 - LET_GO) / arm - height)
        upright += turning * max(0.0, _kept(forearm[held:], 1.0 - LET_GO) - upright)
    # Who has just come into view has not been seen to hold anything.
    lasts = lately.seen * LASTING.evidence(_kept(ups, LET_GO) / arm, noise_now)
    lasts += (1.0 - lately.seen) * LASTING.least
    rows = [row for row in hand.since(end - SWINGS) if row.up > TURNS * arm]
    frayed = FRAYED * noise  # noise alone goes up and down, too
    sway = SWAY.evidence(to_and_fro([row.across for row in rows]) / arm - frayed, frayed)
    # A wave takes the hand to the face and away again. A hand on the head is high, and goes to
    # and fro, for other reasons; so may be one that has just come into view.
    while_up = quantile([row.apart for row in rows], 1.0 - LET_GO)
    at_head = min(quantile(apart, 1.0 - LET_GO), while_up) / arm
    on_head = max(0.0, AT_HEAD.evidence(at_head, noise_now))  # 0 when unknown
    free = (1.0 - on_head) * min(1.0, 0.5 + lately.seen)
    sway = _freed(sway, free)
    stirs = min(1.0, max(0.0, sway))
    if lasts < 0.0 < sway:
        # A hand that comes and goes is an arm swing, however far it goes aside.
        sway *= 1.0 - lasts / LASTING.least
    swung = other.swung(lately.since, end, arm)
    alone = other.covered(end) * ALONE.evidence(height - swung, noise_now)
    if alone < 0.0 < lasts:
        # A hand that lasts is no arm swing, however high the other one swings.
        alone *= 1.0 - lasts / LASTING.most
    # Whose arms swing brings the hand no higher than it has just come.
    usual = max(hand.reached(end, UP) / arm, HANGS)
    # A stroke goes aside as fast as down.
    falls = rises + abs(hand.speed(end, ACROSS)) / arm
    return WaveEvidence(
        _freed(HEIGHT.evidence(height, noise_now), free),
        lasts,
        _freed(UPRIGHT.evidence(upright, 2.0 * noise_now), free),
        sway,
        alone,
        OPENED.evidence(quantile(opened[now:], 0.5) / arm, noise_now),
        _excused(parts, stirs),
        _excused(_fresh(hand, hand.low, end), stirs),
        (1.0 - stirs) * STILL.evidence(distance),
        faces,
        RISEN.evidence(lately.up - usual, noise_now),
        FALLING.evidence(falls, OF_SPEED * noise),
        talk.evidence(hand.low),
    )


def _handshake(asked: _Asked, near: float) -> HandshakeEvidence:
    """What speaks for a handshake of a hand that has been out.

    Args:
        asked: of what.
        near: the evidence of how near the person is.
    """
    hand, _, talk, lately, end, arm, distance, parts, faces = asked
    ups, towards = lately.columns[UP], lately.columns[TOWARD]
    noise, noise_now, out = lately.noise, lately.noise_now, towards[lately.held :]
    frayed = FRAYED * noise
    shaking = [a for a, b in zip(ups, towards, strict=True) if b > OUT * arm]
    shake = SHAKE.evidence(to_and_fro(shaking) / arm - frayed, frayed)
    share = hand.seen_for(end, HOLD)
    held = share * HELD_REACH.evidence(_kept(out, DRAWN_BACK) / arm, noise_now)
    held += (1.0 - share) * HELD_REACH.least
    if held < 0.0 < shake:
        # Nor is a hand shaken that swings out and back.
        shake *= 1.0 - held / HELD_REACH.least
    # Who embraces somebody brings the hands together.
    embraces = min(1.0, max(0.0, (EMBRACE - distance) / EMBRACE_SOFTNESS))
    usual = max(hand.reached(end, TOWARD) / arm, 0.0)
    rises, reaches = hand.speed(end, UP) / arm, hand.speed(end, TOWARD) / arm
    of_speed = OF_SPEED * noise
    lowered = _excused(LOWERED.evidence(rises, of_speed), shake / SHAKE.most)
    withdrawn = WITHDRAWN.evidence(reaches, of_speed)
    return HandshakeEvidence(
        REACH.evidence(lately.toward, noise_now),
        held,
        HALFWAY.evidence(lately.toward * arm / (distance or math.nan), noise_now),
        shake,
        near,
        LEVEL.evidence(abs(lately.up - CHEST), noise_now),
        share * STEADY.evidence(spread(out) / arm, noise),
        _excused(parts, max(embraces, shake / SHAKE.most)),
        _excused(_fresh(hand, hand.back, end), shake / SHAKE.most),
        faces,
        REACHES.evidence(reaches, of_speed),
        REACHED.evidence(lately.toward - usual, noise_now),
        lowered if lowered < withdrawn else withdrawn,
        talk.evidence(hand.back),
    )


def _fresh(hand: Arm, rest: float, end: float) -> float:
    """The evidence of how long a hand has been up, or out.

    Of one that has not been seen at rest nobody knows: it may have been so for longer, and nothing
    speaks for it.

    Args:
        hand: the arm.
        rest: when it was last down, or not out [s].
        end: of the interval [s].
    """
    fresh = FRESH.evidence(end - rest)
    return fresh if rest > hand.first else min(0.0, fresh)


def _kept(values: Sequence[float], share: float) -> float:
    """What a share of the values lies below; NaN of too few to tell."""
    return quantile(values, share) if len(values) > 2 else math.nan


def _excused(against: float, share: float) -> float:
    """What speaks against a gesture counts less by a share, at most 1."""
    return against * (1.0 - share) if against < 0.0 < share else against


def _freed(favour: float, share: float) -> float:
    """What speaks for a gesture counts by a share, as far as nothing else explains it."""
    return favour * share if favour > 0.0 else favour


def near_enough(distance: float) -> float:
    """How surely a person is near enough for a close salutation; one half when unknown [m]."""
    near = logistic((HANDSHAKE_DISTANCE - distance) / SOFTNESS)
    return near if near == near else 0.5

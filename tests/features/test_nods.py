"""Nods and tosses told from the pitch of a head that is known to the last frame."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from kendon.features.gestures import GestureDetector
from kendon.person import Track

SEEN = 4.0  # [s]


def most_nodding(
    pitch: Callable[[float], float],
    *,
    yaw: Callable[[float], float] = lambda t: 0.0,
    rate: float = 30.0,
    noise: float = 0.0,
    lost: tuple[float, float] = (math.inf, math.inf),
) -> float:
    """The greatest probability of a nod or toss of a head 4 m away that pitches so [degrees].

    It is not seen while lost [s], and told of most of the rest.
    """
    rng = np.random.default_rng(3)
    detector = GestureDetector()
    t, asked = 0.0, 0.0
    told: list[float] = []
    while t < SEEN:
        down = math.radians(pitch(t) + noise * rng.normal())
        turned = math.pi + math.radians(yaw(t))
        rotation = (
            -math.sin(down / 2) * math.sin(turned / 2),
            math.sin(down / 2) * math.cos(turned / 2),
            math.cos(down / 2) * math.sin(turned / 2),
            math.cos(down / 2) * math.cos(turned / 2),
        )
        if not lost[0] <= t < lost[1]:
            detector.add(t, (4.0, 0.0, 1.6), rotation, {})
        t += 1 / rate
        if t >= asked + 0.2:
            told.append(detector.gestures(t, asked, 4.0).nod)
            asked = t
    known = [nod for nod in told if nod == nod]
    assert len(known) > len(told) / 2
    return max(known)


def nods(size: float, rate: float, count: int, begin: float = 2.5) -> Callable[[float], float]:
    """So many nods a second, so deep [degrees]."""

    def pitch(t: float) -> float:
        if not begin <= t < begin + count / rate:
            return 0.0
        return size * (1 - math.cos(2 * math.pi * rate * (t - begin))) / 2

    return pitch


def moved(
    size: float, rise: float, hold: float, fall: float, begin: float = 2.2
) -> Callable[[float], float]:
    """Somewhere else and back in straight lines [degrees], [s]."""
    return lambda t: float(
        np.interp(
            t, [begin, begin + rise, begin + rise + hold, begin + rise + hold + fall],
            [0.0, size, size, 0.0],
        )
    )  # fmt: skip


@pytest.mark.parametrize("per_second", [2.0, 2.5, 3.0, 3.5, 4.0])
@pytest.mark.parametrize("frames", [30.0, 60.0])
def test_nods_of_ten_degrees_are_told_however_quick(per_second: float, frames: float) -> None:
    assert most_nodding(nods(10.0, per_second, 3), rate=frames) > 0.5


def test_a_head_that_sways_at_walking_pace_does_not_nod() -> None:
    assert most_nodding(lambda t: 2.0 * math.sin(2 * math.pi * 1.9 * t)) < 0.1


def test_a_toss_goes_above_where_the_head_is_held() -> None:
    assert most_nodding(moved(-14.0, 0.2, 0.1, 0.35)) > 0.5
    # Down for a second, up for half of one as before, and down: nothing was tossed.
    down_up_down = [(1.0, 0.0), (1.3, 14.0), (2.0, 14.0), (2.2, 0.0), (2.5, 0.0), (2.7, 14.0)]
    t, pitch = zip(*down_up_down, strict=True)
    assert most_nodding(lambda at: float(np.interp(at, t, pitch))) < 0.3


def test_who_looks_up_for_longer_does_not_toss() -> None:
    assert most_nodding(moved(-14.0, 0.3, 0.9, 0.4)) < 0.2


@pytest.mark.parametrize("rate", [5.0, 6.0, 10.0, 30.0])
def test_a_look_that_a_slow_camera_or_a_loss_shortens_is_no_nod(rate: float) -> None:
    for look in (moved(10.0, 0.15, 0.5, 0.15), moved(-12.0, 0.2, 0.8, 0.2)):
        assert most_nodding(look, rate=rate) < 0.2
        for begin in (2.3, 2.4, 2.5):
            assert most_nodding(look, rate=rate, lost=(begin, begin + 0.45)) < 0.3


def test_who_looks_aside_and_back_does_not_nod() -> None:
    look = moved(30.0, 0.3, 0.1, 0.3, begin=2.4)
    assert most_nodding(nods(8.0, 2.0, 1), yaw=look) < 0.2


def test_noise_is_no_nod() -> None:
    for noise in (2.0, 5.0, 15.0):
        assert most_nodding(lambda t: 0.0, noise=noise) < 0.15


def test_a_track_of_a_still_head_has_none() -> None:
    t = np.arange(0.0, 3.0, 1 / 30)
    still = Track.build(t, np.tile([3.0, 0.0, 1.6], (len(t), 1)))
    detector = GestureDetector()
    for at, head in zip(still.t.tolist(), still.head.tolist(), strict=True):
        detector.add(at, head, (math.nan,) * 4, {})
    assert math.isnan(detector.gestures(3.0, 2.8, 3.0).nod)

"""How fast a person is, where positions alone leave it open: from the head's rise and fall.

A camera that is unsure of a person's distance by 20 cm a frame still tells the height of the
head to a centimetre. Whoever walks rises and falls by some centimetres at each step, the more the
faster (Murray 1967; Hirasaki et al. 1999: 2 to 5 cm at usual speeds), and whoever stands does
not. So the slope of the positions is taken together with how people move: they stand, take a slow
step or two, walk up to the robot, or do something else, and what the head does tells which. The
speed is its mean given both (Bayes), a mixture of normal distributions in closed form.

Sources of less than ten frames a second tell too few heights of a step, and some tell the same
height all the time because they only know the ground: then the slope stays what it was.

Where the slope is sure it decides alone. Where heights are as noisy as that rise they tell
nothing, and what is left is how often people move in which way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from kendon.person import FloatArray


class Gait(NamedTuple):
    """One way to be on one's feet in front of a robot."""

    share: float  # of the time
    speed: float  # over the ground, in the mean, negative when going away [m/s]
    spread: float  # standard deviation of the speed toward the robot [m/s]
    rise: float  # how far the head rises and falls in STRETCH, the usual [m]


#: A usual pace is 1.1 to 1.4 m/s (Bohannon 1997), slower at the ends of a short way; heads rise
#: with the square of the step (an inverted pendulum). Shares and spreads are ours.
GAITS = (
    Gait(0.55, 0.0, 0.12, 0.005),  # stands
    Gait(0.05, 0.5, 0.25, 0.014),  # sets off, comes to a stand
    Gait(0.34, 1.3, 0.25, 0.028),  # walks up
    Gait(0.05, -1.3, 0.25, 0.028),  # walks away
    Gait(0.01, 0.0, 0.8, 0.005),  # rolls
)
#: The rise and fall of the last so many seconds counts: most of a step's.
STRETCH = 0.35
#: Fewer heights than this, or within less than this time [s], tell nothing.
FEWEST, SHORTEST = 4, 0.15
#: Spread of the rise around the usual one, as of its logarithm.
UNLIKE = 0.5
#: Heads also rise and fall as nobody's gait explains (nods, bows, wild frames): how often, and
#: how far, usually and as spread of the logarithm.
OTHERWISE, ANY_RISE, ANY_UNLIKE = 0.05, 0.03, 1.0
#: Heads that keep their height to this in a second are nobody's: the height is made up [m].
MADE_UP = 1e-6
#: Nobody's head is so high [m].
HIGHEST = 100.0
#: No rise is known better than this [m].
RESOLUTION = 0.0015
#: A head's heights are assumed this noisy until there are three of them [m].
PRIOR_HEIGHT_NOISE = 0.005
#: Outer tenths are not looked at: wild frames, and what noise does in its tails.
_TENTH = 0.1
#: How far apart the outer tenths of normal noise of size 1 lie.
_NOISE_RISE = 2.563
#: The lower quartile of the absolute value of a standard normal variable. The quartile, not the
#: median: a single wild value spoils the comparison with its two neighbours as well.
QUARTILE = 0.3186
#: Stamps are rounded to milliseconds or finer in files [s].
ROUNDED = 1e-3

_SHARE, _SPEED, _SPREAD, _RISE = np.array(GAITS).T


def likely_speed(
    slope: ArrayLike,
    error: ArrayLike,
    aside: ArrayLike,
    t: FloatArray,
    heights: FloatArray,
    end: ArrayLike,
) -> FloatArray:
    """The mean of a person's speed toward the robot, given positions and what the head does.

    Args:
        slope: of the way to the robot, shape (...), positive when coming closer [m/s].
        error: its standard error, (...) [m/s].
        aside: how fast the person goes past the robot instead, (...) [m/s].
        t: stamps of the latest second, (..., M); NaN where there are fewer [s].
        heights: of the head at those instants, (..., M), NaN where unknown [m].
        end: the instant the speed is of, (...) [s].

    Returns:
        Shape (...), positive when coming closer [m/s]; NaN where heights tell nothing.
    """
    heights = np.where(np.abs(heights) < HIGHEST, heights, np.nan)
    rise, noise = _rise(t, heights, np.asarray(end)), _noise(t, heights)
    variance = _SPREAD**2 + np.square(error)[..., None]
    # What of a gait's speed is not spent on going past.
    left = np.sqrt(np.maximum(_SPEED**2 - np.square(aside)[..., None], 0.0))
    toward = np.copysign(left, _SPEED)
    residual = np.asarray(slope)[..., None] - toward
    log = np.log(_SHARE) - 0.5 * (residual**2 / variance + np.log(variance))
    log += np.log(_likelihoods(rise, noise))
    weight = np.exp(log - log.max(axis=-1, keepdims=True))
    means = toward + residual * _SPREAD**2 / variance
    return np.asarray((weight * means).sum(axis=-1) / weight.sum(axis=-1))


def _likelihoods(rise: FloatArray, noise: FloatArray) -> FloatArray:
    """How likely each gait lets a head rise so far, up to a common factor, (..., 5)."""
    seen = np.hypot(rise, RESOLUTION)[..., None]
    noisy = _NOISE_RISE * noise[..., None]
    usual = _log_normal(seen, np.hypot(_RISE, noisy), UNLIKE)
    other = _log_normal(seen, np.hypot(ANY_RISE, noisy), ANY_UNLIKE)
    return (1 - OTHERWISE) * usual + OTHERWISE * other


def _log_normal(x: FloatArray, middle: FloatArray, spread: float) -> FloatArray:
    return np.asarray(np.exp(-0.5 * (np.log(x / middle) / spread) ** 2) / spread)


def _rise(t: FloatArray, heights: FloatArray, end: FloatArray) -> FloatArray:
    """How far apart the outer tenths of the heights in STRETCH lie, (...); NaN where unknown."""
    since = (end - STRETCH - ROUNDED)[..., None]
    recent = (t > since) & np.isfinite(heights)
    ordered = np.sort(np.where(recent, heights, np.nan), axis=-1)  # NaN comes last
    known = np.count_nonzero(recent, axis=-1)
    stamps = np.where(recent, t, np.nan)
    enough = known >= FEWEST
    last = np.where(enough, known - 1, 0)
    with np.errstate(invalid="ignore"):
        span = np.fmax.reduce(stamps, axis=-1) - np.fmin.reduce(stamps, axis=-1)
        moved = np.fmax.reduce(heights, axis=-1) - np.fmin.reduce(heights, axis=-1)
        rise = _at(ordered, (1 - _TENTH) * last) - _at(ordered, _TENTH * last)
    return np.where(enough & (span >= SHORTEST) & (moved > MADE_UP), rise, np.nan)


def _at(ordered: FloatArray, place: FloatArray) -> FloatArray:
    """What lies at a place between two of the values along the last axis, (...)."""
    below = np.floor(place).astype(int)
    above = np.minimum(below + 1, ordered.shape[-1] - 1)
    low, high = (np.take_along_axis(ordered, i[..., None], -1)[..., 0] for i in (below, above))
    share = place - below
    return np.where(share > 0, low + share * (high - low), low)


def _noise(t: FloatArray, heights: FloatArray) -> FloatArray:
    """The standard deviation of heights around a smooth path, (...) [m].

    From how far each lies off the line between its neighbours (Gasser, Sroka & Jennen-Steinmetz
    1986): their lower quartile, so that single wild frames do no harm.
    """
    if heights.shape[-1] < 3:
        return np.full(heights.shape[:-1], PRIOR_HEIGHT_NOISE)
    with np.errstate(invalid="ignore"):
        share = (t[..., 1:-1] - t[..., :-2]) / (t[..., 2:] - t[..., :-2])
        between = (1 - share) * heights[..., :-2] + share * heights[..., 2:]
        off = np.abs(heights[..., 1:-1] - between)
        off = np.sort(off / np.sqrt(1 + share**2 + (1 - share) ** 2), axis=-1)
    known = np.count_nonzero(np.isfinite(off), axis=-1)
    place = np.maximum(known - 1, 0) // 4
    quartile = np.take_along_axis(off, np.asarray(place)[..., None], -1)[..., 0]
    return np.where(known > 0, quartile / QUARTILE, PRIOR_HEIGHT_NOISE)

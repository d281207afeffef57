"""How fast a person closes in, from noisy positions (thesis 3.3.2).

The thesis divides the way between two observations by the time between them (3.2-3.3). With a
camera's noise of a few per cent that is worth little at eight metres, and it lags behind by an
interval. Here the same speed is read off a line laid robustly through the latest positions: the
fewer positions, the quicker it follows; so each time the shortest stretch is taken over which the
noise, estimated from the positions themselves, leaves the slope sure enough (adaptive windowing,
after Janabi-Sharifi, Hayward & Chen 2000). A slope that is still unsure is unknown.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kendon.features.proxemics import closing_speed
from kendon.person import FloatArray, IntArray

#: The stretches a line may be laid through [s], the quickest first.
WINDOWS: FloatArray = np.array([0.2, 0.3, 0.4, 0.6])
#: A slope whose standard error is below this is sure enough: a quarter of a walker's speed [m/s].
SURE = 0.3
#: One whose standard error is above this says nothing: nearly a walker's speed [m/s].
UNSURE = 1.0
#: So far back the noise is estimated from [s].
NOISE_SPAN = 1.0
#: The noise that is assumed while there are too few positions to estimate it: a head sways [m].
_PRIOR_NOISE = 0.02
#: The lower quartile of the absolute value of a standard normal variable. The quartile, not the
#: median: a single wild position spoils the comparison with its two neighbours as well.
_QUARTILE = 0.3186
#: Standard error of repeated medians over that of least squares, for normal noise.
_INEFFICIENCY = 1.25


class Positions(NamedTuple):
    """Where a person and the robot were on the ground of the world, N instants."""

    t: FloatArray  # (N,) [s]
    person: FloatArray  # (N, 2) [m], known
    robot: FloatArray  # (N, 2) [m]


def approach_speed(
    positions: Positions, first: IntArray, stop: IntArray, ends: FloatArray, period: float
) -> FloatArray:
    """The person's speed toward where the robot was one period before, at K instants [m/s].

    Args:
        positions: of a person who may have been lost between runs of positions.
        first: the row at which the run of positions begins that each instant belongs to, (K,).
        stop: the row after the newest one at each instant, (K,).
        ends: the instants, (K,) [s].
        period: the interval between observations [s].

    Returns:
        Shape (K,), positive when coming closer; NaN where it is not sure enough.
    """
    speed = np.full(len(ends), np.nan)
    some = np.flatnonzero(stop - first >= 2)
    if not len(some):
        return speed
    first, stop, ends = first[some], stop[some], ends[some]
    t, person, robot = positions
    noise = _noise(positions, first, stop, ends)

    # Every window of every instant, (K, W); the best of them, (K,).
    begin = np.searchsorted(t, ends[:, None] - WINDOWS - 1e-3)
    begin = np.minimum(np.maximum(begin, first[:, None]), stop[:, None] - 1)
    count = stop[:, None] - begin
    span = t[stop - 1][:, None] - t[begin]
    usable = (count >= 2) & (span >= period / 2)
    with np.errstate(divide="ignore", invalid="ignore"):  # a span of zero is not usable
        error = _INEFFICIENCY * noise[:, None] * np.sqrt(12 / count) / span
    error[~usable] = np.inf
    sure = error <= SURE
    choice = np.where(sure.any(axis=1), sure.argmax(axis=1), error.argmin(axis=1))
    row = np.arange(len(ends))
    good = error[row, choice] <= UNSURE
    if not good.any():
        return speed
    row, choice = row[good], choice[good]
    ends, begin, count = ends[row], begin[row, choice], count[row, choice]

    # Siegel's repeated medians (1982): right as long as fewer than half of the positions are wild.
    rows, outside = _rows(begin, count)
    rows = np.minimum(rows, len(t) - 1)
    at, where = t[rows], person[rows]
    where[outside] = np.nan
    with np.errstate(invalid="ignore", divide="ignore"):  # a position and itself: 0 / 0
        slopes = (where[:, None] - where[:, :, None]) / (at[:, None] - at[:, :, None])[..., None]
    shape = slopes.shape
    inner = median(slopes.reshape(-1, *shape[2:])).reshape(shape[0], shape[1], shape[3])
    velocity = median(inner)
    now = median(where + velocity[:, None] * (ends[:, None] - at)[..., None])

    before = np.maximum(np.searchsorted(t, ends - period + 1e-3, side="right") - 1, begin)
    speed[some[row]] = closing_speed(
        now - velocity * period, now, robot[before], np.asarray(period)
    )
    return speed


def _noise(positions: Positions, first: IntArray, stop: IntArray, ends: FloatArray) -> FloatArray:
    """The standard deviation of the positions around a smooth path, (K,) [m].

    Each position is held against the straight line between its neighbours (Gasser, Sroka &
    Jennen-Steinmetz 1986), which a walk does not bend in a thirtieth of a second.
    """
    t, person, _ = positions
    off = np.full(len(t), np.nan)
    if len(t) > 2:
        share = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
        between = (1 - share) * person[:-2] + share * person[2:]
        scale = np.sqrt(1 + share**2 + (1 - share) ** 2)[:, 0]
        aside = person[1:-1] - between
        off[1:-1] = np.hypot(aside[:, 0], aside[:, 1]) / scale
    begin = np.maximum(np.searchsorted(t, ends - NOISE_SPAN - 1e-3), first + 1)
    rows, outside = _rows(begin, stop - 1 - begin)
    taken = off[np.minimum(rows, len(t) - 1)]
    taken[outside] = np.nan
    ordered = np.sort(taken, axis=1)
    known = (~np.isnan(ordered)).sum(axis=1)
    quartile = ordered[np.arange(len(ends)), np.maximum(known - 1, 0) // 4]
    return np.where(known > 0, quartile / _QUARTILE, _PRIOR_NOISE)


def median(values: FloatArray) -> FloatArray:
    """The median along axis 1 of what is not NaN, NaN where nothing is.

    Args:
        values: shape (K, M, F) with M at least 1.

    Returns:
        Shape (K, F).
    """
    ordered = np.sort(values, axis=1)  # NaN comes last
    count = (ordered == ordered).sum(axis=1)
    k, f = np.ogrid[: ordered.shape[0], : ordered.shape[2]]
    low = ordered[k, np.maximum(count - 1, 0) // 2, f]
    # With one value or more, index count // 2 is inside; with none, everything is NaN anyway.
    high = ordered[k, count // 2, f]
    return np.asarray((low + high) / 2)


def _rows(begin: IntArray, count: IntArray) -> tuple[IntArray, np.ndarray]:
    """The rows begin, begin + 1, ... of each of K stretches, and which are past their end."""
    steps = np.arange(max(1, int(count.max())))
    return begin[:, None] + steps, steps >= count[:, None]

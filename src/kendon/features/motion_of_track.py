"""The speed of `kendon.features.motion` at many instants of a recording at once, with arrays.

A whole track this way takes a third of the time that it takes a `Walk`, which counts where
hundreds of greetings are learned from. The two are held to the same numbers by
``tests/features/test_sampler.py``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kendon.features.motion import (
    INEFFICIENCY,
    NOISE_SPAN,
    PRIOR_NOISE,
    QUARTILE,
    ROUNDED,
    SURE,
    UNSURE,
    WINDOWS,
)
from kendon.person import FloatArray, IntArray


class Positions(NamedTuple):
    """Where a person and the robot were on the ground of the world, N instants."""

    t: FloatArray  # (N,) [s]
    person: FloatArray  # (N, 2) [m], known
    robot: FloatArray  # (N, 2) [m]


def approach_speeds(
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
    begin = np.searchsorted(t, ends[:, None] - np.array(WINDOWS) - ROUNDED)
    begin = np.minimum(np.maximum(begin, first[:, None]), stop[:, None] - 1)
    count = stop[:, None] - begin
    span = t[stop - 1][:, None] - t[begin]
    usable = (count >= 2) & (span >= period / 2)
    with np.errstate(divide="ignore", invalid="ignore"):  # a span of zero is not usable
        error = INEFFICIENCY * noise[:, None] * np.sqrt(12 / count) / span
    error[~usable] = np.inf
    sure = error <= SURE
    choice = np.where(sure.any(axis=1), sure.argmax(axis=1), error.argmin(axis=1))
    row = np.arange(len(ends))
    good = error[row, choice] <= UNSURE
    if not good.any():
        return speed
    row, choice = row[good], choice[good]
    ends, begin, count = ends[row], begin[row, choice], count[row, choice]

    # Repeated medians.
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

    before = np.maximum(np.searchsorted(t, ends - period + ROUNDED, side="right") - 1, begin)
    was, is_now = now - velocity * period - robot[before], now - robot[before]
    speed[some[row]] = (_length(was) - _length(is_now)) / period
    return speed


def _noise(positions: Positions, first: IntArray, stop: IntArray, ends: FloatArray) -> FloatArray:
    """The standard deviation of the positions around a smooth path, (K,) [m]."""
    t, person, _ = positions
    off = np.full(len(t), np.nan)
    if len(t) > 2:
        share = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
        between = (1 - share) * person[:-2] + share * person[2:]
        scale = np.sqrt(1 + share**2 + (1 - share) ** 2)[:, 0]
        aside = person[1:-1] - between
        off[1:-1] = _length(aside) / scale
    begin = np.maximum(np.searchsorted(t, ends - NOISE_SPAN - ROUNDED), first + 1)
    rows, outside = _rows(begin, stop - 1 - begin)
    taken = off[np.minimum(rows, len(t) - 1)]
    taken[outside] = np.nan
    ordered = np.sort(taken, axis=1)
    known = (~np.isnan(ordered)).sum(axis=1)
    quartile = ordered[np.arange(len(ends)), np.maximum(known - 1, 0) // 4]
    return np.where(known > 0, quartile / QUARTILE, PRIOR_NOISE)


def median(values: FloatArray) -> FloatArray:
    """The median along axis 1 of what is not NaN, NaN where nothing is.

    Args:
        values: shape (K, M, F) with M at least 1.

    Returns:
        Shape (K, F).
    """
    ordered = np.sort(values, axis=1)  # NaN comes last
    count = (ordered == ordered).sum(axis=1)
    k, f = np.arange(ordered.shape[0])[:, None], np.arange(ordered.shape[2])
    low = ordered[k, np.maximum(count - 1, 0) // 2, f]
    # With one value or more, index count // 2 is inside; with none, everything is NaN anyway.
    high = ordered[k, count // 2, f]
    return np.asarray((low + high) / 2)


def _length(way: FloatArray) -> FloatArray:
    """The length of vectors (..., 2); `np.hypot` would round differently from a `Walk`."""
    return np.sqrt(way[..., 0] * way[..., 0] + way[..., 1] * way[..., 1])


def _rows(begin: IntArray, count: IntArray) -> tuple[IntArray, np.ndarray]:
    """The rows begin, begin + 1, ... of each of K stretches, and which are past their end."""
    steps = np.arange(max(1, int(count.max())))
    return begin[:, None] + steps, steps >= count[:, None]

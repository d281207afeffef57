"""The speed of `kendon.features.motion` at many instants of recordings at once, with arrays.

Whole tracks this way take a small part of the time that they take a `Walk`, which counts where
thousands of greetings are learned from. The two are held to the same numbers by
``tests/features/test_sampler.py``.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from kendon.features.gait import QUARTILE, ROUNDED, likely_speed
from kendon.features.motion import (
    BRIDGED,
    CERTAIN,
    FASTEST,
    HOPELESS,
    INEFFICIENCY,
    NOISE_SPAN,
    PRIOR_NOISE,
    SURE,
    UNSURE,
    WINDOWS,
)
from kendon.person import FloatArray, IntArray

#: So many slopes at a time, between positions in pairs, stay in a core's cache.
_CACHED = 1 << 14


class Stamps(NamedTuple):
    """When the frames of tracks were taken, one track after the other."""

    track: IntArray  # (N,), which track a frame is of, never falling
    t: FloatArray  # (N,) [s], growing within each track

    def search(
        self, track: IntArray, t: FloatArray, side: Literal["left", "right"] = "left"
    ) -> IntArray:
        """`np.searchsorted` within tracks.

        Args:
            track: in which one, of a shape that fits `t`.
            t: times, of any shape [s].
            side: as of `np.searchsorted`.

        Returns:
            Places among the N, in the shape of `t`.
        """
        # numpy sorts complex numbers by their real parts, and equal ones by their imaginary parts.
        stamps, sought = np.empty(len(self.t), complex), np.empty(t.shape, complex)
        stamps.real, stamps.imag = self
        sought.real, sought.imag = track, t
        return np.searchsorted(stamps, sought, side)


class Positions(NamedTuple):
    """Where people and their robots were on the ground of the world, N instants."""

    stamps: Stamps
    person: FloatArray  # (N, 2) [m], known
    heights: FloatArray  # (N,) [m], of the heads
    robot: FloatArray  # (N, 2) [m]


def approach_speeds(
    positions: Positions, lost: IntArray, stop: IntArray, ends: FloatArray, period: float
) -> FloatArray:
    """People's speeds toward where their robots were one period before, at K instants [m/s].

    Args:
        positions: of people who may have been lost between them.
        lost: the newest row at each instant before which the person was lost for an interval or
            more, (K,); 0 if never.
        stop: the row after the newest one at each instant, (K,); at least one of them is the
            instant's own track's.
        ends: the instants, (K,) [s].
        period: the interval between observations [s].

    Returns:
        Shape (K,), positive when coming closer; NaN where it is not sure enough.
    """
    first, away = _runs(positions, lost)
    first = first[stop - 1]
    speed = np.full(len(ends), np.nan)
    some = np.flatnonzero(stop - first >= 2)
    if not len(some):
        return speed
    first, stop, ends = first[some], stop[some], ends[some]
    stamps, t = positions.stamps, positions.stamps.t
    track = stamps.track[stop - 1]
    noise = _noise(positions, first, stop, ends)

    # Every window of every instant, (K, W); the best of them, (K,).
    seen = Stamps(stamps.track, t - away)
    now = ends - away[stop - 1]
    begin = seen.search(track[:, None], now[:, None] - np.array(WINDOWS) - ROUNDED)
    oldest = ends[:, None] - BRIDGED - np.array(WINDOWS) - ROUNDED
    begin = np.maximum(begin, stamps.search(track[:, None], oldest))
    begin = np.minimum(np.maximum(begin, first[:, None]), stop[:, None] - 1)
    count = stop[:, None] - begin
    span = t[stop - 1][:, None] - t[begin]
    usable = (count >= 2) & (span >= period / 2)
    with np.errstate(divide="ignore", invalid="ignore"):  # a span of zero is not usable
        errors = INEFFICIENCY * noise[:, None] * np.sqrt(12 / count) / span
    errors[~usable] = np.inf
    sure = errors <= SURE
    choice = np.where(sure.any(axis=1), sure.argmax(axis=1), errors.argmin(axis=1))
    error = errors[np.arange(len(ends)), choice]
    row = np.flatnonzero(error <= HOPELESS)
    begin, count = begin[row, choice[row]], count[row, choice[row]]

    aside = np.full(len(ends), np.nan)
    # Stretches of equally many positions at once: no holes, and no more than a cache holds.
    for number in np.unique(count).tolist():
        equal = np.flatnonzero(count == number)
        for part in np.array_split(equal, len(equal) * number * number // _CACHED + 1):
            speed[some[row[part]]], aside[row[part]] = _speeds_of_lines(
                positions, begin[part], number, ends[row[part]], period
            )
    row = row[error[row] > CERTAIN]
    if len(row):
        latest, heights = _latest(positions, first[row], stop[row], ends[row])
        slope = speed[some[row]]
        likely = likely_speed(slope, error[row], aside[row], latest, heights, ends[row])
        alone = np.where(error[row] <= UNSURE, slope, np.nan)
        speed[some[row]] = np.where(np.isnan(likely), alone, likely)
    return speed


def _runs(positions: Positions, lost: IntArray) -> tuple[IntArray, FloatArray]:
    """Where the run of each row begins, and how long until then people were out of sight in it.

    A run begins with a track, and where somebody comes back too late or too far away to have been
    out of sight only.

    Returns:
        Both (N,), rows and [s].
    """
    track, t = positions.stamps
    back = np.unique(lost[(lost > 0) & (lost < len(t))])
    back = back[track[back] == track[back - 1]]
    gaps = t[back] - t[back - 1]
    way = _length((positions.person[back] - positions.person[back - 1]).T)
    bridged = (gaps <= BRIDGED) & (way <= FASTEST * gaps)

    begins = np.zeros(len(t), dtype=int)
    for rows in (back[~bridged], np.flatnonzero(np.diff(track)) + 1):
        begins[rows] = rows
    begins = np.maximum.accumulate(begins)
    # Summed up one by one as a `Walk` does it: sums over all tracks would round differently.
    away, total, run = np.zeros(len(t)), 0.0, -1
    for row, gap in zip(back[bridged].tolist(), gaps[bridged].tolist(), strict=True):
        total = total + gap if begins[row] == run else gap
        run = begins[row]
        away[row] = total
    newest = np.maximum.accumulate(np.where(away > 0, np.arange(len(t)), begins))
    return begins, away[newest]


def _speeds_of_lines(
    positions: Positions, begin: IntArray, number: int, ends: FloatArray, period: float
) -> tuple[FloatArray, FloatArray]:
    """Speeds by repeated medians through the `number` positions from each `begin` on.

    Returns:
        Toward where the robot was, (K,), and past it, (K,) [m/s].
    """
    rows = begin[:, None] + np.arange(number)
    at, where = positions.stamps.t[rows], positions.person.T[:, rows]  # (K, M) and (2, K, M)
    with np.errstate(invalid="ignore", divide="ignore"):  # a position and itself: 0 / 0
        slopes = (where[..., None, :] - where[..., None]) / (at[:, None] - at[:, :, None])
    velocity = _middle(_middle(slopes, number - 1), number)  # (2, K)
    now = _middle(where + velocity[..., None] * (ends[:, None] - at), number)

    track = positions.stamps.track[begin]
    before = positions.stamps.search(track, ends - period + ROUNDED, "right") - 1
    robot = positions.robot.T[:, np.maximum(before, begin)]
    speed = (_length(now - velocity * period - robot) - _length(now - robot)) / period
    past = np.square(velocity).sum(axis=0) - speed * speed
    return speed, np.sqrt(np.maximum(past, 0.0))


def _noise(positions: Positions, first: IntArray, stop: IntArray, ends: FloatArray) -> FloatArray:
    """The standard deviation of the positions around a smooth path, (K,) [m]."""
    stamps, t, person = positions.stamps, positions.stamps.t, positions.person.T
    off = np.full(len(t), np.nan)
    if len(t) > 2:
        # Across the border of two tracks this is nonsense, and never taken.
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
            between = (1 - share) * person[:, :-2] + share * person[:, 2:]
            scale = np.sqrt(1 + share**2 + (1 - share) ** 2)
            off[1:-1] = _length(person[:, 1:-1] - between) / scale
    begin = stamps.search(stamps.track[stop - 1], ends - NOISE_SPAN - ROUNDED)
    begin = np.maximum(begin, first + 1)
    taken = _taken(off, begin, stop - 1)
    taken.sort(axis=1)  # NaN comes last
    known = np.maximum(stop - 1 - begin, 0)
    quartile = taken[np.arange(len(ends)), np.maximum(known - 1, 0) // 4]
    return np.where(known > 0, quartile / QUARTILE, PRIOR_NOISE)


def median(values: FloatArray) -> FloatArray:
    """The median along the last axis of what is not NaN, NaN where nothing is.

    Args:
        values: shape (..., M) with M at least 1.

    Returns:
        Shape (...).
    """
    ordered = np.sort(values.reshape(-1, values.shape[-1]), axis=1)  # NaN comes last
    count = np.count_nonzero(ordered == ordered, axis=1)
    row = np.arange(len(ordered))
    low = ordered[row, np.maximum(count - 1, 0) // 2]
    # With one value or more, index count // 2 is inside; with none, everything is NaN anyway.
    high = ordered[row, count // 2]
    return np.asarray((low + high) / 2).reshape(values.shape[:-1])


def _middle(values: FloatArray, known: int) -> FloatArray:
    """The median along the last axis where so many are known, the others NaN."""
    ordered = np.sort(values, axis=-1)
    return np.asarray((ordered[..., (known - 1) // 2] + ordered[..., known // 2]) / 2)


def _length(way: FloatArray) -> FloatArray:
    """The length of vectors (2, ...); `np.hypot` would round differently from a `Walk`."""
    return np.asarray(np.sqrt(way[0] * way[0] + way[1] * way[1]))


def _latest(
    positions: Positions, first: IntArray, stop: IntArray, ends: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Stamps [s] and heights [m] in the NOISE_SPAN before K instants, (K, M), filled with NaN."""
    stamps = positions.stamps
    begin = stamps.search(stamps.track[stop - 1], ends - NOISE_SPAN - ROUNDED)
    begin = np.maximum(begin, first)
    return _taken(stamps.t, begin, stop), _taken(positions.heights, begin, stop)


def _taken(values: FloatArray, begin: IntArray, stop: IntArray) -> FloatArray:
    """The values from each `begin` to before each `stop`, (K, M), filled with NaN."""
    rows = begin[:, None] + np.arange(max(1, int((stop - begin).max())))
    return np.where(rows < stop[:, None], values[np.minimum(rows, len(values) - 1)], np.nan)

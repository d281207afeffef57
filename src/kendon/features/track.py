"""The observations of a whole recording at once, with arrays: a `Sampler`'s numbers, sooner."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kendon.errors import ParameterError
from kendon.features.gaze import blend, eye_gaze, head_gaze
from kendon.features.gestures import GestureDetector, Question, feed
from kendon.features.motion_of_track import Positions, approach_speeds, median
from kendon.features.proxemics import distance, to_world
from kendon.features.sampler import (
    PERIOD,
    ROBOT_FACE,
    ROUNDING,
    SPACINGS,
    TOLERANCE,
    Sampler,
    checked_face,
    checked_period,
    still_counts,
)
from kendon.geometry import Vec3
from kendon.observations import Observations
from kendon.person import FloatArray, IntArray, Track
from kendon.tracks import MAX_GAP


def observe(
    track: Track, robot_face: Vec3 = ROBOT_FACE, period: float = PERIOD, *, name: str | None = None
) -> Observations:
    """The observations of a whole track; the same numbers as a `Sampler` gives frame by frame.

    The true phase of an observation is that of its interval's middle frame, the phase the person
    is in for most of the interval.

    Args:
        track: at least one interval long.
        robot_face: the robot's face in its base frame [m].
        period: the interval between observations [s].
        name: of the result; the track's own by default.

    Raises:
        ParameterError: the face is not finite, the period is not positive, or the track is
            shorter than one interval.
    """
    face, period = checked_face(robot_face), checked_period(period)
    name = track.name if name is None else name
    if (np.diff(track.t) > MAX_GAP).any():
        return _observed_frame_by_frame(track, face, period, name)
    ends = _ends(track, period)
    if not len(ends):
        raise ParameterError(
            f"{track.name or 'the track'} lasts {track.duration:.2f} s;"
            f" the first observation needs {period:g} s"
        )
    starts, stops = _rows_of_intervals(track.t, ends)
    medians = _medians(track, starts, stops, face)
    speeds = _speeds(track, starts, stops, ends, period)
    gestures = _gestures(track, starts, stops, ends, medians)
    values = np.column_stack([medians[:, 0], speeds, medians[:, 1:3], gestures])
    phases = None if track.phases is None else _phases(track.phases, starts, stops)
    return Observations(ends, values, phases, name)


def watch(
    track: Track, detector: GestureDetector, period: float = PERIOD
) -> Iterator[tuple[Question, float]]:
    """Let a gesture detector see a whole track up to the end of one interval after another.

    For tracks without a leap of the clock.

    Yields:
        What it is to be asked then, and the stamp of the interval's middle frame [s]; nothing for
        intervals without frames.
    """
    ends = _ends(track, checked_period(period))
    starts, stops = _rows_of_intervals(track.t, ends)
    ways = _taken(distance(track.head)[:, None], starts, stops)[:, 0]
    middles = track.t[np.minimum((starts + stops) // 2, len(track) - 1)]
    asked = feed(track, detector, starts, stops, ends, ways)
    for question, middle in zip(asked, middles.tolist(), strict=True):
        if question:
            yield question, middle


def _ends(track: Track, period: float) -> FloatArray:
    """Where a track's intervals end [s]."""
    # Multiplied, not summed up, as the sampler does it: both see the same floating-point ends.
    ends = track.t[:1] + np.arange(1, math.floor(track.duration / period) + 2) * period
    return ends[ends <= track.t[-1:] + TOLERANCE + ROUNDING]


def _observed_frame_by_frame(track: Track, face: Vec3, period: float, name: str) -> Observations:
    """For a track with a leap of the clock, at which a sampler begins anew."""
    sampler = Sampler(face, period)
    rows = [seen for frame in track for seen in sampler.push(frame)]
    rows += sampler.advance(float(track.t[-1]) + TOLERANCE)
    seen = Observations.from_rows(rows, name)
    if track.phases is None:
        return seen
    stops = np.searchsorted(track.t, seen.t + TOLERANCE, side="right")
    starts = np.concatenate([[0], stops[:-1]])
    return Observations(seen.t, seen.values, _phases(track.phases, starts, stops), name)


def _rows_of_intervals(t: FloatArray, ends: FloatArray) -> tuple[IntArray, IntArray]:
    """The first row of each interval and the row after its last one."""
    stops = np.searchsorted(t, ends + TOLERANCE, side="right")
    starts = np.concatenate([[0], stops[:-1]])
    for k in np.flatnonzero(starts == stops).tolist():
        newest = t[max(0, stops[k] - SPACINGS - 1) : stops[k]]
        if still_counts(newest.tolist(), float(ends[k])):
            starts[k] -= 1
    return starts, stops


def _medians(track: Track, starts: IntArray, stops: IntArray, face: Vec3) -> FloatArray:
    """Distance, gaze, smile and given gestures of K intervals, shape (K, 6)."""
    way = distance(track.head)
    look = head_gaze(track.head, track.head_rotation, face)
    if np.isfinite(track.eyes).any():
        eyes = eye_gaze(track.eyes, track.eye_gaze, face)
        rows_of_gaze = zip(eyes.tolist(), look.tolist(), way.tolist(), strict=True)
        look = np.array([blend(*row) for row in rows_of_gaze])
    return _taken(np.column_stack([way, look, track.smile, track.gestures]), starts, stops)


def _taken(values: FloatArray, starts: IntArray, stops: IntArray) -> FloatArray:
    """Medians of N columns of T frames over K intervals, shape (K, N)."""
    rows = starts[:, None] + np.arange(max(1, int((stops - starts).max())))
    taken = values[np.minimum(rows, len(values) - 1)]
    taken[rows >= stops[:, None]] = np.nan
    return median(taken)


def _gestures(
    track: Track, starts: IntArray, stops: IntArray, ends: FloatArray, medians: FloatArray
) -> FloatArray:
    """The gestures of K intervals, shape (K, 3): detected where they are not given by hand."""
    given = medians[:, 3:]
    if not (track.joints or np.isfinite(track.head_rotation).any()):
        return given  # nothing to detect them from
    detector = GestureDetector()
    asked = feed(track, detector, starts, stops, ends, medians[:, 0])
    return np.array(
        [
            detector.complete(values, *question) if question else values
            for values, question in zip(given.tolist(), asked, strict=True)
        ]
    )


def _speeds(
    track: Track, starts: IntArray, stops: IntArray, ends: FloatArray, period: float
) -> FloatArray:
    """The person's speed at the ends of K intervals, shape (K,)."""
    places = to_world(track.head, track.robot)
    known = np.flatnonzero(np.isfinite(places).all(axis=1))
    first, stop = np.searchsorted(known, starts), np.searchsorted(known, stops)
    # A run of positions begins where the person is first seen again after a blind interval.
    blind = first == stop
    runs = np.concatenate([[0], np.maximum.accumulate(np.where(blind, stop, 0))[:-1]])
    positions = Positions(track.t[known], places[known], track.robot[known, :2])
    speeds = approach_speeds(positions, runs, stop, ends, period)
    speeds[blind] = np.nan
    return speeds


def _phases(phases: IntArray, starts: IntArray, stops: IntArray) -> IntArray:
    middle = (starts + stops) // 2
    return np.where(stops > starts, phases[np.minimum(middle, len(phases) - 1)], -1)

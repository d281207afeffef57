"""The observations of whole recordings at once, with arrays: a `Sampler`'s numbers, sooner."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from kendon.errors import ParameterError
from kendon.features.gaze_of_track import blended, eye_gaze, head_gaze
from kendon.features.gestures import GestureDetector, Question, feed
from kendon.features.motion_of_track import Positions, Stamps, approach_speeds, median
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
    [seen] = observe_all([track], robot_face, period)
    return seen if name is None else replace(seen, name=name)


def observe_all(
    tracks: Sequence[Track], robot_face: Vec3 = ROBOT_FACE, period: float = PERIOD
) -> list[Observations]:
    """What `observe` gives for each track, sooner.

    All frames go through the same arrays: a hundred greetings take a third of the time that they
    take one by one, and some megabytes. More at once gain nothing.

    Args:
        tracks: each at least one interval long.
        robot_face: the robot's face in its base frame [m].
        period: the interval between observations [s].

    Raises:
        ParameterError: as `observe` does.
    """
    face, period = checked_face(robot_face), checked_period(period)
    leaps = [bool((np.diff(track.t) > MAX_GAP).any()) for track in tracks]
    whole = [track for track, leap in zip(tracks, leaps, strict=True) if not leap]
    together = iter(_observed_together(whole, face, period) if whole else ())
    return [
        _observed_frame_by_frame(track, face, period) if leap else next(together)
        for track, leap in zip(tracks, leaps, strict=True)
    ]


def _observed_frame_by_frame(track: Track, face: Vec3, period: float) -> Observations:
    """For a track with a leap of the clock, at which a sampler begins anew."""
    sampler = Sampler(face, period)
    rows = [seen for frame in track for seen in sampler.push(frame)]
    rows += sampler.advance(float(track.t[-1]) + TOLERANCE)
    seen = Observations.from_rows(rows, track.name)
    if track.phases is None:
        return seen
    stops = np.searchsorted(track.t, seen.t + TOLERANCE, side="right")
    starts = np.concatenate([[0], stops[:-1]])
    return replace(seen, phases=_phases(track.phases, starts, stops))


def _observed_together(tracks: Sequence[Track], face: Vec3, period: float) -> list[Observations]:
    """For tracks without leaps: their frames one after the other, and so their intervals."""
    each = [_ends_of_intervals(track, period) for track in tracks]
    stamps, intervals = _joined([track.t for track in tracks]), _joined(each)
    starts, stops = _rows_of_intervals(stamps, intervals)
    medians = _medians(tracks, starts, stops, face)
    speeds = _speeds(tracks, stamps, intervals, starts, stops, period)
    gestures = _gestures(tracks, each, starts, stops, medians)
    values = np.stack([medians[0], speeds, *medians[1:3], *gestures], axis=1)
    unlabelled = [np.full(len(t.t), -1) if t.phases is None else t.phases for t in tracks]
    phases = _phases(np.concatenate(unlabelled), starts, stops)
    borders = np.cumsum([0, *map(len, each)]).tolist()
    return [
        Observations(ends, values[a:b], None if track.phases is None else phases[a:b], track.name)
        for track, ends, a, b in zip(tracks, each, borders[:-1], borders[1:], strict=True)
    ]


def _ends_of_intervals(track: Track, period: float) -> FloatArray:
    # Multiplied, not summed up, as the sampler does it: both see the same floating-point ends.
    ends = track.t[:1] + np.arange(1, math.floor(track.duration / period) + 2) * period
    # Written as the sampler does it, too: in seconds since 1970 the rounding is lost.
    ends = ends[ends - ROUNDING < track.t[-1:] + TOLERANCE]
    if not len(ends):
        raise ParameterError(
            f"{track.name or 'the track'} lasts {track.duration:.2f} s;"
            f" the first observation needs {period:g} s"
        )
    return ends


def _joined(times: Sequence[FloatArray]) -> Stamps:
    """Times of one track after the other [s]."""
    return Stamps(np.repeat(np.arange(len(times)), [len(t) for t in times]), np.concatenate(times))


def watch(
    track: Track, detector: GestureDetector, period: float = PERIOD
) -> Iterator[tuple[Question, float]]:
    """Let a gesture detector see a whole track up to the end of one interval after another.

    For tracks without a leap of the clock.

    Yields:
        What it is to be asked then, and the stamp of the interval's middle frame [s]; nothing for
        intervals without frames.
    """
    ends = _ends_of_intervals(track, checked_period(period))
    starts, stops = _rows_of_intervals(_joined([track.t]), _joined([ends]))
    [ways] = _taken(distance(track.head)[None], starts, stops)
    middles = track.t[np.minimum((starts + stops) // 2, len(track) - 1)]
    asked = feed(track, detector, starts, stops, ends, ways)
    for question, middle in zip(asked, middles.tolist(), strict=True):
        if question:
            yield question, middle


def _rows_of_intervals(stamps: Stamps, intervals: Stamps) -> tuple[IntArray, IntArray]:
    """The first row of each interval and the row after its last one."""
    stops = stamps.search(intervals.track, intervals.t + TOLERANCE, "right")
    begins = np.searchsorted(stamps.track, intervals.track)  # the first row of the track
    # The intervals before a track's first one are other tracks', and end before it begins.
    starts = np.maximum(np.concatenate([[0], stops[:-1]]), begins)
    for k in np.flatnonzero(starts == stops).tolist():
        newest = stamps.t[max(begins[k], stops[k] - SPACINGS - 1) : stops[k]]
        if still_counts(newest.tolist(), float(intervals.t[k])):
            starts[k] -= 1
    return starts, stops


def _medians(tracks: Sequence[Track], starts: IntArray, stops: IntArray, face: Vec3) -> FloatArray:
    """Distance, gaze, smile and gestures of K intervals, shape (6, K)."""
    head = np.concatenate([track.head for track in tracks])
    way = distance(head)
    look = head_gaze(head, np.concatenate([track.head_rotation for track in tracks]), face)
    eyes = np.concatenate([track.eyes for track in tracks])
    if np.isfinite(eyes).any():
        gaze = eye_gaze(eyes, np.concatenate([track.eye_gaze for track in tracks]), face)
        look = blended(gaze, look, way)
    smile = np.concatenate([track.smile for track in tracks])
    gestures = np.concatenate([track.gestures for track in tracks])
    return _taken(np.stack([way, look, smile, *gestures.T]), starts, stops)


def _taken(values: FloatArray, starts: IntArray, stops: IntArray) -> FloatArray:
    """Medians of N rows of T frames over K intervals, shape (N, K)."""
    rows = starts[:, None] + np.arange(max(1, int((stops - starts).max())))
    taken = values[:, np.minimum(rows, values.shape[1] - 1)]
    taken[:, rows >= stops[:, None]] = np.nan
    return median(taken)


def _gestures(
    tracks: Sequence[Track],
    ends: Sequence[FloatArray],
    starts: IntArray,
    stops: IntArray,
    medians: FloatArray,
) -> FloatArray:
    """The gestures of K intervals, shape (3, K): detected where they are not given by hand.

    Args:
        tracks: people.
        ends: where the intervals of each end [s].
        starts: (K,), the first frame of each interval, of all people's.
        stops: (K,), the frame after its last.
        medians: (6, K), distance, gaze, smile and the gestures given by hand.
    """
    gestures = medians[3:].copy()
    frame = interval = 0
    for track, its_ends in zip(tracks, ends, strict=True):
        its = slice(interval, interval + len(its_ends))
        seen = track.joints or np.isfinite(track.head_rotation).any()
        asked = np.asarray(np.isnan(gestures[:, its]).any(axis=0))
        if seen and asked.any():
            detector = GestureDetector()
            questions = feed(
                track, detector, starts[its] - frame, stops[its] - frame, its_ends,
                medians[0, its], asked,
            )  # fmt: skip
            for k, question in enumerate(questions, interval):
                if question:
                    gestures[:, k] = detector.complete(gestures[:, k].tolist(), *question)
        frame, interval = frame + len(track), its.stop
    return gestures


def _speeds(
    tracks: Sequence[Track],
    stamps: Stamps,
    intervals: Stamps,
    starts: IntArray,
    stops: IntArray,
    period: float,
) -> FloatArray:
    """People's speeds at the ends of K intervals, shape (K,)."""
    robot = np.concatenate([track.robot for track in tracks])
    head = np.concatenate([track.head for track in tracks])
    places = to_world(head, robot)
    known = np.flatnonzero(np.isfinite(places).all(axis=1))
    first, stop = np.searchsorted(known, starts), np.searchsorted(known, stops)
    blind = first == stop
    lost = np.concatenate([[0], np.maximum.accumulate(np.where(blind, stop, 0))[:-1]])
    there = Stamps(stamps.track[known], stamps.t[known])
    positions = Positions(there, places[known], head[known, 2], robot[known, :2])
    speeds = np.full(len(intervals.t), np.nan)
    seen = np.flatnonzero(~blind)
    if len(seen):
        speeds[seen] = approach_speeds(positions, lost[seen], stop[seen], intervals.t[seen], period)
    return speeds


def _phases(phases: IntArray, starts: IntArray, stops: IntArray) -> IntArray:
    middle = (starts + stops) // 2
    return np.where(stops > starts, phases[np.minimum(middle, len(phases) - 1)], -1)

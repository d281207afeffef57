"""Five observations a second from frames at any rate (thesis 3.3, 3.5.1).

Each observation covers one interval of 0.2 s and is stamped with its end. Distance, gaze, smile
and gestures are medians over the interval's frames, so that single bad frames do no harm; the
speed comes from a robust line through the latest frames (`kendon.features.motion`). An interval
without frames is unknown, never the last value again. The one exception is a source so slow
(about 5 frames a second) that jitter leaves intervals empty: there the newest frame still counts
while it is younger than one and a half frame periods.

A recording and a live source go through the same function (`_reduce`): all intervals of a
track at once, or the newest alone.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from kendon.errors import ParameterError
from kendon.features import gaze, proxemics
from kendon.features.motion import NOISE_SPAN, Positions, approach_speed, median
from kendon.geometry import UNKNOWN_POINT, Vec3
from kendon.observations import Observation, Observations
from kendon.person import FloatArray, IntArray, PersonFrame, Track

#: The interval between observations (thesis 3.3) [s].
PERIOD = 0.2
#: The robot's face in its base frame unless told otherwise [m].
ROBOT_FACE: Vec3 = (0.0, 0.0, 1.2)

#: Stamps are rounded to milliseconds or finer in files: a frame this little past an interval's
#: end still belongs to it [s].
_TOLERANCE = 1e-3
#: Sums of periods and of frame times round differently [s].
_ROUNDING = 1e-9
#: How many periods old the newest frame of a slow source may be.
_CARRY = 1.5
#: From so many spacings the frame period of a source is estimated.
_SPACINGS = 9


class Sampler:
    """Turns frames, as they come, into observations.

    Args:
        robot_face: the robot's face in its base frame [m].
        period: the interval between observations [s].

    Raises:
        ParameterError: the face is not finite, or the period is not positive.
    """

    def __init__(self, robot_face: Vec3 = ROBOT_FACE, period: float = PERIOD) -> None:
        self._face = _checked_face(robot_face)
        self.period = _checked_period(period)
        self._start = math.nan
        self._count = 0
        self._last = -math.inf  # [s], the newest frame's stamp
        self._recent: list[PersonFrame] = []  # the frames of the last second, up to the interval
        self._pending: list[PersonFrame] = []  # those of the interval being filled
        self._run = 0  # where in `_recent` the person was last lost and seen again

    @property
    def next_end(self) -> float:
        """When the interval being filled ends [s]; NaN before the first frame."""
        return self._start + (self._count + 1) * self.period

    def push(self, frame: PersonFrame) -> list[Observation]:
        """Take in a frame; return the observations whose intervals ended before it.

        Raises:
            ParameterError: the stamp is not finite, or not after the last frame's.
        """
        if not math.isfinite(frame.t):
            raise ParameterError(f"the stamp of a frame must be finite seconds, not {frame.t}")
        if frame.t <= self._last:
            raise ParameterError(f"frames must come in order: {frame.t} s after {self._last} s")
        if math.isnan(self._start):
            self._start = frame.t
        done = []
        while self.next_end + _TOLERANCE < frame.t:
            done.append(self._close())
        self._pending.append(frame)
        self._last = frame.t
        return done

    def advance(self, t: float) -> list[Observation]:
        """Let time pass without a frame; return the observations whose intervals have ended."""
        done = []
        while self.next_end <= t + _ROUNDING:  # never before the first frame: that is NaN
            done.append(self._close())
        return done

    def _close(self) -> Observation:
        end = self.next_end
        self._count += 1
        fresh = sum(1 for row in self._pending if row.t <= end + _TOLERANCE)
        stop = len(self._recent) + fresh
        self._recent += self._pending[:fresh]
        self._pending = self._pending[fresh:]
        start = stop - fresh
        if not fresh and _still_counts([row.t for row in self._recent[-_SPACINGS - 1 :]], end):
            start -= 1
        if start == stop:
            self._run = stop
            return Observation(end)
        frames = _Frames.of(self._recent)
        values = _reduce(
            frames, np.array([start]), np.array([stop]), np.array([self._run]), np.array([end]),
            self._face, self.period,
        )[0]  # fmt: skip
        if not np.isfinite(frames.head[start:stop, 0]).any():
            self._run = stop
        self._forget(end)
        return Observation(end, *values.tolist())

    def _forget(self, end: float) -> None:
        """Let go of frames that no later observation needs."""
        keep = bisect_left(self._recent, end - NOISE_SPAN, key=lambda frame: frame.t)
        # One more, as each position is held against its neighbours; some for their spacings.
        old = max(0, min(keep - 2, len(self._recent) - _SPACINGS - 1))
        del self._recent[:old]
        self._run = max(0, self._run - old)


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
    face, period = _checked_face(robot_face), _checked_period(period)
    # Multiplied, not summed up, as the sampler does it: both see the same floating-point ends.
    ends = track.t[:1] + np.arange(1, math.floor(track.duration / period) + 2) * period
    ends = ends[ends <= track.t[-1:] + _TOLERANCE + _ROUNDING]
    if not len(ends):
        raise ParameterError(
            f"{track.name or 'the track'} lasts {track.duration:.2f} s;"
            f" the first observation needs {period:g} s"
        )
    stops = np.searchsorted(track.t, ends + _TOLERANCE, side="right")
    starts = np.concatenate([[0], stops[:-1]])
    for k in np.flatnonzero(starts == stops).tolist():
        newest = track.t[max(0, stops[k] - _SPACINGS - 1) : stops[k]]
        if _still_counts(newest.tolist(), float(ends[k])):
            starts[k] -= 1
    frames = _Frames(
        track.t, track.head, track.head_rotation, track.smile, track.gestures, track.robot,
        *((track.eyes, track.eye_gaze) if np.isfinite(track.eyes).any() else ()),
    )  # fmt: skip
    values = _reduce(frames, starts, stops, _runs(frames, starts, stops), ends, face, period)
    phases = None if track.phases is None else _phases_of(track.phases, starts, stops)
    return Observations(ends, values, phases, track.name if name is None else name)


def _runs(frames: _Frames, starts: IntArray, stops: IntArray) -> IntArray:
    """For each interval the row at which the person was last lost and seen again."""
    seen = np.concatenate([[0], np.cumsum(np.isfinite(frames.head[:, 0]))])
    blind = seen[stops] == seen[starts]
    after = np.where(blind, stops, 0)
    return np.concatenate([[0], np.maximum.accumulate(after)[:-1]])


class _Frames(NamedTuple):
    """Frames as arrays: what observations are made of, without the rest of a track."""

    t: FloatArray  # (N,)
    head: FloatArray  # (N, 3)
    head_rotation: FloatArray  # (N, 4)
    smile: FloatArray  # (N,)
    gestures: FloatArray  # (N, 3)
    robot: FloatArray  # (N, 3)
    eyes: FloatArray | None = None  # (N, 2, 3)
    eye_gaze: FloatArray | None = None  # (N, 2, 3)

    @classmethod
    def of(cls, frames: Sequence[PersonFrame]) -> _Frames:
        rows = np.array(
            [
                (f.t, *f.head, *f.head_rotation, f.smile, f.dsal, f.csal, f.hdip, *f.robot)
                for f in frames
            ]
        )
        columns = rows[:, 0], rows[:, 1:4], rows[:, 4:8], rows[:, 8], rows[:, 9:12], rows[:, 12:]
        if not any(f.eyes for f in frames):
            return cls(*columns)
        nowhere = (UNKNOWN_POINT, UNKNOWN_POINT)
        return cls(
            *columns,
            np.array([f.eyes or nowhere for f in frames]),
            np.array([f.eye_gaze or nowhere for f in frames]),
        )


def _reduce(
    frames: _Frames,
    starts: IntArray,
    stops: IntArray,
    runs: IntArray,
    ends: FloatArray,
    face: FloatArray,
    period: float,
) -> FloatArray:
    """The seven features of K intervals, shape (K, 7).

    Args:
        frames: those of the intervals and, for the speed, those before.
        starts: the first row of each interval, (K,).
        stops: the row after its last, (K,).
        runs: the row since which the person has not been lost, (K,).
        ends: of the intervals, (K,) [s].
        face: the robot's face in its base frame, (3,) [m].
        period: the interval between observations [s].
    """
    way = proxemics.distance(frames.head)
    look = gaze.head_gaze(frames.head, frames.head_rotation, face)
    if frames.eyes is not None and frames.eye_gaze is not None:
        look = gaze.blend(gaze.eye_gaze(frames.eyes, frames.eye_gaze, face), look, way)
    rows = starts[:, None] + np.arange(max(1, int((stops - starts).max())))
    taken = np.column_stack([way, look, frames.smile, frames.gestures])[
        np.minimum(rows, len(frames.t) - 1)
    ]
    taken[rows >= stops[:, None]] = np.nan
    medians = median(taken)

    spots = proxemics.to_world(frames.head, frames.robot)
    known = np.flatnonzero(np.isfinite(spots[:, 0]))
    positions = Positions(frames.t[known], spots[known], frames.robot[known, :2])
    first, stop = np.searchsorted(known, runs), np.searchsorted(known, stops)
    speed = approach_speed(positions, first, stop, ends, period)
    speed[np.searchsorted(known, starts) == stop] = np.nan  # nobody seen in this interval
    return np.column_stack([medians[:, 0], speed, medians[:, 1:]])


def _still_counts(stamps: list[float], end: float) -> bool:
    """Whether a source is so slow that its newest frame still stands for an interval's end."""
    if len(stamps) < 2:
        return False
    spacings = sorted(b - a for a, b in pairwise(stamps))
    return end - stamps[-1] <= _CARRY * spacings[len(spacings) // 2]


def _phases_of(phases: IntArray, starts: IntArray, stops: IntArray) -> IntArray:
    middle = (starts + stops) // 2
    return np.where(stops > starts, phases[np.minimum(middle, len(phases) - 1)], -1)


def _checked_period(period: float) -> float:
    if not (math.isfinite(period) and period > 0):
        raise ParameterError(f"the sampling period must be positive seconds, not {period}")
    return period


def _checked_face(robot_face: Sequence[float]) -> FloatArray:
    face = np.array(robot_face, dtype=float)
    if face.shape != (3,) or not np.isfinite(face).all():
        raise ParameterError(f"the robot's face is a point x, y, z in metres, not {robot_face}")
    return face

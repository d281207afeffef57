"""Five observations a second from frames at any rate (thesis 3.3, 3.5.1).

Each observation covers one interval of 0.2 s and is stamped with its end. Distance, gaze and
smile are medians over the interval's frames, so that single bad frames do no harm; a gesture
probability is the newest one, as it is the state of a key or a detector that has smoothed
already. An interval without frames is unknown, never the last value again. The one exception
is a source so slow (about 5 frames a second) that jitter leaves intervals empty: there the
newest frame still counts while it is younger than one and a half frame periods.

A recording and a live source go through the same function (`_reduce`): all intervals of a
track at once, or the newest with its predecessor.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from kendon.errors import ParameterError
from kendon.features import gaze, proxemics
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
        self._stamps: deque[float] = deque(maxlen=_SPACINGS + 1)
        self._previous: list[PersonFrame] = []  # the frames of the interval before
        self._pending: list[PersonFrame] = []

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
        fresh = [f for f in self._pending if f.t <= end + _TOLERANCE]
        self._pending = self._pending[len(fresh) :]
        self._stamps.extend(f.t for f in fresh)
        before = len(self._previous)
        if fresh:
            frames, place = self._previous + fresh, (before, before + len(fresh))
        elif before and _still_counts(list(self._stamps), end):
            frames, place = self._previous, (before - 1, before)
        else:
            self._previous = []
            return Observation(end)
        places = np.array([(0, before), place])
        values = _reduce(_Frames.of(frames), places, self._face, self.period)[1]
        self._previous = frames[slice(*place)]
        return Observation(end, *values.tolist())


def observe(
    track: Track, robot_face: Vec3 = ROBOT_FACE, period: float = PERIOD, *, name: str | None = None
) -> Observations:
    """The observations of a whole track; the same numbers as a `Sampler` gives frame by frame.

    The true phase of an observation is that of its interval's newest frame, the phase the
    person is in at the observation's stamp.

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
    values = _reduce(frames, np.stack([starts, stops], axis=1), face, period)
    phases = None if track.phases is None else _phases_at(track.phases, starts, stops)
    return Observations(ends, values, phases, track.name if name is None else name)


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


def _reduce(frames: _Frames, places: IntArray, face: FloatArray, period: float) -> FloatArray:
    """The seven features of intervals that cover the rows start to stop, shape (K, 7).

    The speed of the first interval is unknown; that of another is taken against the one before.
    """
    starts, stops = places[:, 0], places[:, 1]
    rows = starts[:, None] + np.arange(max(1, int((stops - starts).max())))
    outside = rows >= stops[:, None]
    rows = np.minimum(rows, len(frames.t) - 1)

    def middle(values: FloatArray) -> FloatArray:
        """The median of the known values of each interval, shape (K, ...)."""
        taken = values[rows]
        taken[outside] = np.nan
        return _median(taken)

    way = proxemics.distance(frames.head)
    head = gaze.head_gaze(frames.head, frames.head_rotation, face)
    if frames.eyes is not None and frames.eye_gaze is not None:
        head = gaze.blend(gaze.eye_gaze(frames.eyes, frames.eye_gaze, face), head, way)
    spots = proxemics.to_world(frames.head, frames.robot)
    stamps = np.where(np.isnan(way), np.nan, frames.t)
    medians = middle(np.column_stack([way, head, frames.smile, stamps, spots]))

    newest = np.maximum(stops - 1, 0)
    robot = frames.robot[newest, :2]
    speed = np.full(len(places), np.nan)
    dt = np.diff(medians[:, 3])
    # Two instants this close together say nothing of a speed.
    dt[~(dt >= period / 2)] = np.nan
    speed[1:] = proxemics.closing_speed(medians[:-1, 4:], medians[1:, 4:], robot[:-1], dt)

    gestures = np.where((stops > starts)[:, None], frames.gestures[newest], np.nan)
    return np.column_stack([medians[:, 0], speed, medians[:, 1], medians[:, 2], gestures])


def _median(values: FloatArray) -> FloatArray:
    """The median along axis 1 of what is not NaN, NaN where nothing is."""
    ordered = np.sort(values, axis=1)  # NaN comes last
    count = (~np.isnan(ordered)).sum(axis=1, keepdims=True)
    low = np.take_along_axis(ordered, np.maximum(count - 1, 0) // 2, axis=1)
    # With one value or more, index count // 2 is inside; with none, everything is NaN anyway.
    high = np.take_along_axis(ordered, count // 2, axis=1)
    return np.asarray(((low + high) / 2)[:, 0])


def _still_counts(stamps: list[float], end: float) -> bool:
    """Whether a source is so slow that its newest frame still stands for an interval's end."""
    if len(stamps) < 2:
        return False
    spacings = sorted(b - a for a, b in pairwise(stamps))
    return end - stamps[-1] <= _CARRY * spacings[len(spacings) // 2]


def _phases_at(phases: IntArray, starts: IntArray, stops: IntArray) -> IntArray:
    return np.where(stops > starts, phases[np.maximum(stops - 1, 0)], -1)


def _checked_period(period: float) -> float:
    if not (math.isfinite(period) and period > 0):
        raise ParameterError(f"the sampling period must be positive seconds, not {period}")
    return period


def _checked_face(robot_face: Sequence[float]) -> FloatArray:
    face = np.array(robot_face, dtype=float)
    if face.shape != (3,) or not np.isfinite(face).all():
        raise ParameterError(f"the robot's face is a point x, y, z in metres, not {robot_face}")
    return face

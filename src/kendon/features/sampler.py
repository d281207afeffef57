"""Five observations a second from frames at any rate (thesis 3.3, 3.5.1).

Each observation covers one interval of 0.2 s and is stamped with its end. Distance, gaze, smile
and gestures are medians over the interval's frames, so that single bad frames do no harm; the
speed comes from a robust line through the latest frames (`kendon.features.motion`). An interval
without frames is unknown, never the last value again. The one exception is a source so slow
(about 5 frames a second) that jitter leaves intervals empty: there the newest frame still counts
while it is younger than one and a half frame periods.

A recording goes through the same sampler as a live source, and so gives the same numbers.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from kendon.errors import ParameterError
from kendon.features.gaze import blend, gaze_of_eyes, gaze_of_head
from kendon.features.motion import Walk, median
from kendon.geometry import Quaternion, Vec3
from kendon.observations import Observation, Observations
from kendon.person import FloatArray, IntArray, PersonFrame, Track
from kendon.tracks import MAX_GAP

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

#: One frame's distance, gaze, smile and three gestures.
_Values = tuple[float, float, float, float, float, float]


class Sampler:
    """Turns frames, as they come, into observations.

    Observations lie on a grid of periods that begins with the first frame. When the clock leaps
    by more than `kendon.tracks.MAX_GAP`, a new grid begins with the next frame.

    Args:
        robot_face: the robot's face in its base frame [m].
        period: the interval between observations [s].

    Raises:
        ParameterError: the face is not finite, or the period is not positive.
    """

    def __init__(self, robot_face: Vec3 = ROBOT_FACE, period: float = PERIOD) -> None:
        self._face = _checked_face(robot_face)
        self.period = _checked_period(period)
        self._last = -math.inf  # [s], the newest frame's stamp
        self._restart()

    def _restart(self) -> None:
        self._start = math.nan  # [s], where the grid begins
        self._count = 1  # of its intervals, with the one being filled
        #: When the interval being filled ends [s]; NaN before the first frame.
        self.next_end = math.nan
        self._stamps: deque[float] = deque(maxlen=_SPACINGS + 1)  # [s], of the newest frames
        self._frames: list[_Values] = []  # of the interval being filled
        self._placed = False  # whether one of those frames tells where the person is
        self._newest: tuple[_Values, bool] | None = None  # the newest frame, and whether it does
        self._walk = Walk()

    def push(self, frame: PersonFrame) -> list[Observation]:
        """Take in a frame; return the observations whose intervals ended before it.

        Raises:
            ParameterError: the stamp is not finite, or not after the last frame's.
        """
        t = frame.t
        if not math.isfinite(t):
            raise ParameterError(f"the stamp of a frame must be finite seconds, not {t}")
        if t <= self._last:
            raise ParameterError(f"frames must come in order: {t} s after {self._last} s")
        done = self._until(t, _TOLERANCE)
        self._take_in(
            t, frame.head, frame.head_rotation, frame.eyes, frame.eye_gaze, frame.smile,
            frame.dsal, frame.csal, frame.hdip, frame.robot,
        )  # fmt: skip
        return done

    def advance(self, t: float) -> list[Observation]:
        """Let time pass without a frame; return the observations whose intervals have ended.

        Raises:
            ParameterError: the time is not finite.
        """
        if not math.isfinite(t):
            raise ParameterError(f"the clock must show finite seconds, not {t}")
        return self._until(t, -_ROUNDING)

    def _until(self, t: float, slack: float) -> list[Observation]:
        """The observations of the intervals that ended more than `slack` before `t` [s]."""
        if t - self.next_end > MAX_GAP:
            done = [self._close()] if self._frames else []
            self._restart()
            return done
        done = []
        while self.next_end + slack < t:  # never before the first frame: that is NaN
            done.append(self._close())
        return done

    def _take_in(
        self,
        t: float,
        head: Vec3,
        rotation: Quaternion,
        eyes: tuple[Vec3, Vec3] | None,
        eye_gaze: tuple[Vec3, Vec3] | None,
        smile: float,
        dsal: float,
        csal: float,
        hdip: float,
        robot: tuple[float, float, float],
    ) -> None:
        if self._start != self._start:  # NaN: the first frame of a grid
            self._start = t
            self.next_end = t + self.period
        self._last = t
        self._stamps.append(t)

        x, y, _ = head
        way = math.hypot(x, y)
        gaze = gaze_of_head(head, rotation, self._face)
        if eyes and eye_gaze:
            gaze = blend(gaze_of_eyes(eyes, eye_gaze, self._face), gaze, way)
        values = (way, gaze, smile, dsal, csal, hdip)
        self._frames.append(values)

        robot_x, robot_y, yaw = robot
        c, s = math.cos(yaw), math.sin(yaw)
        world_x, world_y = robot_x + c * x - s * y, robot_y + s * x + c * y
        placed = math.isfinite(world_x + world_y)
        if placed:
            self._walk.add(t, world_x, world_y, (robot_x, robot_y))
            self._placed = True
        self._newest = values, placed

    def _close(self) -> Observation:
        """The observation of the interval being filled, which ends; the next one begins."""
        end = self.next_end
        frames, placed = self._frames, self._placed
        self._frames, self._placed = [], False
        self._count += 1
        self.next_end = self._start + self._count * self.period  # summed up, it would drift
        if not frames and self._newest and _still_counts(self._stamps, end):
            frames, placed = [self._newest[0]], self._newest[1]
        if not placed:
            self._walk.clear()
        if not frames:
            return Observation(end)
        speed = self._walk.speed(end, self.period) if placed else math.nan
        way, *others = [median(column) for column in zip(*frames, strict=True)]
        return Observation(end, way, speed, *others)


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
    sampler = Sampler(robot_face, period)
    rows: list[Observation] = []
    for frame in _features_of(track):
        if not frame[0] <= sampler.next_end:
            rows += sampler._until(frame[0], _TOLERANCE)
        sampler._take_in(*frame)
    if len(track):
        rows += sampler.advance(float(track.t[-1]) + _TOLERANCE)
    if not rows:
        raise ParameterError(
            f"{track.name or 'the track'} lasts {track.duration:.2f} s;"
            f" the first observation needs {period:g} s"
        )
    seen = Observations.from_rows(rows, track.name if name is None else name)
    return (
        seen
        if track.phases is None
        else replace(seen, phases=_phases_of(track.phases, track.t, seen))
    )


def _features_of(track: Track) -> Iterator[tuple[Any, ...]]:
    """What `Sampler._take_in` needs of every frame: a track's frames without their joints."""
    nothing = [None] * len(track)
    known = np.isfinite(track.eyes).any()
    return zip(
        track.t.tolist(),
        track.head.tolist(),
        track.head_rotation.tolist(),
        track.eyes.tolist() if known else nothing,
        track.eye_gaze.tolist() if known else nothing,
        track.smile.tolist(),
        *track.gestures.T.tolist(),
        track.robot.tolist(),
        strict=True,
    )


def _still_counts(stamps: Sequence[float], end: float) -> bool:
    """Whether a source is so slow that its newest frame still stands for an interval's end."""
    if len(stamps) < 2:
        return False
    spacings = sorted(b - a for a, b in pairwise(stamps))
    return end - stamps[-1] <= _CARRY * spacings[len(spacings) // 2]


def _phases_of(phases: IntArray, t: FloatArray, seen: Observations) -> IntArray:
    """The phase of each interval's middle frame; -1 where nothing was seen."""
    stops = np.searchsorted(t, seen.t + _TOLERANCE, side="right")
    starts = np.concatenate([[0], stops[:-1]])
    # An empty interval in which something was seen is one in which the newest frame still counts.
    empty = starts == stops
    middle = np.where(empty, stops - 1, (starts + stops) // 2)
    unseen = empty & np.isnan(seen.values).all(axis=1)
    return np.where(unseen, -1, phases[middle])


def _checked_period(period: float) -> float:
    if not (math.isfinite(period) and period > 0):
        raise ParameterError(f"the sampling period must be positive seconds, not {period}")
    return period


def _checked_face(robot_face: Sequence[float]) -> Vec3:
    face = tuple(float(value) for value in robot_face)
    if len(face) != 3 or not all(math.isfinite(value) for value in face):
        raise ParameterError(f"the robot's face is a point x, y, z in metres, not {robot_face}")
    return face

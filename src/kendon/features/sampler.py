"""Five observations a second from frames at any rate (thesis 3.3, 3.5.1).

Each observation covers one interval of 0.2 s and is stamped with its end. Distance, gaze, smile
and gestures given by hand are medians over the interval's frames, so that single bad frames do no
harm; the speed comes from a robust line through the latest frames (`kendon.features.motion`).
Gestures that no frame of an interval gives by hand are detected (`kendon.features.gestures`). An
interval without frames is unknown, never the last value again. The one exception is a source so
slow (about 5 frames a second) that jitter leaves intervals empty: there the newest frame still
counts while it is younger than one and a half frame periods.

A recording that is there as a whole is read by `kendon.features.track`, to the same numbers.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from itertools import pairwise

from kendon.errors import ParameterError
from kendon.features.gaze import blend, gaze_of_eyes, gaze_of_head
from kendon.features.gestures import READ_BACK, GestureDetector
from kendon.features.motion import Walk, median
from kendon.geometry import Vec3
from kendon.observations import Observation
from kendon.person import PersonFrame
from kendon.tracks import MAX_GAP

#: The interval between observations (thesis 3.3) [s].
PERIOD = 0.2
#: The robot's face in its base frame unless told otherwise [m].
ROBOT_FACE: Vec3 = (0.0, 0.0, 1.2)

#: Stamps are rounded to milliseconds or finer in files: a frame this little past an interval's
#: end still belongs to it [s].
TOLERANCE = 1e-3
#: Sums of periods and of frame times round differently [s].
ROUNDING = 1e-9
#: How many periods old the newest frame of a slow source may be.
_CARRY = 1.5
#: From so many spacings the frame period of a source is estimated.
SPACINGS = 9

#: One frame's distance, gaze, smile and three gestures.
_Values = tuple[float, float, float, float, float, float]


class Sampler:
    """Turns frames, as they come, into observations.

    Observations lie on a grid of periods that begins with the first frame. When the clock leaps
    by more than `kendon.tracks.MAX_GAP`, a new grid begins with the next frame. When somebody
    else is seen than before, nothing of the last person enters the next observation.

    Args:
        robot_face: the robot's face in its base frame [m].
        period: the interval between observations [s]; the speed is told from the last 0.6 s of
            sight at most, and is unknown where the period is more than twice that.

    Raises:
        ParameterError: the face is not finite, or the period is not positive.
    """

    def __init__(self, robot_face: Vec3 = ROBOT_FACE, period: float = PERIOD) -> None:
        self._face = checked_face(robot_face)
        self.period = checked_period(period)
        self._last = -math.inf  # [s], the newest frame's stamp
        self._who: int | None = None  # whom the last frame with a person showed
        self._restart()

    def _restart(self) -> None:
        self._start = math.nan  # [s], where the grid begins
        self._count = 1  # of its intervals, with the one being filled
        #: When the interval being filled ends [s]; NaN before the first frame.
        self.next_end = math.nan
        self._stamps: deque[float] = deque(maxlen=SPACINGS + 1)  # [s], of the newest frames
        self._frames: list[_Values] = []  # of the interval being filled
        self._since = math.nan  # [s], the first of those frames
        self._placed = False  # whether one of those frames tells where the person is
        self._newest: tuple[_Values, bool] | None = None  # the newest frame, and whether it does
        self._walk = Walk()
        self._detector = GestureDetector()
        #: Frames the detector has not been shown: it costs as much as all the rest, and is not
        #: asked while the gestures are given by hand.
        self._unread: deque[PersonFrame] = deque()

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
        done = self._until(t, TOLERANCE)
        if frame.who != self._who and frame.seen:
            self._meet(frame.who)
        self._take_in(frame)
        return done

    def advance(self, t: float) -> list[Observation]:
        """Let time pass without a frame; return the observations whose intervals have ended.

        Raises:
            ParameterError: the time is not finite.
        """
        if not math.isfinite(t):
            raise ParameterError(f"the clock must show finite seconds, not {t}")
        return self._until(t, -ROUNDING)

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

    def _meet(self, who: int | None) -> None:
        """Somebody else from now on: two people in one interval would make a third."""
        self._who = who
        self._frames, self._placed, self._newest = [], False, None
        self._walk.clear()
        self._detector.clear()
        self._unread.clear()

    def _take_in(self, frame: PersonFrame) -> None:
        t, head = frame.t, frame.head
        if self._start != self._start:  # NaN: the first frame of a grid
            self._start = t
            self.next_end = t + self.period
        self._last = t
        self._stamps.append(t)

        way = math.sqrt(head[0] * head[0] + head[1] * head[1])
        gaze = gaze_of_head(head, frame.head_rotation, self._face)
        if frame.eyes and frame.eye_gaze:
            gaze = blend(gaze_of_eyes(frame.eyes, frame.eye_gaze, self._face), gaze, way)
        if not self._frames:
            self._since = t
        values = (way, gaze, frame.smile, frame.dsal, frame.csal, frame.hdip)
        self._frames.append(values)

        x, y, z = frame.robot.to_world(head)
        placed = math.isfinite(x + y)
        if placed:
            self._walk.add(t, x, y, z, frame.robot[:2])
            self._placed = True
        self._newest = values, placed
        self._unread.append(frame)

    def _close(self) -> Observation:
        """The observation of the interval being filled, which ends; the next one begins."""
        end = self.next_end
        frames, placed = self._frames, self._placed
        since = self._since if frames else self._last
        self._frames, self._placed = [], False
        self._count += 1
        self.next_end = self._start + self._count * self.period  # summed up, it would drift
        if not frames and self._newest and still_counts(self._stamps, end):
            frames, placed = [self._newest[0]], self._newest[1]
        if not placed:
            self._walk.lose()
        if not frames:
            return Observation(end)
        speed = self._walk.speed(end, self.period) if placed else math.nan
        way, gaze, smile, *given = [median(column) for column in zip(*frames, strict=True)]
        gestures = self._gestures(given, end, since, way)
        return Observation(end, way, speed, gaze, smile, *gestures)

    def _gestures(
        self, given: Sequence[float], end: float, since: float, way: float
    ) -> Sequence[float]:
        """The gestures given by hand, completed by what the detector sees."""
        unread = self._unread
        if not any(map(math.isnan, given)):
            while unread and unread[0].t < end - READ_BACK:
                unread.popleft()
            return given
        for frame in unread:
            self._detector.add(frame.t, frame.head, frame.head_rotation, frame.joints)
        unread.clear()
        return self._detector.complete(given, end, since, way)


def still_counts(stamps: Sequence[float], end: float) -> bool:
    """Whether a source is so slow that its newest frame still stands for an interval's end."""
    if len(stamps) < 2:
        return False
    spacings = sorted(b - a for a, b in pairwise(stamps))
    return end - stamps[-1] <= _CARRY * spacings[len(spacings) // 2]


def checked_period(period: float) -> float:
    """The same period.

    Raises:
        ParameterError: it is not positive.
    """
    if not (math.isfinite(period) and period > 0):
        raise ParameterError(f"the sampling period must be positive seconds, not {period}")
    return period


def checked_face(robot_face: Sequence[float]) -> Vec3:
    """The same face as a tuple.

    Raises:
        ParameterError: it is not finite or no point.
    """
    face = tuple(float(value) for value in robot_face)
    if len(face) != 3 or not all(math.isfinite(value) for value in face):
        raise ParameterError(f"the robot's face is a point x, y, z in metres, not {robot_face}")
    return face

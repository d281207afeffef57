"""A source watched as it happens: after each frame what is observed and believed, and how late.

    watch = Watch(source, model)
    for moment in watch.run(seconds=60):
        print(moment.frame.t, moment.belief)
    track = watch.track

For a recording, the beliefs are those of `estimate` with its filter.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from kendon.features import ROBOT_FACE, Sampler
from kendon.geometry import Vec3
from kendon.models import Belief, GreetingModel
from kendon.observations import Observation
from kendon.person import PersonFrame, Track
from kendon.sources.base import Source
from kendon.sources.pictures import Look, PictureSource


class WatchedFrame(NamedTuple):
    """One frame, and what is known after it."""

    frame: PersonFrame
    look: Look | None  # the picture it was read in, where the source has pictures
    observation: Observation | None  # the newest one; None before the first
    belief: Belief | None  # the belief after it


class Latency(NamedTuple):
    """From the arrival of an interval's last picture to the belief after it [s]."""

    median: float
    high: float  # 95 % are below


class Watch:
    """Watches a source.

    Args:
        source: the person.
        model: reads the phases.
        robot_face: the robot's face in its base frame [m].
        clock: that which `kendon.sources.pictures.Picture.arrived` is told by [s].
    """

    def __init__(
        self,
        source: Source,
        model: GreetingModel,
        robot_face: Vec3 = ROBOT_FACE,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._source = source
        self._sampler = Sampler(robot_face)
        self._tracker = model.tracker()
        self._clock = clock
        self._frames: list[PersonFrame] = []
        self._delays: list[float] = []  # [s]

    def run(self, seconds: float | None = None) -> Iterator[WatchedFrame]:
        """Watch until the source ends, or for so many seconds of its own time.

        However it ends, what was watched is in `track`.

        Raises:
            DataError: there is something wrong with what the source reads.
        """
        observation: Observation | None = None
        belief: Belief | None = None
        arrived = float("nan")  # when the last picture of the interval being filled came
        for frame in self._source.frames():
            look = self._source.look if isinstance(self._source, PictureSource) else None
            for fresh in self._sampler.push(frame):
                observation, belief = fresh, self._tracker.step(fresh)
                self._delays.append(self._clock() - arrived)
            if look is not None:
                arrived = look.picture.arrived
            self._frames.append(frame)
            yield WatchedFrame(frame, look, observation, belief)
            if seconds is not None and frame.t - self._frames[0].t >= seconds:
                return

    @property
    def track(self) -> Track:
        """Everything watched so far."""
        return Track.from_frames(self._frames, self._source.name)

    @property
    def latency(self) -> Latency | None:
        """How late the beliefs were; None for a source without pictures, or without a belief."""
        known = np.array([delay for delay in self._delays if delay == delay])
        if not len(known):
            return None
        return Latency(float(np.median(known)), float(np.quantile(known, 0.95)))

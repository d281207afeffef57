"""A whole recording put before a gesture detector, interval by interval."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any, NamedTuple

from kendon.features.gestures.detector import GestureDetector
from kendon.person import FloatArray, IntArray, Track


class Question(NamedTuple):
    """What a detector is to be asked: the arguments of `GestureDetector.gestures`."""

    end: float  # [s]
    since: float  # [s]
    distance: float  # [m]


def feed(
    track: Track,
    detector: GestureDetector,
    starts: IntArray,
    stops: IntArray,
    ends: FloatArray,
    distances: FloatArray,
) -> Iterator[Question | None]:
    """Let a detector see a track up to the end of one interval after another.

    Args:
        track: T frames.
        detector: a new one.
        starts: the first row of each interval, shape (K,).
        stops: the row after its last one, shape (K,).
        ends: of the intervals, shape (K,) [s].
        distances: of the person in the intervals, shape (K,) [m].

    Yields:
        What it is to be asked then; None for an interval without frames.
    """
    rows = _rows(track)
    seen = 0
    for start, stop, end, distance in zip(
        starts.tolist(), stops.tolist(), ends.tolist(), distances.tolist(), strict=True
    ):
        for row in itertools.islice(rows, stop - seen):
            detector.add(*row)
        seen = stop
        yield Question(end, float(track.t[start]), distance) if start < stop else None


def _rows(track: Track) -> Iterator[tuple[Any, ...]]:
    """What `GestureDetector.add` takes, frame by frame; sooner than the frames themselves."""
    names = tuple(track.joints)
    places: Any = (
        zip(*(map(tuple, points.tolist()) for points in track.joints.values()), strict=True)
        if names
        else itertools.repeat(())
    )
    return zip(
        track.t.tolist(),
        map(tuple, track.head.tolist()),
        map(tuple, track.head_rotation.tolist()),
        (dict(zip(names, place, strict=True)) for place in places),
        strict=False,  # the joints of a track without any never end
    )

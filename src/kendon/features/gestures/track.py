"""A whole recording put before a gesture detector, interval by interval."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kendon.features.gestures.detector import READ_BACK, GestureDetector
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
    asked: NDArray[np.bool_] | None = None,
) -> Iterator[Question | None]:
    """Let a detector see a track up to the end of one interval after another.

    While it is not asked it sees nothing, as in a flow of frames: when it is asked again it sees
    the latest `READ_BACK` before.

    Args:
        track: T frames.
        detector: a new one.
        starts: the first row of each interval, shape (K,).
        stops: the row after its last one, shape (K,).
        ends: of the intervals, shape (K,) [s].
        distances: of the person in the intervals, shape (K,) [m].
        asked: in which intervals the detector will be asked, shape (K,); None = in all.

    Yields:
        What it is to be asked then; None for an interval without frames or in which it is not.
    """
    rows = _rows(track)
    seen = 0
    old = np.searchsorted(track.t, ends - READ_BACK).tolist()
    if asked is None:
        asked = np.ones(len(ends), dtype=bool)
    for start, stop, end, distance, first, ask in zip(
        starts.tolist(), stops.tolist(), ends.tolist(), distances.tolist(), old, asked.tolist(),
        strict=True,
    ):  # fmt: skip
        if start == stop:
            yield None
        elif ask:
            for row in itertools.islice(rows, stop - seen):
                detector.add(*row)
            seen = stop
            yield Question(end, float(track.t[start]), distance)
        else:
            if first > seen:
                next(itertools.islice(rows, first - seen - 1, None))
                seen = first
            yield None


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

"""The gestures of a whole recording: a detector's numbers, row by row of a track."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

from kendon.person import Track


def gesture_rows(track: Track) -> Iterator[Any]:
    """What `GestureDetector.add` takes, frame by frame, without building the frames."""
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

"""Who is who: faces in the image keep their numbers from one frame to the next.

Each known face is expected where its motion would have brought it; what is seen is given to what
is expected by the assignment of least total cost (Kuhn 1955, the Hungarian method). A face that is
not seen keeps its number for `LOST`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kendon.sources.face_finder import FaceBox

#: So long a face may be out of sight and still be the same person's when it comes back [s].
LOST = 1.0

#: So far beside the place expected a face may be seen, in sizes of the face (about 0.17 m):
#: a nod or a step to the side between two frames, and more for every second out of sight, up to
#: the most.
_REACH = 1.0
_REACH_PER_SECOND = 6.0
_MOST_REACH = 3.0
#: The largest ratio of sizes of one face between two sightings: somebody who walks 0.4 m nearer
#: from 1.2 m, or turns away.
_RATIO = 1.5
#: How fast the motion of a face that is out of sight dies away [s].
_COASTING = 0.3
#: The share of a new sighting in the motion; the rest is what was known before.
_NEWS = 0.5
#: Two sightings that overlap by more than this share are one face.
_SAME = 0.4
#: More than any cost that is allowed.
_FORBIDDEN = 1e6


@dataclass
class _Known:
    number: int
    box: FaceBox  # where it was last seen
    seen: float  # [s], when
    motion: tuple[float, float] = (0.0, 0.0)  # [px/s] of the box's middle

    def expected(self, t: float) -> FaceBox:
        """Where the face will be at `t` [s]."""
        travelled = _COASTING * (1.0 - math.exp((self.seen - t) / _COASTING))
        x, y, width, height = self.box
        return FaceBox(
            x + self.motion[0] * travelled, y + self.motion[1] * travelled, width, height
        )


class FaceTracks:
    """The faces that are known, by number; numbers count from 1 and are never used again."""

    def __init__(self) -> None:
        self._known: list[_Known] = []
        self._last = 0  # the last number given
        self._updated = -math.inf  # [s]

    def expected(self, t: float) -> dict[int, FaceBox]:
        """Where each known face should be at `t` [s]; those seen last, and the largest, first."""
        self._known = [face for face in self._known if t - face.seen <= LOST]
        self._known.sort(key=lambda face: (-face.seen, -face.box.size))
        return {face.number: face.expected(t) for face in self._known}

    @property
    def complete(self) -> bool:
        """Whether there are known faces, and all of them were seen at the last update."""
        return bool(self._known) and all(face.seen == self._updated for face in self._known)

    def update(self, boxes: Sequence[FaceBox], t: float) -> list[int]:
        """Take in what is seen at `t` [s]; the number of each box's face.

        A box that fits no known face is a new one. No two boxes may show one face (`distinct`).
        """
        expected = list(self.expected(t).values())
        self._updated = t
        numbers = [0] * len(boxes)
        for row, column in self._assigned(expected, boxes, t):
            face = self._known[row]
            numbers[column] = face.number
            self._move(face, boxes[column], t)
        for column, box in enumerate(boxes):
            if not numbers[column]:
                self._last += 1
                numbers[column] = self._last
                self._known.append(_Known(self._last, box, t))
        return numbers

    def _assigned(
        self, expected: Sequence[FaceBox], boxes: Sequence[FaceBox], t: float
    ) -> list[tuple[int, int]]:
        if not expected or not boxes:
            return []
        from scipy.optimize import linear_sum_assignment  # slow to import

        costs = np.array(
            [
                [_cost(old, new, t - face.seen) for new in boxes]
                for face, old in zip(self._known, expected, strict=True)
            ]
        )
        rows, columns = linear_sum_assignment(costs)
        return [
            (row, column)
            for row, column in zip(rows.tolist(), columns.tolist(), strict=True)
            if costs[row, column] < _FORBIDDEN
        ]

    @staticmethod
    def _move(face: _Known, box: FaceBox, t: float) -> None:
        passed = t - face.seen
        if passed > 0:
            (x, y), (old_x, old_y) = box.centre, face.box.centre
            news = (x - old_x) / passed, (y - old_y) / passed
            face.motion = (
                face.motion[0] + _NEWS * (news[0] - face.motion[0]),
                face.motion[1] + _NEWS * (news[1] - face.motion[1]),
            )
        face.box, face.seen = box, t


def distinct(boxes: Sequence[FaceBox]) -> list[int]:
    """Which boxes to keep so that each face is there once: the first of those that overlap."""
    kept: list[int] = []
    for i, box in enumerate(boxes):
        if all(box.overlap(boxes[j]) < _SAME for j in kept):
            kept.append(i)
    return kept


def _cost(expected: FaceBox, seen: FaceBox, passed: float) -> float:
    """How badly a sighting fits a face that has not been seen for `passed` [s]."""
    away = math.dist(expected.centre, seen.centre) / expected.size
    ratio = abs(math.log(seen.size / expected.size))
    reach = min(_REACH + _REACH_PER_SECOND * passed, _MOST_REACH)
    if away > reach or ratio > math.log(_RATIO) * (1.0 + passed):
        return _FORBIDDEN
    return away + ratio

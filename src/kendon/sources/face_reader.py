"""From a picture to the faces in it: found, numbered, and read one by one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from kendon.sources.camera_geometry import import_cv2
from kendon.sources.face_finder import ByteImage, FaceBox, FaceFinder
from kendon.sources.face_landmarks import FaceLandmarks, FaceReading, Window
from kendon.sources.face_tracks import FaceTracks, distinct

#: So often the whole picture is searched while all known faces are seen [s]. Not as often as
#: observations are made, 0.2 s: the slow searches would all fall on the pictures that end one.
SEARCH_PERIOD = 0.25
#: So often while somebody is lost, or nobody is there [s].
LOST_SEARCH_PERIOD = 0.1
#: So many faces are read in one picture, the largest: each costs about 13 ms of one slow core.
MAX_FACES = 4
#: Stamps are rounded; a period may be so much short [s].
_ROUNDING = 1e-3


@dataclass(frozen=True)
class SeenFace:
    """One face of a picture."""

    number: int  # the same in every picture, from 1 in the order in which faces first came
    box: FaceBox  # [px]
    reading: FaceReading | None  # None where it was found but is too small or turned away


class FaceDetector(Protocol):
    """What a video source needs: the faces of each picture."""

    def detect(self, bgr: ByteImage, t: float) -> list[SeenFace]:
        """All faces of one picture, (height, width, 3), stamped `t` [s]; stamps must grow."""

    def close(self) -> None:
        """Give the networks' memory back; nothing may be detected afterwards."""


class FaceReader:
    """Finds faces every now and then, follows them in between by reading them.

    Searching a whole picture costs more than reading a face whose place is known, so it is done
    every `SEARCH_PERIOD`; in between, each face is read in the window where it should be.

    Args:
        finder: looks through whole pictures.
        landmarks: reads the face in a window.
    """

    def __init__(self, finder: FaceFinder, landmarks: FaceLandmarks) -> None:
        self._cv2 = import_cv2("reading faces")
        self._finder = finder
        self._landmarks = landmarks
        self._tracks = FaceTracks()
        self._searched = -math.inf  # [s]

    def detect(self, bgr: ByteImage, t: float) -> list[SeenFace]:
        """All faces of one picture, (height, width, 3), stamped `t` [s]; stamps must grow."""
        places = list(self._tracks.expected(t).values())
        period = SEARCH_PERIOD if self._tracks.complete else LOST_SEARCH_PERIOD
        found: list[FaceBox] = []
        if t - self._searched >= period - _ROUNDING:
            self._searched = t
            found = self._finder.find(bgr)[:MAX_FACES]
        rgb = self._cv2.cvtColor(bgr, self._cv2.COLOR_BGR2RGB)
        seen: list[tuple[FaceBox, FaceReading | None]] = []
        # Where a face was found, its box says better where to read than an expectation does.
        expected = [place for place in places if all(place.overlap(box) < 0.2 for box in found)]
        for box in (found + expected)[:MAX_FACES]:
            reading = self._landmarks.read(rgb, Window.around(box))
            if reading is not None:
                seen.append((reading.box, reading))
            elif box in found:
                seen.append((box, None))
        # Faces that were read come first: of two sightings of one face they are the better.
        seen.sort(key=lambda one: one[1] is None)
        seen = [seen[i] for i in distinct([box for box, _ in seen])]
        numbers = self._tracks.update([box for box, _ in seen], t)
        return [
            SeenFace(number, box, reading)
            for number, (box, reading) in zip(numbers, seen, strict=True)
        ]

    def close(self) -> None:
        """Give the networks' memory back; nothing may be detected afterwards."""
        self._landmarks.close()

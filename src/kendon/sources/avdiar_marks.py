"""What is marked in AVDIAR's images: 18 joints a person, or the box around each face.

``groundTruth.txt`` of the Data Challenge has one row a frame and person, ``frame person speaking
x0 y0 … x17 y17``, frames counted from 1, -1 -1 for what is not seen. ``face_bb.txt`` of the
original release has ``frame,id,x,y,w,h``. Both are in pixels of the left camera.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kendon.errors import DataError
from kendon.person import FloatArray, IntArray
from kendon.sources.number_rows import numbers, text_lines

#: The joints in the file's order. The release's README swaps eyes and ears; the numbers
#: themselves tell that the eyes come first.
FILE_JOINTS = (
    "nose", "neck", "r_shoulder", "r_elbow", "r_wrist", "l_shoulder", "l_elbow", "l_wrist",
    "r_hip", "r_knee", "r_ankle", "l_hip", "l_knee", "l_ankle", "r_eye", "l_eye", "r_ear", "l_ear",
)  # fmt: skip
#: A pixel that no image has: the marks are no marks of images [px].
_MAX_PIXEL = 20000.0
#: Longer than any recording at 25 frames a second (11 hours): a mistaken column.
_MAX_FRAME = 1_000_000
#: How the face box becomes a joint: its middle stands for the nose.
_BOX_JOINT = "nose"


@dataclass(frozen=True, eq=False)
class Marks:
    """Where people are marked, frame by frame from the first to the last marked one."""

    path: Path
    frames: IntArray  # (F,), the numbers in the file, without gaps
    people: Mapping[int, FloatArray]  # number -> (F, 18, 2) [px], x and y; NaN = not seen
    speaking: Mapping[int, FloatArray]  # number -> (F,), 0 or 1; NaN = not said

    def faces(self, person: int) -> FloatArray:
        """The person's face: the nose, or between the eyes, or between the ears; (F, 2) [px]."""
        marks = self.people[person]

        def middle(*names: str) -> FloatArray:
            one, two = (marks[:, FILE_JOINTS.index(name)] for name in names)
            return np.where(np.isnan(one), two, np.where(np.isnan(two), one, (one + two) / 2))

        face = marks[:, FILE_JOINTS.index("nose")]
        for pair in (("r_eye", "l_eye"), ("r_ear", "l_ear")):
            face = np.where(np.isnan(face), middle(*pair), face)
        return face

    @property
    def extent(self) -> tuple[float, float]:
        """The largest x and y marked [px]."""
        largest = np.nanmax(np.stack(list(self.people.values())), axis=(0, 1, 2))
        return float(largest[0]), float(largest[1])


def read_marks(path: str | Path) -> Marks:
    """Read ``groundTruth.txt`` or ``face_bb.txt``, told apart by their commas.

    Of rows that mark the same person in the same frame the first is kept.

    Raises:
        DataError: the file is missing, torn, marks nobody, or holds what cannot be right.
    """
    path = Path(path)
    lines = text_lines(path)
    boxes = "," in lines[0][1]
    seen: dict[tuple[int, int], tuple[float, FloatArray]] = {}
    for row, line in lines:
        if boxes:
            frame, person, marks = _box(line, path, row)
            speaking = math.nan
        else:
            frame, person, speaking, marks = _joints(line, path, row)
        seen.setdefault((frame, person), (speaking, marks))
    numbers_of = [frame for frame, _ in seen]
    frames = np.arange(min(numbers_of), max(numbers_of) + 1)
    people: dict[int, FloatArray] = {}
    speaks: dict[int, FloatArray] = {}
    for number in sorted({person for _, person in seen}):
        people[number] = np.full((len(frames), len(FILE_JOINTS), 2), math.nan)
        speaks[number] = np.full(len(frames), math.nan)
    for (frame, person), (speaking, marks) in seen.items():
        people[person][frame - frames[0]] = marks
        speaks[person][frame - frames[0]] = speaking
    if not any(np.isfinite(marks).any() for marks in people.values()):
        raise DataError("nobody is marked anywhere in this file", file=path)
    return Marks(path, frames, people, speaks)


def _joints(line: str, path: Path, row: int) -> tuple[int, int, float, FloatArray]:
    values = numbers(line.split(), 3 + 2 * len(FILE_JOINTS), path, row)
    frame, person = _counts(values[0], values[1], path, row)
    speaking = values[2]
    if speaking not in (0, 1):
        raise DataError(
            f"speaking is 0 or 1, not {speaking:g}", file=path, row=row, column="speaking"
        )
    marks = np.array(values[3:]).reshape(-1, 2)
    marks[(marks == -1).all(axis=1)] = math.nan
    _check_pixels(marks, path, row)
    return frame, person, speaking, marks


def _box(line: str, path: Path, row: int) -> tuple[int, int, FloatArray]:
    values = numbers(line.split(","), 6, path, row)
    frame, person = _counts(values[0], values[1], path, row)
    x, y, width, height = values[2:]
    if not (width > 0 and height > 0):
        raise DataError(f"a face of {width:g} x {height:g} pixels is none", file=path, row=row)
    marks = np.full((len(FILE_JOINTS), 2), math.nan)
    # A box may reach past the image's rim; its middle is what counts. In this order NaN stays NaN.
    marks[FILE_JOINTS.index(_BOX_JOINT)] = max(x + width / 2, 0.0), max(y + height / 2, 0.0)
    _check_pixels(marks, path, row)
    return frame, person, marks


def _counts(frame: float, person: float, path: Path, row: int) -> tuple[int, int]:
    for value, what in ((frame, "frame"), (person, "person")):
        if not (0 <= value <= _MAX_FRAME and value == int(value)):
            raise DataError(
                f"the {what} is a count, not {value:g}", file=path, row=row, column=what
            )
    return int(frame), int(person)


def _check_pixels(marks: FloatArray, path: Path, row: int) -> None:
    known = marks[~np.isnan(marks)]
    wrong = (known < 0) | (known > _MAX_PIXEL)
    if wrong.any():
        raise DataError(
            f"{known[int(np.argmax(wrong))]:g} is no pixel of an image; what is not seen is"
            " written -1 -1",
            file=path,
            row=row,
        )

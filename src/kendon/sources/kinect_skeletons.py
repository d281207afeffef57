"""The text file of Kinect v2 skeletons that the UoL dataset is made of; its meaning is in `uol`.

One line a frame, ``<time>,<slot>,<slot>,…``; a slot is empty (nobody) or a tracking id and 25
joints of x y z qx qy qz qw, separated by spaces.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kendon.errors import DataError
from kendon.person import FloatArray
from kendon.sources.number_rows import check_metres, numbers, text_lines
from kendon.tracks import MAX_GAP, MIN_RATE

#: The joints in the file's order, which is not that of the Kinect's SDK.
FILE_JOINTS = (
    "SpineBase", "SpineMid", "SpineShoulder", "Neck", "Head", "ShoulderLeft", "ElbowLeft",
    "WristLeft", "HandLeft", "ShoulderRight", "ElbowRight", "WristRight", "HandRight", "HipLeft",
    "KneeLeft", "AnkleLeft", "FootLeft", "HipRight", "KneeRight", "AnkleRight", "FootRight",
    "HandTipLeft", "ThumbLeft", "HandTipRight", "ThumbRight",
)  # fmt: skip
#: x y z qx qy qz qw.
_NUMBERS = 7


@dataclass(frozen=True, eq=False)
class KinectSkeletons:
    """The people of a recording, in the camera's frame."""

    path: Path
    t: FloatArray  # (T,) [s], from the first frame on
    people: Mapping[int, FloatArray]  # slot, counted from 1 -> (T, 25, 7); NaN = not there
    notes: tuple[str, ...]  # what a user should know about how it was read


def joint(name: str) -> int:
    """The place of a joint in the file's order."""
    return FILE_JOINTS.index(name)


def read_kinect_skeletons(path: str | Path, time_unit: float = 1.0) -> KinectSkeletons:
    """Read ``skeletons.txt``: ``<time>,<slot>,<slot>,…`` a frame.

    A joint at the camera itself, which means that it was not tracked, is unknown. Stamps count
    from the first frame.

    Args:
        path: of the file.
        time_unit: of its stamps [s].

    Raises:
        DataError: the file is missing, torn, unsorted, or holds what cannot be right.
    """
    path = Path(path)
    lines = text_lines(path)
    width = len(FILE_JOINTS) * _NUMBERS
    cells = [line.split(",") for _, line in lines]
    rows = [row for row, _ in lines]
    t = np.array([numbers(c[:1], 1, path, row)[0] for c, row in zip(cells, rows, strict=True)])
    t = (t - t[0]) * time_unit
    _check_stamps(t, path, rows)
    empty = np.full(width, np.nan)
    slots: dict[int, Any] = {}
    ids: dict[int, set[str]] = {}
    for index, (row, parts) in enumerate(zip(rows, cells, strict=True)):
        for slot, text in enumerate(parts[1:], start=1):
            words = text.split()
            if not words:
                continue
            values = numbers(words[1:], width, path, row)
            slots.setdefault(slot, [empty] * len(rows))[index] = values
            ids.setdefault(slot, set()).add(words[0])
    people = {}
    for slot in sorted(slots):
        joints = np.array(slots[slot], dtype=float).reshape(-1, len(FILE_JOINTS), _NUMBERS)
        check_metres(joints[:, :, :3], path, rows)
        joints[(joints[:, :, :3] == 0).all(axis=2), :3] = np.nan  # at the camera: not tracked
        people[slot] = joints
    changed = [str(slot) for slot, known in ids.items() if len(known) > 1]
    notes = [f"The tracking id of person {s} changes: it may be two people." for s in changed]
    return KinectSkeletons(path, t, people, tuple(notes))


def _check_stamps(t: FloatArray, path: Path, rows: list[int]) -> None:
    if np.isnan(t).any():
        raise DataError("the time is missing", file=path, row=rows[int(np.argmax(np.isnan(t)))])
    steps = np.diff(t)
    if (steps <= 0).any():
        at = int(np.argmax(steps <= 0)) + 1
        raise DataError(
            "the time does not grow from the row before; rows must be sorted, one a frame",
            file=path,
            row=rows[at],
        )
    if len(steps) and np.median(steps) > 1 / MIN_RATE:
        raise DataError(
            f"frames come every {np.median(steps):g} s; kendon reads seconds and needs at least"
            f" {MIN_RATE:g} frames a second: are these milliseconds?",
            file=path,
            row=rows[1],
        )
    if (steps > MAX_GAP).any():
        at = int(np.argmax(steps > MAX_GAP)) + 1
        raise DataError(
            f"nothing for {steps[at - 1]:.0f} s before this row; split the file into two",
            file=path,
            row=rows[at],
        )

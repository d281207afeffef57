"""The ISR-UoL 3D Social Activity dataset (Coppola et al. 2016): two people's skeletons a recording.

One file a person, ``a<activity>_s<session>[_t<trial>]_user<1|2>.txt``, one line a frame at 30 Hz
without stamps or header: 15 joints of x y z roll pitch yaw. Metres; x away from the camera, y to
its left, z up. The labels are those of a mirror image: ``left_*`` is the person's right. The
head repeats the neck's orientation, so that gaze is unknown.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from kendon.errors import DataError, ParameterError
from kendon.person import FloatArray, Track
from kendon.sources.base import SourceOptions, register
from kendon.sources.number_rows import check_metres, numbers, text_lines
from kendon.sources.pairs import (
    Body,
    PairGreeting,
    floor_height,
    frozen_notes,
    greeting,
    shoulder_heading,
)
from kendon.sources.recording import RecordedSource

#: Frames a second (the dataset's documentation; there are no stamps).
RATE = 30.0
#: The joints in the file's order, under the file's mirrored names.
FILE_JOINTS = (
    "head", "neck", "torso", "left_shoulder", "left_elbow", "right_shoulder", "right_elbow",
    "left_hip", "left_knee", "right_hip", "right_knee", "left_hand", "right_hand", "left_foot",
    "right_foot",
)  # fmt: skip
#: x y z roll pitch yaw.
_NUMBERS = 6
_NAME = re.compile(r"(?P<recording>a\d+_s\d+(?:_t\d+)?)_user(?P<user>[12])\.txt", re.IGNORECASE)
#: Recordings known to be damaged; of the last two the whole one, not its trials ``_t<NN>``.
_DAMAGED = re.compile(r"a03_s09_t0?[1-4]|a05_s10(_t\d+)?|a06_s0[56]|a03_s07_t0?3", re.IGNORECASE)


@register
class IsrUolSource(RecordedSource):
    """One person of an ISR-UoL recording, the robot in the place of the other."""

    name = "isr-uol"
    reads = "ISR-UoL 3D Social Activity skeletons; the other user's file lies beside it"
    example = "a01_s01_user1.txt"

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """A file named as the dataset names its files."""
        return _NAME.fullmatch(Path(spec).name) is not None

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> IsrUolSource:
        """Read both people; `options.fps` replaces the dataset's 30 frames a second.

        Raises:
            DataError: a file is missing, torn, or holds what cannot be right.
        """
        found = _read(Path(spec), options.fps or RATE)[0]
        source = cls(found.track)
        source.notes = found.notes
        return source


def read_isr_uol(path: str | Path, *, fps: float = RATE) -> Track:
    """The person whose file this is, the robot standing where the other user stands.

    Heights are above the floor, on which both people's lower foot stands in the median. The
    robot's x axis is the partner's body heading. ``hand`` joints are read as wrists.

    Args:
        path: of one user's file; the other's must lie beside it.
        fps: frames a second.

    Raises:
        DataError: a file is missing, torn, or holds what cannot be right.
        ParameterError: `fps` is not positive.
    """
    return _read(Path(path), fps)[0].track


def read_isr_uol_pairs(path: str | Path, *, fps: float = RATE) -> list[Track]:
    """Both greetings of a recording: this file's person first, then the other user.

    Args:
        path: of either user's file.
        fps: frames a second.

    Raises:
        DataError: a file is missing, torn, or holds what cannot be right.
        ParameterError: `fps` is not positive.
    """
    return [found.track for found in _read(Path(path), fps)]


def _read(path: Path, fps: float) -> tuple[PairGreeting, PairGreeting]:
    if not fps > 0:
        raise ParameterError(f"frames a second must be positive, not {fps:g}")
    match = _NAME.fullmatch(path.name)
    if match is None:
        raise DataError(
            "the name tells neither the recording nor the user; the dataset's files are called"
            " like a01_s01_user1.txt",
            file=path,
        )
    damaged = _DAMAGED.fullmatch(match["recording"]) is not None
    other = path.with_name(f"{path.name[: match.start('user')]}{3 - int(match['user'])}.txt")
    try:
        mine = _read_joints(path)
        if not other.exists():
            raise DataError(
                f"the partner's file {other.name} is not beside it; a greeting needs both",
                file=path,
            )
        theirs = _read_joints(other)
        return _pair((path, mine), (other, theirs), fps, damaged)
    except DataError as error:
        if not damaged:
            raise
        raise DataError(f"{error} (this recording is known to be damaged)") from None


def _pair(
    one: tuple[Path, FloatArray], two: tuple[Path, FloatArray], fps: float, damaged: bool
) -> tuple[PairGreeting, PairGreeting]:
    (path, mine), (other, theirs) = one, two
    notes = []
    if damaged:
        notes.append(f"{path.name} is of a recording that is known to be damaged.")
    n = min(len(mine), len(theirs))
    if len(mine) != len(theirs):
        notes.append(
            f"{path.name} has {len(mine)} frames and {other.name} {len(theirs)};"
            f" both are cut to {n}."
        )
    t = np.arange(n) / fps
    mine, theirs = mine[:n].copy(), theirs[:n].copy()
    for joints, whose in ((mine, path), (theirs, other)):
        notes.extend(frozen_notes(t, joints[:, :, :3], f"The person of {whose.name}"))
    feet = [joints[:, [_at("left_foot"), _at("right_foot")], 2] for joints in (mine, theirs)]
    floor = floor_height(feet, path)
    for joints in (mine, theirs):
        joints[:, :, 2] -= floor
    bodies = _body(mine), _body(theirs)
    first = greeting(t, bodies[0], bodies[1], path.stem)
    second = greeting(t, bodies[1], bodies[0], other.stem)
    return (
        PairGreeting(first.track, first.robot_face, tuple(notes)),
        PairGreeting(second.track, second.robot_face, tuple(notes)),
    )


def _body(joints: FloatArray) -> Body:
    """The person of a file's joints, shape (T, 15, 6), heights above the floor."""

    def place(name: str) -> FloatArray:
        return joints[:, _at(name), :3]

    named = {}
    for own, label in (("l", "right"), ("r", "left")):  # the file's labels are mirrored
        for joint, word in (
            ("shoulder", "shoulder"), ("elbow", "elbow"), ("wrist", "hand"), ("hip", "hip"),
        ):  # fmt: skip
            named[f"{own}_{joint}"] = place(f"{label}_{word}")
    # The dataset's own formula; it is the shoulders' direction, which fills in for it.
    roll = joints[:, _at("torso"), 3]
    shoulders = shoulder_heading(named["l_shoulder"], named["r_shoulder"])
    heading = np.where(np.isnan(roll), shoulders, math.pi + (roll - math.pi / 2))
    return Body(place("head"), place("torso")[:, :2], heading, named)


def _read_joints(path: Path) -> FloatArray:
    """Shape (T, 15, 6); a joint at the camera itself, which means untracked, is NaN."""
    lines = text_lines(path)
    width = len(FILE_JOINTS) * _NUMBERS
    rows = [numbers(line.split(), width, path, row) for row, line in lines]
    joints = np.array(rows).reshape(-1, len(FILE_JOINTS), _NUMBERS)
    check_metres(joints[:, :, :3], path, [row for row, _ in lines])
    joints[(joints[:, :, :3] == 0).all(axis=2)] = np.nan
    return joints


def _at(name: str) -> int:
    return FILE_JOINTS.index(name)

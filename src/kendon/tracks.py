"""The track CSV: one person over time, one row a frame, in and out.

Metres, seconds, the robot's base frame. Required: ``t head_x head_y head_z``. Optional, each
group whole: ``head_qx head_qy head_qz head_qw``; ``{l,r}_{shoulder,elbow,wrist,hip}_{x,y,z}``;
``{l,r}_eye_{x,y,z}`` with ``{l,r}_gaze_{x,y,z}``; ``smile``; ``dsal csal hdip``;
``robot_x robot_y robot_yaw``; ``phase``. An empty cell is unknown.
"""

from __future__ import annotations

import difflib
import math
from pathlib import Path

import numpy as np

from kendon.errors import DataError
from kendon.person import GESTURES, JOINTS, FloatArray, IntArray, Track
from kendon.phases import PHASE_NAMES
from kendon.tables import Table, read_table, write_table

#: Farther than this nobody is greeted; a larger coordinate is a mistaken unit [m].
MAX_COORDINATE = 100.0
#: A yaw that is counted on past a half turn is fine, but not one in degrees [rad].
MAX_YAW = 20.0
#: Fewer frames a second than this cannot carry five observations a second [1/s].
MIN_RATE = 2.0
#: A longer hole means two recordings in one file [s].
MAX_GAP = 60.0
#: The word in the phase column for somebody who greets nobody.
NOT_GREETING = "NONE"

_HEAD = ("head_x", "head_y", "head_z")
_ROTATION = ("head_qx", "head_qy", "head_qz", "head_qw")
_ROBOT = ("robot_x", "robot_y", "robot_yaw")
_EYES = tuple(f"{side}_eye_{axis}" for side in "lr" for axis in "xyz")
_GAZE = tuple(f"{side}_gaze_{axis}" for side in "lr" for axis in "xyz")
_JOINT_COLUMNS = {joint: tuple(f"{joint}_{axis}" for axis in "xyz") for joint in JOINTS}
_GROUPS = (_ROTATION, _ROBOT, _EYES + _GAZE, *_JOINT_COLUMNS.values())
_KNOWN = {
    "t", "smile", "phase", *GESTURES, *_HEAD, *(column for group in _GROUPS for column in group)
}  # fmt: skip
#: How alike a column must be to a known one to be taken for it, misspelt: `l_wirst_x` is, but
#: no other part of the body is (`l_eyebrow_x` comes nearest, at 0.8).
_ALIKE = 0.85


def read_track(path: str | Path) -> Track:
    """Read a track CSV.

    Raises:
        DataError: the file is missing, empty, torn, unsorted, has stamps twice, mistaken units,
            a misspelt or half-given group of columns; the message names file, row and column.
    """
    table = read_table(path)
    table.require("t", *_HEAD)
    _refuse_misspelt(table)
    _refuse_half_groups(table)
    t = read_stamps(table, "t")
    metres = "kendon reads metres: are these millimetres or centimetres?"

    def points(columns: tuple[str, ...]) -> FloatArray:
        return np.stack(
            [
                table.numbers(c, low=-MAX_COORDINATE, high=MAX_COORDINATE, hint=metres)
                for c in columns
            ],
            axis=1,
        )

    robot = None
    if _ROBOT[0] in table:
        radians = "kendon reads radians: are these degrees?"
        yaw = table.numbers(_ROBOT[2], low=-MAX_YAW, high=MAX_YAW, hint=radians)
        robot = np.column_stack([points(_ROBOT[:2]), yaw])
    has_eyes = _EYES[0] in table
    return Track.build(
        t,
        points(_HEAD),
        head_rotation=_read_rotation(table) if _ROTATION[0] in table else None,
        eyes=points(_EYES).reshape(-1, 2, 3) if has_eyes else None,
        eye_gaze=points(_GAZE).reshape(-1, 2, 3) if has_eyes else None,
        joints={j: points(columns) for j, columns in _JOINT_COLUMNS.items() if columns[0] in table},
        smile=table.numbers("smile", low=0, high=5) if "smile" in table else None,
        gestures=np.stack(
            [
                table.numbers(g, low=0, high=1) if g in table else np.full(len(t), math.nan)
                for g in GESTURES
            ],
            axis=1,
        ),
        robot=robot,
        phases=read_phases(table) if "phase" in table else None,
        name=Path(path).stem,
    )


def write_track(track: Track, path: str | Path) -> None:
    """Write a track CSV; columns of which nothing is known are left out."""
    columns: dict[str, FloatArray] = {"t": track.t}

    def add(names: tuple[str, ...], values: FloatArray) -> None:
        if np.isfinite(values).any():
            columns.update(zip(names, values.reshape(len(track), -1).T, strict=True))

    columns.update(zip(_HEAD, track.head.T, strict=True))
    add(_ROTATION, track.head_rotation)
    for joint, positions in track.joints.items():
        add(tuple(f"{joint}_{axis}" for axis in "xyz"), positions)
    if np.isfinite(track.eyes).any():
        columns.update(zip(_EYES, track.eyes.reshape(-1, 6).T, strict=True))
        columns.update(zip(_GAZE, track.eye_gaze.reshape(-1, 6).T, strict=True))
    add(("smile",), track.smile)
    for i, gesture in enumerate(GESTURES):
        add((gesture,), track.gestures[:, i])
    if not (track.robot == 0).all():
        add(_ROBOT, track.robot)
    rows = np.column_stack(list(columns.values())).tolist()
    if track.phases is None:
        write_table(path, list(columns), rows)
        return
    words = [phase_word(number) for number in track.phases.tolist()]
    write_table(
        path, [*columns, "phase"], [[*row, word] for row, word in zip(rows, words, strict=True)]
    )


def phase_word(number: int) -> str:
    """How a phase number is written in a phase column: 1-6, 0 = NONE, -1 = empty."""
    return "" if number < 0 else NOT_GREETING if number == 0 else PHASE_NAMES[number - 1]


def read_stamps(table: Table, column: str) -> FloatArray:
    """The column of stamps, shape (rows,) [s].

    Raises:
        DataError: a stamp is missing, stands twice, runs backward, leaps, or is no second.
    """
    t = table.numbers(column)
    if np.isnan(t).any():
        raise table.error("the time is missing", int(np.argmax(np.isnan(t))), column)
    steps = np.diff(t)
    if (steps <= 0).any():
        at = int(np.argmax(steps <= 0)) + 1
        problem = "stands twice" if steps[at - 1] == 0 else f"comes after {t[at - 1]:g} s"
        raise table.error(
            f"time {t[at]:g} s {problem}; rows must be sorted by time, one row a frame", at, column
        )
    if len(steps) and np.median(steps) > 1 / MIN_RATE:
        raise table.error(
            f"frames come every {np.median(steps):g} s; kendon reads seconds and needs at least"
            f" {MIN_RATE:g} frames a second: are these milliseconds?",
            1,
            column,
        )
    if (steps > MAX_GAP).any():
        at = int(np.argmax(steps > MAX_GAP)) + 1
        raise table.error(
            f"nothing for {steps[at - 1]:.0f} s before this row; split the file into two",
            at,
            column,
        )
    return t


def read_phases(table: Table) -> IntArray:
    """The phase column as numbers 1-6, 0 for NONE, -1 for an empty cell; shape (rows,).

    Raises:
        DataError: a word is no phase.
    """
    numbers = {"": -1, NOT_GREETING: 0, **{name: i + 1 for i, name in enumerate(PHASE_NAMES)}}
    words = [word.upper() for word in table.texts("phase")]
    for index, word in enumerate(words):
        if word not in numbers:
            valid = ", ".join((*PHASE_NAMES, NOT_GREETING))
            raise table.error(f"{word[:40]!r} is no phase; valid: {valid}", index, "phase")
    return np.array([numbers[word] for word in words])


def _read_rotation(table: Table) -> FloatArray:
    rotation = np.stack([table.numbers(c, low=-1.1, high=1.1) for c in _ROTATION], axis=1)
    norm = np.linalg.norm(rotation, axis=1)
    wrong = np.abs(norm - 1) > 0.05
    if wrong.any():
        at = int(np.argmax(wrong))
        raise table.error(
            f"the quaternion has length {norm[at]:.2f} instead of 1", at, "head_qx..head_qw"
        )
    return np.asarray(rotation / norm[:, None])


def _refuse_misspelt(table: Table) -> None:
    for column in table.columns:
        if column in _KNOWN:
            continue
        free = _KNOWN - set(table.columns)
        near = difflib.get_close_matches(column.lower(), free, n=1, cutoff=_ALIKE)
        if near:
            raise DataError(
                f"unknown column {column!r}; did you mean {near[0]!r}?", file=table.path, row=1
            )


def _refuse_half_groups(table: Table) -> None:
    for group in _GROUPS:
        missing = [column for column in group if column not in table]
        if missing and len(missing) < len(group):
            raise DataError(
                f"columns {', '.join(missing)} missing; they go together with"
                f" {', '.join(c for c in group if c in table)}",
                file=table.path,
                row=1,
            )

"""The seven numbers the greeting model reads, five times a second (thesis 3.3)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kendon.errors import ParameterError
from kendon.person import FloatArray, IntArray
from kendon.tables import read_table, write_table
from kendon.tracks import MAX_COORDINATE, phase_word, read_phases, read_stamps

#: The features in the order of every array with seven columns.
FEATURES: tuple[str, ...] = ("distance", "speed", "gaze", "smile", "dsal", "csal", "hdip")

#: The unit of each feature, for axes and tables.
UNITS: dict[str, str] = {
    "distance": "m", "speed": "m/s", "gaze": "1", "smile": "0–5",
    "dsal": "probability", "csal": "probability", "hdip": "probability",
}  # fmt: skip

#: How often dsal, csal and hdip are there in an interval of a greeting, by how long each gesture
#: lasts and how many greetings have it. A detector's probability has this rate in it: that is what
#: it says on average. A wave 1.3 s in two of three greetings of 8 s, and some nods and bows;
#: a handshake 1.7 s in three of four; a dip 0.6 s in every second (thesis 2.1.3).
GESTURE_RATES: tuple[float, ...] = (0.13, 0.17, 0.04)


class Observation(NamedTuple):
    """What is observed of a person in one interval of 0.2 s; NaN = unknown."""

    t: float  # [s], the end of the interval
    distance: float = math.nan  # [m], robot base to face, ground plane (3.1)
    speed: float = math.nan  # [m/s], of the person toward the robot (3.2-3.3)
    gaze: float = math.nan  # [1], 0 = at the robot's face, 1 = rim of the 60 degree cone (3.8)
    smile: float = math.nan  # [0-5], mean of AU06 and AU12 (3.11)
    dsal: float = math.nan  # [probability] of a distance salutation's gesture
    csal: float = math.nan  # [probability] of a close salutation's gesture
    hdip: float = math.nan  # [probability] of a head dip

    @property
    def values(self) -> FloatArray:
        """The seven features, shape (7,)."""
        return np.array(self[1:])


@dataclass(frozen=True, eq=False)
class Observations:
    """The observations of one greeting, one row an interval.

    Raises:
        ParameterError: the shapes do not fit.
    """

    t: FloatArray  # (T,) [s], ends of the intervals
    values: FloatArray  # (T, 7) in the order of FEATURES, NaN = unknown
    phases: IntArray | None = None  # (T,) true phase 1-6, 0 = not greeting, -1 = not labelled
    name: str = ""

    def __post_init__(self) -> None:
        if self.values.shape != (len(self.t), len(FEATURES)):
            raise ParameterError(
                f"observations need values of shape {(len(self.t), len(FEATURES))},"
                f" not {self.values.shape}"
            )
        if self.phases is not None and self.phases.shape != self.t.shape:
            raise ParameterError(
                f"observations need one phase a row: {len(self.t)}, not {self.phases.shape}"
            )

    @classmethod
    def from_rows(cls, rows: Iterable[Observation], name: str = "") -> Observations:
        """The observations of an iterable, in its order."""
        array = np.array([tuple(row) for row in rows], dtype=float).reshape(-1, 1 + len(FEATURES))
        return cls(array[:, 0], array[:, 1:], name=name)

    def __len__(self) -> int:
        return len(self.t)

    def __iter__(self) -> Iterator[Observation]:
        for t, row in zip(self.t.tolist(), self.values.tolist(), strict=True):
            yield Observation(t, *row)


def read_observations(path: str | Path) -> Observations:
    """Read an observations CSV: ``t``, the seven features, optionally ``phase``.

    Raises:
        DataError: the file is missing, torn, unsorted or out of range; the message names the
            file, the row and the column.
    """
    table = read_table(path)
    table.require("t", *FEATURES)
    metres = "kendon reads metres: are these millimetres?"
    limits: dict[str, tuple[float, float, str]] = {
        "distance": (0, MAX_COORDINATE, metres),
        "speed": (-MAX_COORDINATE, MAX_COORDINATE, metres),
        "gaze": (0, math.inf, ""),
        "smile": (0, 5, ""),
    }
    columns = []
    for feature in FEATURES:
        low, high, hint = limits.get(feature, (0, 1, ""))
        columns.append(table.numbers(feature, low=low, high=high, hint=hint))
    return Observations(
        read_stamps(table, "t"),
        np.stack(columns, axis=1),
        read_phases(table) if "phase" in table else None,
        Path(path).stem,
    )


def write_observations(observations: Observations, path: str | Path) -> None:
    """Write an observations CSV; unknown values become empty cells."""
    rows: list[list[object]] = np.column_stack([observations.t, observations.values]).tolist()
    columns = ["t", *FEATURES]
    if observations.phases is not None:
        columns.append("phase")
        for row, number in zip(rows, observations.phases.tolist(), strict=True):
            row.append(phase_word(number))
    write_table(path, columns, rows)

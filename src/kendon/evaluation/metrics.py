"""How well phases were read: pure functions on arrays of phase numbers.

Throughout, `truth` has the numbers of the true phases, 1-6, with 0 = not greeting and -1 = not
labelled, and `read` those that were read, 1-6; both have the shape (T,). Rows whose truth is
0 or -1 do not count, except in `shares`, which is about them. What cannot be told is NaN.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kendon.errors import ParameterError
from kendon.estimate import stretches
from kendon.person import FloatArray, IntArray
from kendon.phases import Phase

_PHASES = len(Phase)

#: A phase that is read so long after it has ended still counts as found [s]: about one pause
#: between two words, after which an answer is no longer taken for one.
GRACE = 1.0
#: A change of phase is found if it is read at most so long before or after it happens [s].
TOLERANCE = 1.0
#: Stamps are written with six decimals; times that differ by less are the same [s].
_SAME_TIME = 1e-6


def confusion(truth: IntArray, read: IntArray) -> IntArray:
    """How often each true phase (row) was read as each phase (column), shape (6, 6).

    Raises:
        ParameterError: the shapes differ, or a phase that was read is none of the six.
    """
    _check(truth, read)
    counts = np.zeros((_PHASES, _PHASES), dtype=np.int64)
    labelled = truth > 0
    np.add.at(counts, (truth[labelled] - 1, read[labelled] - 1), 1)
    return counts


def accuracy(counts: IntArray) -> float:
    """The share of right phases of a confusion matrix (thesis 3.6.1)."""
    return _share(int(counts.trace()), int(counts.sum()))


class PhaseScores(NamedTuple):
    """How well each phase was read; each of shape (6,)."""

    recall: FloatArray  # of its observations, the share that was read so; NaN if it has none
    precision: FloatArray  # of the observations read so, the share that was; NaN if none was
    f1: FloatArray  # the harmonic mean of the two; NaN if it neither happened nor was read

    @property
    def macro_f1(self) -> float:
        """The mean F1 of the phases that happened, each with the same weight."""
        happened = np.isfinite(self.recall)
        return float(self.f1[happened].mean()) if happened.any() else float("nan")


def phase_scores(counts: IntArray) -> PhaseScores:
    """Recall, precision and F1 of each phase from a confusion matrix, (6, 6)."""
    right = counts.diagonal().astype(float)
    happened, read = counts.sum(axis=1), counts.sum(axis=0)
    return PhaseScores(
        _divide(right, happened), _divide(right, read), _divide(2 * right, happened + read)
    )


class Entry(NamedTuple):
    """One time that a person truly entered a phase."""

    phase: Phase
    t: float  # [s], of its first observation
    delay: float  # [s], until the reading was there; 0 if it was there before; NaN = missed


def entries(t: FloatArray, truth: IntArray, read: IntArray, *, grace: float = GRACE) -> list[Entry]:
    """How late the reading followed each true entry into a phase.

    The reading has until `grace` seconds after the person left the phase, or until the person
    enters it again. A stretch that follows unlabelled rows is not looked at, as nobody knows
    when it began; one that the recording begins with is.

    Args:
        t: stamps, (T,) [s].
        truth: (T,).
        read: (T,).
        grace: [s].

    Raises:
        ParameterError: the shapes differ, or a phase that was read is none of the six.
    """
    _check(truth, read)
    found = []
    parts = stretches(truth)
    for place, part in enumerate(parts):
        if part.number <= 0 or (place and parts[place - 1].number < 0):
            continue
        again = (later.start for later in parts[place + 1 :] if later.number == part.number)
        end = t[part.stop - 1] + grace + _SAME_TIME
        limit = min(int(np.searchsorted(t, end, side="right")), next(again, len(t)))
        there = np.flatnonzero(read[part.start : limit] == part.number)
        delay = float(t[part.start + there[0]] - t[part.start]) if len(there) else float("nan")
        found.append(Entry(Phase(part.number), float(t[part.start]), delay))
    return found


@dataclass(frozen=True)
class Transitions:
    """How many changes from one phase to another happened, were read, and were found."""

    true: int = 0
    read: int = 0
    found: int = 0  # pairs of a true and a read one, the same change at about the same time

    def __add__(self, other: Transitions) -> Transitions:
        return Transitions(self.true + other.true, self.read + other.read, self.found + other.found)

    @property
    def recall(self) -> float:
        """Of the changes that happened, the share that was found."""
        return _share(self.found, self.true)

    @property
    def precision(self) -> float:
        """Of the changes that were read, the share that happened."""
        return _share(self.found, self.read)


def transitions(
    t: FloatArray, truth: IntArray, read: IntArray, *, tolerance: float = TOLERANCE
) -> Transitions:
    """Changes from one phase to another, found if read within `tolerance` seconds.

    Only changes between two labelled rows count, of the truth and of the reading.

    Args:
        t: stamps, (T,) [s].
        truth: (T,).
        read: (T,).
        tolerance: [s].

    Raises:
        ParameterError: the shapes differ, or a phase that was read is none of the six.
    """
    _check(truth, read)
    labelled = truth > 0
    both = labelled[1:] & labelled[:-1]
    true_times, read_times = _changes(t, truth, both), _changes(t, read, both)
    found = sum(
        _pairs(times, read_times.get(change, []), tolerance) for change, times in true_times.items()
    )
    return Transitions(
        sum(map(len, true_times.values())), sum(map(len, read_times.values())), found
    )


def shares(truth: IntArray, read: IntArray) -> FloatArray:
    """Of the observations of somebody who greets nobody, the share read as each phase, (6,).

    Raises:
        ParameterError: the shapes differ, or a phase that was read is none of the six.
    """
    _check(truth, read)
    of_none = read[truth == 0]
    counts = np.bincount(of_none - 1, minlength=_PHASES)
    return _divide(counts.astype(float), np.full(_PHASES, len(of_none)))


def _changes(
    t: FloatArray, numbers: IntArray, counted: np.ndarray[tuple[int], np.dtype[np.bool_]]
) -> dict[tuple[int, int], list[float]]:
    """The times of each kind of change, in order."""
    changes: dict[tuple[int, int], list[float]] = {}
    for row in np.flatnonzero((numbers[1:] != numbers[:-1]) & counted).tolist():
        kind = (int(numbers[row]), int(numbers[row + 1]))
        changes.setdefault(kind, []).append(float(t[row + 1]))
    return changes


def _pairs(true: list[float], read: list[float], tolerance: float) -> int:
    """How many times can be paired, one with one; in order is as good as any other way."""
    waiting: Iterator[float] = iter(read)
    candidate = next(waiting, None)
    pairs = 0
    for time in true:
        while candidate is not None and candidate < time - tolerance - _SAME_TIME:
            candidate = next(waiting, None)
        if candidate is not None and candidate <= time + tolerance + _SAME_TIME:
            pairs += 1
            candidate = next(waiting, None)
    return pairs


def _check(truth: IntArray, read: IntArray) -> None:
    if truth.shape != read.shape or truth.ndim != 1:
        raise ParameterError(
            f"true and read phases are compared row by row: {truth.shape} and {read.shape} differ"
        )
    if len(read) and not 1 <= read.min() <= read.max() <= _PHASES:
        raise ParameterError(f"what was read must be phases, 1 to {_PHASES}, in every row")


def _divide(some: FloatArray, all_of_them: IntArray) -> FloatArray:
    empty = np.full(len(some), np.nan)
    np.divide(some, all_of_them, out=empty, where=all_of_them > 0)
    return empty


def _share(some: int, all_of_them: int) -> float:
    return some / all_of_them if all_of_them else float("nan")

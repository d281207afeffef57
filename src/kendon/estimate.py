"""Phases for recorded people: from a file to observations to a phase for each of them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kendon.models import GreetingModel
from kendon.observations import FEATURES, Observations
from kendon.person import FloatArray, IntArray
from kendon.phases import PHASE_NAMES, Phase
from kendon.tables import write_table


class Decoder(StrEnum):
    """How phases are read from observations."""

    FILTER = "filter"  # causal: what a robot knows at that instant (thesis Algorithm 1)
    VITERBI = "viterbi"  # the most probable path of the whole recording (thesis 2.7-2.12)


class Stretch(NamedTuple):
    """Rows from `start` up to, not including, `stop` with the same number."""

    start: int
    stop: int
    number: int


def stretches(numbers: IntArray) -> list[Stretch]:
    """The stretches of equal numbers of an array, in order.

    >>> stretches(np.array([4, 4, 2]))
    [Stretch(start=0, stop=2, number=4), Stretch(start=2, stop=3, number=2)]
    """
    if not len(numbers):
        return []
    cuts = [0, *(np.flatnonzero(np.diff(numbers)) + 1).tolist(), len(numbers)]
    return [Stretch(a, b, int(numbers[a])) for a, b in pairwise(cuts)]


@dataclass(frozen=True, eq=False)
class Estimate:
    """The phases read from one recording."""

    observations: Observations
    probabilities: FloatArray  # (T, 6), the filter's, whatever the decoder
    phases: IntArray  # (T,), 1-6

    @property
    def accuracy(self) -> float:
        """The share of right phases among the observations with a true one; NaN if none has."""
        right, labelled = self.score
        return right / labelled if labelled else float("nan")

    @property
    def score(self) -> tuple[int, int]:
        """How many phases are right, of how many observations with a true one."""
        truth = self.observations.phases
        if truth is None:
            return 0, 0
        return int((self.phases[truth > 0] == truth[truth > 0]).sum()), int((truth > 0).sum())

    @property
    def sequence(self) -> list[Phase]:
        """The phases in the order they were entered."""
        return [Phase(part.number) for part in stretches(self.phases)]

    def write(self, path: str | Path) -> None:
        """Write ``t,phase,p_IA..p_CS`` and the seven features as CSV."""
        columns = ["t", "phase", *(f"p_{name}" for name in PHASE_NAMES), *FEATURES]
        rows = zip(
            self.observations.t.tolist(),
            self.phases.tolist(),
            self.probabilities.tolist(),
            self.observations.values.tolist(),
            strict=True,
        )
        write_table(
            path, columns, ([t, PHASE_NAMES[n - 1], *p, *values] for t, n, p, values in rows)
        )


def estimate(
    observations: Observations, model: GreetingModel, decoder: Decoder = Decoder.FILTER
) -> Estimate:
    """Read the phases of one recording."""
    probabilities = model.filter(observations.values)
    phases = (
        probabilities.argmax(axis=1) + 1
        if decoder is Decoder.FILTER
        else model.decode(observations.values)
    )
    return Estimate(observations, probabilities, phases)

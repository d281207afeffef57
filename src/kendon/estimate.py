"""Phases for recorded people: from a file to observations to a phase for each of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from kendon.errors import DataError, ParameterError
from kendon.features import PERIOD, ROBOT_FACE, observe
from kendon.geometry import Vec3
from kendon.models import GreetingModel
from kendon.observations import FEATURES, Observations, read_observations
from kendon.person import FloatArray, IntArray, PersonFrame
from kendon.phases import PHASE_NAMES, Phase
from kendon.sources import SourceOptions, find_source, open_source
from kendon.tables import peek_header, write_table


class Decoder(StrEnum):
    """How phases are read from observations."""

    FILTER = "filter"  # causal: what a robot knows at that instant (thesis Algorithm 1)
    VITERBI = "viterbi"  # the most probable path of the whole recording (thesis 2.7-2.12)


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
        changed = np.flatnonzero(np.diff(self.phases, prepend=0))
        return [Phase(n) for n in self.phases[changed].tolist()]

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


def load_observations(
    spec: str,
    options: SourceOptions | None = None,
    *,
    source: str | None = None,
    robot_face: Vec3 = ROBOT_FACE,
    gestures_from_phases: bool = False,
    progress: Callable[[PersonFrame], None] | None = None,
    note: Callable[[str], None] | None = None,
) -> Observations:
    """The observations of a file, whether it holds them ready or a person to observe.

    Args:
        spec: a file that a source recognises, or an observations CSV.
        options: how the source is read.
        source: the source's name, where it is not to be found out from the file.
        robot_face: the robot's face in its base frame [m].
        gestures_from_phases: press the thesis's keys as the true phases say (3.3.5).
        progress: called after each frame of a source that takes its time.
        note: called with each sentence the source has for the user.

    Raises:
        DataError: the file cannot be read, or lasts less than one interval.
        ParameterError: there are no true phases to press keys by.
    """
    header = peek_header(spec) if source is None else ()
    if "t" in header and any(feature in header for feature in FEATURES[:3]):
        observations = read_observations(spec)
        if gestures_from_phases:
            raise ParameterError(f"{spec}: observations hold their gestures already")
        return observations
    if find_source(spec, name=source).live:
        raise DataError("estimate reads recordings; for a device there is kendon greet", file=spec)
    opened = open_source(spec, options, name=source)
    for sentence in opened.notes if note else ():
        note(sentence)  # type: ignore[misc]
    track = opened.record(progress)
    if gestures_from_phases:
        track = track.with_gestures_from_phases()
    if track.duration < PERIOD:
        raise DataError(
            f"lasts {track.duration:.2f} s; the first observation needs {PERIOD:g} s", file=spec
        )
    return observe(track, robot_face)

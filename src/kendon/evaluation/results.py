"""The evaluation as a whole: every reader on every greeting, and the same as plain numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from kendon._version import __version__
from kendon.errors import DataError, ParameterError
from kendon.evaluation import metrics
from kendon.evaluation.comparison import (
    RESAMPLES,
    TEST_SHARE,
    Interval,
    Spread,
    Tally,
    bootstrap,
    tally,
)
from kendon.evaluation.readers import Reader
from kendon.observations import Observations
from kendon.person import FloatArray, IntArray
from kendon.phases import PHASE_NAMES, Phase

#: The number of the layout of `Evaluation.record`; it grows when a program would have to mind.
FORMAT = 1


class Material(NamedTuple):
    """What there is to evaluate on."""

    greetings: tuple[Observations, ...]  # with a true phase at some time
    passersby: tuple[Observations, ...]  # who greet nobody, all the time that is labelled
    unlabelled: tuple[Observations, ...]  # left out


def sort_material(observed: Iterable[Observations]) -> Material:
    """Tell greetings, passers-by and those without labels apart.

    Raises:
        DataError: there is no greeting with true phases.
    """
    greetings: list[Observations] = []
    passersby: list[Observations] = []
    unlabelled: list[Observations] = []
    for one in observed:
        if one.phases is None or (one.phases < 0).all():
            unlabelled.append(one)
        else:
            (greetings if (one.phases > 0).any() else passersby).append(one)
    if not greetings:
        raise DataError(
            "there is no greeting with true phases to evaluate on; tracks and observations carry"
            " them in a column 'phase'"
        )
    return Material(tuple(greetings), tuple(passersby), tuple(unlabelled))


class Delays(NamedTuple):
    """How late the reading followed the entries into one phase."""

    entries: int  # how often the phase was entered
    missed: int  # of these, how often the reading never followed
    median: float  # [s], of those that it followed; NaN if none


@dataclass(frozen=True, eq=False)
class Result:
    """How one reader read everything."""

    name: str
    causal: bool
    readings: tuple[IntArray, ...]  # of each greeting, (T,)
    passing: tuple[IntArray, ...]  # of each passer-by, (T,)
    counts: IntArray  # (6, 6), true phase by phase read, over all greetings
    tally: Tally
    accuracy: Interval
    difference: Interval | None  # to the reference; None for the reference itself
    entries: tuple[metrics.Entry, ...]  # of all greetings
    transitions: metrics.Transitions  # of all greetings
    shares: tuple[FloatArray, ...]  # of each passer-by, (6,)

    @property
    def scores(self) -> metrics.PhaseScores:
        """Recall, precision and F1 of each phase."""
        return metrics.phase_scores(self.counts)

    def delays(self, phase: Phase) -> Delays:
        """How late the reading followed the entries into a phase."""
        all_of_them = [entry.delay for entry in self.entries if entry.phase is phase]
        followed = [delay for delay in all_of_them if math.isfinite(delay)]
        median = float(np.median(followed)) if followed else math.nan
        return Delays(len(all_of_them), len(all_of_them) - len(followed), median)

    @property
    def mean_shares(self) -> FloatArray:
        """The share of passers-by's time in each phase, every passer-by the same weight, (6,)."""
        return np.mean(self.shares, axis=0) if self.shares else np.full(len(Phase), math.nan)

    def ever(self, phase: Phase) -> int:
        """How many passers-by were read to be in a phase at least once."""
        return sum(bool(share[phase.index] > 0) for share in self.shares)


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Every reader on the same greetings; the first is the one the others are compared with."""

    material: Material
    results: tuple[Result, ...]
    seed: int
    command: str = ""  # that makes the same evaluation again
    sensor: str = "clean"
    gestures_from_phases: bool = False
    spreads: Mapping[str, Spread] = field(default_factory=dict)  # by reader, if there were splits

    @property
    def reference(self) -> Result:
        """The reader that the others are compared with."""
        return self.results[0]

    @cached_property
    def observations(self) -> int:
        """How many observations with a true phase there are."""
        return int(self.reference.counts.sum())

    def record(self) -> dict[str, Any]:
        """Everything as numbers, texts and lists for programs; unknown = None."""
        greetings, passersby, unlabelled = self.material
        record: dict[str, Any] = _plain(
            {
                "format": FORMAT,
                "kendon": __version__,
                "command": self.command,
                "settings": {
                    "seed": self.seed,
                    "sensor": self.sensor,
                    "gestures_from_phases": self.gestures_from_phases,
                    "bootstrap_resamples": RESAMPLES,
                    "entry_grace_s": metrics.GRACE,
                    "transition_tolerance_s": metrics.TOLERANCE,
                },
                "data": {
                    "greetings": [_described(one) for one in greetings],
                    "passersby": [_described(one) for one in passersby],
                    "unlabelled": [one.name for one in unlabelled],
                },
                "phases": list(PHASE_NAMES),
                "reference": self.reference.name,
                "readers": [self._reader(result) for result in self.results],
                "splits": self._splits(),
            }
        )
        return record

    def _reader(self, result: Result) -> dict[str, Any]:
        scores = result.scores
        phases = {}
        for phase in Phase:
            delays = result.delays(phase)
            phases[phase.name] = {
                "observations": int(result.counts[phase.index].sum()),
                "recall": scores.recall[phase.index],
                "precision": scores.precision[phase.index],
                "f1": scores.f1[phase.index],
                "entries": delays.entries,
                "entries_missed": delays.missed,
                "median_delay_s": delays.median,
            }
        changes = result.transitions
        passersby = None
        if result.shares:
            passersby = {
                "shares": dict(zip(PHASE_NAMES, result.mean_shares.tolist(), strict=True)),
                "ever_DS": result.ever(Phase.DS),
                "ever_CS": result.ever(Phase.CS),
            }
        return {
            "name": result.name,
            "causal": result.causal,
            "accuracy": result.accuracy._asdict(),
            "difference": result.difference and result.difference._asdict(),
            "macro_f1": scores.macro_f1,
            "phases": phases,
            "confusion": result.counts.tolist(),
            "transitions": {
                "true": changes.true, "read": changes.read, "found": changes.found,
                "recall": changes.recall, "precision": changes.precision,
            },
            "passersby": passersby,
            "greetings": [
                {"name": one.name, "accuracy": result.tally.accuracy([place])}
                for place, one in enumerate(self.material.greetings)
            ],
        }  # fmt: skip

    def _splits(self) -> dict[str, Any] | None:
        if not self.spreads:
            return None
        return {
            "number": len(next(iter(self.spreads.values())).accuracies),
            "test_share": TEST_SHARE,
            "readers": [
                {
                    "name": name,
                    "mean": spread.mean,
                    "deviation": spread.deviation,
                    "accuracies": spread.accuracies.tolist(),
                }
                for name, spread in self.spreads.items()
            ],
        }


def evaluate(
    material: Material,
    readers: Sequence[Reader],
    *,
    seed: int = 0,
    progress: Callable[[], None] | None = None,
) -> Evaluation:
    """Let every reader read everything; the first one is the reference.

    Args:
        material: what to read.
        readers: with different names.
        seed: of the bootstrap.
        progress: called after each reader.

    Raises:
        ParameterError: there is no reader, or two have one name.
    """
    names = [reader.name for reader in readers]
    if not names or len(set(names)) < len(names):
        raise ParameterError(
            f"an evaluation needs readers with different names, not {', '.join(names) or 'none'}"
        )
    results: list[Result] = []
    for reader in readers:
        results.append(_result(reader, material, results[0].tally if results else None, seed))
        if progress:
            progress()
    return Evaluation(material, tuple(results), seed)


def _result(reader: Reader, material: Material, reference: Tally | None, seed: int) -> Result:
    readings = tuple(reader.read(one) for one in material.greetings)
    passing = tuple(reader.read(one) for one in material.passersby)
    counts = np.zeros((len(Phase), len(Phase)), dtype=np.int64)
    pairs, found, changes = [], [], metrics.Transitions()
    for one, read in zip(material.greetings, readings, strict=True):
        truth = _truth(one)
        pairs.append((truth, read))
        counts += metrics.confusion(truth, read)
        found += metrics.entries(one.t, truth, read)
        changes += metrics.transitions(one.t, truth, read)
    right = tally(pairs)
    return Result(
        reader.name,
        reader.causal,
        readings,
        passing,
        counts,
        right,
        bootstrap(right, seed=seed),
        None if reference is None else bootstrap(right, reference, seed=seed),
        tuple(found),
        changes,
        tuple(
            metrics.shares(_truth(one), read)
            for one, read in zip(material.passersby, passing, strict=True)
        ),
    )


def _truth(observations: Observations) -> IntArray:
    if observations.phases is None:
        raise ParameterError(f"{observations.name or 'a greeting'} has no true phases")
    return observations.phases


def _described(one: Observations) -> dict[str, Any]:
    labelled = 0 if one.phases is None else int((one.phases > 0).sum())
    return {"name": one.name, "observations": len(one), "labelled": labelled}


def _plain(value: Any) -> Any:
    """The same in the types of JSON, which has no NaN."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    if isinstance(value, float):  # numpy's too
        return float(value) if math.isfinite(value) else None
    return value

"""Whether one reader is better than another, or only luckier with these greetings.

The observations of one greeting resemble each other, so greetings and not observations are drawn:
the bootstrap draws whole greetings, and a split puts a greeting either here or there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import NamedTuple

import numpy as np

from kendon.errors import KendonError, ParameterError
from kendon.evaluation.readers import Reader
from kendon.observations import Observations
from kendon.person import FloatArray, IntArray
from kendon.processes import each

#: Enough that the ends of an interval move by less than a last printed digit.
RESAMPLES = 10_000
#: The share of the greetings that a split tests on: 8 of 33 in the thesis (3.6.1).
TEST_SHARE = 0.24

#: Makes the readers that learn: from greetings and a seed, as many readers as are to be compared.
Train = Callable[[Sequence[Observations], int], Sequence[Reader]]


class Interval(NamedTuple):
    """A value with its 95 % interval; NaN ends where a single greeting cannot tell."""

    value: float
    low: float
    high: float


class Tally(NamedTuple):
    """What a reader got right, greeting by greeting; G greetings."""

    right: IntArray  # (G,) right phases
    labelled: IntArray  # (G,) of so many observations with a true one

    def accuracy(self, chosen: Sequence[int] | None = None) -> float:
        """The share of right phases over all observations of the chosen greetings, or of all."""
        place = slice(None) if chosen is None else list(chosen)
        total = int(self.labelled[place].sum())
        return int(self.right[place].sum()) / total if total else math.nan


def tally(readings: Sequence[tuple[IntArray, IntArray]]) -> Tally:
    """The right phases of every greeting.

    Args:
        readings: for each greeting the true phases and those read, both (T,).
    """
    right = [int(((truth == read) & (truth > 0)).sum()) for truth, read in readings]
    labelled = [int((truth > 0).sum()) for truth, _ in readings]
    return Tally(np.array(right, dtype=np.int64), np.array(labelled, dtype=np.int64))


def bootstrap(
    first: Tally, second: Tally | None = None, *, seed: int, resamples: int = RESAMPLES
) -> Interval:
    """The accuracy of a reader, or how much it exceeds another's, with its 95 % interval.

    A percentile bootstrap (Efron 1979): greetings are drawn with replacement, the same ones for
    both readers, so that what makes a greeting hard for both cancels out.

    Args:
        first: the reader.
        second: the reader to compare it with, on the same greetings.
        seed: of the draws.
        resamples: how often greetings are drawn.

    Raises:
        ParameterError: the two were not tallied on the same greetings.
    """
    right = first.right.astype(float)
    if second is not None:
        if not np.array_equal(first.labelled, second.labelled):
            raise ParameterError("readers are compared on the same greetings")
        right = right - second.right
    total = int(first.labelled.sum())
    value = float(right.sum()) / total if total else math.nan
    number = len(right)
    if number < 2 or not total:
        return Interval(value, math.nan, math.nan)
    # How often each greeting is drawn is all that matters of a draw.
    draws = np.random.default_rng(seed).multinomial(number, np.full(number, 1 / number), resamples)
    drawn = draws @ first.labelled
    differences = (draws @ right)[drawn > 0] / drawn[drawn > 0]
    low, high = np.quantile(differences, [0.025, 0.975]).tolist()
    return Interval(value, low, high)


class Split(NamedTuple):
    """Which greetings are learned from and which are read, and the seed of the learning."""

    train: tuple[int, ...]
    test: tuple[int, ...]
    seed: int


def random_splits(
    greetings: int, number: int, *, seed: int, test_share: float = TEST_SHARE
) -> list[Split]:
    """Random splits of greetings; each depends on the seed and its own place only.

    Raises:
        ParameterError: there are fewer than two greetings, or no split is asked for, or the
            share is not one.
    """
    if greetings < 2:
        raise ParameterError(
            f"a split needs at least two greetings with true phases, not {greetings}"
        )
    if number < 1:
        raise ParameterError(f"the number of splits must be at least 1, not {number}")
    if not 0 < test_share < 1:
        raise ParameterError(f"the share to test on lies between 0 and 1, not {test_share}")
    tested = min(max(1, round(test_share * greetings)), greetings - 1)
    splits = []
    for source in np.random.SeedSequence(seed).spawn(number):
        draw = np.random.default_rng(source)
        order = draw.permutation(greetings).tolist()
        train, test = sorted(order[tested:]), sorted(order[:tested])
        splits.append(Split(tuple(train), tuple(test), int(draw.integers(2**31))))
    return splits


class Spread(NamedTuple):
    """The accuracies of a reader over splits (thesis table 3.5)."""

    accuracies: FloatArray  # (N,)

    @property
    def mean(self) -> float:
        """Over the splits."""
        return float(self.accuracies.mean())

    @property
    def deviation(self) -> float:
        """The standard deviation of a split's accuracy; NaN for a single split."""
        return float(self.accuracies.std(ddof=1)) if len(self.accuracies) > 1 else math.nan


def repeated_splits(
    greetings: Sequence[Observations],
    splits: Sequence[Split],
    fixed: Mapping[str, Tally],
    train: Train | None = None,
    *,
    n_jobs: int = 1,
    backend: AbstractContextManager[object] | None = None,
    progress: Callable[[], None] | None = None,
) -> dict[str, Spread]:
    """The accuracy of every reader on the test part of every split.

    Args:
        greetings: with true phases.
        splits: of these greetings.
        fixed: what readers that do not learn got right of each greeting, by their names; they
            read a greeting the same whatever the split, so they have read it before.
        train: makes the readers that learn, called once a split; it must be picklable for
            several processes.
        n_jobs: processes on this machine; -1 = one for each core.
        backend: where joblib computes, from `kendon.evaluation.cluster`; this machine if None.
        progress: called after each split.

    Returns:
        The spread of each reader by name: those that learn first.

    Raises:
        ParameterError: a model cannot be trained on a part of the greetings.
    """
    accuracies: dict[str, list[float]] = {}
    if train is not None:
        # A third of a second to import, which whoever compares nothing need not wait for.
        from joblib import parallel_config

        with backend or parallel_config(n_jobs=n_jobs):
            for result in each(_learn_and_test, ((greetings, split, train) for split in splits)):
                for name, accuracy in result:
                    accuracies.setdefault(name, []).append(accuracy)
                if progress:
                    progress()
    for name, right in fixed.items():
        if name in accuracies:
            raise ParameterError(f"two readers are called {name!r}")
        accuracies[name] = [right.accuracy(split.test) for split in splits]
    return {name: Spread(np.array(values)) for name, values in accuracies.items()}


def _learn_and_test(
    greetings: Sequence[Observations], split: Split, train: Train
) -> list[tuple[str, float]]:
    """One split, in a process of its own."""
    try:
        readers = train([greetings[i] for i in split.train], split.seed)
        tested = [greetings[i] for i in split.test]
        results = []
        for reader in readers:
            pairs = [(g.phases, reader.read(g)) for g in tested if g.phases is not None]
            results.append((reader.name, tally(pairs).accuracy()))
        return results
    except KendonError as error:
        # Not every error of kendon's can be sent from process to process; this one can.
        raise ParameterError(str(error)) from None

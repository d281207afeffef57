"""EM itself: iterations from one start, and from many (thesis 2.2, 3.5.3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kendon.errors import ParameterError
from kendon.models.em import Data, Workspace, posterior
from kendon.models.learned_emissions import evaluate, statistics
from kendon.models.prior import Expected, Parameters, Prior

#: Each of many starts is first followed for a few iterations, then only the best of them are
#: followed to the end: starts that will fail show it early (Biernacki et al. 2003, "em-EM").
_TRIAL_ITERATIONS = 15
#: How many of them at least; of more starts the best quarter.
_KEPT = 4


class StartSummary(NamedTuple):
    """How EM went from one start."""

    log_posterior: float  # at the end, or when it was given up for better ones
    iterations: int
    converged: bool


@dataclass(eq=False)
class Run:
    """EM from one start, as far as it has come."""

    number: int
    parameters: Parameters
    expected: Expected | None = None  # under the parameters
    log_posteriors: list[float] = field(default_factory=list)  # the last is the parameters'
    log_likelihoods: list[float] = field(default_factory=list)
    converged: bool = False

    @property
    def iterations(self) -> int:
        """How often the parameters were improved."""
        return len(self.log_posteriors) - 1

    @property
    def summary(self) -> StartSummary:
        """The run in short."""
        return StartSummary(self.log_posteriors[-1], self.iterations, self.converged)


@dataclass(frozen=True, eq=False)
class Search:
    """EM on some data under a prior.

    Args:
        data: what is learned from.
        prior: of the parameters.
        allowed: (K, K), the moves that can be.
        gain: of the log posterior, below which it has converged.
        names: of the sequences, for messages.
        progress: called with the start, the iteration and the log posterior, all along.
    """

    data: Data
    prior: Prior
    allowed: NDArray[np.bool_]
    gain: float
    names: Sequence[str] = ()
    progress: Callable[[int, int, float], None] | None = None
    _workspace: Workspace = field(default_factory=Workspace, repr=False)

    def best(self, runs: Sequence[Run], iterations: int) -> Run:
        """Follow runs; the one that ends with the highest log posterior.

        Raises:
            ParameterError: a sequence's labels cannot happen.
        """
        if len(runs) > _KEPT:
            for run in runs:
                self.follow(run, min(_TRIAL_ITERATIONS, iterations))
            runs = sorted(runs, key=_height, reverse=True)[: max(_KEPT, len(runs) // 4)]
        for run in runs:
            self.follow(run, iterations)
        return max(runs, key=_height)

    def follow(self, run: Run, iterations: int) -> None:
        """Iterate until the run has converged or has made so many iterations.

        Raises:
            ParameterError: a sequence's labels cannot happen.
        """
        while not run.converged and run.iterations < iterations:
            if run.expected is not None:
                run.parameters = self.prior.maximise(
                    run.expected, run.parameters, self.data.center, self.allowed
                )
            run.expected, log_likelihood = expect(
                self.data, run.parameters, self._workspace, self.names
            )
            height = log_likelihood + self.prior.log_density(
                run.parameters, self.data.center, self.allowed
            )
            # Not "less than": two steps down from minus infinity differ by NaN.
            run.converged = bool(run.log_posteriors) and not (
                height - run.log_posteriors[-1] >= self.gain
            )
            run.log_likelihoods.append(log_likelihood)
            run.log_posteriors.append(height)
            if self.progress:
                self.progress(run.number, run.iterations, height)


def _height(run: Run) -> float:
    return run.log_posteriors[-1]


def expect(
    data: Data,
    parameters: Parameters,
    workspace: Workspace | None = None,
    names: Sequence[str] = (),
) -> tuple[Expected, float]:
    """The E-step over all data, and the log-likelihood (thesis 2.13, 2.14, 2.6).

    Args:
        data: of any number of sequences.
        parameters: of K states.
        workspace: whose memory is used.
        names: of the sequences, for messages.

    Raises:
        ParameterError: a sequence's labels cannot happen under the parameters.
    """
    workspace = workspace or Workspace()
    states, features = parameters.means.shape
    starts, moves = np.zeros(states), np.zeros((states, states))
    emissions = np.zeros((states, features, 3))
    total = 0.0
    for chunk in data.chunks:
        evaluated = evaluate(chunk, data.center, parameters, workspace)
        found = posterior(
            parameters.startprob, parameters.transmat, evaluated.log, chunk, workspace
        )
        if not np.isfinite(found.log_likelihoods).all():
            sequence = int(chunk.sequences[np.isfinite(found.log_likelihoods).argmin()])
            name = names[sequence] if names else f"sequence {sequence}"
            raise ParameterError(
                f"{name}: its labels cannot happen with the moves that are possible; allow more,"
                " or give the prior some moves"
            )
        starts += found.states[:, : len(chunk.sequences)].sum(axis=1)
        moves += found.moves
        emissions += statistics(chunk, evaluated, found.states)
        total += float(found.log_likelihoods.sum())
    return Expected(starts, moves, emissions), total

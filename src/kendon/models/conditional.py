"""Learning to tell phases apart: conditional maximum likelihood (Nadas 1983), in two ways.

Counting makes a model that would produce the greetings it has seen, P(o, phases). Where features
are not quite as the model has them (distance is not normal within a phase, the smile of one
moment is that of the last), that is not the model that reads phases best. Here a model is
improved in P(phases | o) instead, the probability of the true phases given what was observed (in
speech recognition: maximum mutual information, Bahl et al. 1986). The gradient is the statistics
of the labelled rows less those that the model expects without the labels (Fisher's identity).

That is how well a whole greeting is read afterwards. A robot reads while it goes on, and has
the filter's beliefs, P(phase_t | o_1..o_t) (`kendon.models.stepwise`). A model is to be good at
both, so that the mean of the two is what rises. In the second a row counts for more the rarer its
phase is: whoever misses a head dip, one row in a hundred, leaves a phase unanswered as much as
whoever misses an approach.

Of people who only pass by it is known that they salute nobody: what rises for them is the
probability of that.

The conditional likelihood alone may end in numbers that nobody recognises a greeting in: it does
not care what a typical final approach is like, only where it begins. A normal prior about the
model to begin with, in a unit of its own for every parameter, keeps them near what they mean.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kendon.models.em import Chunk, Data, Workspace, posterior
from kendon.models.emissions import GESTURES_FROM, Family
from kendon.models.learned_emissions import evaluate, statistics
from kendon.models.prior import Expected, Parameters, Prior
from kendon.models.stepwise import stepwise
from kendon.person import FloatArray
from kendon.phases import SALUTATIONS

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

#: The logarithms of probabilities move no farther than this from where they begin: a move
#: that no training greeting needs would otherwise become impossible.
_FARTHEST = 6.0
#: What no training can change is a probability of 0; allowed moves begin with at least this.
_LEAST_PROBABILITY = 1e-3
#: A row counts as the inverse of its phase's share to this power: more, and rare phases are read
#: too early and left too late; less, and they are missed.
_RARITY = 0.3
#: The label of rows of people who do not greet.
PASSING = -2


class Improvement(NamedTuple):
    """What conditional learning made of a model."""

    parameters: Parameters
    before: float  # the mean of both log P(phases | o) a row, of the model to begin with
    after: float  # of the improved one
    iterations: int


def improve(
    data: Data,
    begin: Parameters,
    prior: Prior,
    allowed: NDArray[np.bool_],
    *,
    iterations: int,
    progress: Callable[[int, float], None] | None = None,
) -> Improvement:
    """Improve a model's conditional likelihood by L-BFGS-B (Liu and Nocedal 1989).

    Args:
        data: greetings with a label on every row, and people who pass by with PASSING.
        begin: the model to improve, in which all that is allowed is `possible`.
        prior: whose tightness, least deviations and certainty of gestures are kept to.
        allowed: (K, K), the moves that can be.
        iterations: at most so many.
        progress: called with the iteration and the mean of both log P(phases | o) a row.
    """
    from scipy.optimize import Bounds, minimize  # half a second: not for those who need none

    ascent = _Ascent(data, begin, prior.tightness, allowed)
    reached: list[float] = []

    def report(intermediate_result: OptimizeResult) -> None:
        reached.append(ascent.conditional)
        if progress:
            progress(len(reached), ascent.conditional)

    start = np.zeros(ascent.layout.size)
    ascent.cost(start)
    before = ascent.conditional
    found = minimize(
        ascent.cost,
        start,
        jac=True,
        method="L-BFGS-B",
        bounds=Bounds(*ascent.layout.bounds(prior)),
        options={"maxiter": iterations},
        callback=report,
    )
    parameters = ascent.layout.parameters(np.asarray(found.x, dtype=float))
    return Improvement(parameters, before, reached[-1] if reached else before, len(reached))


class _Ascent:
    """What is minimised, and its slope.

    Minus the sum of the log prior and the mean of both log P(phases | o), divided by the rows.
    """

    def __init__(
        self, data: Data, begin: Parameters, tightness: float, allowed: NDArray[np.bool_]
    ) -> None:
        self.layout = _Layout(begin, allowed)
        self.conditional = -np.inf  # the mean of both log P(phases | o) a row, at the last call
        self._data, self._tightness = data, tightness
        states = len(allowed)
        self._chunks = [
            (chunk.without_labels(), _truth(chunk, states), weights)
            for chunk, weights in zip(data.chunks, _weights(data, states), strict=True)
        ]
        self._free, self._told = Workspace(), Workspace()

    def cost(self, theta: FloatArray) -> tuple[float, FloatArray]:
        parameters = self.layout.parameters(theta)
        height = 0.0
        starts, moves = np.zeros_like(parameters.startprob), np.zeros_like(parameters.transmat)
        emissions = np.zeros((*parameters.means.shape, 3))
        for chunk, truth, weights in self._chunks:
            evaluated = evaluate(chunk, self._data.center, parameters, self._free)
            model = parameters.startprob, parameters.transmat
            free = posterior(*model, evaluated.log, chunk, self._free)
            told = posterior(*model, np.where(truth, evaluated.log, -np.inf), chunk, self._told)
            filtered = stepwise(*model, evaluated.log, chunk, truth, weights)
            height += float((told.log_likelihoods - free.log_likelihoods).sum())
            height += filtered.log_likelihood
            first = slice(None, len(chunk.sequences))
            starts += filtered.starts + (told.states - free.states)[:, first].sum(axis=1)
            moves += filtered.moves + told.moves - free.moves
            emissions += statistics(chunk, evaluated, filtered.states + told.states - free.states)
        both_rows = 2 * self._data.rows
        self.conditional = height / both_rows
        slope = self.layout.slope(parameters, Expected(starts, moves, emissions), self._data.center)
        tightness = 2 * self._tightness
        cost = 0.5 * tightness * float(theta @ theta) - height
        return cost / both_rows, (tightness * theta - slope) / both_rows


def _truth(chunk: Chunk, states: int) -> NDArray[np.bool_]:
    """Which states each row may truly be in, (K, N)."""
    assert chunk.labels is not None
    number = np.arange(states)[:, None]
    no_salutation = ~np.isin(number + 1, SALUTATIONS)
    return np.asarray(np.where(chunk.labels == PASSING, no_salutation, chunk.labels == number))


def _weights(data: Data, states: int) -> list[FloatArray]:
    """How much each row of each chunk counts: the more the rarer its phase is, 1 in mean.

    Rows of people who pass by count 1.
    """
    labels = [chunk.labels for chunk in data.chunks if chunk.labels is not None]
    counts = sum(np.bincount(of[of >= 0], minlength=states) for of in labels)
    shares = counts / max(np.sum(counts), 1)
    weight = np.divide(1.0, shares**_RARITY, out=np.zeros(states), where=shares > 0)
    weight /= (shares * weight).sum() or 1.0
    return [np.where(of >= 0, weight[of], 1.0) for of in labels]


class _Layout:
    """Parameters as one vector of steps from the model to begin with, each in a unit of its own.

    Of a mean the unit is the deviation, of a deviation a factor of e, of a probability a factor
    of e of it (moves, starts) or of its odds (gestures).
    """

    def __init__(self, begin: Parameters, allowed: NDArray[np.bool_]) -> None:
        self._begin, self._allowed = begin, allowed
        states, features = begin.means.shape
        # Features with a normal distribution come first.
        self._normal = GESTURES_FROM if begin.family is Family.ROBUST else features
        self._shapes = [
            (states, self._normal),  # means
            (states, self._normal),  # deviations
            (states, features - self._normal),  # gestures
            (states, states),  # moves
            (states,),  # starts
        ]
        ends = np.cumsum([int(np.prod(shape)) for shape in self._shapes])
        self._cuts, self.size = ends[:-1], int(ends[-1])

    def _split(self, vector: FloatArray) -> list[FloatArray]:
        """The parts of a vector; views, so that what is written to them is written to it."""
        parts = np.split(vector, self._cuts)
        return [part.reshape(shape) for part, shape in zip(parts, self._shapes, strict=True)]

    def parameters(self, theta: FloatArray) -> Parameters:
        shift, stretch, odds, moves, starts = self._split(theta)
        old, normal, hands = self._begin, slice(0, self._normal), slice(self._normal, None)
        means, variances = old.means.copy(), old.variances.copy()
        means[:, normal] += shift * np.sqrt(old.variances[:, normal])
        variances[:, normal] *= np.exp(2 * stretch)
        if odds.size:
            q = 1 / (1 + np.exp(-_log_odds(old.means[:, hands]) - odds))
            means[:, hands], variances[:, hands] = q, q * (1 - q)
        return old._replace(
            startprob=_tilted(old.startprob, starts),
            transmat=_tilted(old.transmat, moves),
            means=means,
            variances=variances,
        )

    def slope(self, parameters: Parameters, expected: Expected, center: FloatArray) -> FloatArray:
        """The gradient of the expected joint log-likelihood with these statistics, (size,)."""
        normal, hands = slice(0, self._normal), slice(self._normal, None)
        weight, total, squares = np.moveaxis(expected.emissions, 2, 0)
        w, s, ss = weight[:, normal], total[:, normal], squares[:, normal]
        m, v = (parameters.means - center)[:, normal], parameters.variances[:, normal]
        parts = (
            (s - w * m) / v * np.sqrt(self._begin.variances[:, normal]),
            (ss - 2 * m * s + w * m * m) / v - w,
            total[:, hands] - weight[:, hands] * parameters.means[:, hands],
            expected.moves - parameters.transmat * expected.moves.sum(axis=1, keepdims=True),
            expected.starts - parameters.startprob * expected.starts.sum(),
        )
        return np.concatenate([part.ravel() for part in parts])

    def bounds(self, prior: Prior) -> tuple[FloatArray, FloatArray]:
        """The lowest and the highest steps: no deviation below the least, no gesture too sure."""
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        _, stretch, odds, moves, starts = self._split(low)
        _, _, odds_high, moves_high, starts_high = self._split(high)
        variances = self._begin.variances[:, : self._normal]
        least = np.log(np.maximum(prior.least, 1e-6))[: self._normal]
        stretch[:] = np.minimum(least - 0.5 * np.log(variances), 0.0)
        now = _log_odds(self._begin.means[:, self._normal :]) if odds.size else 0.0
        surest = _log_odds(np.array(min(prior.certainty, 1 - 1e-9)))
        odds[:], odds_high[:] = np.minimum(-surest - now, 0.0), np.maximum(surest - now, 0.0)
        moves[:], moves_high[:] = -_FARTHEST * self._allowed, _FARTHEST * self._allowed
        starts[:], starts_high[:] = -_FARTHEST, _FARTHEST
        return low, high


def possible(parameters: Parameters, allowed: NDArray[np.bool_]) -> Parameters:
    """The same parameters, with no probability of 0 but those of moves that are not allowed."""
    return parameters._replace(
        startprob=_at_least(parameters.startprob, np.ones(len(allowed), dtype=bool)),
        transmat=_at_least(parameters.transmat, allowed),
    )


def _at_least(p: FloatArray, allowed: NDArray[np.bool_]) -> FloatArray:
    raised = np.where(allowed, np.maximum(p, _LEAST_PROBABILITY), p)
    return np.asarray(raised / raised.sum(axis=-1, keepdims=True))


def _log_odds(p: FloatArray) -> FloatArray:
    return np.asarray(np.log(p) - np.log1p(-p))


def _tilted(p: FloatArray, by: FloatArray) -> FloatArray:
    """Probabilities whose logarithms are moved, and which sum to one again."""
    tilted = p * np.exp(by - by.max(axis=-1, keepdims=True))
    return np.asarray(tilted / tilted.sum(axis=-1, keepdims=True))

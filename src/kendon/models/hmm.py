"""Hidden Markov models with Gaussian emissions: pure functions on arrays (thesis 2.2, 3.6.1).

K states, T steps, F features. Everything is carried as logarithms, so that nothing underflows
however unlikely an observation is and however long a state has been out of favour: a state that
lost by a factor of 1e-400 can still win later. The floor of 1e-100 in Algorithm 1, which serves
the same purpose for a single step, is not needed. A feature that is NaN is unknown and
marginalised: it drops out of the product of Algorithm 1, line 6.

The online step is the same two functions as the batch filter: `predict`, then `condition`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kendon.person import FloatArray, IntArray

_LOG_2PI = math.log(2 * math.pi)


class Filtered(NamedTuple):
    """What the forward pass knows; each field is one probability."""

    probabilities: FloatArray  # (T, K), P(state_t | o_1..o_t)
    predicted: FloatArray  # (T, K), P(state_t | o_1..o_{t-1})
    log_likelihood: float  # log P(o_1..o_T)


class Emission(NamedTuple):
    """Gaussians with diagonal covariance, prepared for evaluation at single observations."""

    means: FloatArray  # (K, F)
    precision: FloatArray  # (K, F), minus one over twice the variance
    log_norm: FloatArray  # (K, F), log of the density's factor
    log_norms: FloatArray  # (K,), its sum over the features
    ones: FloatArray  # (F,)

    @classmethod
    def of(cls, means: FloatArray, variances: FloatArray) -> Emission:
        """Prepare means and variances, both (K, F)."""
        log_norm = -0.5 * (_LOG_2PI + np.log(variances))
        return cls(means, -0.5 / variances, log_norm, log_norm.sum(axis=1), np.ones(means.shape[1]))

    def log_likelihood(self, x: FloatArray) -> FloatArray:
        """Log P(x | state) over the known features of x (F,), shape (K,)."""
        terms = x - self.means
        terms *= terms
        terms *= self.precision
        if math.isfinite(x.dot(x)):  # nothing unknown: one product over the features
            return np.asarray(terms.dot(self.ones) + self.log_norms)
        terms += self.log_norm
        return np.asarray(np.where(x == x, terms, 0.0).dot(self.ones))  # NaN is unequal to itself


def log_emissions(X: FloatArray, means: FloatArray, variances: FloatArray) -> FloatArray:
    """Log P(x_t | state) of every step over its known features, shape (T, K).

    Args:
        X: observations, (T, F), NaN = unknown.
        means: (K, F).
        variances: (K, F), positive.
    """
    # Row by row, as the tracker does, so that both give the same numbers to the last bit.
    emission = Emission.of(means, variances)
    return np.array([emission.log_likelihood(x) for x in X]).reshape(len(X), len(means))


def predict(log_belief: FloatArray, log_transmat: FloatArray) -> FloatArray:
    """Log P(state_t | o_1..o_{t-1}), shape (K,).

    Args:
        log_belief: log P(state_{t-1} | o_1..o_{t-1}), (K,); -inf = impossible.
        log_transmat: (K, K), from row to column; -inf = impossible.
    """
    return np.asarray(np.logaddexp.reduce(log_belief[:, None] + log_transmat, axis=0))


def condition(log_predicted: FloatArray, log_emission: FloatArray) -> tuple[FloatArray, float]:
    """Log P(state_t | o_1..o_t), shape (K,), and log P(o_t | o_1..o_{t-1}).

    Args:
        log_predicted: log P(state_t | o_1..o_{t-1}), (K,); -inf = impossible.
        log_emission: log P(o_t | state), (K,), finite.
    """
    joint = log_predicted + log_emission
    # Six states are too few for array arithmetic to pay: this is the hot path of the tracker.
    values = joint.tolist()
    scale = max(values)
    # Subtracted one after the other: both stay exact where the states that matter are.
    rest = math.log(sum([math.exp(value - scale) for value in values]))
    return joint - scale - rest, scale + rest


def forward(startprob: FloatArray, transmat: FloatArray, log_emission: FloatArray) -> Filtered:
    """The forward algorithm, normalised at each step (thesis 2.4-2.6, Algorithm 1).

    Args:
        startprob: (K,).
        transmat: (K, K), rows sum to one.
        log_emission: (T, K).
    """
    log_beliefs = np.empty_like(log_emission)
    log_predicted = np.empty_like(log_emission)
    log_likelihood = 0.0
    prediction, log_transmat = log_probabilities(startprob), log_probabilities(transmat)
    for t, row in enumerate(log_emission):
        log_predicted[t] = prediction
        log_beliefs[t], gain = condition(prediction, row)
        log_likelihood += gain
        prediction = predict(log_beliefs[t], log_transmat)
    return Filtered(np.exp(log_beliefs), np.exp(log_predicted), log_likelihood)


def log_probabilities(probabilities: FloatArray) -> FloatArray:
    """Logarithms of probabilities of any shape; -inf where a state or move is impossible."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(probabilities))


def viterbi(
    startprob: FloatArray, transmat: FloatArray, log_emission: FloatArray
) -> tuple[IntArray, float]:
    """The most probable path and its log P(path, o_1..o_T) (thesis 2.7-2.12).

    Returns:
        States 0..K-1, shape (T,), and the logarithm of the joint probability.
    """
    log_moves = log_probabilities(transmat)
    steps = len(log_emission)
    best = log_probabilities(startprob) + log_emission[0]
    came_from = np.zeros(log_emission.shape, dtype=np.int64)
    for t in range(1, steps):
        scores = best[:, None] + log_moves
        came_from[t] = scores.argmax(axis=0)
        best = scores.max(axis=0) + log_emission[t]
    path = np.empty(steps, dtype=np.int64)
    path[-1] = best.argmax()
    for t in range(steps - 1, 0, -1):
        path[t - 1] = came_from[t, path[t]]
    return path, float(best.max())

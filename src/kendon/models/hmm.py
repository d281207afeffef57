"""Hidden Markov models with Gaussian emissions: pure functions on arrays (thesis 2.2, 3.6.1).

K states, T steps, F features. Everything is computed with logarithms of the emissions scaled
by their largest, so that nothing underflows however unlikely an observation is; the floor of
1e-100 in Algorithm 1, which serves the same purpose, is not needed. A feature that is NaN is
unknown and marginalised: it drops out of the product of Algorithm 1, line 6.

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
    terms = (X[:, None, :] - means) ** 2 / variances + np.log(variances) + _LOG_2PI
    return np.asarray(-0.5 * np.where(np.isnan(X)[:, None, :], 0.0, terms).sum(axis=2))


def predict(belief: FloatArray, transmat: FloatArray) -> FloatArray:
    """P(state_t | o_1..o_{t-1}) from the belief at t-1; both shape (K,)."""
    return np.asarray(belief.dot(transmat))


def condition(predicted: FloatArray, log_emission: FloatArray) -> tuple[FloatArray, float]:
    """P(state_t | o_1..o_t) from the prediction, and log P(o_t | o_1..o_{t-1}).

    Args:
        predicted: (K,), sums to one.
        log_emission: log P(o_t | state), (K,).
    """
    # Six states are too few for array arithmetic to pay: this is the hot path of the tracker.
    pairs = list(zip(predicted.tolist(), log_emission.tolist(), strict=True))
    # Scaled by the best state that is possible at all: the total cannot become zero.
    scale = max(log for probability, log in pairs if probability > 0)
    joint = [
        probability * math.exp(log - scale) if probability > 0 else 0.0
        for probability, log in pairs
    ]
    total = sum(joint)
    return np.array([value / total for value in joint]), scale + math.log(total)


def forward(startprob: FloatArray, transmat: FloatArray, log_emission: FloatArray) -> Filtered:
    """The forward algorithm, normalised at each step (thesis 2.4-2.6, Algorithm 1).

    Args:
        startprob: (K,).
        transmat: (K, K), rows sum to one.
        log_emission: (T, K).
    """
    probabilities = np.empty_like(log_emission)
    predicted = np.empty_like(log_emission)
    log_likelihood = 0.0
    prediction = startprob
    for t, row in enumerate(log_emission):
        predicted[t] = prediction
        probabilities[t], gain = condition(prediction, row)
        log_likelihood += gain
        prediction = predict(probabilities[t], transmat)
    return Filtered(probabilities, predicted, log_likelihood)


def viterbi(
    startprob: FloatArray, transmat: FloatArray, log_emission: FloatArray
) -> tuple[IntArray, float]:
    """The most probable path and its log P(path, o_1..o_T) (thesis 2.7-2.12).

    Returns:
        States 0..K-1, shape (T,), and the logarithm of the joint probability.
    """
    with np.errstate(divide="ignore"):  # impossible moves are -inf
        log_start, log_moves = np.log(startprob), np.log(transmat)
    steps = len(log_emission)
    best = log_start + log_emission[0]
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

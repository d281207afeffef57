"""The emissions' part of EM: densities of many rows, sufficient statistics.

The densities are those of `kendon.models.emissions`, for many rows at once. Unknown values drop
out of densities and statistics alike, which is what marginalising them exactly comes to when
features are independent given the state.

The robust family is a mixture in every feature: of the normal distribution and of a value from
nowhere, of a gesture that is there and one that is not. Which of the two a value belongs to is
hidden as the state is, so that its statistics are weighted with the probability of the first:
EM for both at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kendon.models.em import Chunk, Workspace
from kendon.models.emissions import GESTURES_FROM, RANGES, Family
from kendon.models.prior import Parameters
from kendon.observations import GESTURE_RATES
from kendon.person import FloatArray


@dataclass(frozen=True, eq=False)
class Evaluated:
    """The densities of a chunk's rows, and what its statistics need of them again."""

    log: FloatArray  # (K, N), log P(row | state) over the known features
    first: dict[int, FloatArray]  # robust: by feature, (K, N), P(the first part of the mixture)


def evaluate(
    chunk: Chunk, center: FloatArray, parameters: Parameters, workspace: Workspace | None = None
) -> Evaluated:
    """The densities of every row in every state.

    Args:
        chunk: N rows.
        center: (F,), what was taken off the rows.
        parameters: of the states.
        workspace: whose memory is used, for the result as well: valid until the next call.
    """
    if parameters.family is Family.ROBUST:
        return _evaluate_robust(chunk, center, parameters)
    workspace = workspace or Workspace()
    means, precisions = parameters.means - center, 1 / parameters.variances
    constants = -0.5 * (np.log(2 * math.pi * parameters.variances) + means * means * precisions)
    # (x - m)^2 / v, multiplied out: a matrix product instead of K F passes over the rows.
    weights = np.concatenate([means * precisions, -0.5 * precisions], axis=1)
    log = workspace.array("log", len(means), chunk.values.shape[1])
    np.matmul(weights, chunk.values, out=log)
    if chunk.known is None:
        log += constants.sum(axis=1, keepdims=True)
    else:
        log += constants @ chunk.known
    return Evaluated(log, {})


def _evaluate_robust(chunk: Chunk, center: FloatArray, parameters: Parameters) -> Evaluated:
    log = np.zeros((len(parameters.means), chunk.values.shape[1]))
    first: dict[int, FloatArray] = {}
    share = parameters.outliers
    for f in range(len(center)):
        mean, variance = parameters.means[:, f, None], parameters.variances[:, f, None]
        if f < GESTURES_FROM:
            exponent = chunk.values[f] - (mean - center[f])
            exponent *= exponent
            exponent *= -0.5 / variance
            height = (1 - share) / np.sqrt(2 * math.pi * variance)
            if share:
                part = height * np.exp(exponent)
                density = part + share / RANGES[f]
                part /= density
                first[f], term = part, np.log(density)
            else:
                term = exponent + np.log(height)
        else:
            value = chunk.values[f] + center[f]
            rate = GESTURE_RATES[f - GESTURES_FROM]
            part = mean * value / rate
            density = part + (1 - mean) * (1 - value) / (1 - rate)
            part /= density
            first[f], term = part, np.log(density)
        if chunk.known is not None:
            term *= chunk.known[f]
        log += term
    return Evaluated(log, first)


def statistics(chunk: Chunk, evaluated: Evaluated, states: FloatArray) -> FloatArray:
    """Sufficient statistics of the emissions, (K, F, 3).

    Of a feature with a normal distribution: the weight of its values, their sum, the sum of their
    squares (both centred). Of a robust gesture: the weight, that of the gesture being there, 0.

    Args:
        chunk: N rows.
        evaluated: their densities.
        states: (K, N), posterior probabilities.
    """
    features = len(chunk.values) // 2
    result = np.empty((len(states), features, 3))
    if chunk.known is None:
        result[:, :, 0] = states.sum(axis=1, keepdims=True)
    else:
        result[:, :, 0] = states @ chunk.known.T
    sums = states @ chunk.values.T
    result[:, :, 1], result[:, :, 2] = sums[:, :features], sums[:, features:]
    for f, first in evaluated.first.items():
        weights = states * first
        if chunk.known is not None:
            weights *= chunk.known[f]
        if f < GESTURES_FROM:
            result[:, f, 0] = weights.sum(axis=1)
            result[:, f, 1] = weights @ chunk.values[f]
            result[:, f, 2] = weights @ chunk.values[features + f]
        else:
            result[:, f, 1] = weights.sum(axis=1)
            result[:, f, 2] = 0.0
    return result

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

from kendon.models.em import Chunk
from kendon.models.emissions import GESTURES_FROM, RANGES, Family
from kendon.models.prior import Parameters
from kendon.person import FloatArray

@dataclass(frozen=True, eq=False)
class Evaluated:
    """The densities of a chunk's rows, and what its statistics need of them again."""

    log: FloatArray  # (K, N), log P(row | state) over the known features
    squares: FloatArray  # (F, N), of the centred values
    first: dict[int, FloatArray]  # robust: by feature, (K, N), P(the first part of the mixture)


def evaluate(chunk: Chunk, center: FloatArray, parameters: Parameters) -> Evaluated:
    """The densities of every row in every state.

    Args:
        chunk: N rows.
        center: (F,), what was taken off the rows.
        parameters: of the states.
    """
    if parameters.family is Family.ROBUST:
        return _evaluate_robust(chunk, center, parameters)
    squares = np.square(chunk.x)
    means, precisions = parameters.means - center, 1 / parameters.variances
    constants = -0.5 * (np.log(2 * math.pi * parameters.variances) + means * means * precisions)
    # (x - m)^2 / v, multiplied out: two matrix products instead of K F passes over the rows.
    log = (means * precisions) @ chunk.x
    log += (-0.5 * precisions) @ squares
    if chunk.known is None:
        log += constants.sum(axis=1, keepdims=True)
    else:
        log += constants @ chunk.known
    return Evaluated(log, squares, {})


def _evaluate_robust(chunk: Chunk, center: FloatArray, parameters: Parameters) -> Evaluated:
    log = np.zeros((len(parameters.means), chunk.x.shape[1]))
    first: dict[int, FloatArray] = {}
    share = parameters.outliers
    for f in range(len(center)):
        mean, variance = parameters.means[:, f, None], parameters.variances[:, f, None]
        if f < GESTURES_FROM:
            exponent = chunk.x[f] - (mean - center[f])
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
            value = chunk.x[f] + center[f]
            part = mean * value
            density = part + (1 - mean) * (1 - value)
            part /= density
            first[f], term = part, np.log(density)
        if chunk.known is not None:
            term *= chunk.known[f]
        log += term
    return Evaluated(log, np.square(chunk.x), first)


def statistics(chunk: Chunk, evaluated: Evaluated, states: FloatArray) -> FloatArray:
    """Sufficient statistics of the emissions, (K, F, 3).

    Of a feature with a normal distribution: the weight of its values, their sum, the sum of their
    squares (both centred). Of a robust gesture: the weight, that of the gesture being there, 0.

    Args:
        chunk: N rows.
        evaluated: their densities.
        states: (K, N), posterior probabilities.
    """
    result = np.zeros((len(states), len(chunk.x), 3))
    if chunk.known is None:
        result[:, :, 0] = states.sum(axis=1, keepdims=True)
    else:
        result[:, :, 0] = states @ chunk.known.T
    result[:, :, 1] = states @ chunk.x.T
    result[:, :, 2] = states @ evaluated.squares.T
    for f, first in evaluated.first.items():
        weights = states * first
        if chunk.known is not None:
            weights *= chunk.known[f]
        if f < GESTURES_FROM:
            result[:, f, 0] = weights.sum(axis=1)
            result[:, f, 1] = weights @ chunk.x[f]
            result[:, f, 2] = weights @ evaluated.squares[f]
        else:
            result[:, f, 1] = weights.sum(axis=1)
            result[:, f, 2] = 0.0
    return result

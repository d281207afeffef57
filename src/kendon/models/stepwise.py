"""How sure a model is of the true phases while a greeting goes on, and the slope of that.

The filter (Algorithm 1) tells the phase of now from what has been seen up to now. How well it
does so is the sum of log P(phase_t | o_1..o_t) over all rows: the logarithmic score of each of
its beliefs. Beliefs that are sure too early, because the same hint is counted five times a
second, cost most.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kendon.models.em import Chunk
from kendon.person import FloatArray

#: A probability below this counts as this: its logarithm stays finite.
_LEAST = 1e-300


class Stepwise(NamedTuple):
    """The filter's score on a chunk, and its slope along the model's logarithms.

    The slopes are what expected counts are in EM, and may be negative.
    """

    log_likelihood: float  # the weighted sum of log P(true phase_t | o_1..o_t)
    starts: FloatArray  # (K,), along log P(first state)
    moves: FloatArray  # (K, K), along log P(move from row to column)
    states: FloatArray  # (K, N), along log P(row | state)


def stepwise(
    startprob: FloatArray,
    transmat: FloatArray,
    log_emission: FloatArray,
    chunk: Chunk,
    truth: NDArray[np.bool_],
    weights: FloatArray,
) -> Stepwise:
    """The filter's score on rows of which the true state is known, or some that it is among.

    Args:
        startprob: (K,).
        transmat: (K, K), from row to column.
        log_emission: (K, N), log P(row | state).
        chunk: how the N rows are packed.
        truth: (K, N), the states each row may truly be in, at least one.
        weights: (N,), how much each row counts.
    """
    blocks = chunk.blocks()
    before = np.empty_like(log_emission)  # P(state_t | o_1..o_t-1)
    belief = np.empty_like(log_emission)  # P(state_t | o_1..o_t)
    for t, (a, b) in enumerate(blocks):
        if t:
            last = blocks[t - 1][0]
            before[:, a:b] = transmat.T @ belief[:, last : last + b - a]
        else:
            before[:, a:b] = startprob[:, None]
        with np.errstate(divide="ignore"):
            log = np.log(before[:, a:b]) + log_emission[:, a:b]
        now = np.exp(log - log.max(axis=0))
        belief[:, a:b] = now / now.sum(axis=0)
    right = np.where(truth, belief, 0.0)
    sure = np.maximum(right.sum(axis=0), _LEAST)
    score = float(weights @ np.log(sure))

    # Backward: a belief is a normalised product, so that the slope along the logarithm of each
    # factor is what the rows ahead make of this belief, less its mean, and the own row's part.
    slope = weights * (right / sure - belief)
    moves = np.zeros_like(transmat)
    ahead = np.empty((len(transmat), 0))  # along the beliefs of the time step
    for t in range(len(blocks) - 1, -1, -1):
        a, b = blocks[t]
        own = belief[:, a : a + ahead.shape[1]]
        slope[:, a : a + ahead.shape[1]] += own * (ahead - (own * ahead).sum(axis=0))
        if t:
            last = blocks[t - 1][0]
            share = np.zeros((len(transmat), b - a))
            np.divide(slope[:, a:b], before[:, a:b], out=share, where=before[:, a:b] > _LEAST)
            moves += belief[:, last : last + b - a] @ share.T
            ahead = transmat @ share
    return Stepwise(score, slope[:, : blocks[0][1]].sum(axis=1), moves * transmat, slope)

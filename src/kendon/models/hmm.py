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

#: Above this a sum of products of probabilities has lost nothing to underflow that matters: what
#: vanished is smaller than 1e-307.
_SAFE = 1e-290


class Filtered(NamedTuple):
    """What the forward pass knows; each field is one probability."""

    probabilities: FloatArray  # (T, K), P(state_t | o_1..o_t)
    predicted: FloatArray  # (T, K), P(state_t | o_1..o_{t-1})
    log_likelihood: float  # log P(o_1..o_T)


class Transitions(NamedTuple):
    """Transition probabilities, prepared for `predict`."""

    #: Into each state: from where, the probability, its logarithm; impossible moves are left out.
    moves: tuple[tuple[tuple[int, float, float], ...], ...]

    @classmethod
    def of(cls, transmat: FloatArray) -> Transitions:
        """Prepare a transition matrix, (K, K), from row to column, rows sum to one."""
        return cls(
            tuple(
                tuple((i, p, math.log(p)) for i, p in enumerate(column) if p > 0)
                for column in transmat.T.tolist()
            )
        )


# The two functions of a step work on lists: six states are too few for array arithmetic to pay,
# and the tracker spends its time here.


def predict(log_belief: list[float], transitions: Transitions) -> list[float]:
    """Log P(state_t | o_1..o_{t-1}) of each of the K states.

    Args:
        log_belief: log P(state_{t-1} | o_1..o_{t-1}); -inf = impossible.
        transitions: of the model.
    """
    belief = [math.exp(log) for log in log_belief]
    prediction = []
    for moves in transitions.moves:
        total = 0.0
        for i, p, _ in moves:
            total += belief[i] * p
        if total > _SAFE:
            prediction.append(math.log(total))
        else:
            prediction.append(_log_sum([log_belief[i] + log for i, _, log in moves]))
    return prediction


def condition(log_predicted: list[float], log_emission: list[float]) -> tuple[list[float], float]:
    """Log P(state_t | o_1..o_t) of each of the K states, and log P(o_t | o_1..o_{t-1}).

    Args:
        log_predicted: log P(state_t | o_1..o_{t-1}); -inf = impossible.
        log_emission: log P(o_t | state), finite.
    """
    joint = [p + e for p, e in zip(log_predicted, log_emission, strict=True)]
    scale = max(joint)
    rest = math.log(sum([math.exp(log - scale) for log in joint]))
    # Subtracted one after the other: both stay exact where the states that matter are.
    return [log - scale - rest for log in joint], scale + rest


def _log_sum(logs: list[float]) -> float:
    """The logarithm of a sum of numbers given by their logarithms."""
    largest = max(logs, default=-math.inf)
    if largest == -math.inf:
        return largest
    return largest + math.log(sum([math.exp(log - largest) for log in logs]))


def forward(startprob: FloatArray, transmat: FloatArray, log_emission: FloatArray) -> Filtered:
    """The forward algorithm, normalised at each step (thesis 2.4-2.6, Algorithm 1).

    Args:
        startprob: (K,).
        transmat: (K, K), rows sum to one.
        log_emission: (T, K).
    """
    beliefs, predictions = [], []
    log_likelihood = 0.0
    prediction, transitions = log_probabilities(startprob).tolist(), Transitions.of(transmat)
    for row in log_emission.tolist():
        belief, gain = condition(prediction, row)
        beliefs.append(belief)
        predictions.append(prediction)
        log_likelihood += gain
        prediction = predict(belief, transitions)
    return Filtered(np.exp(beliefs), np.exp(predictions), log_likelihood)


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

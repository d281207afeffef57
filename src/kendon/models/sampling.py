"""Greetings drawn from a model: what it believes greetings to look like."""

from __future__ import annotations

import numpy as np

from kendon.errors import ParameterError
from kendon.models.emissions import GESTURES_FROM, RANGES, Family
from kendon.models.greeting import GreetingModel
from kendon.observations import Observations
from kendon.person import FloatArray, IntArray

#: Seconds from one observation to the next (thesis 3.3).
_PERIOD = 0.2
#: Where the values from nowhere begin; how far they reach says `RANGES`.
_LOWEST = (0.0, -2.0, 0.0, 0.0)


def sample(model: GreetingModel, lengths: list[int], seed: int = 0) -> list[Observations]:
    """Greetings as the model has them, with their true phases.

    The values are the model's, not the world's: a Gaussian smile may fall below 0. Gestures of
    the robust family are keys, 0 or 1.

    Args:
        model: to draw from.
        lengths: rows of each greeting.
        seed: of the chance.

    Raises:
        ParameterError: a length is not positive.
    """
    if any(length < 1 for length in lengths):
        raise ParameterError("a greeting has at least one row")
    if not lengths:
        return []
    rng = np.random.default_rng(seed)
    count, longest = len(lengths), max(lengths)
    states = np.empty((count, longest), dtype=np.int64)
    moves = model.transmat.cumsum(axis=1)
    states[:, 0] = _draw(model.startprob.cumsum(), rng.random(count))
    for t in range(1, longest):
        states[:, t] = _draw(moves[states[:, t - 1]], rng.random(count))
    values: FloatArray = np.sqrt(model.variances)[states]
    values *= rng.standard_normal(values.shape)
    values += model.means[states]
    if model.family is Family.ROBUST:
        nowhere = rng.random((*states.shape, GESTURES_FROM)) < model.outliers
        anything = rng.uniform(_LOWEST, np.add(_LOWEST, RANGES), nowhere.shape)
        values[:, :, :GESTURES_FROM][nowhere] = anything[nowhere]
        gestures = model.means[states][:, :, GESTURES_FROM:]
        values[:, :, GESTURES_FROM:] = rng.random(gestures.shape) < gestures
    return [
        Observations(
            _PERIOD * np.arange(1, length + 1, dtype=np.float64),
            values[i, :length],
            states[i, :length] + 1,
            f"{model.name}-{i + 1}",
        )
        for i, length in enumerate(lengths)
    ]


def _draw(cumulated: FloatArray, chance: FloatArray) -> IntArray:
    """The state whose share of 0 to 1 the chance falls into, (N,)."""
    drawn = (chance[:, None] >= cumulated).sum(axis=-1)
    return np.asarray(np.minimum(drawn, cumulated.shape[-1] - 1))

"""Where EM starts: from labels as far as there are any, from chance for the rest.

Chance is k-means++ (Arthur and Vassilvitskii 2007), every feature in units of its spread: states
without a label begin as clusters of rows, each around a row far from the others'. k-means++ takes
a row with a chance that grows with the square of its distance; here it is a higher power, as the
phases are of very different lengths. A head dip is one row in a hundred, and with squares most
starts would never begin with one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kendon.models.em import FREE, Data
from kendon.models.emissions import GESTURES_FROM, Family
from kendon.models.prior import Expected, Parameters, Prior
from kendon.person import FloatArray, IntArray

#: Rows that the chance of a start is drawn from: enough to meet the rarest phase many times.
_SAMPLE = 20_000
#: The powers of the squared distance, one of which each start draws: the lower meets clusters that
#: differ in many features a little, the higher rare ones that differ a lot.
_POWERS = (2, 4)
#: Rounds of k-means before EM takes over.
_ROUNDS = 5
#: How many moves a random row of the transition matrix counts for beside labelled ones.
_RANDOM_MOVES = 5.0


def count_labels(labels: Sequence[IntArray], states: int) -> tuple[FloatArray, FloatArray]:
    """Labelled beginnings, (K,), and moves between two labelled rows, (K, K).

    Args:
        labels: (T,) each, the state or FREE.
        states: how many there are.
    """
    first = np.array([sequence[0] for sequence in labels])
    rows = np.concatenate(labels)
    same = np.ones(len(rows) - 1, dtype=bool)  # both in one sequence
    same[np.cumsum([len(sequence) for sequence in labels])[:-1] - 1] = False
    here, there = rows[:-1], rows[1:]
    both = same & (here != FREE) & (there != FREE)
    moves = np.zeros((states, states))
    np.add.at(moves, (here[both], there[both]), 1.0)
    return np.bincount(first[first != FREE], minlength=states).astype(float), moves


def start(
    data: Data,
    labels: Sequence[IntArray],
    prior: Prior,
    allowed: NDArray[np.bool_],
    family: Family,
    outliers: float,
    rng: np.random.Generator,
) -> Parameters:
    """Parameters to start from; all labelled, there is no chance in them.

    Args:
        data: what is learned from.
        labels: of its sequences, (T,) each.
        prior: of the parameters.
        allowed: (K, K), the moves that can be.
        family: of emissions.
        outliers: probability of a value from nowhere, robust only.
        rng: the chance.
    """
    states = len(allowed)
    emissions = np.zeros((states, len(data.center), 3))
    for chunk in data.chunks:
        if chunk.labels is not None:
            members = (chunk.labels == np.arange(states)[:, None]).astype(float)
            emissions += _statistics(chunk.values, chunk.known, members)
    starts, moves = count_labels(labels, states)
    moves = moves * allowed
    labelled = emissions[:, :, 0].sum(axis=1) > 0
    for chunk in data.chunks:  # a labelled row may be unknown in all its features
        if chunk.labels is not None:
            labelled[np.unique(chunk.labels[chunk.labels != FREE])] = True
    free = any(chunk.labels is None or (chunk.labels == FREE).any() for chunk in data.chunks)
    if free and not labelled.all():
        emissions += _random_statistics(data, emissions, labelled, rng)
    if free:
        chance = 0.5 * np.eye(states) + 0.5 * rng.dirichlet(np.ones(states), states)
        moves = moves + _RANDOM_MOVES * chance * allowed
        starts = starts + rng.dirichlet(np.ones(states))
    if family is Family.ROBUST:  # a gesture's value is how much of it is there
        hands = slice(GESTURES_FROM, None)
        emissions[:, hands, 1] += data.center[hands] * emissions[:, hands, 0]
    scatter = _scatter(data)
    old = Parameters(
        np.full(states, 1 / states),
        allowed / allowed.sum(axis=1, keepdims=True),
        np.tile(data.center, (states, 1)),
        np.tile(np.maximum(scatter, np.square(prior.least) + 1e-12), (states, 1)),
        family,
        outliers,
    )
    if family is Family.ROBUST:
        hands = slice(GESTURES_FROM, None)
        old.means[:, hands] = old.means[:, hands].clip(0.01, 0.99)
    return prior.maximise(Expected(starts, moves, emissions), old, data.center, allowed)


def _statistics(values: FloatArray, known: FloatArray | None, members: FloatArray) -> FloatArray:
    """Weights, sums and sums of squares, (K, F, 3), of rows that belong to states, (K, N)."""
    features = len(values) // 2
    sums = members @ values.T
    weights = (
        np.tile(members.sum(axis=1, keepdims=True), (1, features))
        if known is None
        else members @ known.T
    )
    return np.stack([weights, sums[:, :features], sums[:, features:]], axis=2)


def _random_statistics(
    data: Data, emissions: FloatArray, labelled: NDArray[np.bool_], rng: np.random.Generator
) -> FloatArray:
    """Statistics of the states without labels, from rows around random ones of them."""
    values, known = _sample(data, rng)
    features = len(data.center)
    unit = np.sqrt(np.maximum(_scatter(data), 1e-12))[:, None]
    x = values[:features] / unit

    def distance(center: FloatArray) -> FloatArray:
        # Over the features that both know; a row that knows fewer is not nearer for that.
        shared = known * ~np.isnan(center)[:, None]
        squares = np.square(x - np.nan_to_num(center)[:, None]) * shared
        return np.asarray(squares.sum(axis=0) * features / np.maximum(shared.sum(axis=0), 1))

    def means(statistics: FloatArray) -> FloatArray:
        weight, total = statistics[:, :, 0], statistics[:, :, 1]
        return np.where(weight > 0, total / np.maximum(weight, 1), np.nan) / unit[:, 0]

    states = np.arange(len(labelled))
    centers = means(emissions)
    distances = np.full((len(states), x.shape[1]), np.inf)
    for state in np.flatnonzero(labelled).tolist():
        distances[state] = distance(centers[state])
    power = rng.choice(_POWERS)
    for state in np.flatnonzero(~labelled).tolist():
        nearest = distances.min(axis=0)
        chances = np.where(np.isfinite(nearest), nearest, 1.0) * known.any(axis=0)
        chances = (chances / max(chances.max(), 1e-300)) ** power
        if not chances.sum() > 0:  # fewer different rows than states
            chances = np.ones_like(chances)
        row = int(rng.choice(len(chances), p=chances / chances.sum()))
        distances[state] = distance(np.where(known[:, row] > 0, x[:, row], np.nan))
    for _ in range(_ROUNDS):
        owner = distances.argmin(axis=0)
        members = ((owner == states[:, None]) & ~labelled[:, None]).astype(float)
        result = _statistics(values, known, members)
        for state in np.flatnonzero(members.any(axis=1)).tolist():
            distances[state] = distance(means(result)[state])
    return result


def _sample(data: Data, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Some rows without a label, (2 F, n), and what is known of them, (F, n)."""
    values: list[FloatArray] = []
    known: list[FloatArray] = []
    share = min(1.0, _SAMPLE / data.rows)
    for chunk in data.chunks:
        chosen = rng.random(chunk.values.shape[1]) < share
        if chunk.labels is not None:
            chosen = chosen & (chunk.labels == FREE)
        values.append(chunk.values[:, chosen])
        some = np.ones_like(values[-1][: len(data.center)])
        known.append(some if chunk.known is None else chunk.known[:, chosen])
    return np.concatenate(values, axis=1), np.concatenate(known, axis=1)


def _scatter(data: Data) -> FloatArray:
    """The variance of the known values of each feature, (F,)."""
    features = len(data.center)
    total, weight = np.zeros(features), np.zeros(features)
    for chunk in data.chunks:
        total += chunk.values[features:].sum(axis=1)
        weight += chunk.values.shape[1] if chunk.known is None else chunk.known.sum(axis=1)
    return np.asarray(total / np.maximum(weight, 1))

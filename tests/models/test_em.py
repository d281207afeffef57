"""EM against truths: all paths enumerated, an independent library, laws."""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from hmmlearn.hmm import GaussianHMM
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import logsumexp

from kendon.models import Emissions, Family, Prior
from kendon.models.ascent import Run, Search, expect
from kendon.models.em import FREE, Chunk, pack, posterior
from kendon.models.learned_emissions import evaluate
from kendon.models.prior import Expected, Parameters
from kendon.person import FloatArray, IntArray

FAMILIES = list(Family)
GESTURES = slice(4, None)


def random_parameters(
    rng: np.random.Generator, states: int, family: Family, zeros: bool = False
) -> Parameters:
    startprob = rng.dirichlet(np.ones(states))
    transmat = rng.dirichlet(np.ones(states), states)
    if zeros:
        transmat[np.triu_indices(states, 2)] = 0
        transmat /= transmat.sum(axis=1, keepdims=True)
    means = rng.normal(1, 1, (states, 7))
    means[:, GESTURES] = rng.uniform(0.1, 0.9, (states, 3))
    variances = rng.uniform(0.2, 2, (states, 7))
    outliers = 0.05 if family is Family.ROBUST else 0.0
    return Parameters(startprob, transmat, means, variances, family, outliers)


def random_sequences(
    rng: np.random.Generator, lengths: list[int], nan: bool = True
) -> list[FloatArray]:
    sequences = []
    for length in lengths:
        X = rng.normal(1, 1.5, (length, 7))
        X[:, GESTURES] = rng.random((length, 3))
        if nan:
            X[rng.random(X.shape) < 0.3] = np.nan
            X[rng.random(length) < 0.15] = np.nan
        sequences.append(X)
    return sequences


def random_labels(
    rng: np.random.Generator, sequences: list[FloatArray], states: int
) -> list[IntArray]:
    return [
        np.where(rng.random(len(X)) < 0.4, rng.integers(0, states, len(X)), FREE) for X in sequences
    ]


def log_emissions(parameters: Parameters, X: FloatArray) -> FloatArray:
    """Of the model itself, row by row: an independent way to the same numbers."""
    return Emissions(
        parameters.means, parameters.variances, parameters.family, parameters.outliers
    ).log_likelihoods(X)


class Truth(NamedTuple):
    states: FloatArray  # (T, K)
    moves: FloatArray  # (K, K)
    log_likelihood: float


def enumerate_paths(
    startprob: FloatArray, transmat: FloatArray, log_emission: FloatArray, labels: IntArray
) -> Truth:
    """Posterior probabilities by summing over every path; log_emission (T, K)."""
    steps, states = log_emission.shape
    with np.errstate(divide="ignore"):
        log_start, log_moves = np.log(startprob), np.log(transmat)
    paths, logs = [], []
    for path in itertools.product(range(states), repeat=steps):
        if any(label not in (FREE, s) for label, s in zip(labels.tolist(), path, strict=True)):
            continue
        log = log_start[path[0]] + sum(log_emission[t, s] for t, s in enumerate(path))
        paths.append(path)
        logs.append(log + sum(log_moves[i, j] for i, j in itertools.pairwise(path)))
    total = float(logsumexp(logs))
    occupied, moves = np.zeros((steps, states)), np.zeros((states, states))
    for path, log in zip(paths, logs, strict=True):
        weight = math.exp(log - total)
        for t, s in enumerate(path):
            occupied[t, s] += weight
        for i, j in itertools.pairwise(path):
            moves[i, j] += weight
    return Truth(occupied, moves, total)


def columns_of(chunk: Chunk, place: int) -> list[int]:
    return [a + place for a, b in chunk.blocks() if place < b - a]


# ---- the E-step


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(4))
def test_posteriors_are_those_of_all_paths(seed: int, family: Family) -> None:
    rng = np.random.default_rng(seed)
    parameters = random_parameters(rng, 3, family, zeros=seed % 2 == 0)
    sequences = random_sequences(rng, [3, 6, 1, 5, 5])
    labels = random_labels(rng, sequences, 3)
    for mark in labels[:2]:
        mark[:] = FREE
    for mark in labels[2:]:  # a path that exists whatever the zeros are
        mark[mark != FREE] = 2 if seed % 2 == 0 else mark[mark != FREE]
    data = pack(sequences, labels)
    [chunk] = data.chunks
    log = evaluate(chunk, data.center, parameters).log
    found = posterior(parameters.startprob, parameters.transmat, log, chunk)
    moves = np.zeros((3, 3))
    for place, s in enumerate(chunk.sequences.tolist()):
        emission = log_emissions(parameters, sequences[s])
        columns = columns_of(chunk, place)
        np.testing.assert_allclose(log[:, columns].T, emission, rtol=1e-9, atol=1e-9)
        truth = enumerate_paths(parameters.startprob, parameters.transmat, emission, labels[s])
        np.testing.assert_allclose(found.states[:, columns].T, truth.states, atol=1e-10)
        assert found.log_likelihoods[place] == pytest.approx(truth.log_likelihood, abs=1e-9)
        moves += truth.moves
    np.testing.assert_allclose(found.moves, moves, atol=1e-9)


def chunk_of(lengths: list[int]) -> Chunk:
    return pack([np.zeros((length, 7)) for length in lengths]).chunks[0]


@pytest.mark.parametrize("low", [-5.0, -400.0, -800.0, -5000.0])
def test_a_state_that_was_lost_comes_back(low: float) -> None:
    # The first state is out of favour by e^low twice, and then the only one that can be.
    steep = np.array([[0.0, low, low, 0.0, 0.0], [low, 0.0, 0.0, 3 * low, 4 * low]])
    startprob, transmat = np.array([0.5, 0.5]), np.eye(2)
    chunk = chunk_of([5, 3])
    log = np.zeros((2, 8))
    for place in (0, 1):
        columns = columns_of(chunk, place)
        log[:, columns] = steep[:, : len(columns)]
    found = posterior(startprob, transmat, log, chunk)
    for place in (0, 1):
        columns = columns_of(chunk, place)
        none = np.full(len(columns), FREE)
        truth = enumerate_paths(startprob, transmat, log[:, columns].T, none)
        np.testing.assert_allclose(found.states[:, columns].T, truth.states, atol=1e-12)
        assert found.log_likelihoods[place] == pytest.approx(truth.log_likelihood, rel=1e-12)
    assert found.states[0, columns_of(chunk, 0)] == pytest.approx(np.ones(5))
    assert found.moves.sum() == pytest.approx(6)


def test_lost_sequences_leave_their_neighbours_alone() -> None:
    rng = np.random.default_rng(5)
    startprob, transmat = rng.dirichlet(np.ones(3)), rng.dirichlet(np.ones(3), 3)
    lengths = [4, 6, 6, 2, 5]
    chunk = chunk_of(lengths)
    gentle = rng.normal(0, 3, (3, sum(lengths)))
    steep = gentle.copy()
    lost = [columns_of(chunk, place) for place in (1, 3)]
    for columns in lost:
        steep[:, columns] *= 500
    before = posterior(startprob, transmat, gentle, chunk)
    after = posterior(startprob, np.where(np.eye(3) > 0, transmat, transmat), steep, chunk)
    others = sorted(set(range(sum(lengths))) - {c for columns in lost for c in columns})
    np.testing.assert_allclose(after.states[:, others], before.states[:, others], atol=1e-14)
    for place, columns in zip((1, 3), lost, strict=True):
        none = np.full(len(columns), FREE)
        truth = enumerate_paths(startprob, transmat, steep[:, columns].T, none)
        np.testing.assert_allclose(after.states[:, columns].T, truth.states, atol=1e-12)
        assert after.log_likelihoods[place] == pytest.approx(truth.log_likelihood)


def test_a_very_long_sequence_is_exact() -> None:
    rng = np.random.default_rng(1)
    parameters = random_parameters(rng, 4, Family.GAUSSIAN)
    [X] = random_sequences(rng, [3000])
    [chunk] = (data := pack([X])).chunks
    log = evaluate(chunk, data.center, parameters).log
    found = posterior(parameters.startprob, parameters.transmat, log, chunk)
    other: Any = GaussianHMM(4, covariance_type="diag")
    other.n_features, other.n_trials = 4, None
    other.startprob_, other.transmat_ = parameters.startprob, parameters.transmat
    other._compute_log_likelihood = lambda rows: log.T[: len(rows)]
    other.means_, other.covars_ = parameters.means, parameters.variances
    log_likelihood, states = other.score_samples(np.zeros((3000, 7)))
    assert found.log_likelihoods[0] == pytest.approx(log_likelihood, rel=1e-12)
    np.testing.assert_allclose(found.states.T, states, atol=1e-8)


@pytest.mark.parametrize("family", FAMILIES)
def test_together_chunked_or_one_by_one_is_the_same(family: Family) -> None:
    rng = np.random.default_rng(3)
    parameters = random_parameters(rng, 6, family)
    sequences = random_sequences(rng, rng.integers(1, 30, 40).tolist())
    labels = random_labels(rng, sequences, 6)
    together, total = expect(pack(sequences, labels), parameters)
    data = pack(sequences, labels, chunk_rows=50)
    assert len(data.chunks) > 5
    chunked, chunked_total = expect(data, parameters)
    assert chunked_total == pytest.approx(total, rel=1e-12)
    for a, b in zip(together, chunked, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)
    singles = [expect(pack([X], [y]), parameters) for X, y in zip(sequences, labels, strict=True)]
    assert sum(t for _, t in singles) == pytest.approx(total, rel=1e-12)
    np.testing.assert_allclose(sum(e.starts for e, _ in singles), together.starts)
    np.testing.assert_allclose(sum(e.moves for e, _ in singles), together.moves, atol=1e-9)
    weights = sum(e.emissions[:, :, 0] for e, _ in singles)
    np.testing.assert_allclose(weights, together.emissions[:, :, 0], rtol=1e-9)


# ---- one iteration

NONE = Prior.none()


def iterate(
    sequences: list[FloatArray],
    parameters: Parameters,
    prior: Prior = NONE,
    labels: list[IntArray] | None = None,
) -> Parameters:
    data = pack(sequences, labels)
    expected, _ = expect(data, parameters)
    allowed = np.ones(parameters.transmat.shape, dtype=bool)
    return prior.maximise(expected, parameters, data.center, allowed)


@pytest.mark.parametrize("seed", range(3))
def test_without_a_prior_an_iteration_is_hmmlearns(seed: int) -> None:
    rng = np.random.default_rng(seed)
    parameters = random_parameters(rng, 6, Family.GAUSSIAN)
    lengths = rng.integers(2, 30, 25).tolist()
    sequences = random_sequences(rng, lengths, nan=False)
    other: Any = GaussianHMM(
        6, covariance_type="diag", n_iter=1, init_params="", covars_prior=0, covars_weight=1
    )
    other.startprob_, other.transmat_ = parameters.startprob, parameters.transmat
    other.means_, other.covars_ = parameters.means, parameters.variances
    other.fit(np.concatenate(sequences), lengths)
    found = iterate(sequences, parameters)
    np.testing.assert_allclose(found.startprob, other.startprob_, atol=1e-8)
    np.testing.assert_allclose(found.transmat, other.transmat_, atol=1e-8)
    np.testing.assert_allclose(found.means, other.means_, atol=1e-8)
    variances = np.array([np.diag(c) for c in other.covars_])
    np.testing.assert_allclose(found.variances, variances, rtol=1e-8)


def test_unknown_values_drop_out_of_the_statistics() -> None:
    rng = np.random.default_rng(2)
    parameters = random_parameters(rng, 3, Family.GAUSSIAN)
    sequences = random_sequences(rng, [5, 4, 6])
    found = iterate(sequences, parameters)
    X = np.concatenate(sequences)
    states = np.concatenate(
        [
            enumerate_paths(
                parameters.startprob,
                parameters.transmat,
                log_emissions(parameters, x),
                np.full(len(x), FREE),
            ).states
            for x in sequences
        ]
    )
    for k, f in itertools.product(range(3), range(7)):
        known = ~np.isnan(X[:, f])
        w, x = states[known, k], X[known, f]
        mean = (w * x).sum() / w.sum()
        assert found.means[k, f] == pytest.approx(mean, abs=1e-10)
        variance = (w * (x - mean) ** 2).sum() / w.sum()
        assert found.variances[k, f] == pytest.approx(variance, rel=1e-8)


def test_the_robust_update_weighs_by_both_hidden_parts() -> None:
    rng = np.random.default_rng(4)
    parameters = random_parameters(rng, 2, Family.ROBUST)
    [X] = random_sequences(rng, [6])
    found = iterate([X], parameters)
    none = np.full(6, FREE)
    truth = enumerate_paths(
        parameters.startprob, parameters.transmat, log_emissions(parameters, X), none
    )
    for k in range(2):
        known = ~np.isnan(X[:, 0])
        x, m, v = X[known, 0], parameters.means[k, 0], parameters.variances[k, 0]
        normal = 0.95 * np.exp(-((x - m) ** 2) / (2 * v)) / np.sqrt(2 * np.pi * v)
        w = truth.states[known, k] * normal / (normal + 0.05 / 12)
        mean = (w * x).sum() / w.sum()
        assert found.means[k, 0] == pytest.approx(mean)
        assert found.variances[k, 0] == pytest.approx((w * (x - mean) ** 2).sum() / w.sum())
        known = ~np.isnan(X[:, 5])
        g, q, gamma = X[known, 5], parameters.means[k, 5], truth.states[known, k]
        # csal is there in 17 of a hundred intervals, which the detector has counted in.
        there = q * g / 0.17 / (q * g / 0.17 + (1 - q) * (1 - g) / 0.83)
        assert found.means[k, 5] == pytest.approx((gamma * there).sum() / gamma.sum())


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 10**6), st.sampled_from(FAMILIES), st.booleans(), st.booleans(), st.booleans()
)
def test_em_never_goes_down(
    seed: int, family: Family, with_prior: bool, nan: bool, labelled: bool
) -> None:
    rng = np.random.default_rng(seed)
    parameters = random_parameters(rng, 4, family)
    sequences = random_sequences(rng, rng.integers(1, 12, 6).tolist(), nan)
    if not any((~np.isnan(X)).any() for X in sequences):
        return
    labels = random_labels(rng, sequences, 4) if labelled else None
    data = pack(sequences, labels)
    # Without a prior a floor for variances is all that keeps the likelihood finite.
    prior = Prior() if with_prior else Prior(0, 0, 0, 0, gestures=0, certainty=1)
    if not with_prior:  # EM's promise holds from where the bounds are kept
        parameters = parameters._replace(
            variances=np.maximum(parameters.variances, np.square(prior.least))
        )
    else:
        expected, _ = expect(data, parameters)
        parameters = prior.maximise(expected, parameters, data.center, np.ones((4, 4), bool))
    search = Search(data, prior, np.ones((4, 4), dtype=bool), gain=0.0)
    run = Run(0, parameters)
    search.follow(run, 12)
    heights = run.log_posteriors if with_prior else run.log_likelihoods
    assert np.diff(heights).min(initial=0) >= -1e-7 * max(1.0, abs(heights[-1]))


# ---- the M-step


def test_what_nothing_says_anything_about_stays() -> None:
    rng = np.random.default_rng(0)
    for family in FAMILIES:
        old = random_parameters(rng, 3, family)
        nothing = Expected(np.zeros(3), np.zeros((3, 3)), np.zeros((3, 7, 3)))
        new = NONE.maximise(nothing, old, np.zeros(7), np.ones((3, 3), dtype=bool))
        np.testing.assert_allclose(new.startprob, old.startprob)
        np.testing.assert_allclose(new.transmat, old.transmat)
        np.testing.assert_allclose(new.means, old.means)


@pytest.mark.parametrize("family", FAMILIES)
def test_the_m_step_is_the_highest_point(family: Family) -> None:
    # Of the expected log posterior, which one labelled sequence makes the log posterior itself.
    rng = np.random.default_rng(7)
    prior = Prior(least=(1e-3,) * 7, certainty=0.9999)
    X = random_sequences(rng, [30])[0]
    X[:, GESTURES] = rng.integers(0, 2, (30, 3))
    labels = [rng.integers(0, 3, 30)]
    data, allowed = pack([X], labels), np.ones((3, 3), dtype=bool)
    start = random_parameters(rng, 3, family)._replace(outliers=0.0)
    best = iterate([X], start, prior, labels)

    def height(p: Parameters) -> float:
        return expect(data, p)[1] + prior.log_density(p, data.center, allowed)

    top = height(best)
    for _ in range(60):
        shift = rng.normal(0, 0.02, (3, 7))
        means = best.means + shift
        if family is Family.ROBUST:
            means[:, GESTURES] = means[:, GESTURES].clip(0.001, 0.999)
        rows = best.transmat * np.exp(rng.normal(0, 0.05, (3, 3)))
        first = best.startprob * np.exp(rng.normal(0, 0.05, 3))
        other = best._replace(
            means=means,
            variances=best.variances * np.exp(rng.normal(0, 0.05, (3, 7))),
            transmat=rows / rows.sum(axis=1, keepdims=True),
            startprob=first / first.sum(),
        )
        assert height(other) < top

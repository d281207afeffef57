"""The hidden Markov model against truths: all paths enumerated, an independent library, laws."""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from hmmlearn.hmm import GaussianHMM
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import logsumexp
from scipy.stats import norm

from kendon.models import Emissions, hmm
from kendon.person import FloatArray


class Case(NamedTuple):
    startprob: FloatArray  # (K,)
    transmat: FloatArray  # (K, K)
    means: FloatArray  # (K, F)
    variances: FloatArray  # (K, F)
    X: FloatArray  # (T, F)

    @property
    def log_emissions(self) -> FloatArray:
        return Emissions(self.means, self.variances).log_likelihoods(self.X)

    def forward(self, X: FloatArray | None = None) -> hmm.Filtered:
        emissions = Emissions(self.means, self.variances).log_likelihoods(
            self.X if X is None else X
        )
        return hmm.forward(self.startprob, self.transmat, emissions)


def random_case(
    seed: int, states: int, steps: int, features: int = 2, *, zeros: bool = True, nan: bool = True
) -> Case:
    """A random model with impossible moves and starts, and observations with holes."""
    rng = np.random.default_rng(seed)

    def distribution() -> FloatArray:
        weights = rng.dirichlet(np.ones(states))
        if zeros:
            weights[rng.random(states) < 0.4] = 0
        if not weights.any():
            weights[rng.integers(states)] = 1
        return np.asarray(weights / weights.sum())

    X = rng.normal(0, 2, (steps, features))
    if nan:
        X[rng.random(X.shape) < 0.3] = np.nan
        X[rng.random(steps) < 0.2] = np.nan
    return Case(
        distribution(),
        np.array([distribution() for _ in range(states)]),
        rng.normal(0, 1.5, (states, features)),
        rng.uniform(0.2, 2, (states, features)),
        X,
    )


def density(case: Case, t: int, state: int) -> float:
    """P(x_t | state) over the known features, from scipy rather than from kendon."""
    pdf = norm.pdf(case.X[t], case.means[state], np.sqrt(case.variances[state]))
    return float(np.prod(pdf[~np.isnan(case.X[t])]))


def enumerate_paths(case: Case) -> dict[tuple[int, ...], list[float]]:
    """P(path, x_1..x_t) of every path, for t = 1..T."""
    paths = {}
    states, steps = len(case.startprob), len(case.X)
    densities = [[density(case, t, state) for state in range(states)] for t in range(steps)]
    for path in itertools.product(range(states), repeat=steps):
        joint, partial = 1.0, []
        for t, state in enumerate(path):
            move = case.startprob[state] if t == 0 else case.transmat[path[t - 1], state]
            joint *= float(move) * densities[t][state]
            partial.append(joint)
        paths[path] = partial
    return paths


SMALL = [(seed, k, t) for seed, (k, t) in enumerate([(1, 4), (2, 6), (3, 1), (3, 5), (4, 4)] * 6)]


@pytest.mark.parametrize(("seed", "states", "steps"), SMALL)
def test_every_probability_is_the_sum_over_all_paths(seed: int, states: int, steps: int) -> None:
    case = random_case(seed, states, steps)
    found = case.forward()
    paths = enumerate_paths(case)
    shorter: dict[int, dict[tuple[int, ...], float]] = {}
    for t in range(steps):
        # All paths up to t, each once.
        shorter[t] = {path[: t + 1]: joint[t] for path, joint in paths.items()}
        total = sum(shorter[t].values())
        for state in range(states):
            share = sum(joint for path, joint in shorter[t].items() if path[-1] == state)
            assert found.probabilities[t, state] == pytest.approx(share / total, abs=1e-12)
        if t:
            before = shorter[t - 1]
            expected = np.zeros(states)
            for path, joint in before.items():
                expected += joint * case.transmat[path[-1]]
            expected /= sum(before.values())
        else:
            expected = case.startprob
        np.testing.assert_allclose(found.predicted[t], expected, atol=1e-12)
    likelihood = sum(shorter[steps - 1].values())
    assert found.log_likelihood == pytest.approx(math.log(likelihood), abs=1e-10)


@pytest.mark.parametrize(("seed", "states", "steps"), SMALL)
def test_viterbi_finds_the_best_of_all_paths(seed: int, states: int, steps: int) -> None:
    case = random_case(seed, states, steps)
    joints = {path: partial[-1] for path, partial in enumerate_paths(case).items()}
    path, log_joint = hmm.viterbi(case.startprob, case.transmat, case.log_emissions)
    assert log_joint == pytest.approx(math.log(max(joints.values())), abs=1e-10)
    # Several paths may be equally probable: the one found is one of the best.
    assert math.log(joints[tuple(path.tolist())]) == pytest.approx(log_joint, abs=1e-10)


@pytest.mark.parametrize("seed", range(10))
def test_an_emission_is_the_product_of_the_known_features_densities(seed: int) -> None:
    case = random_case(seed, 3, 8, 4)
    expected = [[density(case, t, s) for s in range(3)] for t in range(8)]
    np.testing.assert_allclose(case.log_emissions, np.log(expected), atol=1e-12)
    one = Emissions(case.means, case.variances)
    np.testing.assert_allclose([one.log_likelihood(x) for x in case.X], case.log_emissions)


# ---- an independent library


def oracle(case: Case) -> Any:
    states, features = case.means.shape
    model = GaussianHMM(states, covariance_type="diag")
    model.n_features = features
    model.startprob_, model.transmat_ = case.startprob, case.transmat
    model.means_, model.covars_ = case.means, case.variances
    return model


@pytest.mark.parametrize("seed", range(12))
def test_hmmlearn_agrees(seed: int) -> None:
    case = random_case(seed, 2 + seed % 5, 40, 3, zeros=seed % 2 == 0, nan=False)
    model = oracle(case)
    found = case.forward()
    assert found.log_likelihood == pytest.approx(model.score(case.X), rel=1e-9)
    path, log_joint = hmm.viterbi(case.startprob, case.transmat, case.log_emissions)
    best, best_path = model.decode(case.X, algorithm="viterbi")
    assert log_joint == pytest.approx(best, rel=1e-9)
    assert path.tolist() == best_path.tolist()
    # The posterior of a prefix's last step is the filtered probability there.
    for t in range(0, 40, 7):
        last = model.predict_proba(case.X[: t + 1])[-1]
        np.testing.assert_allclose(found.probabilities[t], last, atol=1e-9)


# ---- laws

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(1, 6), st.integers(1, 12))
def test_rows_sum_to_one(seed: int, states: int, steps: int) -> None:
    found = random_case(seed, states, steps).forward()
    for rows in (found.probabilities, found.predicted):
        assert (rows >= 0).all()
        np.testing.assert_allclose(rows.sum(axis=1), 1, atol=1e-12)


@given(seeds, st.integers(1, 9))
def test_the_future_never_changes_the_past(seed: int, cut: int) -> None:
    case = random_case(seed, 4, 10)
    whole, part = case.forward(), case.forward(case.X[:cut])
    assert whole.probabilities[:cut].tolist() == part.probabilities.tolist()
    assert whole.predicted[:cut].tolist() == part.predicted.tolist()


@given(seeds, st.integers(1, 9))
def test_a_row_without_any_value_is_pure_prediction(seed: int, row: int) -> None:
    case = random_case(seed, 4, 10)
    case.X[row] = np.nan
    found = case.forward()
    np.testing.assert_allclose(found.probabilities[row], found.predicted[row], atol=1e-13)
    np.testing.assert_allclose(
        found.predicted[row], found.probabilities[row - 1] @ case.transmat, atol=1e-12
    )


@given(seeds)
def test_unknown_last_rows_add_nothing_to_the_likelihood(seed: int) -> None:
    case = random_case(seed, 4, 10)
    longer = np.vstack([case.X, np.full((3, 2), np.nan)])
    assert case.forward(longer).log_likelihood == pytest.approx(
        case.forward().log_likelihood, abs=1e-10
    )


@given(seeds, st.integers(0, 3))
def test_an_unknown_feature_counts_as_removed(seed: int, feature: int) -> None:
    case = random_case(seed, 4, 10, 4)
    case.X[:, feature] = np.nan
    keep = [f for f in range(4) if f != feature]
    without = case._replace(
        means=case.means[:, keep], variances=case.variances[:, keep], X=case.X[:, keep]
    )
    assert_same(case, without)


@given(seeds, st.permutations(range(4)))
def test_the_order_of_features_does_not_matter(seed: int, order: list[int]) -> None:
    case = random_case(seed, 4, 10, 4)
    assert_same(
        case,
        case._replace(
            means=case.means[:, order], variances=case.variances[:, order], X=case.X[:, order]
        ),
    )


@given(seeds, st.floats(-100, 100))
def test_a_feature_counts_only_by_its_distance_to_the_means(seed: int, shift: float) -> None:
    case = random_case(seed, 4, 10)
    assert_same(case, case._replace(means=case.means + shift, X=case.X + shift))


@given(seeds, st.permutations(range(4)))
def test_the_names_of_states_do_not_matter(seed: int, order: list[int]) -> None:
    case = random_case(seed, 4, 10)
    renamed = case._replace(
        startprob=case.startprob[order],
        transmat=case.transmat[np.ix_(order, order)],
        means=case.means[order],
        variances=case.variances[order],
    )
    np.testing.assert_allclose(
        renamed.forward().probabilities, case.forward().probabilities[:, order], atol=1e-11
    )


def assert_same(one: Case, other: Case) -> None:
    a, b = one.forward(), other.forward()
    np.testing.assert_allclose(a.probabilities, b.probabilities, atol=1e-9)
    assert a.log_likelihood == pytest.approx(b.log_likelihood, abs=1e-8)
    best = [hmm.viterbi(c.startprob, c.transmat, c.log_emissions)[1] for c in (one, other)]
    assert best[0] == pytest.approx(best[1], abs=1e-8)


# ---- numbers far out


@pytest.mark.parametrize("seed", range(5))
def test_a_state_that_lost_by_far_can_win_again(seed: int) -> None:
    """A belief below the smallest float is not forgotten: the exact recursion in logarithms."""
    rng = np.random.default_rng(seed)
    means = np.array([[0.0, 0.0], [9.0, 9.0], [2.0, 1.0]])
    # Left to right: a state that has been left cannot be entered again.
    case = Case(
        startprob=np.array([0.9, 0.1, 0.0]),
        transmat=np.array([[0.9, 0.08, 0.02], [0.0, 0.9, 0.1], [0.0, 0.0, 1.0]]),
        means=means,
        variances=np.full((3, 2), 0.1),
        X=rng.normal(means[[2] * 100 + [0] * 300], 0.3),
    )
    found = case.forward()
    with np.errstate(divide="ignore"):
        log_alpha, moves = np.log(case.startprob), np.log(case.transmat)
    exact = []
    for t, row in enumerate(case.log_emissions):
        prior = log_alpha if t == 0 else logsumexp(log_alpha[:, None] + moves, axis=0)
        log_alpha = prior + row
        exact.append(np.exp(log_alpha - logsumexp(log_alpha)))
    np.testing.assert_allclose(found.probabilities, exact, atol=1e-7)
    assert found.log_likelihood == pytest.approx(logsumexp(log_alpha), rel=1e-12)
    assert found.log_likelihood == pytest.approx(oracle(case).score(case.X), rel=1e-9)
    # The premise: the first state was out of any float's reach and came back all the same.
    assert found.probabilities[99, 0] == 0
    assert found.probabilities[-1, 0] > 0.9


def test_condition_prefers_the_best_possible_state() -> None:
    with np.errstate(divide="ignore"):
        predicted = np.log([0.5, 0.5, 0.0]).tolist()
    log_belief, gain = hmm.condition(predicted, [-1e6, -1e6 - 1, 1e6])
    odds = math.exp(-1)
    np.testing.assert_allclose(
        np.exp(log_belief), [1 / (1 + odds), odds / (1 + odds), 0], atol=1e-12
    )
    assert gain == pytest.approx(-1e6 + math.log(0.5 * (1 + odds)), rel=1e-12)


def test_predict_moves_a_belief_along_the_rows() -> None:
    transmat = np.array([[0.25, 0.75], [0.0, 1.0]])
    prediction = hmm.predict([math.log(0.4), math.log(0.6)], hmm.Transitions.of(transmat))
    np.testing.assert_allclose(np.exp(prediction), [0.1, 0.9])

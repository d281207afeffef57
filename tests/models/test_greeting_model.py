"""The greeting model and its tracker: the shapes, the laws and the limits users rely on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hmmlearn.hmm import GaussianHMM
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from kendon.errors import KendonError, ParameterError
from kendon.models import Family, GreetingModel, Tracker, load_model, model_names
from kendon.observations import FEATURES, Observation
from kendon.person import FloatArray
from kendon.phases import Phase

MODELS = {name: load_model(name) for name in model_names()}
#: hmmlearn knows only these.
GAUSSIAN = {name: model for name, model in MODELS.items() if model.family is Family.GAUSSIAN}
KENDON = MODELS["kendon"]

#: Anything a sampler or a wrong sensor might deliver.
values = st.one_of(st.just(np.nan), st.floats(-100, 100))
sequences = st.integers(1, 25).flatmap(lambda n: arrays(float, (n, 7), elements=values))
models = st.sampled_from(list(MODELS.values()))


def plausible(seed: int, steps: int, nan: float = 0.0) -> FloatArray:
    rng = np.random.default_rng(seed)
    X = rng.uniform([0.5, -1, 0, 0, 0, 0, 0], [9, 2, 2, 5, 1, 1, 1], (steps, 7))
    X[rng.random(X.shape) < nan] = np.nan
    return X


def changed(**parts: Any) -> GreetingModel:
    whole = {
        "startprob": KENDON.startprob,
        "transmat": KENDON.transmat,
        "means": KENDON.means,
        "variances": KENDON.variances,
    }
    return GreetingModel(**{**whole, **parts})


# ---- an independent library


@pytest.mark.parametrize("name", GAUSSIAN)
@pytest.mark.parametrize("seed", range(4))
def test_hmmlearn_agrees(name: str, seed: int) -> None:
    model = MODELS[name]
    oracle: Any = GaussianHMM(6, covariance_type="diag")
    oracle.n_features = 7
    oracle.startprob_, oracle.transmat_ = model.startprob, model.transmat
    oracle.means_, oracle.covars_ = model.means, model.variances
    # Half of them drawn from the model, half of them anything.
    X = oracle.sample(60, random_state=seed)[0] if seed % 2 else plausible(seed, 60)
    assert model.log_likelihood(X) == pytest.approx(oracle.score(X), rel=1e-9)
    assert (model.decode(X) - 1).tolist() == oracle.decode(X)[1].tolist()
    found = model.filter(X)
    for t in range(0, 60, 5):
        last = oracle.predict_proba(X[: t + 1])[-1]
        np.testing.assert_allclose(found[t], last, atol=1e-9)


def test_hmmlearn_agrees_when_a_person_who_walked_stands_for_long() -> None:
    oracle: Any = GaussianHMM(6, covariance_type="diag")
    oracle.n_features = 7
    oracle.startprob_, oracle.transmat_ = KENDON.startprob, KENDON.transmat
    oracle.means_, oracle.covars_ = KENDON.means, KENDON.variances
    standing = [5, 0, 1, 1, 0, 0, 0]
    X = np.vstack([np.tile(KENDON.means[3], (30, 1)), np.tile(standing, (300, 1))])
    assert KENDON.log_likelihood(X) == pytest.approx(oracle.score(X), rel=1e-9)
    last = KENDON.filter(X)[-1]
    np.testing.assert_allclose(last, oracle.predict_proba(X)[-1], atol=1e-9)
    # The filter forgets no path, however unlikely it was on the way.
    assert last.argmax() + 1 == KENDON.decode(X)[-1] == Phase.IA


# ---- laws


@given(models, sequences)
def test_stepping_gives_what_the_batch_gives(model: GreetingModel, X: FloatArray) -> None:
    tracker = model.tracker()
    stepped = [tracker.step(x).probabilities for x in X]
    assert np.array_equal(stepped, model.filter(X))


@given(models, sequences)
def test_any_finite_observation_gives_a_normalised_belief(
    model: GreetingModel, X: FloatArray
) -> None:
    beliefs = model.filter(X)
    assert beliefs.shape == (len(X), 6)
    assert (beliefs >= 0).all()
    np.testing.assert_allclose(beliefs.sum(axis=1), 1, atol=1e-12)
    assert np.isfinite(model.log_likelihood(X))


@given(models, sequences, st.integers(0, 24))
def test_nothing_after_an_instant_changes_the_belief_at_it(
    model: GreetingModel, X: FloatArray, cut: int
) -> None:
    cut = min(cut, len(X) - 1) + 1
    assert np.array_equal(model.filter(X[:cut]), model.filter(X)[:cut])


@given(models, sequences)
def test_decoded_phases_follow_possible_moves(model: GreetingModel, X: FloatArray) -> None:
    phases = model.decode(X)
    assert phases.shape == (len(X),)
    assert set(phases.tolist()) <= {int(p) for p in Phase}
    assert model.startprob[phases[0] - 1] > 0
    assert (model.transmat[phases[:-1] - 1, phases[1:] - 1] > 0).all()


@given(models, sequences)
def test_a_phase_that_cannot_be_reached_has_no_probability(
    model: GreetingModel, X: FloatArray
) -> None:
    reachable = np.asarray(model.startprob > 0)
    for belief in model.filter(X):
        assert (belief[~reachable] == 0).all()
        reachable = np.asarray((model.transmat[reachable] > 0).any(axis=0))


@given(models, st.integers(1, 20))
def test_without_any_observation_the_model_runs_on_its_own(
    model: GreetingModel, steps: int
) -> None:
    X = np.full((steps, 7), np.nan)
    expected = model.startprob @ np.linalg.matrix_power(model.transmat, steps - 1)
    np.testing.assert_allclose(model.filter(X)[-1], expected, atol=1e-12)
    assert model.log_likelihood(X) == pytest.approx(0, abs=1e-12)


@given(st.integers(0, 10_000), st.floats(-50, 50))
def test_a_constant_added_to_feature_and_means_changes_nothing(seed: int, shift: float) -> None:
    X = plausible(seed, 20, nan=0.2)
    shifted = changed(means=KENDON.means + shift)
    np.testing.assert_allclose(shifted.filter(X + shift), KENDON.filter(X), atol=1e-8)


@given(st.integers(0, 10_000), st.permutations(range(7)))
def test_the_order_of_features_changes_nothing(seed: int, order: list[int]) -> None:
    X = plausible(seed, 20, nan=0.2)
    moved = changed(means=KENDON.means[:, order], variances=KENDON.variances[:, order])
    np.testing.assert_allclose(moved.filter(X[:, order]), KENDON.filter(X), atol=1e-10)


@given(st.integers(0, 10_000), st.integers(0, 6))
def test_an_unknown_feature_counts_as_one_that_tells_phases_apart_in_nothing(
    seed: int, feature: int
) -> None:
    X = plausible(seed, 20)
    means, variances = KENDON.means.copy(), KENDON.variances.copy()
    means[:, feature], variances[:, feature] = 1.0, 1.0
    indifferent = changed(means=means, variances=variances).filter(X)
    X[:, feature] = np.nan
    np.testing.assert_allclose(KENDON.filter(X), indifferent, atol=1e-10)


# ---- far out


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize(
    "row",
    [
        [99, -50, 2, 5, 1, 1, 1],
        [0, 50, 0, 0, 1, 1, 1],
        [99, np.nan, np.nan, np.nan, 0, 0, 0],
        [1e6, -1e6, 0, 0, 0, 0, 0],
        [1e5] * 7,
    ],
)
def test_absurd_observations_never_underflow(name: str, row: list[float]) -> None:
    model = MODELS[name]
    X = np.tile(np.array(row, dtype=float), (300, 1))
    X[::7] = model.means[3]
    found = model.forward(X)
    assert np.isfinite(found.probabilities).all()
    np.testing.assert_allclose(found.probabilities.sum(axis=1), 1, atol=1e-12)
    assert np.isfinite(found.log_likelihood)
    assert found.log_likelihood < -1000


def test_ten_thousand_steps_stay_normalised() -> None:
    X = plausible(1, 10_000, nan=0.1)
    X[::100] = [99, -50, 2, 5, 1, 1, 1]
    found = KENDON.forward(X)
    np.testing.assert_allclose(found.probabilities.sum(axis=1), 1, atol=1e-12)
    assert np.isfinite(found.log_likelihood)


# ---- a greeting


def test_a_greeting_by_the_book_is_read_by_the_book() -> None:
    order = [Phase.IA, Phase.APP, Phase.DS, Phase.HD, Phase.APP, Phase.FA, Phase.CS]
    X = np.repeat(KENDON.means[[p.index for p in order]], 4, axis=0)
    truth = np.repeat([int(p) for p in order], 4)
    assert KENDON.decode(X).tolist() == truth.tolist()
    assert (KENDON.filter(X).argmax(axis=1) + 1).tolist() == truth.tolist()


def test_a_belief_names_its_most_probable_phase() -> None:
    tracker = KENDON.tracker()
    belief = tracker.step(KENDON.means[0])
    assert belief.phase is Phase.IA
    assert belief.probabilities.tolist() == [1, 0, 0, 0, 0, 0]
    assert tracker.step(KENDON.means[3]).phase is Phase.APP


def test_a_tracker_takes_observations_lists_and_arrays() -> None:
    row = [4.0, 1.1, 0.9, float("nan"), 0.0, 0.0, 0.0]
    forms: list[Any] = [row, tuple(row), np.array(row), Observation(3.2, *row)]
    beliefs = [KENDON.tracker().step(form).probabilities for form in forms]
    for belief in beliefs[1:]:
        assert belief.tolist() == beliefs[0].tolist()


def test_a_tracker_forgets_on_reset_and_shares_nothing() -> None:
    X = plausible(3, 12)
    one, other = KENDON.tracker(), KENDON.tracker()
    first = [one.step(x).probabilities.tolist() for x in X]
    assert [other.step(x).probabilities.tolist() for x in X] == first
    one.reset()
    assert [one.step(x).probabilities.tolist() for x in X] == first


def test_a_refused_observation_leaves_a_tracker_as_it_was() -> None:
    X = plausible(4, 6)
    tracker = KENDON.tracker()
    for x in X[:3]:
        tracker.step(x)
    with pytest.raises(ParameterError):
        tracker.step([np.inf] * 7)
    after = [tracker.step(x).probabilities.tolist() for x in X[3:]]
    assert after == KENDON.filter(X)[3:].tolist()


# ---- mistakes

WRONG_X: dict[str, Any] = {
    "flat": np.zeros(7),
    "six columns": np.zeros((3, 6)),
    "no rows": np.zeros((0, 7)),
    "three axes": np.zeros((2, 3, 7)),
    "nothing": None,
    "ragged": [[1.0] * 7, [1.0] * 6],
    "words": [["near"] * 7],
    "infinite": np.full((2, 7), np.inf),
    "one infinite among unknown": np.array([[np.nan] * 6 + [-np.inf]]),
    "beyond squares": np.full((2, 7), 1e160),
}


@pytest.mark.parametrize("kind", WRONG_X)
@pytest.mark.parametrize("call", ["filter", "forward", "decode", "log_likelihood"])
def test_observations_of_another_kind_are_refused(kind: str, call: str) -> None:
    with pytest.raises(ParameterError) as caught:
        getattr(KENDON, call)(WRONG_X[kind])
    text = str(caught.value)
    assert "distance, speed, gaze" in text or "use NaN for unknown" in text


def test_the_row_of_an_infinite_value_is_named() -> None:
    X = plausible(5, 4)
    X[2, 1] = np.inf
    with pytest.raises(ParameterError, match="observation 2 holds a value beyond all measure"):
        KENDON.filter(X)


@pytest.mark.parametrize(
    "x",
    [
        [0.0] * 6,
        np.zeros((1, 7)),
        [np.inf] + [0.0] * 6,
        [np.nan] * 6 + [np.inf],
        [1e160] * 7,
        # Beyond squares only for phases with a small variance.
        [1.4e154] + [0.0] * 6,
        ["far"] + [0.0] * 6,
        None,
    ],
)
def test_a_step_of_another_kind_is_refused(x: Any) -> None:
    with pytest.raises(ParameterError):
        KENDON.tracker().step(x)


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ({"startprob": [1, 0, 0]}, r"startprob has shape \(3,\) instead of \(6,\)"),
        ({"transmat": np.eye(5)}, r"transmat has shape \(5, 5\) instead of \(6, 6\)"),
        ({"means": np.zeros((7, 6))}, r"means has shape \(7, 6\) instead of \(6, 7\)"),
        ({"variances": 1.0}, r"variances has shape \(\) instead of \(6, 7\)"),
        ({"startprob": None}, r"startprob has shape \(\)"),
        ({"startprob": ["IA"] * 6}, "startprob must hold numbers"),
        ({"transmat": [[1, 0], [1]]}, "transmat must hold numbers, in rows of equal length"),
        ({"means": np.full((6, 7), np.nan)}, "means holds a value that is not finite"),
        ({"variances": np.full((6, 7), np.inf)}, "variances holds a value that is not finite"),
        ({"startprob": [0.5, 0, 0, 0, 0, 0]}, r"startprob must .* sum to 1, not \[0.5\]"),
        ({"startprob": [0] * 6}, "sum to 1"),
        ({"startprob": [1.003, 0, 0, 0, 0, 0]}, "sum to 1"),
        ({"startprob": [1e308] * 6}, "sum to 1"),
        ({"startprob": [1.5, -0.5, 0, 0, 0, 0]}, "startprob holds a negative probability, -0.5"),
        ({"transmat": np.eye(6) * 0.9}, "transmat must .* sum to 1 in each row"),
        ({"variances": np.zeros((6, 7))}, "every variance must be positive, not 0"),
        ({"variances": np.full((6, 7), -1.0)}, "every variance must be positive, not -1"),
        ({"variances": np.full((6, 7), 1e-320)}, "every variance must be positive"),
    ],
)
def test_parameters_that_make_no_model_are_refused(parts: dict[str, Any], reason: str) -> None:
    with pytest.raises(ParameterError, match=reason) as caught:
        changed(**parts, name="mine")
    assert "model 'mine'" in str(caught.value)
    assert isinstance(caught.value, KendonError)
    assert isinstance(caught.value, ValueError)


def test_rounding_in_print_is_normalised() -> None:
    model = changed(startprob=[0.929, 0, 0, 0.072, 0, 0])
    assert model.startprob.tolist() == pytest.approx([0.929 / 1.001, 0, 0, 0.072 / 1.001, 0, 0])
    assert model.startprob.sum() == pytest.approx(1, abs=1e-15)


def test_a_model_keeps_its_numbers_to_itself() -> None:
    means = KENDON.means.copy()
    model = changed(means=means)
    means[:] = 0
    assert model.means.tolist() == KENDON.means.tolist()
    with pytest.raises(ValueError, match="read-only"):
        model.transmat[0, 0] = 0
    X = plausible(6, 5, nan=0.3)
    before = X.copy()
    model.filter(X)
    model.decode(X)
    assert np.array_equal(X, before, equal_nan=True)


def test_the_shapes_and_types_other_programs_rely_on() -> None:
    assert KENDON.startprob.shape == (6,)
    assert KENDON.transmat.shape == (6, 6)
    assert KENDON.means.shape == KENDON.variances.shape == (6, len(FEATURES)) == (6, 7)
    X = plausible(7, 3)
    assert KENDON.filter(X).shape == (3, 6)
    assert Phase(KENDON.decode(X)[0]) is Phase.IA
    assert isinstance(KENDON.log_likelihood(X), float)
    assert isinstance(KENDON.tracker(), Tracker)
    assert KENDON.tracker().step(X[0]).probabilities.shape == (6,)

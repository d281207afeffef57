"""Models to and from hmmlearn: hmmlearn itself says whether they are the same models."""

from __future__ import annotations

import dataclasses
import sys
from typing import Any

import numpy as np
import pytest
from hmmlearn.hmm import GMMHMM, GaussianHMM
from hypothesis import given
from hypothesis import strategies as st

from kendon.errors import MissingExtraError, ParameterError
from kendon.models import (
    Family,
    GreetingModel,
    from_hmmlearn,
    load_model,
    model_names,
    name_states,
    sample,
    to_hmmlearn,
)
from kendon.person import FloatArray
from kendon.phases import Phase

GAUSSIAN = [model for model in map(load_model, model_names()) if model.family is Family.GAUSSIAN]
PARTS = ("startprob", "transmat", "means", "variances")


def drawn(seed: int) -> GreetingModel:
    """Any model, with moves that are impossible."""
    rng = np.random.default_rng(seed)
    transmat = rng.dirichlet(np.ones(6), 6) * (rng.random((6, 6)) < 0.8) + 0.1 * np.eye(6)
    return GreetingModel(
        rng.dirichlet(np.ones(6)),
        transmat / transmat.sum(axis=1, keepdims=True),
        rng.normal(size=(6, 7)),
        rng.uniform(0.01, 4, (6, 7)),
    )


def trained(covariance_type: str, seed: int = 0) -> tuple[Any, FloatArray]:
    """A GaussianHMM that has learned, and what it learned from."""
    X = np.concatenate([g.values for g in sample(load_model("kendon"), [30] * 20, seed)])
    # Gestures that are all but constant leave hmmlearn nothing to divide by.
    X = X + np.random.default_rng(seed).normal(0, 0.05, X.shape)
    return GaussianHMM(6, covariance_type, random_state=seed, n_iter=5, tol=0).fit(X), X


def assert_same(model: GreetingModel, hmm: Any, X: FloatArray) -> None:
    assert model.log_likelihood(X) == pytest.approx(hmm.score(X), rel=1e-9)
    np.testing.assert_array_equal(model.decode(X) - 1, hmm.decode(X)[1])


@given(st.integers(0, 2**32 - 1))
def test_hmmlearn_scores_and_decodes_as_the_model_does(seed: int) -> None:
    model = drawn(seed)
    X = np.random.default_rng(seed).normal(0, 2, (25, 7))
    assert_same(model, to_hmmlearn(model), X)


@pytest.mark.parametrize("model", GAUSSIAN, ids=lambda model: model.name)
def test_there_and_back_is_the_same_to_the_last_bit(model: GreetingModel) -> None:
    back = from_hmmlearn(to_hmmlearn(model), name="back")
    assert back.name == "back"
    for part in PARTS:
        np.testing.assert_array_equal(getattr(back, part), getattr(model, part))


@pytest.mark.parametrize("covariance_type", ["diag", "spherical"])
def test_what_hmmlearn_learned_reads_as_hmmlearn_does(covariance_type: str) -> None:
    hmm, X = trained(covariance_type)
    model = from_hmmlearn(hmm)
    assert_same(model, hmm, X)
    if covariance_type == "diag":
        again = to_hmmlearn(model)
        for part in ("startprob_", "transmat_", "means_", "covars_"):
            np.testing.assert_array_equal(getattr(again, part), getattr(hmm, part))


def test_covariances_set_by_hand_are_taken() -> None:
    for covariance_type, covars in [
        ("spherical", np.arange(1.0, 7.0)),
        ("diag", np.ones((6, 7))),
        ("full", np.tile(np.diag(np.arange(1.0, 8.0)), (6, 1, 1))),
        ("tied", np.diag(np.arange(1.0, 8.0))),
    ]:
        model = load_model("kendon")
        hmm: Any = GaussianHMM(6, covariance_type)
        hmm.startprob_, hmm.transmat_, hmm.means_ = model.startprob, model.transmat, model.means
        hmm.covars_ = covars
        assert_same(from_hmmlearn(hmm), hmm, sample(model, [20], 3)[0].values)


def test_fit_goes_on_from_the_model_and_leaves_it_alone() -> None:
    model = load_model("kendon")
    means = model.means.copy()
    X = sample(model, [40], seed=2)[0].values
    hmm = to_hmmlearn(model)
    hmm.n_iter = 2
    before = hmm.score(X)
    hmm.fit(X)
    assert hmm.monitor_.history[0] == pytest.approx(before)
    np.testing.assert_array_equal(model.means, means)


@pytest.mark.parametrize("seed", range(4))
def test_states_in_any_order_get_their_names(seed: int) -> None:
    model = load_model("kendon")
    order = np.random.default_rng(seed).permutation(6)
    hmm = to_hmmlearn(model)
    hmm.startprob_, hmm.means_ = model.startprob[order], model.means[order]
    hmm.transmat_, hmm.covars_ = model.transmat[np.ix_(order, order)], model.variances[order]
    found = name_states(hmm)
    assert found.phases == tuple(Phase(i + 1) for i in order)
    assert "margin" in str(found)
    for named in (from_hmmlearn(hmm, found.order), from_hmmlearn(hmm, tuple(np.argsort(order)))):
        for part in PARTS:
            np.testing.assert_array_equal(getattr(named, part), getattr(model, part))
    assert name_states(hmm, load_model("data-driven")).order != []


@pytest.mark.parametrize("order", [[0, 1, 2, 3, 4], [0, 1, 2, 3, 4, 4], [1, 2, 3, 4, 5, 6]])
def test_an_order_names_each_state_once(order: list[int]) -> None:
    with pytest.raises(ParameterError, match=r"0 to 5, of each of IA, .* CS once; not \["):
        from_hmmlearn(to_hmmlearn(load_model("kendon")), order)


def test_a_robust_model_is_refused() -> None:
    model = load_model("kendon")
    robust = dataclasses.replace(
        model, means=model.means.clip(0.1, 0.9), family=Family.ROBUST, outliers=0.01
    )
    with pytest.raises(ParameterError, match=r"robust family.*cannot express.*--family gaussian"):
        to_hmmlearn(robust)


@pytest.mark.parametrize("covariance_type", ["full", "tied"])
def test_correlated_features_are_refused(covariance_type: str) -> None:
    hmm, _ = trained(covariance_type)
    with pytest.raises(ParameterError, match=r"state 0 correlates distance with speed.*'diag'"):
        from_hmmlearn(hmm)


def changed(**parts: Any) -> Any:
    hmm = to_hmmlearn(load_model("kendon"))
    for part, value in parts.items():
        setattr(hmm, part, value)
    return hmm


@pytest.mark.parametrize(
    ("hmm", "message"),
    [
        (GaussianHMM(6), r"no startprob_, transmat_, means_, covars_ yet: train it with fit"),
        (GMMHMM(6), "not a GMMHMM"),
        (load_model("kendon"), "not a GreetingModel"),
        (changed(n_components=4), "has 4 states; a greeting has 6 phases: IA, DS"),
        (changed(means_=np.ones((6, 3))), r"shape \(6, 3\) instead of \(6, 7\); .*distance"),
        (changed(covars_=np.ones((6, 3))), r"covars_ are 6 matrices of \(3, 3\) instead of 6 of"),
        (changed(startprob_=np.full(5, 0.2)), r"startprob has shape \(5,\) instead of \(6,\)"),
        (changed(transmat_=np.zeros((6, 6))), "sum to 1 in each row"),
        (changed(means_=np.full((6, 7), np.nan)), "not finite"),
    ],
)
def test_what_is_no_greeting_model_is_refused(hmm: Any, message: str) -> None:
    for convert in (from_hmmlearn, name_states):
        with pytest.raises(ParameterError, match=message):
            convert(hmm)


def test_without_hmmlearn_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    hmm = to_hmmlearn(load_model("kendon"))
    monkeypatch.setitem(sys.modules, "hmmlearn.hmm", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'kendon\[hmmlearn\]'"):
        to_hmmlearn(load_model("kendon"))
    with pytest.raises(MissingExtraError):
        from_hmmlearn(hmm)

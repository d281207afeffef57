"""Learning a model: counted by hand, recovered from samples, found without labels."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kendon.errors import ParameterError, UnknownNameError
from kendon.models import Family, GreetingModel, Prior, fit, load_model, sample, save_model
from kendon.observations import FEATURES, Observations
from kendon.person import FloatArray
from kendon.phases import Phase


def greeting(
    values: FloatArray, phases: Sequence[int] | None = None, name: str = "ann"
) -> Observations:
    t = 0.2 * np.arange(1, len(values) + 1, dtype=np.float64)
    return Observations(t, values, None if phases is None else np.array(phases), name)


def robust(model: GreetingModel) -> GreetingModel:
    """The model with the other family: gestures that are there or not."""
    means = model.means.copy()
    means[:, 4:] = means[:, 4:].clip(0.02, 0.98)
    return dataclasses.replace(model, means=means, family=Family.ROBUST, outliers=0.01)


@pytest.fixture(scope="module")
def published() -> GreetingModel:
    return load_model("kendon")


@pytest.fixture(scope="module")
def small() -> list[Observations]:
    """Two labelled greetings with all phases, easy to count."""
    rng = np.random.default_rng(0)
    phases = [[1, 1, 2, 3, 4, 4, 5, 6, 6], [1, 4, 4, 2, 5, 6, 3, 3]]
    return [greeting(rng.random((len(p), 7)), p) for p in phases]


# ---- all labelled


def test_labels_are_counted(small: list[Observations]) -> None:
    result = fit(small, family=Family.GAUSSIAN, prior=Prior.none())
    model = result.model
    assert model.startprob.tolist() == [1, 0, 0, 0, 0, 0]
    expected = np.zeros((6, 6))
    for g in small:
        assert g.phases is not None
        for i, j in zip(g.phases[:-1] - 1, g.phases[1:] - 1, strict=True):
            expected[i, j] += 1
    np.testing.assert_allclose(model.transmat, expected / expected.sum(axis=1, keepdims=True))
    X = np.concatenate([g.values for g in small])
    labels = np.concatenate([g.phases for g in small if g.phases is not None])
    for phase in Phase:
        rows = X[labels == phase]
        np.testing.assert_allclose(model.means[phase.index], rows.mean(axis=0))
        np.testing.assert_allclose(model.variances[phase.index], rows.var(axis=0), atol=1e-12)


def test_all_labelled_converges_in_one_step(small: list[Observations]) -> None:
    for prior in (Prior.none(), Prior()):
        result = fit(small, family=Family.GAUSSIAN, prior=prior)
        assert result.converged
        assert result.iterations == 1
        assert result.log_posteriors[1] == pytest.approx(result.log_posteriors[0])
        assert len(result.starts) == 1
        assert result.assignment is None


def test_the_prior_counts_as_further_rows(small: list[Observations]) -> None:
    prior = Prior(least=(0.0,) * 7)
    model = fit(small, family=Family.GAUSSIAN, prior=prior).model
    bare = fit(small, family=Family.GAUSSIAN, prior=Prior.none()).model
    assert model.startprob[0] == pytest.approx(2.1 / 2.6)
    # IA was left for IA, DS and APP once each.
    assert model.transmat[0] == pytest.approx(np.array([1.1, 1.1, 0.1, 1.1, 0.1, 0.1]) / 3.6)
    X = np.concatenate([g.values for g in small])
    mean = (3 * bare.means[0] + 0.01 * X.mean(axis=0)) / 3.01
    np.testing.assert_allclose(model.means[0], mean)
    rows = X[np.concatenate([g.phases for g in small if g.phases is not None]) == 1]
    squares = ((rows - mean) ** 2).sum(axis=0) + 0.01 * (mean - X.mean(axis=0)) ** 2
    expected = (squares + 2 * np.square(prior.deviations)) / 5
    np.testing.assert_allclose(model.variances[0], expected)


@pytest.mark.parametrize("family", list(Family))
def test_parameters_are_recovered_from_labelled_samples(
    published: GreetingModel, family: Family
) -> None:
    truth = published if family is Family.GAUSSIAN else robust(published)
    result = fit(sample(truth, [40] * 600, seed=3), family=family)
    np.testing.assert_allclose(result.model.transmat, truth.transmat, atol=0.05)
    np.testing.assert_allclose(result.model.startprob, truth.startprob, atol=0.01)
    spread = np.sqrt(truth.variances)
    assert (abs(result.model.means - truth.means) / spread).max() < 0.2
    measured = slice(0, 7 if family is Family.GAUSSIAN else 4)
    ratio = np.sqrt(result.model.variances / truth.variances)[:, measured]
    assert abs(ratio - 1).max() < 0.15
    assert result.model.family is family


def test_wild_values_do_not_move_the_robust_means(published: GreetingModel) -> None:
    clean = sample(robust(published), [40] * 80, seed=1)
    rng = np.random.default_rng(0)
    wild = []
    for g in clean:
        values = g.values.copy()
        values[rng.random(len(values)) < 0.03, 0] = 12.0
        wild.append(dataclasses.replace(g, values=values))
    by_family = {
        family: fit(wild, family=family, outliers=0.03).model.means[5, 0] for family in Family
    }
    truth = published.means[5, 0]
    assert abs(by_family[Family.ROBUST] - truth) < 0.05
    assert abs(by_family[Family.GAUSSIAN] - truth) > 0.2


@pytest.mark.parametrize("family", list(Family))
def test_two_rows_are_enough_for_a_sane_model(family: Family) -> None:
    X = np.zeros((2, 7))
    for phases in ([1, 6], [-1, -1], [3, 3], None):
        result = fit([greeting(X, phases)], family=family, starts=2)
        model = result.model  # which has checked rows and variances itself
        assert (model.startprob > 0).all()
        assert np.isfinite(result.log_posteriors).all()
        assert (np.sqrt(model.variances[:, :4]) >= np.array(Prior().least)[:4] - 1e-12).all()


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(list(Family)), st.sampled_from([0.0, 0.5, 1.0]))
def test_whatever_is_learned_from_the_model_is_sane_and_em_rises(
    seed: int, family: Family, share: float
) -> None:
    rng = np.random.default_rng(seed)
    greetings = []
    for length in rng.integers(1, 8, 3).tolist():
        X = rng.random((length, 7)).round(1)
        X[rng.random(X.shape) < 0.4] = np.nan
        phases = np.where(rng.random(length) < share, rng.integers(1, 7, length), -1)
        greetings.append(greeting(X, phases.tolist()))
    if all(np.isnan(g.values).all() for g in greetings):
        return
    result = fit(greetings, family=family, starts=1, iterations=10, seed=seed)
    assert np.diff(result.log_posteriors).min(initial=0) >= -1e-7
    assert result.model.transmat.sum(axis=1) - 1 == pytest.approx(np.zeros(6))
    assert (result.model.filter(greetings[0].values) >= 0).all()


# ---- partly labelled


def test_a_few_labels_name_all_states(published: GreetingModel) -> None:
    greetings = sample(published, [40] * 60, seed=2)
    rng = np.random.default_rng(0)
    partly = [
        dataclasses.replace(g, phases=np.where(rng.random(len(g)) < 0.1, g.phases, -1))
        for g in greetings
        if g.phases is not None
    ]
    result = fit(partly, family=Family.GAUSSIAN)
    assert result.assignment is None
    assert len(result.starts) == 1
    phases = np.concatenate([g.phases for g in greetings if g.phases is not None])
    read = np.concatenate([result.model.decode(g.values) for g in greetings])
    assert (read == phases).mean() > 0.97


def test_phases_without_labels_are_found_beside_those_with(published: GreetingModel) -> None:
    greetings = sample(published, [40] * 60, seed=2)
    partly = [
        dataclasses.replace(g, phases=np.where(np.isin(g.phases, [2, 4]), -1, g.phases))
        for g in greetings
        if g.phases is not None
    ]
    result = fit(partly, family=Family.GAUSSIAN, starts=3)
    assert result.assignment is not None
    assert np.isinf(result.assignment.margins).tolist() == [True, False, True, False, True, True]
    np.testing.assert_allclose(result.model.means[:, 4:], published.means[:, 4:], atol=0.15)


# ---- without labels


@pytest.mark.parametrize("seed", range(3))
def test_six_states_are_found_and_named_without_labels(published: GreetingModel, seed: int) -> None:
    greetings = sample(published, [40] * 50, seed=seed)
    result = fit(greetings, labels=False, seed=seed, starts=12)
    assert result.model.family is Family.GAUSSIAN
    assert result.assignment is not None
    assert result.assignment.ambiguous == ()
    phases = np.concatenate([g.phases for g in greetings if g.phases is not None])
    read = np.concatenate([result.model.decode(g.values) for g in greetings])
    assert (read == phases).mean() > 0.97
    heights = [start.log_posterior for start in result.starts]
    assert result.log_posteriors[-1] == max(heights)
    assert len(heights) == 12


def test_the_seed_decides(published: GreetingModel) -> None:
    greetings = sample(published, [20] * 10)
    results = [fit(greetings, labels=False, seed=s, starts=2, iterations=3) for s in (1, 1, 2)]
    assert results[0].log_posteriors == results[1].log_posteriors
    assert results[0].log_posteriors != results[2].log_posteriors


def test_an_initial_model_names_the_states(published: GreetingModel) -> None:
    greetings = sample(published, [40] * 30)
    result = fit(greetings, labels=False, initial=published)
    assert result.assignment is None
    assert result.model.family is published.family
    assert np.diff(result.log_posteriors[1:]).min() >= 0
    assert fit(greetings, initial=published, labels=False, iterations=0).iterations == 0


# ---- what the data do not show


def test_what_is_unknown_is_kendons_and_said_to_be(published: GreetingModel) -> None:
    greetings = []
    for g in sample(published, [30] * 40):
        values = g.values.copy()
        values[:, 4:] = np.nan
        assert g.phases is not None
        values[g.phases == Phase.IA, 3] = np.nan
        phases = np.where(g.phases == Phase.HD, -1, g.phases)
        keep = phases > 0
        greetings.append(greeting(values[keep], phases[keep].tolist()))
    result = fit(greetings, family=Family.GAUSSIAN)
    np.testing.assert_array_equal(result.model.means[:, 4:], published.means[:, 4:])
    np.testing.assert_array_equal(result.model.means[2], published.means[2])
    np.testing.assert_allclose(result.model.transmat[2], published.transmat[2])
    assert result.model.means[0, 3] == published.means[0, 3]
    assert [note.split()[0] for note in result.notes] == ["HD", "dsal,", "smile"]


def test_rows_of_people_who_do_not_greet_are_left_out(small: list[Observations]) -> None:
    values = np.full((4, 7), 0.3)
    passerby = greeting(values, [0, 0, 0, 0], "passerby")
    within = greeting(
        np.concatenate([values, small[0].values, values]),
        [0] * 4 + [*small[0].phases.tolist()] + [0] * 4,  # type: ignore[union-attr]
    )
    plain = fit(small)
    result = fit([within, passerby, small[1]])
    assert result.notes == ("12 rows of people who do not greet (phase 0) left out",)
    assert result.greetings == 2
    np.testing.assert_allclose(result.model.means, plain.model.means)
    np.testing.assert_allclose(result.model.transmat, plain.model.transmat)


def test_moves_that_are_not_allowed_stay_impossible(small: list[Observations]) -> None:
    allowed = np.ones((6, 6), dtype=bool)
    allowed[5, 0] = False
    model = fit(small, allowed=allowed).model
    assert model.transmat[5, 0] == 0
    assert (model.transmat > 0).sum() == 35


def test_a_learned_model_is_the_same_from_its_file(
    published: GreetingModel, tmp_path: Path
) -> None:
    greetings = sample(robust(published), [30] * 20)
    model = fit(greetings).model
    save_model(model, tmp_path / "mine.toml")
    again = load_model(tmp_path / "mine.toml")
    assert again.family is Family.ROBUST
    X = greetings[0].values
    np.testing.assert_allclose(again.filter(X), model.filter(X), atol=1e-12)


# ---- refusals


def test_progress_is_told(small: list[Observations]) -> None:
    told: list[tuple[int, int, float]] = []
    result = fit(small, labels=False, starts=2, progress=lambda *now: told.append(now))
    assert {start for start, _, _ in told} == {0, 1}
    assert max(height for _, _, height in told) == result.log_posteriors[-1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"starts": 0}, "at least once"),
        ({"iterations": -1}, "iterations"),
        ({"gain": float("nan")}, "gain"),
        ({"outliers": 1.0}, "below 1"),
        ({"allowed": np.zeros((6, 6))}, "at least one in each row"),
        ({"allowed": np.ones((6, 6)), "labels": False}, "labels of every phase"),
        ({"allowed": np.eye(6)}, "ann: its labels cannot happen"),
    ],
)
def test_wrong_arguments_are_refused(
    small: list[Observations], arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(ParameterError, match=message):
        fit(small, **arguments)


def test_an_unknown_family_is_refused(small: list[Observations]) -> None:
    with pytest.raises(UnknownNameError, match="gaussian"):
        fit(small, family="gauss")  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", [{"moves": -1}, {"least": (1.0,)}, {"certainty": 0.2}])
def test_an_impossible_prior_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match="prior"):
        Prior(**wrong)


def test_nothing_to_learn_from_is_refused() -> None:
    with pytest.raises(ParameterError, match="no greeting"):
        fit([])
    with pytest.raises(ParameterError, match="no greeting"):
        fit([greeting(np.zeros((2, 7)), [0, 0])])
    with pytest.raises(ParameterError, match="every value is unknown"):
        fit([greeting(np.full((2, 7), np.nan))])


def test_a_wrong_value_is_named() -> None:
    X = np.zeros((3, 7))
    X[1, FEATURES.index("hdip")] = 1.5
    with pytest.raises(ParameterError, match=r"ann: hdip of observation 1 is 1\.5"):
        fit([greeting(X, [1, 2, 3])], family=Family.ROBUST)
    X[2, 0] = np.inf
    with pytest.raises(ParameterError, match="ann: distance of observation 2 is inf"):
        fit([greeting(X)], family=Family.GAUSSIAN)
    with pytest.raises(ParameterError, match="phases are 1 to 6"):
        fit([greeting(np.zeros((1, 7)), [7])])


# ---- samples


def test_samples_are_the_models(published: GreetingModel) -> None:
    [one, two] = sample(published, [5, 9], seed=4)
    assert (len(one), len(two)) == (5, 9)
    assert one.phases is not None
    assert one.phases[0] == Phase.IA
    gestures = np.concatenate([g.values for g in sample(robust(published), [30] * 20)])[:, 4:]
    assert set(np.unique(gestures)) == {0.0, 1.0}
    with pytest.raises(ParameterError, match="at least one row"):
        sample(published, [0])
    assert sample(published, []) == []

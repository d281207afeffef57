"""Conditional learning: the gradient, the ascent, and a reader that gets better."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from kendon.errors import ParameterError
from kendon.models import Family, GreetingModel, fit, load_model
from kendon.models.conditional import PASSING, _Ascent, improve, possible
from kendon.models.em import pack
from kendon.models.emissions import Emissions
from kendon.models.prior import Parameters, Prior
from kendon.models.sampling import sample
from kendon.observations import Observations
from kendon.person import FloatArray, IntArray
from kendon.simulation import simulate

FAMILIES = [Family.GAUSSIAN, Family.ROBUST]


def small(family: Family, rng: np.random.Generator) -> tuple[Parameters, list[FloatArray]]:
    """Three states and some rows with unknown values; gestures between 0 and 1."""
    means = rng.normal(0, 1, (3, 7))
    means[:, 4:] = rng.uniform(0.2, 0.8, (3, 3))
    parameters = Parameters(
        rng.dirichlet(np.ones(3)), rng.dirichlet(np.ones(3), 3), means,
        rng.uniform(0.3, 2.0, (3, 7)), family, 0.05 if family is Family.ROBUST else 0.0,
    )  # fmt: skip
    rows = []
    for length in (4, 1, 6):
        x = rng.normal(0, 1, (length, 7))
        x[:, 4:] = rng.uniform(0.05, 0.95, (length, 3))
        x[rng.random(x.shape) < 0.2] = np.nan
        rows.append(x)
    return parameters, rows


def labels_of(rows: list[FloatArray], rng: np.random.Generator) -> list[IntArray]:
    """Phases of all but the last, who passes by."""
    return [*(rng.integers(0, 3, len(x)) for x in rows[:-1]), np.full(len(rows[-1]), PASSING)]


@pytest.mark.parametrize("family", FAMILIES)
def test_the_slope_is_that_of_finite_differences(family: Family) -> None:
    rng = np.random.default_rng(5)
    begin, rows = small(family, rng)
    labels = labels_of(rows, rng)
    ascent = _Ascent(pack(rows, labels), begin, 2.0, np.ones((3, 3), dtype=bool))
    theta = rng.normal(0, 0.2, ascent.layout.size)

    def cost(at: FloatArray) -> float:
        return ascent.cost(at)[0]

    numerical = approx_fprime(theta, cost, 1e-7)
    assert ascent.cost(theta)[1] == pytest.approx(numerical, abs=2e-6)


@pytest.mark.parametrize("family", FAMILIES)
def test_what_is_improved_are_the_probabilities_of_the_true_phases_by_enumeration(
    family: Family,
) -> None:
    rng = np.random.default_rng(6)
    begin, rows = small(family, rng)
    labels = labels_of(rows, rng)
    ascent = _Ascent(pack(rows, labels), begin, 0.0, np.ones((3, 3), dtype=bool))
    ascent.cost(np.zeros(ascent.layout.size))
    emissions = Emissions(begin.means, begin.variances, family, begin.outliers)
    shares = np.bincount(np.concatenate(labels[:-1]), minlength=3) / sum(map(len, rows[:-1]))
    total = 0.0
    for x, known in zip(rows, labels, strict=True):
        density = np.exp(emissions.log_likelihoods(x))
        # The first three phases are IA, DS and HD: who passes by salutes nobody.
        truth = [{0} if state == PASSING else {state} for state in known.tolist()]

        def joint(path: tuple[int, ...], density: FloatArray = density) -> float:
            p = float(begin.startprob[path[0]])
            for a, b in itertools.pairwise(path):
                p *= float(begin.transmat[a, b])
            return p * float(np.prod([density[t, s] for t, s in enumerate(path)]))

        for t in range(len(x)):
            paths = list(itertools.product(range(3), repeat=t + 1))
            every = sum(joint(path) for path in paths)
            # The rarer a phase, the more its rows count, 1 in mean; passing by counts 1.
            weight = 1.0
            if known[t] != PASSING:
                weight = shares[known[t]] ** -0.3 / (shares**0.7).sum()
            total += weight * math.log(sum(joint(p) for p in paths if p[-1] in truth[t]) / every)
        right = [p for p in paths if all(s in may for s, may in zip(p, truth, strict=True))]
        total += math.log(sum(joint(path) for path in right) / every)
    length = sum(map(len, rows))
    assert ascent.conditional * length == pytest.approx(total / 2)


@pytest.mark.parametrize("family", FAMILIES)
def test_the_conditional_likelihood_rises_within_the_bounds_of_the_prior(family: Family) -> None:
    rng = np.random.default_rng(7)
    begin, rows = small(family, rng)
    labels = labels_of(rows, rng)
    allowed = np.array([[1, 1, 0], [1, 1, 1], [1, 1, 1]], dtype=bool)
    begin = begin._replace(transmat=np.where(allowed, begin.transmat, 0.0))
    begin = possible(begin._replace(transmat=begin.transmat / begin.transmat.sum(1)[:, None]),
                     allowed)  # fmt: skip
    labels = [np.zeros(len(x), dtype=np.int64) for x in rows]
    prior = Prior(least=(0.5,) * 7, certainty=0.9, tightness=0.1)
    steps: list[float] = []
    found = improve(pack(rows, labels), begin, prior, allowed, iterations=30,
                    progress=lambda _, height: steps.append(height))  # fmt: skip
    assert found.after > found.before
    assert found.iterations == len(steps)
    normal = 4 if family is Family.ROBUST else 7
    least = np.minimum(0.25, begin.variances[:, :normal])
    assert (found.parameters.variances[:, :normal] >= least - 1e-9).all()
    if family is Family.ROBUST:
        assert (found.parameters.means[:, 4:] <= 0.9 + 1e-9).all()
        assert (found.parameters.means[:, 4:] >= 0.1 - 1e-9).all()
    assert found.parameters.transmat[0, 2] == 0.0
    assert found.parameters.transmat.sum(axis=1) == pytest.approx(1.0)


def accuracy(model: GreetingModel, greetings: list[Observations]) -> float:
    hits = [model.filter(g.values).argmax(axis=1) + 1 == g.phases for g in greetings]
    return float(np.concatenate(hits).mean())


def test_it_reads_phases_better_than_counting_where_features_last() -> None:
    # A smile that stays for the whole greeting misleads a model which takes it for news.
    truth = load_model("kendon")
    rng = np.random.default_rng(8)

    def draw(seed: int) -> list[Observations]:
        greetings = sample(truth, [25] * 150, seed)
        for greeting in greetings:
            greeting.values[:, 3] += rng.normal(0, 2.0)
        return greetings

    learned_from, tested_on = draw(1), draw(2)
    counted = fit(learned_from, family=Family.GAUSSIAN).model
    better = fit(learned_from, family=Family.GAUSSIAN, conditional=True).model
    assert accuracy(better, tested_on) > accuracy(counted, tested_on)


def test_it_goes_on_from_a_model_whose_moves_the_greetings_contradict() -> None:
    phases = np.array([6, 1, 2])  # Kendon's CS never ends
    values = np.tile(load_model("kendon").means[0], (3, 1))
    greeting = Observations(np.array([0.2, 0.4, 0.6]), values, phases)
    result = fit([greeting], conditional=True, initial=load_model("kendon"))
    assert result.improvement is not None
    assert result.improvement.after > result.improvement.before
    assert result.model.transmat[5, 0] > 0


def test_it_learns_to_read_no_salutation_in_people_who_pass_by() -> None:
    greetings = simulate(40, 3)
    passing, tested_on = (simulate(20, seed, passersby=1.0) for seed in (4, 5))
    for person in (*greetings, *passing, *tested_on):
        person.values[:, 4:] = np.nan  # nobody tells of gestures, which would tell all

    def saluting(model: GreetingModel) -> float:
        beliefs = np.concatenate([model.filter(person.values) for person in tested_on])
        return float(beliefs[:, [1, 2, 5]].sum(axis=1).mean())

    prior = Prior(tightness=30.0)
    kendon = load_model("kendon")
    without = fit(greetings, conditional=True, initial=kendon, prior=prior)
    with_them = fit([*greetings, *passing], conditional=True, initial=kendon, prior=prior)
    assert saluting(with_them.model) < 0.5 * saluting(without.model)
    assert with_them.greetings == 40


def test_every_row_needs_its_phase() -> None:
    greeting = Observations(np.array([0.2, 0.4, 0.6]), np.zeros((3, 7)), np.array([1, -1, 6]))
    with pytest.raises(ParameterError, match="true phase on every row"):
        fit([greeting], conditional=True)

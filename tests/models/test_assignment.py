"""Names for states: permutations undone, doubts told."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from kendon.errors import ParameterError
from kendon.models import Family, GreetingModel, load_model
from kendon.models.assignment import assign
from kendon.models.prior import Parameters
from kendon.phases import Phase


def shuffled(model: GreetingModel, order: list[int]) -> Parameters:
    return Parameters(
        model.startprob[order],
        model.transmat[np.ix_(order, order)],
        model.means[order],
        model.variances[order],
        model.family,
        model.outliers,
    )


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("name", ["kendon", "data-driven"])
def test_shuffled_states_get_their_names_back(name: str, seed: int) -> None:
    # Of the learned model of a small room, too: the thesis named its states by hand (3.5.3).
    order = np.random.default_rng(seed).permutation(6).tolist()
    found = assign(shuffled(load_model(name), order), load_model("kendon"))
    assert found.phases == tuple(Phase(i + 1) for i in order)
    assert [order[i] for i in found.order] == list(range(6))
    # In a small room the approach and its end are much alike (3.5.4).
    assert found.ambiguous == (() if name == "kendon" else (Phase.APP, Phase.FA))


def test_the_names_do_not_depend_on_the_family() -> None:
    model = load_model("kendon")
    means = model.means.copy()
    means[:, 4:] = means[:, 4:].clip(0.1, 0.9)
    robust = dataclasses.replace(model, means=means, family=Family.ROBUST)
    assert assign(shuffled(robust, [3, 1, 5, 0, 2, 4]), model).phases == tuple(
        map(Phase, (4, 2, 6, 1, 3, 5))
    )


def test_a_margin_is_what_the_next_best_naming_costs_more() -> None:
    model = load_model("kendon")
    found = assign(shuffled(load_model("data-driven"), [2, 0, 1, 5, 4, 3]), model)
    totals = {
        naming: sum(found.costs[state, phase] for state, phase in enumerate(naming))
        for naming in itertools.permutations(range(6))
    }
    best = tuple(phase.index for phase in found.phases)
    assert totals[best] == pytest.approx(min(totals.values()))
    for state in range(6):
        others = [total for naming, total in totals.items() if naming[state] != best[state]]
        assert found.margins[state] == pytest.approx(min(others) - totals[best])


def test_states_that_are_alike_are_ambiguous() -> None:
    model = load_model("kendon")
    twins = shuffled(model, list(range(6)))
    twins.means[2], twins.variances[2] = twins.means[3], twins.variances[3]
    twins.transmat[2], twins.startprob[2] = twins.transmat[3], twins.startprob[3]
    twins.transmat[:, 2] = twins.transmat[:, 3] = twins.transmat[:, 2:4].mean(axis=1)
    found = assign(twins, model)
    assert set(found.ambiguous) == {Phase.HD, Phase.APP}
    assert "ambiguous: as like to" in str(found)
    assert str(found).count("\n") == 6


def test_without_gestures_they_are_not_compared() -> None:
    model = load_model("kendon")
    seen = shuffled(model, list(range(6)))
    seen.means[:, 4:] = 7.0
    known = (True,) * 4 + (False,) * 3
    found = assign(seen, model, known=known)
    assert found.phases == tuple(Phase)
    assert (found.costs.diagonal() == 0).all()
    everything = assign(seen, model)
    assert (found.margins < everything.margins + 1e-9).all()


def test_given_names_are_kept() -> None:
    model = load_model("kendon")
    given = {0: Phase.CS, 3: Phase.DS}
    found = assign(shuffled(model, list(range(6))), model, given=given)
    assert found.phases[0] is Phase.CS
    assert found.phases[3] is Phase.DS
    assert sorted(found.phases) == list(Phase)
    assert np.isinf(found.margins[[0, 3]]).all()
    assert "given by labels" in str(found)
    with pytest.raises(ParameterError, match="same phase"):
        assign(shuffled(model, list(range(6))), model, given={0: Phase.CS, 1: Phase.CS})

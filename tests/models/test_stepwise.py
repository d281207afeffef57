"""The filter's score on true phases."""

from __future__ import annotations

import numpy as np
import pytest

from kendon.models import load_model
from kendon.models.em import pack
from kendon.models.learned_emissions import evaluate
from kendon.models.prior import Parameters
from kendon.models.sampling import sample
from kendon.models.stepwise import stepwise


@pytest.mark.parametrize("wild", [0.0, 500.0])
def test_the_score_is_that_of_the_filters_beliefs(wild: float) -> None:
    model = load_model("kendon")
    greetings = sample(model, [25, 3, 1, 40], 3)
    greetings[0].values[4, 0] += wild  # nobody is there: every density vanishes
    labels = [np.asarray(greeting.phases) - 1 for greeting in greetings]
    (chunk,) = pack([greeting.values for greeting in greetings], labels).chunks
    parameters = Parameters(model.startprob, model.transmat, model.means, model.variances)
    center = pack([greeting.values for greeting in greetings]).center
    log = evaluate(chunk, center, parameters).log
    assert chunk.labels is not None
    truth = np.asarray(chunk.labels == np.arange(6)[:, None])
    weights = np.ones(chunk.labels.shape)
    found = stepwise(model.startprob, model.transmat, log, chunk, truth, weights)
    beliefs = [model.filter(greeting.values) for greeting in greetings]
    told = [b[np.arange(len(b)), y] for b, y in zip(beliefs, labels, strict=True)]
    expected = np.log(np.maximum(np.concatenate(told), 1e-300)).sum()
    assert found.log_likelihood == pytest.approx(expected, rel=1e-9)
    for part in found[1:]:
        assert np.isfinite(part).all()

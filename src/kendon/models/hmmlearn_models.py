"""Models to and from hmmlearn's `GaussianHMM`, the common tool for Gaussian hidden Markov models.

hmmlearn knows Gaussian emissions only and takes no unknown values; what both can express goes
over unchanged, to the last bit. Needs the extra ``hmmlearn``.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kendon.errors import MissingExtraError, ParameterError
from kendon.models.assignment import Assignment, assign
from kendon.models.emissions import Family
from kendon.models.greeting import GreetingModel
from kendon.models.library import load_model
from kendon.models.prior import Parameters
from kendon.observations import FEATURES
from kendon.person import FloatArray
from kendon.phases import PHASE_NAMES

#: What a trained GaussianHMM has.
_LEARNED = ("startprob_", "transmat_", "means_", "covars_")
_SHAPE = (len(PHASE_NAMES), len(FEATURES))
#: A covariance is none if it is smaller than this share of the two standard deviations' product:
#: nothing but rounding.
_UNCORRELATED = 1e-9


def to_hmmlearn(model: GreetingModel) -> Any:
    """The same model as an `hmmlearn.hmm.GaussianHMM` of six states with diagonal covariances.

    State i is phase i + 1. Its `fit` goes on from the model's parameters instead of forgetting
    them (``init_params`` is empty).

    Raises:
        ParameterError: the model is of the robust family.
        MissingExtraError: hmmlearn is not installed.

    >>> from kendon.models import load_model, sample
    >>> model = load_model("kendon")
    >>> [greeting] = sample(model, [20], seed=1)
    >>> hmm = to_hmmlearn(model)
    >>> bool(np.isclose(hmm.score(greeting.values), model.log_likelihood(greeting.values)))
    True
    """
    if model.family is not Family.GAUSSIAN:
        raise ParameterError(
            f"model {model.name!r} is of the {model.family} family, whose outliers and gestures"
            " hmmlearn's normal distributions cannot express; learn it with --family gaussian"
        )
    hmm = _gaussian_hmm()(len(PHASE_NAMES), covariance_type="diag", init_params="")
    hmm.n_features = len(FEATURES)
    hmm.startprob_, hmm.transmat_ = model.startprob.copy(), model.transmat.copy()
    hmm.means_, hmm.covars_ = model.means.copy(), model.variances
    return hmm


def from_hmmlearn(
    hmm: Any, order: Sequence[int] | None = None, *, name: str = "hmmlearn"
) -> GreetingModel:
    """A greeting model of an `hmmlearn.hmm.GaussianHMM`.

    Args:
        hmm: trained on the seven features in the order of FEATURES, in kendon's units.
        order: the state of each phase, IA first. States learned without labels come in any
            order: `name_states` finds this one. By default state i is phase i + 1.
        name: of the new model.

    Raises:
        ParameterError: it is no trained GaussianHMM of six states and seven features, its
            features are correlated within a state, or the order does not name each state once.
        MissingExtraError: hmmlearn is not installed.

    >>> from kendon.models import load_model
    >>> hmm = to_hmmlearn(load_model("kendon"))
    >>> back = from_hmmlearn(hmm, name_states(hmm).order)
    >>> bool((back.means == load_model("kendon").means).all())
    True
    """
    model = _model(hmm, name)
    if order is None:
        return model
    states = list(order)
    if sorted(states) != list(range(len(PHASE_NAMES))):
        raise ParameterError(
            f"the order names the state, 0 to {len(PHASE_NAMES) - 1}, of each of"
            f" {', '.join(PHASE_NAMES)} once; not {states}"
        )
    return replace(
        model,
        startprob=model.startprob[states],
        transmat=model.transmat[np.ix_(states, states)],
        means=model.means[states],
        variances=model.variances[states],
    )


def name_states(hmm: Any, reference: GreetingModel | None = None) -> Assignment:
    """Which state of an `hmmlearn.hmm.GaussianHMM` is which phase, by likeness to a model's.

    Args:
        hmm: as for `from_hmmlearn`.
        reference: whose phases its states are compared with; the Kendon model by default.

    Returns:
        Its `order` is for `from_hmmlearn`; printed, it shows how sure each name is.

    Raises:
        ParameterError: as `from_hmmlearn` does.
        MissingExtraError: hmmlearn is not installed.
    """
    model = _model(hmm, "hmmlearn")
    parameters = Parameters(model.startprob, model.transmat, model.means, model.variances)
    return assign(parameters, load_model("kendon") if reference is None else reference)


def _gaussian_hmm() -> Any:
    try:
        from hmmlearn.hmm import GaussianHMM
    except ImportError:
        raise MissingExtraError("converting models", "hmmlearn", "hmmlearn") from None
    return GaussianHMM


def _model(hmm: Any, name: str) -> GreetingModel:
    """The model whose phases are the states of a GaussianHMM in their order.

    Raises:
        ParameterError: see `from_hmmlearn`.
    """
    if not isinstance(hmm, _gaussian_hmm()):
        raise ParameterError(
            f"an hmmlearn.hmm.GaussianHMM becomes a greeting model, not a {type(hmm).__name__}"
        )
    hmm = copy.copy(hmm)
    hmm.n_features = len(FEATURES)  # hmmlearn knows only after training, and needs it for covars_
    missing = [part for part in _LEARNED if not hasattr(hmm, part)]
    if missing:
        raise ParameterError(
            f"the GaussianHMM has no {', '.join(missing)} yet: train it with fit, or set them"
        )
    if hmm.n_components != len(PHASE_NAMES):
        raise ParameterError(
            f"the GaussianHMM has {hmm.n_components} states; a greeting has"
            f" {len(PHASE_NAMES)} phases: {', '.join(PHASE_NAMES)}"
        )
    if np.shape(hmm.means_) != _SHAPE:
        raise ParameterError(
            f"the GaussianHMM's means_ have shape {np.shape(hmm.means_)} instead of {_SHAPE};"
            f" the features are {', '.join(FEATURES)}"
        )
    return GreetingModel(
        hmm.startprob_,
        hmm.transmat_,
        hmm.means_,
        _variances(hmm),
        name=name,
        title="A model from hmmlearn",
        source="hmmlearn.hmm.GaussianHMM",
    )


def _variances(hmm: Any) -> FloatArray:
    """The diagonals of a GaussianHMM's covariance matrices, which must have nothing else."""
    covariances = np.asarray(hmm.covars_)
    if hmm.covariance_type == "spherical" and len(covariances) == np.prod(_SHAPE):
        # Trained ones have the matrix of each state as many times as there are features.
        covariances = covariances[:: len(FEATURES)]
    if covariances.shape != (*_SHAPE, len(FEATURES)):
        raise ParameterError(
            f"the GaussianHMM's covars_ are {covariances.shape[0]} matrices of"
            f" {covariances.shape[1:]} instead of {len(PHASE_NAMES)} of {_SHAPE[1:] * 2}"
        )
    variances = np.diagonal(covariances, axis1=1, axis2=2).copy()
    spread = np.sqrt(np.abs(variances))
    aside = np.abs(covariances) > _UNCORRELATED * spread[:, None] * spread[:, :, None]
    aside &= ~np.eye(len(FEATURES), dtype=bool)
    if aside.any():
        state, one, other = (int(place) for place in np.argwhere(aside)[0])
        raise ParameterError(
            f"the GaussianHMM's state {state} correlates {FEATURES[one]} with {FEATURES[other]}"
            f" (covariance_type={hmm.covariance_type!r}); kendon's features are independent within"
            " a phase: train with covariance_type='diag' or 'spherical'"
        )
    return variances

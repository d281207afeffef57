"""The greeting model: six phases, seven features, a belief that follows a person."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kendon.errors import ParameterError, UnknownNameError
from kendon.models import hmm
from kendon.models.emissions import GESTURES_FROM, Emissions, Family
from kendon.observations import FEATURES, Observation
from kendon.person import FloatArray, IntArray
from kendon.phases import Phase

_PHASES = len(Phase)
_FEATURES = len(FEATURES)

#: A smaller number is zero for all that arithmetic can do with it.
_SMALLEST_VARIANCE = float(np.finfo(float).tiny)


#: No feature in its unit comes near this; what does is a mistake, and its square might overflow.
LARGEST = 1e6


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """The distribution over phases after the observations so far, P(phase_t | o_1..o_t)."""

    probabilities: FloatArray  # (6,), in the order of the phases' numbers

    @property
    def phase(self) -> Phase:
        """The most probable phase (thesis Algorithm 1, line 27)."""
        return Phase(int(self.probabilities.argmax()) + 1)


@dataclass(frozen=True, eq=False)
class GreetingModel:
    """A Gaussian HMM over Kendon's phases with diagonal covariances (thesis 2.2, 3.4).

    Raises:
        ParameterError: a shape is wrong, a value is not finite, probabilities are negative or
            do not sum to one (within 0.002, the thesis's rounding; they are then normalised),
            or a variance is not positive.
    """

    startprob: FloatArray  # (6,)
    transmat: FloatArray  # (6, 6), from row to column
    means: FloatArray  # (6, 7), SI units
    variances: FloatArray  # (6, 7), SI units squared
    family: Family = Family.GAUSSIAN
    outliers: float = 0.0  # probability of a value from nowhere, robust family only
    name: str = "unnamed"
    title: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        shapes = {
            "startprob": (_PHASES,),
            "transmat": (_PHASES, _PHASES),
            "means": (_PHASES, _FEATURES),
            "variances": (_PHASES, _FEATURES),
        }
        for field, shape in shapes.items():
            value = self._numbers(field)
            if value.shape != shape:
                raise ParameterError(
                    f"model {self.name!r}: {field} has shape {value.shape} instead of {shape}"
                )
            if not np.isfinite(value).all():
                raise ParameterError(
                    f"model {self.name!r}: {field} holds a value that is not finite"
                )
            if field in ("startprob", "transmat"):
                if (value < 0).any():
                    raise ParameterError(
                        f"model {self.name!r}: {field} holds a negative probability,"
                        f" {value.min():g}"
                    )
                with np.errstate(over="ignore"):
                    total = value.sum(axis=-1, keepdims=True)
                if (abs(total - 1) > 2e-3).any():
                    raise ParameterError(
                        f"model {self.name!r}: {field} must hold probabilities that sum to 1"
                        f"{' in each row' if field == 'transmat' else ''},"
                        f" not {np.array2string(total.ravel(), precision=4)}"
                    )
                # What sums to one but for rounding stays as it was given.
                value = value / np.where(abs(total - 1) < 1e-12, 1.0, total)
            elif field == "variances" and (value < _SMALLEST_VARIANCE).any():
                raise ParameterError(
                    f"model {self.name!r}: every variance must be positive, not {value.min():g}"
                )
            value.setflags(write=False)
            object.__setattr__(self, field, value)
        self._check_family()

    def _check_family(self) -> None:
        if self.family not in list(Family):
            raise UnknownNameError("family of emissions", self.family, Family)
        object.__setattr__(self, "family", Family(self.family))  # from a file it is a word
        if not 0 <= self.outliers < 1 or (self.outliers and self.family is Family.GAUSSIAN):
            raise ParameterError(
                f"model {self.name!r}: outliers is a probability below 1, and of the robust family"
                f" only; not {self.outliers}"
            )
        gestures = self.means[:, GESTURES_FROM:]
        if self.family is Family.ROBUST and not ((gestures > 0) & (gestures < 1)).all():
            raise ParameterError(
                f"model {self.name!r}: a robust gesture's mean is its probability,"
                " more than 0 and less than 1"
            )

    def _numbers(self, field: str) -> FloatArray:
        try:
            return np.array(getattr(self, field), dtype=float)
        except (TypeError, ValueError):
            raise ParameterError(
                f"model {self.name!r}: {field} must hold numbers, in rows of equal length"
            ) from None

    def filter(self, X: FloatArray) -> FloatArray:
        """The belief after each observation, P(phase_t | x_1..x_t) (thesis Algorithm 1).

        Args:
            X: observations, shape (T, 7) in the order of FEATURES, NaN = unknown.

        Returns:
            Shape (T, 6), rows sum to one.

        Raises:
            ParameterError: X has another shape or holds a value beyond all measure.
        """
        return self.forward(X).probabilities

    def forward(self, X: FloatArray) -> hmm.Filtered:
        """Filtered and predicted probabilities and the log-likelihood in one pass.

        Raises:
            ParameterError: X has another shape or holds a value beyond all measure.
        """
        return hmm.forward(self.startprob, self.transmat, self._log_emissions(X))

    def decode(self, X: FloatArray) -> IntArray:
        """The most probable sequence of phases, numbers 1-6, shape (T,) (thesis 2.7-2.12).

        Raises:
            ParameterError: X has another shape or holds a value beyond all measure.
        """
        return hmm.viterbi(self.startprob, self.transmat, self._log_emissions(X))[0] + 1

    def log_likelihood(self, X: FloatArray) -> float:
        """Log P(X | model) over its known values (thesis 2.6).

        Raises:
            ParameterError: X has another shape or holds a value beyond all measure.
        """
        return self.forward(X).log_likelihood

    def tracker(self) -> Tracker:
        """A tracker that has seen nothing yet."""
        return Tracker(self)

    @functools.cached_property
    def emissions(self) -> Emissions:
        """The emissions, prepared for evaluation."""
        return Emissions(self.means, self.variances, self.family, self.outliers)

    def _log_emissions(self, X: FloatArray) -> FloatArray:
        X = _as_numbers(X)
        if X.ndim != 2 or X.shape[1] != _FEATURES or not len(X):
            raise ParameterError(
                f"observations have shape (T, {_FEATURES}) with T at least 1, not {X.shape};"
                f" the columns are {', '.join(FEATURES)}"
            )
        beyond = (np.abs(X) > LARGEST).any(axis=1)  # False for NaN
        if beyond.any():
            row = int(np.argmax(beyond))
            raise ParameterError(
                f"observation {row} holds a value beyond all measure, {X[row]}; use NaN for unknown"
            )
        return self.emissions.log_likelihoods(X)


class Tracker:
    """Follows one greeting, one observation at a time; gives what the batch filter gives."""

    def __init__(self, model: GreetingModel) -> None:
        self.model = model
        self._emissions = model.emissions
        self._log_startprob: list[float] = hmm.log_probabilities(model.startprob).tolist()
        self._transitions = hmm.Transitions.of(model.transmat)
        self._prediction = self._log_startprob

    def step(self, x: FloatArray | Sequence[float] | Observation) -> Belief:
        """Take in the next observation and return the belief after it (thesis Algorithm 1).

        Args:
            x: the seven features in the order of FEATURES, or an Observation; NaN = unknown.

        Raises:
            ParameterError: there are not seven, or one is beyond all measure.
        """
        values = list(x[1:]) if isinstance(x, Observation) else _as_numbers(x).tolist()
        if not isinstance(values, list) or len(values) != _FEATURES:
            raise ParameterError(
                f"an observation has {_FEATURES} features ({', '.join(FEATURES)}), not {x!r:.60}"
            )
        if any(abs(v) > LARGEST for v in values):  # False for NaN
            raise ParameterError(
                f"an observation holds a value beyond all measure, {values}; use NaN for unknown"
            )
        log_belief, _ = hmm.condition(self._prediction, self._emissions.log_likelihood(values))
        self._prediction = hmm.predict(log_belief, self._transitions)
        return Belief(np.exp(log_belief))

    def reset(self) -> None:
        """Forget everything: the next observation is the first of a greeting."""
        self._prediction = self._log_startprob


def _as_numbers(values: object) -> FloatArray:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ParameterError(
            f"observations hold numbers, NaN for unknown, in rows of {_FEATURES}:"
            f" {', '.join(FEATURES)}"
        ) from None

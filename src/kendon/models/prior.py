"""What is believed of a model before there are data, and the M-step (thesis 2.15, 2.16).

Every part of the prior reads as so many further rows or moves, in the units of the data, so that
few greetings never give a probability of zero, a variance of zero or a division by zero.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kendon.errors import ParameterError
from kendon.models.emissions import GESTURES_FROM, Family
from kendon.observations import FEATURES
from kendon.person import FloatArray

#: Without a prior a probability may come to 0 and a variance too, which no model can have.
_LEAST_PROBABILITY = 1e-12
_LEAST_VARIANCE = 1e-12


class Parameters(NamedTuple):
    """What EM learns, and the family it learns it for; K states, F features."""

    startprob: FloatArray  # (K,)
    transmat: FloatArray  # (K, K)
    means: FloatArray  # (K, F); of a robust gesture, the probability q that it is there
    variances: FloatArray  # (K, F); of a robust gesture, q (1 - q)
    family: Family = Family.GAUSSIAN
    outliers: float = 0.0


class Expected(NamedTuple):
    """What the E-step expects over all data."""

    starts: FloatArray  # (K,), number of greetings that begin in each state
    moves: FloatArray  # (K, K), number of moves from row to column
    emissions: FloatArray  # (K, F, 3), see `learned_emissions.statistics`


@dataclass(frozen=True)
class Prior:
    """A prior of the parameters: Dirichlet, normal-inverse-gamma and Beta.

    The default is weak: a greeting of 25 rows outweighs it. The deviations are the smallest that
    the published Kendon model has. No phase may be narrower than that either: a state that shrinks
    to what a few rows have in common (all quite still, none smiling) gains likelihood without
    end and tells nothing of greetings. That of a Gaussian gesture keeps a detector's 0.5, half
    way, 2.5 deviations from both ends, even if all gestures of the training were keys, 0 or 1.

    Raises:
        ParameterError: a number is negative, not finite, or out of its range.
    """

    starts: float = 0.1  # further beginnings in each state (Dirichlet)
    moves: float = 0.1  # further moves from each state to each (Dirichlet)
    means: float = 0.01  # further rows at the mean of all data, per state (normal)
    variances: float = 2.0  # further rows of `deviations`, per state (inverse gamma)
    deviations: tuple[float, ...] = (0.4, 0.15, 0.5, 0.8, 0.2, 0.2, 0.2)
    least: tuple[float, ...] = (0.4, 0.15, 0.5, 0.8, 0.2, 0.2, 0.2)  # no deviation is smaller
    gestures: float = 1.0  # further rows with and as many without a robust gesture (Beta)
    certainty: float = 0.99  # no gesture of a phase is more certain, to be there or not
    tightness: float = 10.0  # rows a squared unit, about the model that is improved conditionally

    def __post_init__(self) -> None:
        for field in fields(self):
            value = np.asarray(getattr(self, field.name), dtype=float)
            if not (np.isfinite(value).all() and (value >= 0).all()):
                raise ParameterError(
                    f"prior: {field.name} must be finite and not negative, not {value}"
                )
        for name in ("deviations", "least"):
            if len(getattr(self, name)) != len(FEATURES):
                raise ParameterError(
                    f"prior: {name} needs a number for each of {', '.join(FEATURES)}"
                )
        if not 0.5 < self.certainty <= 1:
            raise ParameterError(
                f"prior: certainty lies between 0.5 and 1, not at {self.certainty}"
            )

    @classmethod
    def none(cls) -> Prior:
        """No prior at all: maximum likelihood, with all its dangers."""
        nothing = (0.0,) * len(FEATURES)
        return cls(0.0, 0.0, 0.0, 0.0, nothing, nothing, 0.0, 1.0)

    def log_density(
        self, parameters: Parameters, center: FloatArray, allowed: NDArray[np.bool_]
    ) -> float:
        """Log prior density of parameters but for a constant; what EM adds to the likelihood.

        Args:
            parameters: of K states.
            center: (F,), mean of all data.
            allowed: (K, K), the moves that can be.
        """
        total = 0.0
        with np.errstate(divide="ignore"):
            if self.starts:
                total += self.starts * float(np.log(parameters.startprob).sum())
            if self.moves:
                total += self.moves * float(np.log(parameters.transmat[allowed]).sum())
        normal = _normal_features(parameters.family, len(center))
        m, v = parameters.means[:, normal], parameters.variances[:, normal]
        squares = self.variances * np.square(self.deviations)[normal]
        squares = squares + self.means * np.square(m - center[normal])
        total -= 0.5 * float((self.variances * np.log(v) + squares / v).sum())
        if parameters.family is Family.ROBUST and self.gestures:
            q = parameters.means[:, GESTURES_FROM:]
            total += self.gestures * float((np.log(q) + np.log1p(-q)).sum())
        return total

    def maximise(
        self,
        expected: Expected,
        old: Parameters,
        center: FloatArray,
        allowed: NDArray[np.bool_],
    ) -> Parameters:
        """The M-step: the most probable parameters (thesis 2.15, 2.16).

        What the data say nothing about, and no prior either, stays as it was.

        Args:
            expected: the statistics of the E-step.
            old: the parameters before.
            center: (F,), what was taken off the values.
            allowed: (K, K), the moves that can be.
        """
        startprob = _share(expected.starts + self.starts, old.startprob)
        transmat = _share(expected.moves + self.moves * allowed, old.transmat)
        weight, total, squares = np.moveaxis(expected.emissions, 2, 0)
        with np.errstate(invalid="ignore", divide="ignore"):
            means = total / (weight + self.means)
            about = squares - 2 * means * total + means * means * (weight + self.means)
            variances = about.clip(0) + self.variances * np.square(self.deviations)
            variances /= weight + self.variances
        nothing = weight + self.means == 0
        means = np.where(nothing, old.means, means + center)
        variances = np.where(weight + self.variances == 0, old.variances, variances)
        least = np.maximum(np.square(self.least), _LEAST_VARIANCE)
        variances = np.maximum(variances, least)
        if old.family is Family.ROBUST:
            hands = slice(GESTURES_FROM, None)
            rows = weight[:, hands] + 2 * self.gestures
            with np.errstate(invalid="ignore", divide="ignore"):
                q = (total[:, hands] + self.gestures) / rows
            surest = min(self.certainty, 1 - _LEAST_PROBABILITY)
            q = np.where(rows == 0, old.means[:, hands], q).clip(1 - surest, surest)
            means[:, hands], variances[:, hands] = q, q * (1 - q)
        return Parameters(startprob, transmat, means, variances, old.family, old.outliers)


def _normal_features(family: Family, features: int) -> slice:
    return slice(0, features if family is Family.GAUSSIAN else GESTURES_FROM)


def _share(counts: FloatArray, old: FloatArray) -> FloatArray:
    """Rows that sum to one; one without any count stays as it was."""
    total = counts.sum(axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(total > 0, counts / total, old))

"""Which state is which phase: names for the states that learning without labels has found.

The thesis names the states of its learned model by their likeness to the Kendon model (3.5.3).
Here likeness is a number. A state and a phase differ in each feature's mean and in when they
happen, counted in units of spread and squared; the states are named so that the differences add
up to the least (the assignment problem, Kuhn 1955). How sure a name is shows in its margin: how
much the best of all namings gets worse that gives the state any other phase.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kendon.errors import ParameterError
from kendon.models.emissions import GESTURES_FROM, Family
from kendon.models.greeting import GreetingModel
from kendon.models.prior import Parameters
from kendon.observations import FEATURES
from kendon.person import FloatArray
from kendon.phases import PHASE_NAMES, Phase

#: A difference counts no more than three spreads in any one feature: where people stand differs
#: between a hall and a small room (3.5.4), and must not outvote all else.
_MOST = 9.0
#: A margin below this, two spreads in one feature, is a name that might as well be another.
AMBIGUOUS = 4.0
#: Steps over which one looks when states happen: 10 s, a greeting.
_HORIZON = 50
#: A gesture's probability comes from a detector: its spread is never less.
_GESTURE_SPREAD = 0.2


@dataclass(frozen=True, eq=False)
class Assignment:
    """The phases of states, and how sure they are."""

    phases: tuple[Phase, ...]  # (K,), of each state in the order they were found
    costs: FloatArray  # (K, K), how much a state (row) differs from a phase (column)
    margins: FloatArray  # (K,), by how much another name would be worse; inf: it was given

    @property
    def ambiguous(self) -> tuple[Phase, ...]:
        """The phases whose state might as well have been named otherwise, in their order."""
        return tuple(
            sorted(p for p, m in zip(self.phases, self.margins, strict=True) if m < AMBIGUOUS)
        )

    @property
    def order(self) -> list[int]:
        """The state of each phase, in the order of the phases."""
        return [self.phases.index(phase) for phase in Phase]

    def rows(self) -> list[tuple[str, str, str, str]]:
        """For people: phase, its difference from Kendon's, margin, a remark; in phases' order."""
        table = []
        for phase, state in zip(Phase, self.order, strict=True):
            margin = float(self.margins[state])
            if np.isinf(margin):
                table.append((phase.name, "–", "–", "given by labels"))
                continue
            cost = float(self.costs[state, phase.index])
            remark = ""
            if margin < AMBIGUOUS:
                rivals = self.costs[state].copy()
                rivals[phase.index] = np.inf
                remark = f"ambiguous: as like to {PHASE_NAMES[int(rivals.argmin())]}"
            table.append((phase.name, f"{cost:.1f}", f"{margin:.1f}", remark))
        return table

    def __str__(self) -> str:
        head = ("phase", "difference", "margin", "")
        return "\n".join(
            f"{a:<7}{b:>10}{c:>8}  {d}".rstrip() for a, b, c, d in [head, *self.rows()]
        )


def assign(
    parameters: Parameters,
    reference: GreetingModel,
    *,
    given: Mapping[int, Phase] | None = None,
    known: tuple[bool, ...] = (True,) * len(FEATURES),
) -> Assignment:
    """Name the states of learned parameters after the phases of a model that they are like.

    Args:
        parameters: of six states.
        reference: whose phases they are compared with.
        given: states that have their phase already.
        known: the features that the data told anything about; others are not compared.

    Raises:
        ParameterError: two states are given the same phase.
    """
    given = given or {}
    if len(set(given.values())) < len(given):
        raise ParameterError("two states cannot be the same phase")
    costs = _costs(parameters, reference, np.array(known))
    forbidden = np.zeros(costs.shape, dtype=bool)
    for state, phase in given.items():
        forbidden[state, :] = forbidden[:, phase.index] = True
        forbidden[state, phase.index] = False
    chosen, best = _solve(costs, forbidden)
    margins = np.full(len(costs), np.inf)
    for state, phase_index in enumerate(chosen):
        if state in given or len(given) >= len(costs) - 1:
            continue
        otherwise = forbidden.copy()
        otherwise[state, phase_index] = True
        margins[state] = _solve(costs, otherwise)[1] - best
    return Assignment(tuple(Phase(i + 1) for i in chosen), costs, margins)


def _solve(costs: FloatArray, forbidden: FloatArray) -> tuple[list[int], float]:
    """The best phase index of each state, and the sum of its costs."""
    # Imported here: it takes as long as the rest of kendon, and only learning needs it.
    from scipy.optimize import linear_sum_assignment

    # Large instead of infinite: an assignment always exists.
    prices = np.where(forbidden, 1e6, costs)
    rows, columns = linear_sum_assignment(prices)
    return columns.tolist(), float(prices[rows, columns].sum())


def _costs(parameters: Parameters, reference: GreetingModel, known: FloatArray) -> FloatArray:
    spreads = [_spreads(p.variances, p.means, p.family) for p in (parameters, reference)]
    means = [parameters.means, reference.means]
    times = [_times(p.startprob, p.transmat) for p in (parameters, reference)]
    m, v = (
        [
            np.concatenate([table, time[:, None]], axis=1)
            for table, time in zip(tables, columns, strict=True)
        ]
        for tables, columns in ((means, [t[0] for t in times]), (spreads, [t[1] for t in times]))
    )
    squares = (m[0][:, None] - m[1][None]) ** 2 / (0.5 * (v[0][:, None] + v[1][None]))
    return np.asarray((squares.clip(max=_MOST) * np.append(known, True)).sum(axis=2))


def _spreads(variances: FloatArray, means: FloatArray, family: Family) -> FloatArray:
    variances = variances.copy()
    hands = slice(GESTURES_FROM, None)
    if family is Family.ROBUST:
        variances[:, hands] = 0.0  # q is a number, not a distribution
    variances[:, hands] = np.maximum(variances[:, hands], _GESTURE_SPREAD**2)
    return variances


def _times(startprob: FloatArray, transmat: FloatArray) -> tuple[FloatArray, FloatArray]:
    """When each state happens, in steps: mean and variance, (K,) each."""
    presence = np.empty((_HORIZON, len(startprob)))
    presence[0] = startprob
    for t in range(1, _HORIZON):
        presence[t] = presence[t - 1] @ transmat
    steps = np.arange(_HORIZON)
    weights = presence / np.maximum(presence.sum(axis=0), 1e-12)
    mean = steps @ weights
    return mean, np.square(steps) @ weights - mean * mean + 1.0

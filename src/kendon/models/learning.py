"""Learning a greeting model from greetings, with labels and without (thesis 2.2, 3.5.3).

Where a row has its true phase, the state is known and the model is counted from it; where it has
none, EM (thesis 2.13-2.16) counts with the probabilities of the phases instead. Both are one
algorithm: a label restricts the row's state, and the rest follows. States that no label names are
given names at the end, by their likeness to Kendon's phases.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kendon.errors import ParameterError, UnknownNameError
from kendon.models.ascent import Run, Search, StartSummary
from kendon.models.assignment import Assignment, assign
from kendon.models.conditional import PASSING, Improvement, improve, possible
from kendon.models.em import FREE, pack
from kendon.models.emissions import GESTURES_FROM, Family
from kendon.models.greeting import LARGEST, GreetingModel
from kendon.models.library import load_model
from kendon.models.prior import Expected, Parameters, Prior
from kendon.models.starts import start
from kendon.observations import FEATURES, Observations
from kendon.person import FloatArray, IntArray
from kendon.phases import Phase

#: Random starts when some phase has no label: on simulated greetings between one in two and one
#: in thirty leads to the best optimum.
RANDOM_STARTS = 60
#: The share of values from nowhere that the robust family expects: about one row in 25, a
#: greeting, has one among its four measured features.
OUTLIERS = 0.01
#: A state or value that has been met for less than this share of a row has not been met.
_MET = 1e-3

_STATES = len(Phase)


@dataclasses.dataclass(frozen=True, eq=False)
class Fit:
    """A learned model and how it was learned."""

    model: GreetingModel
    log_posteriors: list[float]  # of the best start: before the first iteration, after each
    log_likelihoods: list[float]  # the same, without the prior
    starts: list[StartSummary]
    assignment: Assignment | None  # None: labels or the initial model say what the states are
    converged: bool
    greetings: int  # learned from
    rows: int
    notes: tuple[str, ...] = ()  # sentences for the user
    improvement: Improvement | None = None  # None: not learned conditionally

    @property
    def iterations(self) -> int:
        """Of the best start."""
        return len(self.log_posteriors) - 1


def fit(
    greetings: Sequence[Observations],
    *,
    family: Family | None = None,
    labels: bool = True,
    starts: int | None = None,
    seed: int = 0,
    prior: Prior | None = None,
    iterations: int = 100,
    gain: float = 0.01,
    outliers: float = OUTLIERS,
    allowed: ArrayLike | None = None,
    initial: GreetingModel | None = None,
    conditional: bool = False,
    progress: Callable[[int, int, float], None] | None = None,
) -> Fit:
    """Learn a greeting model.

    States are found best with the Gaussian family: its gestures tell phases apart sharply, while
    the robust one believes no gesture beyond a certainty, and rather splits a long approach in
    two than keep a short head dip.

    Rows whose phase is 0 (not greeting) are left out; what lies on either side of them counts as
    two greetings. Only conditional learning has a use for people who never greet. Rows whose
    phase is -1, or all rows of greetings without phases, have no label.

    Args:
        greetings: what is learned from.
        family: of the emissions; by default that of the initial model; robust if every phase has a
            label, and the thesis's Gaussian if states are to be found (see above).
        labels: whether to use the true phases; without them all is found from the observations.
        starts: how often EM starts anew from chance, the best is taken (by default 60 times); once
            only if there is no chance in it: every phase has a label, or a model to start from.
        seed: of the chance.
        prior: of the parameters; `Prior()` if not given.
        iterations: at most so many (thesis 3.5.3: 100).
        gain: the log posterior has converged when it gains less than this (3.5.3: 0.01).
        outliers: probability of a value from nowhere, of the robust family; it is not learned.
        allowed: (6, 6), true where a phase may follow a phase; others keep probability 0. Needs
            labels of every phase, or an initial model: other states have no name beforehand.
        initial: a model to start from, whose phases the states then are.
        conditional: whether to improve P(phases | observations) instead of counting, from the
            initial model on or, without one, from the counted one: a better reader of phases, with
            numbers less like what is seen in them. Needs a label on every row. Of people who are
            not greeting in any row it learns to read no salutation in them.
        progress: called with the start, the iteration and the log posterior, all along; while
            the conditional likelihood is improved, with the mean of both kinds of it a row
            (`kendon.models.conditional`).

    Raises:
        ParameterError: there is nothing to learn from, a value is out of its range, or a
            greeting's labels cannot happen under the moves that are allowed.
        UnknownNameError: there is no such family.
    """
    if family is not None and family not in list(Family):
        raise UnknownNameError("family of emissions", family, Family)
    _check_numbers(starts, iterations, gain, outliers)
    prior = prior or Prior()
    passing = [greeting for greeting in greetings if conditional and _passes(greeting)]
    sequences, marks, names, notes = _sequences(
        [greeting for greeting in greetings if not (conditional and _passes(greeting))], labels
    )
    labelled = np.unique(np.concatenate(marks))
    labelled = labelled[labelled != FREE]
    # Whether labels or the initial model say what every state is.
    named = (
        initial is not None
        or len(labelled) == _STATES
        or all((mark != FREE).all() for mark in marks)
    )
    mask = _mask(allowed, named)
    if named:
        starts = 1
    if family is None and initial is not None:
        family = initial.family
    family = Family(family or (Family.ROBUST if named else Family.GAUSSIAN))
    for number, greeting in enumerate(greetings):
        _check_values(greeting.values, family, greeting.name or f"greeting {number}")
    if family is Family.GAUSSIAN:
        outliers = 0.0
    data = pack(sequences, marks)
    rng = np.random.default_rng(seed)
    search = Search(data, prior, mask, gain, names, progress)
    runs = []
    for number in range(starts or RANDOM_STARTS):
        if initial is not None:
            parameters = _from_model(initial, family, outliers, mask, prior)
        else:
            parameters = start(data, marks, prior, mask, family, outliers, rng)
        runs.append(Run(number, possible(parameters, mask) if conditional else parameters))
    if conditional and any((mark == FREE).any() for mark in marks):
        raise ParameterError("conditional learning needs a true phase on every row")
    best = search.best(runs, 0 if conditional and initial else iterations)
    reference = load_model("kendon")
    parameters, expected = best.parameters, best.expected
    assert expected is not None  # the run was followed
    improvement = None
    if conditional:
        improvement = improve(
            pack(
                [*sequences, *(np.asarray(one.values, dtype=float) for one in passing)],
                [*marks, *(np.full(len(one), PASSING) for one in passing)],
            ),
            parameters,
            prior,
            mask,
            iterations=iterations,
            progress=progress and functools.partial(progress, 0),
        )
        parameters = improvement.parameters
    known = expected.emissions[:, :, 0].sum(axis=0) >= _MET
    assignment = None
    if not named:
        given = {int(state): Phase(int(state) + 1) for state in labelled}
        assignment = assign(parameters, reference, given=given, known=tuple(known.tolist()))
        parameters, expected = _reorder(parameters, expected, assignment.order)
    parameters, more = _complete(parameters, expected, reference, prior)
    model = GreetingModel(
        *parameters,
        name="learned",
        title=f"Learned from {data.count} greeting{'s' * (data.count != 1)}",
        source=f"kendon fit: {data.count} sequences, {data.rows} rows,"
        f" {'with' if len(labelled) else 'without'} labels{', conditional' if conditional else ''}",
    )
    return Fit(
        model,
        best.log_posteriors,
        best.log_likelihoods,
        [run.summary for run in runs],
        assignment,
        best.converged,
        data.count,
        data.rows,
        (*notes, *more),
        improvement,
    )


def _check_numbers(starts: int | None, iterations: int, gain: float, outliers: float) -> None:
    if starts is not None and starts < 1:
        raise ParameterError(f"EM starts at least once, not {starts} times")
    if iterations < 0:
        raise ParameterError(f"iterations must not be negative, but are {iterations}")
    if not gain >= 0:
        raise ParameterError(f"the gain must not be negative, but is {gain}")
    if not 0 <= outliers < 1:
        raise ParameterError(f"outliers is a probability below 1, not {outliers}")


def _passes(person: Observations) -> bool:
    """Whether somebody is known not to greet at any time."""
    return len(person) > 0 and person.phases is not None and not person.phases.any()


def _sequences(
    greetings: Sequence[Observations], labels: bool
) -> tuple[list[FloatArray], list[IntArray], list[str], list[str]]:
    """The stretches that are greeting, their labels and names, and notes for the user."""
    sequences, marks, names = [], [], []
    left_out = 0
    for number, greeting in enumerate(greetings):
        name = greeting.name or f"greeting {number}"
        phases = greeting.phases if greeting.phases is not None else np.full(len(greeting), FREE)
        if len(phases) and not (phases.min() >= FREE and phases.max() <= _STATES):
            raise ParameterError(
                f"{name}: phases are 1 to {_STATES}, 0 = not greeting, -1 = not labelled"
            )
        rows = np.flatnonzero(phases != 0)
        left_out += len(phases) - len(rows)
        for stretch in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
            if len(stretch):
                sequences.append(np.asarray(greeting.values[stretch], dtype=float))
                known = phases[stretch]
                marks.append(np.where((known > 0) & labels, known - 1, FREE).astype(np.int64))
                names.append(name)
    if not sequences:
        raise ParameterError("there is no greeting to learn from: no row but those of phase 0")
    if not any((~np.isnan(sequence)).any() for sequence in sequences):
        raise ParameterError("there is nothing to learn from: every value is unknown")
    notes = []
    if left_out:
        notes.append(
            f"{left_out} row{'s' * (left_out != 1)} of people who do not greet (phase 0) left out"
        )
    return sequences, marks, names, notes


def _check_values(values: FloatArray, family: Family, name: str) -> None:
    low, high = np.full(len(FEATURES), -LARGEST), np.full(len(FEATURES), LARGEST)
    if family is Family.ROBUST:  # a gesture's value is a probability there
        low[GESTURES_FROM:], high[GESTURES_FROM:] = 0.0, 1.0
    wrong = np.argwhere((values < low) | (values > high))  # none for NaN
    if len(wrong):
        row, column = wrong[0].tolist()
        raise ParameterError(
            f"{name}: {FEATURES[column]} of observation {row} is {values[row, column]:g},"
            f" not between {low[column]:g} and {high[column]:g}"
        )


def _mask(allowed: ArrayLike | None, named: bool) -> NDArray[np.bool_]:
    if allowed is None:
        return np.ones((_STATES, _STATES), dtype=bool)
    mask = np.asarray(allowed, dtype=bool)
    if mask.shape != (_STATES, _STATES) or not mask.any(axis=1).all():
        raise ParameterError(
            f"allowed moves have shape {(_STATES, _STATES)} and at least one in each row"
        )
    if not named:
        raise ParameterError("allowed moves need labels of every phase, or an initial model")
    return mask


def _from_model(
    model: GreetingModel,
    family: Family,
    outliers: float,
    allowed: NDArray[np.bool_],
    prior: Prior,
) -> Parameters:
    """A model as parameters of a family."""
    transmat = model.transmat * allowed
    if not (transmat.sum(axis=1) > 0).all():
        raise ParameterError("the initial model has a phase with no allowed move")
    transmat = transmat / transmat.sum(axis=1, keepdims=True)
    means, variances = model.means.copy(), np.maximum(model.variances, np.square(prior.least))
    if family is Family.ROBUST:
        hands = slice(GESTURES_FROM, None)
        surest = min(prior.certainty, 0.999)
        means[:, hands] = means[:, hands].clip(1 - surest, surest)
        variances[:, hands] = means[:, hands] * (1 - means[:, hands])
    return Parameters(model.startprob.copy(), transmat, means, variances, family, outliers)


def _reorder(
    parameters: Parameters, expected: Expected, order: list[int]
) -> tuple[Parameters, Expected]:
    """States in the order of their phases."""
    return (
        parameters._replace(
            startprob=parameters.startprob[order],
            transmat=parameters.transmat[np.ix_(order, order)],
            means=parameters.means[order],
            variances=parameters.variances[order],
        ),
        Expected(
            expected.starts[order],
            expected.moves[np.ix_(order, order)],
            expected.emissions[order],
        ),
    )


def _complete(
    parameters: Parameters, expected: Expected, reference: GreetingModel, prior: Prior
) -> tuple[Parameters, list[str]]:
    """Kendon's values for what the data have never shown, and notes that say so."""
    unmet = expected.emissions[:, :, 0] < _MET  # (K, F)
    if not unmet.any():
        return parameters, []
    theirs = _from_model(
        reference, parameters.family, parameters.outliers, reference.transmat > 0, prior
    )
    means = np.where(unmet, theirs.means, parameters.means)
    variances = np.where(unmet, theirs.variances, parameters.variances)
    transmat = parameters.transmat.copy()
    absent = np.array([row.all() for row in unmet])
    transmat[absent] = theirs.transmat[absent]
    notes = []
    for phase in np.flatnonzero(absent).tolist():
        notes.append(f"{Phase(phase + 1).name} never happens: its row is the Kendon model's")
    nowhere = np.array([column.all() for column in unmet.T])
    features = np.flatnonzero(nowhere).tolist()
    if features:
        unknown = ", ".join(FEATURES[f] for f in features)
        notes.append(f"{unknown} unknown throughout: the numbers are the Kendon model's")
    rest = unmet & ~absent[:, None] & ~nowhere
    for phase, feature in zip(*np.nonzero(rest), strict=True):
        notes.append(
            f"{FEATURES[feature]} is never known in {Phase(phase + 1).name}:"
            " the number is the Kendon model's"
        )
    return parameters._replace(transmat=transmat, means=means, variances=variances), notes

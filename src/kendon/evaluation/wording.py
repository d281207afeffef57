"""How results are put into words, the same in the terminal and in the report."""

from __future__ import annotations

import math

from kendon.evaluation.comparison import Interval, Spread
from kendon.evaluation.metrics import GRACE, TOLERANCE
from kendon.evaluation.results import Delays, Evaluation

#: What stands where nothing can be told.
NOTHING = "–"

#: What the numbers mean, by the heading they stand under.
MEANINGS: dict[str, str] = {
    "accuracy": "the share of observations whose phase was read right, over all greetings"
    " (thesis 3.6.1); behind it its 95 % interval, from drawing whole greetings with replacement",
    "difference": "how much more accurate than the reference, with its 95 % interval, both read"
    " the same greetings; an interval that holds 0 tells of no difference",
    "macro F1": "the harmonic mean of recall and precision, averaged over the phases that"
    " happened, each with the same weight",
    "delay": "the median time from a person's entry into a phase until the reading was there;"
    f" missed if it was not within {GRACE:g} s after the person left it",
    "changes found": "changes from one phase to another that were read at most"
    f" {TOLERANCE:g} s early or late, and how many of those read had happened",
    "causal": "reads a phase without knowing what comes later, as a robot must",
}


def number(value: float, digits: int = 3) -> str:
    """A number, or a dash where there is none.

    >>> number(0.5), number(float("nan"))
    ('0.500', '–')
    """
    return f"{value:.{digits}f}" if math.isfinite(value) else NOTHING


def ends(interval: Interval, *, sign: bool = False) -> str:
    """The ends of an interval.

    >>> ends(Interval(0.5, 0.4, 0.6))
    '[0.400, 0.600]'
    """
    if not math.isfinite(interval.low):
        return ""
    if sign:
        return f"[{_signed(interval.low)}, {_signed(interval.high)}]"
    return f"[{interval.low:.3f}, {interval.high:.3f}]"


def interval(value: Interval) -> str:
    """A value and its interval.

    >>> interval(Interval(0.5, 0.4, 0.6))
    '0.500 [0.400, 0.600]'
    """
    return f"{number(value.value)} {ends(value)}".rstrip()


def difference(value: Interval | None) -> str:
    """A signed value and its interval; the reference has none.

    >>> difference(Interval(0.5, 0.4, 0.6))
    '+0.500 [+0.400, +0.600]'
    """
    if value is None:
        return "reference"
    if not math.isfinite(value.value):
        return NOTHING
    return f"{_signed(value.value)} {ends(value, sign=True)}".rstrip()


def delay(delays: Delays) -> str:
    """A median delay, and how many entries were missed.

    >>> delay(Delays(9, 2, 0.4)), delay(Delays(2, 2, float("nan"))), delay(Delays(3, 0, 0.0))
    ('0.4 s, 2 missed', '2 missed', '0.0 s')
    """
    if not delays.entries:
        return NOTHING
    parts = [f"{delays.median:.1f} s"] if math.isfinite(delays.median) else []
    if delays.missed:
        parts.append(f"{delays.missed} missed")
    return ", ".join(parts)


def spread(value: Spread) -> str:
    """Mean and standard deviation, as in thesis table 3.5.

    >>> import numpy as np
    >>> spread(Spread(np.array([0.5, 0.7])))
    '0.600 ± 0.141'
    """
    deviation = f" ± {value.deviation:.3f}" if math.isfinite(value.deviation) else ""
    return f"{number(value.mean)}{deviation}"


def counted(amount: int, one: str, many: str = "") -> str:
    """An amount of things.

    >>> counted(1, "greeting"), counted(2, "passer-by", "passers-by")
    ('1 greeting', '2 passers-by')
    """
    return f"{amount} {one if amount == 1 else many or one + 's'}"


def material(evaluation: Evaluation) -> str:
    """What was evaluated on, in one sentence without its full stop."""
    greetings, passersby, unlabelled = evaluation.material
    words = (
        f"{counted(len(greetings), 'greeting')} with"
        f" {counted(evaluation.observations, 'observation')} of a known phase"
    )
    if passersby:
        words += f", {counted(len(passersby), 'passer-by', 'passers-by')}"
    if unlabelled:
        words += f"; {counted(len(unlabelled), 'recording')} without true phases left out"
    return words


def conditions(evaluation: Evaluation) -> str:
    """How people were observed, in one sentence without its full stop."""
    return f"{evaluation.sensor} sensor, gestures {_gestures(evaluation)}"


def _gestures(evaluation: Evaluation) -> str:
    if evaluation.gestures_from_phases:
        # Whoever reads these numbers must know that they are better than a camera's.
        return "given by hand from the true phases, which tells the models of DS, HD and CS"
    return "found by the detectors where nobody gives them by hand"


def _signed(value: float) -> str:
    return f"{value:+.3f}".replace("-", "−")

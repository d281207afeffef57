"""The metrics on sequences whose results can be worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from evaluation_data import numbers, stamps
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from kendon.errors import ParameterError
from kendon.evaluation import metrics
from kendon.person import IntArray
from kendon.phases import Phase


@st.composite
def pairs(draw: st.DrawFn) -> tuple[IntArray, IntArray]:
    """True phases with gaps, and a reading of the same length."""
    length = draw(st.integers(0, 40))
    truth = draw(arrays(np.int64, length, elements=st.integers(-1, 6)))
    read = draw(arrays(np.int64, length, elements=st.integers(1, 6)))
    return truth, read


def test_confusion_and_scores_by_hand() -> None:
    truth = numbers("IIAAAACC-?")
    read_ = numbers("IAAAFFCCDD")
    counts = metrics.confusion(truth, read_)
    expected = np.zeros((6, 6), dtype=np.int64)
    expected[0, 0], expected[0, 3] = 1, 1
    expected[3, 3], expected[3, 4] = 2, 2
    expected[5, 5] = 2
    np.testing.assert_array_equal(counts, expected)
    assert metrics.accuracy(counts) == 5 / 8
    scores = metrics.phase_scores(counts)
    np.testing.assert_array_equal(scores.recall, [0.5, np.nan, np.nan, 0.5, np.nan, 1])
    np.testing.assert_allclose(scores.precision, [1, np.nan, np.nan, 2 / 3, 0, 1])
    np.testing.assert_allclose(scores.f1, [2 / 3, np.nan, np.nan, 4 / 7, 0, 1])
    # FA never happened: it spoils the precision of others, and is no phase to find.
    assert scores.macro_f1 == pytest.approx((2 / 3 + 4 / 7 + 1) / 3)


def test_the_thesis_s_confusion_matrix_gives_its_accuracy() -> None:
    counts = np.zeros((6, 6), dtype=np.int64)  # table 3.4
    counts[0, 0] = 1
    counts[1, 3] = 2
    counts[3, [0, 3, 4]] = 1, 8, 3
    counts[4, [0, 3, 4]] = 2, 2, 47
    counts[5, 5] = 27
    assert metrics.accuracy(counts) == pytest.approx(0.893, abs=1e-3)  # table 3.3
    assert metrics.phase_scores(counts).recall[3] == pytest.approx(0.667, abs=5e-4)


@given(pairs())
def test_laws_of_the_confusion_matrix(pair: tuple[IntArray, IntArray]) -> None:
    truth, read = pair
    counts = metrics.confusion(truth, read)
    np.testing.assert_array_equal(counts.sum(axis=1), [(truth == p).sum() for p in Phase])
    np.testing.assert_array_equal(counts.sum(axis=0), [(read[truth > 0] == p).sum() for p in Phase])
    labelled = truth > 0
    if labelled.any():
        assert metrics.accuracy(counts) == np.trace(counts) / labelled.sum()
        assert metrics.accuracy(counts) == np.mean(truth[labelled] == read[labelled])
    else:
        assert math.isnan(metrics.accuracy(counts))


@given(pairs(), st.permutations(range(1, 7)))
def test_other_numbers_for_the_phases_change_no_score(
    pair: tuple[IntArray, IntArray], order: list[int]
) -> None:
    truth, read = pair
    new = np.array([0, *order, -1])  # -1 and 0 keep their meaning
    t = stamps(len(truth))
    before, after = metrics.confusion(truth, read), metrics.confusion(new[truth], new[read])
    places = np.array(order) - 1
    np.testing.assert_array_equal(after[np.ix_(places, places)], before)
    for old, relabelled in zip(
        metrics.phase_scores(before), metrics.phase_scores(after), strict=True
    ):
        np.testing.assert_array_equal(relabelled[places], old)
    assert metrics.transitions(t, new[truth], new[read]) == metrics.transitions(t, truth, read)
    delays = [e.delay for e in metrics.entries(t, truth, read)]
    np.testing.assert_array_equal(
        [e.delay for e in metrics.entries(t, new[truth], new[read])], delays
    )


@given(pairs())
def test_the_truth_itself_is_perfect(pair: tuple[IntArray, IntArray]) -> None:
    truth, _ = pair
    read = np.maximum(truth, 1)
    t = stamps(len(truth))
    assert all(entry.delay == 0 for entry in metrics.entries(t, truth, read))
    found = metrics.transitions(t, truth, read)
    assert found.true == found.read == found.found


@pytest.mark.parametrize(
    ("truth", "read", "delays"),
    [
        ("IIAAAA", "IIAAAA", {"IA": [0], "APP": [0]}),
        ("IIAAAA", "IIIIAA", {"IA": [0], "APP": [0.4]}),  # late
        ("IIAAAA", "IAAAAA", {"IA": [0], "APP": [0]}),  # early, and still there
        ("IIAAAA", "IAIAAA", {"IA": [0], "APP": [0.2]}),  # early, and gone again
        ("IIAAAA", "IIIIII", {"IA": [0], "APP": [math.nan]}),  # never
        # Within 1 s after the stretch, five observations, is not too late; six are.
        ("DDIIIIIII", "IIIIIIDII", {"DS": [1.2], "IA": [0]}),
        ("DDIIIIIII", "IIIIIIIDI", {"DS": [math.nan], "IA": [0]}),
        # A second time is another entry; what comes for it is not late for the first.
        ("IADAI", "IIIAI", {"IA": [0, 0], "DS": [math.nan], "APP": [math.nan, 0]}),
        # Nobody knows when a phase after unlabelled rows began; after a passer-by's rows one does.
        ("II??AA", "IIIIIA", {"IA": [0]}),
        ("--AA", "IIIA", {"APP": [0.2]}),
    ],
)
def test_delays_by_hand(truth: str, read: str, delays: dict[str, list[float]]) -> None:
    t = stamps(len(truth))
    found: dict[str, list[float]] = {}
    for entry in metrics.entries(t, numbers(truth), numbers(read)):
        found.setdefault(entry.phase.name, []).append(entry.delay)
    assert found.keys() == delays.keys()
    for name, expected in delays.items():
        np.testing.assert_allclose(found[name], expected, atol=1e-9)


def test_delays_follow_the_stamps() -> None:
    t = np.array([0.5, 1.0, 3.0, 9.0])
    (_, late) = metrics.entries(t, numbers("IAAA"), numbers("IIIA"))
    assert (late.t, late.delay) == (1.0, 8.0)


@pytest.mark.parametrize(
    ("truth", "read", "expected"),
    [
        ("IIAAFF", "IIAAFF", (2, 2, 2)),
        ("IIAAFF", "IAAAAF", (2, 2, 2)),  # at about the same time
        ("IIAAFF", "IIIIFF", (2, 1, 0)),  # another change
        ("IIIIIIIIAA", "IAAAAAAAAA", (1, 1, 0)),  # 1.4 s early
        ("IIIIIIIIAA", "IIIAAAAAAA", (1, 1, 1)),  # 1 s early
        ("IIAAAA", "IAIAAA", (1, 3, 1)),  # one change is found by one reading
        ("II?AAA", "IIAFFF", (0, 0, 0)),  # changes from and to unlabelled rows do not count
    ],
)
def test_transitions_by_hand(truth: str, read: str, expected: tuple[int, int, int]) -> None:
    found = metrics.transitions(stamps(len(truth)), numbers(truth), numbers(read))
    assert (found.true, found.read, found.found) == expected


def test_shares_of_passers_by() -> None:
    shares = metrics.shares(numbers("----?A"), numbers("IAACCC"))
    np.testing.assert_array_equal(shares, [0.25, 0, 0, 0.5, 0, 0.25])
    assert np.isnan(metrics.shares(numbers("AA"), numbers("AA"))).all()


@pytest.mark.parametrize("read", [[1, 2], [1, 2, 0], [1, 2, 7], [[1, 2, 3]]])
def test_what_cannot_be_compared_is_refused(read: list[int]) -> None:
    with pytest.raises(ParameterError, match="phases"):
        metrics.confusion(numbers("IAA"), np.array(read))

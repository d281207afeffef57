"""Faces keep their numbers: people who walk, cross, hide and come back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kendon.sources.face_finder import FaceBox
from kendon.sources.face_tracks import LOST, FaceTracks, distinct

PERIOD = 1 / 15


def box(x: float, y: float = 100.0, size: float = 60.0) -> FaceBox:
    """A square box around a place [px]."""
    return FaceBox(x - size / 2, y - size / 2, size, size)


def test_numbers_count_from_one_and_stay() -> None:
    tracks = FaceTracks()
    assert tracks.update([box(100), box(400)], 0.0) == [1, 2]
    assert tracks.update([box(405), box(102), box(250)], PERIOD) == [2, 1, 3]
    assert tracks.complete


@given(st.permutations(range(4)), st.floats(-12, 12), st.floats(-8, 8), st.floats(0.97, 1.03))
def test_the_order_of_what_is_seen_does_not_matter(
    order: list[int], right: float, down: float, growth: float
) -> None:
    tracks = FaceTracks()
    places = [100.0, 300.0, 520.0, 800.0]
    for step in range(20):
        boxes = [box(x + step * right, 200 + step * down, 60 * growth**step) for x in places]
        seen = order if step else range(4)
        numbers = tracks.update([boxes[i] for i in seen], step * PERIOD)
        assert numbers == [i + 1 for i in seen]


def test_two_people_who_cross_keep_their_numbers() -> None:
    tracks = FaceTracks()
    numbers = []
    for step in range(40):
        # One walks to the right behind the other, who walks to the left and hides them.
        back, front = box(100 + 10 * step, size=50), box(500 - 10 * step, size=75)
        boxes = [front] if back.overlap(front) > 0.15 else [back, front]
        numbers = tracks.update(boxes, step * PERIOD)
    assert numbers == [1, 2]


def test_a_short_loss_keeps_the_number_and_a_long_one_does_not() -> None:
    tracks = FaceTracks()
    tracks.update([box(100)], 0.0)
    assert tracks.update([], 0.5) == []
    assert not tracks.complete
    assert tracks.update([box(120)], LOST - 0.01) == [1]
    assert tracks.expected(2 * LOST - 0.01 + 0.001) == {}
    assert tracks.update([box(120)], 2 * LOST + 0.5) == [2]


def test_a_face_that_moves_is_expected_where_it_goes_but_not_for_ever() -> None:
    tracks = FaceTracks()
    for step in range(15):
        tracks.update([box(100 + 20 * step)], step * PERIOD)
    last = 14 * PERIOD
    soon, later = (tracks.expected(last + t)[1].centre[0] for t in (PERIOD, 0.9))
    assert soon == pytest.approx(400, abs=3)
    assert later < 380 + 300 * 0.3 + 1
    assert math.isclose(tracks.expected(last)[1].centre[0], 380)


def test_another_size_or_a_far_place_is_somebody_else() -> None:
    tracks = FaceTracks()
    tracks.update([box(100)], 0.0)
    assert tracks.update([box(100, size=120)], PERIOD) == [2]
    assert tracks.update([box(400)], 2 * PERIOD) == [3]


def test_of_boxes_that_overlap_the_first_is_kept() -> None:
    assert distinct([box(100), box(110), box(300), box(100, size=58)]) == [0, 2]
    assert distinct([]) == []


@given(*[st.tuples(*[st.floats(0, 500)] * 2, *[st.floats(1, 200)] * 2)] * 2)
def test_overlap_is_a_share_and_the_same_from_both_sides(
    a: tuple[float, float, float, float], b: tuple[float, float, float, float]
) -> None:
    one, other = FaceBox(*a), FaceBox(*b)
    assert 0 <= one.overlap(other) <= 1 + 1e-9
    assert one.overlap(other) == pytest.approx(other.overlap(one))
    assert one.overlap(one) == pytest.approx(1)
    # By counting points of a fine grid.
    points = np.stack(np.meshgrid(*[np.arange(0, 700, 2.0) + 0.5] * 2), axis=-1)
    inside = [
        ((points >= box[:2]) & (points < np.add(box[:2], box[2:]))).all(axis=-1)
        for box in (one, other)
    ]
    union = (inside[0] | inside[1]).sum()
    if union > 2000:
        counted = (inside[0] & inside[1]).sum() / union
        assert one.overlap(other) == pytest.approx(counted, abs=0.1)

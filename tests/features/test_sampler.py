"""Five observations a second from any source, streamed and all at once."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from statistics import median

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from people import TOLERANCE, FloatArray, assert_same, quaternion, stream, tracks

from kendon.errors import ParameterError
from kendon.features import PERIOD, Sampler, head_gaze, observe, observe_all
from kendon.geometry import Vec3
from kendon.observations import Observation
from kendon.person import PersonFrame, Track

UNIX = 1_700_000_000.4
RATES = [5, 6, 7.5, 9.9, 10, 12.5, 15, 24, 25, 29.97, 30, 48, 50, 59.94, 60, 100, 120]


def walk(t: FloatArray, speed: float = 1.0) -> Track:
    """Somebody 60 m away who comes straight to the robot, looking at its face."""
    head = np.stack([60 - speed * (t - t[0]), np.zeros(len(t)), np.full(len(t), 1.2)], axis=1)
    look = np.tile(quaternion(math.pi), (len(t), 1))
    return Track.build(t, head, head_rotation=look, smile=np.full(len(t), 2.0))


def intervals(track: Track, ends: FloatArray) -> list[list[int]]:
    """Which frames each interval covers, by going through all of them."""
    starts = [-math.inf, *(ends[:-1] + TOLERANCE)]
    return [
        [i for i, t in enumerate(track.t.tolist()) if start < t <= end + TOLERANCE]
        for start, end in zip(starts, ends.tolist(), strict=True)
    ]


# ---- stamps and rates


@pytest.mark.parametrize("start", [0.0, 0.0333, -7.7, UNIX])
@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_five_a_second_from_every_rate(rate: float, start: float, jitter: float) -> None:
    rng = np.random.default_rng(7)
    n = round(6 * rate)
    t = start + (np.arange(n) + jitter * rng.uniform(-0.5, 0.5, n)) / rate
    seen = observe(walk(t, speed=1.5))
    count = math.floor((t[-1] - t[0] + TOLERANCE) / PERIOD)
    np.testing.assert_array_equal(seen.t, [t[0] + k * PERIOD for k in range(1, count + 1)])
    assert np.isfinite(seen.values[:, [0, 2, 3]]).all()
    speeds = seen.values[1:, 1]
    if rate >= 9.9:
        assert np.isfinite(speeds).all()
    np.testing.assert_allclose(speeds[np.isfinite(speeds)], 1.5, atol=1e-5)
    # A median stands for the middle of its interval: at most an interval and a frame old.
    age = (60 - 1.5 * (seen.t - t[0])) - seen.values[:, 0]
    assert (age <= 1.5 * TOLERANCE + 1e-5).all()
    assert (age > -1.5 * (PERIOD + 1.5 / rate)).all()


@pytest.mark.parametrize("digits", [2, 3, 4])
@pytest.mark.parametrize("rate", [24, 25, 29.97, 30, 60])
def test_rounded_stamps_cost_no_observation(rate: float, digits: int) -> None:
    t = (0.123 + np.arange(600) / rate).round(digits)
    seen = observe(walk(t))
    assert np.isfinite(seen.values[:, 0]).all()
    assert abs(len(seen) - 599 / rate / PERIOD) <= 1


@given(tracks())
def test_stamps_lie_one_period_apart_from_the_first_frame_on(track: Track) -> None:
    seen = observe(track)
    expected = [float(track.t[0]) + k * PERIOD for k in range(1, len(seen) + 1)]
    np.testing.assert_array_equal(seen.t, expected)
    assert seen.t[-1] <= track.t[-1] + TOLERANCE + 1e-9
    assert seen.t[-1] + PERIOD > track.t[-1]


@given(st.floats(0.05, 2))
def test_another_period(period: float) -> None:
    track = walk(np.arange(200) / 50)
    seen = observe(track, period=period)
    np.testing.assert_allclose(np.diff(seen.t), period, atol=1e-12)
    assert_same(stream(track, period=period), track, period=period)


# ---- streamed is the same as all at once


@given(tracks())
@example(walk(np.array([0.0, 0.1, 0.201, 0.25, 0.41])))  # one on the edge of the tolerance
@example(walk(np.array([0.0, 0.3, 0.599])))
@example(walk(UNIX + np.arange(40) / 30))
@example(walk(np.append(UNIX + np.arange(4) / 10, UNIX + 0.4 - TOLERANCE)))  # on the edge, exactly
def test_a_stream_gives_the_numbers_of_the_whole_track(track: Track) -> None:
    assert_same(stream(track), track)


@given(tracks(), st.floats(0.01, 0.3))
def test_letting_time_pass_between_frames_changes_nothing(track: Track, tick: float) -> None:
    sampler = Sampler()
    done: list[Observation] = []
    now = float(track.t[0]) - 1
    for frame in track:
        while now + tick < frame.t - 1.01 * TOLERANCE:
            now += tick
            done += sampler.advance(now)
        done += sampler.push(frame)
    assert_same(done + sampler.advance(float(track.t[-1]) + TOLERANCE), track)


@pytest.mark.parametrize("seed", [13, 18, 19, 45])
def test_what_was_seen_while_keys_were_pressed_counts_alike_both_ways(seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.15, 0.35, 80))
    head, wrist = rng.uniform(-4, 4, (2, 80, 3))  # the hand seems to leap all the time
    pressed = np.where((t < t[-1] - 1.0)[:, None], np.zeros((80, 3)), np.nan)
    track = replace(walk(t), head=head, joints={"r_wrist": wrist}, gestures=pressed)
    assert_same(stream(track), track)


@pytest.mark.parametrize("seed", range(20))
def test_a_source_slower_than_a_beat_is_read_alike_both_ways(seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.3, 1.0, 30))
    track = walk(t)
    swaying = replace(track, head=track.head + rng.normal(0, 0.05, track.head.shape))
    assert_same(stream(swaying), swaying)


def test_an_observation_comes_as_soon_as_its_interval_is_over() -> None:
    sampler = Sampler()
    assert math.isnan(sampler.next_end)
    assert sampler.advance(5.0) == []  # before the first frame there is no time
    assert sampler.push(PersonFrame(10.0, (2.0, 0.0, 1.5))) == []
    assert sampler.next_end == pytest.approx(10.2)
    assert sampler.advance(10.19) == []
    (first,) = sampler.advance(10.2)
    assert first.t == pytest.approx(10.2)
    assert first.distance == 2.0
    assert sampler.advance(10.2) == []
    assert [o.t for o in sampler.push(PersonFrame(10.7))] == pytest.approx([10.4, 10.6])


# ---- what an observation is made of


@given(tracks(min_rate=12))
def test_features_are_medians_of_the_intervals_frames(track: Track) -> None:
    seen = observe(track)
    spacings = np.diff(track.t)
    assume(np.median(spacings) < 0.1)
    looked = head_gaze(track.head, track.head_rotation, np.array([0, 0, 1.2]))
    for covered, row in zip(intervals(track, seen.t), seen, strict=True):
        if not covered:
            continue
        ways = [math.hypot(*track.head[i, :2]) for i in covered]
        known = [way for way in ways if not math.isnan(way)]
        assert row.distance == pytest.approx(median(known) if known else math.nan, nan_ok=True)
        smiles = [s for s in track.smile[covered].tolist() if not math.isnan(s)]
        assert row.smile == pytest.approx(median(smiles) if smiles else math.nan, nan_ok=True)
        if not np.isfinite(track.eyes[covered]).any():
            gazes = [g for g in looked[covered].tolist() if not math.isnan(g)]
            assert row.gaze == pytest.approx(median(gazes) if gazes else math.nan, nan_ok=True)


@given(tracks(min_rate=12))
def test_given_gestures_are_medians_and_the_true_phase_the_middle_frames(track: Track) -> None:
    seen = observe(track)
    assert seen.phases is not None
    assert track.phases is not None
    for k, covered in enumerate(intervals(track, seen.t)):
        if covered:
            for column, values in enumerate(track.gestures[covered].T.tolist(), 4):
                known = [value for value in values if not math.isnan(value)]
                if known:  # the others are detected
                    assert seen.values[k, column] == pytest.approx(median(known))
            assert seen.phases[k] == track.phases[covered[len(covered) // 2]]


@given(tracks())
def test_every_feature_is_in_its_range_or_unknown(track: Track) -> None:
    values = observe(track).values
    highs = [20, math.inf, 2, 5, 1, 1, 1]
    for column, high in zip(values.T, highs, strict=True):
        known = column[~np.isnan(column)]
        assert np.isfinite(known).all()
        assert (known <= high).all()
    assert (np.delete(values, 1, axis=1)[~np.isnan(np.delete(values, 1, axis=1))] >= 0).all()


def test_eyes_decide_near_and_the_head_far() -> None:
    def seen_at(way: float) -> float:
        """The eyes look at the face, the head 30 degrees past it."""
        t = np.arange(11) / 30
        eyes = np.tile([[way, -0.03, 1.2], [way, 0.03, 1.2]], (11, 1, 1))
        track = Track.build(
            t,
            np.tile([way, 0.0, 1.2], (11, 1)),
            head_rotation=np.tile(quaternion(math.pi + math.radians(30)), (11, 1)),
            eyes=eyes,
            eye_gaze=np.array([0, 0, 1.2]) - eyes,
        )
        return float(observe(track).values[0, 2])

    head = math.cos(math.radians(30))
    assert seen_at(1.0) == pytest.approx(0)
    assert seen_at(1.5) == pytest.approx(0)
    assert seen_at(2.0) == pytest.approx(head / 2)
    assert seen_at(2.5) == pytest.approx(head)
    assert seen_at(6.0) == pytest.approx(head)


def test_gaze_is_at_the_given_robot_face() -> None:
    t = np.arange(11) / 30
    level = Track.build(
        t,
        np.tile([2.0, 0.0, 1.6], (11, 1)),
        head_rotation=np.tile(quaternion(math.pi), (11, 1)),
    )
    assert observe(level, (0.0, 0.0, 1.6)).values[0, 2] == pytest.approx(0)
    beside = 0.3 / (1.9 * math.tan(math.radians(30)))
    assert observe(level, (0.1, 0.3, 1.6)).values[0, 2] == pytest.approx(beside)


# ---- gaps and bad frames


@given(st.floats(10, 120), st.floats(0.5, 10), st.integers(0, 1000))
def test_a_gap_is_unknown_and_never_the_last_value_again(
    rate: float, gap: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    before = np.cumsum(rng.uniform(0.7, 1.3, 40)) / rate
    after = before[-1] + gap + np.cumsum(rng.uniform(0.7, 1.3, 60)) / rate
    track = walk(np.concatenate([before, after]))
    track.head[40:, 0] -= 10  # somewhere else afterwards: a speed across the gap would be wild
    seen = observe(track)
    covered = intervals(track, seen.t)
    assert not all(covered)
    for k, frames in enumerate(covered):
        if not frames:
            assert np.isnan(seen.values[k]).all()
        elif k and not covered[k - 1]:
            assert np.isfinite(seen.values[k, 0])
    speeds = seen.values[:, 1]
    np.testing.assert_allclose(speeds[~np.isnan(speeds)], 1, atol=1e-6)
    assert_same(stream(track), track)


@given(tracks(min_rate=2.5))
def test_only_a_slow_sources_newest_frame_counts_twice(track: Track) -> None:
    n = len(track)
    ways = np.arange(n) + 1.0  # each frame has a distance of its own
    head = np.stack([ways, np.zeros(n), np.ones(n)], axis=1)
    track = Track.build(track.t, head)
    seen = observe(track)
    for row, covered in zip(seen, intervals(track, seen.t), strict=True):
        if covered:
            assert row.distance == median(ways[covered].tolist())
        elif not math.isnan(row.distance):
            newest = int(np.searchsorted(track.t, row.t + TOLERANCE)) - 1
            assert row.distance == ways[newest]
            recent = track.t[max(0, newest - 9) : newest + 1].tolist()
            assert row.t - track.t[newest] <= 1.5 * max(b - a for a, b in pairwise(recent))


def test_a_slow_source_that_falls_silent_is_soon_unknown() -> None:
    t = np.concatenate([np.arange(20) * 0.21, [10.0, 10.21]])
    seen = observe(walk(t))
    silent = (seen.t > t[19] + 1.5 * 0.21 + 0.01) & (seen.t < 10)
    assert silent.sum() > 20
    assert np.isnan(seen.values[silent]).all()
    assert np.isfinite(seen.values[seen.t < t[19], 0]).all()


def test_a_face_lost_for_a_while_is_unknown_but_time_goes_on() -> None:
    track = walk(np.arange(91) / 30)
    head = track.head.copy()
    head[31:61] = np.nan
    seen = observe(Track.build(track.t, head))
    lost = (seen.t > 1.2) & (seen.t <= 2.0)
    assert np.isnan(seen.values[lost, 0]).all()
    assert np.isfinite(seen.values[~lost, 0]).all()


@given(st.sampled_from([25, 30, 60]), st.integers(0, 1000), st.floats(-50, 50))
def test_a_wild_frame_in_each_interval_moves_nothing_far(rate: int, seed: int, wild: float) -> None:
    rng = np.random.default_rng(seed)
    t = np.arange(4 * rate) / rate
    clean = walk(t, speed=1.2)
    head, smile = clean.head.copy(), clean.smile.copy()
    truth = observe(clean)
    for covered in intervals(clean, truth.t):
        bad = rng.choice(covered)
        head[bad, :2] += wild
        smile[bad] = 5.0
    seen = observe(Track.build(t, head, head_rotation=clean.head_rotation, smile=smile))
    step = 1.2 / rate  # what a walker does between two frames
    np.testing.assert_allclose(seen.values[:, 0], truth.values[:, 0], atol=step)
    np.testing.assert_allclose(seen.values[1:, 1], 1.2, atol=4 * step / PERIOD)
    np.testing.assert_array_equal(seen.values[:, 3], 2.0)


# ---- causality


@given(tracks(), st.data())
def test_nothing_after_an_observation_changes_it(track: Track, data: st.DataObject) -> None:
    cut = data.draw(st.integers(1, len(track) - 1))
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    frames = list(track)
    future = [
        PersonFrame(f.t, tuple(rng.normal(size=3).tolist()), f.head_rotation, smile=0.1, dsal=1.0)
        for f in frames[cut:]
        if rng.random() < 0.7
    ]
    changed = Track.from_frames([*frames[:cut], *future, PersonFrame(frames[-1].t + 1.0)])
    here, there = observe(track), observe(changed)
    unchanged = here.t + TOLERANCE < track.t[cut]
    np.testing.assert_array_equal(there.t[: unchanged.sum()], here.t[unchanged])
    np.testing.assert_array_equal(there.values[: unchanged.sum()], here.values[unchanged])


# ---- what is refused


@pytest.mark.parametrize("period", [0.0, -0.2, math.nan, math.inf])
def test_a_period_must_be_positive(period: float) -> None:
    with pytest.raises(ParameterError, match="sampling period must be positive"):
        Sampler(period=period)
    with pytest.raises(ParameterError, match="sampling period must be positive"):
        observe(walk(np.arange(30) / 30), period=period)


@pytest.mark.parametrize("face", [(math.nan, 0, 1), (0, 0, math.inf), (0, 1), (0, 0, 1, 2)])
def test_the_robots_face_is_a_finite_point(face: Vec3) -> None:
    with pytest.raises(ParameterError, match="the robot's face is a point"):
        Sampler(face)
    with pytest.raises(ParameterError, match="the robot's face is a point"):
        observe(walk(np.arange(30) / 30), face)


@pytest.mark.parametrize("t", [1.0, 0.5, -math.inf, math.nan, math.inf])
def test_frames_come_in_order(t: float) -> None:
    sampler = Sampler()
    sampler.push(PersonFrame(1.0, (3.0, 0.0, 1.5)))
    with pytest.raises(ParameterError, match=r"must come in order|must be finite"):
        sampler.push(PersonFrame(t))
    assert sampler.push(PersonFrame(1.25))[0].distance == 3.0  # as if nothing had happened


@pytest.mark.parametrize("t", [[], [0.0], [0.0, 0.1, 0.19]])
def test_a_track_of_less_than_an_interval_is_too_short(t: list[float]) -> None:
    head = np.ones((len(t), 3))
    with pytest.raises(ParameterError, match=r"brief lasts 0\.\d\d s; .* needs 0\.2 s"):
        observe(Track.build(np.array(t), head, name="brief"))


def test_one_interval_is_enough() -> None:
    seen = observe(walk(np.array([0.0, 0.1, 0.2])), name="short")
    assert (len(seen), seen.name) == (1, "short")
    assert seen.values[0, 1] == pytest.approx(1)


# ---- leaps of the clock


@pytest.mark.parametrize("leap", [60.5, 1e4, 1.7e9])
def test_a_leap_of_the_clock_begins_a_new_grid(leap: float) -> None:
    before, after = np.arange(16) / 30, 0.5 + leap + np.arange(16) / 30
    track = walk(np.concatenate([before, after]))
    seen = observe(track)
    # The interval that was being filled still counts; of the time between there is nothing.
    expected = [0.2, 0.4, 0.6, *(after[0] + np.array([0.2, 0.4]))]
    np.testing.assert_allclose(seen.t, expected, atol=1e-6)
    assert np.isfinite(seen.values[:, 0]).all()
    assert_same(stream(track), track)


def test_a_gap_of_just_under_a_leap_is_unknown_observations() -> None:
    seen = observe(walk(np.array([0.0, 0.1, 59.0, 59.1, 59.3])))
    assert len(seen) == round(59.2 / PERIOD)
    assert np.isnan(seen.values[5:-5]).all()


def test_a_leap_while_nobody_is_seen_waits_for_the_next_frame() -> None:
    sampler = Sampler()
    sampler.push(PersonFrame(0.0, (3.0, 0.0, 1.5)))
    assert [o.distance for o in sampler.advance(1.7e9)] == [3.0]
    assert math.isnan(sampler.next_end)
    assert sampler.advance(1.7e9 + 5) == []
    assert sampler.push(PersonFrame(1.7e9 + 6, (2.0, 0.0, 1.5))) == []
    assert [o.distance for o in sampler.advance(1.7e9 + 6.25)] == [2.0]


@pytest.mark.parametrize("t", [math.inf, -math.inf, math.nan])
def test_the_clock_shows_finite_seconds(t: float) -> None:
    sampler = Sampler()
    for stamp in (1.0, 2.0):  # before the first frame and after it
        with pytest.raises(ParameterError, match="the clock must show finite seconds"):
            sampler.advance(t)
        sampler.push(PersonFrame(stamp))


# ---- many tracks at once


def assert_each_as_alone(people: list[Track], **options: float) -> None:
    """To the last bit: a person's observations must not depend on who else is observed."""
    together = observe_all(people, **options)  # type: ignore[arg-type]
    for track, seen in zip(people, together, strict=True):
        alone = observe(track, **options)  # type: ignore[arg-type]
        assert seen.name == track.name
        np.testing.assert_array_equal(seen.t, alone.t)
        np.testing.assert_array_equal(seen.values, alone.values)
        assert (seen.phases is None) == (track.phases is None)
        if seen.phases is not None and alone.phases is not None:
            np.testing.assert_array_equal(seen.phases, alone.phases)
            assert seen.phases.dtype == np.int64


@given(st.floats(0.05, 1.5))
def test_nothing_of_one_person_enters_the_observations_of_the_next(leaves: float) -> None:
    t = np.arange(0, 3, 1 / 30)
    nodding = np.stack([3.0 - 1.2 * t, 0 * t, 1.2 + 0.1 * np.sin(9 * t)], axis=1)
    far, near = walk(t), replace(walk(t), head=nodding, smile=np.full(len(t), 0.5))
    after_somebody, after_nobody = Sampler(), Sampler()
    pairs: list[tuple[Observation, Observation]] = []
    for first, second in zip(far, near, strict=True):
        here = first.t >= leaves
        one = after_somebody.push(second._replace(who=2) if here else first._replace(who=1))
        other = after_nobody.push(second._replace(who=2) if here else PersonFrame(first.t))
        pairs += zip(one, other, strict=True)
    later = [pair for pair in pairs if pair[0].t > leaves + PERIOD]
    assert len(later) > 5
    np.testing.assert_array_equal([a for a, _ in later], [b for _, b in later])
    comes = t[t >= leaves][0]
    assert [a.distance < 4 for a, _ in pairs] == [a.t + TOLERANCE >= comes for a, _ in pairs]


@given(st.lists(tracks(), min_size=1, max_size=4))
def test_many_tracks_at_once_are_each_track_alone(people: list[Track]) -> None:
    assert_each_as_alone(people)


def test_tracks_of_all_kinds_can_be_observed_at_once() -> None:
    rng = np.random.default_rng(3)
    people = []
    for number, rate in enumerate((30, 7, 5.0, 60)):
        t = rng.uniform(-5, 1e6) + np.arange(int(6 * rate)) / rate
        track = walk(t + rng.uniform(0, 0.3 / rate, len(t)), speed=number)
        head = track.head + rng.normal(0, 0.02, track.head.shape)
        head[rng.random(len(t)) < 0.3] = np.nan  # at 5 Hz, blind intervals
        phases = rng.integers(0, 7, len(t)) if number % 2 else None
        people.append(replace(track, head=head, phases=phases, name=str(number)))
    eyes = np.tile(people[0].head[:, None], (1, 2, 1))
    people.append(replace(people[0], eyes=eyes, eye_gaze=-eyes, name="eyes"))
    nobody = replace(people[1], head=np.full_like(people[1].head, np.nan), name="nobody")
    people.insert(1, nobody)
    t = np.concatenate([np.arange(30) / 30, 500 + np.arange(30) / 30])  # the clock leaps
    people.insert(2, walk(t))
    people.append(walk(np.concatenate([np.arange(30) / 30, 4 + np.arange(30) / 30])))  # a hole
    assert_each_as_alone(people)
    assert_each_as_alone(people[::-1], period=0.3)
    assert observe_all([]) == []


def test_a_track_too_short_among_others_is_named() -> None:
    t = np.arange(30) / 30
    with pytest.raises(ParameterError, match=r"bob lasts 0\.10 s"):
        observe_all([walk(t), replace(walk(t[:4]), name="bob")])

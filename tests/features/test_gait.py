"""What a head's rise and fall adds to a speed: held against Bayes' rule by numbers, and people."""

from __future__ import annotations

import math
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from people import FloatArray, assert_same, stream
from scipy.stats import lognorm, norm

from kendon.features import Sampler, observe, observe_all
from kendon.features.gait import (
    ANY_RISE,
    ANY_UNLIKE,
    GAITS,
    OTHERWISE,
    RESOLUTION,
    STRETCH,
    UNLIKE,
    likely_speed,
)
from kendon.person import PersonFrame, Track
from kendon.simulation.sensors import Sensor, sensor

#: Stamps of the latest second at 30 frames a second, up to the instant asked about [s].
T = np.arange(31) / 30
END = 1.0


def likely(slope: float, error: float, heights: FloatArray, aside: float = 0.0) -> float:
    return float(likely_speed(slope, error, aside, T, heights, END))


def risen(rise: float) -> FloatArray:
    """Heights without noise whose outer tenths lie so far apart in the last STRETCH [m]."""
    span = T - (END - STRETCH)
    return np.asarray(1.6 + rise / 0.8 * span / (10 / 30))


# ---- by Bayes' rule, with densities of another library and an integral by numbers


@given(st.floats(-3, 3), st.floats(0.05, 3), st.floats(0.001, 0.3))
def test_it_is_the_mean_of_the_speed_given_slope_and_rise(
    slope: float, error: float, rise: float
) -> None:
    v = np.linspace(-8, 8, 16001)
    seen = math.hypot(rise, RESOLUTION)
    density = np.zeros_like(v)
    for gait in GAITS:
        own = lognorm(UNLIKE, scale=gait.rise).pdf(seen)
        other = lognorm(ANY_UNLIKE, scale=ANY_RISE).pdf(seen)
        likelihood = (1 - OTHERWISE) * own + OTHERWISE * other
        density += gait.share * likelihood * norm(gait.speed, gait.spread).pdf(v)
    density *= norm(v, error).pdf(slope)
    assert likely(slope, error, risen(rise)) == pytest.approx(
        (density * v).sum() / density.sum(), abs=2e-3
    )


def test_shares_are_of_all_people() -> None:
    assert sum(gait.share for gait in GAITS) == pytest.approx(1)


@given(st.floats(-3, 3), st.floats(0.001, 0.2), st.floats(0, 1))
def test_a_sure_slope_decides_alone(slope: float, rise: float, aside: float) -> None:
    assert likely(slope, 1e-4, risen(rise), aside) == pytest.approx(slope, abs=1e-4)


@pytest.mark.parametrize("rise", [0.001, 0.01, 0.03])
def test_heights_as_noisy_as_a_rise_tell_little(rise: float) -> None:
    noise = np.random.default_rng(3).normal(0, 0.03, len(T))
    mean = weights = 0.0  # of the shares alone, at a slope in the middle and an error of 1
    for gait in GAITS:
        variance = gait.spread**2 + 1
        weight = gait.share * norm(gait.speed, math.sqrt(variance)).pdf(0.6)
        weights += weight
        mean += weight * (gait.speed + (0.6 - gait.speed) * gait.spread**2 / variance)
    assert likely(0.6, 1.0, risen(rise) + noise) == pytest.approx(mean / weights, abs=0.2)
    assert abs(likely(0.6, 1.0, risen(0.03)) - likely(0.6, 1.0, risen(0.003))) > 0.8


def test_who_goes_past_does_not_come() -> None:
    coming, passing = (likely(0.9, 0.4, risen(0.03), aside) for aside in (0.0, 1.2))
    assert coming == pytest.approx(1.2, abs=0.1)
    assert passing < 0.75


@pytest.mark.parametrize("known", [0, 1, 3])
def test_few_heights_tell_nothing(known: int) -> None:
    heights = risen(0.03)
    heights[: len(T) - known] = np.nan
    assert math.isnan(likely(0.9, 0.4, heights))


def test_heights_within_a_moment_tell_nothing() -> None:
    t = END - np.arange(31) / 300
    assert math.isnan(likely_speed(0.9, 0.4, 0.0, t[::-1], risen(0.03), END))


def test_a_height_that_is_made_up_tells_nothing() -> None:
    assert math.isnan(likely(0.9, 0.4, np.full(len(T), 1.6)))


@pytest.mark.parametrize("wild", [1e3, -1e300, math.inf])
def test_a_wild_height_tells_nothing(wild: float) -> None:
    heights = risen(0.03)
    heights[27] = wild
    assert likely(0.9, 0.4, heights) == pytest.approx(likely(0.9, 0.4, risen(0.03)), abs=0.1)


# ---- people


def seen(speed: float, bob: float, seed: int, seconds: float = 4.0, **noise: float) -> Track:
    """Somebody 7 m away who stands or comes, and whose head goes up and down twice a second."""
    t = np.arange(round(seconds * 30) + 1) / 30
    z = 1.6 + bob / 2 * np.cos(2 * math.pi * 2 * t) + 0.001 * np.cos(2 * t)  # who stands sways
    head = np.stack([7 - speed * t, 0 * t, z], axis=1)
    look = Sensor(**{"range_noise": 0.05, **noise})  # type: ignore[arg-type]
    return look.see(Track.build(t, head), np.random.default_rng(seed))


def errors(speed: float, bob: float, **noise: float) -> FloatArray:
    """Of the speed, over twenty people, from their second second on [m/s]."""
    tracks = [seen(speed, bob, seed, **noise) for seed in range(20)]
    return np.concatenate([observe(track).values[5:, 1] for track in tracks]) - speed


def rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def test_a_head_that_keeps_its_height_stands_and_one_that_rises_and_falls_walks() -> None:
    told, level = errors(0.0, 0.0), errors(0.0, 0.04)
    assert rms(told) < 0.15
    assert rms(told) < 0.5 * rms(level)
    told, level = errors(1.2, 0.04), errors(1.2, 0.0)
    assert rms(told) < 0.25
    assert rms(told) < 0.8 * rms(level)


def test_without_noise_heads_make_no_difference() -> None:
    for bob in (0.0, 0.04, 0.3):
        np.testing.assert_allclose(errors(0.7, bob, range_noise=0.0), 0, atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_a_stream_gives_the_numbers_of_the_whole_track(seed: int) -> None:
    track = sensor("noisy", seed)(replace(seen(0.9, 0.04, seed), name=str(seed)))
    track.head[20:24, 2] = np.nan  # places without heights
    track.head[50:53, 2] = np.inf
    assert_same(stream(track), track)


# ---- short losses


def lose(track: Track, begin: float, end: float) -> Track:
    head = track.head.copy()
    head[(track.t > begin) & (track.t < end)] = np.nan
    return replace(track, head=head)


@pytest.mark.parametrize("begin", [1.01, 1.11, 1.19])
def test_who_was_out_of_sight_for_less_than_a_second_goes_on(begin: float) -> None:
    track = lose(seen(1.2, 0.0, 0, range_noise=0.0), begin, begin + 0.75)
    speeds = observe(track).values[:, 1]
    unseen = np.isnan(observe(track).values[:, 0])
    assert 2 <= unseen.sum() <= 4
    np.testing.assert_allclose(speeds[~unseen], 1.2, atol=1e-9)


@given(st.floats(3.0, 40.0), st.floats(0.4, 0.9))
def test_who_comes_back_somewhere_else_has_come_from_nowhere(way: float, gap: float) -> None:
    track = lose(seen(0.0, 0.0, 0, range_noise=0.0), 1.05, 1.05 + gap)
    track.head[track.t > 1.05, 1] += way
    speeds = observe(track).values[:, 1]
    np.testing.assert_allclose(speeds[np.isfinite(speeds)], 0, atol=1e-9)


def test_who_is_away_for_longer_has_gone_or_not() -> None:
    track = lose(seen(1.2, 0.0, 0, range_noise=0.0), 1.05, 2.15)
    speeds = observe(track).values[:, 1]
    back = int(np.flatnonzero(np.isfinite(observe(track).values[:, 0]) & (observe(track).t > 2))[0])
    assert math.isnan(speeds[back])
    np.testing.assert_allclose(speeds[back + 1 :], 1.2, atol=1e-9)


@given(st.integers(0, 10_000))
@example(1644)
def test_losses_are_bridged_alike_in_a_stream_and_in_the_whole(seed: int) -> None:
    rng = np.random.default_rng(seed)
    track = seen(float(rng.uniform(-1.5, 1.5)), 0.03, seed, 5.0, range_noise=rng.choice([0, 0.03]))
    t = np.round(track.t + rng.uniform(-0.004, 0.004, len(track)), 3)
    head = track.head.copy()
    for begin in rng.uniform(0, 5, rng.integers(1, 5)):
        head[(t > begin) & (t < begin + rng.uniform(0.2, 1.3))] = np.nan
    track = replace(track, t=t + rng.choice([0.0, 1.7e9]), head=head)
    assert_same(stream(track), track)
    [alone, _] = observe_all([track, seen(1.0, 0.03, 1)])
    np.testing.assert_array_equal(alone.values, observe(track).values)
    [_, second] = observe_all([seen(1.0, 0.03, 1), track])
    np.testing.assert_array_equal(second.values, observe(track).values)


def test_who_is_seen_now_and_then_is_not_remembered_for_long() -> None:
    sampler = Sampler()
    for i in range(6000):  # ten minutes, one frame of five
        t = i / 10
        sampler.push(PersonFrame(t, (3.0, 0.1 * (i % 3), 1.6)) if i % 5 == 0 else PersonFrame(t))
    assert len(sampler._walk._t) < 20


def test_a_track_that_begins_unseen_costs_nothing_of_the_one_before() -> None:
    long, late = seen(0.0, 0.0, 0, 120.0), lose(seen(1.0, 0.03, 1), -1.0, 1.0)
    tracemalloc.start()
    observe_all([long, late])
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 20e6  # slopes between all positions of two minutes are 200 MB

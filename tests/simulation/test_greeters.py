"""People drawn at random do what Kendon and the thesis say people do."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kendon.errors import ParameterError
from kendon.features import observe
from kendon.features.gestures import GestureDetector
from kendon.features.track import watch
from kendon.person import JOINTS
from kendon.phases import Phase
from kendon.simulation.greeters import draw_greeter, draw_passerby, perform
from kendon.simulation.sets import Seeing, simulate

seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_a_greeting_goes_from_sighting_to_a_close_salutation(seed: int) -> None:
    rng = np.random.default_rng(seed)
    greeter = draw_greeter(rng)
    track = perform(greeter, rng, "someone")
    assert track.phases is not None
    assert track.phases[0] == Phase.IA
    assert track.phases[-1] == Phase.CS
    entered = track.phases[np.flatnonzero(np.diff(track.phases, prepend=0))].tolist()
    assert entered.count(Phase.CS) == 1
    assert entered.count(Phase.DS) <= 1
    assert entered.count(Phase.HD) <= 1
    if Phase.HD in entered:  # 2.1.3: a dip follows a salutation
        assert entered.index(Phase.DS) < entered.index(Phase.HD)
    way = np.hypot(track.head[:, 0], track.head[:, 1])
    assert way[0] == pytest.approx(greeter.start, abs=0.2)
    assert way[-1] == pytest.approx(greeter.stop, abs=0.2)
    approaching = track.phases == Phase.APP
    assert (way[approaching] > greeter.final - 0.1).all()


@given(seeds)
def test_nobody_runs_and_everybody_stands_in_the_end(seed: int) -> None:
    rng = np.random.default_rng(seed)
    greeter = draw_greeter(rng)
    seen = observe(perform(greeter, rng))
    speed = seen.values[:, 1]
    assert np.nanmax(speed) < greeter.speed + 0.5
    assert abs(np.nanmedian(speed[-3:])) < 0.35  # swaying, not walking
    assert seen.phases is not None
    assert np.isfinite(seen.values[:, 0]).all()


@given(seeds)
def test_keys_are_pressed_by_the_true_phases(seed: int) -> None:
    rng = np.random.default_rng(seed)
    track = perform(draw_greeter(rng), rng)
    for column, phase in enumerate((Phase.DS, Phase.CS, Phase.HD)):
        np.testing.assert_array_equal(track.gestures[:, column], track.phases == phase)


@given(seeds)
def test_joints_change_nothing_else_that_is_drawn(seed: int) -> None:
    rng, other = np.random.default_rng(seed), np.random.default_rng(seed)
    greeter = draw_greeter(rng)
    plain, track = perform(greeter, rng), perform(draw_greeter(other), other, joints=True)
    np.testing.assert_array_equal(track.t, plain.t)
    np.testing.assert_array_equal(track.phases, plain.phases)
    np.testing.assert_array_equal(track.smile, plain.smile)
    assert rng.random() == other.random()
    assert np.isnan(track.gestures).all()
    # The head is where it was, but for steps, sways, bows and dips.
    assert np.linalg.norm(track.head - plain.head, axis=1).max() < 0.8
    assert np.quantile(track.head[:, 2], 0.9) == pytest.approx(greeter.height, abs=0.08)
    for points in (track.head, *track.joints.values()):
        speeds = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(track.t)
        assert speeds.max() < 7.5


@given(seeds)
def test_who_walks_past_with_a_body_swings_it(seed: int) -> None:
    track = draw_passerby(np.random.default_rng(seed), joints=True)
    plain = draw_passerby(np.random.default_rng(seed))
    assert set(track.joints) == set(JOINTS)
    assert np.isnan(track.gestures).all()
    assert np.linalg.norm(track.head - plain.head, axis=1).max() < 0.25
    np.testing.assert_array_equal(track.smile, plain.smile)


def test_people_differ_as_kendon_says() -> None:
    rng = np.random.default_rng(0)
    tracks = [perform(draw_greeter(rng), rng) for _ in range(300)]
    phases = [set(t.phases.tolist()) for t in tracks if t.phases is not None]
    salute = np.mean([Phase.DS in p for p in phases])
    assert 0.5 < salute < 0.7  # table 3.2: 18 of 33
    starts = np.array([np.hypot(*t.head[0, :2]) for t in tracks])
    assert starts.min() < 3 < 9 < starts.max()
    looks = [np.nanmean(observe(t).values[:, 2]) for t in tracks]
    assert min(looks) < 0.3 < 0.7 < max(looks)


@given(seeds)
def test_who_walks_past_greets_nobody(seed: int) -> None:
    track = draw_passerby(np.random.default_rng(seed))
    assert track.phases is not None
    assert (track.phases == 0).all()
    assert (track.gestures == 0).all()
    assert np.hypot(track.head[:, 0], track.head[:, 1]).min() > 0.7


def test_a_seed_gives_the_same_people_in_any_number_of_jobs() -> None:
    alone = simulate(130, 7, seeing=Seeing.VARIED, passersby=0.2)
    many = simulate(130, 7, seeing=Seeing.VARIED, passersby=0.2, jobs=2)
    fewer = simulate(20, 7, seeing=Seeing.VARIED, passersby=0.2)
    assert [g.name for g in alone] == [g.name for g in many]
    for one, two in zip(alone, many, strict=True):
        np.testing.assert_array_equal(one.values, two.values)
    for one, two in zip(fewer, alone, strict=False):
        np.testing.assert_array_equal(one.values, two.values)
    other = simulate(20, 8, seeing=Seeing.VARIED)
    assert any(len(a) != len(b) for a, b in zip(fewer, other, strict=True))
    assert {g.name.split("_")[0] for g in alone} == {"greeting", "passerby"}


@pytest.mark.parametrize("wrong", [{"n": 0}, {"seed": -1}, {"passersby": 1.5}])
def test_impossible_sets_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ParameterError):
        simulate(**{"n": 3, **wrong})  # type: ignore[arg-type]


def test_heads_on_the_way_move_up_and_down_by_degrees_and_are_not_read_as_nods() -> None:
    """As recorded people's do: 1 to 2 degrees between 0.3 and 1.6 Hz."""
    told = asked = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        greeter = replace(draw_greeter(rng), stares=True, wave_at=math.nan, dip_after=math.nan)
        rails = perform(greeter, np.random.default_rng(seed))
        ahead = Rotation.from_quat(rails.head_rotation).apply([1.0, 0.0, 0.0])
        to_face = np.array([0.0, 0.0, 1.2]) - rails.head
        to_face /= np.linalg.norm(to_face, axis=1, keepdims=True)
        off = np.degrees(np.arcsin(ahead[:, 2]) - np.arcsin(to_face[:, 2]))
        assert 0.3 < off.std() < 2.5
        walker = perform(greeter, np.random.default_rng(seed), joints=True)
        detector = GestureDetector()
        for question, _ in watch(walker, detector):
            nod = detector.gestures(*question).nod
            asked += nod == nod
            told += nod > 0.5
    assert told < 0.02 * asked

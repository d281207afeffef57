"""Sensors spoil what they say they spoil, by as much as they say, and nothing else."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kendon.errors import ParameterError, UnknownNameError
from kendon.person import Track
from kendon.simulation.sensors import SENSORS, Sensor, draw_sensor, sensor


def stander(way: float, frames: int = 3000) -> Track:
    """Somebody who stands and looks at the robot."""
    t = np.arange(frames) / 30
    return Track.build(
        t,
        np.tile([way * 0.6, way * 0.8, 1.6], (frames, 1)),
        head_rotation=np.tile([0.0, 0.0, 1.0, 0.0], (frames, 1)),
        smile=np.full(frames, 2.0),
        gestures=np.zeros((frames, 3)),
        phases=np.full(frames, 6),
        joints={"l_wrist": np.tile([way, 0.0, 1.0], (frames, 1))},
        name="stander",
    )


def see(track: Track, **what: Any) -> Track:
    return Sensor(**what).see(track, np.random.default_rng(0))


def test_the_clean_sensor_changes_nothing() -> None:
    track = stander(3)
    seen = sensor("clean")(track)
    for field in ("t", "head", "head_rotation", "smile", "gestures", "phases"):
        np.testing.assert_array_equal(getattr(seen, field), getattr(track, field))


def test_range_noise_is_a_share_of_the_distance_along_the_line_of_sight() -> None:
    for way in (2.0, 8.0):
        seen = see(stander(way), range_noise=0.05)
        distance = np.hypot(seen.head[:, 0], seen.head[:, 1])
        assert np.std(distance) == pytest.approx(0.05 * way, rel=0.05)
        assert np.mean(distance) == pytest.approx(way, rel=0.01)
        np.testing.assert_allclose(seen.head[:, 1] / seen.head[:, 0], 0.8 / 0.6)
        np.testing.assert_array_equal(seen.head[:, 2], 1.6)


def test_head_noise_turns_the_nose_by_so_much_sideways_and_up() -> None:
    noise = math.radians(5)
    seen = see(stander(2), head_noise=noise)
    nose = Rotation.from_quat(seen.head_rotation).apply([1.0, 0.0, 0.0])
    assert np.std(np.arctan2(nose[:, 1], -nose[:, 0])) == pytest.approx(noise, rel=0.06)
    assert np.std(np.arcsin(nose[:, 2])) == pytest.approx(noise, rel=0.06)
    np.testing.assert_allclose(np.linalg.norm(seen.head_rotation, axis=1), 1)


def test_far_faces_have_a_place_but_no_look_and_no_smile() -> None:
    near, far = see(stander(3.9), face_range=4.0), see(stander(4.1), face_range=4.0)
    assert np.isfinite(near.smile).all()
    assert np.isfinite(far.head).all()
    assert np.isnan(far.smile).all()
    assert np.isnan(far.head_rotation).all()


def test_joints_are_misplaced_with_the_face_and_each_by_itself() -> None:
    track = stander(4)
    seen = see(track, range_noise=0.05)
    shift = seen.head - track.head
    np.testing.assert_allclose(seen.joints["l_wrist"] - track.joints["l_wrist"], shift, atol=1e-12)
    seen = see(track, joint_noise=0.03, joint_memory=0.1)
    np.testing.assert_array_equal(seen.head, track.head)
    off = (seen.joints["l_wrist"] - track.joints["l_wrist"]).ravel(order="F")
    assert np.std(off) == pytest.approx(0.03, rel=0.1)
    assert np.corrcoef(off[1:], off[:-1])[0, 1] == pytest.approx(math.exp(-1 / 3), abs=0.05)


def test_arms_are_hidden_for_the_stated_share_and_some_joints_are_never_seen() -> None:
    track = stander(3, 30000)
    seen = see(track, arm_loss=0.1)
    hidden = np.isnan(seen.joints["l_wrist"][:, 0])
    assert hidden.mean() == pytest.approx(0.1, abs=0.03)
    assert np.abs(np.diff(hidden.astype(int))).sum() < 0.02 * len(track)  # in stretches
    assert see(track, joints_seen=()).joints == {}
    assert list(see(track, joints_seen=("l_wrist", "r_hip")).joints) == ["l_wrist"]
    with pytest.raises(UnknownNameError, match="l_wrist"):
        Sensor(joints_seen=("tail",))


def test_what_is_seen_of_the_face_does_not_depend_on_joints() -> None:
    track = stander(3, 60)
    faces = replace(track, joints={})
    seen, seen_face = sensor("noisy", 3)(track), sensor("noisy", 3)(faces)
    np.testing.assert_array_equal(seen.head, seen_face.head)
    np.testing.assert_array_equal(seen.head_rotation, seen_face.head_rotation)


def test_dropped_frames_and_a_loss_leave_nothing_known_but_the_truth() -> None:
    seen = see(stander(2), dropped=0.12)
    assert np.isnan(seen.head[:, 0]).mean() == pytest.approx(0.12, abs=0.02)
    seen = see(stander(2, 300), loss=0.7)
    lost = np.flatnonzero(np.isnan(seen.head[:, 0]))
    assert len(lost) in (20, 21, 22)
    assert (np.diff(lost) == 1).all()
    assert np.isnan(seen.joints["l_wrist"][lost]).all()
    np.testing.assert_array_equal(seen.phases, 6)
    assert (seen.gestures == 0).all()


def test_what_is_seen_depends_on_the_seed_and_the_name_not_on_the_order() -> None:
    one, two = stander(3, 60), replace(stander(3, 60), name="another")
    first = sensor("noisy", 1)
    again = sensor("noisy", 1)
    again(two)
    np.testing.assert_array_equal(first(one).head, again(one).head)
    assert not np.array_equal(first(one).head, first(two).head, equal_nan=True)
    assert not np.array_equal(first(one).head, sensor("noisy", 2)(one).head, equal_nan=True)


def test_a_track_is_left_as_it_was() -> None:
    track = stander(6, 60)
    before = track.head.copy(), track.smile.copy()
    sensor("noisy")(track)
    np.testing.assert_array_equal(track.head, before[0])
    np.testing.assert_array_equal(track.smile, before[1])


def test_drawn_sensors_are_within_what_is_documented() -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        drawn = draw_sensor(rng)
        assert drawn.range_noise <= 0.06
        assert math.radians(3) <= drawn.head_noise <= math.radians(20)
        assert 3 <= drawn.face_range <= 12
        assert drawn.dropped <= 0.15
        assert 0.005 <= drawn.joint_noise <= 0.05
        assert drawn.arm_loss <= 0.15


@pytest.mark.parametrize(
    "wrong",
    [
        {"range_noise": -0.1},
        {"dropped": 1.0},
        {"loss": math.nan},
        {"head_noise": 9.0},
        {"joint_noise": -0.01},
        {"arm_loss": 1.0},
    ],
)
def test_impossible_sensors_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match=next(iter(wrong))):
        Sensor(**wrong)


def test_an_unknown_sensor_is_answered_with_the_known_ones() -> None:
    with pytest.raises(UnknownNameError) as error:
        sensor("lidar")
    for name in SENSORS:
        assert name in str(error.value)

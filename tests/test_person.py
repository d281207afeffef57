"""A person seen from elsewhere, and frames into tracks and back."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from people import frames, poses, quaternion, tracks
from scipy.spatial.transform import Rotation

from kendon.errors import ParameterError
from kendon.geometry import Pose2D, Vec3
from kendon.person import LateJoints, PersonFrame, Track

DEGREES = math.pi / 180


def places(frame: PersonFrame) -> list[Vec3]:
    """Every point of a person."""
    assert frame.eyes is not None
    return [frame.head, *frame.eyes, *frame.joints.values()]


def assert_same(a: PersonFrame, b: PersonFrame) -> None:
    assert a.robot == pytest.approx(b.robot)
    assert list(a.joints) == list(b.joints)
    np.testing.assert_allclose(places(a), places(b), atol=1e-9)
    np.testing.assert_allclose(np.array(a.eye_gaze), np.array(b.eye_gaze), atol=1e-9)
    turn = Rotation.from_quat(a.head_rotation).inv() * Rotation.from_quat(b.head_rotation)
    assert turn.magnitude() == pytest.approx(0, abs=1e-7)
    assert (a.t, a.smile, a.dsal, a.csal, a.hdip) == (b.t, b.smile, b.dsal, b.csal, b.hdip)


# ---- seen from


def test_seen_from_by_hand() -> None:
    # Two metres ahead of a robot at the origin, looking back at it; the other robot stands one
    # metre to the left of that and looks to the right, along the world's -y.
    frame = PersonFrame(
        3.0,
        (2.0, 0.0, 1.6),
        quaternion(180 * DEGREES),
        ((2.0, -0.03, 1.6), (2.0, 0.03, 1.6)),
        ((-1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)),
        {"l_wrist": (1.8, -0.3, 1.0)},
    )
    seen = frame.seen_from(Pose2D(0.0, 1.0, -90 * DEGREES))
    assert seen.head == pytest.approx((1.0, 2.0, 1.6))
    assert seen.joints["l_wrist"] == pytest.approx((1.3, 1.8, 1.0))
    assert seen.eyes is not None
    assert seen.eye_gaze is not None
    assert seen.eyes[0] == pytest.approx((1.03, 2.0, 1.6))
    assert seen.eye_gaze[0] == pytest.approx((0.0, -1.0, 0.0), abs=1e-12)
    x_axis = Rotation.from_quat(seen.head_rotation).as_matrix()[:, 0]
    np.testing.assert_allclose(x_axis, [0, -1, 0], atol=1e-12)


@given(frames())
def test_seen_from_where_it_was_seen_changes_nothing(frame: PersonFrame) -> None:
    assert frame.seen_from(frame.robot) == frame


@given(frames(), poses)
def test_seeing_from_elsewhere_and_back_changes_nothing(frame: PersonFrame, there: Pose2D) -> None:
    assert_same(frame.seen_from(there).seen_from(frame.robot), frame)


@given(frames(), poses, poses)
def test_a_stop_on_the_way_changes_nothing(frame: PersonFrame, a: Pose2D, b: Pose2D) -> None:
    assert_same(frame.seen_from(a).seen_from(b), frame.seen_from(b))


@given(frames(), poses)
def test_the_body_keeps_its_shape_and_its_place_in_the_world(
    frame: PersonFrame, there: Pose2D
) -> None:
    seen = frame.seen_from(there)
    pairs = zip(combinations(places(frame), 2), combinations(places(seen), 2), strict=True)
    for before, after in pairs:
        assert math.dist(*after) == pytest.approx(math.dist(*before), abs=1e-9)
    for before_, after_ in zip(places(frame), places(seen), strict=True):
        assert there.to_world(after_) == pytest.approx(frame.robot.to_world(before_), abs=1e-9)


@given(poses)
def test_unknown_stays_unknown(there: Pose2D) -> None:
    seen = PersonFrame(1.0).seen_from(there)
    assert not seen.seen
    assert np.isnan([*seen.head, *seen.head_rotation, seen.smile]).all()
    assert seen.eyes is None
    assert seen.eye_gaze is None
    assert seen.joints == {}


def test_joints_are_worked_out_once_and_not_before_somebody_looks() -> None:
    places = {"l_wrist": (1.0, 2.0, 0.9)}
    looks: list[str] = []

    def work_out() -> dict[str, Vec3]:
        looks.append("looked")
        return places

    joints = LateJoints(places, work_out)
    assert (len(joints), list(joints), bool(joints), looks) == (1, ["l_wrist"], True, [])
    assert joints == places
    assert repr(joints) == repr(places)
    assert (joints["l_wrist"], joints.get("r_wrist")) == ((1.0, 2.0, 0.9), None)
    assert looks == ["looked"]


@pytest.mark.parametrize(
    ("head", "seen"),
    [((1.0, 0.0, 1.5), True), ((1.0, 0.0, math.nan), True), ((1.0, math.nan, 1.5), False)],
)
def test_seen_means_that_the_place_on_the_ground_is_known(head: Vec3, seen: bool) -> None:
    assert PersonFrame(0.0, head).seen is seen


# ---- tracks


@given(tracks())
def test_a_track_survives_being_taken_apart(track: Track) -> None:
    again = Track.from_frames(track, name=track.name)
    assert len(again) == len(track)
    for field in ("t", "head", "head_rotation", "smile", "gestures", "robot"):
        np.testing.assert_array_equal(getattr(again, field), getattr(track, field))
    np.testing.assert_array_equal(again.joints["r_wrist"], track.joints["r_wrist"])
    looks = np.isfinite(track.eyes).any(axis=(1, 2))  # without eyes, a direction has no start
    np.testing.assert_array_equal(again.eyes, track.eyes)
    np.testing.assert_array_equal(again.eye_gaze[looks], track.eye_gaze[looks])
    assert np.isnan(again.eye_gaze[~looks]).all()


def test_a_joint_seen_in_some_frames_is_unknown_in_the_others() -> None:
    track = Track.from_frames(
        [PersonFrame(0.0), PersonFrame(0.1, joints={"l_hip": (1.0, 2.0, 3.0)}), PersonFrame(0.2)]
    )
    np.testing.assert_array_equal(track.joints["l_hip"][1], [1, 2, 3])
    assert np.isnan(track.joints["l_hip"][[0, 2]]).all()
    assert track.duration == pytest.approx(0.2)


def test_a_track_without_frames() -> None:
    track = Track.from_frames([])
    assert len(track) == 0
    assert track.duration == 0
    assert list(track) == []


def test_what_is_not_given_is_unknown_and_the_robot_stands_at_the_origin() -> None:
    track = Track.build(np.array([0.0, 1.0]), np.ones((2, 3)))
    (first, second) = track
    assert first.seen
    assert second.robot == (0.0, 0.0, 0.0)
    assert first.eyes is None
    assert np.isnan([*first.head_rotation, first.smile, first.dsal, first.csal, first.hdip]).all()
    assert track.phases is None


TIMES = np.arange(4.0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"head": np.ones((3, 3))},
        {"head_rotation": np.ones((4, 3))},
        {"eyes": np.ones((4, 3))},
        {"joints": {"l_hip": np.ones((4, 2))}},
        {"gestures": np.ones(4)},
        {"phases": np.ones(3, dtype=int)},
        {"t": np.array([0.0, 1.0, 1.0, 2.0])},
        {"t": np.array([0.0, 2.0, 1.0, 3.0])},
        {"t": np.array([0.0, 1.0, np.nan, 3.0])},
    ],
    ids=lambda wrong: "-".join(wrong),
)
def test_arrays_that_do_not_fit_are_refused(wrong: dict[str, np.ndarray]) -> None:
    right = {"t": TIMES, "head": np.ones((4, 3))}
    with pytest.raises(ParameterError, match=r"needs|must be finite and grow"):
        Track.build(**(right | wrong))


def test_keys_pressed_by_true_phases() -> None:
    track = Track.build(
        np.arange(8.0),
        np.ones((8, 3)),
        gestures=np.full((8, 3), 0.5),
        phases=np.array([-1, 0, 1, 2, 3, 4, 5, 6]),
    )
    pressed = track.with_gestures_from_phases().gestures
    np.testing.assert_array_equal(pressed[0], [0.5, 0.5, 0.5])  # not labelled: as it was
    np.testing.assert_array_equal(pressed[1:, 0], [0, 0, 1, 0, 0, 0, 0])  # dsal in DS
    np.testing.assert_array_equal(pressed[1:, 1], [0, 0, 0, 0, 0, 0, 1])  # csal in CS
    np.testing.assert_array_equal(pressed[1:, 2], [0, 0, 0, 1, 0, 0, 0])  # hdip in HD
    np.testing.assert_array_equal(track.gestures, 0.5)


def test_without_true_phases_no_keys_can_be_pressed() -> None:
    with pytest.raises(ParameterError, match="no true phases"):
        Track.build(TIMES, np.ones((4, 3))).with_gestures_from_phases()

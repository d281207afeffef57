"""ROS bags: people of known motion in each kind of bag, and what can be wrong with them."""

from __future__ import annotations

import math
import shutil
import sqlite3
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from people import assert_one_sentence
from scipy.spatial.transform import Rotation
from shared_data import shared_file, shared_files

pytest.importorskip("rosbags", reason="the extra 'bags' is not installed")
from bag_files import EPOCH, KINDS, Ids, Match, Text, Told, Transform, Units, write_bag

from kendon.errors import DataError, MissingExtraError
from kendon.features import observe
from kendon.greetings import expand, load_observations
from kendon.person import FloatArray
from kendon.sources import (
    BagSource,
    CameraMount,
    SourceOptions,
    open_source,
    read_bag,
    read_bag_people,
)
from kendon.sources.bag_people import BagOptions
from kendon.sources.base import find_source

Quat = tuple[float, float, float, float]
Vec = tuple[float, float, float]

OPTICAL = "camera_color_optical_frame"
#: Axes x right, y down, z ahead of a level camera, as columns in x ahead, y left, z up.
LEVEL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
#: From a face (x ahead) to its gaze (z ahead).
GAZE: Quat = (-0.5, 0.5, -0.5, 0.5)
SPEED = 0.8  # [m/s]
RATE = 30.0


def quat(matrix: FloatArray) -> Quat:
    x, y, z, w = Rotation.from_matrix(matrix).as_quat().tolist()
    return (x, y, z, w)


def vec(values: FloatArray) -> Vec:
    x, y, z = values.tolist()
    return (x, y, z)


def turned(yaw: float) -> FloatArray:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def walk(t: float) -> FloatArray:
    """Straight toward the camera's axis, 0.3 m beside it and 0.4 m above it; x ahead."""
    return np.array([4.0 - SPEED * t, 0.3, 0.4])


def face(
    name: str,
    *,
    yaw: float = math.pi,
    frames: int = 91,
    place: Callable[[float], FloatArray] = walk,
    start: float = 0.0,
) -> list[Told]:
    """A face before a camera alone, whose x axis points along a yaw of the camera's level frame."""
    told: list[Told] = []
    for i in range(frames):
        t = start + i / RATE
        rotation = quat(LEVEL.T @ turned(yaw))
        told.append(Transform(t, OPTICAL, f"face_{name}", vec(LEVEL.T @ place(t)), rotation))
        told.append(Transform(t, f"face_{name}", f"gaze_{name}", rotation=GAZE))
    return told


def robot(*, frames: int = 91, speed: float = 0.5) -> list[Told]:
    """A robot that drives along x of odom, its camera 0.1 m ahead, 1.1 m up and 0.2 rad left."""
    mount = quat(turned(0.2) @ LEVEL)
    told: list[Told] = [Transform(0, "base_footprint", OPTICAL, (0.1, 0, 1.1), mount, static=True)]
    for i in range(-10, frames + 10, 3):
        told.append(Transform(i / RATE, "odom", "base_footprint", (speed * i / RATE, 0.0, 0.0)))
    return told


# ---- a camera alone


@pytest.mark.parametrize("kind", KINDS)
def test_a_walk_before_a_camera_is_read_exactly(tmp_path: Path, kind: str) -> None:
    path = write_bag(tmp_path, kind, face("ab1"))
    source = open_source(path)
    assert isinstance(source, BagSource)
    track = source.record()
    assert track.t == pytest.approx(np.arange(91) / RATE, abs=1e-8)
    wanted = np.array([walk(t) for t in track.t]) + np.array([0, 0, 1.2])
    np.testing.assert_allclose(track.head, wanted, atol=1e-7)
    ahead = Rotation.from_quat(track.head_rotation).apply([1, 0, 0])
    np.testing.assert_allclose(ahead, np.tile([-1.0, 0, 0], (91, 1)), atol=1e-9)
    assert track.name == "people_ab1"
    assert "is taken to be a camera at 0,0,1.2" in source.notes[0]


@pytest.mark.parametrize("kind", KINDS)
def test_its_observations_are_those_of_the_closed_form(tmp_path: Path, kind: str) -> None:
    seen = load_observations(str(write_bag(tmp_path, kind, face("ab1"))))
    # An observation is the median of its interval's six frames, the first one's of seven.
    middle = seen.t - 2.5 / RATE
    middle[0] = 3 / RATE
    distance = np.hypot(4.0 - SPEED * middle, 0.3)
    assert seen.values[:, 0] == pytest.approx(distance, abs=1e-3)
    assert seen.values[5:, 1] == pytest.approx(SPEED, abs=0.02)
    # Straight ahead along -x, the gaze point lies 0.3 m beside and 0.4 m above the camera.
    way = 4.0 - SPEED * middle
    assert seen.values[:, 2] == pytest.approx(0.5 / (math.tan(math.radians(30)) * way), rel=1e-3)
    assert np.isnan(seen.values[:, 3:6]).all()
    assert (seen.values[:, 6] < 0.1).all()  # a head that moves straight on does not dip


@pytest.mark.parametrize(("y", "z"), [(0.0, 0.0), (0.9, 0.3), (-1.4, -0.5)])
def test_who_looks_at_the_camera_has_gaze_zero(tmp_path: Path, y: float, z: float) -> None:
    place = np.array([2.0, y, z])
    ahead = -place / np.linalg.norm(place)
    left = np.cross([0, 0, 1], ahead) / np.linalg.norm(np.cross([0, 0, 1], ahead))
    rotation = np.stack([ahead, left, np.cross(ahead, left)], axis=1)
    told: list[Told] = []
    for i in range(30):
        told.append(
            Transform(i / RATE, OPTICAL, "face_x", vec(LEVEL.T @ place), quat(LEVEL.T @ rotation))
        )
        told.append(Transform(i / RATE, "face_x", "gaze_x", rotation=GAZE))
    track = read_bag(write_bag(tmp_path, "db3", told)).track
    assert observe(track).values[:, 2] == pytest.approx(0, abs=1e-6)
    assert np.isnan(track.eye_gaze).all(), "a gaze that repeats the head is no gaze of the eyes"


def test_the_camera_sits_where_it_is_told_to(tmp_path: Path) -> None:
    path = write_bag(tmp_path, "mcap", face("ab1"))
    mount = CameraMount((0.1, 0.2, 1.0), yaw=math.pi / 2)
    source = open_source(path, SourceOptions(camera=mount))
    wanted = np.array([turned(math.pi / 2) @ walk(i / RATE) for i in range(91)]) + np.array(
        [0.1, 0.2, 1.0]
    )
    np.testing.assert_allclose(source.record().head, wanted, atol=1e-7)
    assert "--robot-face 0.1,0.2,1" in " ".join(source.notes)


@pytest.mark.parametrize(("name", "axes"), [("usb_cam", LEVEL), ("camera_link", np.eye(3))])
def test_a_camera_frame_is_optical_where_people_stand_along_its_z(
    tmp_path: Path, name: str, axes: FloatArray
) -> None:
    told: list[Told] = [
        Transform(i / RATE, name, "face_a", vec(axes.T @ walk(i / RATE)), quat(axes.T))
        for i in range(31)
    ]
    told += [Transform(0, "face_a", "gaze_a", rotation=GAZE, static=True)]
    track = read_bag(write_bag(tmp_path, "db3", told)).track
    np.testing.assert_allclose(track.head[0], walk(0) + np.array([0, 0, 1.2]), atol=1e-7)


# ---- a robot with a base


@pytest.mark.parametrize("kind", KINDS)
def test_people_are_placed_in_the_base_of_a_robot_that_drives(tmp_path: Path, kind: str) -> None:
    path = write_bag(tmp_path, kind, robot() + face("ab1"))
    found = read_bag(path)
    track = found.track
    wanted = np.array([turned(0.2) @ walk(t) for t in track.t]) + np.array([0.1, 0, 1.1])
    np.testing.assert_allclose(track.head, wanted, atol=1e-7)
    np.testing.assert_allclose(track.robot[:, 0], 0.5 * track.t, atol=1e-7)
    np.testing.assert_allclose(track.robot[:, 1:], 0, atol=1e-9)
    ahead = Rotation.from_quat(track.head_rotation).apply([1, 0, 0])
    np.testing.assert_allclose(
        ahead, np.tile([-math.cos(0.2), -math.sin(0.2), 0], (91, 1)), atol=1e-9
    )
    assert any("--robot-face 0.1,0,1.1" in note for note in found.notes)


def test_the_robots_own_drive_is_not_the_persons_speed(tmp_path: Path) -> None:
    # The person stands in odom; the robot drives toward them at 0.5 m/s.
    stands: list[Told] = [
        Transform(i / RATE, "odom", "face_a", (4.0, 0.0, 1.6), (0.0, 0.0, 1.0, 0.0))
        for i in range(91)
    ]
    stands += [Transform(0, "face_a", "gaze_a", rotation=GAZE, static=True)]
    seen = observe(read_bag(write_bag(tmp_path, "db3", robot() + stands)).track)
    assert seen.values[1:, 0] == pytest.approx(4.0 - 0.5 * (seen.t[1:] - 2.5 / RATE), abs=1e-3)
    assert seen.values[3:, 1] == pytest.approx(0, abs=0.01)


def test_another_base_can_be_named(tmp_path: Path) -> None:
    path = write_bag(tmp_path, "db3", robot() + face("ab1"))
    track = read_bag(path, BagOptions(base="odom")).track
    np.testing.assert_allclose(
        track.head[:, 0], [0.5 * t + 0.1 + (turned(0.2) @ walk(t))[0] for t in track.t], atol=1e-7
    )
    with pytest.raises(DataError, match="there is no frame 'torso'; valid: base_footprint, "):
        read_bag(path, BagOptions(base="torso"))


def test_base_link_stands_in_for_a_footprint(tmp_path: Path) -> None:
    told: list[Told] = [Transform(0, "base_link", OPTICAL, (0, 0, 1), quat(LEVEL), static=True)]
    found = read_bag(write_bag(tmp_path, "db3", told + face("ab1")))
    np.testing.assert_allclose(found.track.head[0], walk(0) + np.array([0, 0, 1]), atol=1e-7)
    assert "base_link is taken to lie on the floor" in " ".join(found.notes)
    assert "taken to stand still" in " ".join(found.notes)


# ---- gaze, smiles, bodies


def test_a_gaze_of_its_own_is_that_of_the_eyes(tmp_path: Path) -> None:
    # The head points 0.5 rad past the camera, the eyes make up for it.
    place = np.array([1.0, 0.0, 0.0])
    told: list[Told] = []
    for i in range(30):
        head = LEVEL.T @ turned(math.pi + 0.5)
        told.append(Transform(i / RATE, OPTICAL, "face_x", vec(LEVEL.T @ place), quat(head)))
        told.append(Transform(i / RATE, "face_x", "gaze_x", rotation=quat(turned(-0.5) @ LEVEL)))
    track = read_bag(write_bag(tmp_path, "db3", told)).track
    np.testing.assert_allclose(track.eye_gaze[0], [[-1, 0, 0]] * 2, atol=1e-9)
    np.testing.assert_allclose(track.eyes[0], track.head[[0, 0]], atol=1e-9)
    assert observe(track).values[:, 2] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize(("scale", "noted"), [(5.0, False), (1.0, True)])
def test_a_smile_comes_from_the_action_units(tmp_path: Path, scale: float, noted: bool) -> None:
    told = face("ab1")
    for i in range(0, 61, 2):
        units = {6: 0.4 * scale, 12: 0.8 * scale, 25: scale}
        told.append(Units(i / RATE, "ab1", units))
    found = read_bag(write_bag(tmp_path, "mcap", told))
    np.testing.assert_allclose(found.track.smile[:61], 3.0, atol=1e-5)
    assert np.isnan(found.track.smile[67:]).all(), "the last smile does not hold for ever"
    assert any("shares of the full intensity" in note for note in found.notes) is noted


def test_action_units_without_confidence_are_unknown(tmp_path: Path) -> None:
    told = face("ab1", frames=31)
    for i in range(31):
        told.append(Units(i / RATE, "ab1", {6: 2.0, 12: 3.0}, {6: 1.0, 12: float(i >= 15)}))
    smile = read_bag(write_bag(tmp_path, "db3", told)).track.smile
    assert np.isnan(smile[:15]).all()
    np.testing.assert_allclose(smile[15:], 2.5)


def test_an_unknown_scale_of_action_units_is_told(tmp_path: Path) -> None:
    told = [*face("ab1", frames=31), Units(0.5, "ab1", {12: 80.0})]
    found = read_bag(write_bag(tmp_path, "db3", told))
    assert np.isnan(found.track.smile).all()
    assert "reach 80" in " ".join(found.notes)


def body(name: str, *, start: float, frames: int) -> list[Told]:
    """A skeleton whose hips walk as `walk`, with head, wrists and a fixed elbow."""
    told: list[Told] = [
        Transform(0, f"body_{name}", f"l_elbow_{name}", (0.0, 0.3, 0.2), static=True),
        Transform(0, f"body_{name}", f"head_{name}", (0.1, 0.0, 0.7), static=True),
    ]
    facing = quat(LEVEL.T @ turned(math.pi))
    for i in range(frames):
        t = start + i / 15
        hips = walk(t) - np.array([0, 0, 0.7])
        told.append(Transform(t, OPTICAL, f"body_{name}", vec(LEVEL.T @ hips), facing))
        told.append(Transform(t, f"body_{name}", f"r_wrist_{name}", (0.2, -0.3, 0.1 * t)))
    return told


def test_joints_and_head_of_a_body(tmp_path: Path) -> None:
    track = read_bag(write_bag(tmp_path, "db3", body("b7", start=0.0, frames=31))).track
    walked = np.array([walk(t) for t in track.t]) + np.array([0, 0, 0.5])
    # A body that faces the camera has its left at the camera's right, which is -y.
    np.testing.assert_allclose(track.head, walked + np.array([-0.1, 0, 0.7]), atol=1e-7)
    np.testing.assert_allclose(
        track.joints["l_elbow"], walked + np.array([0, -0.3, 0.2]), atol=1e-7
    )
    wrist = walked + np.stack([-0.2 + 0 * track.t, 0.3 + 0 * track.t, 0.1 * track.t], axis=1)
    np.testing.assert_allclose(track.joints["r_wrist"], wrist, atol=1e-7)
    assert set(track.joints) == {"l_elbow", "r_wrist"}


def test_a_lost_face_is_stood_in_for_by_the_head(tmp_path: Path) -> None:
    told = face("f1", frames=31) + body("b7", start=0.0, frames=31)
    told += [Text(0.1, "/humans/persons/ann/face_id", "f1")]
    told += [Text(0.1, "/humans/persons/ann/body_id", "b7")]
    (track,) = read_bag_people(write_bag(tmp_path, "db3", told))
    assert track.name == "people_ann"
    near = track.t <= 1.0
    assert near.sum() == 31, "the head adds nothing while the face is seen"
    np.testing.assert_allclose(track.head[near, 0], 4 - SPEED * track.t[near], atol=1e-6)
    np.testing.assert_allclose(track.head[~near, 0], 3.9 - SPEED * track.t[~near], atol=1e-6)
    assert track.t[-1] == pytest.approx(2.0)
    assert np.isfinite(track.joints["r_wrist"]).all(axis=1).sum() >= len(track) - 1


# ---- several people


def aside(t: float) -> FloatArray:
    return np.array([2.0, -1.0, 0.3])


def two_people() -> list[Told]:
    told = face("f1") + face("f2", place=aside, start=0.5, frames=61)
    return [
        *told,
        Ids(0.0, "/humans/persons/tracked", ["ann", "bob"]),
        Text(0.1, "/humans/persons/ann/face_id", "f1"),
        Text(0.1, "/humans/persons/bob/face_id", ""),
        Text(0.6, "/humans/persons/bob/face_id", "f2"),
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_two_people_are_two_recordings_with_one_clock(tmp_path: Path, kind: str) -> None:
    path = write_bag(tmp_path, kind, two_people())
    assert expand([path]) == [f"{path}#ann", f"{path}#bob"]
    ann, bob = read_bag_people(path)
    assert (ann.t[0], bob.t[0]) == (0.0, pytest.approx(0.5))
    np.testing.assert_allclose(bob.head, np.tile([2.0, -1.0, 1.5], (61, 1)), atol=1e-7)
    by_name = open_source(f"{path}#bob").record()
    by_face = open_source(f"{path}#f2").record()
    np.testing.assert_array_equal(by_name.head, bob.head)
    np.testing.assert_array_equal(by_face.head, bob.head)
    alone = open_source(path)
    np.testing.assert_array_equal(alone.record().head, ann.head)
    assert "holds 2 people; read is ann" in alone.notes[0]


def test_one_person_is_the_bag_itself(tmp_path: Path) -> None:
    path = write_bag(tmp_path, "db3", face("f1"))
    assert expand([path]) == [str(path)]
    storage = path / "people.db3"
    assert expand([storage]) == [storage]
    assert len(open_source(storage).record()) == 91


def test_a_person_keeps_their_id_when_the_face_gets_a_new_one(tmp_path: Path) -> None:
    told = face("f1", frames=31) + face("f2", frames=31, start=2.0)
    told += [Text(0.1, "/humans/persons/ann/face_id", "f1")]
    told += [Text(2.1, "/humans/persons/ann/face_id", "f2")]
    (track,) = read_bag_people(write_bag(tmp_path, "db3", told))
    np.testing.assert_allclose(track.head[:, 0], 4.0 - SPEED * track.t, atol=1e-6)
    assert np.diff(track.t).max() == pytest.approx(1.0)


def test_persons_are_found_by_candidate_matches(tmp_path: Path) -> None:
    told = face("f1", frames=31) + face("f2", frames=31, place=aside)
    told += body("b1", start=0.0, frames=16)
    told += [
        Match(0.1, (2, "f1"), (1, "ann"), 0.7),
        Match(0.1, (2, "f1"), (1, "eve"), 0.6),
        Match(0.2, (1, "bob"), (2, "f2"), 0.4),  # not sure enough
        Match(0.2, (2, "f1"), (3, "b1"), 0.9),
    ]
    path = write_bag(tmp_path, "db3", told)
    assert [track.name for track in read_bag_people(path)] == ["people_ann", "people_f2"]
    assert "r_wrist" in read_bag(path, person="b1").track.joints


def test_a_person_who_turned_out_to_be_another(tmp_path: Path) -> None:
    told = [
        *face("f1", frames=31),
        Text(0.1, "/humans/persons/anonymous_1/face_id", "f1"),
        Text(0.5, "/humans/persons/anonymous_1/alias", "ann"),
    ]
    assert read_bag(write_bag(tmp_path, "db3", told), person="ann").track.name == "people_ann"


# ---- clocks and order


def test_late_and_repeated_transforms_change_nothing(tmp_path: Path) -> None:
    told = face("f1")
    shuffled = [
        one._replace(lag=0.3) if i % 7 == 0 and isinstance(one, Transform) else one
        for i, one in enumerate(told)
    ]
    repeated = [one._replace(lag=0.02) for one in told[:40] if isinstance(one, Transform)]
    good = read_bag(write_bag(tmp_path, "db3", told)).track
    found = read_bag(write_bag(tmp_path, "mcap", [*shuffled, *repeated], "shuffled"))
    np.testing.assert_array_equal(found.track.t, good.t)
    np.testing.assert_array_equal(found.track.head, good.head)
    assert "sorted by their stamps" in " ".join(found.notes)


def test_stamps_count_not_when_they_were_received(tmp_path: Path) -> None:
    told = [
        one._replace(lag=7.5 + 0.01 * (i % 5)) if isinstance(one, Transform) else one
        for i, one in enumerate(face("f1"))
    ]
    found = read_bag(write_bag(tmp_path, "db3", told))
    assert found.track.t == pytest.approx(np.arange(91) / RATE, abs=1e-8)
    assert "stamps are 7.5 s behind the recorder's clock" in " ".join(found.notes)


def wrong(tmp_path: Path, told: list[Told], **options: str) -> str:
    path = write_bag(tmp_path, "db3", told)
    with pytest.raises(DataError) as refused:
        read_bag(path, **options)  # type: ignore[arg-type]
    assert_one_sentence(refused.value, path)
    return str(refused.value)


def test_a_robot_with_another_clock_than_its_camera_is_told_of(tmp_path: Path) -> None:
    told = [
        one._replace(t=one.t + 100, lag=-100.0) if isinstance(one, Transform) else one
        for one in robot()
    ]
    found = read_bag(write_bag(tmp_path, "db3", told + face("f1")))
    assert not found.track.robot.any()
    assert f"stamped from {EPOCH:.1f} to" in " ".join(found.notes)
    assert "the robot is taken to stand still" in " ".join(found.notes)


def test_a_face_that_knows_another_time_than_its_camera(tmp_path: Path) -> None:
    told: list[Told] = [
        Transform(100 + i / 10, "base_link", OPTICAL, (0, 0, 1), quat(LEVEL), lag=-100.0)
        for i in range(30)
    ]
    message = wrong(tmp_path, told + face("f1"))
    start = EPOCH + 100
    assert f"but {OPTICAL} from {start:.1f} to {start + 2.9:.1f} s: these are two clocks" in message


def test_a_clock_that_goes_back_is_refused(tmp_path: Path) -> None:
    again = [one._replace(lag=10.0) for one in face("f1") if isinstance(one, Transform)]
    message = wrong(tmp_path, face("f1", start=5.0) + list(again))
    assert "two recordings in one" in message


# ---- what is missing or broken


def test_no_people(tmp_path: Path) -> None:
    assert "no people in this bag" in wrong(tmp_path, robot())


def test_a_robots_frames_are_nobody(tmp_path: Path) -> None:
    told = [*robot(), Transform(0.0, "base_footprint", "head_camera"), *robot()]
    told += [Transform(0.1, "base_footprint", "face_screen")]
    assert "no people in this bag" in wrong(tmp_path, list(told))


def test_people_without_transforms(tmp_path: Path) -> None:
    message = wrong(tmp_path, [*robot(), Ids(0.1, "/humans/faces/tracked", ["f1"])])
    assert "f1 is tracked, but no transform places" in message


def test_a_bag_of_other_things(tmp_path: Path) -> None:
    assert "no people in this bag" in wrong(tmp_path, [Text(0.0, "/chatter", "hello")])


def test_frames_without_a_way_to_the_base(tmp_path: Path) -> None:
    told = [one for one in robot() if isinstance(one, Transform) and not one.static]
    message = wrong(tmp_path, told + face("f1"))
    assert "no transforms connect face_f1 with base_footprint" in message


def test_a_base_that_sees_nobody_gives_way_to_one_that_does(tmp_path: Path) -> None:
    told: list[Told] = [Transform(0, "base_link", OPTICAL, (0, 0, 1), quat(LEVEL), static=True)]
    told.append(Transform(0, "map", "base_footprint", static=True))
    track = read_bag(write_bag(tmp_path, "db3", told + face("f1"))).track
    np.testing.assert_allclose(track.head[0], walk(0) + np.array([0, 0, 1]), atol=1e-7)


def test_an_unknown_person(tmp_path: Path) -> None:
    message = wrong(tmp_path, two_people(), person="eve")
    assert "there is no person 'eve'; valid: ann, bob" in message


def test_millimetres(tmp_path: Path) -> None:
    far = face("f1", place=lambda t: 1000 * walk(t))
    assert "are these millimetres" in wrong(tmp_path, far)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.95])
def test_a_torn_bag(tmp_path: Path, kind: str, share: float) -> None:
    path = write_bag(tmp_path, kind, face("f1"))
    storage = path if kind == "bag" else path / f"people.{kind}"
    content = storage.read_bytes()
    storage.write_bytes(content[: int(share * len(content))])
    with pytest.raises(DataError, match="torn") as refused:
        read_bag(path)
    assert_one_sentence(refused.value, path)


def test_a_folder_without_its_storage(tmp_path: Path) -> None:
    path = write_bag(tmp_path, "db3", face("f1"))
    (path / "people.db3").unlink()
    with pytest.raises(DataError, match="torn, or none that rosbags can read") as refused:
        read_bag(path)
    assert_one_sentence(refused.value, path)


def test_metadata_that_is_no_metadata(tmp_path: Path) -> None:
    path = write_bag(tmp_path, "mcap", face("f1"))
    (path / "metadata.yaml").write_text("{", encoding="utf-8")
    with pytest.raises(DataError, match="torn, or none that rosbags can read") as refused:
        read_bag(path)
    assert_one_sentence(refused.value, path)


@pytest.mark.parametrize("name", ["nowhere.mcap", "nowhere.bag", "nowhere.mcap#ann"])
def test_a_bag_that_is_not_there(tmp_path: Path, name: str) -> None:
    with pytest.raises(DataError, match="there is no such bag"):
        open_source(tmp_path / name)


def test_what_is_no_bag_is_not_recognised(tmp_path: Path) -> None:
    assert not BagSource.recognises(str(tmp_path))
    assert not BagSource.recognises("video.mp4#1")
    with pytest.raises(DataError, match="this is no ROS bag"):
        read_bag(tmp_path)
    marked = write_bag(tmp_path, "bag", face("f1"), "a#b")
    assert find_source(marked) is BagSource
    assert read_bag(marked).track.name == "a#b_f1"


def test_a_bag_without_message_definitions(tmp_path: Path) -> None:
    # ROS 2 Humble and older write none into .db3 files.
    told: list[Told] = [*face("f1", frames=31), Units(0.5, "f1", {6: 1.0, 12: 2.0})]
    told.append(Match(0.1, (2, "f1"), (1, "ann"), 0.7))
    path = write_bag(tmp_path, "db3", told)
    with closing(sqlite3.connect(path / "people.db3")) as storage, storage:
        storage.execute("DELETE FROM message_definitions")
    track = read_bag(path).track
    assert track.name == "people_ann"
    assert track.smile[15] == 1.5


def test_a_bag_that_was_recorded_anew_is_read_anew(tmp_path: Path) -> None:
    path = write_bag(tmp_path, "db3", face("f1"))
    assert len(read_bag(path).track) == 91
    shutil.rmtree(path)
    write_bag(tmp_path, "db3", face("f1", frames=31))
    assert len(read_bag(path).track) == 31


def test_without_rosbags_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_bag(tmp_path, "db3", face("f1"))
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    assert find_source(path) is BagSource
    with pytest.raises(MissingExtraError, match=r"'rosbags'.*kendon\[bags\]"):
        open_source(path)


# ---- real people


def test_turning_the_head_moves_the_face_the_way_it_turns() -> None:
    """The sellion lies before the neck's axis: it tells independently where a face turns."""
    for name in ("1p_AA_dis_1", "1p_FV_dis_1"):
        track = read_bag(shared_file(f"data/ros4hri_bags/{name}")).track
        ahead = Rotation.from_quat(track.head_rotation).apply([1, 0, 0])
        assert np.median(ahead[:, 0]) < -0.7, "people face the camera, not its back"
        assert np.corrcoef(ahead[:, 1], track.head[:, 1])[0, 1] > 0.6


def test_all_lent_bags_are_read() -> None:
    bags = shared_files("data/ros4hri_bags/*/metadata.yaml")
    for bag in bags:
        people = read_bag_people(bag.parent)
        assert len(people) == int(bag.parent.name[0])
        for track in people:
            assert np.nanmin(track.head[:, 0]) > 0.6
            assert np.nanmax(track.head[:, 0]) < 2.4
            assert np.median(np.diff(track.t)) == pytest.approx(1 / 30, abs=2e-3)

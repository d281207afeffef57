"""People heard live: the frames of the same bag, whatever order the messages come in."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="the extra 'bags' is not installed")
from bag_files import EPOCH, Ids, Text, Told, Transform, Units, write_bag
from hypothesis import given, settings
from hypothesis import strategies as st
from shared_data import shared_files

from kendon.person import PersonFrame, Track
from kendon.sources.bags import read_bag_people
from kendon.sources.live_people import LivePeople
from kendon.sources.ros4hri import HumansLog
from kendon.sources.ros_bags import BagMessage, read_messages

SECOND = 10**9


def robot(seconds: float = 4.0) -> list[Told]:
    """A robot that drives and turns, with a camera, at 20 Hz."""
    told: list[Told] = [
        Transform(0.0, "base_footprint", "camera", (0.1, 0.0, 1.2), (-0.5, 0.5, -0.5, 0.5), True)
    ]
    for i in range(int(seconds * 20)):
        angle = 0.01 * i
        turn = (0.0, 0.0, float(np.sin(angle / 2)), float(np.cos(angle / 2)))
        told.append(Transform(i / 20, "odom", "base_footprint", (0.02 * i, 0.0, 0.0), turn))
    return told


def person(seconds: float = 3.9, name: str = "ann", face: str = "f1") -> list[Told]:
    """Somebody with a face, a gaze of its own, a smile and a wrist, who comes nearer."""
    told: list[Told] = [Text(0.0, f"/humans/persons/{name}/face_id", face)]
    told.append(Text(0.0, f"/humans/persons/{name}/body_id", "b1"))
    told.append(Ids(0.0, "/humans/faces/tracked", [face]))
    aside = (0.0, float(np.sin(0.05)), 0.0, float(np.cos(0.05)))
    for i in range(int(seconds * 30)):
        t = 0.05 + i / 30
        place = (0.2, -0.4, 3.0 - 0.02 * i)
        told.append(Transform(t, "camera", f"face_{face}", place, (0.5, 0.5, -0.5, 0.5)))
        # As in the bags of ROS4HRI: a little after the face.
        told.append(Transform(t + 5e-5, f"face_{face}", f"gaze_{face}", rotation=aside))
        told.append(Transform(t, "camera", "body_b1", (0.2, 0.4, place[2])))
        told.append(Transform(t, "body_b1", "head_b1", (0.0, -0.8, 0.0)))
        told.append(Transform(t, "body_b1", "l_wrist_b1", (0.3, 0.1 * float(np.sin(t)), 0.0)))
        told.append(Units(t, face, {6: 2.0, 12: 2.0 + t / 4}))
    return told


def hear(
    messages: list[BagMessage], live: LivePeople | None = None
) -> dict[str, list[PersonFrame]]:
    """The frames of everybody, by name, when messages are heard."""
    live = live or LivePeople()
    found: dict[str, list[PersonFrame]] = {}
    last = messages[-1].received
    ends = [BagMessage("", last + i * SECOND // 10, None) for i in range(1, 20)]
    for topic, received, message in [*messages, *ends]:
        if message is not None:
            live.take(topic, message, received)
        for heard in live.give(received):
            found.setdefault(heard.person.name, []).append(heard.frame)
    return found


def messages_of(path: Path) -> list[BagMessage]:
    return list(read_messages(path, HumansLog.wanted))


def assert_same(frames: list[PersonFrame], track: Track) -> None:
    heard = Track.from_frames(frames)
    assert heard.t.tolist() == track.t.tolist()
    for name in ("head", "head_rotation", "eyes", "eye_gaze", "smile", "robot"):
        np.testing.assert_allclose(
            getattr(heard, name), getattr(track, name), rtol=0, atol=1e-9, err_msg=name
        )
    for joint, places in track.joints.items():
        np.testing.assert_allclose(heard.joints[joint], places, rtol=0, atol=1e-9)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("bag"), "mcap", [*robot(), *person()])


def test_what_is_heard_is_what_a_bag_holds(recording: Path) -> None:
    (track,) = read_bag_people(recording)
    frames = hear(messages_of(recording))
    assert np.isfinite(track.robot).all()
    assert np.isfinite(track.joints["l_wrist"]).any()
    assert np.isfinite(track.smile).any()
    assert np.isfinite(track.eye_gaze).any()
    assert_same(frames["ann"], track)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=5, deadline=None)
def test_the_order_of_messages_within_a_tenth_of_a_second_does_not_matter(
    recording: Path, seed: int
) -> None:
    (track,) = read_bag_people(recording)
    delay = np.random.default_rng(seed).integers(0, SECOND // 10, 10_000)
    told = [
        message._replace(received=message.received + int(delay[i]))
        for i, message in enumerate(messages_of(recording))
    ]
    told.sort(key=lambda message: message.received)
    live = LivePeople()
    frames = hear(told, live)["ann"]
    # Until the first one is out of order nobody can know that they may be.
    assert len(frames) + live.late == len(track)
    assert live.late <= 2
    there = {frame.t: frame for frame in frames}
    rows = [i for i, t in enumerate(track.t.tolist()) if t in there]
    same = [frame for i, frame in enumerate(track) if i in rows]
    for mine, theirs in zip(frames, same, strict=True):
        assert mine.head == pytest.approx(theirs.head, abs=1e-9)


def test_a_frame_waits_for_the_base_but_not_for_ever(tmp_path: Path) -> None:
    path = write_bag(tmp_path, "mcap", [*robot(2.0), *person(3.0)])
    (track,) = read_bag_people(path)
    frames = hear(messages_of(path))["ann"]
    assert [frame.t for frame in frames] == track.t.tolist()
    # Where the base was last told to be, at 1.95 s, it stays.
    assert [frame.robot.x for frame in frames] == pytest.approx(
        [0.4 * min(frame.t + 0.05, 1.95) for frame in frames], abs=1e-6
    )


def test_a_person_is_known_by_the_head_of_a_body_where_the_face_is_lost(tmp_path: Path) -> None:
    told = [
        one
        for one in [*robot(), *person()]
        if not (isinstance(one, Transform) and "f1" in one.child and 1.0 < one.t < 3.0)
    ]
    path = write_bag(tmp_path, "mcap", told)
    (track,) = read_bag_people(path)
    frames = hear(messages_of(path))["ann"]
    assert [frame.t for frame in frames] == track.t.tolist()
    assert all(frame.seen for frame in frames)


def test_a_name_that_is_told_late_goes_on_with_the_same_face(tmp_path: Path) -> None:
    told: list[Told] = [one for one in [*robot(), *person()] if not isinstance(one, Text)]
    told += [Text(2.5, "/humans/persons/ann/face_id", "f1")]
    frames = hear(messages_of(write_bag(tmp_path, "mcap", told)))
    assert list(frames) == ["b1", "f1", "ann"]  # nobody said whose body it is
    assert frames["f1"][-1].t < frames["ann"][0].t


def test_a_clock_that_is_set_back_begins_anew(recording: Path) -> None:
    messages = messages_of(recording)
    later = 10 * SECOND
    again = [m._replace(received=m.received + later) for m in messages if m.topic == "/tf"]
    live = LivePeople()
    frames = hear([*messages, *again], live)["ann"]
    times = [frame.t for frame in frames]
    assert sum(b < a for a, b in itertools.pairwise(times)) == 1
    assert any("the clock was set back" in note for note in live.notes)


def test_two_clocks_are_named(tmp_path: Path) -> None:
    live = LivePeople()
    messages = messages_of(write_bag(tmp_path, "mcap", [*robot(), *person()]))
    hear([m._replace(received=m.received + 90 * SECOND) for m in messages], live)
    assert any("90.0 s behind this computer's clock" in note for note in live.notes)


def test_a_base_by_another_clock_is_named(tmp_path: Path) -> None:
    moved = [
        one._replace(t=one.t + 500.0, lag=-500.0)
        if isinstance(one, Transform) and one.child == "base_footprint"
        else one
        for one in robot()
    ]
    live = LivePeople()
    frames = hear(messages_of(write_bag(tmp_path, "mcap", [*moved, *person(), *person(8.0)])), live)
    assert all(frame.robot.x == 0.0 for frame in frames["ann"])
    assert sum("is never known in odom" in note for note in live.notes) == 1


def test_what_is_long_over_is_forgotten(tmp_path: Path) -> None:
    live = LivePeople()
    hear(messages_of(write_bag(tmp_path, "mcap", [*robot(14.0), *person(13.0)])), live)
    oldest = live.log.transforms.stamps("face_f1")[0] / SECOND - EPOCH
    assert oldest > 9.0


@pytest.mark.parametrize("bag", ["1p_FV_eng_1", "2p_AA_FV_eng_1"])
def test_real_people_heard_are_those_of_the_bag(bag: str) -> None:
    (path,) = shared_files(f"data/ros4hri_bags/{bag}")
    frames = hear(messages_of(path))
    tracks = read_bag_people(path)
    assert len(frames) == len(tracks)
    for track in tracks:
        assert_same(frames[track.name.rsplit("_", 1)[1]], track)

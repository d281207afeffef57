"""What a node heard and told, as a bag: written by rosbags, heard again without ROS."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ros1.ros1_world import require_ros1

from kendon.errors import DataError
from kendon.estimate import estimate
from kendon.features import observe
from kendon.models import load_model
from kendon.ros.hearing import TRANSFORMS, Hearing
from kendon.ros.humans import make_stream
from kendon.ros.parts import ReadingPart, Told
from kendon.ros.ros1 import record
from kendon.ros.ros1.environment import messages, ros_module
from kendon.ros.settings import Input, NodeSettings, Part
from kendon.ros.watching import Watcher
from kendon.simulation import SimulatedPerson, script
from kendon.sources import open_source
from kendon.sources.ros_faces import fill_face
from kendon.sources.ros_place import RobotPlace

pytest.importorskip("rosbags")

START = 1_700_000_000_123_456_789  # [ns]
LATE = 30_000_000  # so long after its stamp a message comes at most [ns]


def stamp(at: int) -> Any:
    return ros_module("genpy").Time(at // 10**9, at % 10**9)


def transform(parent: str, child: str, at: int, place: Any, turn: Any) -> Any:
    told = ros_module("geometry_msgs.msg").TransformStamped()
    told.header.stamp, told.header.frame_id, told.child_frame_id = stamp(at), parent, child
    move, rotation = told.transform.translation, told.transform.rotation
    move.x, move.y, move.z = place
    rotation.x, rotation.y, rotation.z, rotation.w = turn
    return ros_module("tf2_msgs.msg").TFMessage([told])


def heard(way: Input, drives: float = 0.1) -> list[tuple[str, Any, int]]:
    """The messages of a greeting: topic, message, when it came [ns]; the robot drives a bit [m]."""
    point = ros_module("geometry_msgs.msg").Point
    person = SimulatedPerson(script("normal"))
    rng = np.random.default_rng(7)
    found, came = [], START
    while not person.finished:
        at = START + round(person.t * 1e9)
        came = max(came + 1, at + int(rng.integers(0, LATE)))
        frame = person.frame()
        way_x = drives * math.sin(person.t)
        found.append(
            (TRANSFORMS, transform("odom", "base_footprint", at, (way_x, 0, 0), (0, 0, 0, 1)), came)
        )
        if way is Input.FACES:
            face = fill_face(messages("kendon_msgs").FaceExtraction(), frame, point)
            face.header.stamp, face.header.frame_id = stamp(at), "base_footprint"
            found.append(("/camera/faces", face, came + 1))
        else:
            for child, turn in (("face_ab", frame.head_rotation), ("gaze_ab", None)):
                parent = "base_footprint" if turn else "face_ab"
                place = frame.head if turn else (0.0, 0.0, 0.0)
                # The gaze frame is an optical one: z ahead, x right (REP-155).
                quaternion = turn or (-0.5, 0.5, -0.5, 0.5)
                found.append(
                    (TRANSFORMS, transform(parent, child, at, place, quaternion), came + 1)
                )
        came += 2
        person.step()
    return found


def told_live(way: Input, path: Path | None, drives: float = 0.1) -> list[Told]:
    """What a node's own parts tell of them, recorded on the way."""
    settings = NodeSettings(part=Part.READING, input=way)
    place = RobotPlace()
    stream = make_stream(place, settings, "/camera/faces")
    part = ReadingPart(stream, Watcher(place, settings.robot_face), settings)
    hearing = Hearing(place, stream, part)
    recorder = record.BagRecorder(path) if path else None
    told: list[Told] = []
    for topic, message, came in heard(way, drives):
        # Between messages the node looks at the time whenever it happens to.
        told += hearing.pass_time(came - 7_000_000)
        at = hearing.arrival(came)
        if recorder:
            recorder.write(topic, record.RawMessage.of(message), at)
        told += hearing.take(topic, message, at)
    if recorder:
        recorder.close()
    return told


def rows(told: list[Told]) -> Any:
    return np.array([
        (one.stamp, *one.moment.belief.probabilities)
        for one in told
        if one.moment.is_new and one.moment.belief
    ])  # fmt: skip


@pytest.mark.parametrize("way", [Input.FACES, Input.HUMANS])
def test_a_recording_replays_bit_by_bit(way: Input, tmp_path: Path) -> None:
    require_ros1()
    path = tmp_path / "hall.bag"
    live = rows(told_live(way, path))
    again = rows(list(record.replay(path)))
    assert len(live) > 40
    assert again.tobytes() == live.tobytes()
    assert {p.name for p in tmp_path.iterdir()} == {"hall.bag"}


@pytest.mark.parametrize("way", [Input.FACES, Input.HUMANS])
def test_a_recording_is_a_source(way: Input, tmp_path: Path) -> None:
    """The whole recording at once is read as it was message by message."""
    require_ros1()
    path = tmp_path / "hall.bag"
    # Frames of ROS4HRI wait for what is missing, while a robot drives on.
    live = rows(told_live(way, path, drives=0.1 if way is Input.FACES else 0.0))
    observations = observe(open_source(str(path)).record())
    found = estimate(observations, load_model())
    shared = min(len(live), len(found.phases)) - 1
    assert shared > 40
    np.testing.assert_allclose(found.probabilities[:shared], live[:shared, 1:], atol=1e-6)


def test_a_recording_has_the_definitions_of_its_messages(tmp_path: Path) -> None:
    require_ros1()
    from rosbags.rosbag1 import Reader

    path = tmp_path / "hall.bag"
    told_live(Input.FACES, path)
    kind = messages("kendon_msgs").FaceExtraction
    with Reader(path) as reader:
        (faces,) = [c for c in reader.connections if c.topic == "/camera/faces"]
        assert (faces.msgtype, faces.digest) == ("kendon_msgs/msg/FaceExtraction", kind._md5sum)
        _, _, raw = next(reader.messages([faces]))
    first = next(message for topic, message, _ in heard(Input.FACES) if topic == "/camera/faces")
    again, sent = kind().deserialize(raw), io.BytesIO()
    first.serialize(sent)
    assert (bytes(raw), again.header.stamp.to_nsec()) == (sent.getvalue(), START)


def test_messages_count_one_after_the_other_though_the_clock_stands_still() -> None:
    place, settings = RobotPlace(), NodeSettings(part=Part.READING)
    stream = make_stream(place, settings, "/faces")
    part = ReadingPart(stream, Watcher(place, settings.robot_face), settings)
    hearing, came = Hearing(place, stream, part), []
    for _ in range(3):
        for _ in range(2):
            came.append(hearing.arrival(START))
            assert not list(hearing.pass_time(came[-1]))
        assert not list(hearing.pass_time(START))  # nothing came for a moment
    assert came == sorted(set(came))
    assert hearing.arrival(START - 10**10) == START - 10**10  # the clock began again


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("hall.mcap", "a recording of ROS 1 ends in .bag"),
        ("old.bag/hall.bag", "cannot be written"),
        ("old.bag", "this recording exists already; name another one"),
    ],
)
def test_a_recording_that_cannot_be_is_refused(name: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "old.bag").touch()
    with pytest.raises(DataError, match=sentence):
        record.BagRecorder(tmp_path / name)


def test_a_recording_without_messages_is_not_kept(tmp_path: Path) -> None:
    recorder = record.BagRecorder(tmp_path / "empty.bag")
    recorder.close()
    recorder.close()
    assert not list(tmp_path.iterdir())

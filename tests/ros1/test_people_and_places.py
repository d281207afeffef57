"""What messages become, without any ROS: faces, people, places, shapes, parts."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.geometry import ORIGIN, Pose2D, yaw_quaternion
from kendon.phases import Phase
from kendon.ros.settings import Input, NodeSettings, Part
from kendon.ros.stream import PersonStream
from kendon.ros.telling import fill_state, phase_of_state
from kendon.simulation import SimulatedPerson, script
from kendon.sources.ros_faces import angles_of, fill_face, frame_of_face, rotation_of
from kendon.sources.ros_people import People
from kendon.sources.ros_place import BASES, RobotPlace

angles = st.floats(-3.1, 3.1)


def point(x: float = 0.0, y: float = 0.0, z: float = 0.0, w: float = 0.0) -> Any:
    return SimpleNamespace(x=x, y=y, z=z, w=w)


def header(frame: str = "base_footprint", stamp: float = 1.0) -> Any:
    nanoseconds = round(stamp * 1e9)
    time = SimpleNamespace(secs=nanoseconds // 10**9, nsecs=nanoseconds % 10**9)
    return SimpleNamespace(frame_id=frame, stamp=time)


def face(frame: str = "base_footprint", stamp: float = 1.0, **fields: Any) -> Any:
    """An empty FaceExtraction, as ROS makes one."""
    empty: dict[str, Any] = {
        "left_eye_gaze": point(), "right_eye_gaze": point(), "face": point(),
        "face_rotation": point(), "left_eye_borders": [point(), point()],
        "right_eye_borders": [point(), point()], "action_units": [0.0, 0.0], "face_id": "",
        "joint_names": [], "joints": [], "gestures_given": False, "dsal": 0.0, "csal": 0.0,
        "hdip": 0.0,
    }  # fmt: skip
    return SimpleNamespace(header=header(frame, stamp), **{**empty, **fields})


@given(angles, st.floats(-1.5, 1.5), angles)
def test_face_rotations_are_about_fixed_axes(roll: float, pitch: float, yaw: float) -> None:
    expected = Rotation.from_euler("xyz", [roll, pitch, yaw])
    got = Rotation.from_quat(rotation_of(roll, pitch, yaw))
    assert (expected.inv() * got).magnitude() < 1e-9
    again = Rotation.from_quat(rotation_of(*angles_of(rotation_of(roll, pitch, yaw))))
    assert (expected.inv() * again).magnitude() < 1e-6


def test_a_person_survives_the_message() -> None:
    person = SimulatedPerson(script("normal"))
    for _ in range(200):
        person.step()
    frame = person.frame()
    message = fill_face(face(), frame, point)
    again = frame_of_face(message, frame.t, ORIGIN, bases=BASES)
    assert again.head == pytest.approx(frame.head)
    np.testing.assert_allclose(
        Rotation.from_quat(again.head_rotation).as_matrix(),
        Rotation.from_quat(frame.head_rotation).as_matrix(),
        atol=1e-9,
    )
    assert again.smile == pytest.approx(frame.smile)
    assert (again.dsal, again.csal, again.hdip) == (frame.dsal, frame.csal, frame.hdip)
    assert again.joints.keys() == frame.joints.keys()
    for joint, place in frame.joints.items():
        assert again.joints[joint] == pytest.approx(place)


def test_what_a_sender_leaves_empty_is_unknown() -> None:
    frame = frame_of_face(face(), 0.0, ORIGIN, bases=BASES)
    assert frame.eyes is None
    assert frame.eye_gaze is None
    assert all(math.isnan(v) for v in (frame.dsal, frame.csal, frame.hdip))


def test_faces_of_another_frame_are_refused() -> None:
    with pytest.raises(DataError, match=r"base_footprint or base_link, not in 'camera'"):
        frame_of_face(face("camera"), 0.0, ORIGIN, bases=BASES)


def people(*places: tuple[float, float, float], frame: str = "map") -> Any:
    turn = point(z=math.sin(math.pi / 2), w=math.cos(math.pi / 2))
    poses = [SimpleNamespace(position=point(*p), orientation=turn) for p in places]
    return SimpleNamespace(header=header(frame), poses=poses)


def test_people_of_the_world_are_seen_from_the_robot() -> None:
    robot = Pose2D(1.0, 2.0, math.pi / 2)
    frame = People(1.6, BASES).frame(people((1.0, 5.0, 0.0)), 0.0, robot, [7])
    assert frame.head == pytest.approx((3.0, 0.0, 1.6))
    ahead = Rotation.from_quat(frame.head_rotation).as_matrix()[:, 0]
    np.testing.assert_allclose(ahead, [0, 1, 0], atol=1e-12)  # -x of the world is their left
    assert frame.who == 7


def test_the_nearest_is_greeted_and_kept_while_nobody_is_clearly_nearer() -> None:
    choice = People(1.6, BASES)
    greeted = [
        choice.frame(people((3.0, 0, 0), (x, 0, 0)), 0.0, ORIGIN, [0, 1]).who
        for x in (5.0, 2.9, 2.6, 2.4, 2.9)
    ]
    assert greeted == [0, 0, 0, 1, 1]
    assert not choice.frame(people(), 0.0, ORIGIN, []).seen


def test_people_of_an_unknown_frame_are_refused() -> None:
    with pytest.raises(DataError, match="not in 'camera'"):
        People(1.6, BASES).frame(people((1, 0, 0), frame="camera"), 0.0, ORIGIN, [0])


def transform(parent: str, child: str, pose: Pose2D, stamp: float) -> Any:
    _, _, z, w = yaw_quaternion(pose.yaw)
    told = SimpleNamespace(translation=point(pose.x, pose.y), rotation=point(z=z, w=w))
    return SimpleNamespace(header=header(parent, stamp), child_frame_id=child, transform=told)


def test_the_robot_is_where_its_frames_put_it() -> None:
    place = RobotPlace()
    still = SimpleNamespace(transforms=[transform("map", "odom", Pose2D(1, 0, math.pi / 2), 0)])
    place.take_transforms(still, static=True)
    for stamp in (1.0, 1.5):
        moved = transform("odom", "base_footprint", Pose2D(2 * stamp, 0, 0), stamp)
        place.take_transforms(SimpleNamespace(transforms=[moved]))
    assert place.world == "map"
    assert place.pose == pytest.approx((1.0, 3.0, math.pi / 2))
    assert place.at(1.25) == pytest.approx((1.0, 2.5, math.pi / 2))  # between the two
    assert place.at(9.0) == place.pose


def test_of_several_faces_the_first_is_followed_until_it_is_gone() -> None:
    stream = PersonStream(RobotPlace(), NodeSettings(), "/faces")
    taken = []
    for i in range(40):
        now = 1.0 + i / 10
        for name in ("a", "b") if i < 20 else ("b",):
            frame = stream.take(face(stamp=now, face_id=name, face=point(2.0, 0, 1.6)), now)
            taken.append((now, name, frame is not None))
    assert {name for now, name, there in taken if there and now < 2.9} == {"a"}
    assert [name for now, name, there in taken if there][-1] == "b"


def test_a_message_that_cannot_be_read_is_told_of_once() -> None:
    stream = PersonStream(RobotPlace(), NodeSettings(), "/faces")
    for i in range(5):
        assert stream.take(face("camera", 1.0 + i), 1.0 + i) is None
    assert stream.refused == 5
    assert len([note for note in stream.notes if "is left out" in note]) == 1


def test_the_state_is_told_as_a_number() -> None:
    text, number = SimpleNamespace(data=""), SimpleNamespace(data=0)
    assert fill_state(text, Phase.APP).data == "4"
    assert fill_state(number, Phase.APP).data == 4
    assert phase_of_state(text) is phase_of_state(number) is Phase.APP
    with pytest.raises(UnknownNameError, match="valid: IA, DS"):
        phase_of_state(SimpleNamespace(data="7"))


def test_settings_take_texts_and_parameters() -> None:
    settings = NodeSettings().with_values(
        {"part": "reading", "input": "people", "robot_face": [0, 0, 1.3], "markers": "false"}
    )
    assert (settings.part, settings.input, settings.markers) == (
        Part.READING, Input.PEOPLE, False,
    )  # fmt: skip
    assert settings.robot_face == (0.0, 0.0, 1.3)


@pytest.mark.parametrize(
    ("values", "error", "sentence"),
    [
        ({"part": "all"}, UnknownNameError, "valid: both, reading, answering"),
        ({"speed": 1}, UnknownNameError, "there is no parameter 'speed'"),
        ({"patience": 0}, ParameterError, "positive number of seconds"),
        ({"face_height": "tall"}, ParameterError, "face_height is a number, not 'tall'"),
        ({"markers": "maybe"}, ParameterError, "true or false"),
    ],
)
def test_settings_refuse_mistakes(
    values: dict[str, Any], error: type[Exception], sentence: str
) -> None:
    with pytest.raises(error, match=sentence):
        NodeSettings().with_values(values)

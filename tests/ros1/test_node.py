"""The node as a user runs it: a process, a master, faces in, the state out, the robot stopped."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import groupby
from pathlib import Path
from typing import Any
from xmlrpc.client import ServerProxy

import numpy as np
import pytest
from ros1.human_topics import HumanTopics
from ros1.ros1_world import Master, require_ros1, tells, wait_for

from kendon.greeter import Encounter, Greeter
from kendon.phases import Phase
from kendon.ros.ros1.environment import messages, ros_module
from kendon.simulation import SimulatedPerson, script
from kendon.sources import open_source
from kendon.sources.ros_bags import read_messages
from kendon.sources.ros_faces import fill_face

CLI = "from kendon.cli import main; main()"


class Ends:
    """This process's ends of the node's topics."""

    def __init__(self) -> None:
        rospy, self.kendon = ros_module("rospy"), messages("kendon_msgs")
        standard = ros_module("std_msgs.msg")
        self.rospy = rospy
        self.point = ros_module("geometry_msgs.msg").Point
        self.faces = rospy.Publisher("/faces", self.kendon.FaceExtraction, queue_size=50)
        self.states: list[str] = []
        self.beliefs: list[Any] = []
        self.observations: list[Any] = []
        self.ends = [
            rospy.Subscriber("/state", standard.String, lambda m: self.states.append(m.data)),
            rospy.Subscriber("/belief", self.kendon.Belief, self.beliefs.append),
            rospy.Subscriber("/observation", self.kendon.Observation, self.observations.append),
        ]

    def connected(self) -> bool:
        return self.faces.get_num_connections() > 0 and all(
            tells("/kendon", end.resolved_name) for end in self.ends
        )

    def close(self) -> None:
        for end in (self.faces, *self.ends):
            end.unregister()

    def send(self, person: SimulatedPerson, start: float) -> None:
        message = fill_face(self.kendon.FaceExtraction(), person.frame(), self.point)
        message.header.stamp = self.rospy.Time.from_sec(start + person.t)
        message.header.frame_id = "base_footprint"
        self.faces.publish(message)


@pytest.fixture
def ends(master: Master) -> Iterator[Ends]:
    del master
    ends = Ends()
    yield ends
    ends.close()


@contextmanager
def node(master: Master, *options: str) -> Iterator[subprocess.Popen[str]]:
    with master.running("-c", CLI, "ros1", *options) as process:
        yield process


def play(ends: Ends, name: str, pace: float = 0.002) -> None:
    """Send a simulated greeting faster than it was, at its own stamps."""
    person = SimulatedPerson(script(name))
    start = ends.rospy.get_time()
    while not person.finished:
        ends.send(person, start)
        person.step()
        threading.Event().wait(pace)


@pytest.fixture
def standing_clock(master: Master) -> Iterator[None]:
    """Simulated time that stands still: for a node, no time passes between messages.

    By the wall's clock, a sender that a busy machine holds up leaves a hole in what is seen.
    """
    del master
    rospy = ros_module("rospy")
    kind = ros_module("rosgraph_msgs.msg").Clock
    clock = rospy.Publisher("/clock", kind, queue_size=1, latch=True)
    clock.publish(kind(rospy.Time.now()))
    rospy.set_param("/use_sim_time", True)  # counts for nodes that start now
    yield
    rospy.delete_param("/use_sim_time")
    clock.unregister()


@pytest.mark.usefixtures("standing_clock")
def test_a_greeting_over_topics_is_read_as_in_one_process(master: Master, ends: Ends) -> None:
    expected = Encounter()
    with node(master, "--part", "reading"):
        wait_for(ends.connected, "the node", 60)
        play(ends, "normal")
        source = open_source("simulated:normal")
        source.reacts = False  # type: ignore[misc]
        for moment in Greeter(source).run():
            expected.add(moment)
        wait_for(lambda: len(ends.beliefs) >= len(expected.probabilities) - 1, "all beliefs", 30)
    got = np.array([b.probabilities for b in ends.beliefs])
    count = len(expected.probabilities) - 1
    np.testing.assert_allclose(got[:count], expected.probabilities[:count], atol=1e-6)
    assert [b.phase for b in ends.beliefs] == [int(s) for s in ends.states]
    shown = [Phase.parse(s) for s, _ in groupby(ends.states)]
    assert shown == expected.phases
    assert ends.beliefs[0].header.frame_id == "base_footprint"
    spacing = np.diff([b.header.stamp.to_sec() for b in ends.beliefs])
    np.testing.assert_allclose(spacing, 0.2, atol=1e-3)
    assert ends.observations[0].distance == pytest.approx(expected.observations.values[0, 0])


def interrupt(process: subprocess.Popen[str]) -> None:
    process.send_signal(signal.SIGINT)


def kill_by_name(process: subprocess.Popen[str]) -> None:
    """As `rosnode kill` does, and the master where another node takes the name."""
    del process
    node: Any = ServerProxy(ros_module("rosgraph").Master("/kendon_tests").lookupNode("/kendon"))
    with suppress(OSError):  # it may end before it has answered, as rosnode knows
        node.shutdown("/kendon_tests", "the test ends it")


@pytest.mark.parametrize("end", [interrupt, kill_by_name])
def test_the_robot_is_stopped_when_the_node_ends(
    master: Master, ends: Ends, end: Callable[[subprocess.Popen[str]], None]
) -> None:
    cancelled: list[Any] = []
    identity = ros_module("actionlib_msgs.msg").GoalID
    rospy = ros_module("rospy")
    with master.servers():
        listening = rospy.Subscriber("/move_base/cancel", identity, cancelled.append)
        with node(master) as process:
            wait_for(ends.connected, "the node", 60)
            wait_for(lambda: tells("/kendon", "/move_base/cancel"), "the robot's client")
            person = SimulatedPerson(script("normal"))
            start = rospy.get_time()
            for _ in range(60):
                ends.send(person, start)
                person.step()
                threading.Event().wait(0.01)
            wait_for(lambda: ends.states, "a state")
            end(process)
            assert process.wait(60) == 0
        wait_for(lambda: any(not c.id for c in cancelled), "the cancellation of all goals")
        listening.unregister()


TELLER = """
from kendon.ros.ros1.connection import flush, start_node
from kendon.ros.ros1.environment import ros_module
import sys, time
start_node("teller")
rospy, standard = ros_module("rospy"), ros_module("std_msgs.msg")
topic = rospy.Publisher("/numbers", standard.Int16, queue_size=0)
while topic.get_num_connections() == 0:
    time.sleep(0.01)
for number in range(3000):
    topic.publish(number)
print(flush(float(sys.argv[1])))
rospy.signal_shutdown("all is told")
"""


def test_what_is_flushed_arrives_though_the_node_ends_at_once(master: Master) -> None:
    heard: list[int] = []
    rospy = ros_module("rospy")
    listening = rospy.Subscriber(
        "/numbers", ros_module("std_msgs.msg").Int16, lambda m: heard.append(m.data)
    )
    with master.running("-c", TELLER, "60") as process:
        assert process.stdout is not None
        assert process.stdout.read() == "[]\n"
        wait_for(lambda: len(heard) == 3000, "all numbers")
    listening.unregister()
    assert heard == list(range(3000))


BUSY = """
from kendon.ros.ros1.connection import start_node
from kendon.ros.ros1.node import GreetingNode
from kendon.ros.settings import NodeSettings, Part
from kendon.ros.watching import Watcher
from kendon.sources.ros_place import RobotPlace
import threading, time
start_node("busy")
place, settings = RobotPlace(), NodeSettings(part=Part.READING)
node = GreetingNode(Watcher(place, settings.robot_face), place, settings)
while not node.lost:
    time.sleep(0.01)
threading.Thread(target=lambda: list(node.run()), daemon=True).start()
while place.pose.x != 7.0:  # by way of both
    time.sleep(0.01)
"""


def transform(parent: str, child: str, x: float) -> Any:
    """A message of /tf, of now."""
    told = ros_module("geometry_msgs.msg").TransformStamped()
    told.header.stamp = ros_module("rospy").Time.now()
    told.header.frame_id, told.child_frame_id = parent, child
    told.transform.translation.x, told.transform.rotation.w = x, 1.0
    return ros_module("tf2_msgs.msg").TFMessage([told])


def test_static_transforms_are_not_lost_while_the_node_is_busy(master: Master) -> None:
    rospy, kind = ros_module("rospy"), ros_module("tf2_msgs.msg").TFMessage
    static = rospy.Publisher("/tf_static", kind, queue_size=1, latch=True)
    moving = rospy.Publisher("/tf", kind, queue_size=100)
    static.publish(transform("map", "odom", 5.0))
    with master.running("-c", BUSY) as process:
        wait_for(lambda: static.get_num_connections() and moving.get_num_connections(), "its ears")

        def placed() -> bool:
            for _ in range(20):
                moving.publish(transform("odom", "base_footprint", 2.0))
            return process.poll() is not None

        wait_for(placed, "where the robot is in the map")
        assert process.returncode == 0
    for end in (static, moving):
        end.unregister()


def test_definitions_that_cannot_be_read_are_told_in_one_sentence(master: Master) -> None:
    pytest.importorskip("rosbags")

    class Odd(ros_module("genpy").Message):  # type: ignore[misc]
        _type, _md5sum, _full_text = "hri_msgs/IdsList", "0" * 32, "what is this?"
        _has_header = False
        __slots__ = ("data",)
        _slot_types = ("string",)

        def serialize(self, buffer: Any) -> None:
            buffer.write(b"odd")

    faces = ros_module("rospy").Publisher("/humans/faces/tracked", Odd, queue_size=5)
    with node(master, "--part", "reading", "--input", "humans") as process:
        wait_for(faces.get_num_connections, "its ears")
        for _ in range(3):
            faces.publish(Odd(""))
        assert process.stdout is not None
        said = ""
        while "do not fit" not in said:
            said = process.stdout.readline()
            assert said
            assert "Traceback" not in said
        process.send_signal(signal.SIGINT)
        rest = process.stdout.read()
    faces.unregister()
    assert "Messages of /humans/faces/tracked do not fit the definition of hri_msgs/" in said
    assert "Traceback" not in rest
    assert "do not fit" not in rest


def test_mistakes_are_one_sentence(master: Master) -> None:
    require_ros1()
    environment = master.child_environment()
    cases = {
        ("--model", "nobody", "__name:=unknown"): "there is no model 'nobody'",
        ("_patience:=-1", "__name:=impatient"): "patience is a positive number of seconds",
        ("_modle:=kendon",): "there is no parameter of the node 'modle'; valid: part, input,",
        ("faces",): "'faces' is neither an option nor a remapping",
        ("--robot-face", "1,2"): "robot_face is X,Y,Z in metres, not '1,2'",
        (
            "faces:=/rosout",
            "__name:=deaf",
        ): "/rosout: it carries rosgraph_msgs/Log, not kendon_msgs/FaceExtr",
    }
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", CLI, "ros1", *options],
            env=environment, text=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        )
        for options in cases
    ]  # fmt: skip
    for run, sentence in zip(runs, cases.values(), strict=True):
        _, said = run.communicate(timeout=120)
        assert run.returncode == 2, said
        assert sentence in said
        assert "Traceback" not in said


def test_without_a_master_it_says_how_to_start_one(master: Master) -> None:
    environment = {**master.child_environment(), "ROS_MASTER_URI": "http://127.0.0.1:1"}
    run = subprocess.run(
        [sys.executable, "-c", CLI, "ros1"],
        env=environment, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert run.returncode == 2
    assert run.stderr == (
        "kendon: no ROS 1 master answers at http://127.0.0.1:1 (ROS_MASTER_URI); start one with"
        " `roscore`, or on Debian with `rosmaster --core`\n"
    )


def test_people_of_ros4hri_are_read_recorded_and_read_again(
    master: Master, ends: Ends, tmp_path: Path
) -> None:
    pytest.importorskip("rosbags")
    from kendon.ros.ros1.record import replay

    rospy, path = ros_module("rospy"), tmp_path / "hall.bag"
    topics = HumanTopics("/camera/tf")
    options = ("--part", "reading", "--input", "humans", "--record", str(path))
    with node(master, *options, "/tf:=/camera/tf") as process:
        wait_for(lambda: all(tells("/kendon", t) for t in ("/belief", "/state")), "the node", 60)
        wait_for(topics.connected, "its ears")
        person = SimulatedPerson(script("short"))
        start = rospy.get_time()
        while not person.finished:
            topics.tell(person.frame(), rospy.Time.from_sec(start + person.t))
            person.step()
            threading.Event().wait(1 / person.rate)  # as a camera would: both topics keep step
        wait_for(lambda: len(ends.beliefs) >= 5 * (person.t - 1), "its beliefs")
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 0
        assert process.stdout is not None
        assert "All that was heard and told is in" in process.stdout.read()
    topics.close()
    told = [one.moment.belief for one in replay(path) if one.moment.is_new]
    assert [b.probabilities.tolist() for b in told if b] == [
        list(b.probabilities) for b in ends.beliefs
    ]
    assert max(o.smile for o in ends.observations) == pytest.approx(2.0, abs=0.1)
    assert "/tf" in {topic for topic, _, _ in read_messages(path, lambda _: True)}

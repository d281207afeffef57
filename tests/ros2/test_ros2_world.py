"""The node before a world that comes and goes, in the world's own time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from bag_files import Transform, write_bag
from ros2.wire import STEP, Wire, World
from ros2_peers import DRIVING_TREE

from kendon.geometry import Pose2D
from kendon.models import load_model
from kendon.robots.base import CommandStatus
from kendon.ros.ros2_node import Ros2Node
from kendon.ros.ros2_reading import Engagement
from kendon.ros.ros2_robot import Ros2Robot
from kendon.ros.ros2_settings import Drive, Ros2Settings
from kendon.ros.ros2_types import FACE, STRING
from kendon.sources.live_people import PATIENCE
from kendon.sources.ros_bags import read_messages
from kendon.trees import GreetingTree

SECOND = 10**9


class Life:
    """A node in a world, with a robot that drives on and on while there is a phase."""

    def __init__(self, tree: Path) -> None:
        self.world = World()
        wire = self.world.wire
        self.node = Ros2Node(wire, load_model(), clock=wire.clock)
        self.robot = Ros2Robot(wire, self.node.place, Ros2Settings(Drive.CMD_VEL), clock=wire.clock)
        self.node.greet_with(self.robot, GreetingTree(tree))
        self.steps = self.node.run()

    def until(self, condition: Callable[[], Any], limit: float = 20.0) -> None:
        """Live on until something is so, at most for so long [s]."""
        end = self.world.wire.now + limit * SECOND
        while not condition():
            assert self.world.wire.now < end, [str(c) for c in self.robot.log]
            next(self.steps)

    def drives(self) -> bool:
        return self.world.speed > 0.1

    def stands(self) -> bool:
        return self.world.speed == 0.0

    def levels(self) -> list[int]:
        topic = "/humans/persons/anonymous_person_7/engagement_status"
        return [message.level for message in self.world.wire.heard(topic)]


@pytest.fixture
def life(tmp_path: Path) -> Iterator[Life]:
    tree = tmp_path / "tree.xml"
    tree.write_text(DRIVING_TREE)
    life = Life(tree)
    yield life
    life.steps.close()
    assert life.world.wire.closed


def test_the_base_stops_when_the_person_is_lost_and_they_are_told_of_as_gone(life: Life) -> None:
    life.until(life.drives)
    life.world.person = False
    life.until(life.stands, limit=8.0)
    life.until(lambda: life.levels()[-1] == Engagement.UNKNOWN)
    assert life.node.reader.followed is None
    life.world.person = True
    life.until(life.drives)
    assert life.node.late == 0


def test_a_base_that_vanishes_ends_in_a_stated_failure_and_is_driven_when_it_is_back(
    life: Life,
) -> None:
    life.until(life.drives)
    life.world.base = False
    life.world.wire.renamed = {"/cmd_vel"}
    life.until(life.stands, limit=1.0)  # it does not drive blind
    why = "nobody has read /renamed/cmd_vel for"
    life.until(lambda: any(c.reason.startswith(why) for c in life.robot.log))
    life.world.base = True
    life.until(life.drives)


def test_the_log_of_a_robot_that_is_up_for_long_does_not_grow(life: Life) -> None:
    life.until(life.drives)
    for _ in range(300):
        life.robot.look_at((1.0, 0.0, 1.0))
        next(life.steps)
    assert len(life.robot.log) <= 110


def walk(person: str, seconds: float) -> list[tuple[int, str, Any]]:
    """What a camera tells of somebody: when [ns], topic, and the message's fields."""
    told = []
    for i in range(round(seconds * 30)):
        t = i * SECOND // 30
        face = {"face": {"x": 4.0 - i / 60, "z": 1.6}, "face_rotation": {"z": np.pi}}
        told.append((t, "/faces", {"face_id": person, **face}))
    return told


def beliefs_of(sleeps: dict[int, float], patience: float = PATIENCE) -> tuple[list[Any], Ros2Node]:
    """The beliefs about somebody who walks up, to a process that is not run now and then.

    Args:
        sleeps: after which of its steps it sleeps, and for how long [s].
        patience: how late messages may be [s].
    """
    wire = Wire()
    node = Ros2Node(wire, load_model(), patience=patience, clock=wire.clock)
    steps = node.run()
    begin = wire.now
    script = walk("1", 6.0)

    def world(now: int) -> None:
        while script and begin + script[0][0] <= now:
            at, topic, fields = script.pop(0)
            before, wire.now = wire.now, begin + at
            header = {"stamp": {"sec": wire.now // SECOND, "nanosec": wire.now % SECOND}}
            wire.tell(topic, FACE, {**fields, "header": {**header, "frame_id": "base_footprint"}})
            wire.now = before

    wire.world = world
    for number in range(59):
        next(steps)
        end = wire.now + round(sleeps.get(number, 0.0) * SECOND)
        while wire.now < end:  # the world lives on, and what it tells waits
            wire.now += STEP
            world(wire.now)
    found = wire.heard("/kendon/anonymous_person_1/belief")
    return [message.probabilities.tolist() for message in found], node


def test_what_waited_while_the_computer_was_busy_is_not_late() -> None:
    expected, _ = beliefs_of({})
    beliefs, node = beliefs_of({10: 0.45, 20: 1.3, 30: 0.7})
    assert len(expected) > 20
    assert beliefs[: len(expected)] == expected[: len(beliefs)]
    assert len(beliefs) >= len(expected)
    assert node.late == 0


def test_frames_that_came_too_late_are_left_out_counted_and_said() -> None:
    wire = Wire()
    node = Ros2Node(wire, load_model(), clock=wire.clock)
    steps = node.run()
    begin = wire.now

    def tell(t: float, sent: float) -> None:
        wire.now = begin + round(sent * SECOND)
        place = {"face": {"x": 3.0, "z": 1.6}, "face_rotation": {"z": np.pi}}
        stamped = begin + round(t * SECOND)
        header = {"stamp": {"sec": stamped // SECOND, "nanosec": stamped % SECOND}}
        wire.tell("/faces", FACE, {"header": header, **place})

    tell(0.0, 0.0)
    next(steps)
    for i in range(1, 30):
        tell(i / 30, i / 30)
        next(steps)
    while wire.now < begin + 2 * SECOND:
        next(steps)
    tell(1.0, 2.1)  # its interval was told long ago
    next(steps)
    tell(2.2, 2.2)
    next(steps)
    assert node.late == 1
    assert any("s late, and are left out (--lateness waits longer)" in n for n in node.notes)


def test_topics_of_another_type_are_not_read_and_that_is_said() -> None:
    wire = Wire()
    wire.tell("/faces", STRING, {"data": "?"})
    node = Ros2Node(wire, load_model(), clock=wire.clock)
    next(node.run())
    sentence = "/faces is published as std_msgs/msg/String, not as kendon_msgs/msg/FaceExtraction."
    assert sentence in node.notes


def test_people_who_come_and_go_leave_nothing_behind(tmp_path: Path) -> None:
    told = []
    turn = (0.5, 0.5, -0.5, 0.5)
    for number in range(12):
        for i in range(60):
            t = 8 * number + i / 30
            place = (0.1, -0.4, 4.0 - 0.015 * i)
            told.append(Transform(t, "camera_optical_frame", f"face_f{number}", place, turn))
            told.append(Transform(t, f"face_f{number}", f"gaze_f{number}", rotation=turn))
    script = list(read_messages(write_bag(tmp_path, "mcap", told), lambda _: True))
    node = Ros2Node(Wire(), load_model())
    sizes = []
    for topic, received, message in script:
        node.reader.hear(topic, message, received)
        sizes.append((len(node.reader.people.log.transforms.frames), len(node.reader._readings)))
    assert max(sizes) <= (6, 2)


def test_a_goal_that_is_followed_up_is_told_once_and_a_refused_one_ends_the_drive() -> None:
    world = World()
    node = Ros2Node(world.wire, load_model(), clock=world.wire.clock)
    robot = Ros2Robot(world.wire, node.place, Ros2Settings(), clock=world.wire.clock)
    steps = node.run()
    for _ in range(5):
        next(steps)
    robot.update(0.1)
    for x in (2.0, 2.5):
        assert robot.go_to(Pose2D(x, 0.0, 0.0)).running
    assert robot.turn_to(1.0).running
    far = robot.go_to(Pose2D(1e6, 0.0, 0.0))
    assert far.status is CommandStatus.FAILED
    goals = [message.pose for message in world.wire.heard("/goal_pose")]
    # The last is where the base is: nobody wants the drive before any more.
    assert [goal.position.x for goal in goals] == [2.0, 2.5, 0.0, 0.0]
    assert goals[2].orientation.z > 0.4
    assert goals[3].orientation.z == 0.0
    robot.go_to(Pose2D(2.0, 0.0, 0.0))
    robot.stop()
    assert [m.pose.position.x for m in world.wire.heard("/goal_pose")][4:] == [2.0, 0.0, 0.0]
    steps.close()

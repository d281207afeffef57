"""The closed loop over ROS 2's topics: a person, a robot's look-alike and kendon, three processes.

    PYTHONPATH=src:tests python benchmarks/ros2_encounters.py [--encounters 50]

A simulated person greets, in real time, a base like Nav2's that `kendon ros2` drives with the
default tree. Each encounter is held against the same one in a single process: the phases that were
read; what the robot said, performed and showed, in its order; where it was sent, and where it was
to look. Drives and looks are sent again as the person moves, ten times a second: each one, in both
directions, must have one of the other that holds at nearly the same time and place. Every
difference is listed. Printed are also how long after the face message that ends an interval its
belief comes to the person's process, and what was lost.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from functools import partial
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from ros2_peers import CLOCK, LOOPBACK, ODOMETRY, free_domain, peer, reached, until

from kendon.features.sampler import PERIOD
from kendon.geometry import ORIGIN, Pose2D, quaternion_yaw, wrap_angle
from kendon.greeter import FORGOTTEN, Encounter, Greeter
from kendon.robots.base import CommandKind
from kendon.ros.dds import DdsNode
from kendon.ros.ros2_robot import POINT, POSE
from kendon.ros.ros2_settings import Ros2Settings
from kendon.ros.ros2_transport import Offer
from kendon.ros.ros2_types import (
    BELIEF,
    FACE,
    STRING,
    build,
    header_fields,
    stamp_fields,
    type_store,
)
from kendon.simulation import SCRIPTS, SimulatedPerson, script
from kendon.sources import open_source
from kendon.sources.ros_bags import read_messages
from kendon.sources.ros_faces import fill_face
from kendon.sources.ros_stamps import nanoseconds

_NANO = 10**9
#: Commands whose order tells what the robot answered.
ANSWERS = {
    CommandKind.GESTURE: "/gesture",
    CommandKind.SAY: "/say",
    CommandKind.EXPRESS: "/expression",
}
GOAL, LOOK = "/goal_pose", "/look_at"
#: Drives and looks are the same so near to each other in time [s]: a base over ROS 2 has arrived
#: when it has stood for 0.3 s, and a tick is 0.1 s.
NEAR_TIME = 0.4
#: And within the tolerances that Nav2 reaches goals with [m], [rad]: the person answers to where
#: the robot is, and the robot to where the person is.
NEAR_PLACE, NEAR_YAW = Ros2Settings().position_tolerance, Ros2Settings().yaw_tolerance
#: A goal so near to where the base is, in metres and radians, tells it to stand. It is where the
#: base happens to be.
STANDS = 0.1


class Aim(NamedTuple):
    """Where the base or the head was sent, as seen from where the robot stood at the start."""

    t: float  # [s], since the first frame
    place: tuple[float, ...]  # x, y of a base; x, y, z of a look [m]
    yaw: float = 0.0  # [rad]

    def __str__(self) -> str:
        place = ", ".join(f"{value:.2f}" for value in (*self.place, self.yaw))
        return f"({place}) at {self.t:.2f} s"

    def off(self, other: Aim) -> float:
        """How far it is from another one [m]."""
        return math.dist(self.place, other.place)

    def near(self, other: Aim) -> bool:
        """Whether both are the same."""
        turned = abs(wrap_angle(self.yaw - other.yaw))
        return self.off(other) <= NEAR_PLACE and turned <= NEAR_YAW

    def stands(self, base: Pose2D) -> bool:
        """Whether it only tells a base to stand."""
        turned = abs(wrap_angle(self.yaw - base.yaw))
        return math.dist(self.place, base[:2]) <= STANDS and turned <= STANDS


class Course(NamedTuple):
    """What is held against each other of an encounter."""

    phases: list[int]
    answers: list[str]
    drives: list[Aim]
    looks: list[Aim]
    end: Pose2D  # of the robot
    seconds: float  # that it took


class Stage:
    """Where the person is: tells of their face, hears beliefs, commands and the robot's pose."""

    def __init__(self, domain: int) -> None:
        self.node = DdsNode(domain)
        self.pose = ORIGIN
        self.sent: list[tuple[int, int]] = []  # [ns], the faces' stamps, and when they were sent
        self.count = 0  # of faces
        self.delays: list[float] = []  # [s]
        self.stamps: list[int] = []  # of the beliefs [ns]
        self.phases: list[int] = []
        self.answers: list[str] = []
        self.drives: list[Aim] = []
        self.looks: list[Aim] = []
        self._person = ""
        self._home, self._begin = ORIGIN, 0  # where the robot stood, and when [ns]
        for topic, kind in (("/clock", CLOCK), ("/faces", FACE)):
            self.node.advertise(topic, kind)
        self._read("/odom", ODOMETRY, self._take_pose)
        for topic in ANSWERS.values():
            self._read(topic, STRING, partial(self._take_answer, topic))
        self._read(GOAL, POSE, self._take_goal)
        self._read(LOOK, POINT, self._take_look)

    def play(self, name: str, number: int) -> Course:
        """Somebody plays a script, in real time, and rests; what came of it."""
        for old in (self.phases, self.answers, self.sent, self.stamps, self.drives, self.looks):
            old.clear()
        person = SimulatedPerson(script(name))
        home, begin = self._home, self._begin = self.pose, time.time_ns()
        self._person = str(number)
        self._follow()
        while not person.finished:
            due = begin + round(person.t * _NANO)
            self._wait(due)
            self._tell(person, due, home)
            person.step(in_frame_of(home, self.pose))
        end = in_frame_of(home, self.pose)
        self.rest(0.5)
        phases = [phase for phase, _ in groupby(self.phases)]
        return Course(
            phases, list(self.answers), list(self.drives), list(self.looks), end, person.t
        )

    def rest(self, seconds: float) -> None:
        """Nobody is there."""
        for _ in range(round(20 * seconds)):
            now = time.time_ns()
            self.node.publish("/clock", CLOCK, {"clock": stamp_fields(now)})
            self._wait(now + _NANO // 20)

    def _wait(self, due: int) -> None:
        while (left := due - time.time_ns()) > 0:
            self.node.spin(left / _NANO)
        self.node.spin(0.0)

    def _tell(self, person: SimulatedPerson, now: int, home: Pose2D) -> None:
        self.node.publish("/clock", CLOCK, {"clock": stamp_fields(now)})
        frame = person.frame(in_frame_of(home, self.pose))
        message = build(FACE, {"header": header_fields(now, "base_footprint")})
        face = fill_face(message, frame, point)
        face.action_units = np.array(face.action_units)
        face.face_id = self._person  # somebody else each time
        raw = bytes(type_store().serialize_cdr(face, FACE))
        self.sent.append((now, time.time_ns()))
        self.count += 1
        self.node.publish_raw("/faces", FACE, raw)

    def _follow(self) -> None:
        topic = f"/kendon/anonymous_person_{self._person}/belief"
        self._read(topic, BELIEF, self._take_belief)

    def _read(self, topic: str, kind: str, callback: Any) -> None:
        self.node.subscribe(topic, Offer(kind, True, False), callback)

    def _take_belief(self, raw: bytes, message: Any, sent: int) -> None:
        now, told = time.time_ns(), nanoseconds(message.header.stamp)
        ended = next((sent for stamp, sent in self.sent if stamp > told + _NANO // 1000), None)
        if ended is not None:  # not by time alone, as those after the person has gone
            self.delays.append((now - ended) / _NANO)
        self.stamps.append(told)
        self.phases.append(message.phase)

    def _take_answer(self, topic: str, raw: bytes, message: Any, sent: int) -> None:
        self.answers.append(f"{topic[1:]} {message.data}")

    def _take_goal(self, raw: bytes, message: Any, sent: int) -> None:
        goal = in_frame_of(self._home, pose_of(message.pose))
        drive = Aim(self._now(), goal[:2], goal.yaw)
        if not drive.stands(in_frame_of(self._home, self.pose)):
            self.drives.append(drive)

    def _take_look(self, raw: bytes, message: Any, sent: int) -> None:
        point = message.point
        self.looks.append(Aim(self._now(), self._home.to_local((point.x, point.y, point.z))))

    def _now(self) -> float:
        return (time.time_ns() - self._begin) / _NANO

    def _take_pose(self, raw: bytes, message: Any, sent: int) -> None:
        self.pose = pose_of(message.pose.pose)


def pose_of(message: Any) -> Pose2D:
    p, q = message.position, message.orientation
    return Pose2D(p.x, p.y, quaternion_yaw((q.x, q.y, q.z, q.w)))


def point(x: float, y: float, z: float) -> Any:
    return build("geometry_msgs/msg/Point", {"x": x, "y": y, "z": z})


def in_frame_of(home: Pose2D, pose: Pose2D) -> Pose2D:
    """A pose of the world, as seen from where the robot stood when the person came."""
    x, y, _ = home.to_local((pose.x, pose.y, 0.0))
    return Pose2D(x, y, wrap_angle(pose.yaw - home.yaw))


def in_one_process(name: str) -> Course:
    """The same person before the robot with ideal kinematics."""
    encounter = Encounter(name)
    for moment in Greeter(open_source(f"simulated:{name}")).run():
        encounter.add(moment)
    places = [(moment.t, moment.robot) for moment in encounter.moments]
    answers, drives, looks = [], [], []
    for action in encounter.actions:
        command, asked = action.command, action.command.asked
        here = place_at(places, command.issued)
        match command.kind:
            case CommandKind.EXPRESS:
                answers.append(f"expression {asked['expression']} {asked['intensity']:g}")
            case CommandKind.GESTURE | CommandKind.SAY:
                topic = ANSWERS[command.kind][1:]
                answers.append(f"{topic} {asked.get('name') or asked['text']}")
            case CommandKind.LOOK_AT:
                looks.append(Aim(command.issued, asked["point"]))
            case CommandKind.GO_TO:
                goal = command.sent["goal"]
                drives.append(Aim(command.issued, goal[:2], goal.yaw))
            case CommandKind.TURN_TO:
                drives.append(Aim(command.issued, here[:2], asked["yaw"]))
    drives = [drive for drive in drives if not drive.stands(place_at(places, drive.t))]
    phases = [phase.value for phase in encounter.phases]
    return Course(phases, answers, drives, looks, places[-1][1], places[-1][0])


def place_at(places: list[tuple[float, Pose2D]], t: float) -> Pose2D:
    """Where the robot was at a time [s]."""
    return next((pose for when, pose in places if when >= t), places[-1][1])


class Figures:
    """What all encounters come to."""

    def __init__(self) -> None:
        self.count = self.phases = self.answers = self.drives = self.looks = 0
        self.told = self.missing = 0  # beliefs
        self.off: dict[str, list[float]] = {"drives": [], "looks": []}  # [m], from one process
        self.apart: list[float] = []  # [s], after one process, of drives and looks
        self.ends: list[float] = []  # [m], between the places the robot ended in

    def compare(self, title: str, over: Course, inside: Course) -> None:
        """Add an encounter, and list how it differs from that of one process."""
        self.count += 1
        self.phases += over.phases == inside.phases
        self.answers += over.answers == inside.answers
        for what in ("phases", "answers"):
            one, two = getattr(over, what), getattr(inside, what)
            if one != two:
                print(f"{title}: {what} {one}, in one process {two}")
        self.drives += self._aims(f"{title}: drive", "drives", over, inside)
        self.looks += self._aims(f"{title}: look", "looks", over, inside)
        self.ends.append(math.dist(over.end[:2], inside.end[:2]))

    def _aims(self, title: str, what: str, over: Course, inside: Course) -> bool:
        """Whether each drive, or look, has its like in the other encounter."""
        same = True
        for mine, others, where in (
            (getattr(over, what), getattr(inside, what), "over ROS 2, not in one process"),
            (getattr(inside, what), getattr(over, what), "in one process, not over ROS 2"),
        ):
            lonely = []
            for aim in mine:
                if aim.t > inside.seconds - NEAR_TIME:
                    continue  # its like may lie after the end
                before = [other for other in others if other.t < aim.t - NEAR_TIME]
                near = [other for other in others if abs(other.t - aim.t) <= NEAR_TIME]
                # The last one before that time holds still.
                like = [other for other in (*before[-1:], *near) if aim.near(other)]
                if not like:
                    lonely.append(aim)
                elif mine is getattr(over, what):
                    best = min(like, key=aim.off)
                    self.off[what].append(aim.off(best))
                    self.apart.append(aim.t - best.t)
            if lonely:
                same = False
                listed = ", ".join(map(str, lonely[:3]))
                print(f"{title} {where}: {len(lonely)} of {len(mine)}: {listed}")
        return same

    def print(self, delays: list[float]) -> None:
        """Print them."""
        late = 1000 * np.array(delays)
        print(
            f"  {self.phases} of {self.count} with the phases of one process, {self.answers} with"
            f" its answers, {self.drives} with its drives, {self.looks} with its looks"
        )
        for what, off in self.off.items():
            far = 100 * np.array(off)
            print(
                f"  {len(off)} {what} off those of one process: median {np.median(far):.1f} cm,"
                f" at most {far.max():.1f} cm"
            )
        apart = 1000 * np.array(self.apart)
        print(f"  after those of one process: median {np.median(apart):.0f} ms")
        print(f"  the robot ends at most {100 * max(self.ends):.1f} cm from where it does in one")
        print(f"  beliefs told {self.told}, missing between them {self.missing}")
        print(
            f"  belief after face: median {np.median(late):.1f} ms, 95 % below"
            f" {np.quantile(late, 0.95):.1f} ms, at most {late.max():.0f} ms",
            flush=True,
        )


def measure(encounters: int) -> None:
    domain = free_domain()
    names = list(SCRIPTS)
    expected = {name: in_one_process(name) for name in names}
    figures = Figures()
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        said = stack.enter_context(tempfile.TemporaryFile("w+"))
        recording = folder / "all.mcap"
        command = "from kendon.cli import main; main()"
        options = ["--domain", str(domain), "--robot", "goal_pose", "--record", str(recording)]
        stack.enter_context(peer("robot", str(domain)))
        kendon = subprocess.Popen(
            [sys.executable, "-c", command, "ros2", *options],
            stdout=subprocess.DEVNULL, stderr=said, start_new_session=True,
        )  # fmt: skip
        stack.callback(kendon.kill)
        stage = Stage(domain)
        until(stage.node, lambda: all(reached(stage.node, t) for t in ("/clock", "/faces")))
        stage.rest(2.0)
        for number in range(encounters):
            name = names[number % len(names)]
            figures.compare(f"{number} {name}", stage.play(name, number), expected[name])
            ends = [stage.sent[0][0], *stage.stamps]
            figures.told += len(stage.stamps)
            figures.missing += sum(round((b - a) / _NANO / PERIOD) - 1 for a, b in pairwise(ends))
            if (number + 1) % 10 == 0 or number + 1 == encounters:
                print(f"after {number + 1} encounters:", flush=True)
                figures.print(stage.delays)
            stage.rest(FORGOTTEN + 0.5)  # the greeting is over
        kendon.terminate()
        kendon.wait()
        heard = sum(1 for _ in read_messages(recording, "/faces".__eq__))
        print(f"faces sent {stage.count}, heard {heard}, lost {stage.count - heard}")
        said.seek(0)
        print("kendon had said:", said.read().strip(), sep="\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--encounters", type=int, default=50, help="so many (50)")
    arguments = parser.parse_args()
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    measure(arguments.encounters)


if __name__ == "__main__":
    main()

"""The closed loop over ROS 2's topics: a person, a robot's look-alike and kendon, three processes.

    PYTHONPATH=src:tests python benchmarks/ros2_encounters.py [--encounters 50]

A simulated person greets, in real time, a base like Nav2's that `kendon ros2` drives with the
default tree. Each encounter is held against the same one in a single process: the phases that were
read, and what the robot said, performed and showed. Printed are also how long after the face
message that ends an interval its belief comes to the person's process, and what was lost.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from functools import partial
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from ros2_peers import CLOCK, LOOPBACK, ODOMETRY, free_domain, peer, reached, until

from kendon.features.sampler import PERIOD
from kendon.geometry import ORIGIN, Pose2D, quaternion_yaw, wrap_angle
from kendon.greeter import FORGOTTEN, Encounter, Greeter
from kendon.robots.base import CommandKind
from kendon.ros.dds import DdsNode
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
#: Commands whose order tells what the robot answered; drives and looks are sent again and again.
ANSWERS = {
    CommandKind.GESTURE: "/gesture",
    CommandKind.SAY: "/say",
    CommandKind.EXPRESS: "/expression",
}


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
        self._person = ""
        for topic, kind in (("/clock", CLOCK), ("/faces", FACE)):
            self.node.advertise(topic, kind)
        self._read("/odom", ODOMETRY, self._take_pose)
        for topic in ANSWERS.values():
            self._read(topic, STRING, partial(self._take_answer, topic))

    def play(self, name: str, number: int) -> None:
        """Somebody plays a script, in real time."""
        self.phases.clear()
        self.answers.clear()
        self.sent.clear()
        self.stamps.clear()
        person = SimulatedPerson(script(name))
        home, begin = self.pose, time.time_ns()
        self._person = str(number)
        self._follow()
        while not person.finished:
            due = begin + round(person.t * _NANO)
            self._wait(due)
            self._tell(person, due, home)
            person.step(in_frame_of(home, self.pose))

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

    def _take_pose(self, raw: bytes, message: Any, sent: int) -> None:
        p, q = message.pose.pose.position, message.pose.pose.orientation
        self.pose = Pose2D(p.x, p.y, quaternion_yaw((q.x, q.y, q.z, q.w)))


def point(x: float, y: float, z: float) -> Any:
    return build("geometry_msgs/msg/Point", {"x": x, "y": y, "z": z})


def in_frame_of(home: Pose2D, pose: Pose2D) -> Pose2D:
    """A pose of the world, as seen from where the robot stood when the person came."""
    x, y, _ = home.to_local((pose.x, pose.y, 0.0))
    return Pose2D(x, y, wrap_angle(pose.yaw - home.yaw))


def in_one_process(name: str) -> tuple[list[int], list[str]]:
    """The phases, and the robot's answers."""
    encounter = Encounter(name)
    for moment in Greeter(open_source(f"simulated:{name}")).run():
        encounter.add(moment)
    answers = []
    for action in encounter.actions:
        asked = action.command.asked
        kind = action.command.kind
        if kind is CommandKind.EXPRESS:
            answers.append(f"expression {asked['expression']} {asked['intensity']:g}")
        elif kind in ANSWERS:
            answers.append(f"{ANSWERS[kind][1:]} {asked.get('name') or asked['text']}")
    return [phase.value for phase in encounter.phases], answers


def measure(encounters: int) -> None:
    domain = free_domain()
    names = list(SCRIPTS)
    expected = {name: in_one_process(name) for name in names}
    same_phases = same_answers = told = missing = 0
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
            phases, answers = expected[name]
            stage.play(name, number)
            began = stage.sent[0][0]
            stage.rest(0.5)
            read = [phase for phase, _ in groupby(stage.phases)]
            same_phases += read == phases
            same_answers += stage.answers == answers
            told += len(stage.stamps)
            missing += sum(
                round((b - a) / _NANO / PERIOD) - 1 for a, b in pairwise([began, *stage.stamps])
            )
            if read != phases:
                print(f"{number} {name}: phases {read}, in one process {phases}")
            if stage.answers != answers:
                print(f"{number} {name}: answers {stage.answers}, in one process {answers}")
            if (number + 1) % 10 == 0:
                print(f"after {number + 1} encounters:", flush=True)
                report(stage.delays, number + 1, same_phases, same_answers, told, missing)
            stage.rest(FORGOTTEN + 0.5)  # the greeting is over
        kendon.terminate()
        kendon.wait()
        heard = sum(1 for _ in read_messages(recording, "/faces".__eq__))
        print(f"faces sent {stage.count}, heard {heard}, lost {stage.count - heard}")
        said.seek(0)
        print("kendon had said:", said.read().strip(), sep="\n")


def report(
    delays: list[float], encounters: int, phases: int, answers: int, told: int, missing: int
) -> None:
    late = 1000 * np.array(delays)
    print(f"  {phases} of {encounters} with the phases of one process, {answers} with its answers")
    print(f"  beliefs told {told}, missing between them {missing}")
    print(
        f"  belief after face: median {np.median(late):.1f} ms, 95 % below"
        f" {np.quantile(late, 0.95):.1f} ms, at most {late.max():.0f} ms",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--encounters", type=int, default=50, help="so many (50)")
    arguments = parser.parse_args()
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    measure(arguments.encounters)


if __name__ == "__main__":
    main()

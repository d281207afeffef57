"""kendon over ROS 1, in three processes: a person, kendon's node, and servers like Vizzy's.

    python benchmarks/ros.py [--encounters 50]

A simulated person greets so many times, at their own pace, with the default tree and model. Told
are how long after the face message that ends an interval its belief comes, what was lost, and
whether phases and commands are those of one process; every difference is listed.
"""

from __future__ import annotations

import argparse
import bisect
import json
import math
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from ros1.ros1_world import Master, make_this_process_a_node, tells, wait_for

from kendon.features.sampler import TOLERANCE
from kendon.geometry import Pose2D, wrap_angle
from kendon.greeter import FORGOTTEN, Encounter, Greeter
from kendon.phases import Phase
from kendon.robots.base import CHANNELS, Command, CommandKind
from kendon.ros.ros1.environment import messages, ros_module
from kendon.ros.ros1.vizzy import follow_robot
from kendon.simulation import SCRIPTS, SimulatedPerson, script
from kendon.sources import open_source
from kendon.sources.ros_faces import fill_face
from kendon.sources.ros_place import RobotPlace

NODE = "from kendon.cli import main; main()"
#: How long after its end an encounter's last messages are waited for, until the next begins [s].
PAUSE = FORGOTTEN + 0.5


class Act(NamedTuple):
    """What the robot was told."""

    channel: str
    label: str  # without the numbers
    t: float  # [s], since the first frame


class Deeds:
    """What the servers print that they were told."""

    def __init__(self, servers: subprocess.Popen[str]) -> None:
        self.lines: list[dict[str, Any]] = []
        self._servers = servers
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._servers.stdout is not None
        for line in self._servers.stdout:
            if line.startswith("{"):
                self.lines.append(json.loads(line))
            else:  # what went wrong with them
                print(f"the servers said: {line.rstrip()}", flush=True)

    def between(self, start: float, end: float) -> list[dict[str, Any]]:
        """Those between two times of the clock [s], with times since the first."""
        return [{**line, "t": line["t"] - start} for line in self.lines if start <= line["t"] < end]


class Beliefs:
    """The beliefs as they come."""

    def __init__(self) -> None:
        self.heard: list[tuple[float, float, int]] = []  # stamp [s], when [s], phase

    def take(self, message: Any) -> None:
        """Take in a belief."""
        self.heard.append((message.header.stamp.to_sec(), time.monotonic(), message.phase))


class Figures:
    """What all encounters come to."""

    def __init__(self) -> None:
        self.same_phases = self.same_commands = self.count = 0
        self.delays: list[float] = []  # [s], from face to belief
        self.told = self.expected = self.lost = 0
        self.apart: list[float] = []  # [s], over ROS after one process, of commands
        self.off: list[float] = []  # [m], between the places the robot ended in

    def print(self) -> None:
        """Print them."""
        delays, apart = sorted(self.delays), sorted(self.apart)
        print(f"{self.count} encounters")
        print(f"with the phases of one process: {self.same_phases}")
        print(f"with the commands of one process, in their order: {self.same_commands}")
        print(
            f"commands over ROS after those of one process: median"
            f" {statistics.median(apart) * 1e3:.0f} ms, between {apart[0] * 1e3:.0f} and"
            f" {apart[-1] * 1e3:.0f} ms"
        )
        print(f"the robot ends at most {max(self.off) * 100:.1f} cm from where it does in one")
        print(f"beliefs: {self.told}, in one process {self.expected}; intervals lost: {self.lost}")
        print(
            f"belief after face: median {statistics.median(delays) * 1e3:.1f} ms,"
            f" 95 % below {delays[int(0.95 * len(delays))] * 1e3:.1f} ms,"
            f" at most {delays[-1] * 1e3:.1f} ms"
        )


def main(count: int) -> None:
    with tempfile.TemporaryDirectory() as logs:
        master = Master(Path(logs))
        master.start()
        try:
            make_this_process_a_node(master)
            with master.servers("ideal") as servers, master.running("-c", NODE, "ros1") as node:
                said: list[str] = []
                threading.Thread(target=lambda: said.extend(node.stdout or ()), daemon=True).start()
                measure(count, Deeds(servers))
                assert node.poll() is None, "the node has ended"
                for line in said:
                    if "lost" in line or "left out" in line:
                        print(f"kendon said: {line.strip()}")
        finally:
            master.stop()


def measure(count: int, deeds: Deeds) -> None:
    rospy, kendon = ros_module("rospy"), messages("kendon_msgs")
    point = ros_module("geometry_msgs.msg").Point
    beliefs = Beliefs()
    faces = rospy.Publisher("/faces", kendon.FaceExtraction, queue_size=50, tcp_nodelay=True)
    rospy.Subscriber("/belief", kendon.Belief, beliefs.take, tcp_nodelay=True)
    wait_for(lambda: faces.get_num_connections() and tells("/kendon", "/belief"), "the node", 60)
    place = RobotPlace()
    follow_robot(place)
    wait_for(lambda: place.known, "the robot's pose")
    names = list(SCRIPTS)
    wanted = {name: in_one_process(name) for name in names}
    figures = Figures()
    for number in range(count):
        name = names[number % len(names)]
        beliefs.heard.clear()
        person = SimulatedPerson(script(name))
        begin, start, home = time.monotonic(), rospy.get_time(), place.pose
        sent: list[tuple[float, float]] = []  # stamp [s], when [s]
        while not person.finished:
            time.sleep(max(0.0, begin + person.t - time.monotonic()))
            frame = person.frame(in_frame_of(home, place.pose))
            message = fill_face(kendon.FaceExtraction(), frame, point)
            message.header.stamp = rospy.Time.from_sec(start + person.t)
            message.face_id = str(number)  # somebody else each time
            sent.append((message.header.stamp.to_sec(), time.monotonic()))
            faces.publish(message)
            person.step(in_frame_of(home, place.pose))
        end = start + person.t
        last = in_frame_of(home, place.pose)
        time.sleep(PAUSE)  # the greeting is over
        heard = [one for one in beliefs.heard if start < one[0] <= end + TOLERANCE]
        compare(f"{number} {name}", wanted[name], heard, sent, deeds, end, last, figures)
    figures.print()


def compare(
    title: str,
    wanted: Encounter,
    heard: list[tuple[float, float, int]],
    sent: list[tuple[float, float]],
    deeds: Deeds,
    end: float,
    last: Pose2D,
    figures: Figures,
) -> None:
    """Add an encounter to the figures, and list how it differs from that of one process."""
    start = sent[0][0]
    figures.count += 1
    phases = [Phase(phase).name for phase, _ in groupby(phase for _, _, phase in heard)]
    same = phases == [phase.name for phase in wanted.phases]
    figures.same_phases += same
    if not same:
        print(f"{title}: phases over ROS {phases}, in one process {wanted.phases}")
    stamps = [stamp for stamp, _ in sent]
    for stamp, when, _ in heard:
        face = bisect.bisect_right(stamps, stamp + TOLERANCE)  # the first one after the interval
        if face < len(sent):
            figures.delays.append(when - sent[face][1])
    figures.told += len(heard)
    figures.expected += len(wanted.observations)
    gaps = [b[0] - a[0] for a, b in pairwise(heard)]
    figures.lost += sum(round(gap / 0.2) - 1 for gap in gaps)
    over, inside = acts_over_ros(deeds.between(start, end)), acts_in_process(wanted)
    equal = True
    for channel in sorted({act.channel for act in over + inside}):
        one, two = ([a for a in acts if a.channel == channel] for acts in (over, inside))
        if [a.label for a in one] != [a.label for a in two]:
            equal = False
            print(f"{title}: {channel} over ROS {told(one)}, in one process {told(two)}")
        else:
            figures.apart += [a.t - b.t for a, b in zip(one, two, strict=True)]
    figures.same_commands += equal
    there = wanted.moments[-1].robot
    figures.off.append(math.hypot(last.x - there.x, last.y - there.y))


def told(acts: list[Act]) -> str:
    return ", ".join(f"{act.label} at {act.t:.2f} s" for act in acts) or "nothing"


def acts_over_ros(lines: list[dict[str, Any]]) -> list[Act]:
    """What the servers were told, with follow-ups left out."""
    kinds = {kind.value: kind for kind in CommandKind}
    found = []
    for line in lines:
        if line["kind"] in kinds:
            kind = kinds[line["kind"]]
            found.append(Act(CHANNELS[kind], label(kind, line["what"]), line["t"]))
    return without_repeats(found)


def acts_in_process(wanted: Encounter) -> list[Act]:
    """What the robot with ideal kinematics was told, with follow-ups left out."""

    def act(command: Command) -> Act:
        known = (command.asked.get(key) for key in ("text", "name", "expression"))
        what = next(filter(None, known), "")
        return Act(CHANNELS[command.kind], label(command.kind, what), command.issued)

    return without_repeats([act(action.command) for action in wanted.actions])


def label(kind: CommandKind, what: object) -> str:
    """A command without its numbers, which change as it is followed up."""
    words = {CommandKind.GO_TO: "drive", CommandKind.TURN_TO: "drive", CommandKind.LOOK_AT: "look"}
    return words.get(kind) or str(what)


def without_repeats(acts: list[Act]) -> list[Act]:
    """Of the same again and again on a channel, the first."""
    newest: dict[str, str] = {}
    kept = []
    for act in acts:
        if newest.get(act.channel) != act.label:
            kept.append(act)
        newest[act.channel] = act.label
    return kept


def in_frame_of(home: Pose2D, pose: Pose2D) -> Pose2D:
    """A pose of the world, as seen from where the robot stood when the person came."""
    x, y, _ = home.to_local((pose.x, pose.y, 0.0))
    return Pose2D(x, y, wrap_angle(pose.yaw - home.yaw))


def in_one_process(name: str) -> Encounter:
    """The same person before the robot with ideal kinematics."""
    encounter = Encounter(name)
    for moment in Greeter(open_source(f"simulated:{name}")).run():
        encounter.add(moment)
    return encounter


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--encounters", type=int, default=4)
    main(parser.parse_args().encounters)

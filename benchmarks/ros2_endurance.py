"""`kendon ros2` for a long time: ten people of ROS4HRI, thirty times a second, and a robot.

    PYTHONPATH=src:tests python benchmarks/ros2_endurance.py [--minutes 30] [--people 10]

This process is the cameras: of everybody it tells face, gaze and Action Units, and each minute
somebody goes and somebody else comes. A robot's look-alike is a second process, `kendon ros2` the
third. Printed are, minute by minute, how often everybody was really told of, kendon's memory and
share of a core, how long after the transforms that end an interval its belief comes here, and how
many did not come. Then the robot is
killed and started again, then the cameras: whether commands and beliefs come again.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from ros2_peers import CLOCK, LIMIT, LOOPBACK, free_domain, peer, reached

from kendon.ros.dds import DdsNode
from kendon.ros.ros2_transport import Offer
from kendon.ros.ros2_types import BELIEF, TRANSFORMS, build, type_store

UNITS = "hri_msgs/msg/FacialActionUnits"
RATE = 30
#: The camera's optical frame in the robot's base: z ahead, x to the right.
CAMERA = {"x": -0.5, "y": 0.5, "z": -0.5, "w": 0.5}
#: How kendon tells them.
_BELIEFS = Offer(BELIEF, reliable=True, latched=False)
_NANO = 10**9


class Camera:
    """Tells of people who come, stand about and go, on a node of its own."""

    def __init__(self, domain: int, people: int) -> None:
        self.node = DdsNode(domain)
        self.people: list[str] = []
        self.came = 0
        self.sent: deque[int] = deque(maxlen=40 * RATE)  # [ns], the stamps of the newest frames
        self.delays: list[float] = []  # [s]
        self.stamps: dict[str, int] = {}  # of everybody's newest belief [ns]
        self.missing = 0  # beliefs
        self.commands = 0  # of the robot's head and base that were heard
        self._read: set[str] = set()
        self._tf = build(TRANSFORMS, {"transforms": [{}]})
        self._units = build(UNITS, {})
        self.node.advertise("/tf", TRANSFORMS)
        self.node.advertise("/tf_static", TRANSFORMS, latched=True)
        self.node.advertise("/clock", CLOCK)
        mount = {
            "header": {"frame_id": "base_footprint"},
            "child_frame_id": "camera",
            "transform": {"translation": {"z": 1.2}, "rotation": CAMERA},
        }
        self.node.publish("/tf_static", TRANSFORMS, {"transforms": [mount]})
        for topic, kind in (
            ("/look_at", "geometry_msgs/msg/PointStamped"),
            ("/goal_pose", "geometry_msgs/msg/PoseStamped"),
        ):
            self.node.subscribe(topic, Offer(kind, True, False), self._count)
        for _ in range(people):
            self.replace()

    def replace(self, *, first: bool = False) -> None:
        """Somebody comes; with `first`, whoever was there first goes."""
        if first:
            gone = self.people.pop(0)
            self.node.withdraw(f"/humans/faces/{gone}/facs")
        name = f"f{self.came}"
        self.came += 1
        self.people.append(name)
        self.node.advertise(f"/humans/faces/{name}/facs", UNITS)

    def tell(self, now: int) -> None:
        """A frame of everybody, and what has come meanwhile."""
        store = type_store()
        header = {"sec": now // _NANO, "nanosec": now % _NANO}
        one = self._tf.transforms[0]
        vars(one.header.stamp).update(header)
        vars(self._units.header.stamp).update(header)
        t = now / _NANO
        self.node.publish("/clock", CLOCK, {"clock": header})
        self.sent.append(now)
        for name in self.people:
            number = int(name[1:])
            place, turn = one.transform.translation, one.transform.rotation
            # They sway before the robot, each at a place of their own.
            place.x, place.y = 0.5 * (number % 5) - 1 + 0.1 * math.sin(t / 2 + number), -0.4
            place.z = 1.5 + 0.4 * (number % 7) + 0.3 * math.sin(t / 5 + number)
            turn.x, turn.y, turn.z, turn.w = 0.5, 0.5, -0.5, 0.5
            one.header.frame_id, one.child_frame_id = "camera", f"face_{name}"
            self.node.publish_raw(
                "/tf", TRANSFORMS, bytes(store.serialize_cdr(self._tf, TRANSFORMS))
            )
            place.x = place.y = place.z = 0.0
            one.header.frame_id, one.child_frame_id = f"face_{name}", f"gaze_{name}"
            self.node.publish_raw(
                "/tf", TRANSFORMS, bytes(store.serialize_cdr(self._tf, TRANSFORMS))
            )
            self._units.intensity[12] = 2 + math.sin(t + number)
            raw = bytes(store.serialize_cdr(self._units, UNITS))
            self.node.publish_raw(f"/humans/faces/{name}/facs", UNITS, raw)
        self.node.spin(0.0)

    def follow(self) -> None:
        """Read the beliefs that have come to be told."""
        told = {topic for topic in self.node.offers() if topic.endswith("/belief")}
        for topic in told - self._read:
            self.node.subscribe(topic, _BELIEFS, partial(self._take, topic))
        for topic in self._read - told:
            self.node.unsubscribe(topic, _BELIEFS)
        self._read = told

    def run(self, seconds: float) -> float:
        """Tell of people for a while; how often a second that was."""
        begin, frames = time.monotonic(), 0
        while (passed := frames / RATE) < seconds:
            while (left := begin + passed - time.monotonic()) > 0:
                self.node.spin(left)
            self.tell(time.time_ns())
            frames += 1
            if frames % RATE == 0:
                self.follow()
        return frames / (time.monotonic() - begin)

    def _take(self, topic: str, raw: bytes, message: Any, sent: int) -> None:
        now = time.time_ns()
        told = message.header.stamp.sec * _NANO + message.header.stamp.nanosec
        before = self.stamps.get(topic)
        if before is not None:
            self.missing += max(0, round((told - before) / _NANO / 0.2) - 1)
        self.stamps[topic] = told
        stamps = np.array(self.sent)
        after = int(np.searchsorted(stamps, told + _NANO // 1000, side="right"))
        if after < len(stamps):
            self.delays.append((now - int(stamps[after])) / _NANO)

    def _count(self, raw: bytes, message: Any, sent: int) -> None:
        self.commands += 1


def memory_and_work(process: int) -> tuple[float, float]:
    """Resident memory [MB] and processor time [s] of a process."""
    status = Path(f"/proc/{process}/status").read_text()
    resident = next(line for line in status.splitlines() if line.startswith("VmRSS"))
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    ticks = int(fields[11]) + int(fields[12])
    return int(resident.split()[1]) / 1024, ticks / os.sysconf("SC_CLK_TCK")


def wait(camera: Camera, what: str, condition: Any) -> None:
    """Go on telling until something is so; how long it took."""
    begin = time.monotonic()
    while not condition():
        camera.run(0.2)
        camera.follow()
        if time.monotonic() - begin > LIMIT:
            print(f"{what}: NOT within {LIMIT:g} s", flush=True)
            return
    print(f"{what} after {time.monotonic() - begin:.1f} s", flush=True)


def measure(minutes: int, people: int, robot: str) -> None:
    domain = free_domain()
    with ExitStack() as stack:
        end = stack.enter_context(tempfile.TemporaryFile("w+"))
        command = "from kendon.cli import main; main()"
        kendon = subprocess.Popen(
            [sys.executable, "-c", command, "ros2", "--domain", str(domain), "--robot", robot],
            stdout=subprocess.DEVNULL, stderr=end,
        )  # fmt: skip
        stack.callback(kendon.kill)
        base = ExitStack()
        base.enter_context(peer("robot", str(domain)))
        stack.callback(base.close)
        camera = Camera(domain, people)
        while not reached(camera.node, "/tf"):
            camera.node.spin(0.1)
        wait(camera, "first belief", lambda: camera.stamps)
        print(
            "minute  rate [Hz]  memory [MB]  core  belief after face [ms]: median  99 %  max "
            " beliefs  missing"
        )
        for minute in range(minutes):
            _, before = memory_and_work(kendon.pid)
            camera.delays.clear()
            camera.missing = 0
            rate = camera.run(60)
            camera.replace(first=True)
            memory, work = memory_and_work(kendon.pid)
            late = 1000 * np.array(camera.delays)
            print(
                f"{minute + 1:6} {rate:10.2f} {memory:12.1f} {(work - before) / 60:5.2f}"
                f" {np.median(late):31.1f} {np.quantile(late, 0.99):5.0f} {late.max():4.0f}"
                f" {len(late):8} {camera.missing:8}",
                flush=True,
            )
        camera.commands = 0
        wait(camera, "a command for the robot", lambda: camera.commands)
        base.close()
        print("the robot is killed, and started again after 20 s", flush=True)
        camera.run(20)
        base.enter_context(peer("robot", str(domain)))
        camera.commands = 0
        wait(camera, "a command for the robot", lambda: camera.commands)
        for name in camera.people:
            camera.node.withdraw(f"/humans/faces/{name}/facs")
        camera.node.close()
        print("the cameras leave, and come again after 20 s", flush=True)
        time.sleep(20)
        camera = Camera(domain, people)
        wait(camera, "a belief", lambda: camera.stamps)
        camera.node.close()
        kendon.terminate()
        print(f"kendon ended with code {kendon.wait()}, and had said:")
        end.seek(0)
        print(end.read().strip())


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--minutes", type=int, default=30, help="so long (30)")
    parser.add_argument("--people", type=int, default=10, help="so many (10)")
    parser.add_argument("--robot", default="goal_pose", help="how the robot is driven (goal_pose)")
    arguments = parser.parse_args()
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    measure(arguments.minutes, arguments.people, arguments.robot)


if __name__ == "__main__":
    main()

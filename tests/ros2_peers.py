"""Other processes on a private DDS domain of this machine: a robot's look-alike, and a player.

python ros2_peers.py robot DOMAIN
python ros2_peers.py play DOMAIN BAG RATE [wait]
"""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

#: Nothing leaves this machine.
LOOPBACK = (
    '<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface name="lo"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>30</MaxAutoParticipantIndex>"
    '<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>'
)
CLOCK = "rosgraph_msgs/msg/Clock"
ODOMETRY = "nav_msgs/msg/Odometry"
STRING = "std_msgs/msg/String"
#: Everything is waited for so long, then a test fails: even a crawling machine is quicker [s].
LIMIT = 300.0
#: A tree that drives on and on while there is a phase.
DRIVING_TREE = """<root BTCPP_format="4" main_tree_to_execute="Go">
  <BehaviorTree ID="Go">
    <ReactiveSequence>
      <GetState state="{state}"/>
      <MoveBase goal_pose="30;0;0" frame_id="map" action_name="move_base"/>
    </ReactiveSequence>
  </BehaviorTree>
</root>
"""


def free_domain() -> int:
    """A domain that no other test run on this machine is likely to use."""
    return 20 + os.getpid() % 200


@contextmanager
def peer(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """One of the processes below, running; killed in the end."""
    root = Path(__file__).resolve().parents[1]
    environment = {**os.environ, "CYCLONEDDS_URI": LOOPBACK, "PYTHONPATH": str(root / "src")}
    process = subprocess.Popen(
        [sys.executable, __file__, *arguments],
        env=environment, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        yield process
        assert process.poll() in (None, -signal.SIGKILL), process.communicate()[1]
    finally:
        process.kill()
        process.communicate()


def until(node: Any, condition: Any) -> None:
    """Spin a node until something is so."""
    limit = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < limit, "the other process does not answer"
        node.spin(0.01)


def reached(node: Any, topic: str) -> bool:
    """Whether what a node publishes on a topic from now on gets to somebody.

    That somebody reads it is known a little earlier than its messages have a way there.
    """
    return bool(node._writers[topic][0].get_matched_subscriptions())


def stamp(t: float) -> dict[str, int]:
    seconds, rest = divmod(round(t * 1e9), 10**9)
    return {"sec": seconds, "nanosec": rest}


def robot(domain: int) -> None:
    """A base like Nav2's and ros2_control's, by the time of /clock; it reads the rest.

    What it hears on other topics it prints.
    """
    from kendon.geometry import Pose2D, quaternion_yaw
    from kendon.robots.point import PointRobot
    from kendon.ros.dds import DdsNode
    from kendon.ros.ros2_transport import Offer

    node = DdsNode(domain)
    planned = PointRobot(keep_distance=0.0)
    body: dict[str, Any] = {"speed": 0.0, "turn": 0.0}
    place = [0.0, 0.0, 0.0]  # as driven by /cmd_vel

    def goal(raw: bytes, message: Any, sent: int) -> None:
        p, q = message.pose.position, message.pose.orientation
        planned.go_to(Pose2D(p.x, p.y, quaternion_yaw((q.x, q.y, q.z, q.w))))
        body["driven"] = False

    def velocity(raw: bytes, message: Any, sent: int) -> None:
        body["speed"], body["turn"], body["driven"] = message.linear.x, message.angular.z, True

    def tick(raw: bytes, message: Any, sent: int) -> None:
        stamped = message.clock
        t = stamped.sec + stamped.nanosec * 1e-9
        dt, body["time"] = t - body.get("time", t), t
        if body.get("driven"):
            turned = place[2] + body["turn"] * dt
            place[0] += body["speed"] * dt * math.cos((place[2] + turned) / 2)
            place[1] += body["speed"] * dt * math.sin((place[2] + turned) / 2)
            place[2] = turned
            x, y, yaw = place
        else:
            planned.update(planned.time + dt)
            x, y, yaw = place[:] = planned.pose
        pose = {
            "position": {"x": x, "y": y},
            "orientation": {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)},
        }
        header = {"stamp": stamp(t), "frame_id": "odom"}
        node.publish("/odom", ODOMETRY, {"header": header, "pose": {"pose": pose}})

    def say(raw: bytes, message: Any, sent: int) -> None:
        print(getattr(message, "data", None) or f"look {message.point.z:g}", flush=True)

    for topic in ("/gesture", "/say", "/expression"):
        node.subscribe(topic, Offer(STRING, True, False), say)
    node.subscribe("/look_at", Offer("geometry_msgs/msg/PointStamped", True, False), say)
    node.subscribe("/goal_pose", Offer("geometry_msgs/msg/PoseStamped", True, False), goal)
    node.subscribe("/cmd_vel", Offer("geometry_msgs/msg/Twist", True, False), velocity)
    node.subscribe("/clock", Offer(CLOCK, True, False), tick)
    node.advertise("/odom", ODOMETRY)
    while True:
        node.spin(1.0)


def play(domain: int, bag: Path, rate: float, *, wait: bool) -> None:
    """A recording's messages at their times, once kendon reads them; then it waits to be ended.

    Args:
        domain: where.
        bag: the recording.
        rate: how much faster.
        wait: in the middle for a line on the standard input.
    """
    from kendon.ros import dds
    from kendon.ros.ros2_reading import PeopleReader

    from rosbags.highlevel import AnyReader  # isort: skip

    # However busy this machine is, nothing is lost.
    dds.DEPTHS["/tf"] = dds.DEPTH = 10_000
    node = dds.DdsNode(domain)
    with AnyReader([bag]) as reader:
        topics = {c.topic: c.msgtype for c in reader.connections}
        for topic, kind in topics.items():
            node.advertise(topic, kind, latched=topic == "/tf_static")
        wanted = {topic for topic in topics if PeopleReader.wanted(topic)}
        while not all(reached(node, topic) for topic in wanted):
            node.spin(0.01)
        began: tuple[int, float] | None = None
        for number, (connection, when, raw) in enumerate(reader.messages()):
            if wait and number == reader.message_count // 2:
                sys.stdin.readline()
                began = None
            began = began or (when, time.monotonic())
            due = began[1] + (when - began[0]) * 1e-9 / rate
            time.sleep(max(0.0, due - time.monotonic()))
            node.publish_raw(connection.topic, connection.msgtype, bytes(raw))
    print("played", flush=True)
    signal.pause()


if __name__ == "__main__":
    if sys.argv[1] == "robot":
        robot(int(sys.argv[2]))
    else:
        play(int(sys.argv[2]), Path(sys.argv[3]), float(sys.argv[4]), wait="wait" in sys.argv)

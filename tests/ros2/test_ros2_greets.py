"""A whole greeting between processes: a simulated person on /faces, a base like Nav2's, kendon."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="the extra 'ros2' is not installed")
pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from ros2_peers import LIMIT, LOOPBACK, ODOMETRY, free_domain, stamp, until

from kendon.geometry import Pose2D, quaternion_yaw
from kendon.phases import Phase
from kendon.robots import PointRobot
from kendon.ros.dds import DdsNode
from kendon.ros.ros2_robot import POSE
from kendon.ros.ros2_transport import Offer
from kendon.ros.ros2_types import FACE, STRING, build, header_fields, type_store
from kendon.simulation.person import SimulatedPerson
from kendon.simulation.scripts import SCRIPTS, script
from kendon.sources.ros_faces import fill_face

ROOT = Path(__file__).resolve().parents[2]


def point(x: float, y: float, z: float) -> Any:
    return build("geometry_msgs/msg/Point", {"x": x, "y": y, "z": z})


def test_a_robot_on_ros2_greets_a_simulated_person(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK)
    node = DdsNode(free_domain() + 4)
    base = PointRobot(Pose2D(0.0, 0.0, 0.0), keep_distance=0.0)
    gestures: list[str] = []
    states: list[str] = []

    def drive(raw: bytes, message: Any, sent: int) -> None:
        p, q = message.pose.position, message.pose.orientation
        base.go_to(Pose2D(p.x, p.y, quaternion_yaw((q.x, q.y, q.z, q.w))))

    def offer(kind: str) -> Offer:
        return Offer(kind, True, False)

    node.advertise("/odom", ODOMETRY)
    node.advertise("/faces", FACE)
    node.subscribe("/goal_pose", offer(POSE), drive)
    node.subscribe("/gesture", offer(STRING), lambda _raw, m, _sent: gestures.append(m.data))
    node.subscribe("/state", offer(STRING), lambda _raw, m, _sent: states.append(m.data))
    for topic in ("/say", "/expression"):
        node.subscribe(topic, offer(STRING), lambda _raw, m, _sent: None)
    node.subscribe("/look_at", offer("geometry_msgs/msg/PointStamped"), lambda _raw, m, _sent: None)

    command = "from kendon.cli import main; main()"
    options = ["ros2", "--domain", str(node.domain), "--robot", "goal_pose"]
    running = subprocess.Popen(
        [sys.executable, "-c", command, *options],
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        until(node, lambda: node.asked().keys() >= {"/faces", "/odom"})
        person = SimulatedPerson(script(next(iter(SCRIPTS))))
        began = time.time()
        closest = math.inf
        while not person.finished:
            # The person's own clock leads; a slow machine makes the whole world late, not torn.
            frame = person.frame(base.pose, base.face)
            now = began + frame.t
            time.sleep(max(0.0, now - time.time()))
            base.update(frame.t)
            x, y, yaw = base.pose
            place = {
                "position": {"x": x, "y": y},
                "orientation": {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)},
            }
            header = {"stamp": stamp(now), "frame_id": "odom"}
            node.publish("/odom", ODOMETRY, {"header": header, "pose": {"pose": place}})
            header = dict(header_fields(round(now * 1e9), "base_footprint"))
            face = fill_face(build(FACE, {"header": header}), frame, point)
            face.action_units = np.array(face.action_units)
            node.publish_raw("/faces", FACE, bytes(type_store().serialize_cdr(face, FACE)))
            if frame.seen:
                closest = min(closest, math.hypot(*frame.head[:2]))
            node.spin(0.001)
            person.step(base.pose)
        until(node, lambda: len(states) > 20)
        running.send_signal(signal.SIGTERM)
        out, err = running.communicate(timeout=LIMIT)
    finally:
        running.kill()
        running.communicate()
        node.close()
    assert running.returncode == 0, err
    assert "Traceback" not in err
    read = list(dict.fromkeys(states))
    assert read[0] == str(Phase.IA.value)
    assert {str(Phase.DS.value), str(Phase.CS.value)} <= set(read)
    assert "wave" in gestures
    assert 0.5 < closest < 1.6
    assert "Pleased to meet you" in out

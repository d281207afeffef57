"""`kendon ros2` as a process among others on this machine: a player, a camera, a base."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="the extra 'ros2' is not installed")
pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from bag_files import Told, Transform, write_bag
from ros2_peers import LIMIT, LOOPBACK, ODOMETRY, free_domain, peer, stamp, until
from shared_data import shared_file

from kendon.estimate import estimate
from kendon.features import observe
from kendon.models import load_model
from kendon.person import FloatArray
from kendon.ros.dds import DdsNode
from kendon.ros.ros2_reading import Engagement, PeopleReader
from kendon.ros.ros2_record import replay
from kendon.ros.ros2_transport import Offer
from kendon.ros.ros2_types import BELIEF, FACE, header_fields
from kendon.sources.bags import read_bag_people
from kendon.sources.ros_bags import read_messages

ROOT = Path(__file__).resolve().parents[2]
TWIST = "geometry_msgs/msg/Twist"


@pytest.fixture
def domain() -> int:
    return free_domain() + 1


@pytest.fixture
def node(domain: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[DdsNode]:
    """This process on the domain."""
    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK)
    node = DdsNode(domain)
    yield node
    node.close()


class Process:
    """`kendon ros2` running."""

    def __init__(self, domain: int, *options: str | Path) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", "from kendon.cli import main; main()", "ros2",
             "--domain", str(domain), *map(str, options)],
            env={**os.environ, "CYCLONEDDS_URI": LOOPBACK, "PYTHONPATH": str(ROOT / "src"),
                 "COLUMNS": "200"},
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip

    def interrupt(self) -> tuple[int, str, str]:
        """Press Ctrl-C; how it ended, and what it printed."""
        self.process.send_signal(signal.SIGINT)
        return self.end()

    def end(self) -> tuple[int, str, str]:
        out, err = self.process.communicate(timeout=LIMIT)
        return self.process.returncode, out, err


@pytest.fixture
def kendon(domain: int) -> Iterator[Any]:
    started: list[Process] = []

    def start(*options: str | Path) -> Process:
        started.append(Process(domain, *options))
        return started[-1]

    yield start
    for one in started:
        one.process.kill()
        one.process.communicate()


def recorded_beliefs(recording: Path) -> dict[str, FloatArray]:
    """The beliefs that were published, by the person's name."""
    found: dict[str, list[FloatArray]] = {}
    for topic, _, message in read_messages(recording, lambda t: t.endswith("/belief")):
        found.setdefault(topic.split("/")[2], []).append(np.array(message.probabilities))
    return {name: np.array(rows) for name, rows in found.items()}


def play(bag: Path, rate: float, node: DdsNode, kendon: Any, recording: Path) -> None:
    """Play a bag to kendon, which records; it ends when everybody has gone."""
    running = kendon("--record", recording)
    until(node, lambda: "/state" in node.offers())
    with peer("play", str(node.domain), str(bag), str(rate)) as player:
        assert player.stdout is not None
        levels: dict[str, int] = {}

        def follow() -> bool:
            """Whether somebody was there, and everybody has gone."""
            for topic, offer in node.offers().items():
                if topic.endswith("/engagement_status") and topic not in levels:
                    levels[topic] = 1

                    def take(raw: bytes, message: Any, sent: int, topic: str = topic) -> None:
                        levels[topic] = message.level

                    node.subscribe(topic, offer, take)
            return bool(levels) and not any(levels.values())

        until(node, follow)
        assert player.stdout.readline() == "played\n"
    code, _, err = running.interrupt()
    assert code == 0, err


def assert_same_beliefs(bag: Path, recording: Path) -> None:
    model = load_model()
    told = recorded_beliefs(recording)
    tracks = read_bag_people(bag)
    assert len(told) == len(tracks)
    for track in tracks:
        expected = estimate(observe(track), model).probabilities
        heard = told[track.name.removeprefix(f"{bag.stem}_")]
        # The file's last interval ends with its last frame, before its time.
        count = len(expected) - 1
        np.testing.assert_allclose(heard[:count], expected[:count], rtol=0, atol=1e-9)
    again: dict[str, list[FloatArray]] = {name: [] for name in told}
    for one in replay(recording, PeopleReader(model)):
        if one.belief is not None:
            again[one.name].append(one.belief.probabilities)
    for name, beliefs in told.items():
        assert beliefs.tolist() == np.array(again[name]).tolist()


def walk_up() -> list[Told]:
    """Somebody who walks up to a camera, for 6 s."""
    told: list[Told] = [Transform(0.0, "camera_link", "camera_optical_frame", static=True)]
    turn = (0.5, 0.5, -0.5, 0.5)
    for i in range(180):
        t = i / 30
        place = (0.1, -0.4, 4.0 - 0.015 * i)
        told.append(Transform(t, "camera_optical_frame", "face_ann1", place, turn))
        told.append(Transform(t + 5e-5, "face_ann1", "gaze_ann1", rotation=turn))
    return told


def test_a_made_bag_played_over_dds_gives_the_beliefs_of_the_file(
    node: DdsNode, kendon: Any, tmp_path: Path
) -> None:
    bag = write_bag(tmp_path, "mcap", walk_up())
    play(bag, 2.0, node, kendon, tmp_path / "heard.mcap")
    model = load_model()
    (track,) = read_bag_people(bag)
    expected = estimate(observe(track), model).probabilities
    heard = recorded_beliefs(tmp_path / "heard.mcap")["anonymous_person_ann1"]
    count = len(expected) - 1
    np.testing.assert_allclose(heard[:count], expected[:count], rtol=0, atol=1e-9)
    again = [
        one.belief.probabilities.tolist()
        for one in replay(tmp_path / "heard.mcap", PeopleReader(model))
        if one.belief is not None
    ]
    assert again == heard.tolist()


def test_a_real_bag_played_over_dds_gives_the_beliefs_of_the_file(
    node: DdsNode, kendon: Any, tmp_path: Path
) -> None:
    bag = shared_file("data/ros4hri_bags/2p_AA_FV_eng_1")
    play(bag, 1.5, node, kendon, tmp_path / "heard.mcap")
    assert_same_beliefs(bag, tmp_path / "heard.mcap")


class World:
    """A camera that tells /faces of somebody, and a base that drives by /cmd_vel; 20 Hz."""

    def __init__(self, node: DdsNode) -> None:
        self.node = node
        self.speeds: list[float] = []
        self.beliefs: list[int] = []
        self.levels: list[int] = []
        self.x = 0.0
        node.advertise("/odom", ODOMETRY)
        node.advertise("/faces", FACE)
        node.subscribe("/cmd_vel", Offer(TWIST, True, False), self._drive)
        until(node, lambda: node.asked().keys() >= {"/faces", "/odom"})

    def _drive(self, raw: bytes, message: Any, sent: int) -> None:
        self.speeds.append(message.linear.x)

    def _follow(self) -> None:
        name = "/kendon/anonymous_person_7/belief"
        if name in self.node.offers() and not self.beliefs:
            self.beliefs.append(0)
            self.node.subscribe(
                name, Offer(BELIEF, True, False), lambda _raw, m, _sent: self.beliefs.append(m.phase)
            )

    def step(self, *, person: bool = True, odometry: bool = True) -> None:
        """A twentieth of a second of the world, in real time."""
        now = time.time()
        end = now + 0.05
        self.x += 0.05 * (self.speeds[-1] if self.speeds else 0.0)
        header = {"stamp": stamp(now), "frame_id": "odom"}
        place = {"position": {"x": self.x}, "orientation": {"w": 1.0}}
        if odometry:
            self.node.publish("/odom", ODOMETRY, {"header": header, "pose": {"pose": place}})
        if person:
            face = {
                "header": header_fields(round(now * 1e9), "base_footprint"),
                "face": {"x": 4.0 - self.x, "z": 1.6},
                "face_rotation": {"z": np.pi},
                "action_units": [0.0, 0.0],
                "face_id": "7",
            }
            self.node.publish("/faces", FACE, face)
        self._follow()
        while (left := end - time.time()) > 0:
            self.node.spin(left)

    def until(self, condition: Any, **options: bool) -> None:
        limit = time.monotonic() + LIMIT
        while not condition():
            assert time.monotonic() < limit, (self.speeds[-5:], self.beliefs[-5:])
            self.step(**options)

    def drives(self) -> bool:
        return bool(self.speeds) and self.speeds[-1] > 0.1


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A tree that drives on and on while there is a phase."""
    path = tmp_path / "tree.xml"
    path.write_text(TREE)
    return path


TREE = """<root BTCPP_format="4" main_tree_to_execute="Go">
  <BehaviorTree ID="Go">
    <ReactiveSequence>
      <GetState state="{state}"/>
      <MoveBase goal_pose="30;0;0" frame_id="map" action_name="move_base"/>
    </ReactiveSequence>
  </BehaviorTree>
</root>
"""


def test_the_base_stops_on_ctrl_c(node: DdsNode, kendon: Any, tree: Path) -> None:
    running = kendon("--robot", "cmd_vel", "--tree", tree)
    world = World(node)
    world.until(world.drives)
    code, out, err = running.interrupt()
    node.spin(0.2)
    assert code == 0, err
    assert world.speeds[-1] == 0.0
    assert "go_to" in out
    assert "Traceback" not in err


def test_the_base_stops_when_the_person_is_lost_and_they_are_told_of_as_gone(
    node: DdsNode, kendon: Any, tree: Path
) -> None:
    running = kendon("--robot", "cmd_vel", "--tree", tree)
    world = World(node)
    node_levels: list[int] = []
    world.until(world.drives)
    topic = "/humans/persons/anonymous_person_7/engagement_status"
    world.until(lambda: topic in node.offers())
    node.subscribe(topic, node.offers()[topic], lambda _raw, m, _sent: node_levels.append(m.level))
    world.until(lambda: node_levels and node_levels[-1] != 0)
    world.until(lambda: node_levels[-1] == Engagement.UNKNOWN, person=False)
    world.until(lambda: world.speeds[-1] == 0.0, person=False)
    assert len(world.beliefs) > 2
    code, out, err = running.interrupt()
    assert code == 0, err
    assert "anonymous_person_7  gone" in out


def test_a_base_that_vanishes_ends_in_a_stated_failure(
    node: DdsNode, kendon: Any, tree: Path
) -> None:
    running = kendon("--robot", "cmd_vel", "--tree", tree)
    world = World(node)
    world.until(world.drives)
    world.until(lambda: world.speeds[-1] == 0.0, odometry=False)  # it does not drive blind
    limit = time.monotonic() + 7.0  # more than the patience
    while time.monotonic() < limit:
        world.step(odometry=False)
    code, _, err = running.interrupt()
    assert code == 0
    assert "failed: the robot has not told where it is for 5" in err


def test_what_a_node_cannot_use_is_said(node: DdsNode, kendon: Any) -> None:
    node.advertise("/faces", "std_msgs/msg/String")
    code, _, err = kendon("--seconds", "2").end()
    assert code == 2
    assert (
        "/faces is published as std_msgs/msg/String, not as kendon_msgs/msg/FaceExtraction" in err
    )
    assert "Traceback" not in err


def test_who_waits_for_nobody_says_for_what_and_where(domain: int, kendon: Any) -> None:
    code, _, err = kendon("--seconds", "1").end()
    assert code == 2
    assert err.count("kendon: ") == 1
    assert (
        f"nobody publishes /humans/faces/tracked with /tf (ROS4HRI), or /faces, on domain {domain}"
        in err
    )


def test_mistakes_on_the_command_line(domain: int, kendon: Any, tmp_path: Path) -> None:
    there = tmp_path / "there.mcap"
    there.touch()
    for options, sentence in (
        (("--domain", "233"), "--domain lies between 0 and 232, not 233"),
        (("--seconds", "-1"), "--seconds is more than 0, not -1"),
        (("--record", tmp_path / "x.bag"), "a recording ends in .mcap"),
        (("--record", there), "this recording exists already"),
        (("--record", tmp_path / "no" / "x.mcap"), "there is no such folder"),
    ):
        code, _, err = kendon(*options).end()
        assert (code, err.count("\n")) == (2, 1)
        assert sentence in err
    assert list(tmp_path.iterdir()) == [there]

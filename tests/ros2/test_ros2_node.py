"""`kendon ros2` as a process among others on this machine: a player, a camera, a base."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="the extra 'ros2' is not installed")
pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from bag_files import Told, Transform, write_bag
from ros2_peers import DRIVING_TREE, LIMIT, LOOPBACK, ODOMETRY, free_domain, peer, stamp, until
from shared_data import shared_file

from kendon.cli import main
from kendon.estimate import estimate
from kendon.features import observe
from kendon.models import load_model
from kendon.person import FloatArray, Track
from kendon.ros.dds import DdsNode
from kendon.ros.ros2_reading import PeopleReader
from kendon.ros.ros2_record import replay
from kendon.ros.ros2_transport import Offer
from kendon.ros.ros2_types import BELIEF, FACE, header_fields
from kendon.sources.bags import read_bag_people
from kendon.sources.ros_bags import read_messages
from kendon.sources.ros_stamps import nanoseconds

ROOT = Path(__file__).resolve().parents[2]
TWIST = "geometry_msgs/msg/Twist"
#: No machine is so busy that messages are later [s].
PATIENCE = 60.0
#: A face of nobody who is known.
ANONYMOUS = "ann1"


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

    def __init__(self, domain: int, *options: object) -> None:
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

    def start(*options: object) -> Process:
        started.append(Process(domain, *options))
        return started[-1]

    yield start
    for one in started:
        one.process.kill()
        one.process.communicate()


@pytest.fixture
def command(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[..., tuple[int, str]]:
    """`kendon ros2` in this process: its exit code, and what it says on stderr."""
    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK)
    monkeypatch.setenv("COLUMNS", "300")

    def run(*options: object) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["kendon", "ros2", *map(str, options)])
        with pytest.raises(SystemExit) as ended:
            main()
        return int(ended.value.code or 0), capsys.readouterr().err

    return run


def recorded_beliefs(recording: Path) -> dict[str, FloatArray]:
    """The beliefs that were published, by the person's name."""
    found: dict[str, list[FloatArray]] = {}
    for topic, _, message in read_messages(recording, lambda t: t.endswith("/belief")):
        found.setdefault(topic.split("/")[2], []).append(np.array(message.probabilities))
    return {name: np.array(rows) for name, rows in found.items()}


def play(bag: Path, node: DdsNode, kendon: Any, recording: Path) -> None:
    """Play a bag to kendon, which records; however slow the machine, none of it counts as late.

    In its middle the player waits until all beliefs are heard here; the last ones are the end.
    """
    ends = {name_of(bag, track): last_complete(bag, track) for track in read_bag_people(bag)}
    running = kendon("--record", recording, "--lateness", PATIENCE)
    newest: dict[str, int] = {}
    until(node, lambda: "/state" in node.offers())
    with peer("play", str(node.domain), str(bag), "4", "wait") as player:
        assert player.stdin is not None
        for name in ends:

            def take(raw: bytes, message: Any, sent: int, name: str = name) -> None:
                newest[name] = nanoseconds(message.header.stamp)

            topic = f"/kendon/{name}/belief"
            until(node, lambda topic=topic: topic in node.offers())
            node.subscribe(topic, Offer(BELIEF, True, False), take)
        player.stdin.write("go on\n")
        player.stdin.flush()
        until(node, lambda: all(newest.get(name, 0) >= end for name, end in ends.items()))
    code, _, err = running.interrupt()
    assert code == 0, err
    assert "left out" not in err


def name_of(bag: Path, track: Track) -> str:
    """What kendon calls somebody who is in a bag."""
    name = track.name.removeprefix(f"{bag.stem}_")
    return f"anonymous_person_{name}" if name == ANONYMOUS else name


def last_complete(bag: Path, track: Track) -> int:
    """When the last interval of somebody in a bag ends that a later frame closes [ns]."""
    heads = [
        nanoseconds(told.header.stamp)
        for _, _, message in read_messages(bag, "/tf".__eq__)
        for told in message.transforms
        if told.child_frame_id.startswith("face_")
    ]
    # The file's last interval ends with its last frame, before its time.
    return min(heads) + round(float(observe(track).t[-2]) * 1e9) - 1000


def assert_same_beliefs(bag: Path, recording: Path) -> None:
    model = load_model()
    told = recorded_beliefs(recording)
    tracks = read_bag_people(bag)
    assert len(told) == len(tracks)
    for track in tracks:
        expected = estimate(observe(track), model).probabilities
        heard = told[name_of(bag, track)]
        count = len(expected) - 1
        np.testing.assert_allclose(heard[:count], expected[:count], rtol=0, atol=1e-9)
    again: dict[str, list[FloatArray]] = {name: [] for name in told}
    for one in replay(recording, PeopleReader(model, patience=PATIENCE)):
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
        told.append(Transform(t, "camera_optical_frame", f"face_{ANONYMOUS}", place, turn))
        told.append(Transform(t + 5e-5, f"face_{ANONYMOUS}", f"gaze_{ANONYMOUS}", rotation=turn))
    return told


def test_a_made_bag_played_over_dds_gives_the_beliefs_of_the_file(
    node: DdsNode, kendon: Any, tmp_path: Path
) -> None:
    bag = write_bag(tmp_path, "mcap", walk_up())
    play(bag, node, kendon, tmp_path / "heard.mcap")
    assert_same_beliefs(bag, tmp_path / "heard.mcap")


def test_a_real_bag_played_over_dds_gives_the_beliefs_of_the_file(
    node: DdsNode, kendon: Any, tmp_path: Path
) -> None:
    bag = shared_file("data/ros4hri_bags/2p_AA_FV_eng_1")
    play(bag, node, kendon, tmp_path / "heard.mcap")
    assert_same_beliefs(bag, tmp_path / "heard.mcap")


class World:
    """A camera that tells /faces of somebody, and a base that drives by /cmd_vel; 20 Hz."""

    def __init__(self, node: DdsNode) -> None:
        self.node = node
        self.speeds: list[float] = []
        self.x = 0.0
        node.advertise("/odom", ODOMETRY)
        node.advertise("/faces", FACE)
        node.subscribe("/cmd_vel", Offer(TWIST, True, False), self._drive)
        until(node, lambda: node.asked().keys() >= {"/faces", "/odom"})

    def _drive(self, raw: bytes, message: Any, sent: int) -> None:
        self.speeds.append(message.linear.x)

    def step(self) -> None:
        """A twentieth of a second of the world, in real time."""
        now = time.time()
        end = now + 0.05
        self.x += 0.05 * (self.speeds[-1] if self.speeds else 0.0)
        header = {"stamp": stamp(now), "frame_id": "odom"}
        place = {"position": {"x": self.x}, "orientation": {"w": 1.0}}
        self.node.publish("/odom", ODOMETRY, {"header": header, "pose": {"pose": place}})
        face = {
            "header": header_fields(round(now * 1e9), "base_footprint"),
            "face": {"x": 9.0, "z": 1.6},
            "face_rotation": {"z": np.pi},
            "action_units": [0.0, 0.0],
            "face_id": "7",
        }
        self.node.publish("/faces", FACE, face)
        while (left := end - time.time()) > 0:
            self.node.spin(left)

    def until(self, condition: Any) -> None:
        limit = time.monotonic() + LIMIT
        while not condition():
            assert time.monotonic() < limit, self.speeds[-5:]
            self.step()

    def drives(self) -> bool:
        return bool(self.speeds) and self.speeds[-1] > 0.1


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A tree that drives on and on while there is a phase."""
    path = tmp_path / "tree.xml"
    path.write_text(DRIVING_TREE)
    return path


def test_the_base_stops_on_ctrl_c(node: DdsNode, kendon: Any, tree: Path) -> None:
    running = kendon("--robot", "cmd_vel", "--tree", tree)
    world = World(node)
    world.until(world.drives)
    code, out, err = running.interrupt()
    until(node, lambda: world.speeds[-1] == 0.0)
    assert code == 0, err
    assert "robot  drive" in out
    assert "Traceback" not in err


def test_a_camera_that_dies_and_comes_again_is_read_again(
    node: DdsNode, kendon: Any, tmp_path: Path
) -> None:
    bag = write_bag(tmp_path, "mcap", walk_up())
    kendon("--lateness", PATIENCE)
    until(node, lambda: "/state" in node.offers())
    heard: list[int] = []
    topic = f"/kendon/anonymous_person_{ANONYMOUS}/belief"

    def take(raw: bytes, message: Any, sent: int) -> None:
        heard.append(nanoseconds(message.header.stamp))

    node.subscribe(topic, Offer(BELIEF, True, False), take)
    with peer("play", str(node.domain), str(bag), "4"):
        until(node, lambda: heard)
    with peer("play", str(node.domain), str(bag), "4"):  # its clock begins again
        until(node, lambda: any(later < before for before, later in pairwise(heard)))


def test_who_waits_for_nobody_says_for_what_and_where(domain: int, command: Any) -> None:
    code, err = command("--domain", domain, "--seconds", "0.2")
    assert code == 2
    assert err.count("kendon: ") == 1
    assert (
        f"nobody publishes /humans/faces/tracked with /tf (ROS4HRI), or /faces, on domain {domain}"
        in err
    )


def test_mistakes_on_the_command_line(domain: int, command: Any, tmp_path: Path) -> None:
    there = tmp_path / "there.mcap"
    there.touch()
    for options, sentence in (
        (("--domain", "233"), "--domain lies between 0 and 232, not 233"),
        (("--seconds", "-1"), "--seconds is more than 0, not -1"),
        (("--lateness", "0"), "--lateness is more than 0, and at most 60 s, not 0"),
        (("--lateness", "nan"), "--lateness is more than 0, and at most 60 s, not nan"),
        (("/odom",), "'/odom' is no remapping of a topic; write it as /odom:=/my_robot/odom"),
        (("/odom:=/7up!",), "'/odom:=/7up!' is no remapping of a topic"),
        (("/scan:=/x",), "kendon has no topic /scan; valid: /faces, /odom, /tf,"),
        (("/odom:=/x", "/faces:=/x"), "two of kendon's topics would be /x"),
        (("--record", tmp_path / "x.bag"), "a recording of ROS 2 ends in .mcap"),
        (("--record", there), "this recording exists already"),
        (("--record", there / "x.mcap"), "cannot be written"),
        (("--record", "/proc/x.mcap"), "cannot be recorded into"),
        (("--robot", "cmd_vel", "--leash", "-1"), "leash is a finite number of m, at least 0"),
        (("--robot", "goal_pose", "--tree", tmp_path / "no.xml"), "no.xml"),
        (
            ("--tree", tmp_path / "no.xml"),
            "--tree is for a robot that greets; give --robot goal_pose",
        ),
        (("--leash", "2"), "--leash is for a robot that greets"),
        (("--model", "nobody"), "nobody"),
    ):
        code, err = command("--domain", domain, *options)
        assert (code, err.count("\n")) == (2, 1), err
        assert sentence in err
    assert list(tmp_path.iterdir()) == [there]

"""The transport of rclpy, with a stand-in for ROS: what it asks of it, and that it is the same."""

from __future__ import annotations

import math
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from bag_files import Transform, write_bag
from ros2_peers import DRIVING_TREE, LIMIT, ODOMETRY

from kendon.models import load_model
from kendon.ros.rclpy_node import RclpyTransport, main
from kendon.ros.ros2_node import Ros2Node
from kendon.ros.ros2_transport import Offer, Transport
from kendon.ros.ros2_types import FACE, STRING, TRANSFORMS, build, header_fields, type_store


class WrongTypeError(Exception):
    """What rclpy raises for a parameter of another type."""


class Graph:
    """A node of rclpy whose graph is these lists."""

    def __init__(self) -> None:
        self.published: list[tuple[str, Any]] = []
        self.readers: dict[str, Callable[[bytes], None]] = {}
        self.others: dict[str, list[Any]] = {}
        self.waiting: list[tuple[str, bytes]] = []
        self.left = False
        self.parameters: dict[str, Any] = {}
        self.waits: list[float] = []  # [s], for readers of the last messages
        self.after: Callable[[], None] = lambda: None  # each time it is spun

    def get_name(self) -> str:
        return "kendon"

    def get_logger(self) -> Any:
        return SimpleNamespace(info=print, warning=print)

    def declare_parameter(self, name: str, value: Any) -> Any:
        given = self.parameters.get(name, value)
        if type(given) is not type(value):
            raise WrongTypeError(f"{given!r} is no {type(value).__name__}")
        return SimpleNamespace(value=given)

    def resolve_topic_name(self, topic: str) -> str:
        return topic

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [(topic, [infos[0].topic_type]) for topic, infos in self.others.items()]

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        return self.others.get(topic, [])

    def get_subscriptions_info_by_topic(self, topic: str) -> list[Any]:
        return [SimpleNamespace(node_name="base", topic_type=STRING)] if topic == "/state" else []

    def create_publisher(self, kind: Any, topic: str, qos: Any) -> Any:
        return SimpleNamespace(
            topic=topic,
            publish=lambda message: self.published.append((topic, message)),
            wait_for_all_acked=self.waits.append,
        )

    def destroy_publisher(self, publisher: Any) -> None:
        pass

    def create_subscription(
        self, kind: Any, topic: str, callback: Callable[[bytes], None], qos: Any, *, raw: bool
    ) -> str:
        assert raw
        self.readers[topic] = callback
        return topic

    def destroy_subscription(self, subscription: Any) -> None:
        del self.readers[subscription]

    def destroy_node(self) -> None:
        self.left = True


def set_fields(message: Any, fields: dict[str, Any]) -> None:
    """As rosidl_runtime_py does: field by field, into what is there."""
    made = build(message.__msgtype__, fields)
    message.__dict__.update(vars(made))


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Graph:
    graph = Graph()
    store = type_store()

    def module(name: str, **members: Any) -> None:
        made = ModuleType(name)
        vars(made).update(members)
        monkeypatch.setitem(sys.modules, name, made)

    def spin_once(node: Any, timeout_sec: float) -> None:
        if graph.waiting:
            topic, raw = graph.waiting.pop(0)
            graph.readers[topic](raw)
        graph.after()

    def init(signal_handler_options: Any) -> None:
        assert signal_handler_options == "no"

    policy = SimpleNamespace(RELIABLE=1, BEST_EFFORT=2, TRANSIENT_LOCAL=1, VOLATILE=2)
    node = {"create_node": lambda name: graph, "try_shutdown": lambda: None}
    module("rclpy", spin_once=spin_once, init=init, **node)
    module("rclpy.signals", SignalHandlerOptions=SimpleNamespace(NO="no"))
    module("rclpy.exceptions", ParameterException=WrongTypeError)
    module("rclpy.duration", Duration=lambda seconds: seconds)
    module("rclpy.qos", ReliabilityPolicy=policy, DurabilityPolicy=policy, QoSProfile=dict)
    module(
        "rclpy.serialization",
        serialize_message=lambda m: bytes(store.serialize_cdr(m, m.__msgtype__)),
        deserialize_message=lambda raw, kind: store.deserialize_cdr(raw, kind().__msgtype__),
    )
    module("rosidl_runtime_py")
    module("rosidl_runtime_py.utilities", get_message=lambda kind: lambda: build(kind, {}))
    module("rosidl_runtime_py.set_message", set_message_fields=set_fields)
    return graph


def told_by(name: str, kind: str, *, latched: bool = False) -> Any:
    profile = SimpleNamespace(reliability=1, durability=1 if latched else 2)
    return SimpleNamespace(node_name=name, topic_type=kind, qos_profile=profile)


def test_it_tells_what_others_publish_and_read(graph: Graph) -> None:
    transport: Transport = RclpyTransport(graph)
    graph.others = {
        "/tf_static": [told_by("camera", TRANSFORMS, latched=True)],
        "/tf": [told_by("kendon", TRANSFORMS)],
        "/scan": [told_by("laser", "sensor_msgs/msg/LaserScan")],
    }
    transport.advertise("/state", STRING)
    assert transport.offers() == {"/tf_static": {Offer(TRANSFORMS, True, True)}}
    assert transport.asked() == {"/state": STRING}


def test_a_node_on_rclpy_reads_people(graph: Graph, tmp_path: Any) -> None:
    from rosbags.highlevel import AnyReader

    turn = (0.5, 0.5, -0.5, 0.5)
    told = []
    for i in range(90):
        place = (0.1, -0.4, 4.0 - 0.015 * i)
        told.append(Transform(i / 30, "camera_optical_frame", "face_a1", place, turn))
        told.append(Transform(i / 30, "face_a1", "gaze_a1", rotation=turn))
    graph.others = {"/tf": [told_by("camera", TRANSFORMS)]}
    with AnyReader([write_bag(tmp_path, "mcap", told)]) as reader:
        messages = [(when, bytes(raw)) for _, when, raw in reader.messages()]
    clock = [messages[0][0] - 10**8]

    def now() -> int:
        clock[0] += 10**6
        return clock[0]

    node = Ros2Node(RclpyTransport(graph), load_model(), clock=now)
    running = node.run()
    while messages:
        while messages and messages[0][0] <= clock[0] + 10**8:
            graph.waiting.append(("/tf", messages.pop(0)[1]))
        next(running)
    for _ in range(10):
        next(running)
    topics = {topic for topic, _ in graph.published}
    assert "/humans/persons/anonymous_person_a1/engagement_status" in topics
    states = [message.data for topic, message in graph.published if topic == "/state"]
    assert len(states) > 10
    assert set(states) <= set("123456")
    running.close()
    assert graph.left


def test_bytes_that_are_no_message_are_left_out_and_said(graph: Graph) -> None:
    transport, heard = RclpyTransport(graph), []
    offer = Offer(STRING, reliable=True, latched=False)
    transport.subscribe("/state", offer, lambda _raw, message, _sent: heard.append(message.data))
    good = type_store().serialize_cdr(build(STRING, {"data": "4"}), STRING)
    for raw in (b"\0\1\0\0\3\0\0\0\xff\xfe\0\0", b"", bytes(good)):
        graph.waiting.append(("/state", raw))
        assert transport.spin(0.0) == 1
    assert heard == ["4"]
    assert transport.notes == [
        "Messages of /state do not fit std_msgs/msg/String as it is known here; they are left out."
    ]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_robot_is_told_to_stop_before_the_node_leaves(
    graph: Graph, number: int, tmp_path: Path
) -> None:
    (tmp_path / "drives.xml").write_text(DRIVING_TREE)
    graph.parameters = {"robot": "goal_pose", "tree": str(tmp_path / "drives.xml")}
    graph.others = {"/odom": [told_by("base", ODOMETRY)], "/faces": [told_by("camera", FACE)]}
    pose = {"position": {"x": 1.5}, "orientation": {"w": 1.0}}
    told, limit = 0, time.time_ns() + round(LIMIT * 1e9)

    def drives() -> bool:
        return any(topic == "/goal_pose" for topic, _ in graph.published)

    def tell(topic: str, kind: str, fields: Any) -> None:
        raw = type_store().serialize_cdr(build(kind, fields), kind)
        graph.waiting.append((topic, bytes(raw)))

    def after() -> None:
        nonlocal told
        now = time.time_ns()
        assert now < limit
        if drives():
            graph.after = lambda: None
            os.kill(os.getpid(), number)
        elif len(graph.readers) == 2 and now - told > 50_000_000:
            told = now
            odometry = header_fields(now, "odom")
            tell("/odom", ODOMETRY, {"header": odometry, "pose": {"pose": pose}})
            header = header_fields(now, "base_footprint")
            tell("/faces", FACE, {"header": header, "face": {"x": 4.0, "z": 1.6}})

    graph.after = after
    main()
    goals = [message.pose.position.x for topic, message in graph.published if topic == "/goal_pose"]
    assert (goals[0], goals[-1]) == (30.0, 1.5)
    assert graph.waits
    assert graph.left


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"robot": "hover"}, "there is no way to drive a robot 'hover'; valid: goal_pose, cmd_vel"),
        ({"robot": "cmd_vel", "leash": 2}, "the parameter leash is like -1.0 (2 is no float)"),
        ({"robot": "cmd_vel", "leash": math.nan}, "leash is a finite number of m"),
        ({"robot_face": [1.0]}, "robot_face is x, y and z in metres, not [1.0]"),
        ({"lateness": 0.0}, "lateness is more than 0, and at most 60 s, not 0"),
        (
            {"tree": "mine.xml"},
            "tree is for a robot that greets; set robot to goal_pose",
        ),
        ({"model": "nobody"}, "there is no model 'nobody'"),
        ({"record": f"{__file__}/x.mcap"}, "cannot be written"),
    ],
)
def test_wrong_parameters_are_one_sentence(
    graph: Graph, capsys: pytest.CaptureFixture[str], parameters: dict[str, Any], sentence: str
) -> None:
    graph.parameters = parameters
    with pytest.raises(SystemExit) as ended:
        main()
    said = capsys.readouterr().err
    assert (ended.value.code, said.count("\n"), said.startswith("kendon: ")) == (2, 1, True)
    assert sentence in said
    assert graph.left


def test_without_ros_it_is_said_what_is_missing(capsys: pytest.CaptureFixture[str]) -> None:
    if "rclpy" in sys.modules:
        pytest.skip("there is ROS here")
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith(
        "kendon: rclpy comes with ROS 2, and is not there: source its setup.bash"
    )

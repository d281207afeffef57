"""The transport of rclpy, with a stand-in for ROS: what it asks of it, and that it is the same."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from bag_files import Transform, write_bag

from kendon.errors import KendonError
from kendon.models import load_model
from kendon.ros.rclpy_node import RclpyTransport, main
from kendon.ros.ros2_node import Ros2Node
from kendon.ros.ros2_transport import Offer, Transport
from kendon.ros.ros2_types import STRING, TRANSFORMS, build, type_store


class Graph:
    """A node of rclpy whose graph is these lists."""

    def __init__(self) -> None:
        self.published: list[tuple[str, Any]] = []
        self.readers: dict[str, Callable[[bytes], None]] = {}
        self.others: dict[str, list[Any]] = {}
        self.waiting: list[tuple[str, bytes]] = []
        self.left = False

    def get_name(self) -> str:
        return "kendon"

    def get_logger(self) -> Any:
        return None

    def declare_parameter(self, name: str, value: Any) -> Any:
        return SimpleNamespace(value=value)

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [(topic, [infos[0].topic_type]) for topic, infos in self.others.items()]

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        return self.others.get(topic, [])

    def get_subscriptions_info_by_topic(self, topic: str) -> list[Any]:
        return [SimpleNamespace(node_name="base", topic_type=STRING)] if topic == "/state" else []

    def create_publisher(self, kind: Any, topic: str, qos: Any) -> Any:
        return SimpleNamespace(
            topic=topic, publish=lambda message: self.published.append((topic, message))
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

    policy = SimpleNamespace(RELIABLE=1, BEST_EFFORT=2, TRANSIENT_LOCAL=1, VOLATILE=2)
    module("rclpy", spin_once=spin_once)
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


def test_without_ros_it_is_said_what_is_missing() -> None:
    if "rclpy" in sys.modules:
        pytest.skip("there is ROS here")
    with pytest.raises(KendonError, match=r"rclpy comes with ROS 2.*setup.bash.*`kendon ros2`"):
        main()

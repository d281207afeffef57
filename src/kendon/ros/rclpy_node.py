"""kendon as a node of rclpy, for colcon workspaces: the same node as over DDS, carried by ROS.

``ros/kendon_ros2`` makes it an executable. rclpy comes with ROS, not from a package index; what
is needed of it is written down here as protocols.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from kendon.errors import KendonError, ParameterError, UnknownNameError
from kendon.geometry import Vec3
from kendon.models import DEFAULT_MODEL, GreetingModel, load_model
from kendon.phases import Phase
from kendon.ros.ros2_node import Ros2Node
from kendon.ros.ros2_record import Recorder
from kendon.ros.ros2_robot import Ros2Robot
from kendon.ros.ros2_settings import Drive, Ros2Settings, check_lateness
from kendon.ros.ros2_transport import Callback, Fields, Offer
from kendon.ros.stopping import Stopping
from kendon.sources.bag_people import BagOptions
from kendon.sources.live_people import PATIENCE
from kendon.trees import GreetingTree

#: What may be read; the graph of a big robot has hundreds of other topics.
_HEARD = ("/humans/", "/tf", "/tf_static", "/faces", "/odom")
#: A reader may take so long for the last message, which may be the robot's stop [s].
_LAST_WORD = 1.0


class EndpointInfo(Protocol):
    """``rclpy.topic_endpoint_info.TopicEndpointInfo``."""

    node_name: str
    topic_type: str
    qos_profile: Any


class RclpyNode(Protocol):
    """What is needed of ``rclpy.node.Node``."""

    def get_name(self) -> str:
        """Its name."""

    def get_logger(self) -> Any:
        """Its log."""

    def declare_parameter(self, name: str, value: Any) -> Any:
        """Declare a parameter with its default; returns it."""

    def resolve_topic_name(self, topic: str) -> str:
        """What a topic is called after remappings."""

    def get_topic_names_and_types(self) -> Iterable[tuple[str, Sequence[str]]]:
        """All topics of the graph."""

    def get_publishers_info_by_topic(self, topic: str) -> Iterable[EndpointInfo]:
        """Who publishes a topic."""

    def get_subscriptions_info_by_topic(self, topic: str) -> Iterable[EndpointInfo]:
        """Who reads a topic."""

    def create_publisher(self, kind: Any, topic: str, qos: Any) -> Any:
        """Publish a topic."""

    def destroy_publisher(self, publisher: Any) -> Any:
        """Publish it no more."""

    def create_subscription(
        self, kind: Any, topic: str, callback: Callable[[bytes], None], qos: Any, *, raw: bool
    ) -> Any:
        """Read a topic."""

    def destroy_subscription(self, subscription: Any) -> Any:
        """Read it no more."""

    def destroy_node(self) -> Any:
        """Leave the graph."""


class RclpyTransport:
    """`kendon.ros.ros2_transport.Transport` by rclpy.

    Args:
        node: carries the topics.
    """

    def __init__(self, node: RclpyNode) -> None:
        self.domain = int(os.environ.get("ROS_DOMAIN_ID") or 0)
        self.notes: list[str] = []
        self._node = node
        self._rclpy = _module("rclpy")
        self._qos = _module("rclpy.qos")
        self._bytes = _module("rclpy.serialization")
        self._get_message = _module("rosidl_runtime_py.utilities").get_message
        self._set_fields = _module("rosidl_runtime_py.set_message").set_message_fields
        self._publishers: dict[str, Any] = {}
        self._subscriptions: dict[tuple[str, Offer], Any] = {}
        self._count = 0  # of messages handed out

    def called(self, topic: str) -> str:
        """What a topic is called on the network, for people to read."""
        return self._node.resolve_topic_name(topic)

    def offers(self) -> dict[str, set[Offer]]:
        """What others publish at present, by topic: all the ways in which they do."""
        found: dict[str, set[Offer]] = {}
        for topic, _ in self._node.get_topic_names_and_types():
            if topic.startswith(_HEARD):
                for info in self._others(self._node.get_publishers_info_by_topic(topic)):
                    profile = info.qos_profile
                    reliable = profile.reliability == self._qos.ReliabilityPolicy.RELIABLE
                    latched = profile.durability == self._qos.DurabilityPolicy.TRANSIENT_LOCAL
                    offer = Offer(info.topic_type, reliable, latched)
                    found.setdefault(topic, set()).add(offer)
        return found

    def asked(self) -> dict[str, str]:
        """Those of this node's topics that others read at present, and their message types."""
        return {
            topic: info.topic_type
            for topic in self._publishers
            for info in self._others(self._node.get_subscriptions_info_by_topic(topic))
        }

    def subscribe(self, topic: str, offer: Offer, callback: Callback) -> None:
        """Read what is published on a topic in one way, or in one that offers more."""
        kind = self._get_message(offer.kind)

        def take(raw: bytes) -> None:
            self._count += 1
            try:
                message = self._bytes.deserialize_message(raw, kind)
            except Exception:  # whatever a middleware raises for bytes that are no message
                sentence = (
                    f"Messages of {self.called(topic)} do not fit {offer.kind} as it is known here;"
                    " they are left out."
                )
                if sentence not in self.notes:
                    self.notes.append(sentence)
                return
            callback(raw, message, 0)

        qos = self._profile(500, reliable=offer.reliable, latched=offer.latched)
        self._subscriptions[topic, offer] = self._node.create_subscription(
            kind, topic, take, qos, raw=True
        )

    def unsubscribe(self, topic: str, offer: Offer) -> None:
        """Stop reading a topic in that way."""
        self._node.destroy_subscription(self._subscriptions.pop((topic, offer)))

    def advertise(self, topic: str, kind: str, *, latched: bool = False) -> None:
        """Announce a topic, so that readers find it before the first message."""
        if topic not in self._publishers:
            qos = self._profile(1 if latched else 10, reliable=True, latched=latched)
            message = self._get_message(kind)
            self._publishers[topic] = self._node.create_publisher(message, topic, qos)

    def publish(self, topic: str, kind: str, fields: Fields) -> bytes:
        """Publish a message from its fields; returns its bytes."""
        self.advertise(topic, kind)
        message = self._get_message(kind)()
        self._set_fields(message, dict(fields))
        self._publishers[topic].publish(message)
        return bytes(self._bytes.serialize_message(message))

    def withdraw(self, topic: str) -> None:
        """Publish a topic no more."""
        if topic in self._publishers:
            self._node.destroy_publisher(self._publishers.pop(topic))

    def spin(self, seconds: float) -> int:
        """Wait for messages up to so long, and hand out one that came; returns how many."""
        before = self._count
        self._rclpy.spin_once(self._node, timeout_sec=seconds)
        return self._count - before

    def close(self) -> None:
        """Leave the graph when the last messages have been taken."""
        patience = _module("rclpy.duration").Duration(seconds=_LAST_WORD)
        for publisher in self._publishers.values():
            publisher.wait_for_all_acked(patience)
        self._node.destroy_node()

    def _others(self, infos: Iterable[EndpointInfo]) -> Iterable[EndpointInfo]:
        return (info for info in infos if info.node_name != self._node.get_name())

    def _profile(self, depth: int, *, reliable: bool, latched: bool) -> Any:
        qos = self._qos
        reliability, durability = qos.ReliabilityPolicy, qos.DurabilityPolicy
        return qos.QoSProfile(
            depth=depth,
            reliability=reliability.RELIABLE if reliable else reliability.BEST_EFFORT,
            durability=durability.TRANSIENT_LOCAL if latched else durability.VOLATILE,
        )


def main() -> None:
    """Run the node until it is interrupted; its parameters are the options of `kendon ros2`.

    A mistake of the user is one sentence and exit code 2.
    """
    try:
        _run()
    except KendonError as error:
        print(f"kendon: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:  # a second one, or before anything could move
        sys.exit(130)


class _Options(NamedTuple):
    """What the parameters say."""

    model: GreetingModel
    options: BagOptions
    face: Vec3
    lateness: float  # [s]
    record: str
    settings: Ros2Settings | None  # of the robot that is to greet
    tree: GreetingTree | None


def _options(handle: RclpyNode) -> _Options:
    """Declare the node's parameters.

    Raises:
        KendonError: one is not what it should be.
    """
    wrong_type = _module("rclpy.exceptions").ParameterException

    def told(name: str, default: Any) -> Any:
        try:
            return handle.declare_parameter(name, default).value
        except wrong_type as error:
            raise ParameterError(f"the parameter {name} is like {default!r} ({error})") from None

    face = list(told("robot_face", [0.0, 0.0, 1.2]))
    if len(face) != 3 or not all(map(math.isfinite, face)):
        raise ParameterError(f"robot_face is x, y and z in metres, not {face}")
    base, model, drive = told("base", ""), told("model", DEFAULT_MODEL), told("robot", "")
    for_robots = {"tree": told("tree", ""), "world": told("world", "")}
    leash = told("leash", -1.0)  # less than 0: none
    lateness, record = told("lateness", PATIENCE), told("record", "")
    check_lateness("lateness", lateness)
    if drive not in ("", *Drive):
        raise UnknownNameError("way to drive a robot", drive, Drive)
    for name, value in for_robots.items():
        if value and not drive:
            raise ParameterError(
                f"{name} is for a robot that greets; set robot to {' or '.join(Drive)}, too"
            )
    x, y, z = face
    settings = Ros2Settings(
        Drive(drive), world=for_robots["world"], face=(x, y, z),
        leash=None if leash < 0 else leash,
    ) if drive else None  # fmt: skip
    tree = GreetingTree(for_robots["tree"]) if for_robots["tree"] else None
    return _Options(
        load_model(model), BagOptions(base or None), (x, y, z), lateness, record, settings, tree
    )


def _run() -> None:
    rclpy = _module("rclpy")
    # ROS's own handlers take the network away at once: nobody could tell the robot to stop.
    no_handlers = _module("rclpy.signals").SignalHandlerOptions.NO
    rclpy.init(signal_handler_options=no_handlers)
    handle: RclpyNode = rclpy.create_node("kendon")
    transport: RclpyTransport | None = None
    try:
        chosen = _options(handle)
        recorder = Recorder(Path(chosen.record)) if chosen.record else None
        transport = RclpyTransport(handle)
        node = Ros2Node(
            transport, chosen.model, options=chosen.options, face=chosen.face, recorder=recorder,
            patience=chosen.lateness,
        )  # fmt: skip
        if chosen.settings is not None:
            robot = Ros2Robot(transport, node.place, chosen.settings, clock=time.time_ns)
            node.greet_with(robot, chosen.tree)
        with Stopping() as stop:
            _follow(node, handle.get_logger(), stop)
    finally:
        if transport is None:  # else the node has left with it
            handle.destroy_node()
        rclpy.try_shutdown()


def _follow(node: Ros2Node, log: Any, stop: Stopping) -> None:
    """Run the node until it is interrupted, and tell what it does."""
    seen: set[str] = set()
    phases: dict[str, Phase] = {}
    with contextlib.closing(node.run()) as steps:
        for people, _ in steps:
            for one in people:
                if one.belief and phases.get(one.name) is not one.belief.phase:
                    phases[one.name] = one.belief.phase
                    log.info(f"{one.name}: {one.belief.phase.name} {one.belief.phase.title}")
            for note in node.notes:
                if note not in seen:
                    seen.add(note)
                    log.warning(note)
            if stop.asked:
                break


def _module(name: str) -> Any:
    """A module of ROS 2's Python.

    Raises:
        KendonError: it is not there.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise KendonError(
            f"{name} comes with ROS 2, and is not there: source its setup.bash; without ROS there"
            " is `kendon ros2`"
        ) from error

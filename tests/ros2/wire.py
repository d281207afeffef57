"""A transport within this process, whose time passes only while it is spun."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from ros2_peers import ODOMETRY, stamp

from kendon.ros.ros2_robot import POINT, TWIST
from kendon.ros.ros2_transport import Callback, Fields, Offer
from kendon.ros.ros2_types import FACE, STRING, build, header_fields, type_store

STEP = 50_000_000  # [ns], of the world at the other end


class Wire:
    """Carries topics between a node and a world.

    Args:
        world: lives on by a step; given the time [ns].
    """

    def __init__(self, world: Callable[[int], None] = lambda _: None) -> None:
        self.domain = 0
        self.notes: list[str] = []
        self.now = 1_700_000_000 * 10**9  # [ns]
        self.world = world
        self.told: list[tuple[str, Any]] = []  # topic and message, by the node
        self.waiting: list[tuple[str, int, bytes, Any]] = []  # to the node
        self.offered: dict[str, set[Offer]] = {}
        self.readers: dict[str, str] = {}
        self.closed = False
        self.renamed: set[str] = set()
        self._callbacks: dict[str, Callback] = {}

    def clock(self) -> int:
        return self.now

    def tell(self, topic: str, kind: str, fields: Fields) -> None:
        """The world publishes a message, and is known to."""
        self.offered.setdefault(topic, {Offer(kind, True, False)})
        message = build(kind, fields)
        raw = bytes(type_store().serialize_cdr(message, kind))
        self.waiting.append((topic, self.now, raw, message))

    def heard(self, topic: str) -> list[Any]:
        """What the node has told on a topic."""
        return [message for name, message in self.told if name == topic]

    def called(self, topic: str) -> str:
        return f"/renamed{topic}" if topic in self.renamed else topic

    def offers(self) -> dict[str, set[Offer]]:
        return dict(self.offered)

    def asked(self) -> dict[str, str]:
        return dict(self.readers)

    def subscribe(self, topic: str, offer: Offer, callback: Callback) -> None:
        self._callbacks[topic] = callback

    def unsubscribe(self, topic: str, offer: Offer) -> None:
        del self._callbacks[topic]

    def advertise(self, topic: str, kind: str, *, latched: bool = False) -> None:
        pass

    def publish(self, topic: str, kind: str, fields: Fields) -> bytes:
        message = build(kind, fields)
        self.told.append((topic, message))
        return bytes(type_store().serialize_cdr(message, kind))

    def withdraw(self, topic: str) -> None:
        pass

    def spin(self, seconds: float) -> int:
        end = self.now + round(seconds * 1e9)
        while not self.waiting and self.now < end:
            due = (self.now // STEP + 1) * STEP
            self.now = min(due, end)
            if self.now == due:
                self.world(due)
        came, self.waiting = self.waiting, []
        for topic, sent, raw, message in came:
            if topic in self._callbacks:
                self._callbacks[topic](raw, message, sent)
        return len(came)

    def close(self) -> None:
        self.closed = True


class World:
    """Somebody before a base that drives by /cmd_vel, in `Wire`'s time."""

    def __init__(self) -> None:
        self.wire = Wire(self.step)
        self.person = True  # whether the camera sees them
        self.base = True  # whether the base is there
        self.x = 0.0  # [m], of the base

    @property
    def speed(self) -> float:
        """What the base was last told [m/s]."""
        speeds = self.wire.heard("/cmd_vel")
        return float(speeds[-1].linear.x) if speeds else 0.0

    def step(self, now: int) -> None:
        wire = self.wire
        wire.readers = {}
        wire.offered = {}
        if self.base:
            self.x += self.speed * STEP * 1e-9
            pose = {"position": {"x": self.x}, "orientation": {"w": 1.0}}
            header = {"stamp": stamp(now * 1e-9), "frame_id": "odom"}
            wire.tell("/odom", ODOMETRY, {"header": header, "pose": {"pose": pose}})
            texts = dict.fromkeys(("/gesture", "/say", "/expression"), STRING)
            wire.readers = {"/cmd_vel": TWIST, "/look_at": POINT, **texts}
        if self.person:
            face = {
                "header": header_fields(now, "base_footprint"),
                "face": {"x": 9.0 - self.x, "z": 1.6},
                "face_rotation": {"z": np.pi},
                "face_id": "7",
            }
            wire.tell("/faces", FACE, face)

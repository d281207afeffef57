"""What kendon needs of ROS 2, whoever carries it: DDS itself, or rclpy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from typing import Any, NamedTuple, Protocol

#: What a message is made from: values by field names, messages within it likewise.
Fields = Mapping[str, Any]
#: Takes a message as it came (CDR), as an object with the fields of its type, and when it was sent
#: by its sender's clock, 0 = unknown [ns].
Callback = Callable[[bytes, Any, int], None]


class Offer(NamedTuple):
    """One way in which a topic is published."""

    kind: str  # the message type, such as std_msgs/msg/String
    reliable: bool
    latched: bool  # whether late readers get the last messages (transient local)


class Transport(Protocol):
    """Publishes and reads topics; callbacks are called in `spin`, in the thread that calls it."""

    @property
    def domain(self) -> int:
        """DDS's number of the network of nodes, ROS_DOMAIN_ID."""

    @property
    def notes(self) -> Sequence[str]:
        """What a user should know of what could not be read, one sentence each."""

    def called(self, topic: str) -> str:
        """What a topic is called on the network, for people to read."""

    def offers(self) -> Mapping[str, Set[Offer]]:
        """What others publish at present, by topic: all the ways in which they do."""

    def asked(self) -> Mapping[str, str]:
        """The topics that others read at present, and as what message type."""

    def subscribe(self, topic: str, offer: Offer, callback: Callback) -> None:
        """Read what is published on a topic in one way, or in one that offers more."""

    def unsubscribe(self, topic: str, offer: Offer) -> None:
        """Stop reading a topic in that way."""

    def advertise(self, topic: str, kind: str, *, latched: bool = False) -> None:
        """Announce a topic, so that readers find it before the first message."""

    def publish(self, topic: str, kind: str, fields: Fields) -> bytes:
        """Publish a message from its fields; returns it as it went over the wire.

        Raises:
            KendonError: it cannot be published.
        """

    def withdraw(self, topic: str) -> None:
        """Publish a topic no more."""

    def spin(self, seconds: float) -> int:
        """Wait for messages up to so long, and hand out those that came; returns how many.

        None at all means that all that had come when it was called has been handed out.
        """

    def close(self) -> None:
        """Leave; others see at once that this node is gone."""

"""Topics of ROS 2 over DDS without ROS: Eclipse Cyclone DDS carries them, rosbags is the codec.

ROS 2's middleware layer names a topic ``rt/<name>`` and a type ``<package>::msg::dds_::<Name>_``.
Who publishes what is learnt by DDS's own discovery, and a reader asks for what the writer offers.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from kendon.errors import KendonError, MissingExtraError, ParameterError
from kendon.ros.dds_types import ros_name, sample_type, wrapped
from kendon.ros.ros2_transport import Callback, Fields, Offer
from kendon.ros.ros2_types import build, prepare_codec, type_store

#: The domains whose ports exist on every system (DDSI-RTPS 9.6.1: 7400 + 250 d < 65536).
DOMAINS = range(233)
#: What ROS 2 keeps for a slow reader (rmw_qos_profile_default).
DEPTH = 10
#: What tf2_ros keeps, of its own broadcasters' messages.
DEPTHS = {"/tf": 100, "/tf_static": 1}
#: Transforms of some seconds, at any rate that there is.
READ_DEPTH = 2000
#: So long one slow reader may hold up a message to all [s].
_BLOCKS = 0.05


class _Reader(NamedTuple):
    reader: Any
    unread: Any  # Cyclone's condition that something can be read
    callback: Callback


class DdsNode:
    """Publishes and reads topics on a domain.

    Everything happens in `spin`, in the thread that calls it.

    Args:
        domain: DDS's number of the network of nodes, ROS_DOMAIN_ID.
        names: what topics are called on the network, where that is not what they are called here.

    Raises:
        MissingExtraError: cyclonedds or rosbags is not installed.
        ParameterError: there is no such domain.
        KendonError: DDS does not start, for example for want of a network.
    """

    def __init__(self, domain: int = 0, names: Mapping[str, str] | None = None) -> None:
        if domain not in DOMAINS:
            raise ParameterError(f"DDS's domains are 0 to {DOMAINS[-1]}, not {domain}")
        try:
            from cyclonedds import builtin, core, domain as domains  # isort: skip
        except ImportError as error:
            raise MissingExtraError("ROS 2 over DDS", "ros2", "cyclonedds") from error
        type_store()
        self.domain = domain
        self._names = names or {}
        self._inner = {other: name for name, other in self._names.items()}
        self.notes: list[str] = []  # what a user should know, one sentence each
        self.lost = 0  # messages that DDS knows to have been sent, but could not get
        try:
            self._participant = domains.DomainParticipant(domain)
            self._discovery = builtin.BuiltinDataReader(
                self._participant, builtin.BuiltinTopicDcpsPublication
            )
            self._readers_about = builtin.BuiltinDataReader(
                self._participant, builtin.BuiltinTopicDcpsSubscription
            )
        except core.DDSException as error:
            raise KendonError(
                f"DDS does not start on domain {domain} ({_one_line(error)}); is there a network,"
                " and is CYCLONEDDS_URI right?"
            ) from None
        self._wait = core.WaitSet(self._participant)
        self._alive = core.InstanceState.Alive
        self._offers: dict[str, dict[Any, Offer]] = {}
        self._asked: dict[str, dict[Any, str]] = {}
        self._topics: dict[str, Any] = {}
        self._writers: dict[str, tuple[Any, str]] = {}
        self._readers: dict[tuple[str, Offer], _Reader] = {}

    def called(self, topic: str) -> str:
        """What a topic is called on the network, for people to read."""
        return self._names.get(topic, topic)

    def offers(self) -> dict[str, set[Offer]]:
        """What others publish at present, by topic: all the ways in which they do."""
        self._discover(self._discovery, self._note_offer, self._offers)
        self._count_lost()
        return {topic: set(found.values()) for topic, found in self._offers.items()}

    def asked(self) -> dict[str, str]:
        """The topics that others read at present, and as what message type."""

        def note(sample: Any) -> None:
            kind = ros_name(sample.type_name)
            self._asked.setdefault(self._known_as(sample), {})[sample.key] = kind

        self._discover(self._readers_about, note, self._asked)
        return {topic: next(iter(found.values())) for topic, found in self._asked.items()}

    def subscribe(self, topic: str, offer: Offer, callback: Callback) -> None:
        """Read what is published on a topic in one way, or in one that offers more.

        `callback` is given its messages in `spin`.
        """
        from cyclonedds.core import ReadCondition, SampleState
        from cyclonedds.sub import DataReader

        qos = _qos(reliable=offer.reliable, latched=offer.latched, depth=READ_DEPTH)
        reader: Any = DataReader(self._participant, self._topic(topic, offer.kind), qos=qos)
        unread = ReadCondition(reader, SampleState.NotRead)
        self._wait.attach(unread)
        self._readers[topic, offer] = _Reader(reader, unread, callback)

    def unsubscribe(self, topic: str, offer: Offer) -> None:
        """Stop reading a topic in that way."""
        # DDS closes what nobody refers to.
        self._wait.detach(self._readers.pop((topic, offer)).unread)
        self._release(topic)

    def advertise(self, topic: str, kind: str, *, latched: bool = False) -> None:
        """Announce a topic, so that readers find it before the first message."""
        from cyclonedds.pub import DataWriter

        if topic not in self._writers:
            qos = _qos(reliable=True, latched=latched, depth=DEPTHS.get(topic, DEPTH))
            writer = DataWriter(self._participant, self._topic(topic, kind), qos=qos)
            self._writers[topic] = writer, kind

    def publish(self, topic: str, kind: str, fields: Fields) -> bytes:
        """Publish a message from its fields; returns it as it went over the wire."""
        raw = bytes(type_store().serialize_cdr(build(kind, fields), kind))
        self.publish_raw(topic, kind, raw)
        return raw

    def publish_raw(self, topic: str, kind: str, raw: bytes) -> None:
        """Publish a message that is bytes already (CDR, with its header).

        Raises:
            KendonError: it is no message of its type, or a reader holds everything up.
        """
        from cyclonedds.core import DDSException

        self.advertise(topic, kind)
        writer, _ = self._writers[topic]
        try:
            writer.write(wrapped(self._topics[topic].data_type, raw))
        except DDSException as error:
            raise KendonError(
                f"{self.called(topic)} cannot be published ({_one_line(error)})"
            ) from None

    def withdraw(self, topic: str) -> None:
        """Publish a topic no more."""
        self._writers.pop(topic, None)
        self._release(topic)

    def spin(self, seconds: float) -> int:
        """Wait for messages up to so long, and hand out those that came; returns how many."""
        from cyclonedds.util import duration

        if self._readers:
            self._wait.wait(duration(seconds=max(seconds, 1e-6)))
        else:
            time.sleep(seconds)
        came = []
        for way, one in self._readers.items():
            samples = one.reader.take(N=READ_DEPTH)
            if len(samples) == READ_DEPTH:
                self._note(
                    f"Messages of {self.called(way[0])} come faster than they can be read: some are"
                    " lost."
                )
            came += [
                (sample.sample_info.source_timestamp, way, sample.raw)
                for sample in samples
                if sample.sample_info.valid_data
            ]
        # Of what has come since the last time, on whatever topics, first what was sent first.
        came.sort(key=lambda sample: sample[0])
        store = type_store()
        for sent, way, raw in came:
            if way not in self._readers:
                continue
            topic, (kind, *_) = way
            try:
                message = store.deserialize_cdr(raw, kind)
            except Exception:  # a text that is no UTF-8, for one
                self._note_misfit(topic, kind)
                continue
            self._readers[way].callback(raw, message, sent)
        return len(came)

    def close(self) -> None:
        """Leave the domain; others see at once that this node is gone."""
        for topic, offer in list(self._readers):
            self.unsubscribe(topic, offer)
        self._writers.clear()
        self._topics.clear()
        del self._wait, self._discovery, self._readers_about, self._participant

    def _note_misfit(self, topic: str, kind: str) -> None:
        self._note(
            f"Messages of {self.called(topic)} do not fit {kind} as it is known here; they are left"
            " out."
        )

    def _count_lost(self) -> None:
        for (topic, _), one in self._readers.items():
            status = one.reader.get_sample_lost_status()
            if status is not None and status.total_count_change:
                self.lost += status.total_count_change
                self._note(
                    f"Messages of {self.called(topic)} are lost on the way: too much for this"
                    " computer?"
                )

    def _note(self, sentence: str) -> None:
        if sentence not in self.notes:
            self.notes.append(sentence)

    def _discover(self, reader: Any, note: Callable[[Any], None], known: dict[str, Any]) -> None:
        from cyclonedds.core import DDSException

        mine = self._participant.guid
        while True:
            try:
                samples = reader.take(N=100)
            except DDSException:
                return
            for sample in samples:
                if sample.sample_info.instance_state != self._alive:
                    for topic in [topic for topic, found in known.items() if sample.key in found]:
                        del known[topic][sample.key]
                        if not known[topic]:
                            del known[topic]
                elif sample.topic_name.startswith("rt/") and sample.participant_key != mine:
                    note(sample)
            if len(samples) < 100:
                return

    def _note_offer(self, sample: Any) -> None:
        from cyclonedds.qos import Policy

        kind = ros_name(sample.type_name)
        reliability = sample.qos[Policy.Reliability]
        durability = sample.qos[Policy.Durability]
        offer = Offer(
            kind,
            reliability is not None and reliability != Policy.Reliability.BestEffort,
            durability is not None and durability != Policy.Durability.Volatile,
        )
        self._offers.setdefault(self._known_as(sample), {})[sample.key] = offer

    def _known_as(self, sample: Any) -> str:
        """The name here of a topic of the network, where another one may be called so."""
        name = sample.topic_name[2:]
        return self._inner.get(name, f"{name} (not used)" if name in self._names else name)

    def _release(self, topic: str) -> None:
        if topic not in self._writers and all(topic != read for read, _ in self._readers):
            self._topics.pop(topic, None)

    def _topic(self, name: str, kind: str) -> Any:
        from cyclonedds.topic import Topic

        if name not in self._topics:
            self._topics[name] = Topic(
                self._participant, f"rt{self.called(name)}", sample_type(kind)
            )
            prepare_codec(kind)
        return self._topics[name]


def _qos(*, reliable: bool, latched: bool, depth: int) -> Any:
    from cyclonedds.qos import Policy, Qos
    from cyclonedds.util import duration

    patience = duration(seconds=_BLOCKS)
    reliability = Policy.Reliability
    durability = Policy.Durability
    return Qos(
        reliability.Reliable(patience) if reliable else reliability.BestEffort,
        durability.TransientLocal if latched else durability.Volatile,
        Policy.History.KeepLast(depth),
    )


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()).rstrip(".")[:150]

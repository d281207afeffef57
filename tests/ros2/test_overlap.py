"""Topics that are published in several ways at once: nothing is lost, nothing comes twice."""

from __future__ import annotations

from collections import Counter
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("cyclonedds", reason="the extra 'ros2' is not installed")
pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from ros2_peers import LIMIT, LOOPBACK, free_domain

from kendon.models import load_model
from kendon.ros.dds import DdsNode
from kendon.ros.dds_types import sample_type, wrapped
from kendon.ros.overlap import Overlap
from kendon.ros.ros2_node import Ros2Node
from kendon.ros.ros2_record import Recorder
from kendon.ros.ros2_types import TRANSFORMS, build, type_store
from kendon.sources.ros_bags import read_messages

WAYS = list(product((False, True), (False, True)))  # reliable, latched


@given(st.lists(st.tuples(st.sampled_from(WAYS), st.integers(0, 3)), max_size=40), st.randoms())
def test_each_message_is_new_once_however_the_ways_interleave(sent: Any, random: Any) -> None:
    """Every reader hears the writers that offer at least its own way, each in order."""
    queues = {
        way: [m for writer, m in sent if writer[0] >= way[0] and writer[1] >= way[1]]
        for way in WAYS
    }
    overlap, handed = Overlap(), Counter[int]()
    while any(queues.values()):
        way = random.choice([way for way, queue in queues.items() if queue])
        message = queues[way].pop(0)
        handed[message] += overlap.is_new(way, bytes([message]))
    assert handed == Counter(m for _, m in sent)


class Writer:
    """A publisher of transforms in one way, which numbers them."""

    def __init__(self, participant: Any, topic: str, *, reliable: bool, latched: bool) -> None:
        from cyclonedds.pub import DataWriter
        from cyclonedds.qos import Policy, Qos
        from cyclonedds.topic import Topic
        from cyclonedds.util import duration

        reliability, durability = Policy.Reliability, Policy.Durability
        qos = Qos(
            reliability.Reliable(duration(seconds=1)) if reliable else reliability.BestEffort,
            durability.TransientLocal if latched else durability.Volatile,
            Policy.History.KeepLast(10),
        )
        named = Topic(participant, f"rt{topic}", sample_type(TRANSFORMS))
        self.writer = DataWriter(participant, named, qos=qos)
        self.name = f"{topic[1:]}_{reliable:d}{latched:d}"
        self.made = named.data_type
        self.sent: list[str] = []

    def write(self) -> None:
        self.sent.append(f"{self.name}_{len(self.sent)}")
        told = {"header": {"frame_id": "rig"}, "child_frame_id": self.sent[-1]}
        raw = type_store().serialize_cdr(build(TRANSFORMS, {"transforms": [told]}), TRANSFORMS)
        self.writer.write(wrapped(self.made, bytes(raw)))


def test_transforms_published_in_several_ways_are_all_heard_once(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from cyclonedds.domain import DomainParticipant

    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK)
    domain = free_domain() + 4
    participant = DomainParticipant(domain)
    writers = [
        Writer(participant, topic, reliable=reliable, latched=latched)
        for topic in ("/tf", "/tf_static")
        for reliable, latched in WAYS
    ]
    latched = [writer for writer in writers if writer.name.endswith("11")]
    for writer in latched:  # before anybody listens
        writer.write()
    recorder = Recorder(tmp_path / "heard.mcap")
    node = Ros2Node(DdsNode(domain), load_model(), recorder=recorder)
    running = node.run()
    steps = range(round(LIMIT / 0.1))
    # A reader of its own way, and those that ask for less.
    readers = {"00": 1, "01": 2, "10": 2, "11": 4}
    for _ in steps:
        next(running)
        if all(len(w.writer.get_matched_subscriptions()) == readers[w.name[-2:]] for w in writers):
            break
    for _ in range(5):
        for writer in writers:
            writer.write()
        next(running)
    count = sum(len(writer.sent) for writer in writers)
    for _ in steps:
        if recorder.count >= count:
            break
        next(running)
    for _ in range(3):  # whatever might come twice
        next(running)
    running.close()
    heard = Counter(
        message.transforms[0].child_frame_id
        for _, _, message in read_messages(tmp_path / "heard.mcap", lambda t: t.startswith("/tf"))
    )
    assert heard == dict.fromkeys((name for writer in writers for name in writer.sent), 1)

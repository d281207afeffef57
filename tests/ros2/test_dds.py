"""Topics between two nodes on DDS: what is offered is asked for, what does not fit is left out."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("cyclonedds", reason="the extra 'ros2' is not installed")
pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from ros2_peers import LOOPBACK, free_domain, until

from kendon.errors import KendonError, MissingExtraError, ParameterError
from kendon.ros.dds import DdsNode
from kendon.ros.dds_types import dds_name, ros_name
from kendon.ros.ros2_transport import Offer
from kendon.ros.ros2_types import BELIEF, STRING, build, type_store


@pytest.fixture
def nodes(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[DdsNode, DdsNode]]:
    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK)
    pair = DdsNode(free_domain() + 2), DdsNode(free_domain() + 2)
    yield pair
    for node in pair:
        node.close()


def read(node: DdsNode, topic: str) -> list[Any]:
    """What a node hears on a topic, which it reads as it is offered."""
    heard: list[Any] = []
    until(node, lambda: topic in node.offers())
    (offer,) = node.offers()[topic]
    node.subscribe(topic, offer, lambda _raw, message, _sent: heard.append(message))
    return heard


def test_messages_come_in_order_and_whole(nodes: tuple[DdsNode, DdsNode]) -> None:
    mine, other = nodes
    other.advertise("/state", STRING)
    heard = read(mine, "/state")
    until(mine, lambda: "/state" in other.asked())
    for number in range(200):
        other.publish("/state", STRING, {"data": f"nº {number}"})
        mine.spin(0.001)
    until(mine, lambda: len(heard) == 200)
    assert [message.data for message in heard] == [f"nº {number}" for number in range(200)]
    assert other.asked() == {"/state": STRING}


def test_who_comes_late_hears_what_is_latched(nodes: tuple[DdsNode, DdsNode]) -> None:
    mine, other = nodes
    other.advertise("/tf_static", STRING, latched=True)
    other.publish("/tf_static", STRING, {"data": "still here"})
    heard = read(mine, "/tf_static")
    assert mine.offers()["/tf_static"] == {Offer(STRING, True, True)}
    until(mine, lambda: heard)
    assert heard[0].data == "still here"


def test_a_node_that_has_left_offers_nothing(nodes: tuple[DdsNode, DdsNode]) -> None:
    mine, other = nodes
    other.advertise("/state", STRING)
    until(mine, lambda: "/state" in mine.offers())
    other.withdraw("/state")
    until(mine, lambda: "/state" not in mine.offers())
    other.withdraw("/state")  # nothing to do


def test_topics_may_have_another_name_on_the_network(nodes: tuple[DdsNode, DdsNode]) -> None:
    mine, other = nodes
    renamed = DdsNode(mine.domain, {"/state": "/greeter/state", "/odom": "/base/odom"})
    other.advertise("/base/odom", STRING)
    other.advertise("/odom", STRING)
    heard = read(renamed, "/odom")
    renamed.advertise("/state", STRING)
    until(mine, lambda: "/greeter/state" in mine.offers())
    until(mine, lambda: "/base/odom" in other.asked())
    other.publish("/odom", STRING, {"data": "another robot's"})
    other.publish("/base/odom", STRING, {"data": "this robot's"})
    until(renamed, lambda: heard)
    assert [message.data for message in heard] == ["this robot's"]
    assert mine.offers().keys() == {"/greeter/state", "/base/odom", "/odom"}
    renamed.close()


def test_a_text_that_is_none_is_left_out_and_said(nodes: tuple[DdsNode, DdsNode]) -> None:
    mine, other = nodes
    other.advertise("/state", STRING)
    heard = read(mine, "/state")
    until(mine, lambda: "/state" in other.asked())
    other.publish_raw("/state", STRING, b"\0\1\0\0\3\0\0\0\xff\xfe\0\0")
    other.publish("/state", STRING, {"data": "4"})
    until(mine, lambda: heard)
    assert [message.data for message in heard] == ["4"]
    assert mine.notes == [
        "Messages of /state do not fit std_msgs/msg/String as it is known here; they are left out."
    ]


def test_bytes_of_another_message_are_not_published(nodes: tuple[DdsNode, DdsNode]) -> None:
    text = bytes(type_store().serialize_cdr(build(STRING, {"data": "x" * 90}), STRING))
    with pytest.raises(KendonError, match="/belief cannot be published"):
        nodes[0].publish_raw("/belief", BELIEF, text)


def test_there_are_only_so_many_domains() -> None:
    for bad in (-1, 233):
        with pytest.raises(ParameterError, match=f"0 to 232, not {bad}"):
            DdsNode(bad)


def test_a_wrong_configuration_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK.replace('"lo"', '"no_such_interface"'))
    with pytest.raises(KendonError, match=r"DDS does not start on domain .* CYCLONEDDS_URI"):
        DdsNode(free_domain() + 3)


def test_without_cyclone_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    with pytest.raises(MissingExtraError, match=r"'cyclonedds'.*pip install 'kendon\[ros2\]'"):
        DdsNode(0)


@pytest.mark.parametrize("kind", [STRING, BELIEF])
def test_names_on_the_wire_go_there_and_back(kind: str) -> None:
    assert ros_name(dds_name(kind)) == kind
    assert ros_name("some::other::Type") == "some::other::Type"

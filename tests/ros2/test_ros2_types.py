"""Messages as bytes: rosbags and Cyclone DDS, two codecs by two authors, write the same."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="the extra 'ros2' is not installed")
pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.interfaces import Nodetype

from kendon.errors import DataError, ParameterError
from kendon.ros.dds_types import idl_struct, sample_type
from kendon.ros.ros2_node import KINDS
from kendon.ros.ros2_robot import POINT, POSE, TWIST, TWIST_STAMPED
from kendon.ros.ros2_types import BELIEF, ENGAGEMENT, FACE, OBSERVATION, STRING, build, type_store

EXCHANGED = sorted(
    {*KINDS.values(), BELIEF, ENGAGEMENT, FACE, OBSERVATION, STRING, POSE, POINT, TWIST}
    | {TWIST_STAMPED, "hri_msgs/msg/FacialActionUnits", "hri_msgs/msg/IdsList"}
)


def random_fields(kind: str, draw: np.random.Generator) -> dict[str, Any]:
    """Values for all fields of a message."""
    return {name: _random(field, draw) for name, field in type_store().fielddefs[kind][1]}


def _random(field: Any, draw: np.random.Generator) -> Any:
    node, inner = field
    if node == Nodetype.NAME:
        return random_fields(inner, draw)
    if node == Nodetype.BASE:
        word = inner[0]
        if word == "string":
            return "".join(chr(c) for c in draw.integers(32, 500, draw.integers(0, 9)).tolist())
        if word == "bool":
            return bool(draw.integers(2))
        if word.startswith("float"):
            return float(np.dtype(word).type(draw.normal()))
        limits = np.iinfo(word)
        return int(draw.integers(limits.min, limits.max))
    part, length = inner
    length = length if node == Nodetype.ARRAY else int(draw.integers(0, 5))
    return [_random(part, draw) for _ in range(length)]


def as_idl(message: Any, kind: Any) -> Any:
    """The same message as an object of Cyclone's."""
    values = {}
    for one in dataclasses.fields(kind):
        value = getattr(message, one.name)
        values[one.name] = _as_idl(value)
    return kind(**values)


def _as_idl(value: Any) -> Any:
    if hasattr(value, "__msgtype__"):
        return as_idl(value, idl_struct(value.__msgtype__))
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [_as_idl(one) for one in value] if isinstance(value, list) else value


@pytest.mark.parametrize("kind", EXCHANGED)
@given(seed=st.integers(0, 2**32))
@settings(max_examples=10, deadline=None)
def test_both_codecs_write_the_same_bytes(kind: str, seed: int) -> None:
    fields = random_fields(kind, np.random.default_rng(seed))
    message = build(kind, fields)
    mine = bytes(type_store().serialize_cdr(message, kind))
    theirs = as_idl(message, idl_struct(kind)).serialize(use_version_2=False)
    assert mine.ljust(len(theirs), b"\0") == theirs.ljust(len(mine), b"\0")
    back = type_store().deserialize_cdr(mine, kind)
    assert bytes(type_store().serialize_cdr(back, kind)) == mine


def test_a_belief_is_the_bytes_that_the_standard_says() -> None:
    raw = type_store().serialize_cdr(
        build(BELIEF, {"header": {"frame_id": "ab"}, "phase": 4, "probabilities": [0.5] * 6}),
        BELIEF,
    )
    half = b"\0\0\0\0\0\0\xe0\x3f"
    # Little endian; stamp; the text with its length and end; a byte; six doubles, aligned to 8.
    expected = b"\0\1\0\0" + bytes(8) + b"\3\0\0\0ab\0" + b"\4" + half * 6
    assert bytes(raw) == expected


def test_what_is_left_out_is_empty() -> None:
    face = build(FACE, {"face": {"x": 1.0}})
    assert (face.face.x, face.face.y, face.face_id, face.gestures_given) == (1.0, 0.0, "", False)
    assert len(face.left_eye_borders) == 2
    assert face.joints == []
    assert face.action_units.tolist() == [0.0, 0.0]


def test_mistakes_are_named() -> None:
    with pytest.raises(ParameterError, match="no field 'fase'; valid: header, phase"):
        build(BELIEF, {"fase": 1})
    with pytest.raises(DataError, match="no_msgs/msg/X are not known"):
        sample_type("no_msgs/msg/X")

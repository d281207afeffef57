"""Everybody's phases from messages, without a transport."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")

from kendon.features import Sampler
from kendon.models import Belief, load_model
from kendon.observations import Observation
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.ros.ros2_reading import Engagement, PeopleReader, Told, engagement
from kendon.ros.ros2_record import Recorder
from kendon.ros.ros2_types import FACE, STRING, TRANSFORMS, build, header_fields, type_store
from kendon.sources.ros_bags import read_messages

SECOND = 10**9
EPOCH = 1_700_000_000 * SECOND


def face(t: float, x: float, *, name: str = "", frame: str = "base_footprint") -> Any:
    """A FaceExtraction of somebody ahead who looks at the robot."""
    return build(
        FACE,
        {
            "header": header_fields(EPOCH + round(t * SECOND), frame),
            "face": {"x": x, "z": 1.6},
            "face_rotation": {"z": math.pi},
            "face_id": name,
        },
    )


def hear(reader: PeopleReader, t: float, message: Any) -> list[Told]:
    return reader.hear("/faces", message, EPOCH + round(t * SECOND))


def belief(phase: Phase) -> Belief:
    return Belief(np.eye(6)[phase.value - 1])


def test_faces_give_the_beliefs_of_their_frames() -> None:
    model = load_model()
    reader, sampler, tracker = PeopleReader(model), Sampler(), model.tracker()
    told: list[Told] = []
    expected: list[Belief] = []
    for i in range(120):
        t, x = i / 30, 4.0 - i / 60
        told += hear(reader, t, face(t, x))
        frame = PersonFrame(t, (x, 0.0, 1.6), (0.0, 0.0, 1.0, 0.0), smile=0.0)
        expected += [tracker.step(o) for o in sampler.push(frame)]
    assert [one.name for one in told] == ["anonymous_person_face"] * len(expected)
    assert [one.stamp for one in told] == [
        EPOCH + round(0.2 * i * SECOND) for i in range(1, len(told) + 1)
    ]
    for one, other in zip(told, expected, strict=True):
        assert one.belief is not None
        # Stamps since 1970 are rounded to a fifth of a microsecond, which speeds show.
        assert one.belief.probabilities == pytest.approx(other.probabilities, abs=1e-5)


def test_several_faces_are_told_apart_and_the_first_is_followed() -> None:
    reader = PeopleReader(load_model())
    told: list[Told] = []
    for i in range(60):
        told += hear(reader, i / 30, face(i / 30, 3.0, name="a"))
        told += hear(reader, i / 30, face(i / 30, 2.0, name="b"))
    ways: dict[str, set[float]] = {}
    for one in told:
        assert one.observation is not None
        ways.setdefault(one.name, set()).add(one.observation.distance)
    assert ways == {"anonymous_person_a": {3.0}, "anonymous_person_b": {2.0}}
    assert reader.followed == "anonymous_person_a"
    assert reader.late == 0


def test_who_is_not_told_of_any_more_is_unknown_for_five_seconds_and_then_gone() -> None:
    reader = PeopleReader(load_model())
    for i in range(60):
        hear(reader, i / 30, face(i / 30, 3.0))
    told = reader.pass_time(EPOCH + 9 * SECOND)
    assert told[-1].observation is None
    assert told[-1].engagement is Engagement.UNKNOWN
    unknown = [one.observation for one in told[:-1] if one.observation]
    assert len(unknown) == pytest.approx(25, abs=2)
    assert all(math.isnan(o.distance) for o in unknown[2:])
    assert reader.followed is None
    assert reader.pass_time(EPOCH + 12 * SECOND) == []


def test_late_faces_are_left_out_and_counted() -> None:
    reader = PeopleReader(load_model())
    for t, came in ((0.0, 0.0), (0.1, 0.1), (0.05, 0.12), (0.2, 0.2)):
        hear(reader, came, face(t, 3.0))
    assert (reader.frames, reader.late) == (3, 1)


def test_a_face_in_another_frame_is_left_out_and_said() -> None:
    reader = PeopleReader(load_model())
    for i in range(3):
        assert hear(reader, i / 30, face(i / 30, 3.0, frame="camera")) == []
    assert reader.frames == 0
    assert len(reader.notes) == 1
    assert "base_footprint or base_link, not in 'camera'" in reader.notes[0]


def test_messages_of_another_kind_are_left_out_and_said() -> None:
    reader = PeopleReader(load_model())
    for i in range(3):
        assert reader.hear("/tf", build(STRING, {}), EPOCH + i) == []
    (note,) = reader.notes
    assert note.startswith("A message of /tf is left out: it is none as it should be")


def test_engagement_follows_phase_and_gaze() -> None:
    looks, away = Observation(0.2, gaze=0.2), Observation(0.2, gaze=2.0)
    level = Engagement.UNKNOWN
    for phase, seen, expected in (
        (Phase.IA, away, Engagement.DISENGAGED),
        (Phase.IA, Observation(0.2), Engagement.DISENGAGED),
        (Phase.IA, looks, Engagement.ENGAGING),
        (Phase.APP, away, Engagement.ENGAGING),
        (Phase.CS, looks, Engagement.ENGAGED),
        (Phase.CS, away, Engagement.ENGAGED),
        (Phase.FA, away, Engagement.DISENGAGING),
        (Phase.IA, away, Engagement.DISENGAGING),
        (Phase.DS, looks, Engagement.ENGAGING),
    ):
        level = engagement(level, belief(phase), seen)
        assert level is expected


def test_a_recording_is_there_when_it_is_finished(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    recorder = Recorder(path)
    assert not path.exists()
    raw = bytes(type_store().serialize_cdr(build(STRING, {"data": "4"}), STRING))
    recorder.write("/state", STRING, 7, raw)
    recorder.close()
    assert list(tmp_path.iterdir()) == [path]
    ((topic, received, message),) = read_messages(path, lambda _: True)
    assert (topic, received, message.data) == ("/state", 7, "4")


def test_a_recording_of_nothing_is_none(tmp_path: Path) -> None:
    Recorder(tmp_path / "x.mcap").close()
    assert list(tmp_path.iterdir()) == []


def test_the_last_frames_of_somebody_count_though_only_time_ends_their_interval() -> None:
    """However the steps of time lie to the stamps."""
    model = load_model()
    for shift in (0, 1, 50_000_000, 99_999_999):
        reader, told = PeopleReader(model), []
        for i in range(90):
            stamp = EPOCH + shift + i * SECOND // 30
            pose = {"translation": {"x": 3.0, "z": 1.6}, "rotation": {"z": 1.0}}
            header = header_fields(stamp, "base_footprint")
            one = {"header": header, "child_frame_id": "face_a", "transform": pose}
            gaze = {"header": header_fields(stamp, "face_a"), "child_frame_id": "gaze_a"}
            turn = {"transform": {"rotation": {"w": 1.0}}}
            message = build(TRANSFORMS, {"transforms": [one, {**gaze, **turn}]})
            told += reader.hear("/tf", message, stamp)
        told += reader.pass_time(stamp + SECOND)
        assert reader.frames == 90
        ends = [round((one.stamp - EPOCH - shift) / SECOND, 3) for one in told]
        assert ends[:15] == [round(0.2 * i, 3) for i in range(1, 16)]
        assert told[14].observation is not None
        assert told[14].observation.distance == 3.0

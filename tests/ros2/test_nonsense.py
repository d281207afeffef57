"""Messages that cannot be right: they are said and passed over, and change nothing for others."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from ros2.wire import World
from ros2_peers import ODOMETRY

from kendon.models import load_model
from kendon.ros.ros2_node import Ros2Node
from kendon.ros.ros2_reading import PeopleReader
from kendon.ros.ros2_types import FACE, STRING, TRANSFORMS, build, header_fields
from kendon.sources.bag_people import BagOptions

EPOCH = 1_700_000_000 * 10**9
SECOND = 10**9
MODEL = load_model()
NUMBERS = [0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 1e300, -1e300, 1e-300, 1e6]
FRAMES = ["base_link", "odom", "camera", "face_z", "gaze_z", "head_z", "body_z", "face_", "gaze_",
          "l_wrist_z", "", "/", "\xff", "z"]  # fmt: skip


class Nonsense:
    """Messages full of numbers that nothing has, in frames that lie in each other."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)

    def number(self) -> float:
        return self.rng.choice(NUMBERS)

    def point(self) -> dict[str, float]:
        return {axis: self.number() for axis in "xyz"}

    def turn(self) -> dict[str, float]:
        return {"w": 1.0} if self.rng.random() < 0.6 else {**self.point(), "w": self.number()}

    def transform(self, stamp: int) -> dict[str, Any]:
        place = self.point() if self.rng.random() < 0.7 else {"x": 1.0, "z": 1.5}
        return {
            "header": header_fields(stamp, self.rng.choice(FRAMES)),
            "child_frame_id": self.rng.choice(FRAMES),
            "transform": {"translation": place, "rotation": self.turn()},
        }

    def face(self, stamp: int) -> dict[str, Any]:
        eyes = {f"{side}_eye_gaze": self.point() for side in ("left", "right")}
        borders = {f"{side}_eye_borders": [self.point()] * 2 for side in ("left", "right")}
        return {
            "header": header_fields(stamp, self.rng.choice(["", "base_link", "cam"])),
            "face": self.point() if self.rng.random() < 0.5 else {"x": 2.0},
            "face_rotation": self.point(),
            "face_id": self.rng.choice(["", "q", "z"]),
            "action_units": [self.number(), self.number()],
            "joint_names": self.rng.choice([[], ["l_wrist"], ["foo"]]),
            "joints": [self.point()] * self.rng.randrange(2),
            "gestures_given": self.rng.random() < 0.5,
            **{name: self.number() for name in ("dsal", "csal", "hdip")},
            **eyes, **borders,
        }  # fmt: skip

    def message(self, stamp: int) -> tuple[str, Any]:
        rng = self.rng
        match rng.randrange(7):
            case 0 | 1:
                told = [self.transform(stamp) for _ in range(rng.randrange(3))]
                topic = rng.choice(["/tf", "/tf", "/tf_static"])
                return topic, build(TRANSFORMS, {"transforms": told})
            case 2:
                return "/faces", build(FACE, self.face(stamp))
            case 3:
                far = {axis: rng.choice([math.nan, math.inf, 1e300]) for axis in "xy"}
                pose = {"pose": {"position": far, "orientation": self.turn()}}
                header = header_fields(stamp, "odom")
                return "/odom", build(ODOMETRY, {"header": header, "pose": pose})
            case 4:
                units = np.array([rng.choice([math.nan, math.inf, 0.5]) for _ in range(99)])
                fields = {"intensity": units, "confidence": units[::-1]}
                header = header_fields(stamp, "")
                kind = "hri_msgs/msg/FacialActionUnits"
                return "/humans/faces/z/facs", build(kind, {"header": header, **fields})
            case 5:
                who, what = rng.choice("pqz"), rng.choice(["face_id", "body_id", "alias"])
                text = build(STRING, {"data": rng.choice(["", "z", "p", "\0", "a b/c"])})
                return f"/humans/persons/{who}/{what}", text
            case _:
                ends = {"id1": rng.choice(["", "z", "p"]), "id1_type": rng.randint(-128, 127)}
                rest = {"id2": "z", "id2_type": 2, "confidence": self.number()}
                match_kind = "hri_msgs/msg/IdsMatch"
                return "/humans/candidate_matches", build(match_kind, {**ends, **rest})


def somebody(stamp: int, t: float) -> Any:
    """Somebody who walks up to the robot, and looks at it."""
    turn = {"z": 1.0}
    face = {
        "header": header_fields(stamp, "base_footprint"),
        "child_frame_id": "face_good",
        "transform": {"translation": {"x": 5.0 - 0.8 * t, "z": 1.6}, "rotation": turn},
    }
    gaze = {
        "header": header_fields(stamp, "face_good"),
        "child_frame_id": "gaze_good",
        "transform": {"rotation": {"x": -0.5, "y": 0.5, "z": -0.5, "w": 0.5}},
    }
    return build(TRANSFORMS, {"transforms": [face, gaze]})


def beliefs(reader: PeopleReader, nonsense: Nonsense | None) -> list[list[float]]:
    """What a reader makes of somebody, with nonsense between their frames or without."""
    told = []
    for i in range(120):
        now = EPOCH + i * SECOND // 30
        told += reader.hear("/tf", somebody(now, i / 30), now)
        for k in range(1, 4) if nonsense else ():
            later = now + k * 1_000_000
            assert nonsense is not None
            told += reader.hear(*nonsense.message(later), later)
    told += reader.pass_time(now + SECOND)
    return [
        one.belief.probabilities.tolist()
        for one in told
        if one.name.endswith("good") and one.belief
    ]


@given(st.integers(0, 2**32))
@settings(max_examples=15, deadline=None)
def test_nonsense_about_others_does_not_change_what_is_read_of_somebody(seed: int) -> None:
    expected = beliefs(PeopleReader(MODEL), None)
    found = beliefs(PeopleReader(MODEL), Nonsense(seed))
    # After the last message time alone ends intervals, by the clock of all who told of anything.
    count = min(len(found), len(expected))
    assert count >= 19
    np.testing.assert_allclose(found[:count], expected[:count], rtol=0, atol=1e-9)


def test_nonsense_at_any_time_ends_nothing_and_is_not_spoken_of_for_ever() -> None:
    for seed in range(30):
        reader, nonsense, now = PeopleReader(MODEL), Nonsense(seed), EPOCH
        for _ in range(100):
            now += nonsense.rng.randint(1, SECOND // 15)
            stamp = nonsense.rng.choice([now, now, 0, now + nonsense.rng.randint(-3, 3) * SECOND])
            reader.hear(*nonsense.message(stamp), now)
        assert len(reader.notes) < 40


def test_one_frame_too_far_away_is_left_out_and_the_others_are_not() -> None:
    reader = PeopleReader(MODEL)
    for i in range(90):
        now = EPOCH + i * SECOND // 30
        message = somebody(now, i / 30)
        if i == 60:
            message.transforms[0].transform.translation.x = 2000.0
        reader.hear("/tf", message, now)
    reader.pass_time(now + SECOND)
    assert reader.frames == 89
    (note,) = [note for note in reader.notes if "millimetres" in note]
    assert note.startswith("Left out: person good is more than 100 m away")


def test_a_base_that_is_not_told_of_yet_is_waited_for() -> None:
    reader = PeopleReader(MODEL, BagOptions("torso"))
    for i in range(120):
        now = EPOCH + i * SECOND // 30
        reader.hear("/tf", somebody(now, i / 30), now)
        if i == 60:
            assert reader.frames == 0
            told = {"header": header_fields(0, "base_footprint"), "child_frame_id": "torso"}
            turn = {"rotation": {"w": 1.0}}
            rig = build(TRANSFORMS, {"transforms": [{**told, "transform": turn}]})
            reader.hear("/tf_static", rig, now)
    assert reader.frames > 30
    assert [note for note in reader.notes if "there is no frame 'torso'; valid:" in note.lower()]


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"face": {"x": 1600.0}}, "a coordinate of 1600 is not within 100 m"),
        ({"gestures_given": True, "dsal": 80.0}, "dsal is a probability, from 0 to 1, not 80"),
        ({"joint_names": ["l_wrist"]}, "a face has 1 joint_names but 0 joints"),
        ({"action_units": [1.0]}, "it is none as it should be"),
    ],
)
def test_a_node_goes_on_after_a_bad_message(fields: dict[str, Any], sentence: str) -> None:
    world = World()
    node = Ros2Node(world.wire, MODEL, clock=world.wire.clock)
    running = node.run()
    for _ in range(20):
        next(running)
    before = node.reader.frames
    for _ in range(3):
        bad = {"header": header_fields(world.wire.now + 10**7, "base_footprint"), "face_id": "7"}
        message = build(FACE, {**bad, **fields})
        world.wire.waiting.append(("/faces", world.wire.now, b"as it came", message))
        next(running)
    for _ in range(20):
        next(running)
    running.close()
    assert len([note for note in node.notes if sentence in note]) == 1
    assert node.reader.frames > before + 30


@pytest.mark.parametrize("stray", [-5.0, 1.5, 9.0, 3600.0, -3600.0, -1.7e9 + 5, 4e8])
def test_a_single_stamp_of_another_time_changes_nothing(stray: float) -> None:
    expected = beliefs(PeopleReader(MODEL), None)
    reader, told, now = PeopleReader(MODEL), [], EPOCH
    for i in range(120):
        now = EPOCH + i * SECOND // 30
        told += reader.hear("/tf", somebody(now, i / 30), now)
        if i in (45, 46, 80):
            told += reader.hear("/tf", somebody(now + round(stray * SECOND), 0.0), now + 1)
    told += reader.pass_time(now + SECOND)
    assert len({one.name for one in told}) == 1
    assert all(one.observation for one in told)  # nobody has gone meanwhile
    found = [one.belief.probabilities.tolist() for one in told if one.belief]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
    notes = [note for note in reader.notes if "is stamped" in note]
    assert len(notes) == 2  # of the face, and of the gaze


def test_a_clock_that_was_set_is_followed_after_three_messages() -> None:
    reader, told = PeopleReader(MODEL), []
    for i in range(240):
        now = EPOCH + i * SECOND // 30
        set_back = 100 * SECOND if i >= 120 else 0
        told += reader.hear("/tf", somebody(now - set_back, i / 30), now)
    names = [(one.name, one.observation is None) for one in told]
    assert names.count(("anonymous_person_good", True)) == 1  # gone, and there again
    after = [one for one in told if one.stamp < EPOCH and one.belief]
    assert len(after) > 12

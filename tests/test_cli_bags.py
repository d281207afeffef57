"""The command line with ROS bags: everybody in a bag, one of them, and mistakes."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("rosbags", reason="the extra 'bags' is not installed")
from bag_files import Ids, Text, Told, Transform, write_bag
from command_line import Kendon


def people(*names: str) -> list[Told]:
    """People side by side who walk up to a camera."""
    told: list[Told] = []
    for number, name in enumerate(names):
        told.append(Text(0.0, f"/humans/persons/{name}/face_id", f"f{number}"))
        for i in range(60):
            place = (float(number), -0.4, 3.0 - 0.03 * i)
            told.append(Transform(i / 30, "camera_optical_frame", f"face_f{number}", place))
            told.append(Transform(i / 30, f"face_f{number}", f"gaze_f{number}"))
    return told


def test_estimate_reads_everybody(kendon: Kendon, tmp_path: Path) -> None:
    bag = write_bag(tmp_path, "mcap", people("ann", "bob"), "hall")
    run = kendon("estimate", bag, "--out", tmp_path / "phases")
    assert run.code == 0
    assert "hall#ann" in run.out
    assert "hall#bob" in run.out
    assert {f.name for f in (tmp_path / "phases").iterdir()} == {"hall_ann.csv", "hall_bob.csv"}
    assert run.err.count("is taken to be a camera at 0,0,1.2") == 1


def test_estimate_reads_the_one_chosen(kendon: Kendon, tmp_path: Path) -> None:
    bag = write_bag(tmp_path, "bag", people("ann", "bob"), "hall")
    run = kendon("estimate", f"{bag}#bob", "--out", tmp_path / "phases")
    assert run.code == 0
    assert [f.name for f in (tmp_path / "phases").iterdir()] == ["hall_bob.csv"]


def test_greet_answers_the_one_seen_most(kendon: Kendon, tmp_path: Path) -> None:
    bag = write_bag(tmp_path, "db3", people("ann", "bob"), "hall")
    run = kendon("greet", bag, "--quiet")
    assert run.code == 0
    assert "holds 2 people; read is ann" in run.err


def no_transforms() -> list[Told]:
    return [Ids(0.0, "/humans/faces/tracked", ["f0"])]


def unconnected() -> list[Told]:
    return [*people("ann"), Transform(0.0, "odom", "base_link", static=True)]


@pytest.mark.parametrize(
    ("told", "suffix", "words"),
    [
        (people("ann", "bob"), "#eve", ["there is no person 'eve'", "ann, bob"]),
        (no_transforms(), "", ["no people", "f0 is tracked"]),
        (unconnected(), "", ["no transforms connect face_f0 with base_link"]),
    ],
)
def test_a_mistake_is_one_sentence_and_exit_code_2(
    kendon: Kendon, tmp_path: Path, told: list[Told], suffix: str, words: list[str]
) -> None:
    bag = write_bag(tmp_path, "db3", told)
    run = kendon("estimate", f"{bag}{suffix}", "--out", tmp_path / "phases")
    assert run.code == 2
    assert "Traceback" not in run.err
    for word in words:
        assert word in run.err
    assert not (tmp_path / "phases").exists()


def test_a_torn_bag_is_exit_code_2(kendon: Kendon, tmp_path: Path) -> None:
    bag = write_bag(tmp_path, "bag", people("ann"))
    bag.write_bytes(bag.read_bytes()[:3000])
    run = kendon("estimate", bag)
    assert run.code == 2
    assert "torn" in run.err
    assert "Traceback" not in run.err


def test_a_missing_extra_is_named_and_exit_code_2(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = write_bag(tmp_path, "db3", people("ann"))
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    run = kendon("estimate", bag)
    assert run.code == 2
    assert "pip install 'kendon[bags]'" in run.err


def test_the_source_and_its_extra_are_listed(kendon: Kendon) -> None:
    assert "ROS bags" in kendon("sources").out
    assert "extra bags" in kendon("doctor").out

"""The command line as its users meet it: good input, bad input, exit codes."""

from __future__ import annotations

import csv
import dataclasses
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import Kendon

from kendon.cli.information import EXTRAS
from kendon.errors import RendererError
from kendon.person import Track
from kendon.simulation import SCRIPTS, SimulatedPerson
from kendon.tracks import write_track


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A track CSV of the built-in person before a robot that stands still."""
    person = SimulatedPerson(SCRIPTS["normal"])
    frames, phases = [], []
    while not person.finished:
        frames.append(person.frame())
        phases.append(int(person.phase))
        person.step()
    track = Track.from_frames(frames)
    path = tmp_path_factory.mktemp("tracks") / "ann.csv"
    write_track(dataclasses.replace(track, phases=np.array(phases)), path)
    return path


def test_greet_alone_visits_all_phases_and_draws_the_encounter(
    kendon: Kendon, tmp_path: Path
) -> None:
    run = kendon("greet", "--figure", tmp_path / "greeting.png", "--out", tmp_path)
    assert run.code == 0
    assert "IA → APP → DS → HD → APP → FA → CS" in run.out
    assert (tmp_path / "greeting.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "commands.csv").open() as file:
        commands = list(csv.DictReader(file))
    spoken = [c for c in commands if c["part"] == "voice"]
    assert [c["phase"] for c in spoken] == ["CS"]
    with (tmp_path / "phases.csv").open() as file:
        assert next(csv.reader(file)) == [
            "t", "phase", "p_IA", "p_DS", "p_HD", "p_APP", "p_FA", "p_CS",
            "distance", "speed", "gaze", "smile", "dsal", "csal", "hdip",
        ]  # fmt: skip


def test_greet_a_recording_answers_without_driving_into_its_person(
    kendon: Kendon, recording: Path, tmp_path: Path
) -> None:
    run = kendon("greet", recording, "--out", tmp_path, "--quiet")
    assert run.code == 0
    with (tmp_path / "commands.csv").open() as file:
        gestures = [c["command"] for c in csv.DictReader(file) if c["part"] == "arms"]
    assert gestures.count("wave") == 1
    assert gestures.count("handshake") == 1


def test_greet_with_a_body_answers_like_the_point_robot(kendon: Kendon) -> None:
    answers = []
    for robot in ("point", "mujoco"):
        run = kendon("greet", "--robot", robot)
        assert run.code == 0
        # A body's gestures take their own time, and the arms go home after them.
        told = run.out.split("The person")[1]
        answers.append(told.replace(", home", "").replace("home, ", ""))
    assert answers[0] == answers[1]


def test_estimate_tells_accuracy_and_writes_a_file_each(
    kendon: Kendon, recording: Path, tmp_path: Path
) -> None:
    run = kendon("estimate", recording, "--out", tmp_path / "phases")
    assert run.code == 0
    assert "accuracy" in run.out
    assert (tmp_path / "phases" / "ann.csv").exists()


def test_a_folder_its_index_and_its_files_are_the_same_recordings(
    kendon: Kendon, recording: Path, tmp_path: Path
) -> None:
    (tmp_path / "bob.csv").write_bytes(recording.read_bytes())
    index = tmp_path / "index.csv"
    index.write_text("file,kind\nbob.csv,full\n")
    by_folder = kendon("estimate", tmp_path)
    assert by_folder.code == 0
    assert by_folder.out.count("bob.csv") == 1
    assert kendon("estimate", index).out == by_folder.out
    assert kendon("estimate", tmp_path / "bob.csv", index).out == by_folder.out


def test_gestures_from_phases_is_better_than_no_gestures(
    kendon: Kendon, recording: Path, tmp_path: Path
) -> None:
    rows = list(csv.reader(recording.read_text().splitlines()))
    # Without joints only the head is left to tell gestures by.
    told = re.compile("t|head_.*|smile|phase")
    keep = [i for i, name in enumerate(rows[0]) if told.fullmatch(name)]
    bare = tmp_path / "bare.csv"
    with bare.open("w", newline="") as file:
        csv.writer(file).writerows([row[i] for i in keep] for row in rows)

    def accuracy(*arguments: str | Path) -> float:
        return float(re.findall(r"\b[01]\.\d{3}\b", kendon("estimate", *arguments).out)[0])

    assert accuracy(bare, "--gestures-from-phases") > accuracy(bare)


@pytest.mark.parametrize("command", ["sources", "robots", "models", "trees", "doctor", "--version"])
def test_commands_that_tell_about_kendon(kendon: Kendon, command: str) -> None:
    run = kendon(command)
    assert run.code == 0
    assert run.out.strip()


def test_the_doctor_tells_what_is_missing_and_what_to_do(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nothing_draws() -> None:
        raise RendererError("neither EGL nor OSMesa")

    monkeypatch.setattr("kendon.viewer.stage.require_renderer", nothing_draws)
    monkeypatch.setattr("kendon.cli.information.find_spec", lambda module: None)
    run = kendon("doctor", "--model-files", tmp_path)
    assert run.code == 0
    for extra, packages in EXTRAS.items():
        assert re.search(rf"– +extra {extra} +without {re.escape(', '.join(packages.values()))}",
                         run.out)  # fmt: skip
        assert f"  • for the extra {extra}: pip install 'kendon[{extra}]'\n" in run.out
    assert re.search(r"– +--picture, --video +nothing to draw with", run.out)
    assert "  • neither EGL nor OSMesa\n" in run.out
    assert "  • face_landmarker.task: get it from https" in run.out


@pytest.mark.parametrize("command", ["greet", "estimate"])
def test_help_has_examples(kendon: Kendon, command: str) -> None:
    run = kendon(command, "--help")
    assert run.code == 0
    assert "Examples" in run.out


def test_exported_trees_run(kendon: Kendon, tmp_path: Path) -> None:
    trees = tmp_path / "mine.xml"
    assert kendon("trees", "--export", trees).code == 0
    run = kendon("greet", "simulated:short", "--tree", trees)
    assert run.code == 0
    assert "handshake" in run.out
    again = kendon("trees", "--export", trees)
    assert again.code == 2
    assert "exists" in again.err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["greet", "nobody.csv"], ["nobody.csv", "no such file"]),
        (["greet", "simulated:tango"], ["tango", "late-wave"]),
        (["greet", "--model", "kendom"], ["kendom", "did you mean 'kendon'"]),
        (["greet", "--model", "none.toml"], ["none.toml", "no such model file"]),
        (["greet", "--tree", "none.xml"], ["none.xml"]),
        (["greet", "--speed", "-1"], ["--speed", "-1"]),
        (["greet", "--speed", "nan"], ["--speed", "nan"]),
        (["greet", "--figure", "greeting.txt"], ["greeting.txt", ".png"]),
        (["greet", "--robot-face", "1,2"], ["--robot-face", "X,Y,Z", "1,2"]),
        (["greet", "--robot-face", "0,0,inf"], ["--robot-face", "inf"]),
        (["greet", "--camera-pose", "0,0,1,2"], ["--camera-pose", "YAW,PITCH"]),
        (["greet", "--camera-pose", "1e300,0,0"], ["--camera-pose", "100 m", "1e300"]),
        (["greet", "--camera-pose", "0,0,1,0,9e9"], ["--camera-pose", "360 degrees"]),
        (["greet", "--fov", "400"], ["--fov", "160 degrees", "400"]),
        (["greet", "--fps", "0"], ["frames a second", "1 and 1000"]),
        (["greet", "--source", "kinect", "x"], ["kinect", "openface"]),
        (["greet", "--gestures-from-phases"], ["simulated", "no true phases"]),
        (["greet", "--out", __file__], ["--out", "is a file"]),
        (["greet", "--robot", "vizy"], ["vizy", "point, mujoco", ".toml robot file"]),
        (["greet", "--robot", "gone.toml"], ["gone.toml", "no such robot file"]),
        (["greet", "--robot", "mujoco", "--robot-face", "0,0,1"], ["face", "'point'"]),
        (["greet", "--robot", "point", "--video", "x.mp4"], ["'point' has no body", "mujoco"]),
        (["greet", "--video", "x.avi"], ["x.avi", ".mp4 or .webm"]),
        (["greet", "--picture", "x.jpg"], ["x.jpg", ".png"]),
        (["estimate", "."], [".", "folder"]),
        (["estimate", "nobody.csv"], ["nobody.csv"]),
        (["estimate", "simulated", "--decoder", "magic"], ["magic", "viterbi"]),
        (["estimate", "camera:0", "--gestures-from-phases"], ["camera:0", "no true phases"]),
        (["estimate", "--camera", "-1"], ["--camera", "greater than or equal to 0"]),
        (["estimate", "--camera", "0", "--seconds", "0"], ["--seconds", "more than 0"]),
        (["estimate", "simulated", "--overlay", "seen.txt"], ["seen.txt", ".mp4 or .avi"]),
        (["estimate", "simulated", "--overlay", f"{__file__}/a.mp4"], ["is not a folder"]),
        (["estimate", "simulated", "--overlay", "seen.mp4"], ["--overlay", "videos and cameras"]),
        (["estimate", "a.mp4", "b.mp4", "--overlay", "seen.mp4"], ["one video", "2 sources"]),
        (["greet", "--calibration", "c.yaml", "--fov", "70"], ["give one of the two"]),
        (["greet", "--person", "0"], ["numbered from 1", "0"]),
        (["fit", "camera:0", "--out", "m.toml"], ["camera:0", "device"]),
        (["estimate", __file__], ["test_cli.py", "kendon sources"]),
        (["estimate", "--out", __file__, "simulated"], ["--out", "is a file"]),
        (["greet", "--robot-face", "1e300,0,0"], ["--robot-face", "10 m"]),
        (["estimate", ""], ["empty name"]),
        (["simulate", "--out", __file__], ["--out", "is a file"]),
        (["simulate", "--out", "people", "--jobs", "0"], ["--jobs", "at least 1, or -1", "0"]),
        (["gazebo", "1,2", "3,nan"], ["the goal of the walk is X,Y", "3,nan"]),
        (["gazebo", "--", "-1,inf", "3,0"], ["the start of the walk is X,Y", "-1,inf"]),
        (["ros1", "--model", "nobody"], ["nobody", "trained"]),
        (["ros1", "--tree", "no.xml"], ["no.xml", "cannot be read"]),
        (["trees", "--export", "mine.txt"], ["mine.txt", ".xml"]),
        (["dance"], ["dance"]),
        (["estimate"], ["--camera 0"]),
    ],
)
def test_a_mistake_is_one_sentence_and_exit_code_2(
    kendon: Kendon, arguments: list[str], words: list[str], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    run = kendon(*arguments)
    assert run.code == 2
    assert "Traceback" not in run.err
    for word in words:
        assert word in run.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", [("--overlay", "seen.mp4"), ("--seconds", "2")])
def test_observations_have_no_pictures_and_no_clock(
    kendon: Kendon, option: tuple[str, str], tmp_path: Path
) -> None:
    file = tmp_path / "seen.csv"
    file.write_text("t,distance\n0.2,3\n0.4,2.9\n", encoding="utf-8")
    run = kendon("estimate", file, *option)
    assert run.code == 2
    assert f"{option[0]} is for videos and cameras; {file} is observations" in run.err


def test_a_renderer_that_does_not_exist_is_told() -> None:
    # MuJoCo reads the variable when it is imported: this takes a process of its own.
    run = subprocess.run(
        [sys.executable, "-c", "from kendon.cli import main; main()", "greet", "--robot", "mujoco"],
        env={**os.environ, "MUJOCO_GL": "crayon"}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 2
    assert "MUJOCO_GL=crayon" in run.stderr
    assert "apt-get install" in run.stderr
    assert "Traceback" not in run.stderr


def test_python_runs_the_package_as_the_command() -> None:
    program = [sys.executable, "-m", "kendon"]
    run = subprocess.run([*program, "robots"], capture_output=True, text=True, check=False)
    assert run.returncode == 0
    assert "point" in run.stdout
    run = subprocess.run([*program, "greet", "nobody"], capture_output=True, text=True, check=False)
    assert run.returncode == 2
    assert run.stderr.startswith("kendon: ")


def test_a_bad_file_among_good_ones_leaves_nothing_written(
    kendon: Kendon, recording: Path, tmp_path: Path
) -> None:
    torn = tmp_path / "torn.csv"
    torn.write_text("t,head_x,head_y,head_z\n0,1,2,1.6\n0.1,1,2\n")
    run = kendon("estimate", recording, torn, "--out", tmp_path / "out")
    assert run.code == 2
    assert "torn.csv, row 3" in run.err
    assert not (tmp_path / "out").exists()


def test_two_recordings_of_one_name_are_not_written_over_each_other(
    kendon: Kendon, recording: Path, tmp_path: Path
) -> None:
    twin = tmp_path / recording.name
    twin.write_bytes(recording.read_bytes())
    run = kendon("estimate", recording, twin, "--out", tmp_path / "out")
    assert run.code == 2
    assert "both" in run.err
    assert not (tmp_path / "out").exists()


def test_a_recording_is_never_overwritten_by_the_answer_to_it(
    kendon: Kendon, recording: Path, tmp_path: Path
) -> None:
    mine = tmp_path / "phases.csv"
    mine.write_bytes(recording.read_bytes())
    run = kendon("greet", mine, "--out", tmp_path, "--quiet")
    assert run.code == 2
    assert "overwrite" in run.err
    assert mine.read_bytes() == recording.read_bytes()


def test_nobody_is_read_where_nobody_is_seen(kendon: Kendon, tmp_path: Path) -> None:
    empty = tmp_path / "nobody.csv"
    rows = "".join(f"{i / 30:.4f},,,\n" for i in range(60))
    empty.write_text(f"t,head_x,head_y,head_z\n{rows}")
    run = kendon("estimate", empty)
    assert run.code == 2
    assert "nobody is seen" in run.err


def test_brackets_in_a_name_are_no_markup(
    kendon: Kendon, recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("[b]ann[/c].csv").parent.mkdir()
    Path("[b]ann[/c].csv").write_bytes(recording.read_bytes())
    run = kendon("estimate", "[b]ann[/c].csv", "--out", "[red]")
    assert run.code == 0
    assert "c].csv  " in run.out
    assert "written to [red]" in run.out
    run = kendon("greet", "simulated:short", "-q", "--figure", "[/x]/[y].svg")
    assert run.code == 0
    assert "drawn in [/x]/[y].svg." in run.out


def test_no_phase_is_read_off_observations_of_nothing(kendon: Kendon, tmp_path: Path) -> None:
    empty = tmp_path / "nothing.csv"
    features = "distance,speed,gaze,smile,dsal,csal,hdip"
    empty.write_text(f"t,{features}\n0.2,nan,,,,,,\n0.4,,,,,,,\n", encoding="utf-8")
    run = kendon("estimate", empty, "--out", tmp_path / "out")
    assert run.code == 2
    assert "nobody is seen in it: no value is known" in run.err
    assert list(tmp_path.iterdir()) == [empty]


def test_observations_are_not_greeted(kendon: Kendon, tmp_path: Path) -> None:
    assert kendon("simulate", "--n", "1", "--out", tmp_path / "set").code == 0
    run = kendon("greet", tmp_path / "set" / "greeting_00000.csv")
    assert run.code == 2
    assert "these are observations" in run.err


def test_results_never_overwrite_their_input(kendon: Kendon, recording: Path) -> None:
    before = recording.read_bytes()
    run = kendon("estimate", recording, "--out", recording.parent)
    assert run.code == 2
    assert "overwrite" in run.err
    assert recording.read_bytes() == before

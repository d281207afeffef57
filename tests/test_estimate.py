"""Phases for recorded people: scores, tables, decoders, and accuracy on recorded people."""

from __future__ import annotations

import csv
import math
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from shared_data import shared_files

from kendon.errors import DataError, ParameterError
from kendon.estimate import Decoder, Estimate, estimate
from kendon.features import PERIOD, observe
from kendon.greetings import load_observations
from kendon.models import load_model
from kendon.observations import FEATURES, Observations, write_observations
from kendon.person import FloatArray, IntArray, PersonFrame, Track
from kendon.phases import PHASE_NAMES, Phase
from kendon.simulation import SimulatedPerson, script
from kendon.tracks import write_track

KENDON = load_model("kendon")
HEADER = "t,phase,p_IA,p_DS,p_HD,p_APP,p_FA,p_CS,distance,speed,gaze,smile,dsal,csal,hdip"


def observations(values: FloatArray, phases: IntArray | None = None) -> Observations:
    t = np.array([PERIOD * k for k in range(1, len(values) + 1)], dtype=np.float64)
    return Observations(t, values, phases, "person")


def greeting(*, labelled: bool = True) -> Observations:
    """Everyone's favourite greeting: three observations a phase, right at the model's means."""
    order = [Phase.IA, Phase.APP, Phase.DS, Phase.HD, Phase.APP, Phase.FA, Phase.CS]
    values = np.repeat(KENDON.means[[p.index for p in order]], 3, axis=0)
    phases = np.repeat(np.array([int(p) for p in order]), 3)
    return observations(values, phases if labelled else None)


def result(phases: list[int], truth: list[int] | None) -> Estimate:
    seen = observations(np.zeros((len(phases), 7)), None if truth is None else np.array(truth))
    return Estimate(seen, np.full((len(phases), 6), 1 / 6), np.array(phases))


def simulated_track(name: str = "normal") -> Track:
    """A simulated person before a robot that stands still, with the phases of the script."""
    person = SimulatedPerson(script(name))
    frames: list[PersonFrame] = []
    phases = []
    while not person.finished:
        frames.append(person.frame())
        phases.append(int(person.phase))
        person.step()
    track = Track.from_frames(frames, name)
    return Track(**{**vars(track), "phases": np.array(phases)})


# ---- scores


@pytest.mark.parametrize(
    ("phases", "truth", "score", "accuracy"),
    [
        ([1, 4, 5, 6], [1, 4, 5, 6], (4, 4), 1.0),
        ([1, 4, 4, 6], [1, 4, 5, 6], (3, 4), 0.75),
        ([1, 4, 4, 6], [4, 1, 5, 2], (0, 4), 0.0),
        # Who greets nobody (0) and what nobody labelled (-1) counts neither way.
        ([1, 4, 4, 6], [1, 0, -1, 5], (1, 2), 0.5),
        ([1, 1], [0, -1], (0, 0), math.nan),
        ([1, 1], None, (0, 0), math.nan),
    ],
)
def test_accuracy_counts_labelled_observations_only(
    phases: list[int], truth: list[int] | None, score: tuple[int, int], accuracy: float
) -> None:
    found = result(phases, truth)
    assert found.score == score
    assert found.accuracy == pytest.approx(accuracy, nan_ok=True)


def test_the_sequence_names_each_stretch_once() -> None:
    assert result([1, 1, 4, 2, 2, 3, 4, 4, 5, 6], None).sequence == [
        Phase.IA, Phase.APP, Phase.DS, Phase.HD, Phase.APP, Phase.FA, Phase.CS,
    ]  # fmt: skip
    assert result([6], None).sequence == [Phase.CS]


# ---- decoders


def test_the_filter_reads_what_the_model_filters() -> None:
    seen = greeting()
    found = estimate(seen, KENDON)
    np.testing.assert_array_equal(found.probabilities, KENDON.filter(seen.values))
    assert found.phases.tolist() == (found.probabilities.argmax(axis=1) + 1).tolist()
    assert found.accuracy == 1


def test_viterbi_decodes_but_reports_the_filters_probabilities() -> None:
    # Half a second of a Close Salutation's observations in the middle of an approach: the
    # filter believes them, the best path of the whole cannot, as nothing follows a CS.
    values = np.tile(KENDON.means[3], (15, 1))
    values[:2] = KENDON.means[0]
    values[7] = [1.5, 0.6, 0.5, 2, 0, 0.6, 0]
    seen = observations(values)
    by_filter = estimate(seen, KENDON, Decoder.FILTER)
    by_viterbi = estimate(seen, KENDON, Decoder("viterbi"))
    np.testing.assert_array_equal(by_viterbi.probabilities, by_filter.probabilities)
    assert by_viterbi.phases.tolist() == KENDON.decode(values).tolist()
    assert by_viterbi.phases.tolist() != by_filter.phases.tolist()


def test_no_observation_at_all_is_refused() -> None:
    with pytest.raises(ParameterError, match="at least 1"):
        estimate(observations(np.zeros((0, 7))), KENDON)


# ---- the table


def read(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_table_has_exactly_the_promised_columns(tmp_path: Path) -> None:
    path = tmp_path / "new" / "folder" / "person.csv"
    found = estimate(greeting(), KENDON)
    found.write(path)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == HEADER
    rows = read(path)
    assert len(rows) == len(found.phases) == len(lines) - 1
    for k, row in enumerate(rows):
        assert row["phase"] == PHASE_NAMES[found.phases[k] - 1]
        assert float(row["t"]) == pytest.approx(found.observations.t[k], rel=1e-5)
        beliefs = [float(row[f"p_{name}"]) for name in PHASE_NAMES]
        np.testing.assert_allclose(beliefs, found.probabilities[k], rtol=1e-5, atol=1e-12)
        seen = [float(row[feature]) for feature in FEATURES]
        np.testing.assert_allclose(seen, found.observations.values[k], rtol=1e-5)


def test_unknown_values_become_empty_cells(tmp_path: Path) -> None:
    values = greeting().values.copy()
    values[:, 4:] = np.nan
    values[2] = np.nan
    path = tmp_path / "person.csv"
    estimate(observations(values), KENDON).write(path)
    rows = read(path)
    assert all(row[gesture] == "" for row in rows for gesture in ("dsal", "csal", "hdip"))
    assert [rows[2][feature] for feature in FEATURES] == [""] * 7
    assert rows[1]["distance"] == "7"
    # A belief is never unknown.
    assert all(row[f"p_{name}"] for row in rows for name in PHASE_NAMES)
    assert "nan" not in path.read_text(encoding="utf-8")


def test_a_file_that_stood_there_is_replaced_whole(tmp_path: Path) -> None:
    path = tmp_path / "person.csv"
    path.write_text("something else\n" * 1000, encoding="utf-8")
    estimate(greeting(), KENDON).write(path)
    assert len(read(path)) == len(greeting())
    assert [p.name for p in tmp_path.iterdir()] == ["person.csv"]


def test_nothing_is_left_behind_where_writing_fails_half_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "person.csv"
    path.write_text("as before\n", encoding="utf-8")

    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(DataError, match=r"person\.csv: cannot be written \(Permission denied\)"):
        estimate(greeting(), KENDON).write(path)
    assert path.read_text(encoding="utf-8") == "as before\n"
    assert [p.name for p in tmp_path.iterdir()] == ["person.csv"]


def test_a_folder_that_cannot_be_written_to_is_named(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    with pytest.raises(DataError, match="cannot be written") as caught:
        estimate(greeting(), KENDON).write(blocked / "person.csv")
    assert caught.value.file == str(blocked / "person.csv")
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="nothing is forbidden to root"
)
def test_a_folder_without_permission_stays_empty(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(DataError, match="cannot be written"):
            estimate(greeting(), KENDON).write(tmp_path / "person.csv")
        assert list(tmp_path.iterdir()) == []
    finally:
        tmp_path.chmod(0o700)


# ---- what is read


def test_observations_are_read_as_they_are(tmp_path: Path) -> None:
    path = tmp_path / "seen.csv"
    write_observations(greeting(), path)
    seen = load_observations(str(path))
    np.testing.assert_allclose(seen.values, greeting().values)
    assert estimate(seen, KENDON).accuracy == 1
    with pytest.raises(ParameterError, match="gestures and sensors are for tracks"):
        load_observations(str(path), gestures_from_phases=True)


def test_a_track_is_observed_from_the_robots_face(tmp_path: Path) -> None:
    path = tmp_path / "person.csv"
    track = simulated_track()
    write_track(track, path)
    seen = load_observations(str(path), robot_face=(0.3, 0.1, 0.8))
    expected = observe(track, (0.3, 0.1, 0.8))
    np.testing.assert_allclose(seen.values, expected.values, atol=5e-3)
    assert seen.phases is not None
    assert expected.phases is not None
    assert seen.phases.tolist() == expected.phases.tolist()
    higher = load_observations(str(path), robot_face=(0.3, 0.1, 2.0))
    assert abs(higher.values[:, 2] - seen.values[:, 2]).max() > 0.01


def test_keys_are_pressed_as_the_true_phases_say(tmp_path: Path) -> None:
    path = tmp_path / "person.csv"
    track = simulated_track()
    bare = Track(**{**vars(track), "gestures": np.full_like(track.gestures, np.nan)})
    write_track(bare, path)
    detected = load_observations(str(path)).values[:, 4:]
    assert not np.isin(detected, (0.0, 1.0)).any()  # a detector is never as sure as a key
    seen = load_observations(str(path), gestures_from_phases=True)
    assert seen.phases is not None
    for place, phase in ((4, Phase.DS), (5, Phase.CS), (6, Phase.HD)):
        pressed = seen.values[:, place]
        # A phase that changes in the middle of an interval leaves the key half pressed.
        sure = pressed != 0.5
        assert sure.sum() > 0.9 * len(pressed)
        np.testing.assert_array_equal(pressed[sure], (seen.phases == phase)[sure])
    unlabelled = Track(**{**vars(bare), "phases": None})
    write_track(unlabelled, path)
    with pytest.raises(ParameterError, match="no true phases"):
        load_observations(str(path), gestures_from_phases=True)


def test_too_short_a_track_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "blink.csv"
    path.write_text("t,head_x,head_y,head_z\n0,3,0,1.6\n0.1,3,0,1.6\n", encoding="utf-8")
    with pytest.raises(DataError, match=r"blink\.csv: lasts 0\.10 s; .* needs 0\.2 s"):
        load_observations(str(path))


@pytest.mark.parametrize("name", ["normal", "plain", "late-wave", "short"])
def test_simulated_greetings_are_read_with_both_decoders(name: str) -> None:
    seen = observe(simulated_track(name))
    for decoder in Decoder:
        found = estimate(seen, KENDON, decoder)
        assert found.accuracy > 0.9
        assert found.sequence[-1] is Phase.CS


# ---- recorded people


@pytest.mark.parametrize(("decoder", "least"), [(Decoder.FILTER, 0.93), (Decoder.VITERBI, 0.94)])
def test_recorded_greetings_are_read(decoder: Decoder, least: float) -> None:
    """The Kendon model with the thesis's keys over all observations of all greetings."""
    right = labelled = 0
    for path in shared_files("data/mocap/greeting_*.csv"):
        found = estimate(load_observations(str(path), gestures_from_phases=True), KENDON, decoder)
        right, labelled = right + found.score[0], labelled + found.score[1]
    assert labelled > 800
    assert right / labelled >= least


def test_a_recorded_greeting_is_written_and_read_again(tmp_path: Path) -> None:
    copy = tmp_path / "person.csv"
    shutil.copy(shared_files("data/mocap/greeting_*.csv")[0], copy)
    seen = load_observations(str(copy), gestures_from_phases=True)
    estimate(seen, KENDON).write(tmp_path / "out" / "person.csv")
    again = load_observations(str(tmp_path / "out" / "person.csv"))
    np.testing.assert_allclose(again.values, seen.values, rtol=1e-5, atol=1e-9)

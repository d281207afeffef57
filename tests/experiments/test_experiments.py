"""The experiments: what they play is what the thesis tells, and what is judged is what happens."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from kendon.cli.app import app
from kendon.errors import KendonError, ParameterError, UnknownNameError
from kendon.experiments.encounters import Setting, hold, hold_all
from kendon.experiments.readings import read, tally
from kendon.experiments.scenes import OURS, THESIS
from kendon.experiments.verdict import judge, visits_of
from kendon.geometry import Pose2D
from kendon.models import load_model
from kendon.phases import Phase
from kendon.robots import Appearance
from kendon.sources.simulated import Station


@pytest.mark.parametrize("scene", THESIS, ids=lambda s: str(s.number))
@pytest.mark.parametrize("keys", [True, False])
def test_labels_are_as_many_as_in_table_3_8(scene: object, keys: bool) -> None:
    assert isinstance(scene, type(THESIS[0]))
    assert read(scene, load_model("kendon"), keys=keys).labels == scene.labels


@pytest.mark.parametrize(
    ("number", "missing"),
    [(1, ""), (2, "DS HD"), (3, "HD"), (4, "DS HD APP"), (5, ""), (6, "")],
)
def test_the_states_are_those_of_table_3_7(number: int, missing: str) -> None:
    track = THESIS[number - 1].record(keys=True, seed=0)
    assert track.phases is not None
    shown = {Phase(int(p)).name for p in np.unique(track.phases)}
    assert set(Phase.__members__) - shown == set(missing.split())


@pytest.mark.parametrize(
    ("number", "start", "gaze", "smile"),
    [(1, 5.5, 1.0, 1.5), (2, 6.0, 1.0, 1.5), (4, 2.0, 1.0, 1.5), (5, 5.5, 1.0, 2.5),
     (6, 5.5, 0.4, 1.5)],
)  # fmt: skip
def test_starts_stops_gaze_and_smile_are_the_thesiss(
    number: int, start: float, gaze: float, smile: float
) -> None:
    reading = read(THESIS[number - 1], load_model("kendon"), keys=True)
    distance, _, gazes, smiles = reading.observations.values[:, :4].T
    assert distance[0] == pytest.approx(start, abs=0.01)
    assert distance[-1] == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(gazes, gaze, atol=0.01)
    np.testing.assert_allclose(smiles, smile)


def test_the_first_one_salutes_after_a_metre_and_a_half() -> None:
    track = THESIS[0].record(keys=True, seed=0)
    first = int(np.argmax(track.phases == Phase.DS))
    assert track.head[first, 0] == pytest.approx(4.0, abs=0.05)


def test_stepping_reads_what_the_batch_filter_reads() -> None:
    model = load_model("kendon")
    reading = read(THESIS[0], model, keys=False, seed=3)
    np.testing.assert_allclose(
        reading.probabilities, model.filter(reading.observations.values), atol=1e-12
    )


def test_the_published_model_reads_the_thesiss_experiments_better_than_the_thesis() -> None:
    tallies = tally(THESIS, load_model("kendon"), keys=True, bodies=1)
    assert sum(t.mean for t in tallies) / sum(t.labels for t in tallies) > 135 / 147
    assert tallies[5].share > 0.93


def test_whoever_turns_away_or_walks_past_ends_as_nobody_who_greets() -> None:
    for number in (8, 12):
        reading = read(OURS[number - 7], load_model("kendon"), keys=False)
        assert reading.truth[-1] == 0
        assert reading.greets[-1] < 0.3


def test_a_lost_face_is_unknown_while_it_is() -> None:
    reading = read(OURS[4], load_model("kendon"), keys=True)
    t, distance = reading.observations.t, reading.observations.values[:, 0]
    assert np.isnan(distance[(t > 1.5) & (t < 2.1)]).all()


# ---- encounters


def test_encounters_repeat_in_any_number_of_processes() -> None:
    setting = Setting(seed=5, sensor="noisy")
    assert repr(hold_all(4, setting)) == repr(hold_all(4, setting, jobs=2))


@pytest.mark.parametrize("sensor", ["truth", "clean"])
def test_encounters_by_keys_are_answered(sensor: str) -> None:
    verdicts = hold_all(12, Setting(seed=3, sensor=sensor, keys=True))
    visits = [v for verdict in verdicts if verdict.greets for v in verdict.visits]
    assert np.mean([v.answered for v in visits]) > 0.95
    assert np.median([v.delay for v in visits if v.answered]) <= 0.5
    assert not any(v.intruded for v in verdicts)


def test_nobody_who_passes_is_approached() -> None:
    verdicts = hold_all(8, Setting(seed=2, passersby=1.0))
    assert not any(v.greets for v in verdicts)
    assert max(v.approach for v in verdicts) < 0.5


def test_what_the_person_saw_is_what_the_robot_did() -> None:
    encounter, source = hold(1, Setting(keys=True, passersby=0.0))
    shown = {s.robot.gesture for s in source.truth if s.robot.gesture}
    asked = {str(a.command.asked["name"]) for a in encounter.actions if a.channel == "arms"}
    assert shown <= asked
    verdict = judge(1, encounter, source)
    assert verdict.nearest == min(math.dist(s.place, s.robot.pose[:2]) for s in source.truth)


def test_visits_are_the_stretches_of_the_truth() -> None:
    robot = Appearance(0.0, Pose2D(0, 0, 0), (0, 0, 1.2), (1, 0, 0), None, None, None)
    phases = [Phase.IA] * 5 + [None] * 3 + [Phase.DS] * 6
    truth = [Station(i / 10, p, (4.0, 0.0), robot) for i, p in enumerate(phases)]
    found = [(p, round(b, 1), round(e, 1)) for p, b, e in visits_of(truth)]
    assert found == [(Phase.IA, 0.0, 0.4), (Phase.DS, 0.8, 1.3)]


def test_a_robot_that_does_nothing_answers_nothing() -> None:
    encounter, source = hold(1, Setting(keys=True, passersby=0.0, sensor="truth"))
    away = (-1.0, 0.0, 0.0)
    idle = Appearance(0.0, Pose2D(0, 0, math.pi), (0, 0, 1.2), away, None, None, None)
    source.truth = [replace_station(s, idle) for s in source.truth]
    verdict = judge(1, encounter, source)
    assert not verdict.complete
    assert not any(v.answered for v in verdict.visits if v.phase in (Phase.IA, Phase.DS, Phase.CS))


def replace_station(station: Station, robot: Appearance) -> Station:
    return station._replace(robot=robot._replace(t=station.t))


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"robot": "hal"}, UnknownNameError),
        ({"sensor": "x-ray"}, UnknownNameError),
        ({"passersby": 1.5}, ParameterError),
        ({"seed": -1}, ParameterError),
    ],
)
def test_wrong_settings_are_refused(wrong: dict[str, object], error: type[KendonError]) -> None:
    with pytest.raises(error):
        replace(Setting(), **wrong)  # type: ignore[arg-type]
    with pytest.raises(ParameterError):
        hold_all(0, Setting())


# ---- the command


def test_the_command_prints_table_3_8_and_draws(tmp_path: Path) -> None:
    figures = tmp_path / "figures"
    asked = ["experiments", "--bodies", "1", "--model", "kendon", "--out", str(figures)]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    assert "135  0.918" in done.output
    assert "The thesis leaves open" in done.output
    for name in ("thesis.png", "ours.png"):
        assert (figures / name).stat().st_size > 10_000


def test_the_command_holds_encounters() -> None:
    done = CliRunner().invoke(app, ["experiments", "--closed-loop", "3", "--seed", "4"])
    assert done.exit_code == 0, done.output
    assert "3 encounters with" in done.output


@pytest.mark.parametrize(
    "wrong",
    [
        ["--closed-loop", "2", "--robot", "hal"],
        ["--closed-loop", "2", "--sensor", "x-ray"],
        ["--closed-loop", "2", "--model", "nobody"],
        ["--closed-loop", "2", "--seed", "-1"],
        ["--closed-loop", "2", "--jobs", "0"],
        ["--closed-loop", "2", "--jobs", "-2"],
        ["--closed-loop", "2", "--bodies", "5"],
        ["--robot", "mujoco", "--keys"],
        ["--jobs", "2"],
        ["--model", "nobody"],
    ],
)
def test_mistakes_are_refused_in_one_sentence(wrong: list[str]) -> None:
    done = CliRunner().invoke(app, ["experiments", *wrong])
    assert isinstance(done.exception, KendonError)
    assert "\n" not in str(done.exception)

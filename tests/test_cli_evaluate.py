"""`kendon evaluate` as its users meet it: good input, bad input, exit codes."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from command_line import Kendon, Run
from evaluation_data import learn_distances, pass_by, unknown, walk_up

from kendon import load_model
from kendon.evaluation import BASELINES
from kendon.greetings import write_greetings
from kendon.models import save_model
from kendon.observations import write_observations
from kendon.person import Track
from kendon.tracks import write_track

Evaluate = Callable[..., Run]


@pytest.fixture
def kendon(kendon: Kendon) -> Evaluate:
    """Runs `kendon evaluate`."""
    return partial(kendon, "evaluate")


@pytest.fixture(scope="module")
def people(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of four greetings and a passer-by."""
    folder = tmp_path_factory.mktemp("people") / "set"
    write_greetings(folder, [*(walk_up(f"ann {i}", 3.0 + i) for i in range(4)), pass_by("bob")])
    return folder


@pytest.fixture(scope="module")
def track(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A track of somebody who walks up, without a word of gestures."""
    t = np.arange(0, 6, 0.1)
    distance = np.maximum(1.0, 5.0 - 1.2 * np.maximum(0, t - 1))
    head = np.stack([distance, np.zeros(len(t)), np.full(len(t), 1.6)], axis=1)
    phases = np.select([t < 1, distance > 3, distance > 1], [1, 4, 5], 6)
    path = tmp_path_factory.mktemp("tracks") / "cem.csv"
    write_track(Track.build(t, head, phases=phases), path)
    return path


def test_the_tables_tell_everything(kendon: Evaluate, people: Path) -> None:
    run = kendon(people, "--splits", "2")
    assert run.code == 0
    assert "4 greetings" in run.out
    assert "1 passer-by" in run.out
    for words in ("kendon (filter)", "kendon (viterbi)", "data-driven (filter)", "state machine",
                  "zones", "learned robust (filter)", "[s]", "2 random splits", "±"):  # fmt: skip
        assert words in run.out
    assert run.err == ""


def test_numbers_for_programs_stand_alone_on_standard_output(
    kendon: Evaluate, people: Path, tmp_path: Path
) -> None:
    report = tmp_path / "report.html"
    run = kendon(people, "--json", "-", "--report", report, "--seed", "3", "--decoder", "filter")
    assert run.code == 0
    record = json.loads(run.out)
    assert [r["name"] for r in record["readers"]] == [
        "trained (filter)", "kendon (filter)", "data-driven (filter)", "state machine", "zones",
    ]  # fmt: skip
    assert record["settings"]["seed"] == 3
    assert record["command"].startswith("kendon evaluate ")
    assert "report" in run.err
    assert record["command"].replace("&", "&amp;") in report.read_text(encoding="utf-8")


def test_the_same_command_gives_the_same_numbers(
    kendon: Evaluate, people: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Something that learns faster than EM; that one learns in the test of the tables.
    monkeypatch.setattr("kendon.cli.evaluate.learned_readers", learn_distances)

    def record(*arguments: str) -> dict[str, object]:
        target = tmp_path / "numbers.json"
        assert kendon(people, "--json", target, "--splits", "3", *arguments).code == 0
        content: dict[str, object] = json.loads(target.read_text(encoding="utf-8"))
        del content["command"]
        return content

    first = record()
    assert record() == first
    assert record("--jobs", "2") == first
    assert record("--seed", "1")["splits"] != first["splits"]


def test_the_first_model_is_the_reference(kendon: Evaluate, people: Path, tmp_path: Path) -> None:
    save_model(load_model("kendon"), tmp_path / "mine.toml")
    run = kendon(
        people, "--model", tmp_path / "mine.toml", "--model", "data-driven", "--decoder", "viterbi",
        "--json", "-",
    )  # fmt: skip
    record = json.loads(run.out)
    assert record["reference"] == "mine (viterbi)"
    twin = next(r for r in record["readers"] if r["name"] == "kendon (viterbi)")
    assert twin["difference"] == {"value": 0.0, "low": 0.0, "high": 0.0}


def test_gestures_and_sensors_change_what_is_observed(kendon: Evaluate, track: Path) -> None:
    def recall(*arguments: str) -> float:
        run = kendon(track, "--json", "-", "--decoder", "filter", *arguments)
        assert run.code == 0
        reader = json.loads(run.out)["readers"][0]
        return float(reader["phases"]["CS"]["recall"])

    assert recall("--gestures-from-phases") >= recall()
    noisy = json.loads(kendon(track, "--json", "-", "--sensor", "noisy").out)
    assert noisy["settings"]["sensor"] == "noisy"
    told = kendon(track)
    assert "no gesture information" in told.err
    assert "no gesture information" not in kendon(track, "--gestures-from-phases").err


def test_figures_go_into_their_folder(
    kendon: Evaluate, track: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # One reader's figures take a second, and the others' are drawn the same way.
    monkeypatch.setattr("kendon.cli.evaluate.model_readers", lambda *_: [])
    monkeypatch.setattr("kendon.cli.evaluate.BASELINES", BASELINES[:1])
    run = kendon(track, "--figures", tmp_path / "new" / "figures")
    assert run.code == 0
    drawn = {file.name for file in (tmp_path / "new" / "figures").iterdir()}
    assert {"accuracy.png", "recall.svg", "timelines_state_machine.png"} <= drawn
    assert f"{len(drawn)} figures" in run.out


def test_help_has_examples(kendon: Evaluate) -> None:
    run = kendon("--help")
    assert run.code == 0
    assert "Examples" in run.out


def test_comparing_without_figures_does_not_wait_for_matplotlib(people: Path) -> None:
    code = (
        "import sys; from kendon.cli import main\n"
        f"sys.argv = ['kendon', 'evaluate', {str(people)!r}, '--json', '-']\n"
        "try: main()\nfinally: print(*sys.modules, file=sys.stderr)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert {"matplotlib", "joblib", "distributed"}.isdisjoint(run.stderr.split())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--model", "kendom"], ["kendom", "did you mean 'kendon'"]),
        (["--model", "none.toml"], ["none.toml", "no such model file"]),
        (["--decoder", "magic"], ["magic", "viterbi"]),
        (["--sensor", "broken"], ["broken", "noisy"]),
        (["--seed", "-1"], ["--seed", "-1"]),
        (["--splits", "-1"], ["--splits", "-1"]),
        (["--jobs", "0"], ["--jobs", "0"]),
        (["--jobs", "-2"], ["--jobs", "-2"]),
        (["--cluster", "tcp://127.0.0.1:9"], ["--cluster", "--splits"]),
        (["--report", "report.txt"], ["report.txt", ".html"]),
        (["--report", "."], ["."]),
        (["--json", "."], ["--json", "folder"]),
        (["--json", f"{__file__}/numbers.json"], ["numbers.json", "is not a folder"]),
        (["--json", "same.html", "--report", "same.html"], ["--json", "--report", "same.html"]),
        (["--figures", __file__], ["--figures", "is a file"]),
        (["nobody.csv"], ["nobody.csv"]),
        (["--gestures-from-phases"], ["gestures", "tracks"]),
        (["--sensor", "noisy"], ["sensors", "tracks"]),
    ],
)
def test_a_mistake_is_one_sentence_and_exit_code_2(
    kendon: Evaluate, people: Path, arguments: list[str], words: list[str], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    run = kendon(people, *arguments)
    assert run.code == 2
    assert "Traceback" not in run.err
    for word in words:
        assert word in run.err
    assert run.out == ""
    assert list(tmp_path.iterdir()) == []


def test_nothing_labelled_is_one_sentence(kendon: Evaluate, tmp_path: Path) -> None:
    write_observations(pass_by("bob"), tmp_path / "bob.csv")
    write_observations(unknown("????"), tmp_path / "who.csv")
    run = kendon(tmp_path)
    assert run.code == 2
    assert "no greeting with true phases" in run.err


def test_one_greeting_cannot_be_split(kendon: Evaluate, track: Path) -> None:
    run = kendon(track, "--splits", "3")
    assert run.code == 2
    assert "at least two greetings" in run.err


def test_results_never_overwrite_a_recording(kendon: Evaluate, track: Path) -> None:
    before = track.read_bytes()
    run = kendon(track, "--json", track)
    assert run.code == 2
    assert "overwrite" in run.err
    assert track.read_bytes() == before


def test_a_cluster_without_dask_names_the_extra(
    kendon: Evaluate, people: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    run = kendon(people, "--splits", "2", "--cluster", "tcp://127.0.0.1:9")
    assert run.code == 2
    assert "kendon[cluster]" in run.err


@pytest.mark.filterwarnings("default")  # Dask's, of which kendon knows nothing
def test_a_cluster_gives_what_this_machine_gives(kendon: Evaluate, people: Path) -> None:
    distributed = pytest.importorskip(
        "distributed", reason="Dask is not installed; it is the extra 'cluster'"
    )
    alone = json.loads(kendon(people, "--splits", "3", "--json", "-").out)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, protocol="tcp",
        host="127.0.0.1", dashboard_address="127.0.0.1:0",
    ) as local:  # fmt: skip
        address = local.scheduler_address
        run = kendon(people, "--splits", "3", "--json", "-", "--cluster", address)
    assert run.code == 0
    assert json.loads(run.out)["splits"] == alone["splits"]

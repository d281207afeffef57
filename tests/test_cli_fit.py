"""`kendon fit` as its users meet it."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner, Result

from kendon.cli.fit import EPILOG, fit_command
from kendon.errors import KendonError
from kendon.greetings import write_greetings
from kendon.models import Family, load_model, sample
from kendon.observations import Observations

app = typer.Typer()
app.command(epilog=EPILOG)(fit_command)


def kendon_fit(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(a) for a in arguments], env={"COLUMNS": "160"})


def refusal(*arguments: str | Path) -> str:
    """The sentence the command fails with; `kendon` prints it and exits with 2."""
    result = kendon_fit(*arguments)
    assert isinstance(result.exception, KendonError), result.output
    return str(result.exception)


@pytest.fixture(scope="module")
def greetings() -> list[Observations]:
    """As a file can have them: gestures are probabilities, no smile is negative."""
    low = np.array([0.0, -9, 0, 0, 0, 0, 0])
    high = np.array([20.0, 9, 9, 5, 1, 1, 1])
    return [
        dataclasses.replace(g, values=g.values.clip(low, high))
        for g in sample(load_model("kendon"), [30] * 30, seed=1)
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, greetings: list[Observations]) -> Path:
    folder = tmp_path_factory.mktemp("greetings")
    write_greetings(folder, greetings)
    return folder


def test_a_labelled_set_gives_a_model_that_estimates(
    folder: Path, tmp_path: Path, greetings: list[Observations]
) -> None:
    target = tmp_path / "new" / "mine.toml"
    result = kendon_fit(folder, "--out", target, "--title", "Mine")
    assert result.exit_code == 0, result.output
    model = load_model(target)
    assert (model.name, model.title, model.family) == ("mine", "Mine", Family.ROBUST)
    assert model.outliers == 0.01
    right = [(model.decode(g.values) == g.phases).mean() for g in greetings]
    assert np.mean(right) > 0.95
    for part in (
        "distance [m]",
        "smile [0–5]",
        "900 rows of 30 greetings",
        "Mine",
    ):
        assert part in result.output
    assert "±" in result.output


def test_without_labels_states_are_named(folder: Path, tmp_path: Path) -> None:
    target = tmp_path / "learned.toml"
    result = kendon_fit(folder, "--ignore-labels", "--starts", "6", "--seed", "1", "--out", target)
    assert result.exit_code == 0, result.output
    assert load_model(target).family is Family.GAUSSIAN
    assert "margin" in result.output
    assert "the best of 6 starts" in result.output


def test_the_share_of_wild_values_is_kept(folder: Path, tmp_path: Path) -> None:
    target = tmp_path / "wild.toml"
    assert kendon_fit(folder, "--outliers", "0.05", "--out", target).exit_code == 0
    assert load_model(target).outliers == 0.05
    assert "--family robust" in refusal(
        folder, "--outliers", "0.05", "--family", "gaussian", "--out", tmp_path / "x.toml"
    )


def test_an_existing_file_is_only_overwritten_by_force(folder: Path, tmp_path: Path) -> None:
    target = tmp_path / "mine.toml"
    target.write_text("precious")
    assert "--force" in refusal(folder, "--out", target)
    assert target.read_text() == "precious"
    assert kendon_fit(folder, "--out", target, "--force").exit_code == 0
    assert load_model(target).name == "mine"


def test_mistakes_leave_nothing_behind(folder: Path, tmp_path: Path) -> None:
    assert "ends in .toml" in refusal(folder, "--out", tmp_path / "mine.json")
    empty = tmp_path / "empty"
    empty.mkdir()
    assert "no CSV file" in refusal(empty, "--out", tmp_path / "mine.toml")
    torn = tmp_path / "torn.csv"
    torn.write_text("t,distance,speed,gaze,smile,dsal,csal,hdip\n0.2,far,0,1,1,0,0,0\n")
    assert "'far' is not a number" in refusal(folder, torn, "--out", tmp_path / "mine.toml")
    (tmp_path / "folder.toml").mkdir()
    assert "folder" in refusal(folder, "--out", tmp_path / "folder.toml")
    assert "tracks of people" in refusal(
        folder, "--gestures-from-phases", "--out", tmp_path / "mine.toml"
    )
    assert list(tmp_path.glob("mine*")) == []


def test_people_who_do_not_greet_are_mentioned(
    folder: Path, tmp_path: Path, greetings: list[Observations]
) -> None:
    passing = dataclasses.replace(
        greetings[0], phases=np.zeros(len(greetings[0]), dtype=np.int64), name="passerby"
    )
    write_greetings(tmp_path / "more", [passing])
    result = kendon_fit(folder, tmp_path / "more", "--out", tmp_path / "mine.toml")
    assert result.exit_code == 0, result.output
    assert "30 rows of people who do not greet" in result.output

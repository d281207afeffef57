"""What programs may rely on: the public names, and the README's own code."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kendon

ROOT = Path(__file__).resolve().parent.parent


def test_the_public_names_are_these() -> None:
    for name in kendon.__all__:
        assert hasattr(kendon, name)
    promised = {
        "Belief", "DataError", "Encounter", "FEATURES", "Greeter", "GreetingModel", "GreetingTree",
        "KendonError", "Observation", "Observations", "PersonFrame", "Phase", "PointRobot",
        "Robot", "Sampler", "Track", "Tracker", "load_model", "model_names", "observe",
        "open_source", "read_observations", "read_track", "write_observations", "write_track",
    }  # fmt: skip
    assert promised <= set(kendon.__all__)


def test_what_is_not_offered_is_told_like_any_missing_attribute() -> None:
    with pytest.raises(AttributeError, match="module 'kendon' has no attribute 'observ'"):
        _ = kendon.observ  # type: ignore[attr-defined]
    assert not hasattr(kendon, "__wrapped__")
    assert set(kendon.__all__) <= set(dir(kendon))


@pytest.mark.parametrize(
    "code",
    [
        "import kendon; kendon.observe, kendon.features.observe, kendon.Track",
        "from kendon import *; observe, Track",
        "from kendon import observe, features, Track; features.observe",
        "import kendon.features; kendon.features.observe, kendon.load_model",
    ],
)
def test_the_public_names_are_there_when_they_are_asked_for(code: str) -> None:
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_model_contract() -> None:
    model = kendon.load_model("kendon")
    assert model.startprob.shape == (6,)
    assert model.transmat.shape == (6, 6)
    assert model.means.shape == model.variances.shape == (6, 7)
    X = np.full((4, 7), np.nan)
    assert model.filter(X).shape == (4, 6)
    assert model.decode(X).shape == (4,)
    assert model.log_likelihood(X) == pytest.approx(0)
    belief = model.tracker().step(X[0])
    assert belief.probabilities.shape == (6,)
    assert belief.phase is kendon.Phase.IA


def test_the_readmes_python_runs_as_written(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, "README.md", "exec"), {})
    assert "Close Salutation" in capsys.readouterr().out


def test_every_command_the_readme_names_exists() -> None:
    from kendon.cli.app import app

    known = {command.name for command in app.registered_commands}
    shell = re.findall(r"```sh\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    named = re.findall(r"^kendon (\w+)", "\n".join(shell), re.MULTILINE)
    assert named
    assert set(named) <= known

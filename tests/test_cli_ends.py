"""How the command line ends: mistakes of typing, readers that go, full disks, Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from importlib.abc import MetaPathFinder
from pathlib import Path

import pytest
from command_line import Kendon

from kendon.outputs import whole_file

PROGRAM = [sys.executable, "-m", "kendon"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            ["greet", "--modle", "x"],
            "there is no option '--modle' (kendon greet --help lists them); did you mean"
            " '--model' or '--model-files' or '--pose-model'?",
        ),
        (["--frobnicate"], "there is no option '--frobnicate' (kendon --help lists them)"),
        (
            ["estimate", "simulated", "--decoder", "magic"],
            "--decoder: 'magic' is not one of 'filter', 'viterbi'; see kendon estimate --help",
        ),
        (["fit"], "missing argument 'FILE_OR_FOLDER...'; see kendon fit --help"),
        (["fit", "people"], "missing option '--out'; see kendon fit --help"),
        (["greet", "--model"], "option '--model' requires an argument; see kendon greet --help"),
        (["greet", "--quiet=3"], "option '--quiet' does not take a value; see kendon greet --help"),
    ],
)
def test_what_is_typed_wrongly_is_told_like_any_other_mistake(
    kendon: Kendon, words: list[str], sentence: str
) -> None:
    run = kendon(*words)
    assert run == (2, "", f"kendon: {sentence}\n")


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["greet", "--speed", "fast"], ["--speed", "valid number", "'fast'"]),
        (["simulate", "--out", "x", "--n", "0"], ["--n", "greater than or equal to 1"]),
        (["simulate", "--out", "x", "--n", "1.5"], ["--n", "valid integer", "'1.5'"]),
        (["greet", "ann", "bob"], ["unexpected", "bob", "kendon greet --help"]),
        (["simulate", "--out", ""], ["--out: an empty name is no folder"]),
        (["gret"], ["no command 'gret'", "greet, play, estimate", "did you mean 'greet'?"]),
    ],
)
def test_a_wrong_value_is_one_line_with_its_place(
    kendon: Kendon, words: list[str], parts: list[str]
) -> None:
    run = kendon(*words)
    assert (run.code, run.out) == (2, "")
    assert run.err.startswith("kendon: ")
    assert run.err.count("\n") == 1
    for part in parts:
        assert part in run.err


def test_kendon_alone_tells_its_commands(kendon: Kendon) -> None:
    run = kendon()
    assert run.code == 2
    assert "greet" in run.out
    assert run.err == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full here")
@pytest.mark.parametrize(("words", "unbuffered"), [(["models"], ""), (["--version"], "1")])
def test_a_full_disk_is_one_sentence(words: list[str], unbuffered: str) -> None:
    with open("/dev/full", "w") as full:
        run = subprocess.run(
            [*PROGRAM, *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False,
            env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
        )  # fmt: skip
    assert run.returncode == 2
    assert run.stderr == "kendon: the standard output: No space left on device\n"


@pytest.mark.skipif(os.name == "nt", reason="pipes end otherwise there")
@pytest.mark.parametrize("words", [["--help"], ["greet"]])
def test_a_reader_that_goes_ends_the_command_without_a_word(words: list[str]) -> None:
    read, write = os.pipe()
    os.close(read)
    try:
        run = subprocess.run(
            [*PROGRAM, *words], stdout=write, stderr=subprocess.PIPE, text=True, check=False
        )
    finally:
        os.close(write)
    assert (run.returncode, run.stderr) == (1, "")


def test_a_command_that_is_ended_leaves_no_half_of_a_file(
    kendon: Kendon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write_trees(_: object, path: Path) -> None:
        with whole_file(path) as part:
            part.write_text("half", encoding="utf-8")
            signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr("kendon.cli.information.write_trees", write_trees)
    before = signal.getsignal(signal.SIGTERM)
    run = kendon("trees", "--export", tmp_path / "mine.xml")
    assert run.code == 128 + signal.SIGTERM
    assert list(tmp_path.iterdir()) == []
    assert signal.getsignal(signal.SIGTERM) is before


def test_ctrl_c_is_one_word(kendon: Kendon, monkeypatch: pytest.MonkeyPatch) -> None:
    def model_names() -> None:
        # Not by a signal: shells have their background jobs ignore it.
        raise KeyboardInterrupt

    monkeypatch.setattr("kendon.cli.information.model_names", model_names)
    assert kendon("models") == (130, "", "kendon: stopped\n")


class _Interrupting(MetaPathFinder):
    """Is interrupted as the commands are imported."""

    def find_spec(self, fullname: str, path: object, target: object = None) -> None:
        if fullname == "kendon.cli.app":
            raise KeyboardInterrupt


def test_ctrl_c_is_one_word_before_anything_has_begun(
    kendon: Kendon, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(sys.modules, "kendon.cli.app", raising=False)
    monkeypatch.setattr(sys, "meta_path", [_Interrupting(), *sys.meta_path])
    assert kendon("models") == (130, "", "kendon: stopped\n")


def test_nothing_is_imported_before_an_interrupt_is_answered() -> None:
    code = "import sys; from kendon.cli import main; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert {"numpy", "typer", "kendon.greeter"}.isdisjoint(run.stdout.split())


@pytest.mark.parametrize(
    ("command", "option"),
    [
        ("greet", ("--out", "{}")),
        ("greet", ("--figure", "{}/a.png")),
        ("greet", ("--picture", "{}/a.png")),
        ("greet", ("--video", "{}/a.mp4")),
        ("greet", ("--record", "{}/a.html")),
        ("estimate simulated", ("--out", "{}")),
        ("estimate simulated", ("--overlay", "{}/a.mp4")),
        ("evaluate people", ("--json", "{}/a.json")),
        ("evaluate people", ("--report", "{}/a.html")),
        ("evaluate people", ("--figures", "{}")),
        ("fit people", ("--out", "{}/a.toml")),
        ("simulate", ("--out", "{}")),
        ("experiments", ("--out", "{}")),
        ("trees", ("--export", "{}/a.xml")),
    ],
    ids=lambda words: words if isinstance(words, str) else words[0],
)
def test_what_cannot_be_written_is_refused_before_the_work(
    kendon: Kendon, command: str, option: tuple[str, str], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    def work(*_: object, **__: object) -> None:
        raise AssertionError("the work has begun")

    monkeypatch.chdir(tmp_path)
    (tmp_path / "people").mkdir()
    (tmp_path / "people" / "ann.csv").touch()
    (tmp_path / "file").touch()
    for place in ("greet.open_source", "estimate.load_observations", "evaluate.load_observations",
                  "fit.load_observations", "simulate.simulate", "experiments.tally",
                  "information.write_trees"):  # fmt: skip
        monkeypatch.setattr(f"kendon.cli.{place}", work)
    name, place = option
    for folder in ("file/far", "/proc/kendon"):
        run = kendon(*command.split(), name, place.format(folder))
        assert (run.code, run.out) == (2, "")
        assert run.err.startswith(f"kendon: {place.format(folder)}: cannot be written")
        assert run.err.count("\n") == 1
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["ann.csv", "file", "people"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--figure", "a.png", "--picture", "./a.png"], "--figure and --picture would both"),
        (["--record", "folder"], "--record names a file, but this is a folder"),
    ],
)
def test_results_that_cannot_all_be_are_refused(
    kendon: Kendon, words: list[str], sentence: str, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    run = kendon("greet", *words)
    assert run.code == 2
    assert sentence in run.err


def test_a_missing_folder_is_made_wherever_a_result_goes(kendon: Kendon, tmp_path: Path) -> None:
    far = tmp_path / "far"
    assert kendon("trees", "--export", far / "trees" / "mine.xml").code == 0
    run = kendon(
        "greet", "simulated:short", "--figure", far / "a" / "short.svg", "--out", far / "b", "-q"
    )
    assert run.code == 0
    assert kendon("simulate", "--n", "2", "--out", far / "c").code == 0
    assert kendon("evaluate", far / "c", "--json", far / "d" / "numbers.json").code == 0
    found = sorted(str(path.relative_to(far)) for path in far.rglob("*.*"))
    assert found == [
        "a/short.svg", "b/commands.csv", "b/phases.csv", "c/greeting_00000.csv",
        "c/greeting_00001.csv", "c/index.csv", "d/numbers.json", "trees/mine.xml",
    ]  # fmt: skip


@pytest.mark.skipif(os.name == "nt", reason="needs a shell that closes what it passes on")
def test_a_command_runs_where_its_output_was_closed_before_it_began() -> None:
    closed = subprocess.run(
        ["sh", "-c", 'exec "$@" >&- 2>&-', "sh", *PROGRAM, "models"], check=False
    )
    assert closed.returncode == 0

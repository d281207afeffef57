"""`kendon play`, `kendon greet --view` and `--record` as their users meet them."""

from __future__ import annotations

import socket
import sys
from pathlib import Path

import pytest
from command_line import Kendon

pytest.importorskip("viser", reason="viser is not installed")


def test_a_recorded_greeting_is_one_page_beside_the_usual_results(
    kendon: Kendon, tmp_path: Path
) -> None:
    file = tmp_path / "new" / "greeting.html"
    run = kendon("greet", "simulated:short", "--robot", "point", "--record", file)
    assert (run.code, run.err) == (0, "")
    assert "The person  IA → FA → CS" in run.out
    assert str(file) in run.out.replace("\n", "")
    assert "viser" not in run.out
    text = file.read_text(encoding="utf-8")
    assert "simulated:short greeting" in text
    assert "Close Salutation" in text
    assert len(text) > 500_000  # with all that shows it


@pytest.mark.parametrize("command", [("play",), ("greet", "--view")], ids=["play", "greet"])
@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--robot", "nobody"), "there is no robot 'nobody'; valid: point"),
        (("--model", "nothing"), "nothing"),
        (("--port", "70000"), "--port lies between 0 and 65535"),
        (("--host", "192.0.2.77"), "cannot be listened on"),
        (("--record", "replay.png"), "a replay is a .html file"),
        (("--record", "/proc/replay.html"), "cannot be written"),
        (("--tree", "missing.xml"), "missing.xml"),
    ],
)
def test_what_cannot_be_shown_is_told_in_one_sentence(
    kendon: Kendon, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...],
    options: tuple[str, str], sentence: str,
) -> None:  # fmt: skip
    # The network guard of the tests would refuse even to look the address up.
    lookup = [(socket.AF_INET, socket.SOCK_STREAM, 6, "", ("192.0.2.77", 8080))]
    if "--host" in options:
        monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: lookup)
    port = () if "--port" in options else ("--port", "0")
    run = kendon(*command, "--no-open", *port, *options)
    assert run.code == 2
    assert run.err.startswith("kendon: ")
    assert sentence in run.err
    assert run.err.count("\n") == 1


def test_a_port_in_use_is_told_before_anything_runs(kendon: Kendon) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        run = kendon("play", "--no-open", "--port", str(port))
    assert run.code == 2
    assert f"port {port} of 127.0.0.1 cannot be listened on" in run.err
    assert "name another with --port" in run.err


def test_an_unknown_scenario_is_told_with_those_there_are(kendon: Kendon) -> None:
    run = kendon("greet", "simulated:nonsense", "--view", "--no-open", "--port", "0")
    assert run.code == 2
    assert "valid: normal, plain, late-wave, short" in run.err


def test_a_page_draws_no_figures(kendon: Kendon, tmp_path: Path) -> None:
    run = kendon("greet", "--view", "--figure", tmp_path / "a.png")
    assert run.code == 2
    assert "leave out either" in run.err


def test_without_viser_the_extra_is_named(
    kendon: Kendon, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in [n for n in sys.modules if n.startswith("kendon.viewer.browser")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "viser", None)
    for command in (("play", "--no-open"), ("greet", "--record", tmp_path / "a.html")):
        run = kendon(*command)
        assert run.code == 2
        assert "pip install 'kendon[view]'" in run.err


def test_help_shows_examples(kendon: Kendon) -> None:
    assert "kendon play --record mine.html" in " ".join(kendon("play", "--help").out.split())
    assert "kendon greet --view" in " ".join(kendon("greet", "--help").out.split())

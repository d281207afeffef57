"""The command `kendon`, run in the tests' own process."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from kendon.cli import main


class Run(NamedTuple):
    """What a run of the command printed and how it ended."""

    code: int
    out: str
    err: str


class Kendon:
    """Runs `kendon` in this process."""

    def __init__(self, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
        self._capsys, self._monkeypatch = capsys, monkeypatch

    def __call__(self, *arguments: str | Path) -> Run:
        self._monkeypatch.setattr(sys, "argv", ["kendon", *map(str, arguments)])
        self._capsys.readouterr()
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
        return Run(code, *self._capsys.readouterr())

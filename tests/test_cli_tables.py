"""Tables on narrow terminals and in pipes: nothing that matters is cut short."""

from __future__ import annotations

import io
from typing import Any

import pytest
from command_line import Kendon
from rich.console import Console
from rich.table import Table

from kendon.cli.tables import print_table

PLAIN: Any = {"markup": False, "color_system": None}
NUMBERS = ("0.962 [0.94, 1.00]", "−0.030 [−0.054, −0.020]")


def printed(width: int, *, terminal: bool) -> list[str]:
    """The lines of a table of words and numbers on a console of that width."""
    table = Table(title="Accuracy [share], and how it differs from the first reader's", box=None)
    table.add_column("reader", no_wrap=True)
    table.add_column("what it is")
    table.add_column("difference", justify="right")
    table.add_column("accuracy", justify="right")
    table.add_row("trained (filter)", "improved on simulated greeters", *reversed(NUMBERS))
    table.add_row("zones", "a baseline", "reference", "1")
    file = io.StringIO()
    print_table(table, Console(file=file, width=width, force_terminal=terminal, **PLAIN))
    return file.getvalue().splitlines()


@pytest.mark.parametrize("width", [20, 40, 80, 200])
@pytest.mark.parametrize("terminal", [True, False])
def test_no_word_and_no_number_is_cut_short(width: int, terminal: bool) -> None:
    lines = printed(width, terminal=terminal)
    assert lines[0] == "Accuracy [share], and how it differs from the first reader's"
    assert "…" not in "\n".join(lines)
    for text in ("trained (filter)", "simulated", "difference", "accuracy", *NUMBERS):
        assert any(text in line for line in lines)


def test_what_is_piped_has_one_line_a_row() -> None:
    assert len(printed(30, terminal=False)) == 4
    assert len(printed(30, terminal=True)) > 4


def test_a_terminal_that_is_wide_enough_is_not_left() -> None:
    assert max(map(len, printed(95, terminal=True))) <= 95


@pytest.mark.parametrize("command", ["models", "robots", "sources", "trees", "doctor"])
def test_lists_are_whole_on_a_narrow_terminal(
    kendon: Kendon, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "kendon.cli.information.out", Console(width=40, force_terminal=True, **PLAIN)
    )
    run = kendon(command)
    assert run.code == 0
    assert "…" not in run.out

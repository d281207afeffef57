"""The tables that `kendon evaluate` prints."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from kendon.cli.tables import print_table
from kendon.evaluation import wording
from kendon.evaluation.results import Evaluation
from kendon.phases import Phase


def print_tables(evaluation: Evaluation, console: Console) -> None:
    """Print accuracy, each phase, delays, passers-by and splits, each if there is any."""
    sentence = f"{wording.material(evaluation)}; {wording.conditions(evaluation)}."
    console.print(sentence, highlight=False)
    tables = [
        _accuracy(evaluation),
        _recall(evaluation),
        _delays(evaluation),
        _passersby(evaluation),
        _splits(evaluation),
    ]
    for table in tables:
        if table is not None:
            console.print()
            print_table(table, console)


def _accuracy(evaluation: Evaluation) -> Table:
    table = _table("Accuracy with its 95 % interval, and the difference to the first reader")
    for head in ("accuracy", "difference", "macro F1"):
        table.add_column(head, justify="right", no_wrap=True)
    for result in evaluation.results:
        table.add_row(
            result.name,
            wording.interval(result.accuracy),
            wording.difference(result.difference),
            wording.number(result.scores.macro_f1),
        )
    return table


def _recall(evaluation: Evaluation) -> Table:
    table = _table("Recall of each phase, and changes of phase found")
    for phase in Phase:
        table.add_column(_head(phase), justify="right")
    table.add_column("changes", justify="right")
    for result in evaluation.results:
        recall = (wording.number(value) for value in result.scores.recall.tolist())
        changes = result.transitions
        table.add_row(result.name, *recall, f"{changes.found}/{changes.true}")
    totals = evaluation.reference.counts.sum(axis=1).tolist()
    table.add_row("observations", *map(str, totals), "", style="dim")
    return table


def _delays(evaluation: Evaluation) -> Table:
    happened = [p for p in Phase if evaluation.reference.delays(p).entries]
    table = _table("Median delay to enter a phase [s], and how many entries were missed")
    for phase in happened:
        table.add_column(_head(phase), justify="right")
    for result in evaluation.results:
        cells = []
        for phase in happened:
            delays = result.delays(phase)
            missed = f" ({delays.missed})" if delays.missed else ""
            cells.append(f"{wording.number(delays.median, 1)}{missed}")
        table.add_row(result.name, *cells)
    entries = (str(evaluation.reference.delays(phase).entries) for phase in happened)
    table.add_row("entries", *entries, style="dim")
    return table


def _passersby(evaluation: Evaluation) -> Table | None:
    number = len(evaluation.material.passersby)
    if not number:
        return None
    people = wording.counted(number, "passer-by", "passers-by")
    table = _table(f"Share of the time in each phase, and how many of {people} ever")
    for phase in Phase:
        table.add_column(_head(phase), justify="right")
    table.add_column("ever DS", justify="right")
    table.add_column("ever CS", justify="right")
    for result in evaluation.results:
        shares = (f"{share:.0%}" for share in result.mean_shares.tolist())
        ever = (str(result.ever(phase)) for phase in (Phase.DS, Phase.CS))
        table.add_row(result.name, *shares, *ever)
    return table


def _splits(evaluation: Evaluation) -> Table | None:
    if not evaluation.spreads:
        return None
    number = len(next(iter(evaluation.spreads.values())).accuracies)
    table = _table(f"Accuracy over {wording.counted(number, 'random split')}")
    table.add_column("mean ± standard deviation", justify="right", no_wrap=True)
    for name, spread in evaluation.spreads.items():
        table.add_row(name, wording.spread(spread))
    return table


def _table(title: str) -> Table:
    table = Table(title=title, box=None, pad_edge=False)
    table.add_column("reader", no_wrap=True)
    return table


def _head(phase: Phase) -> Text:
    return Text(phase.name, style=phase.color)

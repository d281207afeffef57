"""The tables that `kendon experiments` prints."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from kendon.cli.tables import print_table
from kendon.experiments.encounters import Setting
from kendon.experiments.readings import GREETS, Tally
from kendon.experiments.scenes import ASSUMED
from kendon.experiments.verdict import APPROACHED, PERSONAL, Verdict, Visit
from kendon.phases import Phase

#: So many failures are listed.
_LISTED = 20


def print_readings(
    tallies: Mapping[tuple[str, bool], Sequence[Tally]], bodies: int, console: Console
) -> None:
    """Table 3.8 with a column for each model, by keys and detected, then our experiments."""
    for title, ours in (("Table 3.8: labels read correctly", False), ("Six more of ours", True)):
        table = Table(title=title, box=None, pad_edge=False)
        table.add_column("", justify="right")
        table.add_column("experiment")
        table.add_column("labels", justify="right")
        if not ours:
            table.add_column("thesis", justify="right")
        for name, keys in tallies:
            table.add_column(f"{name}\n{'keys' if keys else 'detected'}", justify="right")
        columns = [[t for t in column if bool(t.scene.labels) != ours]
                   for column in tallies.values()]  # fmt: skip
        for row in zip(*columns, strict=True):
            scene = row[0].scene
            cells = [str(scene.number), scene.title, str(row[0].labels)]
            if not ours:
                cells.append(_share(scene.correct, scene.labels))
            table.add_row(*cells, *(_share(t.mean, t.labels) for t in row))
        labels = [sum(t.labels for t in column) for column in columns]
        total = ["", "all", str(labels[0])]
        if not ours:
            first = columns[0]
            total.append(_share(sum(t.scene.correct for t in first), labels[0]))
        sums = (_share(sum(t.mean for t in c), n) for c, n in zip(columns, labels, strict=True))
        table.add_section()
        table.add_row(*total, *sums)
        print_table(table, console)
        console.print()
    console.print(
        "keys: gestures given by hand, as in the thesis. detected: read off the joints of"
        f" {bodies} {'body' if bodies == 1 else 'bodies'}, on average. In ours, somebody who does"
        f" not greet counts as read where the probability of a greeting is below {GREETS:g}.",
        highlight=False,
    )
    console.print("The thesis leaves open, and here it is taken that:")
    for sentence in ASSUMED:
        console.print(f"  · {sentence}", highlight=False)


def _share(correct: float, labels: int) -> str:
    count = f"{correct:.0f}" if correct == int(correct) else f"{correct:.1f}"
    return f"{count}  {correct / labels:.3f}"


def print_encounters(verdicts: Sequence[Verdict], setting: Setting, console: Console) -> None:
    """How the robot answered, phase by phase; what failed."""
    greeters = [v for v in verdicts if v.greets]
    passers = [v for v in verdicts if not v.greets]
    console.print(
        f"{len(verdicts)} encounters with {len(greeters)} people who greet and {len(passers)} who"
        f" pass; robot {setting.robot}, sensor {setting.sensor}, model {setting.model}, gestures"
        f" {'by keys' if setting.keys else 'detected'}, seed {setting.seed}.",
        highlight=False,
    )
    console.print()
    table = Table(title="The robot's answers, as people see them", box=None,
                  pad_edge=False)  # fmt: skip
    for head in ("phase", "shown by", "times", "answered", "delay, median [s]", "95 % [s]"):
        table.add_column(head, justify="left" if head in ("phase", "shown by") else "right")
    visits = [visit for verdict in greeters for visit in verdict.visits]
    for phase in Phase:
        of_phase = [v for v in visits if v.phase is phase]
        kinds = sorted({v.shown for v in of_phase})
        for kind in kinds:
            _row(table, phase.name, kind, [v for v in of_phase if v.shown == kind])
    table.add_section()
    _row(table, "all", "", visits)
    print_table(table, console)
    console.print()
    for sentence in _sentences(greeters, passers):
        console.print(sentence, highlight=False)
    failed = [v for v in verdicts if v.failures]
    if failed:
        console.print()
        console.print(f"Failures, the first {min(len(failed), _LISTED)} of {len(failed)}:")
    for verdict in failed[:_LISTED]:
        what = "; ".join(verdict.failures)
        console.print(f"  {verdict.number:4d} {verdict.temperament}: {what}", highlight=False)


def _row(table: Table, phase: str, kind: str, visits: Sequence[Visit]) -> None:
    delays = [v.delay for v in visits if v.answered]
    numbers = ["–", "–"]
    if delays:
        numbers = [f"{np.median(delays):.2f}", f"{np.quantile(delays, 0.95):.2f}"]
    share = f"{len(delays) / len(visits):.1%}" if visits else "–"
    table.add_row(phase, kind, str(len(visits)), share, *numbers)


def _sentences(greeters: Sequence[Verdict], passers: Sequence[Verdict]) -> list[str]:
    found = []
    if greeters:
        complete = sum(v.complete for v in greeters)
        bodily = sum(v.complete_but_for_heads for v in greeters)
        found += [
            f"Complete, with every phase answered: {complete} of {len(greeters)}"
            f" ({complete / len(greeters):.1%}); but for salutations of the head alone"
            f" {bodily / len(greeters):.1%}.",
            f"Answers in the order of the phases: {sum(v.in_order for v in greeters)}.",
            f"Nearest: {np.median([v.nearest for v in greeters]):.2f} m in the middle,"
            f" {min(v.nearest for v in greeters):.2f} m at the least; the robot itself came nearer"
            f" than {PERSONAL:g} m before the handshake in {sum(v.intruded for v in greeters)}.",
            f"Lost from sight for more than a second: {sum(v.out_of_sight for v in greeters)}."
            f" People stepped back {sum(v.step_backs for v in greeters)} times.",
        ]
    waves = sum(v.unprompted for v in (*greeters, *passers))
    found.append(f"Waves and hands that answered no salutation: {waves}.")
    if passers:
        approached = sum(v.approach > APPROACHED for v in passers)
        found.append(
            f"Passers-by approached by more than {APPROACHED:g} m: {approached} of {len(passers)}"
            f" ({approached / len(passers):.1%})."
        )
    gave_up = Counter(v.gave_up for v in greeters if v.gave_up)
    for reason, count in gave_up.most_common():
        found.append(f"Gave up: {count} times, as {reason}.")
    return found

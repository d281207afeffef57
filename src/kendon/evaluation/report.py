"""An evaluation as one HTML page that needs nothing else: no network, no script, no fonts.

Its figures are drawn into the page; it follows the reader's choice of light or dark, and folds
into one column on a phone.
"""

from __future__ import annotations

import platform
from collections.abc import Iterable, Sequence
from html import escape
from importlib import resources
from pathlib import Path

import numpy as np

from kendon._version import __version__
from kendon.evaluation import drawings, wording
from kendon.evaluation.results import Evaluation, Result
from kendon.observations import Observations
from kendon.outputs import write_text
from kendon.person import IntArray
from kendon.phases import Phase


def write_report(evaluation: Evaluation, path: str | Path) -> None:
    """Write the page, whole or not at all.

    Raises:
        DataError: the file cannot be written.
    """
    write_text(path, page(evaluation))


def page(evaluation: Evaluation) -> str:
    """The page as HTML."""
    style = (resources.files("kendon.evaluation") / "report.css").read_text(encoding="utf-8")
    sections = [
        _summary(evaluation),
        _splits(evaluation),
        _recall(evaluation),
        _delays(evaluation),
        _confusion(evaluation),
        _passersby(evaluation),
        _timelines(evaluation),
        _making(evaluation),
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        '<meta http-equiv="Content-Security-Policy"'
        " content=\"default-src 'none'; style-src 'unsafe-inline'\">\n"
        f"<title>How well the phases of {len(evaluation.material.greetings)} greetings were read"
        f"</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(section for section in sections if section)
        + "\n</main>\n</body>\n</html>\n"
    )


def _summary(evaluation: Evaluation) -> str:
    rows = []
    for result in evaluation.results:
        changes = result.transitions
        rows.append(
            [
                _name(result, evaluation),
                "yes" if result.causal else "no",
                wording.interval(result.accuracy),
                wording.difference(result.difference),
                wording.number(result.scores.macro_f1),
            ]
        )
        rows[-1].append(f"{changes.found} of {changes.true}; {changes.found} of {changes.read}")
    chart = drawings.accuracy_bars(
        [(result.name, result.accuracy) for result in evaluation.results],
        "accuracy [share of observations], with 95 % interval",
    )
    explained = ("accuracy", "difference", "causal", "macro F1", "changes found")
    return (
        "<header><h1>How well the phases of greetings were read</h1>"
        f"<p>{escape(wording.material(evaluation))}; {escape(wording.conditions(evaluation))}.</p>"
        f"{_legend()}</header>\n<section><h2>Accuracy</h2>"
        f'<div class="wide">{chart}</div>'
        + _table(
            ["reader", "causal", "accuracy", "difference", "macro F1",
             "changes found of true; of read"],
            rows,
        )
        + _meanings(explained)
        + "</section>"
    )  # fmt: skip


def _splits(evaluation: Evaluation) -> str:
    if not evaluation.spreads:
        return ""
    number = len(next(iter(evaluation.spreads.values())).accuracies)
    rows = [[escape(n), wording.spread(s)] for n, s in evaluation.spreads.items()]
    return (
        f"<section><h2>Accuracy over {wording.counted(number, 'random split')}</h2>"
        "<p>Mean ± standard deviation of the accuracy on the tested 24 % of the greetings; the"
        " readers called “learned” were trained on the other 76 %, anew for each split.</p>"
        + _table(["reader", "accuracy"], rows)
        + "</section>"
    )


def _recall(evaluation: Evaluation) -> str:
    figures = []
    for phase in Phase:
        observations = int(evaluation.reference.counts[phase.index].sum())
        if observations:
            rows = [(r.name, float(r.scores.recall[phase.index])) for r in evaluation.results]
            figures.append(drawings.recall_bars(phase, rows, observations))
    return (
        "<section><h2>Each phase</h2><p>Of the observations of a phase, the share that was read"
        f" as that phase.</p>{_figures(figures)}</section>"
    )


def _delays(evaluation: Evaluation) -> str:
    happened = [p for p in Phase if evaluation.reference.delays(p).entries]
    rows = [
        [_name(result, evaluation), *(wording.delay(result.delays(p)) for p in happened)]
        for result in evaluation.results
    ]
    heads = [
        f"{p.name} ({wording.counted(evaluation.reference.delays(p).entries, 'entry', 'entries')})"
        for p in happened
    ]
    return (
        "<section><h2>Delay to enter each phase</h2>"
        + _table(["reader", *heads], rows)
        + _meanings(("delay",))
        + "</section>"
    )


def _confusion(evaluation: Evaluation) -> str:
    figures = [
        f"<h3>{_name(result, evaluation)}</h3>"
        + drawings.confusion_matrix(result.counts, result.name)
        for result in evaluation.results
    ]
    return (
        "<section><h2>Which phases are taken for which</h2><p>Observations of each true phase, by"
        " the phase that was read; the darker a cell, the larger its share of the row.</p>"
        f"{_figures(figures)}</section>"
    )


def _passersby(evaluation: Evaluation) -> str:
    number = len(evaluation.material.passersby)
    if not number:
        return ""
    rows = [
        [
            _name(result, evaluation),
            *(f"{share:.1%}" for share in result.mean_shares.tolist()),
            f"{result.ever(Phase.DS)} of {number}",
            f"{result.ever(Phase.CS)} of {number}",
        ]
        for result in evaluation.results
    ]
    chart = drawings.share_bars(
        [(result.name, result.mean_shares) for result in evaluation.results],
        "phases read [share of a passer-by's time]",
    )
    return (
        "<section><h2>People who only pass by</h2><p>They greet nobody: a reading of DS or CS would"
        " make a robot wave or hold out its hand in vain.</p>"
        f'<div class="wide">{chart}</div>'
        + _table(["reader", *(p.name for p in Phase), "ever DS", "ever CS"], rows)
        + "</section>"
    )


def _timelines(evaluation: Evaluation) -> str:
    greetings, passersby, _ = evaluation.material
    seconds = max(_seconds(one) for one in (*greetings, *passersby))
    parts = []
    for place, result in enumerate(evaluation.results):
        figures = []
        for number, (one, read) in enumerate(zip(greetings, result.readings, strict=True)):
            right = wording.number(result.tally.accuracy([number]), 2)
            figures.append(_strip(one, read, seconds, f"accuracy {right}"))
        figures += [
            _strip(one, read, seconds, "passes by")
            for one, read in zip(passersby, result.passing, strict=True)
        ]
        parts.append(
            f"<details{'' if place else ' open'}><summary>{_name(result, evaluation)}</summary>"
            f"{_figures(figures)}</details>"
        )
    return (
        "<section><h2>Every greeting</h2><p>The true phases above, those that were read below."
        f"</p>{_legend()}{''.join(parts)}</section>"
    )


def _strip(one: Observations, read: IntArray, seconds: float, told: str) -> str:
    truth = np.full(len(one), -1) if one.phases is None else one.phases
    drawing = drawings.timeline(one.t, truth, read, one.name, seconds=seconds)
    return f'<h3>{escape(one.name)} <span class="soft">{escape(told)}</span></h3>{drawing}'


def _making(evaluation: Evaluation) -> str:
    facts = [
        ("made with", f"kendon {__version__}, Python {platform.python_version()},"
         f" numpy {np.__version__}"),
        ("seed", str(evaluation.seed)),
        ("evaluated on", wording.material(evaluation)),
        ("observed", wording.conditions(evaluation)),
    ]  # fmt: skip
    unlabelled = evaluation.material.unlabelled
    if unlabelled:
        facts.append(("left out", ", ".join(one.name for one in unlabelled)))
    listed = "".join(f"<dt>{escape(what)}</dt><dd>{escape(how)}</dd>" for what, how in facts)
    command = f"<pre>{escape(evaluation.command)}</pre>" if evaluation.command else ""
    again = "<p>This command makes the same page again:</p>" if command else ""
    return f"<section><h2>How this was made</h2><dl>{listed}</dl>{again}{command}</section>"


def _name(result: Result, evaluation: Evaluation) -> str:
    mark = ' <span class="soft">reference</span>' if result is evaluation.reference else ""
    return f"{escape(result.name)}{mark}"


def _legend() -> str:
    entries = "".join(
        f'<li><i style="background:{p.color}"></i>{p.name} <span class="soft">{p.title}</span></li>'
        for p in Phase
    )
    return f'<ul class="legend">{entries}</ul>'


def _meanings(words: Iterable[str]) -> str:
    items = "".join(f"<dt>{escape(w)}</dt><dd>{escape(wording.MEANINGS[w])}</dd>" for w in words)
    return f"<details><summary>What the numbers mean</summary><dl>{items}</dl></details>"


def _figures(figures: Sequence[str]) -> str:
    return f'<div class="grid">{"".join(f"<figure>{f}</figure>" for f in figures)}</div>'


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; the cells are HTML already."""
    head = "".join(f'<th scope="col">{escape(h)}</th>' for h in heads)
    body = "".join(
        f'<tr><th scope="row">{row[0]}</th>{"".join(f"<td>{cell}</td>" for cell in row[1:])}</tr>'
        for row in rows
    )
    return (
        f'<div class="scroll" tabindex="0"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def _seconds(one: Observations) -> float:
    period = float(np.median(np.diff(one.t))) if len(one) > 1 else 0.2
    return float(one.t[-1] - one.t[0]) + period

"""The figures of a report as SVG to stand inside a page, drawn for a phone's width first.

Every drawing is 340 units wide and scales as a whole, so that its text stays legible on a phone.
Text takes the page's colour, light or dark; phases have theirs (`Phase.color`).
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from kendon.estimate import stretches
from kendon.evaluation.comparison import Interval
from kendon.person import FloatArray, IntArray
from kendon.phases import Phase

WIDTH = 340
_RIGHT = 330  # where axes end
_LEFT = 10  # where those of bars begin
_LEFT_OF_STRIPS = 34  # and those of timelines, after a word


def _svg(height: float, parts: Sequence[str], what: str) -> str:
    return (
        f'<svg viewBox="0 0 {WIDTH} {height:g}" role="img" aria-label="{escape(what)}">'
        f"{''.join(parts)}</svg>"
    )


def _text(x: float, y: float, words: str, *, anchor: str = "start", kind: str = "") -> str:
    look = f' class="{kind}"' if kind else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{look}>{escape(words)}</text>'


def _rect(
    x: float, y: float, width: float, height: float, *, fill: str = "", kind: str = "",
    title: str = "",
) -> str:  # fmt: skip
    look = f' class="{kind}"' if kind else f' fill="{fill}"'
    told = f"<title>{escape(title)}</title>" if title else ""
    return (
        f'<rect x="{x:.2f}" y="{y:.1f}" width="{width:.2f}" height="{height:.1f}"{look}>'
        f"{told}</rect>"
    )


def _axis(
    y: float, end: float, ticks: Sequence[float], label: str, *, top: float, left: float = _LEFT
) -> list[str]:
    """A horizontal axis at `y` from 0 to `end`, with grid lines up to `top` and a label below."""
    parts = []
    for tick in ticks:
        x = left + tick / end * (_RIGHT - left)
        parts.append(f'<line x1="{x:.1f}" y1="{top:.1f}" x2="{x:.1f}" y2="{y:.1f}" class="grid"/>')
        parts.append(_text(x, y + 13, f"{tick:g}", anchor="middle", kind="soft"))
    parts.append(_text((left + _RIGHT) / 2, y + 27, label, anchor="middle", kind="soft"))
    return parts


def accuracy_bars(rows: Sequence[tuple[str, Interval]], label: str) -> str:
    """One bar a reader with its 95 % interval, the first reader's strongest."""
    step = 30
    bottom = 8 + step * len(rows)
    parts = _axis(bottom, 1, (0, 0.2, 0.4, 0.6, 0.8, 1), label, top=4)
    for place, (name, interval) in enumerate(rows):
        y = 8 + step * place
        parts.append(_text(_LEFT, y + 9, name))
        parts.append(_text(_RIGHT, y + 9, _number(interval.value), anchor="end", kind="strong"))
        if np.isfinite(interval.value):
            kind = "bar" if place else "bar first"
            parts.append(_rect(_LEFT, y + 13, _x(interval.value) - _LEFT, 9, kind=kind))
        if np.isfinite(interval.low):
            low, high, middle = _x(interval.low), _x(interval.high), y + 17.5
            parts.append(
                f'<path d="M{low:.1f} {middle - 4}v8M{low:.1f} {middle}H{high:.1f}'
                f'M{high:.1f} {middle - 4}v8" class="whisker"/>'
            )
    return _svg(bottom + 32, parts, label)


def recall_bars(phase: Phase, rows: Sequence[tuple[str, float]], observations: int) -> str:
    """How much of one phase each reader found, in the phase's colour."""
    step = 28
    bottom = 26 + step * len(rows)
    plural = "observation" if observations == 1 else "observations"
    label = f"recall [share of {observations} {plural}]"
    parts = [
        _rect(_LEFT, 3, 11, 11, fill=phase.color),
        _text(_LEFT + 17, 13, f"{phase.name}  {phase.title}", kind="strong"),
        *_axis(bottom, 1, (0, 0.5, 1), label, top=22),
    ]
    for place, (name, recall) in enumerate(rows):
        y = 24 + step * place
        parts.append(_text(_LEFT, y + 9, name))
        parts.append(_text(_RIGHT, y + 9, _number(recall), anchor="end"))
        if np.isfinite(recall):
            parts.append(_rect(_LEFT, y + 13, _x(recall) - _LEFT, 8, fill=phase.color))
    return _svg(bottom + 32, parts, f"{phase.title}: {label}")


def confusion_matrix(counts: IntArray, name: str) -> str:
    """Counts of true phases (rows) read as each phase (columns), shaded by the row's share."""
    left, top, cell = 46, 34, 36
    parts = [
        _text(left + 3 * cell, 11, "phase read", anchor="middle", kind="soft"),
        f'<text transform="translate(10 {top + 3 * cell}) rotate(-90)" text-anchor="middle"'
        ' class="soft">true phase</text>',
        _text(left + 6 * cell + 34, 27, "all", anchor="middle", kind="soft"),
    ]
    totals = counts.sum(axis=1)
    for true in Phase:
        y = top + true.index * cell
        parts.append(_rect(left - 6, y + 2, 4, cell - 4, fill=true.color))
        parts.append(_text(left - 9, y + cell / 2 + 4, true.name, anchor="end"))
        x = left + true.index * cell
        parts.append(_rect(x + 2, top - 5, cell - 4, 3, fill=true.color))
        parts.append(_text(x + cell / 2, top - 8, true.name, anchor="middle"))
        total = int(totals[true.index])
        parts.append(
            _text(left + 6 * cell + 34, y + cell / 2 + 4, str(total), anchor="middle", kind="soft")
        )
        for read in Phase:
            count = int(counts[true.index, read.index])
            share = count / total if total else 0.0
            x = left + read.index * cell
            told = f"{count} of {total} observations of {true.name} read as {read.name}"
            parts.append(
                f'<rect x="{x + 1}" y="{y + 1}" width="{cell - 2}" height="{cell - 2}"'
                f' class="cell" fill-opacity="{0.06 + 0.94 * share:.3f}">'
                f"<title>{told}</title></rect>"
            )
            kind = "onfull" if share > 0.5 else "" if count else "soft"
            parts.append(
                _text(x + cell / 2, y + cell / 2 + 4, str(count), anchor="middle", kind=kind)
            )
    return _svg(top + 6 * cell + 4, parts, f"confusion matrix of {name}")


def timeline(t: FloatArray, truth: IntArray, read: IntArray, name: str, *, seconds: float) -> str:
    """True phases above those that were read, over time.

    Args:
        t: ends of the intervals, (T,) [s].
        truth: (T,).
        read: (T,).
        name: of the greeting.
        seconds: the length of the axis, the same for all greetings.
    """
    period = float(np.median(np.diff(t))) if len(t) > 1 else 0.2
    began = float(t[0]) - period
    edges = np.append(t - period, t[-1:]) - began
    step = next(s for s in (1, 2, 5, 10, 20, 60, 300, 3600, 1e9) if seconds / s <= 8)
    ticks = np.arange(0, seconds + 1e-9, step).tolist()
    parts = _axis(31, seconds, ticks, "time [s]", top=2, left=_LEFT_OF_STRIPS)
    scale = (_RIGHT - _LEFT_OF_STRIPS) / seconds
    for y, label, numbers in ((2, "true", truth), (17, "read", read)):
        parts.append(_text(_LEFT_OF_STRIPS - 5, y + 10, label, anchor="end", kind="soft"))
        for start, stop, number in stretches(numbers):
            begin, end = float(edges[start]), float(edges[stop])
            x, width = _LEFT_OF_STRIPS + begin * scale, (end - begin) * scale
            span = f"{begin:.1f}–{end:.1f} s"
            if number > 0:
                phase = Phase(number)
                told = f"{label}: {phase.name} {span}"
                parts.append(_rect(x, y, width, 13, fill=phase.color, title=told))
            else:
                word = "not greeting" if number == 0 else "not labelled"
                parts.append(_rect(x, y, width, 13, kind="none", title=f"{word} {span}"))
    return _svg(62, parts, f"{name}: true phases above, read phases below")


def share_bars(rows: Sequence[tuple[str, FloatArray]], label: str) -> str:
    """One bar a reader, divided among the phases; shares of shape (6,)."""
    step = 30
    bottom = 8 + step * len(rows)
    parts = _axis(bottom, 1, (0, 0.25, 0.5, 0.75, 1), label, top=4)
    for place, (name, shares) in enumerate(rows):
        y = 8 + step * place
        parts.append(_text(_LEFT, y + 9, name))
        edge = 0.0
        for phase in Phase:
            share = float(shares[phase.index])
            told = f"{phase.name}: {share:.1%} of the time"
            x = _x(edge)
            edge += share
            parts.append(_rect(x, y + 13, _x(edge) - x, 11, fill=phase.color, title=told))
    return _svg(bottom + 32, parts, label)


def _x(share: float) -> float:
    return _LEFT + share * (_RIGHT - _LEFT)


def _number(value: float) -> str:
    return f"{value:.3f}" if np.isfinite(value) else "–"

"""The reading over time as an SVG drawing: the phases' probabilities and the observations."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from kendon.phases import Phase
from kendon.viewer.browser.stage import Snapshot

_INK, _SOFT, _LINE, _GRID = "#222", "#666", "#333", "#e3e3e3"
#: How many columns of a drawing are kept apart; more observations are thinned out.
_FINEST = 300


class Lane(NamedTuple):
    """One row of the drawing under the probabilities."""

    label: str
    field: str
    low: float
    high: float
    form: str  # how the newest value is written


_LANES = (
    Lane("distance", "distance", 0.0, 7.0, "{:.1f} m"),
    Lane("speed", "speed", -0.6, 1.6, "{:+.1f} m/s"),
    Lane("gaze", "gaze", 0.0, 2.0, "{:.1f}"),
    Lane("smile", "smile", 0.0, 5.0, "{:.1f}"),
)
_GESTURES = (("salutes from afar", "dsal", Phase.DS), ("salutes nearby", "csal", Phase.CS),
             ("dips the head", "hdip", Phase.HD))  # fmt: skip
_LEFT, _RIGHT, _TOP = 92, 58, 14
_BELIEF, _ROW, _BAR = 84, 34, 13
_GAP = 5  # between the drawing and the numbers beside it


def draw_charts(
    snapshots: Sequence[Snapshot], start: float, stop: float, *, width: int = 360,
    values: bool = True,
) -> str:  # fmt: skip
    """The observations between two times, as the code of an SVG picture.

    Args:
        snapshots: in the order of time; those without a new observation are passed over.
        start: at the left edge [s].
        stop: at the right edge [s].
        width: of the picture [pixels].
        values: whether the newest `chart_values` are written; else there is an empty group
            ``values`` to write some into.
    """
    read = [s for s in snapshots if s.is_new and s.observation and start <= s.t <= stop + 1e-6]
    read = read[:: max(1, len(read) // _FINEST)]
    plot = width - _LEFT - _RIGHT
    span = max(stop - start, 1e-6)

    def x(t: float) -> float:
        return _LEFT + plot * (t - start) / span

    parts = [_text(_LEFT, 10, "probability of each phase", _SOFT)]
    parts += _belief(read, x)
    y = _TOP + _BELIEF + 8
    for lane in _LANES:
        parts += _lane(lane, read, x, y, plot)
        y += _ROW
    for label, field, phase in _GESTURES:
        parts += _bars(label, field, phase, read, x, y, plot)
        y += _BAR + 4
    parts += _axis(start, stop, x, y)
    height = y + 18
    right = [x(read[-1].t) if read else 0.0, _LEFT + plot]
    written = [
        _text(right[place] + _GAP, level, words, _INK)
        for place, level, words in (chart_values(read[-1]) if values and read else ())
    ]
    return (
        f'<svg viewBox="0 0 {width} {height}" width="100%" role="img"'
        ' aria-label="Probabilities of the phases and observations over time"'
        ' style="display:block;font:11px system-ui,sans-serif">'
        + "".join(parts) + '<g class="values">' + "".join(written) + "</g></svg>"
    )  # fmt: skip


def chart_values(snapshot: Snapshot) -> list[tuple[int, float, str]]:
    """The numbers of one instant, as they stand beside a drawing.

    Returns:
        For each one whether it belongs at the end of what is drawn (0) or at the right edge of
        the drawing (1), how high [pixels], and its text.
    """
    written: list[tuple[int, float, str]] = []
    base = 0.0
    for phase, p in zip(Phase, snapshot.probabilities, strict=False):  # none before a belief
        if p > 0.15:
            level = _TOP + _BELIEF * (1 - base - p / 2) + 4
            written.append((0, round(level, 1), f"{phase.name} {p:.2f}"))
        base += p
    if snapshot.observation is None:
        return written
    y = _TOP + _BELIEF + 8
    for lane in _LANES:
        value = getattr(snapshot.observation, lane.field)
        if not math.isnan(value):
            written.append((1, y + _ROW / 2 + 3, lane.form.format(round(value, 1) + 0.0)))
        y += _ROW
    for _, field, _ in _GESTURES:
        value = getattr(snapshot.observation, field)
        written.append((1, y + _BAR - 3, "–" if math.isnan(value) else f"{value:.1f}"))
        y += _BAR + 4
    return written


def plot_box(width: int = 360) -> tuple[int, int, int]:
    """Of a drawing: where time begins, how wide it is, and where numbers stand [pixels]."""
    return _LEFT, width - _LEFT - _RIGHT, width - _RIGHT + _GAP


def _belief(read: Sequence[Snapshot], x: Callable[[float], float]) -> list[str]:
    parts = []
    rows = [(s.t, s.probabilities) for s in read if s.probabilities]
    below = [0.0] * len(rows)
    for phase in Phase:
        above = [b + row[1][phase.index] for b, row in zip(below, rows, strict=True)]
        if rows and max(a - b for a, b in zip(above, below, strict=True)) > 0.005:
            upper = [(x(r[0]), _TOP + _BELIEF * (1 - a)) for r, a in zip(rows, above, strict=True)]
            lower = [(x(r[0]), _TOP + _BELIEF * (1 - b)) for r, b in zip(rows, below, strict=True)]
            points = _points(upper + lower[::-1])
            parts.append(f'<polygon points="{points}" fill="{phase.color}"/>')
        below = above
    for share in (0, 1):
        parts.append(_text(_LEFT - 6, _TOP + _BELIEF * (1 - share) + 4, f"{share}", _SOFT, "end"))
    return parts


def _lane(
    lane: Lane, read: Sequence[Snapshot], x: Callable[[float], float], y: float, plot: float
) -> list[str]:
    def height(value: float) -> float:
        share = (min(max(value, lane.low), lane.high) - lane.low) / (lane.high - lane.low)
        return y + 3 + (_ROW - 8) * (1 - share)

    parts = [
        f'<rect x="{_LEFT}" y="{y}" width="{plot:.0f}" height="{_ROW - 3}" fill="#f7f7f7"/>',
        _text(_LEFT - 6, y + _ROW / 2 + 3, lane.label, _INK, "end"),
    ]
    zero = 1.0 if lane.field == "gaze" else 0.0
    level = height(zero)
    parts.append(
        f'<line x1="{_LEFT}" x2="{_LEFT + plot:.0f}" y1="{level:.1f}" y2="{level:.1f}"'
        f' stroke="{_GRID}" stroke-dasharray="{"3 3" if lane.field == "gaze" else "none"}"/>'
    )
    run: list[tuple[float, float]] = []
    for snapshot in read:
        value = getattr(snapshot.observation, lane.field)
        if math.isnan(value):
            parts += _stroke(run)
            run = []
        else:
            run.append((x(snapshot.t), height(value)))
    return parts + _stroke(run)


def _stroke(run: list[tuple[float, float]]) -> list[str]:
    if len(run) < 2:
        return []
    return [f'<polyline points="{_points(run)}" fill="none" stroke="{_LINE}" stroke-width="1.5"/>']


def _bars(
    label: str, field: str, phase: Phase, read: Sequence[Snapshot], x: Callable[[float], float],
    y: float, plot: float,
) -> list[str]:  # fmt: skip
    parts = [
        f'<rect x="{_LEFT}" y="{y}" width="{plot:.0f}" height="{_BAR}" fill="#f7f7f7"/>',
        _text(_LEFT - 6, y + _BAR - 3, label, _INK, "end", small=True),
    ]
    for snapshot in read:
        value = getattr(snapshot.observation, field)
        if value > 0.05:
            left, right = max(x(snapshot.t - 0.2), _LEFT), x(snapshot.t)
            parts.append(
                f'<rect x="{left:.1f}" y="{y}" width="{max(0.5, right - left):.1f}"'
                f' height="{_BAR}" fill="{phase.color}" opacity="{value:.2f}"/>'
            )
    return parts


def _axis(start: float, stop: float, x: Callable[[float], float], y: float) -> list[str]:
    span = stop - start
    step = next((s for s in (1, 2, 5, 10, 20, 30, 60, 120) if span / s <= 6), 300)
    first = math.ceil(max(start, 0.0) / step) * step
    parts = []
    t = first
    while t <= stop + 1e-6:
        parts.append(_text(x(t), y + 12, f"{t:g} s", _SOFT, "middle"))
        t += step
    return parts


def _points(points: Sequence[tuple[float, float]]) -> str:
    return " ".join(f"{px:.1f},{py:.1f}" for px, py in points)


def _text(
    x: float, y: float, words: str, color: str, anchor: str = "start", small: bool = False
) -> str:
    size = ' font-size="10"' if small else ""
    return (
        f'<text x="{x:.0f}" y="{y:.0f}" fill="{color}" text-anchor="{anchor}"{size}>{words}</text>'
    )

"""Figures of experiments: labels beside what was read, and encounters in closed loop."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from kendon.estimate import stretches
from kendon.person import IntArray
from kendon.phases import Phase
from kendon.viewer.figure import DARK, INK, SOFT, STYLE, draw_commands, draw_paths, save_figure

if TYPE_CHECKING:
    from kendon.experiments.readings import Reading
    from kendon.experiments.verdict import Verdict
    from kendon.greeter import Encounter
    from kendon.sources.simulated import Station

_NOBODY = "#eeeeee"


def draw_readings(
    rows: Sequence[tuple[str, Sequence[Reading]]], title: str, path: str | Path
) -> None:
    """Draw the labels of experiments, and below them each reading.

    Args:
        rows: what each reading is called, and one a scene; the scenes in the same order.
        title: of the figure.
        path: of the picture.
    """
    count = len(rows[0][1])
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 1.0 + count * (0.5 + 0.27 * len(rows))), layout="constrained")
        FigureCanvasAgg(figure)
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
        panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
        for place, axes in enumerate(panels):
            scene = rows[0][1][place].scene
            axes.set_title(f"{scene.number}  {scene.title}", fontsize=9)
            first = rows[0][1][place]
            _strip(axes, 0, first.observations.t, first.truth)
            names = ["labels"]
            for row, (name, readings) in enumerate(rows, start=1):
                reading = readings[place]
                _strip(axes, -row, reading.observations.t, reading.read)
                _underline(axes, -row, reading.observations.t, reading.right == 0)
                names.append(f"{name}  {reading.correct}/{reading.labels}")
            axes.set_yticks([-i for i in range(len(names))], names, fontsize=7)
            axes.set_ylim(-len(rows) - 0.55, 0.55)
            axes.spines["left"].set_visible(False)
            axes.tick_params(left=False, labelbottom=place == count - 1)
        panels[-1].set_xlabel("time [s]")
        panels[-1].set_xlim(left=0)
        handles = [
            *(Patch(color=p.color, label=f"{p.name}  {p.title}") for p in Phase),
            Patch(color=_NOBODY, label="no greeting"),
            Line2D([], [], color=INK, lw=2.5, label="not read as labelled"),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
        save_figure(figure, Path(path))


def draw_verdict(
    encounter: Encounter, truth: Sequence[Station], verdict: Verdict, path: str | Path
) -> None:
    """Draw an encounter: what the person did, what was read, what the robot did, and the ways."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(13, 5.6), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(2, 2, width_ratios=[2.4, 1], height_ratios=[1, 2.2])
        top = figure.add_subplot(grid[0, 0])
        what = "; ".join(verdict.failures) or "nothing failed"
        top.set_title(f"{encounter.title}: {what}", fontsize=9)
        t = np.array([s.t for s in truth])
        _strip(top, 0, t, np.array([s.phase or 0 for s in truth]))
        _strip(top, -1, np.array([m.t for m in encounter.moments]), encounter.moment_phases)
        for visit in verdict.visits:
            if visit.answered:
                top.plot(visit.answer, -2, "^", color=visit.phase.color, mec=INK, ms=7)
            else:
                top.plot((visit.begin + visit.end) / 2, -2, "x", color=INK, ms=7, mew=2)
        top.set_yticks([0, -1, -2], ["really", "read", "answered"])
        top.set_ylim(-2.6, 0.55)
        top.tick_params(labelbottom=False, left=False)
        below = figure.add_subplot(grid[1, 0], sharex=top)
        draw_commands(below, encounter)
        below.set_xlabel("time [s]")
        below.set_xlim(0, encounter.duration)
        draw_paths(figure.add_subplot(grid[:, 1]), encounter)
        figure.legend(
            handles=[
                *(Patch(color=p.color, label=f"{p.name}  {p.title}") for p in Phase),
                Line2D([], [], marker="^", ls="", mfc=_NOBODY, mec=INK, label="the robot answers"),
                Line2D([], [], marker="x", ls="", color=INK, mew=2, label="it does not"),
            ],
            loc="outside lower center", ncols=4, frameon=False,
        )  # fmt: skip
        save_figure(figure, Path(path))


def _strip(axes: Axes, row: float, t: np.ndarray, phases: IntArray) -> None:
    """Phases over time as a coloured strip; 0 is no greeting."""
    width = float(np.median(np.diff(t))) if len(t) > 1 else 0.2
    edges = np.append(t - width, t[-1:])
    whole = edges[-1] - edges[0]
    for start, stop, number in stretches(phases):
        color = Phase(number).color if number > 0 else _NOBODY
        begin, end = edges[start], edges[stop]
        axes.barh(row, end - begin, left=begin, height=0.8, color=color, lw=0)
        if number > 0 and end - begin > 0.025 * whole:
            axes.text(
                (begin + end) / 2, row, Phase(number).name, ha="center", va="center", fontsize=7,
                color="white" if Phase(number) in DARK else INK,
            )  # fmt: skip
    axes.axhline(row - 0.5, color="white", lw=1)
    axes.tick_params(colors=SOFT)


def _underline(axes: Axes, row: float, t: np.ndarray, wrong: np.ndarray) -> None:
    """Mark the stretches of a strip that are wrong, at its foot: its letters stay readable."""
    width = float(np.median(np.diff(t))) if len(t) > 1 else 0.2
    for start, stop, marked in stretches(wrong.astype(int)):
        if marked:
            axes.barh(
                row - 0.36, t[stop - 1] - t[start] + width, left=t[start] - width, height=0.16,
                color=INK, lw=0,
            )  # fmt: skip

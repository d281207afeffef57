"""One figure that tells a whole encounter: the reading, the person, the robot, their paths."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from matplotlib.patheffects import withStroke

from kendon.errors import DataError
from kendon.estimate import stretches
from kendon.observations import FEATURES, Observations
from kendon.outputs import whole_file
from kendon.person import FloatArray
from kendon.phases import Phase

if TYPE_CHECKING:
    from kendon.greeter import Encounter

_LANES = ("base", "head", "arms", "voice", "face")
#: Phases on whose colour white letters read better.
DARK = (Phase.FA, Phase.CS)
INK, SOFT, GRID = "#222222", "#777777", "#dddddd"
STYLE: Any = {
    "font.size": 9, "axes.edgecolor": SOFT, "axes.labelcolor": INK, "xtick.color": INK,
    "ytick.color": INK, "axes.spines.top": False, "axes.spines.right": False,
    "axes.titlesize": 10, "axes.titleweight": "bold", "axes.titlelocation": "left",
}  # fmt: skip


def draw_encounter(encounter: Encounter, path: str | Path) -> None:
    """Draw an encounter into a picture file (.png, .svg or .pdf).

    Raises:
        DataError: the file cannot be written, or its format is none of matplotlib's.
    """
    path = Path(path)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(13, 9.2), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(
            7, 2, width_ratios=[2.5, 1], height_ratios=[3.2, 1, 1, 1, 1, 0.8, 2.2]
        )
        top = figure.add_subplot(grid[0, 0])
        draw_belief(top, encounter.observations.t, encounter.probabilities)
        top.set_title(f"{encounter.title}: which phase is the person in?")
        panels = [figure.add_subplot(grid[row, 0], sharex=top) for row in range(1, 7)]
        draw_observations(panels[:5], encounter.observations)
        draw_commands(panels[5], encounter)
        for axes in (top, *panels[:-1]):
            axes.tick_params(labelbottom=False)
        panels[-1].set_xlabel("time [s]")
        panels[-1].set_xlim(0, encounter.duration)
        draw_paths(figure.add_subplot(grid[:6, 1]), encounter)
        legend = figure.add_subplot(grid[6, 1])
        legend.axis("off")
        legend.legend(
            handles=[Patch(color=p.color, label=f"{p.name}  {p.title}") for p in Phase],
            loc="center", frameon=False, title="Kendon's phases", alignment="left",
        )  # fmt: skip
        save_figure(figure, path)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure to a file.

    Raises:
        DataError: the file cannot be written.
    """
    with whole_file(path) as part:
        try:
            figure.savefig(part, dpi=110)
        except ValueError as error:  # of the ending
            raise DataError(str(error), file=path) from None


def draw_belief(axes: Axes, t: FloatArray, probabilities: FloatArray) -> None:
    """The six probabilities stacked over time, the most probable phase as a strip above.

    Args:
        axes: to draw on.
        t: ends of the intervals, (T,) [s].
        probabilities: (T, 6).
    """
    width = float(np.median(np.diff(t))) if len(t) > 1 else 0.2
    edges = np.append(t - width, t[-1:])
    bottom = np.zeros(len(t))
    for phase in Phase:
        share = probabilities[:, phase.index]
        axes.stairs(bottom + share, edges, baseline=bottom, fill=True, color=phase.color, lw=0)
        bottom = bottom + share
    for start, stop, number in stretches(probabilities.argmax(axis=1) + 1):
        phase = Phase(number)
        axes.axvspan(edges[start], edges[stop], 1.02 / 1.12, 1, color=phase.color, lw=0)
        if edges[stop] - edges[start] > 0.025 * (edges[-1] - edges[0]):
            axes.text(
                (edges[start] + edges[stop]) / 2, 1.07, phase.name,
                ha="center", va="center", color="white", fontsize=8, fontweight="bold",
            )  # fmt: skip
    axes.set_ylim(0, 1.12)
    axes.set_yticks([0, 0.5, 1])
    axes.set_ylabel("probability")


def draw_observations(panels: list[Axes], observations: Observations) -> None:
    """Distance, speed, gaze and smile over time, and the gestures as bars; five panels."""
    t, values = observations.t, observations.values
    labels = ("distance\n[m]", "speed\n[m/s]", "gaze\n[1]", "smile\n[0–5]")
    for axes, column, label in zip(panels, range(4), labels, strict=False):
        axes.plot(t, values[:, column], color=INK, lw=1.3)
        axes.set_ylabel(label, rotation=0, ha="right", va="center")
        axes.grid(axis="y", color=GRID, lw=0.6)
        axes.margins(y=0.15)
    panels[0].set_ylim(bottom=0)
    panels[2].set_ylim(0, 2.1)
    panels[2].axhline(1, color=SOFT, lw=0.8, ls=":")
    panels[2].annotate(
        "looks at the robot below this line", (1, 1), xycoords=("axes fraction", "data"),
        ha="right", va="bottom", fontsize=7, color=SOFT,
    )  # fmt: skip
    gestures = panels[4]
    for row, phase in enumerate((Phase.DS, Phase.CS, Phase.HD)):
        column = FEATURES.index(("dsal", "csal", "hdip")[row])
        for time, value in zip(t, values[:, column], strict=True):
            if value > 0.05:
                gestures.barh(
                    -row, 0.2, left=time - 0.2, height=0.7, color=phase.color, alpha=value
                )
    gestures.set_yticks(
        [0, -1, -2], ["salutes from afar", "salutes nearby", "dips the head"], fontsize=7
    )
    gestures.set_ylim(-2.6, 0.6)
    if not np.isfinite(values[:, 4:]).any():
        gestures.text(
            0.5, 0.5, "no gesture information", transform=gestures.transAxes,
            ha="center", va="center", fontsize=8, color=SOFT,
        )  # fmt: skip


def draw_commands(axes: Axes, encounter: Encounter) -> None:
    """The robot's commands over time, a lane for each part of its body."""
    axes.set_title("What the robot does")
    letter = encounter.duration * 0.0085  # the width of one, roughly
    stretches = encounter.stretches
    for place, (action, end, _) in enumerate(stretches):
        row = -_LANES.index(action.channel)
        color = action.phase.color if action.phase else SOFT
        length = max(end - action.start, 0.06)
        axes.barh(row, length, left=action.start, height=0.55, color=color, lw=0)
        axes.plot(action.start, row, marker="|", ms=11, color=INK, mew=1.2)
        follows = (a.start for a, _, _ in stretches[place + 1 :] if a.channel == action.channel)
        free = next(follows, encounter.duration) - action.start - length
        short = action.label.removeprefix("look ").removesuffix(" high")
        texts = [t for t in (action.label, short) if len(t) * letter <= max(length, free)]
        if not texts:
            continue
        inside = len(texts[0]) * letter <= length  # else behind its bar, where nothing is
        axes.annotate(
            texts[0], (action.start + (0 if inside else length), row), xytext=(4, 0),
            textcoords="offset points", va="center", fontsize=7,
            color="white" if inside and action.phase in DARK else INK,
        )  # fmt: skip
    axes.set_yticks([-i for i in range(len(_LANES))], _LANES)
    axes.set_ylim(-len(_LANES) + 0.4, 0.6)


def draw_paths(axes: Axes, encounter: Encounter) -> None:
    """Where the two went, seen from above."""
    person, robot = encounter.person_path, encounter.robot_path
    axes.set_title("From above")
    phases = encounter.moment_phases
    for start, stop, number in stretches(phases):
        color = Phase(number).color if number else SOFT
        part = slice(start, min(stop + 1, len(person)))
        axes.plot(person[part, 1], person[part, 0], color=color, lw=4, solid_capstyle="round")
    axes.plot(robot[:, 1], robot[:, 0], color=INK, lw=2)
    for path, marker, label in ((person, "o", "person"), (robot[:, :2], "s", "robot")):
        known = path[np.isfinite(path).all(axis=1)]
        if not len(known):
            continue
        axes.plot(known[0, 1], known[0, 0], marker, ms=9, mfc="white", mec=INK, mew=1.5)
        axes.plot(known[-1, 1], known[-1, 0], marker, ms=9, color=INK)
        axes.annotate(
            label, (known[0, 1], known[0, 0]), xytext=(12, 0), textcoords="offset points",
            va="center", fontsize=9,
        )  # fmt: skip
    end = robot[-1]
    for radius, zone in ((1.2, "personal"), (3.6, "social")):  # Hall (1966)
        axes.add_patch(Circle((end[1], end[0]), radius, fill=False, ec=GRID, lw=1, zorder=0))
        axes.annotate(
            f"{zone} {radius} m", (end[1], end[0] + radius), ha="center", va="bottom",
            fontsize=7, color=SOFT, path_effects=[withStroke(linewidth=3, foreground="white")],
        )  # fmt: skip
    both = np.vstack([person, robot[:, :2]])
    low, high = np.nanmin(both, axis=0), np.nanmax(both, axis=0)
    middle = (low[1] + high[1]) / 2
    half = max(1.6, (high[1] - low[1]) / 2 + 0.6)
    axes.set_xlim(middle + half, middle - half)  # y grows to the left, as the robot sees it
    axes.set_ylim(low[0] - 0.7, high[0] + 0.7)
    axes.set_aspect("equal")
    axes.set_xlabel("y, to the left [m]")
    axes.set_ylabel("x, ahead of the robot's start [m]")
    axes.legend(
        handles=[
            Line2D([], [], marker="o", ls="", mfc="white", mec=INK, label="start"),
            Line2D([], [], marker="o", ls="", color=INK, label="end"),
        ],
        loc="best", frameon=False, fontsize=8,
    )  # fmt: skip

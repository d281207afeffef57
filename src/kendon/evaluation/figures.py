"""The figures of an evaluation for papers and slides, drawn by matplotlib into files."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from kendon.estimate import stretches
from kendon.evaluation.results import Evaluation, Result
from kendon.observations import Observations
from kendon.outputs import whole_file
from kendon.person import IntArray
from kendon.phases import PHASE_NAMES, Phase

_INK, _SOFT, _GRID = "#222222", "#777777", "#dddddd"
_STYLE: Any = {
    "font.size": 9, "axes.edgecolor": _SOFT, "axes.labelcolor": _INK, "xtick.color": _INK,
    "ytick.color": _INK, "axes.spines.top": False, "axes.spines.right": False,
    "axes.titlesize": 10, "axes.titleweight": "bold", "axes.titlelocation": "left",
    # So that the same evaluation makes the same file, and its text stays text.
    "svg.hashsalt": "kendon", "svg.fonttype": "none",
}  # fmt: skip
_FORMATS = (".png", ".svg")


def draw_figures(evaluation: Evaluation, folder: str | Path) -> list[Path]:
    """Draw accuracy and recall of all readers, and each one's confusions and timelines.

    Returns:
        The files, each figure as .png and .svg.

    Raises:
        DataError: a file cannot be written.
    """
    folder = Path(folder)
    files: list[Path] = []

    def draw(name: str, width: float, height: float, how: Callable[[Figure], None]) -> None:
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        how(figure)
        files.extend(_save(figure, folder / name))

    results = evaluation.results
    strips = len(evaluation.material.greetings) + len(evaluation.material.passersby)
    with mpl.rc_context(_STYLE):
        draw("accuracy", 6, 1 + 0.3 * len(results), lambda f: _accuracy(f, evaluation))
        draw("recall", 8, 1.2 + 0.4 * len(results), lambda f: _recall(f, evaluation))
        for result, name in zip(results, _file_names(evaluation), strict=True):
            draw(f"confusion_{name}", 4.2, 4, partial(_confusion, result=result))
            timelines = partial(_timelines, result=result, evaluation=evaluation)
            draw(f"timelines_{name}", 8, 1.2 + 0.42 * strips, timelines)
    return files


def _file_names(evaluation: Evaluation) -> list[str]:
    """A name for each reader that any file system takes, told apart by a number if need be."""
    names: list[str] = []
    for result in evaluation.results:
        name = re.sub(r"[^a-z0-9-]+", "_", result.name.lower()).strip("_") or "reader"
        again = sum(other == name or other.startswith(f"{name}_") for other in names)
        names.append(f"{name}_{again + 1}" if name in names else name)
    return names


def _save(figure: Figure, stem: Path) -> list[Path]:
    files = [stem.with_name(stem.name + ending) for ending in _FORMATS]
    for file in files:
        # No date: the same evaluation makes the same file.
        metadata = {"Date": None} if file.suffix == ".svg" else None
        with whole_file(file) as part:
            figure.savefig(part, dpi=160, metadata=metadata)
    return files


def _accuracy(figure: Figure, evaluation: Evaluation) -> None:
    axes = figure.add_subplot()
    for place, result in enumerate(evaluation.results):
        value, low, high = result.accuracy
        axes.plot(value, -place, "o", color=_INK, ms=5)
        axes.plot([low, high], [-place, -place], color=_INK, lw=1.2)
    axes.set_yticks(
        [-i for i in range(len(evaluation.results))], [r.name for r in evaluation.results]
    )
    axes.set_ylim(-len(evaluation.results) + 0.4, 0.6)
    axes.set_xlim(0, 1)
    axes.grid(axis="x", color=_GRID, lw=0.6)
    axes.set_xlabel("accuracy [share of observations], with 95 % interval")


def _recall(figure: Figure, evaluation: Evaluation) -> None:
    names = [result.name for result in evaluation.results]
    panels = figure.subplots(1, len(Phase), sharey=True)
    for phase, axes in zip(Phase, panels, strict=True):
        recall = [result.scores.recall[phase.index] for result in evaluation.results]
        for i, share in enumerate(recall):
            if np.isfinite(share):
                axes.barh(-i, share, 0.65, color=phase.color)
            else:  # the phase never happens: that is no recall of 0
                axes.text(0.03, -i, "–", va="center", color=_SOFT)
        axes.set_ylim(-len(names) + 0.4, 0.6)
        axes.set_xlim(0, 1)
        axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])
        axes.grid(axis="x", color=_GRID, lw=0.6)
        axes.set_axisbelow(True)
        count = int(evaluation.reference.counts[phase.index].sum())
        axes.set_title(f"{phase.name} ({count})")
    panels[0].set_yticks([-i for i in range(len(names))], names)
    figure.supxlabel("recall [share of the phase's observations, their number above]", fontsize=9)


def _confusion(figure: Figure, result: Result) -> None:
    axes: Axes = figure.add_subplot()
    totals = result.counts.sum(axis=1, keepdims=True)
    shares = result.counts / np.maximum(totals, 1)
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1.15)
    for true in range(len(Phase)):
        for read in range(len(Phase)):
            axes.text(
                read, true, str(result.counts[true, read]), ha="center", va="center",
                color="white" if shares[true, read] > 0.55 else _INK,
            )  # fmt: skip
    axes.set_xticks(range(len(Phase)), PHASE_NAMES)
    axes.set_yticks(range(len(Phase)), PHASE_NAMES)
    axes.spines[:].set_visible(False)
    axes.set_xlabel("phase read")
    axes.set_ylabel("true phase")
    axes.set_title(f"{result.name}: observations")


def _timelines(figure: Figure, result: Result, evaluation: Evaluation) -> None:
    axes: Axes = figure.add_subplot()
    greetings, passersby, _ = evaluation.material
    everyone = [*greetings, *passersby]
    for row, (one, read) in enumerate(
        zip(everyone, (*result.readings, *result.passing), strict=True)
    ):
        if one.phases is not None:
            _strip(axes, one, one.phases, -row + 0.19)
        _strip(axes, one, read, -row - 0.17)
    axes.set_yticks([-row for row in range(len(everyone))], [one.name for one in everyone])
    axes.set_ylim(-len(everyone) + 0.5, 0.5)
    axes.set_xlim(left=0)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set_xlabel("time [s]")
    axes.set_title(f"{result.name}: true phases above, read phases below")
    figure.legend(
        handles=[Patch(color=p.color, label=f"{p.name}  {p.title}") for p in Phase],
        loc="outside lower center", ncols=3, frameon=False,
    )  # fmt: skip


def _strip(axes: Axes, one: Observations, numbers: IntArray, y: float) -> None:
    period = float(np.median(np.diff(one.t))) if len(one) > 1 else 0.2
    edges = np.append(one.t - period, one.t[-1:]) - (one.t[0] - period)
    for start, stop, number in stretches(numbers):
        color, edge = (Phase(number).color, "none") if number > 0 else ("none", _GRID)
        axes.barh(y, edges[stop] - edges[start], 0.32, left=edges[start], color=color, ec=edge)

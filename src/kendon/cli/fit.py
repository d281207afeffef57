"""`kendon fit`: a greeting model learned from greetings."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
from rich.table import Table
from rich.text import Text

from kendon.cli.options import (
    CameraPoseOption,
    FovOption,
    FpsOption,
    GesturesOption,
    ModelFilesOption,
    RobotFaceOption,
    SourceOption,
    err,
    note,
    out,
    point,
    source_options,
)
from kendon.cli.tables import print_table
from kendon.cli.targets import check_targets
from kendon.errors import DataError, ParameterError
from kendon.evaluation.wording import counted
from kendon.geometry import Vec3
from kendon.greetings import expand, load_observations
from kendon.models import Family, Fit, GreetingModel, fit, load_model, save_model
from kendon.models.learning import OUTLIERS
from kendon.observations import FEATURES, UNITS, Observations
from kendon.phases import Phase
from kendon.sources import SourceOptions

EPILOG = """
**Examples**

`kendon fit greetings/ --out mine.toml` · then `kendon estimate person.csv --model mine.toml`

`kendon fit greetings/ --conditional --initial kendon --out reader.toml` · Kendon's model, improved

`kendon fit greetings/ --ignore-labels --family gaussian --starts 50 --out learned.toml`
"""

_COLUMNS = (
    TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn(),
    TextColumn("{task.fields[detail]}", markup=False),
)  # fmt: skip


def fit_command(
    paths: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE_OR_FOLDER...",
            help="Greetings: observations, tracks and more, folders or indexes of them.",
        ),
    ],
    target: Annotated[Path, typer.Option("--out", help="The model file to write, .toml.")],
    family: Annotated[
        Family | None,
        typer.Option(
            help="The thesis's normal distributions, or ones that stand wild values; robust if not"
            " given, gaussian if there are phases without labels."
        ),
    ] = None,
    ignore_labels: Annotated[
        bool, typer.Option("--ignore-labels", help="Learn without the true phases in the files.")
    ] = False,
    starts: Annotated[
        int | None,
        typer.Option(
            min=1, help="How often to start from chance when there are unlabelled phases; 60."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same model.")] = 0,
    iterations: Annotated[int, typer.Option(min=1, help="At most so many a start.")] = 100,
    outliers: Annotated[
        float | None,
        typer.Option(help=f"Share of wild values, robust family only; {OUTLIERS:g} if not given."),
    ] = None,
    conditional: Annotated[
        bool,
        typer.Option(
            "--conditional",
            help="Learn to tell phases apart, not what they are like: needs a true phase on every"
            " row.",
        ),
    ] = False,
    initial: Annotated[
        str | None,
        typer.Option(help="A model to learn on from: a name, or a .toml file.", metavar="MODEL"),
    ] = None,
    title: Annotated[str, typer.Option(help="What the model is, for lists and figures.")] = "",
    force: Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")] = False,
    robot_face: RobotFaceOption = "0,0,1.2",
    gestures_from_phases: GesturesOption = False,
    source: SourceOption = None,
    camera_pose: CameraPoseOption = "0,0,1.2",
    fov: FovOption = None,
    fps: FpsOption = None,
    model_files: ModelFilesOption = None,
) -> None:
    """Learn a greeting model from greetings, labelled or not."""
    _check_target(target, force)
    if outliers is not None and family is Family.GAUSSIAN:
        raise ParameterError("--outliers is for --family robust; a normal distribution has none")
    begin = load_model(initial) if initial else None
    options = source_options(camera_pose, fov, fps, model_files)
    face = point("--robot-face", robot_face)
    greetings = _read(paths, options, source, face, gestures_from_phases)
    with Progress(*_COLUMNS, console=err, transient=True, disable=not err.is_terminal) as progress:
        task = progress.add_task("learning", total=iterations, detail="")

        def tell(start: int, iteration: int, height: float) -> None:
            progress.update(
                task, completed=iteration,
                detail=f"log P(phases) a row {height:.4f}" if conditional
                else f"start {start + 1}, log posterior {height:.2f}",
            )  # fmt: skip

        result = fit(
            greetings, family=family, labels=not ignore_labels, starts=starts, seed=seed,
            iterations=iterations, outliers=OUTLIERS if outliers is None else outliers,
            initial=begin, conditional=conditional, progress=tell,
        )  # fmt: skip
    model = dataclasses.replace(result.model, name=target.stem, title=title or result.model.title)
    save_model(model, target)
    _report(result, model)
    out.print(f"The model is in {target}.", highlight=False)


def _check_target(target: Path, force: bool) -> None:
    """Refuse, before any work, a file that could not be written or should not be."""
    if target.suffix != ".toml":
        raise DataError("a model file ends in .toml", file=target)
    check_targets([("--out", target)])
    if target.exists() and not force:
        raise DataError("this file is there already; --force overwrites it", file=target)


def _read(
    paths: list[str],
    options: SourceOptions,
    source: str | None,
    face: Vec3,
    gestures_from_phases: bool,
) -> list[Observations]:
    files = expand(paths)
    greetings = []
    told: set[str] = set()

    def tell_once(sentence: str) -> None:
        if sentence not in told:
            told.add(sentence)
            note(sentence)

    with Progress(*_COLUMNS, console=err, transient=True, disable=not err.is_terminal) as progress:
        task = progress.add_task("reading", total=len(files), detail="")
        for file in files:
            progress.update(task, advance=1, detail=Path(file).name)
            greetings.append(
                load_observations(
                    file, options, source=source, robot_face=face,
                    gestures_from_phases=gestures_from_phases, note=tell_once,
                )
            )  # fmt: skip
    return greetings


def _report(result: Fit, model: GreetingModel) -> None:
    print_table(_means(model), out)
    if result.assignment is not None:
        print_table(_names(result), out)
    rows = f"{counted(result.rows, 'row')} of {counted(result.greetings, 'greeting')}"
    if result.improvement is not None:
        found = result.improvement
        out.print(
            f"{rows}: the true phases' mean probability went from"
            f" {math.exp(found.before):.3f} to {math.exp(found.after):.3f}"
            f" a row in {found.iterations} iterations",
            highlight=False,
        )
        for sentence in result.notes:
            note(sentence)
        return
    steps = "iteration" if result.iterations == 1 else "iterations"
    ending = "" if result.converged else ", not converged"
    of = f", the best of {len(result.starts)} starts" if len(result.starts) > 1 else ""
    out.print(
        f"{rows}:"
        f" log-likelihood {result.log_likelihoods[-1]:.2f}"
        f" after {result.iterations} {steps}{ending}{of}",
        highlight=False,
    )
    for sentence in result.notes:
        note(sentence)
    if not result.converged:
        note("EM had not converged; more --iterations may fit better")
    if result.assignment is not None and result.assignment.ambiguous:
        names = ", ".join(phase.name for phase in result.assignment.ambiguous)
        note(f"{names}: ambiguous, the state might as well have another name; label some greetings")


def _means(model: GreetingModel) -> Table:
    table = Table(
        title=f"{model.title} ({model.family}; mean ± standard deviation)",
        box=None, pad_edge=False, collapse_padding=True,
    )  # fmt: skip
    table.add_column("phase")
    for feature in FEATURES:
        unit = UNITS[feature]
        heading = feature if unit in ("1", "probability") else f"{feature} [{unit}]"
        table.add_column(heading, justify="right")
    for phase in Phase:
        means = model.means[phase.index].tolist()
        deviations = (model.variances[phase.index] ** 0.5).tolist()
        cells = [f"{m:z.2f}±{s:.2f}" for m, s in zip(means, deviations, strict=True)]
        table.add_row(Text(phase.name, style=phase.color), *cells)
    return table


def _names(result: Fit) -> Table:
    table = Table(
        title="States named after the phases they are like",
        box=None, pad_edge=False,
    )  # fmt: skip
    for column in ("phase", "difference", "margin", ""):
        table.add_column(column, justify="right" if column in ("difference", "margin") else "left")
    assert result.assignment is not None
    for name, *cells in result.assignment.rows():
        table.add_row(Text(name, style=Phase[name].color), *cells)
    return table

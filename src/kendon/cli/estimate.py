"""`kendon estimate`: phases for recorded people."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.progress import Progress, SpinnerColumn, TextColumn
from rich.table import Table
from rich.text import Text

from kendon.cli.options import (
    CalibrationOption,
    CameraPoseOption,
    FovOption,
    FpsOption,
    GesturesOption,
    ModelFilesOption,
    ModelOption,
    PersonOption,
    PoseModelOption,
    RobotFaceOption,
    SourceOption,
    err,
    note,
    out,
    point,
    source_options,
)
from kendon.cli.tables import print_table
from kendon.cli.targets import check_targets, folder_name
from kendon.cli.watching import Watching
from kendon.errors import DataError, ParameterError
from kendon.estimate import Decoder, Estimate, estimate, stretches
from kendon.features import PERIOD
from kendon.greetings import expand, load_observations
from kendon.models import DEFAULT_MODEL, load_model
from kendon.observations import Observations
from kendon.person import PersonFrame, Track
from kendon.phases import Phase
from kendon.sources import Source, SourceOptions
from kendon.tables import is_observations

EPILOG = """
**Examples**

`kendon estimate recordings/*.csv --out phases/`

`kendon estimate openface.csv --camera-pose 0.1,0,1.1,0,10 --decoder viterbi`

`kendon estimate greeting.mp4 --fov 70 --out phases/ --overlay seen.mp4` · see why

`kendon estimate --camera 0 --calibration camera.yaml --seconds 60 --out phases/` · live
"""


def estimate_command(
    files: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="FILE", help="Recordings: tracks, videos and more, or folders of them."
        ),
    ] = None,
    camera: Annotated[
        int | None,
        typer.Option(
            min=0, help="Read this camera, live, until Ctrl-C or --seconds; 0 is the first."
        ),
    ] = None,
    seconds: Annotated[
        float | None, typer.Option(help="Read no more than so many seconds of a video or camera.")
    ] = None,
    overlay: Annotated[
        Path | None,
        typer.Option(
            help="Draw what is seen and believed into this video (.mp4 or .avi); for one video or"
            " camera."
        ),
    ] = None,
    model: ModelOption = DEFAULT_MODEL,
    decoder: Annotated[
        Decoder, typer.Option(help="As a robot knows it at the time, or the best whole path.")
    ] = Decoder.FILTER,
    robot_face: RobotFaceOption = "0,0,1.2",
    gestures_from_phases: GesturesOption = False,
    folder: Annotated[
        Path | None,
        typer.Option(
            "--out",
            parser=folder_name,
            metavar="DIR",
            help="Write NAME.csv for each file into this folder.",
        ),
    ] = None,
    source: SourceOption = None,
    camera_pose: CameraPoseOption = "0,0,1.2",
    fov: FovOption = None,
    fps: FpsOption = None,
    model_files: ModelFilesOption = None,
    calibration: CalibrationOption = None,
    pose_model: PoseModelOption = None,
    person: PersonOption = None,
) -> None:
    """Read the greeting phases of people, recorded or live before a camera."""
    files = [str(file) for file in expand(files or [])]
    if camera is not None:
        files.append(f"camera:{camera}")
    options = source_options(camera_pose, fov, fps, model_files, calibration, pose_model, person)
    face = point("--robot-face", robot_face)
    greeting_model = load_model(model)
    targets = _targets(files, folder)
    _check_overlay(overlay, files)
    check_targets(
        [("--overlay", overlay), *(("--out", target) for target in targets)],
        [("--out", folder)], [*files, model, calibration, pose_model],
    )  # fmt: skip
    watching = Watching(greeting_model, face, seconds, overlay)
    _check_observations(files, source, watching)
    # Everything is read before anything is written: a bad file leaves nothing half-done.
    observed = _observe_all(files, options, source, watching, gestures_from_phases)
    _require_somebody(files, observed)
    estimates = [estimate(o, greeting_model, decoder) for o in observed]
    for result, target in zip(estimates, targets, strict=bool(folder)):
        result.write(target)
    print_table(_summary(files, estimates, f"{greeting_model.name}, {decoder.value}"), out)
    if folder:
        out.print(f"{len(targets)} file{'s' * (len(targets) != 1)} written to {folder}")
    elif len(files) == 1:
        print_table(_timeline(estimates[0]), out)
    if not gestures_from_phases and not any(_gestures_known(o) for o in observed):
        note(
            "no gesture information in the input; salutations and dips are read from distance,"
            " speed, gaze and smile alone"
        )


def _check_overlay(overlay: Path | None, files: list[str]) -> None:
    """Refuse what cannot be drawn or read.

    Raises:
        ParameterError: there is nothing to read, or an overlay of several files is asked for.
    """
    if not files:
        raise ParameterError("name a recording to read, or a camera: --camera 0")
    if overlay is None:
        return
    if len(files) != 1:
        raise ParameterError(f"--overlay draws one video or camera, not {len(files)} sources")


def _require_somebody(files: list[str], observed: list[Observations]) -> None:
    """Refuse to read phases off nothing: what came out would be the model's odds alone.

    Raises:
        DataError: a file holds no known value.
    """
    for file, observations in zip(files, observed, strict=True):
        if np.isnan(observations.values).all():
            raise DataError("nobody is seen in it: no value is known", file=file)


def _check_observations(files: list[str], source: str | None, watching: Watching) -> None:
    """Refuse what only sources can do, of a file that holds the observations themselves.

    Raises:
        ParameterError: an overlay or an end is asked for.
    """
    for option, asked in (("--overlay", watching.overlay), ("--seconds", watching.seconds)):
        for file in files:
            if asked is not None and source is None and is_observations(file):
                raise ParameterError(f"{option} is for videos and cameras; {file} is observations")


def _targets(files: list[str], folder: Path | None) -> list[Path]:
    """Where each file's phases go.

    Raises:
        ParameterError: two files would go to the same place.
    """
    if folder is None:
        return []
    targets: dict[Path, str] = {}
    for file in files:
        # skeletons.txt#1-2 names two people of a file; camera:0 is a name, too, not a path.
        path, _, people = file.partition("#")
        stem = Path(path).stem.replace(":", "-") + (f"_{people}" if people else "")
        target = folder / f"{stem}.csv"
        if target in targets:
            raise ParameterError(f"{targets[target]} and {file} would both be written to {target}")
        targets[target] = file
    return list(targets)


def _observe_all(
    files: list[str],
    options: SourceOptions,
    source: str | None,
    watching: Watching,
    gestures_from_phases: bool,
) -> list[Observations]:
    results = []
    told: set[str] = set()

    def tell_once(sentence: str) -> None:
        if sentence not in told:
            told.add(sentence)
            note(sentence)

    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False))
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as progress:
        task = progress.add_task("reading")
        for number, file in enumerate(files, 1):
            name = f"{Path(file).name} ({number} of {len(files)})"
            progress.update(task, description=f"reading {name}")
            shown = time.monotonic()

            def tell(frame: PersonFrame, name: str = name) -> None:
                nonlocal shown
                if time.monotonic() - shown > 0.2:
                    shown = time.monotonic()
                    progress.update(task, description=f"reading {name}: {frame.t:.1f} s")

            def record(opened: Source, tell: Callable[[PersonFrame], None] = tell) -> Track:
                return watching.record(opened, tell, tell_once)

            results.append(
                load_observations(
                    file, options, source=source, robot_face=watching.face,
                    gestures_from_phases=gestures_from_phases, record=record,
                )
            )  # fmt: skip
    return results


def _gestures_known(observations: Observations) -> bool:
    gestures = observations.values[:, 4:]
    return bool((gestures == gestures).any())


def _summary(files: list[str], estimates: list[Estimate], title: str) -> Table:
    truth_known = any(e.score[1] for e in estimates)
    table = Table(title=f"Phases read ({title})", box=None, pad_edge=False)
    table.add_column("file", no_wrap=True)
    table.add_column("s", justify="right")
    table.add_column("phases")
    if truth_known:
        table.add_column("right", justify="right")
        table.add_column("accuracy", justify="right")
    right = labelled = 0
    for file, result in zip(files, estimates, strict=True):
        score = result.score
        right, labelled = right + score[0], labelled + score[1]
        row: list[str | Text] = [
            Path(file).name, f"{len(result.phases) * PERIOD:.1f}", phase_line(result),
        ]  # fmt: skip
        if truth_known:
            row += [f"{score[0]}/{score[1]}", f"{result.accuracy:.3f}"] if score[1] else ["–", "–"]
        table.add_row(*row)
    if truth_known and len(files) > 1:
        table.add_section()
        table.add_row("all", "", "", f"{right}/{labelled}", f"{right / labelled:.3f}", style="bold")
    return table


def phase_line(result: Estimate) -> Text:
    """The phases of an estimate in their colours, joined by arrows."""
    line = Text()
    for i, phase in enumerate(result.sequence):
        line.append(" → " if i else "", style="dim")
        line.append(phase.name, style=phase.color)
    return line


def _timeline(result: Estimate) -> Table:
    """When each phase was entered, for a single file."""
    table = Table(box=None, pad_edge=False)
    for column in ("from [s]", "to [s]", "phase"):
        table.add_column(column, justify="left" if column == "phase" else "right")
    t = result.observations.t
    for start, stop, number in stretches(result.phases):
        phase = Phase(number)
        table.add_row(
            f"{t[start] - PERIOD:.1f}", f"{t[stop - 1]:.1f}",
            Text(f"{phase.name}  {phase.title}", style=phase.color),
        )  # fmt: skip
    return table

"""`kendon evaluate`: how well phases are read, with numbers, a report and figures."""

from __future__ import annotations

import contextlib
import json
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from kendon.cli.evaluate_tables import print_tables
from kendon.cli.options import GesturesOption, check_jobs, err, note, out
from kendon.cli.targets import check_targets, folder_name
from kendon.errors import DataError, ParameterError
from kendon.estimate import Decoder
from kendon.evaluation import (
    BASELINES,
    Evaluation,
    Material,
    Spread,
    evaluate,
    learned_readers,
    model_readers,
    random_splits,
    repeated_splits,
    sort_material,
)
from kendon.evaluation.cluster import dask_cluster, require_dask
from kendon.evaluation.report import write_report
from kendon.greetings import expand, load_observations
from kendon.models import DEFAULT_MODEL
from kendon.observations import Observations
from kendon.outputs import write_text
from kendon.person import Track

EPILOG = """
**Examples**

`kendon evaluate recordings/ --gestures-from-phases --report report.html`

`kendon evaluate test/index.csv --model mine.toml --decoder filter --json results.json`

`kendon evaluate recordings/ --splits 15 --jobs -1` · the thesis's table 3.5, on all cores

`kendon evaluate recordings/ --splits 200 --cluster tcp://10.0.0.1:8786` · on a Dask cluster
"""

#: Programs read the numbers from here.
STANDARD_OUTPUT = Path("-")


class Decoders(StrEnum):
    """Which decoders read."""

    FILTER = "filter"
    VITERBI = "viterbi"
    BOTH = "both"

    @property
    def chosen(self) -> list[Decoder]:
        """The decoders that the word stands for."""
        return list(Decoder) if self is Decoders.BOTH else [Decoder(self.value)]


class Sensor(StrEnum):
    """What observes the people of the recordings."""

    CLEAN = "clean"
    NOISY = "noisy"


def evaluate_command(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE...", help="Greetings with true phases, or folders or indexes of them."
        ),
    ],
    model: Annotated[
        list[str] | None,
        typer.Option(
            help="A model's name or file; may be given several times. The first is what the"
            " others are compared with; the thesis's models always join in."
        ),
    ] = None,
    decoder: Annotated[
        Decoders, typer.Option(help="As a robot knows it at the time, the best whole path, or both")
    ] = Decoders.BOTH,
    gestures_from_phases: GesturesOption = False,
    sensor: Annotated[
        Sensor, typer.Option(help="As recorded, or as a worse sensor would have seen it.")
    ] = Sensor.CLEAN,
    seed: Annotated[int, typer.Option(help="Of everything that is drawn at random.")] = 0,
    splits: Annotated[
        int,
        typer.Option(
            metavar="N", help="Also train and test on so many random splits (76 % / 24 %)."
        ),
    ] = 0,
    jobs: Annotated[
        int, typer.Option(metavar="N", help="Processes for the splits; -1 = one for each core.")
    ] = 1,
    cluster: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Compute the splits on this Dask cluster instead."),
    ] = None,
    json_file: Annotated[
        Path | None,
        typer.Option("--json", metavar="FILE|-", help="Write the numbers for programs."),
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="Write a report with figures, one .html page.")
    ] = None,
    figures: Annotated[
        Path | None,
        typer.Option(parser=folder_name, metavar="DIR", help="Draw the figures into this folder."),
    ] = None,
) -> None:
    """Compare how well models read the phases of greetings, with baselines and intervals."""
    _check_numbers(seed, splits, jobs, cluster)
    paths = expand(files)
    _check_targets(json_file, report, figures, [*paths, *(model or [])])
    if cluster:
        require_dask()
    readers = [*model_readers(model or [DEFAULT_MODEL], decoder.chosen), *BASELINES]
    material = _load(paths, gestures_from_phases, sensor, seed)
    with _progress("reading phases", len(readers)) as step:
        evaluation = evaluate(material, readers, seed=seed, progress=step)
    evaluation = replace(
        evaluation,
        command=shlex.join(["kendon", *sys.argv[1:]]),
        sensor=sensor.value,
        gestures_from_phases=gestures_from_phases,
    )
    if splits:
        spreads = _repeat(evaluation, decoder.chosen, splits, jobs, cluster)
        evaluation = replace(evaluation, spreads=spreads)
    if json_file == STANDARD_OUTPUT:
        typer.echo(_json(evaluation), nl=False)
    else:
        print_tables(evaluation, out)
    _write(evaluation, json_file, report, figures)
    if not gestures_from_phases and not any(_gestures_known(g) for g in material.greetings):
        note(
            "no gesture information in the input; salutations and dips are read from distance,"
            " speed, gaze and smile alone"
        )


def _check_numbers(seed: int, splits: int, jobs: int, cluster: str | None) -> None:
    if seed < 0:
        raise ParameterError(f"--seed must be 0 or more, not {seed}")
    if splits < 0:
        raise ParameterError(f"--splits must be 0 or more, not {splits}")
    check_jobs(jobs)
    if cluster is not None and not splits:
        raise ParameterError("--cluster is where splits are computed; ask for them with --splits N")


def _check_targets(
    json_file: Path | None,
    report: Path | None,
    figures: Path | None,
    inputs: Sequence[Path | str],
) -> None:
    """Refuse before the work what could not be written after it.

    Raises:
        DataError: a result cannot be written where it is to be.
        ParameterError: two results, or a result and a recording, would be the same file.
    """
    if report and report.suffix.lower() not in (".html", ".htm"):
        raise DataError("a report is an .html file", file=report)
    numbers = None if json_file == STANDARD_OUTPUT else json_file
    check_targets([("--json", numbers), ("--report", report)], [("--figures", figures)], inputs)


def _load(
    paths: Sequence[Path | str], gestures_from_phases: bool, sensor: Sensor, seed: int
) -> Material:
    observed = []
    worse = _worse(sensor, seed)
    with _progress("reading recordings", len(paths)) as step:
        for path in paths:
            observed.append(
                load_observations(path, gestures_from_phases=gestures_from_phases, sensor=worse)
            )
            step()
    return sort_material(observed)


def _worse(sensor: Sensor, seed: int) -> Callable[[Track], Track] | None:
    """What the sensor makes of a track, or nothing if it sees all there is."""
    if sensor is Sensor.CLEAN:
        return None
    from kendon.simulation.sensors import sensor as named_sensor

    return named_sensor(sensor.value, seed)


def _repeat(
    evaluation: Evaluation, decoders: list[Decoder], number: int, jobs: int, cluster: str | None
) -> dict[str, Spread]:
    greetings = evaluation.material.greetings
    splits = random_splits(len(greetings), number, seed=evaluation.seed)
    with _progress("training and testing", number) as step:
        return repeated_splits(
            greetings,
            splits,
            {result.name: result.tally for result in evaluation.results},
            partial(learned_readers, decoders=decoders),
            n_jobs=jobs,
            backend=dask_cluster(cluster) if cluster else None,
            progress=step,
        )


def _write(
    evaluation: Evaluation, json_file: Path | None, report: Path | None, figures: Path | None
) -> None:
    # Where stdout carries the numbers, nothing else may stand there.
    console = err if json_file == STANDARD_OUTPUT else out
    if json_file and json_file != STANDARD_OUTPUT:
        write_text(json_file, _json(evaluation))
        console.print(f"The numbers are in {json_file}.", highlight=False, soft_wrap=True)
    if report:
        write_report(evaluation, report)
        console.print(f"The report is in {report}.", highlight=False, soft_wrap=True)
    if figures:
        # matplotlib takes a second to import: only those who draw wait for it.
        from kendon.evaluation.figures import draw_figures

        drawn = draw_figures(evaluation, figures)
        console.print(f"{len(drawn)} figures are in {figures}.", highlight=False, soft_wrap=True)


def _json(evaluation: Evaluation) -> str:
    return json.dumps(evaluation.record(), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def _gestures_known(observations: Observations) -> bool:
    gestures = observations.values[:, 4:]
    return bool((gestures == gestures).any())


@contextlib.contextmanager
def _progress(what: str, total: int) -> Iterator[Callable[[], None]]:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bar:
        task = bar.add_task(what, total=total)
        yield lambda: bar.advance(task)

"""`kendon experiments`: the thesis's experiments again, ours, and encounters in closed loop."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress

from kendon.cli.experiments_tables import print_encounters, print_readings
from kendon.cli.options import check_jobs, err, out
from kendon.cli.targets import check_targets, folder_name
from kendon.errors import ParameterError
from kendon.experiments.encounters import TRUTH, Setting, hold, hold_all
from kendon.experiments.readings import read, tally
from kendon.experiments.scenes import OURS, SCENES, THESIS
from kendon.experiments.verdict import judge
from kendon.models import DEFAULT_MODEL, load_model, model_names
from kendon.robots import DEFAULT_ROBOT
from kendon.simulation.sensors import SENSORS

EPILOG = """
**Examples**

`kendon experiments` · table 3.8 again, with every model that comes with kendon

`kendon experiments --model mine.toml --out figures/` · with your own, drawn

`kendon experiments --closed-loop 500 --sensor noisy --jobs -1` · people and robot react
"""
#: So many bodies act each experiment unless told otherwise.
BODIES = 20
#: So many failed encounters are drawn.
DRAWN = 3


def experiments_command(
    models: Annotated[
        list[str] | None,
        typer.Option("--model", help="A model's name or file; may be given several times."),
    ] = None,
    bodies: Annotated[
        int, typer.Option(min=1, max=1000, help="How many bodies act each experiment.")
    ] = BODIES,
    folder: Annotated[
        Path | None,
        typer.Option(
            "--out",
            parser=folder_name,
            metavar="DIR",
            help="Draw timelines or failures into this folder.",
        ),
    ] = None,
    closed_loop: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="Hold N random encounters with a robot instead."),
    ] = None,
    robot: Annotated[
        str,
        typer.Option(help="In closed loop: a robot's name (see `kendon robots`) or .toml file."),
    ] = DEFAULT_ROBOT,
    sensor: Annotated[
        str,
        typer.Option(
            help=f"In closed loop: {TRUTH} sees all; {' and '.join(SENSORS)} see what the camera"
            " in the robot's head has in view."
        ),
    ] = "clean",
    seed: Annotated[int, typer.Option(help="In closed loop: the same gives the same.")] = 0,
    passersby: Annotated[
        float, typer.Option(help="In closed loop: the share of people who only walk past.")
    ] = 0.2,
    keys: Annotated[
        bool,
        typer.Option("--keys", help="In closed loop: gestures by hand, as in the thesis."),
    ] = False,
    jobs: Annotated[int, typer.Option(help="Processes at work; -1 for one on each core.")] = 1,
) -> None:
    """Repeat the thesis's experiments (3.6.4), or hold random encounters in closed loop."""
    check_targets(folders=[("--out", folder)])
    check_jobs(jobs)
    if closed_loop is None:
        _check_unheeded(Setting(seed, robot, sensor, DEFAULT_MODEL, passersby, keys), jobs)
        _read(models or [DEFAULT_MODEL, *(m for m in model_names() if m != DEFAULT_MODEL)],
              bodies, folder)  # fmt: skip
        return
    if bodies != BODIES:
        raise ParameterError(
            f"--bodies is for the experiments; --closed-loop {closed_loop} says how many people"
        )
    if models and len(models) > 1:
        raise ParameterError("encounters are held with one model; give --model once")
    load_model(models[0] if models else DEFAULT_MODEL)  # refuse a wrong one before the work
    setting = Setting(seed, robot, sensor, models[0] if models else DEFAULT_MODEL, passersby, keys)
    _encounter(closed_loop, setting, jobs, folder)


def _check_unheeded(asked: Setting, jobs: int) -> None:
    """Refuse what would change nothing without encounters.

    Raises:
        ParameterError: the sentence names the options.
    """
    usual = Setting()
    given = [
        f"--{f.name}" for f in fields(Setting) if getattr(asked, f.name) != getattr(usual, f.name)
    ]
    given += ["--jobs"] * (jobs != 1)
    if given:
        raise ParameterError(
            f"{' and '.join(given)}: only encounters in closed loop heed this; ask for them with"
            " --closed-loop N"
        )


def _read(names: list[str], bodies: int, folder: Path | None) -> None:
    loaded = {name: load_model(name) for name in names}
    with Progress(console=err, transient=True, disable=not err.is_terminal) as progress:
        task = progress.add_task("reading", total=2 * len(loaded) * len(SCENES))
        tallies = {
            (name, keys): tally(
                SCENES, model, keys=keys, bodies=bodies, progress=lambda: progress.advance(task)
            )
            for name, model in loaded.items()
            for keys in (True, False)
        }
    print_readings(tallies, bodies, out)
    if not folder:
        return
    # matplotlib takes a second to import: only those who draw wait for it.
    from kendon.viewer.experiments import draw_readings

    for stem, title, scenes in (
        ("thesis", "The thesis's six experiments (3.6.4)", THESIS),
        ("ours", "Six experiments of ours", OURS),
    ):
        rows = [
            (f"{model.name}, {'keys' if keys else 'detected'}",
             [read(scene, model, keys=keys) for scene in scenes])
            for model in loaded.values()
            for keys in (True, False)
        ]  # fmt: skip
        draw_readings(rows, title, folder / f"{stem}.png")
    out.print(f"The timelines are drawn in {folder}, with the first body.", highlight=False)


def _encounter(count: int, setting: Setting, jobs: int, folder: Path | None) -> None:
    with Progress(console=err, transient=True, disable=not err.is_terminal) as progress:
        task = progress.add_task("meeting people", total=count)
        verdicts = hold_all(
            count, setting, jobs=jobs, progress=lambda n: progress.update(task, completed=n)
        )
    print_encounters(verdicts, setting, out)
    failed = [verdict for verdict in verdicts if verdict.failures][:DRAWN]
    if not (folder and failed):
        return
    from kendon.viewer.experiments import draw_verdict

    for verdict in failed:
        encounter, source = hold(verdict.number, setting)
        again = judge(verdict.number, encounter, source)
        picture = folder / f"encounter_{verdict.number}.png"
        draw_verdict(encounter, source.truth, again, picture)
        out.print(f"Encounter {verdict.number} is drawn in {picture}.", highlight=False)

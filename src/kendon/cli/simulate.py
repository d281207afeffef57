"""`kendon simulate`: sets of simulated greetings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress

from kendon.cli.options import check_jobs, err, out
from kendon.cli.targets import check_targets, folder_name
from kendon.greetings import INDEX, write_greetings
from kendon.simulation.sets import Seeing, Signs, simulate

EPILOG = """
**Examples**

`kendon simulate --n 1000 --seed 1 --out greetings/` · then `kendon fit greetings/ --out mine.toml`

`kendon simulate --n 200 --seeing noisy --passersby 0.2 --out hard/` · then `kendon evaluate hard/`
"""


def simulate_command(
    folder: Annotated[
        Path,
        typer.Option(
            "--out", parser=folder_name, metavar="DIR", help="The folder to write the set into."
        ),
    ],
    n: Annotated[int, typer.Option("--n", min=1, help="How many people.")] = 100,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same people.")] = 0,
    seeing: Annotated[
        Seeing, typer.Option(help="As they are, through a bad sensor, or through various ones.")
    ] = Seeing.CLEAN,
    signs: Annotated[
        Signs,
        typer.Option(
            help="Gestures by keys, as true as can be; by bodies, which the detectors read;"
            " or half and half."
        ),
    ] = Signs.KEYS,
    passersby: Annotated[
        float, typer.Option(min=0, max=1, help="The share of people who only walk past.")
    ] = 0.0,
    jobs: Annotated[int, typer.Option(help="Processes at work; -1 for one on each core.")] = 1,
) -> None:
    """Draw people who greet, and write what is observed of them."""
    check_jobs(jobs)
    check_targets(folders=[("--out", folder)])
    if (folder / INDEX).exists():
        # write_greetings refuses it too, but only after the work.
        write_greetings(folder, [])
    with Progress(console=err, transient=True, disable=not err.is_terminal) as progress:
        task = progress.add_task("simulating", total=n)
        greetings = simulate(
            n, seed, seeing=seeing, signs=signs, passersby=passersby, jobs=jobs,
            progress=lambda done: progress.update(task, completed=done),
        )  # fmt: skip
    rows = [
        (greeting.name.partition("_")[0], seed, seeing.value, signs.value, len(greeting))
        for greeting in greetings
    ]
    write_greetings(folder, greetings, ("kind", "seed", "seeing", "signs", "observations"), rows)
    out.print(f"{n} people are in {folder}, listed in {folder / INDEX}.", highlight=False)

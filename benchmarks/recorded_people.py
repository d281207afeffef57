"""The people that benchmarks are run on: recorded ones where there are some, else simulated."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from kendon import Track, read_track
from kendon.simulation import SCRIPTS, SimulatedPerson

#: Where recorded greetings are expected, beside the checkout.
DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "mocap"


def add_data_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--data DIR``."""
    parser.add_argument(
        "--data",
        type=Path,
        default=DATA,
        metavar="DIR",
        help="a folder with greeting_*.csv, tracks with true phases"
        " (default: ../shared/data/mocap beside the checkout); without it people are simulated",
    )


def greetings(folder: Path) -> tuple[list[Track], str]:
    """Tracks of greetings with true phases, and a sentence that says what they are."""
    paths = sorted(folder.glob("greeting_*.csv"))
    if paths:
        return [read_track(path) for path in paths], f"{len(paths)} recorded greetings"
    print(f"{folder}: no greeting_*.csv here, so people are simulated", file=sys.stderr)
    bearings = np.radians([-30, -15, 0, 15, 30])
    tracks = [simulate(name, float(bearing)) for name in SCRIPTS for bearing in bearings]
    return tracks, f"{len(tracks)} simulated greetings (not recorded ones)"


def simulate(name: str, bearing: float) -> Track:
    """A simulated person who greets a robot that stands still, without pressed keys."""
    person = SimulatedPerson(replace(SCRIPTS[name], bearing=bearing))
    frames, phases = [], []
    while not person.finished:
        frames.append(person.frame())
        phases.append(int(person.phase))
        person.step()
    track = Track.from_frames(frames, f"{name} {np.degrees(bearing):+.0f}°")
    unknown = np.full_like(track.gestures, np.nan)
    return replace(track, phases=np.array(phases), gestures=unknown)


def print_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print columns of text, the first to the left and the others to the right."""
    widths = [max(len(row[i]) for row in (header, *rows)) for i in range(len(header))]
    for row in (header, *rows):
        cells = [
            cell.rjust(width) if i else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        print("  ".join(cells).rstrip())

"""How far heads go up and down: recorded people's beside drawn people's.

    python benchmarks/heads.py --data DIR [--bags DIR]

DIR holds ``greeting_*.csv`` and ``passerby_*.csv``; bags are those of `benchmarks/bags.py`. Of the
face's pitch the standard deviation in three bands is printed, weighted by how long each person is
seen, and how many intervals look like a nod that is none: people who pass by or stand before a
camera do not nod, and greetings are counted outside their distance salutations. Drawn people
should move their heads as recorded people do, or models learn to distrust nods.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from bags import DATA as BAGS
from recorded_people import add_data_option, greetings, print_table
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation

from kendon import Track, observe, read_track
from kendon.features.gestures import GestureDetector
from kendon.features.track import watch
from kendon.phases import Phase
from kendon.simulation.greeters import draw_greeter, perform
from kendon.sources import read_bag_people
from kendon.sources.ros_bags import is_bag

#: Bands of frequencies [Hz], and the rate to which pitches are resampled [1/s].
BANDS, RATE = ((0.3, 0.8), (0.8, 1.6), (1.6, 4.0)), 30.0
#: Shorter courses tell nothing of the slowest band [s].
SHORTEST = 2.0
#: So long after a salutation it is still read [s].
AFTER = 0.6
DRAWN = 40


def bands(track: Track) -> tuple[float, tuple[float, ...]] | None:
    """How long the head is seen [s], and the pitch's standard deviation in each band [degrees]."""
    known = np.isfinite(track.head_rotation).all(axis=1)
    if known.sum() < 2 or np.ptp(track.t[known]) < SHORTEST:
        return None
    t = track.t[known]
    ahead = Rotation.from_quat(track.head_rotation[known]).apply([1.0, 0.0, 0.0])
    even = np.arange(t[0], t[-1], 1 / RATE)
    pitch = np.interp(even, t, -np.degrees(np.arcsin(ahead[:, 2].clip(-1, 1))))
    found = (
        sosfiltfilt(butter(2, band, "band", fs=RATE, output="sos"), pitch).std() for band in BANDS
    )
    return float(np.ptp(t)), tuple(map(float, found))


def nods(track: Track) -> tuple[int, int]:
    """Intervals that look like a nod outside distance salutations and dips, and all of those."""
    seen = observe(track)
    labels = np.zeros(len(seen.t)) if seen.phases is None else seen.phases
    ends = seen.t[np.isin(labels, (Phase.DS, Phase.HD))]
    detector, found, asked = GestureDetector(), 0, 0
    for question, t in watch(track, detector):
        nod = detector.gestures(*question).nod
        salutes = any(-0.2 < t - end < AFTER for end in ends)
        if not math.isnan(nod) and not salutes:
            found, asked = found + (nod > 0.5), asked + 1
    return found, asked


def row(name: str, tracks: Sequence[Track]) -> list[str]:
    """What is printed of some people."""
    told = [found for track in tracks if (found := bands(track))]
    seconds = np.array([found[0] for found in told])
    means = np.average([found[1] for found in told], axis=0, weights=seconds)
    found, asked = np.sum([nods(track) for track in tracks], axis=0)
    return [
        name,
        str(len(told)),
        f"{seconds.sum():.0f}",
        *(f"{mean:.2f}" for mean in means),
        f"{found / max(asked, 1):.3f}",
    ]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_data_option(parser)
    parser.add_argument("--bags", type=Path, default=BAGS, metavar="DIR", help="a folder with bags")
    arguments = parser.parse_args()
    tracks, what = greetings(arguments.data)
    rows = [row(what, tracks)]
    passers = [read_track(path) for path in sorted(arguments.data.glob("passerby_*.csv"))]
    if passers:
        rows.append(row("recorded passers-by", passers))
    bags = [path for path in sorted(arguments.bags.glob("*")) if is_bag(path)]
    if bags:
        people = [track for bag in bags for track in read_bag_people(bag)]
        rows.append(row("people before a camera (bags)", people))
    drawn = []
    for seed in range(DRAWN):
        rng = np.random.default_rng(seed)
        drawn.append(perform(draw_greeter(rng), rng, joints=True))
    rows.append(row("drawn greeters", drawn))
    print("Standard deviation of the face's pitch in bands, and intervals that look like a nod")
    names = [f"{low}-{high} Hz [°]" for low, high in BANDS]
    print_table(["people", "count", "seen [s]", *names, "nods"], rows)


if __name__ == "__main__":
    main()

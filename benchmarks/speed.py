"""How fast kendon follows a person, on one core.

    python benchmarks/speed.py --data DIR

First the tracker alone: the time of one `Tracker.step`, and what the same belief costs with
hmmlearn, which has no online filter and is run again over the whole sequence at each step. Then
the whole flow, `Greeter` with a `PointRobot` on recorded people whose gestures are given by hand,
as a multiple of real time. All times are process times: what else the machine does counts little.
"""

from __future__ import annotations

import argparse
import cProfile
import gc
import pstats
import sys
import time
from collections.abc import Callable, Sequence

import numpy as np
from recorded_people import add_data_option, greetings, print_table

from kendon import Greeter, Observation, Sampler, Track, load_model, observe, to_hmmlearn
from kendon.errors import KendonError, MissingExtraError
from kendon.person import FloatArray, PersonFrame
from kendon.sources import RecordedSource

#: How many calls are timed together: enough for the clock's resolution.
BATCH = 50


def step_times(X: FloatArray, batches: int) -> list[float]:
    """The time of one step in each batch of steps through greetings [s]."""
    tracker = load_model().tracker()
    times = []
    place = 0
    for _ in range(batches):
        rows = [X[(place + i) % len(X)] for i in range(BATCH)]
        place += BATCH
        start = time.process_time()
        for row in rows:
            tracker.step(row)
        times.append((time.process_time() - start) / BATCH)
    return times


def hmmlearn_times(X: FloatArray) -> list[float] | None:
    """The time of each step when hmmlearn reads the whole sequence again [s]."""
    try:
        other = to_hmmlearn(load_model("kendon"))  # hmmlearn has no other family than its
    except MissingExtraError:
        return None
    known = np.nan_to_num(X)  # hmmlearn takes no unknown values
    times = []
    for t in range(1, len(known) + 1):
        start = time.process_time()
        other.predict(known[:t])
        times.append(time.process_time() - start)
    return times


def process_time(job: Callable[[], object]) -> float:
    """How long a job takes [s]."""
    gc.collect()  # what earlier jobs left behind is not this one's
    start = time.process_time()
    job()
    return time.process_time() - start


def read_frames(tracks: Sequence[Track]) -> list[list[PersonFrame]]:
    """Every track as frames."""
    return [list(RecordedSource(track).frames()) for track in tracks]


def sample(people: Sequence[Sequence[PersonFrame]]) -> list[list[Observation]]:
    """The observations of people, taken in frame by frame as the flow does."""
    found = []
    for frames in people:
        sampler = Sampler()
        found.append([seen for frame in frames for seen in sampler.push(frame)])
    return found


def track_all(people: Sequence[Sequence[Observation]]) -> None:
    """The beliefs of people, observation by observation."""
    model = load_model()
    for observations in people:
        tracker = model.tracker()
        for seen in observations:
            tracker.step(seen)


def greet_all(tracks: Sequence[Track]) -> None:
    """The whole flow, from setting up a model, a tree and a robot for each person on."""
    for track in tracks:
        for _ in Greeter(RecordedSource(track)).run():
            pass


def set_up(count: int) -> None:
    """What a flow needs before its first frame."""
    for _ in range(count):
        Greeter(RecordedSource(Track.build(np.arange(2.0), np.ones((2, 3)))))


def flow_parts(tracks: Sequence[Track]) -> dict[str, float]:
    """The time of each part of the flow over all tracks, and of the whole [s]."""
    # Before anything else: the more objects live, the longer each garbage collection takes.
    whole = process_time(lambda: greet_all(tracks))
    parts = {
        "setting up": process_time(lambda: set_up(len(tracks))),
        "reading frames": process_time(lambda: read_frames(tracks)),
    }
    people = read_frames(tracks)
    parts["sampler"] = process_time(lambda: sample(people))
    observations = sample(people)
    parts["tracker"] = process_time(lambda: track_all(observations))
    # What is left: ticks of the tree, the robot, and what ties them together.
    parts["tree, robot, clock"] = whole - sum(parts.values())
    parts["the whole flow"] = whole
    return parts


def microseconds(times: Sequence[float]) -> list[str]:
    """Fastest, median and 95 % quantile [µs], as text."""
    return [f"{t * 1e6:.1f}" for t in np.quantile(times, [0, 0.5, 0.95])]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_data_option(parser)
    parser.add_argument("--batches", type=int, default=400, help=f"of {BATCH} steps each")
    parser.add_argument(
        "--repeats", type=int, default=5, help="of the whole flow; the fastest counts"
    )
    parser.add_argument(
        "--profile", action="store_true", help="show where the flow spends its time"
    )
    arguments = parser.parse_args()
    try:
        tracks, what = greetings(arguments.data)
        tracks = [track.with_gestures_from_phases() for track in tracks]
    except KendonError as error:
        print(error, file=sys.stderr)
        return 2
    X = np.vstack([observe(track).values for track in tracks])
    gaps = X.copy()
    gaps[:, 4:] = np.nan

    print(f"Following a person: {what}")
    rows = [
        ["Tracker.step", *microseconds(step_times(X, arguments.batches))],
        ["Tracker.step, gestures unknown", *microseconds(step_times(gaps, arguments.batches))],
    ]
    longest = max(tracks, key=lambda track: track.duration)
    again = hmmlearn_times(observe(longest).values)
    if again is not None:
        middle = len(again) // 2
        rows += [
            [f"hmmlearn, run again over steps 1-{middle}", *microseconds(again[:middle])],
            [
                f"hmmlearn, run again over steps {middle}-{len(again)}",
                *microseconds(again[middle:]),
            ],
        ]
    print_table(["one step [µs]", "fastest", "median", "95 %"], rows)

    seconds = sum(track.duration for track in tracks)
    runs = [flow_parts(tracks) for _ in range(arguments.repeats)]
    spent = min(runs, key=lambda run: run["the whole flow"])  # the one least disturbed
    print(f"\nThe whole flow: {seconds:.0f} s of {what}")
    print_table(
        ["part", "s", "share", "x real time"],
        [
            [part, f"{t:.3f}", f"{t / spent['the whole flow']:.0%}", f"{seconds / t:.0f}"]
            for part, t in spent.items()
        ],
    )
    if arguments.profile:
        profile = cProfile.Profile()
        profile.runcall(greet_all, tracks)
        pstats.Stats(profile).sort_stats("tottime").print_stats(25)
    return 0


if __name__ == "__main__":
    sys.exit(main())

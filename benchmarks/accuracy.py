"""How often models and baselines name the right phase of a greeting.

    python benchmarks/accuracy.py --data DIR [--sensor noisy [--draws 10]]

Every reader reads each greeting three times: with the gestures given by hand (the thesis's keys,
pressed as the true phases say), as the detectors find them, and without any word of gestures.
Accuracy is the share of right phases over all observations of all greetings (thesis 3.6.1); behind
it the recall of each phase, the share of its observations that were named so.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace

import numpy as np
from recorded_people import add_data_option, greetings, print_table

from kendon import model_names, observe
from kendon.errors import KendonError
from kendon.evaluation import BASELINES, Result, evaluate, model_readers, sort_material
from kendon.observations import Observations
from kendon.person import Track
from kendon.phases import PHASE_NAMES
from kendon.simulation.sensors import SENSORS, sensor

GESTURES = ("by hand", "detected", "unknown")


def observe_with(track: Track, gestures: str) -> Observations:
    """What is observed of a person whose gestures become known in one of three ways."""
    if gestures == "by hand":
        return observe(track.with_gestures_from_phases())
    seen = observe(track)
    if gestures == "unknown":
        seen.values[:, 4:] = np.nan
    return seen


def scores(result: Result) -> list[str]:
    """Accuracy and the recall of each phase, as text."""
    recall = [f"{share:.3f}" if np.isfinite(share) else "–" for share in result.scores.recall]
    return [f"{result.accuracy.value:.3f}", *recall]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_data_option(parser)
    parser.add_argument(
        "--model",
        action="append",
        metavar="NAME",
        help="a model's name or file; may be given several times (default: all that come along)",
    )
    parser.add_argument(
        "--sensor", choices=sorted(SENSORS), default="clean", help="what people are seen through"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the sensor's noise")
    parser.add_argument(
        "--draws",
        type=int,
        default=1,
        metavar="N",
        help="how often its noise is drawn, with seeds from --seed on; all draws count together",
    )
    arguments = parser.parse_args()
    try:
        readers = [*model_readers(arguments.model or model_names()), *BASELINES]
        tracks, what = greetings(arguments.data)
        if arguments.draws < 1:
            parser.error(f"--draws is at least 1, not {arguments.draws}")
        seeds = range(arguments.seed, arguments.seed + arguments.draws)
        sensors = {seed: sensor(arguments.sensor, seed) for seed in seeds}
        seen = [
            replace(see(track), name=f"{track.name}_{seed}")
            for seed, see in sensors.items()
            for track in tracks
        ]
        rows = []
        for gestures in GESTURES:
            people = sort_material([observe_with(track, gestures) for track in seen])
            found = evaluate(people, readers)
            for result in found.results:
                rows.append([result.name, gestures, *scores(result)])
    except KendonError as error:
        print(error, file=sys.stderr)
        return 2
    totals = found.reference.counts.sum(axis=1).tolist()
    rows.append(["observations", "", str(sum(totals)), *map(str, totals)])
    print(
        f"Accuracy and recall of each phase: {what}, {arguments.sensor} sensor,"
        " 5 observations a second"
    )
    print_table(["reader", "gestures", "accuracy", *PHASE_NAMES], rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())

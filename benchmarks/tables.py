"""The thesis's tables 3.3 and 3.5 for kendon's models, with baselines, as Markdown.

    python benchmarks/tables.py --data DIR

For recorded greetings and for simulated ones: the accuracy of each model with both decoders on
one split into greetings to learn from (76 %) and to test on (24 %), and its mean and standard
deviation over 15 of them. The models called "learned" are learned anew for each split, the others
are the same in all. Gestures are given by hand, as the thesis's were (3.3.5); with --detected
nobody tells of any, and the detectors find what they can.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Mapping, Sequence

from recorded_people import add_data_option, greetings

from kendon import observe
from kendon.errors import KendonError
from kendon.evaluation import (
    BASELINES,
    PUBLISHED,
    Spread,
    evaluate,
    learned_readers,
    model_readers,
    random_splits,
    repeated_splits,
    sort_material,
    wording,
)
from kendon.models import DEFAULT_MODEL
from kendon.observations import Observations
from kendon.simulation import Signs, simulate

#: So many greetings, learned from and tested on together, had the thesis (3.5.2).
SIMULATED = 33
DECODERS = ("filter", "viterbi")


def accuracies(
    people: Sequence[Observations], models: Sequence[str], splits: int, seed: int, jobs: int
) -> dict[str, Spread]:
    """Each reader's accuracy on the test part of each split."""
    readers = [*model_readers(models), *BASELINES]
    evaluation = evaluate(sort_material(people), readers, seed=seed)
    return repeated_splits(
        people,
        random_splits(len(people), splits, seed=seed),
        {result.name: result.tally for result in evaluation.results},
        learned_readers,
        n_jobs=jobs,
    )


def by_decoder(spreads: Mapping[str, Spread]) -> dict[str, dict[str, Spread]]:
    """Readers that differ in the decoder alone side by side; baselines have none."""
    rows: dict[str, dict[str, Spread]] = {}
    for name, spread in spreads.items():
        model, _, decoder = name.removesuffix(")").rpartition(" (")
        if decoder in DECODERS:
            rows.setdefault(model, {})[decoder] = spread
        else:
            rows[name] = {DECODERS[0]: spread}  # causal, as the filter is
    return rows


def print_tables(spreads: Mapping[str, Spread], people: int) -> None:
    rows = by_decoder(spreads)
    splits = random_splits(people, 1, seed=0)[0]
    print(
        f"\nOne split, {len(splits.train)} greetings to learn from and {len(splits.test)} to test"
        " on (thesis table 3.3):\n"
    )
    _print_markdown(
        [model, *(wording.number(float(of[d].accuracies[0])) if d in of else "–" for d in DECODERS)]
        for model, of in rows.items()
    )
    number = len(next(iter(spreads.values())).accuracies)
    print(f"\n{wording.counted(number, 'split')}, mean ± standard deviation (thesis table 3.5):\n")
    _print_markdown(
        [model, *(wording.spread(of[d]) if d in of else "–" for d in DECODERS)]
        for model, of in rows.items()
    )


def _print_markdown(rows: Iterable[Sequence[str]]) -> None:
    print("| model | filter | viterbi |\n| --- | ---: | ---: |")
    for row in rows:
        print(f"| {' | '.join(row)} |")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_data_option(parser)
    parser.add_argument(
        "--model",
        action="append",
        metavar="NAME",
        help="a further model's name or file; may be given several times",
    )
    parser.add_argument("--splits", type=int, default=15, help="how many (default: 15)")
    parser.add_argument("--seed", type=int, default=0, help="of splits, learning and simulation")
    parser.add_argument(
        "--jobs", type=int, default=-1, help="processes (default: one for each core)"
    )
    parser.add_argument(
        "--detected", action="store_true", help="gestures found by the detectors, not by hand"
    )
    arguments = parser.parse_args()
    try:
        signs = Signs.BODIES if arguments.detected else Signs.KEYS
        sets = [
            (
                simulate(SIMULATED, arguments.seed, signs=signs),
                f"{SIMULATED} greetings drawn at random (not recorded)",
            )
        ]
        if any(arguments.data.glob("greeting_*.csv")):
            tracks, what = greetings(arguments.data)
            if not arguments.detected:
                tracks = [track.with_gestures_from_phases() for track in tracks]
            sets.insert(0, ([observe(track) for track in tracks], what))
        else:
            print(f"{arguments.data}: no greeting_*.csv here, only simulated ones", file=sys.stderr)
        models = [*(arguments.model or ()), DEFAULT_MODEL, *PUBLISHED]
        for people, what in sets:
            spreads = accuracies(people, models, arguments.splits, arguments.seed, arguments.jobs)
            print(f"\n### {what}, gestures {'detected' if arguments.detected else 'by hand'}")
            print_tables(spreads, len(people))
    except KendonError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

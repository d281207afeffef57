"""How often the published models name the right phase of a greeting.

    python benchmarks/accuracy.py --data DIR

Each model reads each greeting with both decoders, once with the gestures given by hand (the
thesis's keys, pressed as the true phases say) and once found by the detectors. Accuracy is
the share of right phases over all observations of all greetings (thesis 3.6.1); behind it the
recall of each phase, the share of its observations that were named so.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from recorded_people import add_data_option, greetings, print_table

from kendon import load_model, model_names, observe
from kendon.errors import KendonError
from kendon.estimate import Decoder, estimate
from kendon.features.sampler import TOLERANCE
from kendon.models import GreetingModel
from kendon.observations import Observations
from kendon.person import IntArray, Track
from kendon.phases import PHASE_NAMES, Phase


def observe_at(track: Track, truth: str) -> Observations:
    """The observations of a track with the true phases of their intervals' middle or end."""
    seen = observe(track)
    if truth == "middle" or track.phases is None:
        return seen
    newest = np.searchsorted(track.t, seen.t + TOLERANCE, side="right") - 1
    return replace(seen, phases=track.phases[newest])


def confusion(model: GreetingModel, decoder: Decoder, people: Sequence[Observations]) -> IntArray:
    """How often each true phase (row) was read as each phase (column), shape (6, 6)."""
    counts = np.zeros((len(Phase), len(Phase)), dtype=np.int64)
    for seen in people:
        if seen.phases is None:
            continue
        labelled = seen.phases > 0
        read = estimate(seen, model, decoder).phases
        np.add.at(counts, (seen.phases[labelled] - 1, read[labelled] - 1), 1)
    return counts


def scores(counts: IntArray) -> list[str]:
    """Accuracy and the recall of each phase, as text."""
    totals = counts.sum(axis=1)
    recall = [
        f"{right / total:.3f}" if total else "–"
        for right, total in zip(counts.diagonal().tolist(), totals.tolist(), strict=True)
    ]
    return [f"{counts.trace() / max(1, counts.sum()):.3f}", *recall]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_data_option(parser)
    parser.add_argument(
        "--model",
        action="append",
        metavar="NAME",
        help="a model's name or file; may be given several times (default: all published ones)",
    )
    parser.add_argument(
        "--truth",
        choices=("middle", "end"),
        default="middle",
        help="the true phase of an observation: of the middle of its 0.2 s (default), which its"
        " medians describe, or of their very end, half an interval later",
    )
    arguments = parser.parse_args()
    try:
        models = [load_model(name) for name in arguments.model or model_names()]
        tracks, what = greetings(arguments.data)
        gestures = {
            "by hand": [track.with_gestures_from_phases() for track in tracks],
            "detected": tracks,
        }
        observed = {
            given: [observe_at(track, arguments.truth) for track in people]
            for given, people in gestures.items()
        }
        rows = []
        for model in models:
            for given, people in observed.items():
                for decoder in Decoder:
                    counts = confusion(model, decoder, people)
                    rows.append([model.name, given, decoder.value, *scores(counts)])
    except KendonError as error:
        print(error, file=sys.stderr)
        return 2
    totals = counts.sum(axis=1).tolist()
    rows.append(["observations", "", "", str(sum(totals)), *map(str, totals)])
    print(f"Accuracy and recall of each phase: {what}, 5 observations a second")
    print_table(["model", "gestures", "decoder", "accuracy", *PHASE_NAMES], rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())

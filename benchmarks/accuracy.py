"""How often the published models name the right phase of a greeting.

    python benchmarks/accuracy.py --data DIR

Each model reads each greeting with both decoders, once with the gestures given by hand (the
thesis's keys, pressed as the true phases say) and once without any word of gestures. Accuracy is
the share of right phases over all observations of all greetings (thesis 3.6.1); behind it the
recall of each phase, the share of its observations that were named so.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np
from recorded_people import add_data_option, greetings, print_table

from kendon import load_model, model_names, observe
from kendon.errors import KendonError
from kendon.estimate import Decoder, estimate
from kendon.models import GreetingModel
from kendon.observations import Observations
from kendon.person import IntArray
from kendon.phases import PHASE_NAMES, Phase


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
    arguments = parser.parse_args()
    try:
        models = [load_model(name) for name in arguments.model or model_names()]
        tracks, what = greetings(arguments.data)
        gestures = {
            "by hand": [observe(track.with_gestures_from_phases()) for track in tracks],
            "none": [observe(track) for track in tracks],
        }
        rows = []
        for model in models:
            for given, people in gestures.items():
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

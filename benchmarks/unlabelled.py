"""Does learning without labels find Kendon's six phases? EM from random starts, seed by seed.

    python benchmarks/unlabelled.py

Each seed draws simulated greetings, hides their phases, learns six states by EM from random
starts (thesis 3.5.3) and names them by their likeness to Kendon's phases. The phases then tell
what was hidden: a state is named right if it is mostly met in the phase it is named after.
"""

from __future__ import annotations

import argparse

import numpy as np

from kendon import fit
from kendon.phases import Phase
from kendon.simulation import simulate


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, default=150, help="greetings a seed (150)")
    parser.add_argument("--seeds", type=int, default=10, help="how many seeds (10)")
    options = parser.parse_args()
    print("seed  named right  accuracy  ambiguous")
    all_right = 0
    for seed in range(options.seeds):
        greetings = simulate(options.n, seed)
        found = fit(greetings, labels=False, seed=seed)
        assert found.assignment is not None
        read = np.concatenate([found.model.decode(g.values) for g in greetings])
        true = np.concatenate([g.phases for g in greetings if g.phases is not None])
        right = [
            phase
            for phase in Phase
            if (read == phase).any() and np.bincount(true[read == phase]).argmax() == phase
        ]
        all_right += len(right) == len(Phase)
        ambiguous = ", ".join(phase.name for phase in found.assignment.ambiguous) or "none"
        share = np.mean(read == true)
        print(f"{seed:4}  {len(right)} of {len(Phase)}  {share:12.3f}  {ambiguous}", flush=True)
    print(f"all six named right: {all_right} of {options.seeds} seeds")


if __name__ == "__main__":
    main()

"""How well gestures are read from people's bodies, with nothing given by hand.

    python benchmarks/gestures.py [--data DIR] [--sensor NAME] [--out DIR]

Nothing is fitted to these recordings. For each gesture the intervals of 0.2 s in which it is read
are compared with those in which it was performed: precision, recall, area under the ROC curve;
then by whole gestures: how many were found, how long after they began (median; half of an
interval of 0.2 s is the least on average) and how long it was still read after they ended (median
of those found). Greetings come with phases, not gestures: some of a phase is the hand's way up and
down, and of Close Salutations with a bow much is a mere halt.

A false alarm is a stretch of time in which a gesture is read that was not performed within 0.5 s
of any of it: people who label mark edges no better than that. Readings less than 0.5 s apart are
one stretch. Alarms are counted a minute of the time farther than that from what was performed.
The last line counts the alarms of all three gestures over all recorded people together: passers-by
and talks, and of greetings, waves and handshakes what lies between them.

With ``--out`` it draws reliability, and what was missed or mistaken, interval by interval.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from recorded_people import DATA, add_data_option, greetings, print_table

from kendon import Track, read_track
from kendon.errors import KendonError
from kendon.features.gestures import GestureDetector, Gestures
from kendon.features.sampler import PERIOD
from kendon.features.track import watch
from kendon.person import GESTURES, FloatArray
from kendon.phases import Phase
from kendon.simulation import sensor
from kendon.simulation.movers import draw_mover
from kendon.simulation.sensors import SENSORS
from kendon.sources.isr_uol import read_isr_uol

#: Above this a gesture counts as read.
READ = 0.5
#: A gesture found this long after its end was not found [s].
LATE = 0.3
#: Labels are no sharper than this, and readings this near to each other are one [s].
TOLERANCE = 0.5
#: People who are not recorded.
SIMULATED = "simulated bodies"
#: The phases in which the gestures are performed.
PHASES = dict(zip(GESTURES, (Phase.DS, Phase.CS, Phase.HD), strict=True))


@dataclass(frozen=True)
class Reading:
    """One gesture read from one track."""

    dataset: str
    gesture: str  # one of `Gestures`
    name: str
    minutes: float  # in which it was not performed, nor shortly before or after
    rest: float  # [min] in which no gesture was
    end: FloatArray  # (K,) ends of the intervals [s]
    probability: FloatArray  # (K,), NaN = unknown
    performed: FloatArray  # (K,), 0 or 1
    begins: Sequence[float] = ()  # when gestures begin and end [s]
    ends: Sequence[float] = ()

    @property
    def read(self) -> FloatArray:
        """Whether it was read, (K,), 0 or 1."""
        return (self.probability > READ).astype(float)  # NaN is not above

    def delays(self) -> list[float]:
        """How long after its begin each gesture was read [s]; infinite for one that was not."""
        found = []
        for begin, end in zip(self.begins, self.ends, strict=True):
            hits = (self.end > begin) & (self.end - LATE <= end) & (self.read > 0)
            found.append(float(self.end[hits][0] - begin) if hits.any() else np.inf)
        return found

    def stretches(self) -> list[tuple[float, float]]:
        """From when until when it was read [s]; short pauses are passed over."""
        found: list[tuple[float, float]] = []
        for end in self.end[self.read > 0].tolist():
            begin = end - PERIOD
            if found and begin - found[-1][1] < TOLERANCE:
                begin = found.pop()[0]
            found.append((begin, end))
        return found

    @property
    def alarms(self) -> int:
        """How many stretches lie away from every gesture that was performed."""
        return sum(
            all(
                end < its_begin - TOLERANCE or begin > its_end + TOLERANCE
                for its_begin, its_end in zip(self.begins, self.ends, strict=True)
            )
            for begin, end in self.stretches()
        )

    def lingers(self) -> list[float]:
        """How long after its end each gesture that was found was still read [s]."""
        found = []
        for begin, end in zip(self.begins, self.ends, strict=True):
            last = [b for a, b in self.stretches() if a < end + LATE and b > begin]
            if last:
                found.append(max(0.0, last[-1] - end))
        return found


def away(track: Track, performed: FloatArray) -> float:
    """How long nothing is performed in a track, nor shortly before or after [min]."""
    busy = track.t[performed > 0]
    near = np.searchsorted(busy, track.t + TOLERANCE, "right") > np.searchsorted(
        busy, track.t - TOLERANCE
    )
    return float(np.mean(~near)) * track.duration / 60


def readings(dataset: str, track: Track, truth: dict[str, FloatArray]) -> list[Reading]:
    """Each gesture of `truth`, (T,) 0 or 1 for each frame, as it is read from a track."""
    detector = GestureDetector()
    ends, found, middles = [], [], []
    for question, middle in watch(track, detector):
        ends.append(question.end)
        found.append(detector.gestures(*question))
        middles.append(middle)
    rows = np.searchsorted(track.t, middles)
    probabilities = np.array(found, dtype=float).reshape(-1, len(Gestures._fields))
    result = []
    rest = away(track, np.max(list(truth.values()), axis=0))
    for gesture, performed in truth.items():
        edges = np.diff(performed, prepend=0, append=0)
        stops = np.minimum(np.flatnonzero(edges < 0), len(track) - 1)
        result.append(
            Reading(
                dataset, gesture, track.name, away(track, performed), rest, np.array(ends),
                probabilities[:, Gestures._fields.index(gesture)], performed[rows],
                track.t[np.flatnonzero(edges > 0)].tolist(), track.t[stops].tolist(),
            )
        )  # fmt: skip
    return result


def of_greetings(folder: Path, see: Callable[[Track], Track]) -> list[Reading]:
    """The greetings, and the passers-by who perform nothing."""
    found = []
    for track in greetings(folder)[0]:
        phases = track.phases if track.phases is not None else np.zeros(len(track), dtype=int)
        truth = {name: (phases == phase).astype(float) for name, phase in PHASES.items()}
        found += readings("greetings", see(track), truth)
    for path in sorted(folder.glob("passerby_*.csv")):
        track = see(read_track(path))
        found += readings("passers-by", track, {name: np.zeros(len(track)) for name in GESTURES})
    return found


def of_hands(folder: Path, see: Callable[[Track], Track]) -> list[Reading]:
    """People who wave or shake hands about a metre away: a close salutation, whichever it is."""
    found = []
    for path in sorted(folder.glob("*.csv")):
        with path.open(newline="") as file:
            labels = np.array([row["gesture"] for row in csv.DictReader(file)])
        track = see(read_track(path))
        names = [name for name in ("wave", "handshake") if name in labels]
        truth = {name: (labels == name).astype(float) for name in names}
        truth["csal"] = (labels != "none").astype(float)
        found += readings("waves and handshakes", track, truth)
    return found


def of_talks(folder: Path, see: Callable[[Track], Track]) -> list[Reading]:
    """Two people who talk: neither salutes."""
    found = []
    for path in sorted(folder.glob("a07_*.txt")):
        track = see(read_isr_uol(path))
        none = np.zeros(len(track))
        found += readings("talks", track, {"dsal": none, "csal": none})
    return found


def of_simulated(people: int, see: Callable[[Track], Track]) -> list[Reading]:
    """Simulated bodies, other ones than the weights were fitted to."""
    rng = np.random.default_rng(20_000)
    found = []
    for _ in range(people):
        person = draw_mover(rng)
        truth = dict(zip(GESTURES, person.truth.T, strict=True))
        found += readings(SIMULATED, see(person.track), truth)
    return found


def area(probability: FloatArray, performed: FloatArray) -> float:
    """The area under the ROC curve: how often a performed gesture is the more probable one."""
    from scipy.stats import rankdata

    ranks = rankdata(probability)
    yes = performed.sum()
    no = len(performed) - yes
    if not yes or not no:
        return np.nan
    return float((ranks[performed > 0].sum() - yes * (yes + 1) / 2) / (yes * no))


def row(dataset: str, gesture: str, found: Sequence[Reading]) -> list[str]:
    """One line of the table."""
    probability = np.concatenate([one.probability for one in found])
    performed = np.concatenate([one.performed for one in found])
    read = probability > READ
    known = np.isfinite(probability)
    delays = [delay for one in found for delay in one.delays()]
    lingers = [linger for one in found for linger in one.lingers()]
    hits = float((read & (performed > 0)).sum())

    def share(part: float, whole: float) -> str:
        return f"{part / whole:.3f}" if whole else "–"

    auc = area(probability[known], performed[known])
    return [
        dataset,
        gesture,
        f"{1 - known.mean():.2f}",
        "–" if np.isnan(auc) else f"{auc:.3f}",
        share(hits, read.sum()),
        share(hits, performed.sum()),
        f"{np.isfinite(delays).sum()}/{len(delays)}",
        f"{np.median(delays):.2f} s" if delays else "–",
        f"{np.median(lingers):.2f} s" if lingers else "–",
        f"{sum(one.alarms for one in found) / sum(one.minutes for one in found):.2f}",
    ]


def groups(found: Sequence[Reading]) -> dict[tuple[str, str], list[Reading]]:
    """The readings of each gesture of each dataset, in their order."""
    grouped: dict[tuple[str, str], list[Reading]] = {}
    for one in found:
        grouped.setdefault((one.dataset, one.gesture), []).append(one)
    return grouped


def draw(found: Sequence[Reading], folder: Path) -> None:
    """Draw reliability of each gesture, and each track in which one was missed or mistaken."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    folder.mkdir(parents=True, exist_ok=True)
    grouped = groups(found)
    datasets = [d for d in dict.fromkeys(one.dataset for one in found) if d != "passers-by"]
    figure, axes = plt.subplots(1, len(GESTURES), figsize=(13, 4.5), sharey=True)
    edges = np.linspace(0, 1, 11)
    for ax, gesture in zip(axes, GESTURES, strict=True):
        for dataset in datasets:
            if (dataset, gesture) not in grouped:
                continue
            of = grouped[dataset, gesture]
            probability = np.concatenate([one.probability for one in of])
            performed = np.concatenate([one.performed for one in of])
            place = np.digitize(probability, edges[1:-1])
            place[np.isnan(probability)] = -1
            bins = [k for k in range(10) if (place == k).sum() >= 10]
            if not performed.any() or not bins:
                continue
            ax.plot(
                [probability[place == k].mean() for k in bins],
                [performed[place == k].mean() for k in bins],
                "o-", label=dataset,
            )  # fmt: skip
        ax.plot([0, 1], [0, 1], color="0.6", lw=1)
        ax.set(title=gesture, xlabel="probability read", xlim=(0, 1), ylim=(0, 1))
        ax.legend(loc="upper left", fontsize=8)
    axes[0].set_ylabel("share of intervals in which it was performed")
    figure.tight_layout()
    figure.savefig(folder / "reliability.png", dpi=110)
    plt.close(figure)

    bad = [
        one for one in found
        if one.dataset != SIMULATED and (one.alarms or np.isinf(one.delays()).any())
    ]  # fmt: skip
    if not bad:
        return
    figure, rows = plt.subplots(len(bad), 1, figsize=(9, 1.3 * len(bad)), squeeze=False)
    for ax, one in zip(rows[:, 0], bad, strict=True):
        ax.fill_between(one.end, one.performed, step="pre", color="0.85", label="performed")
        ax.step(one.end, one.probability, lw=1)
        ax.axhline(READ, color="0.6", lw=0.5)
        ax.set(ylim=(0, 1), yticks=(0, 1))
        ax.set_title(f"{one.dataset}: {one.gesture} of {one.name}", fontsize=8, loc="left", pad=2)
    rows[-1, 0].set_xlabel("time [s]")
    figure.tight_layout()
    figure.savefig(folder / "failures.png", dpi=80)
    plt.close(figure)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_data_option(parser)
    parser.add_argument(
        "--hands",
        type=Path,
        default=DATA.parent / "gestures",
        metavar="DIR",
        help="a folder with tracks of waves and handshakes, named in the column gesture",
    )
    parser.add_argument(
        "--talks",
        type=Path,
        default=DATA.parent / "isr_uol",
        metavar="DIR",
        help="a folder with ISR-UoL recordings a07 (conversation)",
    )
    parser.add_argument("--people", type=int, default=300, metavar="N", help=SIMULATED)
    parser.add_argument("--sensor", choices=tuple(SENSORS), default="clean")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the sensor")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where figures are drawn")
    arguments = parser.parse_args()
    see = sensor(arguments.sensor, arguments.seed)
    try:
        found = [
            *of_greetings(arguments.data, see),
            *of_hands(arguments.hands, see),
            *of_talks(arguments.talks, see),
            *of_simulated(arguments.people, see),
        ]
    except KendonError as error:
        print(error, file=sys.stderr)
        return 2
    print(f"Gestures read above {READ}, sensor {arguments.sensor}, 5 intervals a second")
    header = ["dataset", "gesture", "unknown", "AUC", "precision", "recall"]
    header += ["found", "delay", "lingers", "alarms/min"]
    print_table(header, [row(*key, of) for key, of in groups(found).items()])
    recorded = [one for one in found if one.dataset != SIMULATED and one.gesture in GESTURES]
    alarms = sum(one.alarms for one in recorded)
    minutes = sum({(one.dataset, one.name): one.rest for one in recorded}.values())
    print(
        f"\n{alarms} false alarms of any gesture in {minutes:.2f} min of recorded people who"
        f" perform none: {alarms / minutes if minutes else 0:.2f} a minute"
    )
    if arguments.out:
        draw(found, arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Who is engaged with a camera and who is not, told from kendon's gaze: ROS bags of ROS4HRI people.

    python benchmarks/bags.py --data DIR --out FIGURE.png

DIR holds bags whose names say ``_eng_`` or ``_dis_``, as those of ROS4HRI's hri_engagement do:
everybody in a bag is labelled as the bag is. The robot's face is where the camera is. Printed
are gaze, distance and speed of each person, and how well gaze alone separates the engaged from
the others: the area under the ROC curve (AUC), the chance that of one engaged and one other
sample the engaged one looks nearer to the camera. Samples are single observations of 0.2 s, means
over windows of 1, 2 and 5 s that do not overlap, over all that is seen of a person, and over a
bag. Beside it stands the measure by which hri_engagement decides, on the same samples.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from recorded_people import print_table
from scipy.spatial.transform import Rotation

from kendon import Observations, Track, observe
from kendon.errors import KendonError
from kendon.features import PERIOD
from kendon.person import FloatArray
from kendon.sources import CameraMount, read_bag_people
from kendon.sources.bag_people import BagOptions
from kendon.sources.ros_bags import is_bag

#: Where recorded bags are expected, beside the checkout.
DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "ros4hri_bags"
#: What the names of bags say of the people in them.
LABELS = {"_eng_": True, "_dis_": False}
#: The windows over which gaze is averaged [s].
WINDOWS = (1.0, 2.0, 5.0)
CAMERA = CameraMount()
#: hri_engagement's parameters: beyond this distance [m] nobody is engaged; field of view [rad].
FARTHEST, VIEW = 4.0, np.radians(60)
COLORS = {True: "C2", False: "C3"}
WORDS = {True: "engaged", False: "disengaged"}


@dataclass(frozen=True)
class Seen:
    """One person of a bag."""

    bag: str
    engaged: bool
    track: Track
    observations: Observations
    measure: FloatArray  # (T,) hri_engagement's, one an observation

    @property
    def gaze(self) -> FloatArray:
        """One an observation, (T,); NaN = unknown."""
        return self.observations.values[:, 2]


def read(folder: Path) -> list[Seen]:
    people = []
    for bag in sorted(path for path in folder.glob("*") if is_bag(path)):
        engaged = next((label for part, label in LABELS.items() if part in bag.name), None)
        if engaged is None:
            print(f"{bag.name}: neither {' nor '.join(LABELS)} in its name", file=sys.stderr)
            continue
        for track in read_bag_people(bag, BagOptions(camera=CAMERA)):
            seen = observe(track, CAMERA.position)
            people.append(Seen(bag.name, engaged, track, seen, measure(track, seen)))
    return people


def measure(track: Track, seen: Observations) -> FloatArray:
    """hri_engagement's visual social engagement (Webb and Lemaignan), mean of each interval."""
    ahead = track.head - np.array(CAMERA.position)
    to_camera = Rotation.from_quat(track.head_rotation).inv().apply(-ahead)
    far = np.linalg.norm(ahead, axis=1)
    nearness = np.log(np.maximum(FARTHEST + 1 - far, 1)) / np.log(FARTHEST + 1)
    values = _in_view(to_camera) * _in_view(ahead) * nearness
    within = [(track.t > end - PERIOD) & (track.t <= end) for end in seen.t]
    return np.array([values[rows].mean() if rows.any() else np.nan for rows in within])


def _in_view(points: FloatArray) -> FloatArray:
    """1 on the x axis, 0 at the rim of the field of view and behind."""
    x, y, z = points.T
    beside = np.hypot(y, z) / (np.tan(VIEW) * np.where(x > 0, x, np.nan))
    return np.asarray(np.where(x > 0, np.clip(1 - beside, 0, 1), 0.0))


def auc(engaged: FloatArray, others: FloatArray) -> float:
    """The chance that a sample of the engaged is smaller than another one; ties count half."""
    smaller = (engaged[:, None] < others).mean()
    return float(smaller + (engaged[:, None] == others).mean() / 2)


def windows(values: FloatArray, length: float) -> FloatArray:
    """Means over windows [s] that do not overlap; a rest of less than half a window is left out."""
    step = round(length / PERIOD)
    parts = [values[i : i + step] for i in range(0, len(values), step)]
    kept = [known(p) for p in parts if len(p) > step / 2 or len(parts) == 1]
    return np.array([p.mean() for p in kept if len(p)])


def mean(values: FloatArray) -> FloatArray:
    return np.array([np.nanmean(values)])


def known(values: FloatArray) -> FloatArray:
    return values[np.isfinite(values)]


def samplings() -> Iterator[tuple[str, Callable[[FloatArray], FloatArray]]]:
    yield f"observations, {PERIOD:g} s", known
    for length in WINDOWS:
        yield f"windows of {length:g} s", partial(windows, length=length)
    yield "people", mean


def separation(
    people: list[Seen],
    values: Callable[[Seen], FloatArray],
    sample: Callable[[FloatArray], FloatArray],
) -> tuple[float, int, int]:
    """The AUC of values that are smaller for the engaged, and the numbers of samples."""
    sets = [
        np.concatenate([sample(values(p)) for p in people if p.engaged is engaged])
        for engaged in (True, False)
    ]
    return auc(*sets), len(sets[0]), len(sets[1])


def by_bag(people: list[Seen], values: Callable[[Seen], FloatArray]) -> tuple[float, int, int]:
    """The same where a sample is the mean over everybody in a bag."""
    means: dict[bool, list[float]] = {True: [], False: []}
    for bag in dict.fromkeys(p.bag for p in people):
        inside = [p for p in people if p.bag == bag]
        means[inside[0].engaged].append(float(np.mean([np.nanmean(values(p)) for p in inside])))
    return auc(np.array(means[True]), np.array(means[False])), len(means[True]), len(means[False])


def print_people(people: list[Seen]) -> None:
    rows = []
    for person in people:
        distance, speed = person.observations.values[:, :2].T
        ahead = Rotation.from_quat(person.track.head_rotation).apply([1.0, 0.0, 0.0])
        turns = np.corrcoef(ahead[:, 1], person.track.head[:, 1])[0, 1]
        rows.append(
            [
                person.track.name,
                WORDS[person.engaged],
                f"{person.track.duration:.1f}",
                f"{len(person.track)}",
                f"{np.nanmean(person.gaze):.2f}",
                f"{np.nanpercentile(person.gaze, 10):.2f}–{np.nanpercentile(person.gaze, 90):.2f}",
                f"{np.nanmin(distance):.2f}–{np.nanmax(distance):.2f}",
                f"{np.nanmin(speed):+.2f}–{np.nanmax(speed):+.2f}",
                f"{np.degrees(np.std(np.arctan2(ahead[:, 1], -ahead[:, 0]))):.0f}",
                f"{turns:+.2f}",
            ]
        )
    header = ["person", "label", "s", "frames", "gaze", "10–90 %", "distance [m]", "speed [m/s]"]
    print_table([*header, "turning [°]", "r"], rows)
    print(
        "turning: standard deviation of the head's yaw; r: correlation of where the face points"
        " sideways\nwith where it is: a head that turns carries its face with it, whichever way"
        " its frame is said to lie"
    )


def print_separation(people: list[Seen], title: str) -> None:
    rows = []
    for name, sample in samplings():
        gaze = separation(people, lambda p: p.gaze, sample)
        other = separation(people, lambda p: -p.measure, sample)
        rows.append([name, f"{gaze[1]}", f"{gaze[2]}", f"{gaze[0]:.3f}", f"{other[0]:.3f}"])
    gaze, other = by_bag(people, lambda p: p.gaze), by_bag(people, lambda p: -p.measure)
    rows.append(["bags", f"{gaze[1]}", f"{gaze[2]}", f"{gaze[0]:.3f}", f"{other[0]:.3f}"])
    print(f"\n{title}")
    print_table(["samples", "engaged", "not", "AUC of gaze", "of hri_engagement"], rows)


def draw(people: list[Seen], target: Path) -> None:
    """Distributions of gaze for each label and person, and gaze over time."""
    figure, (pooled, each, over_time) = plt.subplots(
        1, 3, figsize=(15, 4.6), layout="constrained", width_ratios=[1, 1.2, 1.3]
    )
    edges = np.linspace(0, 2, 41)
    for engaged in (True, False):
        parts = [known(p.gaze) for p in people if p.engaged is engaged]
        pooled.hist(
            np.concatenate(parts), edges, density=True, alpha=0.6, color=COLORS[engaged],
            label=f"{WORDS[engaged]}, {sum(map(len, parts))} observations",
        )  # fmt: skip
    pooled.set(xlabel="gaze (0 = at the camera)", ylabel="density", xlim=(0, 2))
    pooled.legend(fontsize=8, loc="upper right")
    order = sorted(people, key=lambda p: (not p.engaged, float(np.nanmean(p.gaze))))
    for place, person in enumerate(order):
        values = known(person.gaze)
        violin: Any = each.violinplot(values, [place], orientation="horizontal", showextrema=False)
        for shape in violin["bodies"]:
            shape.set_facecolor(COLORS[person.engaged])
        each.plot(values.mean(), place, "o", color="k", ms=5)
        each.annotate(
            f"{values.mean():.2f}", (values.mean(), place), xytext=(0, 6),
            textcoords="offset points", ha="center", fontsize=8,
        )  # fmt: skip
    each.set_yticks(range(len(order)), [p.track.name for p in order], fontsize=8)
    each.invert_yaxis()
    each.set(xlabel="gaze, with each person's mean", xlim=(0, 2))
    for person in order:
        over_time.plot(
            person.observations.t, person.gaze, lw=1.2, color=COLORS[person.engaged],
            ls="-" if person.bag.startswith("1p") else ":",
        )  # fmt: skip
    over_time.set(xlabel="time [s]", ylabel="gaze (dotted: two people in the bag)", ylim=(0, 2))
    for axes in (pooled, each):
        axes.axvline(1.0, color="0.5", lw=0.8, ls="--")
    over_time.axhline(1.0, color="0.5", lw=0.8, ls="--")
    target.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(target, dpi=110)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--data",
        type=Path,
        default=DATA,
        metavar="DIR",
        help="a folder of bags (default: ../shared/data/ros4hri_bags beside the checkout)",
    )
    parser.add_argument("--out", type=Path, help="the figure to draw")
    arguments = parser.parse_args()
    try:
        people = read(arguments.data)
    except KendonError as error:
        print(error, file=sys.stderr)
        return 2
    if {p.engaged for p in people} != {True, False}:
        print(
            f"{arguments.data}: no bags of engaged and of disengaged people here", file=sys.stderr
        )
        return 2
    print_people(people)
    print_separation(people, "Everybody")
    alone = [p for p in people if sum(q.bag == p.bag for q in people) == 1]
    if {p.engaged for p in alone} == {True, False}:
        print_separation(
            alone, "People alone before the camera: there a bag's label is one person's"
        )
    if arguments.out:
        draw(people, arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())

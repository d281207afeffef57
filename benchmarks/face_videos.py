"""What kendon reads from videos of faces over time: distance, gaze, smile.

    python benchmarks/face_videos.py --data DIR --model-files DIR --out FIGURE.png

Draws one column a video, with the numbers only. With ``--with-frames`` the marked frames are
drawn above them, to judge by eye whether the numbers are what a person sees; such a figure shows
the people in the videos and is for looking at, not for publishing.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import cv2
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from kendon.errors import KendonError
from kendon.features import ROBOT_FACE, Sampler, eye_gaze, head_gaze
from kendon.observations import Observation
from kendon.person import PersonFrame
from kendon.sources.base import SourceOptions, open_source
from kendon.sources.video import SUFFIXES

#: How many moments of each video are marked.
MARKS = 6


def read(video: Path, options: SourceOptions) -> tuple[list[PersonFrame], float]:
    """All frames of a video, and how many were read a second."""
    start = time.perf_counter()
    frames = list(open_source(video, options).frames())
    return frames, len(frames) / (time.perf_counter() - start)


def gazes(frames: list[PersonFrame]) -> tuple[Any, Any]:
    """Gaze by the eyes and by the head, each (N,); NaN where unknown."""
    unknown = np.full((2, 3), np.nan)
    eyes = np.array([f.eyes or unknown for f in frames], dtype=float)
    directions = np.array([f.eye_gaze or unknown for f in frames], dtype=float)
    heads = np.array([f.head for f in frames])
    rotations = np.array([f.head_rotation for f in frames])
    face = np.array(ROBOT_FACE)
    return eye_gaze(eyes, directions, face), head_gaze(heads, rotations, face)


def observed(frames: list[PersonFrame]) -> list[Observation]:
    """The observations that the model would get from these frames, one every 0.2 s."""
    sampler = Sampler()
    done = [observation for frame in frames for observation in sampler.push(frame)]
    return done + sampler.advance(frames[-1].t + 1e-3)


def images(video: Path, wanted: list[int]) -> list[Any]:
    """The wanted frames of a video as RGB images."""
    capture = cv2.VideoCapture(str(video))
    shown: list[Any] = []
    number = 0
    while len(shown) < len(wanted):
        good, image = capture.read()
        if not good:
            break
        if number in wanted:
            shown.append(cv2.cvtColor(image, cv2.COLOR_BGR2RGB))
        number += 1
    capture.release()
    return shown


def draw_video(column: Any, video: Path, frames: list[PersonFrame], with_frames: bool) -> None:
    """Fill one column of the figure: marked frames if wanted, distance, gaze, smile."""
    t = np.array([f.t for f in frames])
    marks = [round((i + 0.5) * len(frames) / MARKS) for i in range(MARKS)]
    by_eyes, by_head = gazes(frames)
    steps = observed(frames)
    ends = [step.t for step in steps]
    heights = [1.0] * with_frames + [1.2, 1.2, 1.2]
    rows = column.subplots(len(heights), 1, height_ratios=heights)
    column.suptitle(video.stem)
    if with_frames:
        strip = np.hstack([cv2.resize(image, (240, 135)) for image in images(video, marks)])
        rows[0].imshow(strip, aspect="auto")
        rows[0].axis("off")
    distance, gaze, smile = rows[-3:]
    planar = np.hypot([f.head[0] for f in frames], [f.head[1] for f in frames])
    distance.plot(t, planar, lw=1, color="C7", label="each frame")
    distance.plot(ends, [step.distance for step in steps], "o-", ms=3, color="C0", label="observed")
    distance.set(ylabel="distance [m]", ylim=(0, 1.3 * np.nanmax(planar)))
    gaze.plot(t, by_head, lw=1, color="C1", label="by the head")
    gaze.plot(t, by_eyes, lw=1, color="C2", label="by the eyes")
    gaze.plot(ends, [step.gaze for step in steps], "o-", ms=3, color="C0", label="observed")
    gaze.axhline(1.0, color="0.6", lw=0.8, ls="--")
    gaze.set(ylabel="gaze (0 = at the robot)", ylim=(0, 2.1))
    smile.plot(t, [f.smile for f in frames], lw=1, color="C7", label="each frame")
    smile.plot(ends, [step.smile for step in steps], "o-", ms=3, color="C0", label="observed")
    smile.set(ylabel="smile [0–5]", ylim=(0, 5), xlabel="time [s]")
    for axes in (distance, gaze, smile):
        axes.set_xlim(0, t[-1])
        axes.legend(loc="upper right", fontsize=7, ncols=3)
        for number, mark in enumerate(marks, start=1):
            axes.axvline(t[mark], color="0.85", lw=0.8, zorder=0)
            if axes is distance:
                axes.annotate(str(number), (t[mark], 0.02), fontsize=8, color="0.4", ha="center")
    print(f"{video.stem}: t [s], distance [m], gaze by eyes, gaze by head, smile")
    for mark in marks:
        print(
            f"  {t[mark]:6.2f}  {planar[mark]:.2f}  {by_eyes[mark]:.2f}  {by_head[mark]:.2f}"
            f"  {frames[mark].smile:.1f}"
        )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", type=Path, required=True, help="a folder of videos of one face")
    parser.add_argument("--model-files", type=Path, help="a folder with the networks' files")
    parser.add_argument("--out", type=Path, required=True, help="the figure to write")
    parser.add_argument("--with-frames", action="store_true", help="draw the videos' pictures too")
    arguments = parser.parse_args()
    videos = sorted(p for p in arguments.data.glob("*") if p.suffix.lower() in SUFFIXES)
    if not videos:
        print(f"{arguments.data}: no video here ({' '.join(SUFFIXES)})", file=sys.stderr)
        return 2
    options = SourceOptions(model_files=arguments.model_files)
    figure = plt.figure(figsize=(6.5 * len(videos), 8), layout="constrained")
    columns = figure.subfigures(1, len(videos), squeeze=False)[0]
    try:
        for column, video in zip(columns, videos, strict=True):
            frames, rate = read(video, options)
            print(f"{video.name}: {len(frames)} frames, {rate:.0f} a second")
            draw_video(column, video, frames, arguments.with_frames)
    except KendonError as error:
        print(error, file=sys.stderr)
        return 2
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(arguments.out, dpi=110)
    return 0


if __name__ == "__main__":
    sys.exit(main())

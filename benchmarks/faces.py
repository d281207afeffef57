"""Faces near and far: how well each feature is read by distance, and how fast.

    python benchmarks/faces.py --data DIR --model-files DIR [--out TABLE.csv]

**Accuracy.** A face from a video is shown to kendon smaller and smaller in a picture of 1280 x 720
pixels, as a camera of 60 degrees would show it from 0.5 to 8 m. How far away it *truly* is comes
from the face itself: read at its full size it has a distance d0 for a camera of focal length f0,
and a picture of it that is s times as large is what a camera of focal length f shows of it at
d = d0 f / (s f0). Everything else is compared with the reading at full size, too. What is not in
this: the face keeps the perspective of the distance it was filmed from (which alone makes a far
face seem up to 4 % farther), an unknown person's face is not the mean face (6 %), and a lens
blurs. Noise of a sensor is added.

**Speed.** One face in a video of 640 x 360 pixels, from the file to the belief, on two cores.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from kendon.errors import KendonError
from kendon.models import load_model
from kendon.sources.base import CameraMount, SourceOptions, open_source
from kendon.sources.camera_geometry import Intrinsics, MountedCamera
from kendon.sources.face_finder import YuNet
from kendon.sources.face_landmarks import FaceLandmarker
from kendon.sources.face_person import PersonReader, SeenPerson, eyes_range, head_range
from kendon.sources.face_reader import FaceReader
from kendon.sources.model_files import FACE_FINDER, FACE_LANDMARKER, find_model_file
from kendon.sources.video import SUFFIXES
from kendon.tables import write_table
from kendon.watch import Latency, Watch

#: The picture that faces are put into, and what of the world it shows.
WIDTH, HEIGHT = 1280, 720
#: The distances that are tried [m].
DISTANCES = (0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 7.0, 8.0)
#: Frames of each video, evenly spread.
FRAMES = 8
#: Standard deviation of the sensor's noise, in grey levels of 255.
NOISE = 3.0
#: The size at which the face's own distance is read.
FULL = (640, 360)


@dataclass(frozen=True)
class Compared:
    """A far face beside the same face at its full size."""

    true: float  # [m]
    distance: float  # share of the true distance, too far positive; NaN = unknown
    head: float  # [degrees] between the directions of the head
    eyes: float  # [degrees] between the directions of the eyes; NaN = unknown
    smile: float  # difference on the scale 0 to 5; NaN = unknown


class Reader:
    """Reads single pictures; the networks are set up once.

    Args:
        model_files: a folder with the networks' files; None for the cache.
    """

    def __init__(self, model_files: Path | None) -> None:
        self._finder = YuNet(find_model_file(FACE_FINDER.name, model_files))
        self._landmarker = FaceLandmarker(find_model_file(FACE_LANDMARKER.name, model_files))
        self._rng = np.random.default_rng(0)

    def read(self, image: Any) -> SeenPerson | None:
        """The nearest face of a picture, with a sensor's noise; None where none is read."""
        height, width = image.shape[:2]
        camera = Intrinsics.from_fov(width, height)
        noise = self._rng.normal(0, NOISE, image.shape)
        noisy = np.clip(image + noise, 0, 255).astype(np.uint8)
        faces = FaceReader(self._finder, self._landmarker).detect(noisy, 0.0)
        reader = PersonReader(camera, MountedCamera.from_mount(CameraMount()))
        scene = reader.read(faces, 0.0)
        return next((p for p in scene.people if p.face.number == scene.greeted), None)

    def close(self) -> None:
        """Give the networks' memory back."""
        self._landmarker.close()


def shrunk(image: Any, scale: float) -> Any:
    """A picture `scale` times as large, in the middle of a grey scene."""
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=way)
    scene = np.full((HEIGHT, WIDTH, 3), 110, np.uint8)
    height, width = min(small.shape[0], HEIGHT), min(small.shape[1], WIDTH)
    y, x = (small.shape[0] - height) // 2, (small.shape[1] - width) // 2
    top, left = (HEIGHT - height) // 2, (WIDTH - width) // 2
    scene[top : top + height, left : left + width] = small[y : y + height, x : x + width]
    return scene


def angle(a: Any, b: Any) -> float:
    """Between two directions [degrees]."""
    cosine = float(np.dot(a, b) / np.linalg.norm(a) / np.linalg.norm(b))
    return math.degrees(math.acos(min(max(cosine, -1.0), 1.0)))


def compare(reader: Reader, image: Any) -> list[Compared]:
    """One face at every distance."""
    full = cv2.resize(image, FULL, interpolation=cv2.INTER_AREA)
    own = reader.read(full)
    if own is None or own.pose is None:
        return []
    own_way = float(own.pose.position[2])
    camera, own_camera = Intrinsics.from_fov(WIDTH, HEIGHT), Intrinsics.from_fov(*FULL)
    rows = []
    for true in DISTANCES:
        scale = own_way * camera.focal / (true * own_camera.focal)
        seen = reader.read(shrunk(full, scale))
        if seen is None or seen.pose is None:
            rows.append(Compared(true, *[math.nan] * 4))
            continue
        eyes = math.nan
        if seen.eyes is not None and own.eyes is not None:
            eyes = angle(seen.eyes.gaze.mean(axis=0), own.eyes.gaze.mean(axis=0))
        rows.append(
            Compared(
                true,
                float(seen.pose.position[2]) / true - 1.0,
                angle(seen.pose.rotation[:, 0], own.pose.rotation[:, 0]),
                eyes,
                seen.frame.smile - own.frame.smile,
            )
        )
    return rows


def images(video: Path) -> list[Any]:
    """Frames of a video, evenly spread."""
    capture = cv2.VideoCapture(str(video))
    length = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    taken = []
    for number in np.linspace(0, length - 1, FRAMES).round():
        capture.set(cv2.CAP_PROP_POS_FRAMES, number)
        good, image = capture.read()
        if good:
            taken.append(image)
    capture.release()
    return taken


def print_table(rows: list[Compared], out: Path | None) -> bool:
    """Print errors by distance; whether they keep what is promised."""
    camera = Intrinsics.from_fov(WIDTH, HEIGHT)
    print(
        f"{WIDTH} x {HEIGHT} pixels, 60 degrees: a face's place is told up to"
        f" {head_range(camera):.1f} m, its eyes and smile up to {eyes_range(camera):.1f} m"
    )
    header = (
        "true [m]",
        "read",
        "distance: mean",
        "worst [%]",
        "head [deg]",
        "eyes [deg]",
        "smile",
    )
    print("  ".join(header))
    lines, fine = [], True
    for true in DISTANCES:
        here = [row for row in rows if row.true == true]
        known = [row for row in here if not math.isnan(row.distance)]
        wrong = [100 * row.distance for row in known]
        worst = max(wrong, key=abs, default=math.nan)
        if true <= 4.0:
            fine &= len(known) == len(here) and abs(worst) <= 8.0
        elif true > 1.1 * head_range(camera):
            fine &= not known
        line: list[object] = [
            true, f"{len(known)}/{len(here)}", mean(wrong), worst,
            mean([row.head for row in known]), mean([row.eyes for row in known]),
            mean([abs(row.smile) for row in known]),
        ]  # fmt: skip
        lines.append(line)
        cells = [f"{cell:.2f}" if isinstance(cell, float) else str(cell) for cell in line]
        pairs = zip(header, cells, strict=True)
        print("  ".join(f"{cell:>{len(name)}}" for name, cell in pairs))
    if out is not None:
        write_table(out, header, lines)
    return fine


def mean(values: list[float]) -> float:
    """The mean of those that are known; NaN where none is."""
    known = [value for value in values if not math.isnan(value)]
    return sum(known) / len(known) if known else math.nan


def frame_rate(options: SourceOptions, video: Path) -> tuple[float, Latency]:
    """Frames a second from the file to the belief, from its first half second on; the latency."""
    watch = Watch(open_source(video, options), load_model())
    began, count = math.nan, 0  # the networks are set up in the first half second
    for watched in watch.run():
        if watched.frame.t >= 0.5:
            began, count = (time.perf_counter(), 0) if math.isnan(began) else (began, count + 1)
    rate = count / (time.perf_counter() - began)
    return rate, watch.latency or Latency(math.nan, math.nan)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", type=Path, required=True, help="a folder of videos of one face")
    parser.add_argument("--model-files", type=Path, help="a folder with the networks' files")
    parser.add_argument("--out", type=Path, help="write the table into this CSV")
    arguments = parser.parse_args()
    videos = sorted(p for p in arguments.data.glob("*") if p.suffix.lower() in SUFFIXES)
    if not videos:
        print(f"{arguments.data}: no video here ({' '.join(SUFFIXES)})", file=sys.stderr)
        return 2
    options = SourceOptions(model_files=arguments.model_files)
    cv2.setNumThreads(2)
    try:
        reader = Reader(arguments.model_files)
        rows = [
            row for video in videos for image in images(video) for row in compare(reader, image)
        ]
        reader.close()
        fine = print_table(rows, arguments.out)
        for video in videos:
            capture = cv2.VideoCapture(str(video))
            size = int(capture.get(3)), int(capture.get(4))
            capture.release()
            rate, latency = frame_rate(options, video)
            print(
                f"{video.name}, {size[0]} x {size[1]}: {rate:.0f} frames a second; from picture to"
                f" belief {1000 * latency.median:.0f} ms, 95 % within {1000 * latency.high:.0f} ms"
            )
    except KendonError as error:
        print(error, file=sys.stderr)
        return 2
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())

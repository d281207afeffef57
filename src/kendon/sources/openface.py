"""The CSV of OpenFace's FeatureExtraction (Baltrusaitis et al. 2018), as the thesis read it.

OpenFace's camera frame has x to the right, y down and z away from the camera, in millimetres;
its head rotation is R = Rx Ry Rz with the face looking along R (0, 0, -1). Columns are found by
name, as their groups depend on OpenFace's flags and version. Only its output is read here.
"""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import numpy as np

from kendon.errors import DataError
from kendon.features.smile import smile
from kendon.person import FloatArray, Track
from kendon.sources.base import CameraMount, SourceOptions, register
from kendon.sources.camera_geometry import MountedCamera
from kendon.sources.recording import RecordedSource
from kendon.tables import Table, peek_header, read_table
from kendon.tracks import MAX_COORDINATE, read_stamps

_MILLIMETRES = 1000.0
#: The frame rate assumed where OpenFace numbered images instead of stamping them [1/s].
_IMAGE_RATE = 30.0
_POSITION = ("pose_Tx", "pose_Ty", "pose_Tz")
_ROTATION = ("pose_Rx", "pose_Ry", "pose_Rz")
_REQUIRED = ("timestamp", "success", *_POSITION)

#: kendon's head axes (out of the face, to the person's left, up) in OpenFace's head frame,
#: in which an upright face that looks back along the camera's axis is not rotated.
_HEAD_AXES = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])

#: The person's left eye is OpenFace's eye 1, with its corners at landmarks 42 and 45; the right
#: one is eye 0, with 36 and 39 (thesis 3.3.3, figure 3.6).
_EYES = ((1, (42, 45)), (0, (36, 39)))


@register
class OpenFaceSource(RecordedSource):
    """A face over time as OpenFace saw it."""

    name = "openface"
    reads = "OpenFace's FeatureExtraction CSV: timestamp, success, pose_Tx and more"
    example = "face.csv"

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """A .csv file with OpenFace's head position."""
        return Path(spec).suffix.lower() == ".csv" and "pose_Tx" in peek_header(spec)

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> OpenFaceSource:
        """Read the file, seen from the camera at `options.camera`.

        Raises:
            DataError: the file is missing, torn, unsorted, or lacks a required column.
        """
        table = _read(spec)
        source = cls(_track(table, _stamps(table, options.fps), options.camera))
        if options.fps is None and not _is_clock(table):
            source.notes = (
                f"{spec}: OpenFace only counted the images here (a millisecond each);"
                f" read at {_IMAGE_RATE:g} frames a second, say --fps if that is wrong",
            )
        return source


def read_openface(
    path: str | Path, camera: CameraMount | None = None, *, fps: float | None = None
) -> Track:
    """Read OpenFace's CSV into a track in the robot's base frame.

    Rows with ``success`` 0 are unknown. Where several faces were tracked (``face_id``), the one
    seen in most rows is read.

    Args:
        path: of the file.
        camera: where the camera sits on the robot; by default 1.2 m up, looking forward.
        fps: frames a second, instead of the file's own stamps. OpenFace stamps the images of a
            folder a millisecond apart whatever their rate; such files are read at 30 frames a
            second unless told otherwise.

    Raises:
        DataError: the file is missing, torn, unsorted, or lacks a required column.
    """
    table = _read(path)
    return _track(table, _stamps(table, fps), camera or CameraMount())


def _read(path: str | Path) -> Table:
    table = read_table(path)
    table.require(*_REQUIRED)
    return _most_seen_face(table) if "face_id" in table else table


def _is_clock(table: Table) -> bool:
    """Whether the stamps are times, not a count of images (no camera makes 500 a second)."""
    steps = np.diff(table.numbers("timestamp"))
    # Neither missing nor unsorted stamps make it a count: they are told to the user as times.
    return not bool((steps > 0).any() and (np.abs(steps) <= 1 / 500).mean() > 0.5)


def _stamps(table: Table, fps: float | None) -> FloatArray:
    if fps is None and _is_clock(table):
        return read_stamps(table, "timestamp")
    frames = table.numbers("frame") if "frame" in table else np.arange(len(table.rows)) + 1.0
    if not (np.diff(frames) > 0).all():
        at = int(np.argmax(~(np.diff(frames) > 0))) + 1
        raise table.error("the frame numbers do not grow", at, "frame")
    return np.asarray((frames - frames[0]) / (fps or _IMAGE_RATE))


def _track(table: Table, t: FloatArray, mount: CameraMount) -> Track:
    camera = MountedCamera.from_mount(mount)
    seen = table.numbers("success", low=0, high=1) > 0

    def columns(*names: str, limit: float = math.inf) -> FloatArray:
        values = np.stack([table.numbers(n, low=-limit, high=limit) for n in names], axis=-1)
        values[~seen] = np.nan
        return values

    far = MAX_COORDINATE * _MILLIMETRES
    head = camera.points(columns(*_POSITION, limit=far) / _MILLIMETRES)
    rotation = np.full((len(t), 4), np.nan)
    if all(name in table for name in _ROTATION):
        angles = columns(*_ROTATION)
        known = np.isfinite(angles).all(axis=1)
        from scipy.spatial.transform import Rotation  # half a second: not for those who need none

        # Intrinsic axes in the order x, y, z are the product Rx Ry Rz.
        turned = Rotation.from_euler("XYZ", angles[known]).as_matrix()
        rotation[known] = Rotation.from_matrix(camera.rotation @ turned @ _HEAD_AXES).as_quat()

    eyes = eye_gaze = None
    corners = [f"{axis}_{mark}" for _, marks in _EYES for mark in marks for axis in "XYZ"]
    gazes = [f"gaze_{eye}_{axis}" for eye, _ in _EYES for axis in "xyz"]
    if all(name in table for name in (*corners, *gazes)):
        ends = columns(*corners, limit=far).reshape(-1, 2, 2, 3) / _MILLIMETRES
        eyes = camera.points(ends.mean(axis=2))
        eye_gaze = camera.directions(columns(*gazes).reshape(-1, 2, 3))
    smiles = None
    if "AU06_r" in table and "AU12_r" in table:
        smiles = smile(columns("AU06_r")[:, 0], columns("AU12_r")[:, 0])
    return Track.build(
        t,
        head,
        head_rotation=rotation,
        eyes=eyes,
        eye_gaze=eye_gaze,
        smile=smiles,
        name=table.path.stem,
    )


def _most_seen_face(table: Table) -> Table:
    faces = table.texts("face_id")
    seen = Counter(
        face
        for face, ok in zip(faces, table.texts("success"), strict=True)
        if ok not in ("", "0", "0.0")
    )
    if not seen:
        raise DataError("OpenFace found no face in any row", file=table.path, column="success")
    wanted = seen.most_common(1)[0][0]
    keep = [i for i, face in enumerate(faces) if face == wanted]
    return Table(
        table.path,
        table.columns,
        [table.rows[i] for i in keep],
        [table.row_numbers[i] for i in keep],
    )

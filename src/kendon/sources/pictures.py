"""What a video file and a live camera have in common: pictures in, one greeted person out."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from kendon.person import PersonFrame
from kendon.sources.base import Source, SourceOptions
from kendon.sources.body_joints import BodyReading, body_joints, match_bodies
from kendon.sources.calibration import calibrated, read_calibration
from kendon.sources.camera_geometry import (
    DEFAULT_FOV,
    FloatArray,
    Intrinsics,
    MountedCamera,
    import_cv2,
)
from kendon.sources.face_finder import ByteImage, YuNet
from kendon.sources.face_landmarks import FaceLandmarker, import_mediapipe
from kendon.sources.face_person import PersonReader, Scene
from kendon.sources.face_reader import MAX_FACES, FaceDetector, FaceReader, SeenFace
from kendon.sources.model_files import FACE_FINDER, FACE_LANDMARKER, find_model_file
from kendon.sources.pose_landmarks import BodyDetector, PoseLandmarker, check_pose_model


class Picture(NamedTuple):
    """One picture of a video or camera."""

    t: float  # [s], its stamp
    image: ByteImage | None  # (height, width, 3) BGR; None while a camera gives none
    arrived: float  # [s], of `time.monotonic`, when it was there to be read


@dataclass(frozen=True)
class Look:
    """A picture and what was read in it."""

    picture: Picture
    camera: Intrinsics  # that took it
    mounted: MountedCamera  # as it sits on the robot
    scene: Scene


class Detectors(NamedTuple):
    """The networks that read pictures."""

    faces: FaceDetector
    bodies: BodyDetector | None


#: Makes the detectors; called when the first picture is wanted.
DetectorMaker = Callable[[], Detectors]


class PictureSource(Source):
    """A person in pictures.

    With each frame, `look` is the picture that it was read in.

    Args:
        options: of the source.
        make_detectors: called when the first picture is wanted.
    """

    #: The picture of the newest frame and what was read in it; None where there was none.
    look: Look | None = None
    #: Pictures a second that the source means to give; NaN where it does not know.
    rate: float = math.nan

    def __init__(self, options: SourceOptions, make_detectors: DetectorMaker) -> None:
        self._options = options
        self._make_detectors = make_detectors
        self._calibration = options.calibration and read_calibration(options.calibration)
        self.notes = self._assumptions()
        self._last_greeted: int | None = None

    @abstractmethod
    def pictures(self) -> Generator[Picture, None, None]:
        """The pictures, with growing stamps [s]; closed, it lets go of what it reads."""

    def frames(self) -> Iterator[PersonFrame]:
        """The greeted person, one frame a picture.

        Raises:
            DataError: there is something wrong with what is read, or with the calibration.
        """
        reader: PersonReader | None = None
        mounted = MountedCamera.from_mount(self._options.camera)
        with ExitStack() as stack:
            pictures = stack.enter_context(closing(self.pictures()))
            faces, bodies = self._make_detectors()
            self._last_greeted = None
            stack.enter_context(closing(faces))
            if bodies is not None:
                stack.enter_context(closing(bodies))
            for picture in pictures:
                t, image = picture.t, picture.image
                if image is None:
                    self.look = None
                    yield PersonFrame(t)
                    continue
                height, width = image.shape[:2]
                # A camera that was away may come back with pictures of another size.
                if reader is None or (reader.camera.width, reader.camera.height) != (width, height):
                    camera = self._intrinsics(width, height)
                    reader = PersonReader(camera, mounted, self._options.person)
                seen = faces.detect(image, t)
                joints = _joints(reader, bodies.detect(image, t), seen) if bodies else None
                scene = reader.read(seen, t, joints)
                self._tell_of_change(scene)
                self.look = Look(picture, reader.camera, mounted, scene)
                yield scene.frame

    def _intrinsics(self, width: int, height: int) -> Intrinsics:
        if self._calibration and self._options.calibration:
            return calibrated(self._calibration, width, height, self._options.calibration)
        return Intrinsics.from_fov(width, height, self._options.fov)

    def _assumptions(self) -> tuple[str, ...]:
        if self._options.calibration is not None or self._options.fov is not None:
            return ()
        return (
            "The camera's horizontal field of view is taken to be"
            f" {math.degrees(DEFAULT_FOV):.0f} degrees; with another one all distances are off by"
            " one factor.",
        )

    def _tell_of_change(self, scene: Scene) -> None:
        """Note who is greeted instead of whom."""
        now = scene.greeted
        if now is not None:
            if self._last_greeted is not None and now != self._last_greeted:
                self.notes += (
                    f"From {scene.frame.t:.1f} s on person {now} is greeted, before it was person"
                    f" {self._last_greeted}; --person N reads one of them alone.",
                )
            self._last_greeted = now


def _joints(
    reader: PersonReader, bodies: list[BodyReading], faces: list[SeenFace]
) -> dict[int, dict[str, FloatArray]]:
    """By the face's number, the joints of the body that it belongs to."""
    matched = match_bodies(bodies, {face.number: face.box for face in faces})
    joints = {}
    for face in faces:
        if face.number in matched and (found := reader.pose(face)):
            joints[face.number] = body_joints(
                matched[face.number], found[1].position, reader.camera
            )
    return joints


def detector_maker(options: SourceOptions) -> DetectorMaker:
    """What makes the detectors later; what can be missing for them is found missing now.

    Raises:
        MissingExtraError: the ``camera`` extra is not installed.
        ModelFileError: a network's file cannot be had.
    """
    import_cv2("reading videos")
    import_mediapipe()
    finder = find_model_file(FACE_FINDER.name, options.model_files)
    landmarker = find_model_file(FACE_LANDMARKER.name, options.model_files)
    if options.pose_model is not None:
        check_pose_model(options.pose_model)
    return lambda: _detectors(finder, landmarker, options.pose_model)


def _detectors(finder: Path, landmarker: Path, pose_model: Path | None) -> Detectors:
    bodies = None if pose_model is None else PoseLandmarker(pose_model, MAX_FACES)
    return Detectors(FaceReader(YuNet(finder), FaceLandmarker(landmarker)), bodies)

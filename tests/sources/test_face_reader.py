"""Pictures to people, with networks that see what they are told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sources.painted_faces import ToldFinder, ToldLandmarks, face_at, seen

from kendon.sources.base import CameraMount
from kendon.sources.camera_geometry import Intrinsics, MountedCamera
from kendon.sources.face_finder import FaceBox
from kendon.sources.face_landmarks import Window
from kendon.sources.face_person import PersonReader, Scene, eyes_range, head_range
from kendon.sources.face_reader import (
    LOST_SEARCH_PERIOD,
    MAX_FACES,
    SEARCH_PERIOD,
    FaceReader,
)

pytest.importorskip("cv2", reason="OpenCV is not installed (the 'camera' extra)")

CAMERA = Intrinsics.from_fov(1280, 720)
PICTURE = np.zeros((720, 1280, 3), dtype=np.uint8)
LEVEL = MountedCamera.from_mount(CameraMount())


def reader(only: int | None = None, camera: Intrinsics = CAMERA) -> PersonReader:
    return PersonReader(camera, LEVEL, only)


def read(
    people: PersonReader, *places: tuple[int, float, float], t: float, yaw: float = 0
) -> Scene:
    """People at x and z of the optical frame [m], by number."""
    faces = [seen(n, face_at(x, 0, z, camera=CAMERA)) for n, x, z in places]
    return people.read(faces, t)


def test_the_picture_is_searched_now_and_then_and_faces_read_in_each() -> None:
    face = face_at(0, 0, 2, camera=CAMERA)
    finder, landmarks = ToldFinder(face.box), ToldLandmarks(face)
    faces = FaceReader(finder, landmarks)
    found = [faces.detect(PICTURE, i / 100) for i in range(101)]
    assert all(len(one) == 1 and one[0].number == 1 and one[0].reading is face for one in found)
    assert finder.searches == 1 + round(1 / SEARCH_PERIOD)
    assert len(landmarks.windows) == 101
    faces.close()
    assert landmarks.closed


def test_while_somebody_is_lost_it_is_searched_more_often() -> None:
    finder = ToldFinder()
    faces = FaceReader(finder, ToldLandmarks())
    assert not any(faces.detect(PICTURE, i / 100) for i in range(101))
    assert finder.searches == 1 + round(1 / LOST_SEARCH_PERIOD)


def test_what_is_found_but_not_read_is_a_box_alone() -> None:
    finder = ToldFinder(FaceBox(100, 100, 20, 24))
    (face,) = FaceReader(finder, ToldLandmarks()).detect(PICTURE, 0.0)
    assert face.reading is None
    scene = reader().read([face], 0.0)
    assert scene.people[0].pose is None
    assert not scene.frame.seen


def test_one_face_found_twice_is_one() -> None:
    face = face_at(0, 0, 2, camera=CAMERA)
    x, y, width, height = face.box
    finder = ToldFinder(face.box, FaceBox(x + 9, y - 9, width, height))
    assert len(FaceReader(finder, ToldLandmarks(face)).detect(PICTURE, 0.0)) == 1


def test_of_a_crowd_the_largest_are_read() -> None:
    crowd = [face_at(x, 0, 2 + abs(x), camera=CAMERA) for x in np.linspace(-0.9, 0.9, 7)]
    landmarks = ToldLandmarks(*crowd)
    faces = FaceReader(ToldFinder(*(face.box for face in crowd)), landmarks)
    assert len(faces.detect(PICTURE, 0.0)) == len(landmarks.windows) == MAX_FACES


def test_the_window_holds_the_face_with_a_margin() -> None:
    window = Window.around(FaceBox(100.0, 50.0, 40.0, 50.0))
    assert window.side == 80
    assert (window.x + window.side / 2, window.y + window.side / 2) == pytest.approx((120, 75))


def test_a_face_is_placed_up_to_its_range_and_then_not_at_all() -> None:
    assert 4 < head_range(CAMERA) < 6
    near = read(reader(), (1, 0.0, head_range(CAMERA) - 0.1), t=0.0)
    assert near.frame.head[0] == pytest.approx(head_range(CAMERA) - 0.1, rel=0.01)
    far = read(reader(), (1, 0.0, head_range(CAMERA) + 0.1), t=0.0)
    assert not far.frame.seen
    assert far.greeted is None
    assert len(far.people) == 1


def test_eyes_and_smile_have_a_shorter_range() -> None:
    near = read(reader(), (1, 0.0, eyes_range(CAMERA) - 0.1), t=0.0).frame
    far = read(reader(), (1, 0.0, eyes_range(CAMERA) + 0.1), t=0.0).frame
    assert near.eyes is not None
    assert near.smile > 1
    assert far.seen
    assert far.eyes is None
    assert far.eye_gaze is None
    assert math.isnan(far.smile)
    assert math.isfinite(far.head_rotation[0])


def test_the_greeted_one_is_told_by_number() -> None:
    people = reader()
    assert read(people, (1, 0.0, 3.0), (2, 0.5, 2.0), t=0.0).frame.who == 2
    assert read(people, (2, 0.5, 2.0), (1, 0.0, 1.0), t=0.1).frame.head[0] == pytest.approx(2, 0.01)
    assert read(reader(only=1), (1, 0.0, 3.0), (2, 0.5, 2.0), t=0.0).frame.who == 1


def test_between_two_people_nobody_is_seen_for_an_interval() -> None:
    people = reader()
    frames = [read(people, (1, 0.0, 3.0), t=i / 10).frame for i in range(5)]
    frames += [read(people, (2, 0.8, 2.0), t=0.5 + i / 10).frame for i in range(25)]
    who = [frame.who for frame in frames]
    assert who[:5] == [1] * 5
    assert who[-5:] == [2] * 5
    change = next(i for i, frame in enumerate(frames) if frame.who == 2)
    assert not any(frame.seen for frame in frames[5:change])
    assert change / 10 > 1.5  # the first one is waited for


def test_somebody_who_looks_aside_does_not_face_the_robot() -> None:
    scene = PersonReader(CAMERA, LEVEL).read(
        [
            seen(1, face_at(0, 0, 1.0, yaw=0.9, camera=CAMERA)),
            seen(2, face_at(0.4, 0, 2.0, camera=CAMERA)),
        ],
        0.0,
    )
    assert scene.greeted == 2


def test_a_lens_that_bends_is_straightened_first() -> None:
    lens = (-0.3, 0.1, 0.0, 0.0)
    bent = Intrinsics(1280, 720, CAMERA.focal, CAMERA.focal, CAMERA.centre, lens)
    face = face_at(0.7, 0.3, 1.5, camera=CAMERA)
    shown = type(face)(bent.bend(face.landmarks), face.blendshapes)
    frame = reader(camera=bent).read([seen(1, shown)], 0.0).frame
    assert frame.head == pytest.approx((1.5, -0.7, 0.9), abs=0.01)
    wrong = reader().read([seen(1, shown)], 0.0).frame
    assert np.linalg.norm(np.subtract(wrong.head, (1.5, -0.7, 0.9))) > 0.05


def test_landmarks_that_fit_no_face_place_nobody() -> None:
    face = face_at(0, 0, 1.5, camera=CAMERA)
    noise = np.random.default_rng(0).normal(0, 1, face.landmarks.shape)
    steady = type(face)(face.landmarks + 0.01 * face.box.size * noise, face.blendshapes)
    torn = type(face)(face.landmarks + 0.06 * face.box.size * noise, face.blendshapes)
    assert reader().read([seen(1, steady)], 0.0).frame.seen
    assert not reader().read([seen(1, torn)], 0.0).frame.seen


def test_faces_seen_last_are_read_before_those_that_are_lost() -> None:
    crowd = [face_at(x, 0, 2.5 + abs(x), camera=CAMERA) for x in (-0.9, -0.5, 0.0, 0.5)]
    near = face_at(0.9, 0, 1.2, camera=CAMERA)
    finder, landmarks = ToldFinder(*(f.box for f in crowd)), ToldLandmarks(*crowd)
    faces = FaceReader(finder, landmarks)
    faces.detect(PICTURE, 0.0)
    finder.boxes, landmarks.readings = [near.box], [near]  # they go, somebody else comes
    seen_at = [len(faces.detect(PICTURE, 0.25 + i / 30)) for i in range(15)]
    assert seen_at == [1] * 15

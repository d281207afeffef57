"""The overview holds both bodies, whatever the page leaves of the picture."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from viewer.browser import encounters

pytest.importorskip("viser", reason="viser is not installed")

from kendon.geometry import Vec3
from kendon.person import FloatArray
from kendon.viewer.browser.cameras import FOV, VIEWS, Aim, Cameras, course, from_above, overview
from kendon.viewer.browser.session import Session
from kendon.viewer.browser.stage import Shown

DESKTOP, PHONE, WIDE = (562, 800), (390, 844), (900, 600)
places = st.tuples(st.floats(-6, 6), st.floats(-6, 6))


def instant(robot: tuple[float, float], person: tuple[float, float] | None) -> Shown:
    """Two bodies at places on the floor [m]."""
    row: Any = None if person is None else np.array([*person, 1.6, 0.0, 0.0, 0.0, 1.0], np.float32)
    anything: Any = None
    return Shown(anything, row, np.array([*robot, 0.0], np.float32))


def seen_at(point: Vec3, aim: Aim, size: tuple[int, int]) -> tuple[float, float]:
    """Where a point is in the picture [pixels] from its upper left corner, as a pinhole sees it."""
    eye, target = np.array(aim[0]), np.array(aim[1])
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    way: FloatArray = np.array(point) - eye
    depth = float(way @ ahead)
    assert depth > 0
    focal = size[1] / (2 * math.tan(FOV / 2))
    x, y = float(way @ right), float(way @ np.cross(right, ahead))
    return size[0] / 2 + focal * x / depth, size[1] / 2 - focal * y / depth


@given(places, places, st.sampled_from([DESKTOP, PHONE, WIDE]))
def test_feet_and_words_of_both_bodies_are_in_sight(
    robot: tuple[float, float], person: tuple[float, float], size: tuple[int, int]
) -> None:
    shown = instant(robot, person)
    lowest = 0.4 * size[1] if size == PHONE else size[1]  # panels lie over the rest
    for aim in (overview([shown], course(shown), size), from_above([shown], size)):
        for (x, y), height in ((robot, 1.6), (person, 2.0)):
            for z in (0.0, height):
                across, down = seen_at((x, y, z), aim, size)
                assert 80 < across < size[0] - 80
                assert 25 < down < lowest


@given(places, st.floats(0.0, 2 * math.pi), st.floats(2.0, 7.0))
def test_nobody_hides_behind_the_other(
    robot: tuple[float, float], bearing: float, apart: float
) -> None:
    person = (robot[0] + apart * math.cos(bearing), robot[1] + apart * math.sin(bearing))
    shown = instant(robot, person)
    aim = overview([shown], course(shown), DESKTOP)
    (left, _), (right, _) = (seen_at((*at, 1.0), aim, DESKTOP) for at in (robot, person))
    assert right - left > 150


def test_two_who_meet_are_drawn_larger() -> None:
    def height(apart: float) -> float:
        shown = instant((0.0, 0.0), (apart, 0.0))
        aim = overview([shown], course(shown), DESKTOP)
        feet, top = (seen_at((apart, 0.0, z), aim, DESKTOP)[1] for z in (0.0, 1.7))
        return feet - top

    assert height(1.0) > 1.5 * height(3.0) > 2.0 * height(6.0)


def test_a_robot_alone_is_in_sight() -> None:
    shown = instant((2.0, 1.0), None)
    across, down = seen_at((2.0, 1.0, 0.5), overview([shown], course(shown), DESKTOP), DESKTOP)
    assert 80 < across < DESKTOP[0] - 80
    assert 0 < down < DESKTOP[1]


def test_a_whole_encounter_is_in_sight_at_once() -> None:
    stage = encounters.simulated().stage
    for _ in stage.run():
        pass
    instants = [stage.shown(place) for place in range(len(stage.snapshots))]
    aim = overview(instants, course(instants[0]), DESKTOP)
    for shown in instants:
        if shown.person is not None:
            x, y, z = shown.person[:3].astype(float).tolist()
            across, down = seen_at((x, y, z), aim, DESKTOP)
            assert 80 < across < DESKTOP[0] - 80
            assert 25 < down < DESKTOP[1]


# ---- going along


class Client:
    """A browser, with the part of viser's handle of its camera that matters here."""

    client_id = 1
    atomic = contextlib.nullcontext
    image_width, image_height = DESKTOP

    def __init__(self) -> None:
        self.camera = self.client = self
        self.position = self.look_at = np.array([9.0, 0.0, 2.0])
        self.told: Callable[[Any], None] = print

    def on_update(self, told: Callable[[Any], None]) -> None:
        self.told = told

    def __setattr__(self, name: str, value: Any) -> None:
        moves = name in ("position", "look_at")
        super().__setattr__(name, np.array(value, dtype=float) if moves else value)

    @property
    def eye(self) -> Vec3:
        x, y, z = self.position.tolist()
        return x, y, z

    def tell(self, eye: Vec3) -> None:
        """Say where the camera is, as browsers do once they have drawn."""
        now, self.position = self.eye, np.array(eye)
        self.told(self)
        self.position = np.array(now)


@pytest.fixture
def watched() -> tuple[Session, Cameras, Client]:
    """A session, and a browser that has just shown its page."""
    connected: list[Callable[[Any], None]] = []
    server: Any = SimpleNamespace(
        initial_camera=SimpleNamespace(), on_client_connect=connected.append,
        on_client_disconnect=connected.append,
    )  # fmt: skip
    session, cameras, client = encounters.simulated(), Cameras(server), Client()
    cameras.start(session)
    connected[-1](client)
    session.step(0.1)
    cameras.follow(session, 0.1)
    return session, cameras, client


Watched = tuple[Session, Cameras, Client]


def test_a_new_page_begins_with_the_overview(watched: Watched) -> None:
    session, _, client = watched
    shown = session.shown()
    assert client.eye == pytest.approx(overview([shown], course(shown), DESKTOP)[0], abs=1e-6)


def test_the_camera_goes_along_and_reports_of_where_it_was_do_not_stop_it(watched: Watched) -> None:
    session, cameras, client = watched
    was = [client.eye] * 20
    for _ in range(100):
        session.step(0.1)
        cameras.follow(session, 0.1)
        was.append(client.eye)
        client.tell(was[-20])  # two seconds late
    shown, first = session.shown(), instant((0.0, 0.0), (7.0, 0.0))
    nearer = math.dist(client.eye, [*shown.robot[:2].tolist(), 1.0])
    assert nearer < 0.7 * math.dist(overview([first], course(first), DESKTOP)[0], (0, 0, 1.0))
    for (x, y), z in ((shown.robot[:2], 1.2), (shown.person[:2], 1.6)):  # type: ignore[index]
        across, down = seen_at((x, y, z), (client.eye, tuple(client.look_at)), DESKTOP)
        assert 60 < across < DESKTOP[0] - 60
        assert 20 < down < DESKTOP[1]


def test_a_camera_that_its_user_moves_stays_where_it_is_until_a_view_is_chosen(
    watched: Watched,
) -> None:
    session, cameras, client = watched
    mine = (3.0, -8.0, 5.0)
    client.position = np.array(mine)
    client.tell(mine)
    for _ in range(30):
        session.step(0.1)
        cameras.follow(session, 0.1)
    assert client.eye == mine
    for view in VIEWS:
        cameras.choose(client, view, session)  # type: ignore[arg-type]
        cameras.follow(session, 0.1)
        assert math.dist(client.eye, mine) > 1.0

"""Where the page looks from: views a user can choose, two of which follow a body's eyes."""

from __future__ import annotations

import math

import viser

from kendon.viewer.browser.session import Session
from kendon.viewer.browser.stage import Shown

#: The views by the names of their buttons.
VIEWS = ("Overview", "From above", "Robot's eyes", "Person's eyes")
#: The vertical field of view [rad].
FOV = math.radians(50)
#: Pictures narrower than this are a phone's (width over height).
_NARROW = 0.6


class Cameras:
    """Moves each client's camera as its user chose.

    Args:
        server: the server.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._following: dict[int, str] = {}  # client -> the view that goes along
        self._server.initial_camera.up = (0.0, 0.0, 1.0)
        self._server.initial_camera.fov = FOV

        @server.on_client_disconnect
        def _(client: viser.ClientHandle) -> None:
            self._following.pop(client.client_id, None)

    def start(self, session: Session) -> None:
        """Let new clients begin with the overview."""
        position, look_at = overview(session.shown())
        self._server.initial_camera.position = position
        self._server.initial_camera.look_at = look_at

        @self._server.on_client_connect
        def _(client: viser.ClientHandle) -> None:
            # Wider ones begin as set above: what their panels leave is not known yet.
            if _aspect(client) <= _NARROW:
                session.post(lambda: self.choose(client, VIEWS[0], session))

    def choose(self, client: viser.ClientHandle, view: str, session: Session) -> None:
        """Bring a client to one of `VIEWS`."""
        self._following.pop(client.client_id, None)
        shown = session.shown()
        if view == VIEWS[0]:
            _aim(client, *overview(shown, _aspect(client)))
        elif view == VIEWS[1]:
            x, y = _middle(shown)
            _aim(client, (x - 0.01, y, 14.0), (x, y, 0.0))
        else:
            self._following[client.client_id] = view

    def follow(self, session: Session) -> None:
        """Take along the clients that look through somebody's eyes."""
        if not self._following:
            return
        shown = session.shown()
        clients = self._server.get_clients()
        _, face, (w, x, y, z) = session.stage.form.draw(shown.robot)
        for number, view in list(self._following.items()):
            client = clients.get(number)
            if client is None:
                continue
            if view == VIEWS[2]:
                _look_out(client, face, (x, y, z, w), 0.16)
            elif shown.person is not None:
                px, py, pz, qx, qy, qz, qw = shown.person[:7].astype(float).tolist()
                if not math.isnan(pz + qw):
                    _look_out(client, (px, py, pz), (qx, qy, qz, qw), 0.12)


def overview(
    shown: Shown, aspect: float = 0.8
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """From the side, with both in sight: where the camera is, and what it looks at [m].

    Args:
        shown: the instant.
        aspect: width over height of the picture. In one as narrow as a phone's, panels lie over
            the lower half: both bodies go in the upper.
    """
    robot = shown.robot[:2].astype(float).tolist()
    person = robot if shown.person is None else shown.person[:2].astype(float).tolist()
    dx, dy = person[0] - robot[0], person[1] - robot[1]
    apart = max(3.0, math.hypot(dx, dy))
    angle = math.atan2(dy, dx) if dx or dy else 0.0
    x, y = _middle(shown)
    # Across the line between them, a little behind the robot, far enough to have both in sight.
    side = angle - math.radians(105)
    # Labels, too: on a phone they are as wide as three metres.
    margin = 2.2 if aspect > _NARROW else 4.0
    away = (apart + margin) / (2 * max(0.35, min(aspect, 1.2)) * math.tan(FOV / 2))
    eye = (x + away * math.cos(side), y + away * math.sin(side), 0.34 * away + 0.6)
    if aspect > _NARROW:
        return eye, (x, y, 0.8)
    # What is looked at is lowered until the bodies are three tenths of the picture above it.
    return eye, (x, y, 0.8 - 0.6 * math.tan(FOV / 2) * away)


def _aspect(client: viser.ClientHandle) -> float:
    return client.camera.image_width / max(1, client.camera.image_height)


def _middle(shown: Shown) -> tuple[float, float]:
    x, y = shown.robot[:2].astype(float).tolist()
    if shown.person is None:
        return x + 2.0, y
    px, py = shown.person[:2].astype(float).tolist()
    return (x + px) / 2, (y + py) / 2


def _look_out(
    client: viser.ClientHandle,
    face: tuple[float, float, float],
    turn: tuple[float, float, float, float],
    ahead: float,
) -> None:
    """Look out of a face, from a little before it so that it is not in the way."""
    x, y, z, w = turn
    forward = (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y))
    eye = (
        face[0] + ahead * forward[0], face[1] + ahead * forward[1], face[2] + ahead * forward[2]
    )  # fmt: skip
    target = (eye[0] + 2 * forward[0], eye[1] + 2 * forward[1], eye[2] + 2 * forward[2])
    _aim(client, eye, target)


def _aim(
    client: viser.ClientHandle,
    position: tuple[float, float, float],
    look_at: tuple[float, float, float],
) -> None:
    with client.atomic():
        client.camera.up_direction = (0.0, 0.0, 1.0)
        client.camera.position = position
        client.camera.look_at = look_at


def floor_point(
    eye: tuple[float, float, float], through: tuple[float, float, float]
) -> tuple[float, float] | None:
    """Where the line of sight from an eye through a point meets the floor [m]; None if nowhere.

    >>> floor_point((0.0, 0.0, 2.0), (1.0, 0.0, 1.0))
    (2.0, 0.0)
    """
    down = eye[2] - through[2]
    if down <= 1e-6:
        return None
    way = eye[2] / down
    return (eye[0] + way * (through[0] - eye[0]), eye[1] + way * (through[1] - eye[1]))

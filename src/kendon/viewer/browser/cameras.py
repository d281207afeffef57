"""Where the page looks from: views a user can choose, all of which go along with the bodies."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

import numpy as np
import viser

from kendon.geometry import Vec3
from kendon.person import FloatArray
from kendon.viewer.browser.session import Session
from kendon.viewer.browser.stage import Shown

#: The views by the names of their buttons.
VIEWS = ("Overview", "From above", "Robot's eyes", "Person's eyes")
#: The vertical field of view [rad].
FOV = math.radians(50)
#: Pictures narrower than this are a phone's (width over height): panels lie over all but the upper
#: two fifths of them.
_NARROW = 0.6
_UPPER = 0.4
#: A picture of that many pixels is what a page has between its panels, as a rule.
SIZE = (600, 800)
#: Room for words at the left and right rim, the upper one and the lower one [pixels].
_RIM = (85.0, 34.0, 24.0)
#: The overview looks down by so much [rad], from across the way between the two, a little behind
#: the robot; the bodies are at least so far away [m].
_DOWN, _ACROSS, _NEAREST = math.radians(17), math.radians(122), 5.0
#: Where words stand over a body, and where its hands may be beside it [m].
_WORDS, _ARMS = 0.45, 0.5
#: How high a robot's face is, about [m].
_ROBOT_TOP = 1.2
#: How soon the overview is where the bodies call for [s].
_GLIDE = 0.6
#: A camera that is farther than this from all places it was sent to was moved by its user [m].
_MOVED = 0.03

#: Where a camera is, and what it looks at [m].
Aim = tuple[Vec3, Vec3]


class _Following:
    """A client whose camera goes along with a view."""

    def __init__(self, client: viser.ClientHandle, view: str, shown: Shown) -> None:
        self.client, self.view = client, view
        self.course = course(shown)  # [rad], the overview's
        self.aim: Aim | None = None  # where it was last sent
        self.sent: deque[Vec3] = deque([_eye(client)], maxlen=250)

    def send(self, aim: Aim, share: float = 1.0) -> None:
        """Bring the camera a share of the way to an aim."""
        old = self.aim
        if old is not None and share < 1.0:
            aim = (_between(old[0], aim[0], share), _between(old[1], aim[1], share))
            if math.dist(old[0], aim[0]) + math.dist(old[1], aim[1]) < 1e-3:
                return
        self.aim = aim
        self.sent.append(aim[0])
        position, look_at = aim
        with self.client.atomic():
            self.client.camera.up_direction = (0.0, 0.0, 1.0)
            self.client.camera.position = position
            self.client.camera.look_at = look_at


class Cameras:
    """Moves each client's camera as its user chose, until the user moves it.

    Args:
        server: the server.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._following: dict[int, _Following] = {}  # by the clients' numbers
        self._server.initial_camera.up = (0.0, 0.0, 1.0)
        self._server.initial_camera.fov = FOV

        @server.on_client_disconnect
        def _(client: viser.ClientHandle) -> None:
            self._following.pop(client.client_id, None)

    def start(self, session: Session) -> None:
        """Let new clients begin with the overview."""
        shown = session.shown()
        position, look_at = overview([shown], course(shown))
        self._server.initial_camera.position = position
        self._server.initial_camera.look_at = look_at

        @self._server.on_client_connect
        def _(client: viser.ClientHandle) -> None:
            session.post(lambda: self.choose(client, VIEWS[0], session))

            @client.camera.on_update
            def _(camera: viser.CameraHandle) -> None:
                eye = _eye(camera.client)
                session.post(lambda: self._let_go(client, eye))

    def choose(self, client: viser.ClientHandle, view: str, session: Session) -> None:
        """Bring a client to one of `VIEWS`, and take it along with the bodies."""
        self._following[client.client_id] = _Following(client, view, session.shown())

    def _let_go(self, client: viser.ClientHandle, eye: Vec3) -> None:
        """Leave a camera to its user who has moved it away from where it was sent."""
        following = self._following.get(client.client_id)
        if following and all(math.dist(eye, sent) > _MOVED for sent in following.sent):
            del self._following[client.client_id]

    def follow(self, session: Session, passed: float) -> None:
        """Take the clients' cameras along with the bodies.

        Args:
            session: what they see.
            passed: real time since they were last taken along [s].
        """
        share = -math.expm1(-passed / _GLIDE)
        if not self._following:
            return
        shown = session.shown()
        _, face, (w, x, y, z) = session.stage.form.draw(shown.robot)
        for following in list(self._following.values()):
            camera = following.client.camera
            size = camera.image_width, camera.image_height
            if following.view == VIEWS[0]:
                following.send(overview([shown], following.course, size), share)
            elif following.view == VIEWS[1]:
                following.send(from_above([shown], size), share)
            elif following.view == VIEWS[2]:
                following.send(_looking_out(face, (x, y, z, w), 0.16, size))
            elif shown.person is not None:
                px, py, pz, qx, qy, qz, qw = shown.person[:7].astype(float).tolist()
                if not math.isnan(pz + qw):
                    following.send(_looking_out((px, py, pz), (qx, qy, qz, qw), 0.12, size))


def course(shown: Shown) -> float:
    """Where the overview's camera looks along the ground [rad]: across the way between the two."""
    robot = shown.robot[:2].astype(float)
    person = robot if shown.person is None else shown.person[:2].astype(float)
    dx, dy = person - robot
    return math.atan2(dy, dx) + math.pi - _ACROSS


def overview(instants: Iterable[Shown], course: float, size: tuple[int, int] = SIZE) -> Aim:
    """From the side, with both bodies and the words over them in sight.

    Args:
        instants: at which they are in sight.
        course: where the camera looks along the ground [rad].
        size: of the picture, width and height [pixels].
    """
    _, top, bottom = _edges(size)
    # The bodies are looked down at by as much wherever in the picture they are.
    down = _DOWN + math.atan((top - bottom) / 2)
    level = math.cos(down)
    forward = np.array([level * math.cos(course), level * math.sin(course), -math.sin(down)])
    return _framed(_extent(instants), forward, size)


def from_above(instants: Iterable[Shown], size: tuple[int, int] = SIZE) -> Aim:
    """From above, with both bodies in sight; the world's x axis points up."""
    # Not quite straight down, where no direction would be up.
    return _framed(_extent(instants), np.array([1e-3, 0.0, -1.0]), size)


def _extent(instants: Iterable[Shown]) -> FloatArray:
    """Points around the bodies and the words over them, (N, 3) [m]."""
    points = []
    for shown in instants:
        x, y = shown.robot[:2].astype(float).tolist()
        tops = [(x, y, _ROBOT_TOP)]
        if shown.person is None:
            tops.append((x + 2.0, y, _ROBOT_TOP))
        else:
            x, y, z = shown.person[:3].astype(float).tolist()
            tops.append((x, y, 1.6 if math.isnan(z) else z))
        points += [
            (x + side * _ARMS, y + aside * _ARMS, height)
            for x, y, top in tops
            for height in (0.0, top + _WORDS)
            for side, aside in ((-1, 0), (1, 0), (0, -1), (0, 1))
        ]
    return np.array(points)


def _framed(points: FloatArray, forward: FloatArray, size: tuple[int, int]) -> Aim:
    """The camera that looks forward and has points in the middle of its picture, and all in sight.

    Each edge of the picture is a plane through the eye: seen along an axis, no point may lie
    farther out than so many times its depth. That is linear in the eye's place.

    Args:
        points: (N, 3) [m].
        forward: a unit vector, not straight up or down.
        size: of the picture, width and height [pixels].
    """
    side, top, bottom = _edges(size)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    x, y, z = points @ right, points @ up, points @ forward
    # From here on the right and upper edges, and the left and lower ones, ask for no more room.
    most_x, most_y = float((x - side * z).max()), float((y - top * z).max())
    least_x, least_y = float((x + side * z).min()), float((y + bottom * z).min())
    middle = float(z.min() + z.max()) / 2
    eye_z = min(
        (least_x - most_x) / (2 * side), (least_y - most_y) / (top + bottom), middle - _NEAREST
    )
    eye_x, eye_y = (most_x + least_x) / 2, (most_y + least_y + (top - bottom) * eye_z) / 2
    eye = eye_x * right + eye_y * up + eye_z * forward
    return _point(eye), _point(eye + (middle - eye_z) * forward)


def _edges(size: tuple[int, int]) -> tuple[float, float, float]:
    """How far the room for bodies reaches sideways, up and down, in depths of what is seen."""
    width, height = max(1, size[0]), max(1, size[1])
    rim_x, rim_top, rim_bottom = _RIM
    slope = math.tan(FOV / 2)
    lowest = 2 * _UPPER - 1 if width / height <= _NARROW else 1.0
    return (
        slope * width / height * max(0.3, 1 - 2 * rim_x / width),
        slope * (1 - 2 * rim_top / height),
        slope * (lowest - 2 * rim_bottom / height),
    )


def _point(place: FloatArray) -> Vec3:
    x, y, z = place.tolist()
    return x, y, z


def _between(a: Vec3, b: Vec3, share: float) -> Vec3:
    return (
        a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])
    )  # fmt: skip


def _eye(client: viser.ClientHandle) -> Vec3:
    return _point(client.camera.position)


def _looking_out(
    face: Vec3, turn: tuple[float, float, float, float], ahead: float, size: tuple[int, int]
) -> Aim:
    """Out of a face, from a little before it so that it is not in the way."""
    x, y, z, w = turn
    forward = (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y))
    eye = (
        face[0] + ahead * forward[0], face[1] + ahead * forward[1], face[2] + ahead * forward[2]
    )  # fmt: skip
    _, top, bottom = _edges(size)
    # What the face looks at is in the middle of the room that panels leave.
    lower = forward[2] - (top - bottom) / 2
    return eye, (eye[0] + 2 * forward[0], eye[1] + 2 * forward[1], eye[2] + 2 * lower)


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

"""The page itself: a viser server that draws a session and hands it what the user wants."""

from __future__ import annotations

import socket
import time
import webbrowser
from collections.abc import Callable

import viser

from kendon.errors import ParameterError
from kendon.viewer.browser.cameras import Cameras, floor_point
from kendon.viewer.browser.controls import Controls
from kendon.viewer.browser.player import Player
from kendon.viewer.browser.scene import Scene
from kendon.viewer.browser.serving import start_server, stop_server
from kendon.viewer.browser.session import Session

#: Where the page is found unless asked otherwise.
HOST, PORT = "127.0.0.1", 8080
#: How often the scene is drawn, and the panels [1/s].
_FRAMES, _PANELS = 25.0, 5.0


class Page:
    """A page that shows a session for as long as its `run` runs.

    Args:
        session: what it shows.
        save: makes the replay of the session, as the text of a page.
        host: the address it listens on; 0.0.0.0 for every one of this machine's.
        port: likewise; 0 for any that is free.

    Raises:
        ParameterError: nothing can listen there.
    """

    def __init__(
        self, session: Session, save: Callable[[], str], host: str = HOST, port: int = PORT
    ) -> None:
        check_address(host, port)
        self.session = session
        self._server = start_server(host, port)
        self._server.gui.configure_theme(
            dark_mode=False, show_logo=False, show_share_button=False, control_width="medium"
        )
        self._scene = Scene(self._server, handle=session.player is not None)
        self._cameras = Cameras(self._server)
        self._cameras.start(session)
        self._controls = Controls(self._server, session, save, self._cameras)
        self._take_places()

    @property
    def address(self) -> str:
        """Where a browser on this machine finds the page."""
        host = self._server.get_host()
        shown = "localhost" if host in ("0.0.0.0", "127.0.0.1", "::") else host
        return f"http://{shown}:{self._server.get_port()}"

    @property
    def watched(self) -> bool:
        """Whether a browser shows the page."""
        return bool(self._server.get_clients())

    def open(self) -> None:
        """Show the page in the user's browser, where there is one."""
        webbrowser.open(self.address)

    def run(self, until: Callable[[], bool] = lambda: False) -> None:
        """Let the session run and draw it, until told or interrupted.

        Time stands still until the first browser shows the page, so that nobody misses the start.

        Raises:
            DataError: there is something wrong with what the source reads.
        """
        before = time.monotonic()
        panels_at = -1.0
        started = False
        while not until():
            now = time.monotonic()
            passed, before = min(now - before, 0.5), now
            started = started or self.watched or self.session.stage.live
            self.session.step(passed if started else 0.0)
            self._draw()
            self._cameras.follow(self.session, passed)
            if now - panels_at >= 1 / _PANELS:
                panels_at = now
                self._controls.draw()
            time.sleep(max(0.0, 1 / _FRAMES - (time.monotonic() - now)))

    def close(self) -> None:
        """Take the page down."""
        stop_server(self._server)
        self.session.stage.close()

    def _draw(self) -> None:
        session = self.session
        self._scene.draw(session.stage, session.shown(), session.place)
        if session.player is not None:
            self._scene.point_out(session.player.goal)

    def _take_places(self) -> None:
        """Send the person where the ring is dragged or the floor is clicked."""
        disc = self._scene.disc
        if disc is None:
            return

        @disc.on_drag
        async def _(event: viser.SceneNodeDragEvent[viser.MeshHandle]) -> None:
            x, y, z = event.client.camera.position.tolist()
            self.send_to(floor_point((x, y, z), event.end_position))

        @self._server.scene.on_click()
        def _(event: viser.SceneClickEvent) -> None:
            (x, y, z), (dx, dy, dz) = event.ray_origin, event.ray_direction
            self.send_to(floor_point((x, y, z), (x + dx, y + dy, z + dz)))

    def send_to(self, place: tuple[float, float] | None) -> None:
        """Have the user's person walk to a place on the floor."""
        if place is None:
            return

        def walk(player: Player | None) -> None:
            if player is not None:
                player.walk_to(*place)

        self.session.post(lambda: walk(self.session.player))


def check_address(host: str, port: int) -> None:
    """Make sure that a server can listen somewhere.

    Raises:
        ParameterError: it cannot.
    """
    if not 0 <= port <= 65535:
        raise ParameterError(f"--port lies between 0 and 65535, not {port}")
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        with socket.socket(family, socket.SOCK_STREAM) as trial:
            # As servers do, so that a port that was in use a moment ago is free.
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            trial.bind((host, port))
    except socket.gaierror:
        raise ParameterError(f"--host {host} is no address of this machine") from None
    except OSError as error:
        raise ParameterError(
            f"port {port} of {host} cannot be listened on ({error.strerror}); name another with"
            " --port, or 0 for any that is free"
        ) from None

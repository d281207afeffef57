"""viser servers, started and stopped without a word."""

from __future__ import annotations

import contextlib
import io
import warnings
from collections.abc import Iterator

import viser


def start_server(host: str, port: int) -> viser.ViserServer:
    """A server of that address; 0 is any port that is free."""
    # A browser that is being closed counts as a client for a moment longer.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    with _silence():
        return viser.ViserServer(host=host, port=port, label="kendon", verbose=False)


def stop_server(server: viser.ViserServer) -> None:
    """Take a server down."""
    with _silence():
        server.stop()


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Viser tells its address on the standard output, which is the results' place."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield

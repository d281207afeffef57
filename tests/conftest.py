"""What holds for every test: no window, no network, and in CI the same examples each time."""

from __future__ import annotations

import ipaddress
import os
import socket
from typing import Any

import pytest
from command_line import Kendon
from hypothesis import settings

# Before anything imports matplotlib, which reads it once; inherited by child processes.
os.environ["MPLBACKEND"] = "Agg"

# A deadline measures how busy the machine is rather than whether the code is right.
settings.register_profile("local", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


@pytest.fixture
def kendon(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Kendon:
    return Kendon(capsys, monkeypatch)


def pytest_configure(config: pytest.Config) -> None:
    """Let sockets reach this machine only, from collection to the end."""
    patch = pytest.MonkeyPatch()
    config.add_cleanup(patch.undo)
    for method in ("connect", "connect_ex"):
        patch.setattr(socket.socket, method, _guarded(getattr(socket.socket, method)))
    patch.setattr(socket, "getaddrinfo", _guarded_lookup(socket.getaddrinfo))


def _guarded(connect: Any) -> Any:
    def guarded(self: socket.socket, address: Any) -> Any:
        # Other families, such as AF_UNIX, do not leave the machine.
        if self.family in (socket.AF_INET, socket.AF_INET6):
            _require_local(address[0])
        return connect(self, address)

    return guarded


def _guarded_lookup(lookup: Any) -> Any:
    def guarded(host: Any, *args: Any, **kwargs: Any) -> Any:
        _require_local(host)
        return lookup(host, *args, **kwargs)

    return guarded


def _require_local(host: str | bytes | None) -> None:
    name = host.decode() if isinstance(host, bytes) else host
    if not name or name in ("localhost", socket.gethostname()):
        return
    try:
        address = ipaddress.ip_address(name)
    except ValueError:
        local = False
    else:
        local = address.is_loopback or address.is_unspecified
    if not local:
        # Not an OSError, so that code which copes with a missing network does not hide it.
        raise RuntimeError(f"a test tried to reach {name}; tests use only what is on this machine")

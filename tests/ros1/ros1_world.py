"""A ROS 1 master on a port of its own, and processes that are nodes of it."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any
from xmlrpc.client import ServerProxy

import pytest

from kendon.ros.ros1 import environment
from kendon.ros.ros1.connection import start_node
from kendon.ros.ros1.environment import RosMissingError, ros_module

HERE = Path(__file__).parent
SOURCE = HERE.parents[1] / "src"
#: How long anything may take to come about [s].
PATIENCE = 60.0


def wait_for(condition: Callable[[], Any], what: str, seconds: float = PATIENCE) -> Any:
    """Wait until something holds; fail if it never does."""
    deadline = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < deadline, f"{what} has not come about within {seconds} s"
        time.sleep(0.01)
    return value


class Master:
    """A master in a process, which can be killed and started again on the same port."""

    def __init__(self, logs: Path) -> None:
        with socket.create_server(("127.0.0.1", 0)) as server:
            self.port = server.getsockname()[1]
        self.uri = f"http://127.0.0.1:{self.port}"
        self.environment = {
            "ROS_MASTER_URI": self.uri, "ROS_IP": "127.0.0.1", "ROS_LOG_DIR": str(logs),
        }  # fmt: skip
        self.process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        code = (
            "from kendon.ros.ros1.environment import ros_module; import sys;"
            f" ros_module('rosmaster').rosmaster_main(['--core', '-p', '{self.port}'])"
        )
        self.process = subprocess.Popen(
            [sys.executable, "-c", code], env=self.child_environment(),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        wait_for(self.answers, "the master")

    def stop(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process = None

    def answers(self) -> bool:
        try:
            socket.create_connection(("127.0.0.1", self.port), 1).close()
        except OSError:
            return False
        return True

    def child_environment(self) -> dict[str, str]:
        path = os.pathsep.join(filter(None, [str(SOURCE), os.environ.get("PYTHONPATH", "")]))
        return {**os.environ, **self.environment, "PYTHONPATH": path}

    @contextmanager
    def running(self, *command: str) -> Iterator[subprocess.Popen[str]]:
        """A Python process that is a node of this master; killed at the end."""
        process = subprocess.Popen(
            [sys.executable, *command], env=self.child_environment(), text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            yield process
        finally:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                close(pipe)

    @contextmanager
    def servers(self, behaviour: str = "obey", *parts: str) -> Iterator[subprocess.Popen[str]]:
        """Servers like Vizzy's, all or some."""
        with self.running(str(HERE / "vizzy_servers.py"), behaviour, *parts) as process:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert line.startswith("ready"), line + process.stdout.read()
            yield process


def tells(node: str, topic: str) -> bool:
    """Whether a node, by its own account, is connected with this process to tell it a topic.

    A subscriber counts a connection before the publisher has taken it in; what is published in
    between never comes.
    """
    try:
        uri = ros_module("rosgraph").Master("/kendon_tests").lookupNode(node)
        links: Any = ServerProxy(uri).getBusInfo("/kendon_tests")  # code, message, links
    except (OSError, ros_module("rosgraph").MasterException):
        return False
    own = ros_module("rospy").get_name()
    return any(link[1:3] == [own, "o"] and link[4] == topic for link in links[2])


def close(pipe: IO[str] | None) -> None:
    if pipe is not None:
        pipe.close()


def require_ros1() -> None:
    """Skip where ROS 1 is not installed, with what to do."""
    try:
        environment.require_ros1()
    except RosMissingError as error:
        pytest.skip(str(error))


def make_this_process_a_node(master: Master) -> None:
    """Once a process; later calls do nothing."""
    os.environ.update(master.environment)
    if not ros_module("rospy").core.is_initialized():
        start_node("kendon_tests")

"""One ROS 1 master for all tests of ROS 1: a process can be a node of one master only."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from pathlib import Path

import pytest
from ros.ros1_world import Master, make_this_process_a_node, require_ros1


@pytest.fixture(scope="session")
def master(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Master]:
    require_ros1()
    master = Master(tmp_path_factory.mktemp("roslogs"))
    master.start()
    try:
        make_this_process_a_node(master)
        yield master
    finally:
        master.stop()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """ROS 1 leaves the sockets that it has done with to the garbage collector."""
    for item in items:
        if Path(item.path).parent == Path(__file__).parent:
            item.add_marker(pytest.mark.filterwarnings("ignore:unclosed:ResourceWarning"))


@pytest.fixture(autouse=True)
def collected() -> Iterator[None]:
    """Let nothing of that be found in a test of something else."""
    yield
    gc.collect()

"""Everything around the node dies and comes back; the node goes on."""

from __future__ import annotations

import json
import subprocess
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from ros1.ros1_world import HERE, Master, require_ros1, wait_for

CLI = "from kendon.cli import main; main()"


class Other:
    """A process beside the node, and what it has told in JSON since it was started."""

    def __init__(self, master: Master, stack: ExitStack, *command: str) -> None:
        self._master, self._stack, self._command = master, stack, command
        self.start()

    def start(self) -> None:
        self.told: list[dict[str, Any]] = []
        self._process = self._stack.enter_context(self._master.running(*self._command))
        threading.Thread(target=self._read, args=(self._process, self.told), daemon=True).start()

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()

    def waits_for(self, what: str) -> None:
        """Wait until it has told that it heard of the node."""
        wait_for(lambda: any(any(line.values()) for line in self.told), what, 60)

    @staticmethod
    def _read(process: subprocess.Popen[str], told: list[dict[str, Any]]) -> None:
        for line in process.stdout or ():
            if line.startswith("{"):
                told.append(json.loads(line))


@pytest.fixture
def own(tmp_path: Path) -> Iterator[Master]:
    require_ros1()
    master = Master(tmp_path)
    master.start()
    yield master
    master.stop()


def test_all_but_the_node_may_die_and_come_back(own: Master) -> None:
    with ExitStack() as stack:
        base, rest, peer = (
            Other(own, stack, str(HERE / "vizzy_servers.py"), "rooted", "move_base"),
            Other(
                own, stack, str(HERE / "vizzy_servers.py"), "rooted", "gaze", "gcloud_tts", "arms"
            ),
            Other(own, stack, str(HERE / "faces_peer.py"), "1", "0.5"),
        )
        node = stack.enter_context(own.running("-c", CLI, "ros1", "--quiet"))
        for other, what in ((peer, "beliefs"), (base, "a drive"), (rest, "looks and words")):
            other.waits_for(what)
        own.stop()
        for other in (base, rest, peer):
            other.kill()
        own.start()
        for other in (base, rest, peer):
            other.start()
        for other, what in ((base, "a drive"), (rest, "looks and words"), (peer, "beliefs")):
            other.waits_for(f"{what} after the end and a new beginning")
        assert node.poll() is None


def test_people_of_ros4hri_are_heard_though_the_master_goes_and_comes(own: Master) -> None:
    pytest.importorskip("rosbags")
    with ExitStack() as stack:
        people = Other(own, stack, str(HERE / "human_topics.py"), "0.5")
        command = ("ros1", "--part", "reading", "--input", "humans", "--quiet")
        node = stack.enter_context(own.running("-c", CLI, *command))
        people.waits_for("smiles")
        own.stop()
        own.start()
        assert node.stdout is not None
        while "is registered with a new master" not in (line := node.stdout.readline()):
            assert line
        # The new master knows nothing of who has told until now, but they are still connected.
        before = len(people.told)
        # What was under way until then is no more than three.
        wait_for(lambda: sum(line["smiles"] for line in people.told[before:]) > 12, "smiles")
        people.kill()
        people.start()
        people.waits_for("smiles after the end and a new beginning")
        assert node.poll() is None

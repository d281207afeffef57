"""kendon over ROS 1 for long, and when everything around it dies and comes back.

    python benchmarks/ros_endurance.py [--minutes 30] [--people 10]

People greet without an end, 30 faces a second each. Told are every minute the memory and the
threads of kendon's node, and how long after the faces its beliefs come. Then the master, each of
the robot's servers and the sender of the faces are killed and started again, and it is told how
long it took until kendon, which goes on running, was heard of there again.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from ros1.ros1_world import Master, wait_for

TESTS = Path(__file__).parents[1] / "tests"
NODE = "from kendon.cli import main; main()"
PARTS = ("move_base", "gaze", "gcloud_tts", "arms")


class Process:
    """A process that can be killed and started again, and the lines of JSON that it prints."""

    def __init__(self, master: Master, stack: ExitStack, *command: str) -> None:
        self.command = command
        self._master, self._stack = master, stack
        self.start()

    def start(self) -> None:
        """Start it; what the last one printed is forgotten."""
        self.lines: list[dict[str, Any]] = []
        running = self._master.running(*self.command)
        self.process = self._stack.enter_context(running)
        threading.Thread(target=self._read, args=(self.process, self.lines), daemon=True).start()

    def kill(self) -> None:
        """Kill it, without a word to anybody."""
        self.process.kill()
        self.process.wait()

    @staticmethod
    def _read(process: subprocess.Popen[str], lines: list[dict[str, Any]]) -> None:
        for line in process.stdout or ():
            if line.startswith("{"):
                lines.append(json.loads(line))


def main(minutes: float, people: int) -> None:
    with tempfile.TemporaryDirectory() as logs, ExitStack() as stack:
        master = Master(Path(logs))
        master.start()
        stack.callback(master.stop)
        servers = {
            part: Process(master, stack, str(TESTS / "ros1" / "vizzy_servers.py"), "rooted", part)
            for part in PARTS
        }
        kendon = Process(master, stack, "-c", NODE, "ros1")
        peer = Process(
            master, stack, str(TESTS / "ros1" / "faces_peer.py"), str(people),
            str(60.0 if minutes >= 1 else 5.0),
        )  # fmt: skip
        print("minute  memory  threads  beliefs  after the face: median  95 %  longest", flush=True)
        for number in range(1, max(1, round(minutes)) + 1):
            line = told_by(peer, number, kendon)
            print(
                f"{number:>6}  {of(kendon, 'VmRSS') / 1024:5.1f} M  {of(kendon, 'Threads'):>7}"
                f"  {line['beliefs']:>7}  {line.get('median', 0) * 1e3:18.1f} ms"
                f"  {line.get('most', 0) * 1e3:.0f} ms  {line.get('longest', 0) * 1e3:.0f} ms",
                flush=True,
            )
        recover(master, servers, peer, kendon)
        print(f"memory at the end: {of(kendon, 'VmRSS') / 1024:.1f} M")


def told_by(peer: Process, number: int, kendon: Process) -> dict[str, Any]:
    """The peer's line of a minute."""
    wait_for(lambda: len(peer.lines) >= number, "a line of the peer", 120)
    assert kendon.process.poll() is None, "the node has ended"
    return peer.lines[number - 1]


def recover(master: Master, servers: dict[str, Process], peer: Process, kendon: Process) -> None:
    """Kill all but kendon, one by one, and see it come back."""
    master.stop()
    master.start()
    print("the master was killed and started again")
    for part, server in servers.items():
        server.kill()
        again(f"the server of {part}", server, lambda server=server: server.lines)  # type: ignore[misc]
    peer.kill()
    peer.command = (*peer.command[:-1], "1.0")  # a line a second now
    again("the sender of faces", peer, lambda: any(line["beliefs"] for line in peer.lines))
    assert kendon.process.poll() is None, "the node has ended"


def again(what: str, process: Process, works: Callable[[], Any]) -> None:
    """Start a process again, and tell when kendon was heard of there."""
    began = time.monotonic()
    process.start()
    wait_for(works, f"{what} has heard of kendon", 120)
    print(f"{what} was killed and started again: {time.monotonic() - began:.1f} s", flush=True)


def of(process: Process, name: str) -> int:
    """A figure of a process, by Linux."""
    status = Path(f"/proc/{process.process.pid}/status").read_text(encoding="utf-8")
    (line,) = (line for line in status.splitlines() if line.startswith(f"{name}:"))
    return int(line.split()[1])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--people", type=int, default=10)
    arguments = parser.parse_args()
    main(arguments.minutes, arguments.people)

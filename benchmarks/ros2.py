"""ROS4HRI bags played over DDS in real time, against the same bags read from their files.

    PYTHONPATH=src:tests python benchmarks/ros2.py BAG...

Each bag is played by a process of its own to `kendon ros2`, on a private domain of this machine.
Printed are the greatest difference between the beliefs told and those read from the file, how many
transforms and frames were lost, and how long after the frame that ends an interval its belief is
told: from receipt to receipt, in a third process.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from ros2_peers import LOOPBACK, free_domain, peer, until

from kendon.estimate import estimate
from kendon.features import observe
from kendon.models import load_model
from kendon.ros.dds import DdsNode
from kendon.ros.ros2_transport import Offer
from kendon.ros.ros2_types import TRANSFORMS
from kendon.sources.bags import read_bag_people
from kendon.sources.ros_bags import read_messages

_NANO = 10**9


class Witness:
    """Hears the transforms and the beliefs, and when."""

    def __init__(self, node: DdsNode) -> None:
        self.node = node
        self.heads: dict[int, int] = {}  # stamp of a face -> when it came [ns]
        self.beliefs: dict[str, list[tuple[int, int, Any]]] = {}  # name -> stamp, when, message

    def follow(self) -> None:
        """Read what has come to be published."""
        for topic, offers in self.node.offers().items():
            if topic == "/tf" and not self.heads:
                self.heads[0] = 0
                self.node.subscribe(topic, Offer(TRANSFORMS, True, False), self._take_tf)
            elif topic.endswith("/belief") and topic not in self.beliefs:
                told = self.beliefs[topic] = []

                def take(raw: bytes, message: Any, sent: int, told: Any = told) -> None:
                    told.append((_ns(message.header.stamp), time.time_ns(), message))

                (offer,) = offers  # kendon alone tells it
                self.node.subscribe(topic, offer, take)

    def _take_tf(self, raw: bytes, message: Any, sent: int) -> None:
        now = time.time_ns()
        for one in message.transforms:
            if one.child_frame_id.startswith("gaze_"):  # with it a frame is complete
                self.heads[_ns(one.header.stamp)] = now

    def latencies(self) -> list[float]:
        """From the frame after an interval's end to the belief about it [s]."""
        stamps = np.array(sorted(self.heads))
        found = []
        for told in self.beliefs.values():
            for stamp, when, _ in told:
                after = int(np.searchsorted(stamps, stamp + 1_000_000, side="right"))
                if after < len(stamps):
                    found.append((when - self.heads[int(stamps[after])]) / _NANO)
        return found


def _ns(stamp: Any) -> int:
    return int(stamp.sec) * _NANO + int(stamp.nanosec)


def play(bag: Path, domain: int) -> str:
    """One line about one bag."""
    model = load_model()
    tracks = read_bag_people(bag)
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "heard.mcap"
        node = DdsNode(domain)
        witness = Witness(node)
        command = "from kendon.cli import main; main()"
        options = ["ros2", "--domain", str(domain), "--record", str(recording)]
        quiet = subprocess.DEVNULL
        running = subprocess.Popen(
            [sys.executable, "-c", command, *options], stdout=quiet, stderr=quiet
        )
        until(node, lambda: "/state" in node.offers())
        with peer("play", str(domain), str(bag), "1") as player:
            assert player.stdout is not None
            while not select.select([player.stdout], [], [], 0)[0]:
                witness.follow()
                node.spin(0.02)
            end = time.monotonic() + 1
            while time.monotonic() < end:
                node.spin(0.02)
        running.send_signal(signal.SIGINT)
        running.wait()
        node.close()
        sent = sum(1 for m in read_messages(bag, lambda t: t == "/tf") if m.message)
        heard = sum(1 for m in read_messages(recording, lambda t: t == "/tf") if m.message)
        worst, count = 0.0, 0
        for track in tracks:
            name = track.name.removeprefix(f"{bag.stem}_")
            expected = estimate(observe(track), model).probabilities
            topic = f"/kendon/{name}/belief"
            told = read_messages(recording, topic.__eq__)
            rows = np.array([belief.message.probabilities for belief in told])
            # The last interval ends with the file there, and with the next frame here.
            n = min(len(rows), len(expected)) - 1
            worst = max(worst, float(np.abs(rows[:n] - expected[:n]).max()))
            count += n
    # The first second of beliefs comes at once, when the robot's frames are known.
    late = np.array(witness.latencies()[10:])
    return (
        f"{bag.name:16} {len(tracks)} people  {count:4} beliefs  greatest difference {worst:.1e}"
        f"  lost {sent - heard} of {sent} transforms"
        f"  latency {1000 * np.median(late):.1f} ms median, {1000 * np.quantile(late, 0.95):.1f} ms"
        " for 95 %"
    )


if __name__ == "__main__":
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    for number, name in enumerate(sys.argv[1:]):
        print(play(Path(name), (free_domain() + number) % 230), flush=True)

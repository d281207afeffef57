"""People on /faces without an end, and what is told of them: faces_peer.py [PEOPLE [SECONDS]]

So many people greet, 30 faces a second each, go away, and come again as somebody else. After each
so many seconds a line of JSON tells how many beliefs came, and how long after the faces that ended
their intervals.
"""

from __future__ import annotations

import bisect
import copy
import json
import sys
import time
from collections import deque
from itertools import count
from typing import Any

from kendon.features.sampler import TOLERANCE
from kendon.geometry import ORIGIN
from kendon.person import PersonFrame
from kendon.ros.ros1.connection import start_node
from kendon.ros.ros1.environment import messages, ros_module
from kendon.simulation import SCRIPTS, SimulatedPerson, script
from kendon.sources.ros_faces import fill_face

RATE = 30
#: How long people are away [s]: longer than they are remembered.
AWAY = 6.0


class Delays:
    """The beliefs, and how long after the faces they came."""

    def __init__(self) -> None:
        self.sent: deque[tuple[float, float]] = deque(maxlen=20 * RATE)  # stamp, when [s]
        self.heard: list[float] = []  # [s]

    def take(self, belief: Any) -> None:
        now = time.monotonic()
        sent = list(self.sent)
        place = bisect.bisect_right(sent, (belief.header.stamp.to_sec() + TOLERANCE, 0.0))
        if place < len(sent):  # else nobody was there any more
            self.heard.append(now - sent[place][1])

    def tell(self) -> None:
        """Print what came since the last time."""
        delays, self.heard = sorted(self.heard), []
        figures: dict[str, float] = {"beliefs": len(delays)}
        if delays:
            shares = {"median": 0.5, "most": 0.95, "longest": 1.0}
            figures |= {
                name: round(delays[min(int(share * len(delays)), len(delays) - 1)], 4)
                for name, share in shares.items()
            }
        print(json.dumps(figures), flush=True)


def played(name: str, aside: float) -> list[Any]:
    """A greeting as messages without stamps, by somebody who stands a little aside [m]."""
    kind, point = messages("kendon_msgs").FaceExtraction, ros_module("geometry_msgs.msg").Point
    person = SimulatedPerson(script(name), rate=RATE)
    found = []
    while not person.finished:
        frame: PersonFrame = person.frame()
        message = fill_face(kind(), frame, point)
        message.header.frame_id = "base_footprint"
        for place in (message.face, *message.joints):
            place.y += aside
        found.append(message)
        person.step(ORIGIN)
    return found


def main(people: int, seconds: float) -> None:
    start_node("faces_peer")
    rospy, kendon = ros_module("rospy"), messages("kendon_msgs")
    delays = Delays()
    faces = rospy.Publisher("/faces", kendon.FaceExtraction, queue_size=1000, tcp_nodelay=True)
    rospy.Subscriber("/belief", kendon.Belief, delays.take, tcp_nodelay=True)
    names = list(SCRIPTS)
    plays = [played(names[i % len(names)], 0.7 * (i - people / 2)) for i in range(people)]
    begin = time.monotonic()
    next_told = begin + seconds
    for tick in count():
        time.sleep(max(0.0, begin + tick / RATE - time.monotonic()))
        stamp = rospy.Time.now()
        delays.sent.append((stamp.to_sec(), time.monotonic()))
        for number, play in enumerate(plays):
            whole = len(play) + round(AWAY * RATE)
            # Not all come at once.
            visit, step = divmod(tick + number * RATE, whole)
            if step < len(play):
                message = copy.copy(play[step])
                message.header.stamp = stamp
                message.face_id = f"{number}_{visit}"
                faces.publish(message)
        if time.monotonic() >= next_told:
            next_told += seconds
            delays.tell()


if __name__ == "__main__":
    arguments = [float(argument) for argument in sys.argv[1:]]
    main(int(arguments[0]) if arguments else 1, arguments[1] if len(arguments) > 1 else 1.0)

"""kendon over ROS 1, in three processes: faces, kendon's node, and servers like Vizzy's.

    python benchmarks/ros.py [N]

A simulated person greets N times (5 if not given), at their own pace. Told are how long after the
face message that ends an interval its belief comes, what was lost, and whether the phases are those
of one process.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from itertools import groupby
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from ros1.ros1_world import Master, make_this_process_a_node, wait_for

from kendon.geometry import Pose2D, wrap_angle
from kendon.greeter import FORGOTTEN, Encounter, Greeter
from kendon.person import PersonFrame
from kendon.ros.faces import fill_face
from kendon.ros.place import RobotPlace
from kendon.ros.ros1.environment import messages, ros_module
from kendon.ros.ros1.vizzy import follow_robot
from kendon.simulation import SCRIPTS, SimulatedPerson, script
from kendon.sources import open_source

NODE = "from kendon.cli import main; main()"


class Listener:
    """The beliefs as they come, and how long after the newest face they did."""

    def __init__(self) -> None:
        self.sent = 0.0
        self.delays: list[float] = []
        self.phases: list[int] = []
        self.playing = False

    def belief(self, message: Any) -> None:
        """Take in a belief."""
        if self.playing:
            self.delays.append(time.monotonic() - self.sent)
            self.phases.append(message.phase)


def main(count: int) -> None:
    with tempfile.TemporaryDirectory() as logs:
        master = Master(Path(logs))
        master.start()
        try:
            make_this_process_a_node(master)
            with master.servers("drive"), master.running("-c", NODE, "ros1", "--quiet") as node:
                measure(count)
                assert node.poll() is None, "the node has ended"
        finally:
            master.stop()


def measure(count: int) -> None:
    rospy, kendon = ros_module("rospy"), messages("kendon_msgs")
    point = ros_module("geometry_msgs.msg").Point
    listener = Listener()
    faces = rospy.Publisher("/faces", kendon.FaceExtraction, queue_size=50, tcp_nodelay=True)
    end = rospy.Subscriber("/belief", kendon.Belief, listener.belief, tcp_nodelay=True)
    wait_for(lambda: faces.get_num_connections() and end.get_num_connections(), "the node", 60)
    place = RobotPlace()
    follow_robot(place)
    wait_for(lambda: place.known, "the robot's pose")
    names = list(SCRIPTS)
    same = expected_count = got_count = 0
    for number in range(count):
        name = names[number % len(names)]
        expected = in_one_process(name)
        listener.phases.clear()
        listener.playing = True
        person = SimulatedPerson(script(name))
        begin, start, home = time.monotonic(), rospy.get_time(), place.pose
        while not person.finished:
            time.sleep(max(0.0, begin + person.t - time.monotonic()))
            message = fill_face(kendon.FaceExtraction(), seen(person, place.pose, home), point)
            message.header.stamp = rospy.Time.from_sec(start + person.t)
            message.face_id = str(number)  # somebody else each time
            listener.sent = time.monotonic()
            faces.publish(message)
            person.step(in_frame_of(home, place.pose))
        listener.playing = False
        time.sleep(FORGOTTEN + 0.5)  # the greeting is over
        got = [phase for phase, _ in groupby(listener.phases)]
        wanted = [phase.value for phase in expected.phases]
        same += got == wanted
        expected_count += len(expected.observations)
        got_count += len(listener.phases)
        if got != wanted:
            print(f"{name} {number}: over ROS {got}, in one process {wanted}")
    delays = sorted(listener.delays)
    print(f"{count} encounters, {same} with the phases of one process")
    print(f"observations told: {got_count}, in one process: {expected_count}")
    print(
        f"belief after face: median {statistics.median(delays) * 1e3:.1f} ms,"
        f" 95 % below {delays[int(0.95 * len(delays))] * 1e3:.1f} ms"
    )


def in_frame_of(home: Pose2D, pose: Pose2D) -> Pose2D:
    """A pose of the world, as seen from where the robot stood when the person came."""
    x, y, _ = home.to_local((pose.x, pose.y, 0.0))
    return Pose2D(x, y, wrap_angle(pose.yaw - home.yaw))


def seen(person: SimulatedPerson, pose: Pose2D, home: Pose2D) -> PersonFrame:
    """The person as the robot sees them; they came to where it stood then."""
    return person.frame(in_frame_of(home, pose))


def in_one_process(name: str) -> Encounter:
    """The same person before the robot with ideal kinematics."""
    encounter = Encounter(name)
    for moment in Greeter(open_source(f"simulated:{name}")).run():
        encounter.add(moment)
    return encounter


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)

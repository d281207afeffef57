"""Takes docs/rviz.png: rviz on a screen that is none, while a simulated person greets.

    python scripts/rviz_picture.py [FILE [SECONDS]]

Needs Debian's rviz, xvfb and imagemagick. A master, servers like Vizzy's and kendon's node run as
in the tests; the picture is taken so long after the person has come.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from ros1.ros1_world import Master, make_this_process_a_node, wait_for

from kendon.geometry import yaw_quaternion
from kendon.ros.ros1.environment import messages, ros_module
from kendon.simulation import SimulatedPerson, script
from kendon.sources.ros_faces import fill_face
from kendon.sources.ros_place import RobotPlace

ROOT = Path(__file__).parents[1]
VIEW = ROOT / "ros" / "kendon_ros" / "rviz" / "kendon.rviz"
NODE = "from kendon.cli import main; main()"
SCREEN = ":97"


def main(picture: Path, seconds: float) -> None:
    """Run everything, and take the picture so long after the person has come [s]."""
    screen = subprocess.Popen(["Xvfb", SCREEN, "-screen", "0", "1200x800x24"])
    try:
        with tempfile.TemporaryDirectory() as logs:
            master = Master(Path(logs))
            master.start()
            try:
                make_this_process_a_node(master)
                with master.servers("ideal"), master.running("-c", NODE, "ros1", "--quiet"):
                    show(master, picture, seconds)
            finally:
                master.stop()
    finally:
        screen.terminate()


def show(master: Master, picture: Path, seconds: float) -> None:
    """Run rviz beside a greeting."""
    display = {
        **master.child_environment(), "DISPLAY": SCREEN, "LIBGL_ALWAYS_SOFTWARE": "1",
        "QT_X11_NO_MITSHM": "1",
    }  # fmt: skip
    display.pop("PYTHONPATH")
    rviz = subprocess.Popen(
        ["rviz", "-d", str(VIEW), "--fullscreen"], env=display, stdout=subprocess.DEVNULL
    )
    try:
        # rviz has subscribed when kendon's node tells it; it draws a little later.
        rosgraph = ros_module("rosgraph").Master("/picture")
        wait_for(
            lambda: any(
                topic == "/kendon_markers" for topic, _ in rosgraph.getSystemState()[1]
            ),
            "rviz", 60,
        )  # fmt: skip
        greet(picture, seconds, display)
    finally:
        rviz.terminate()
        rviz.wait()


def greet(picture: Path, seconds: float, display: dict[str, str]) -> None:
    """Let a person greet."""
    rospy, kendon = ros_module("rospy"), messages("kendon_msgs")
    point = ros_module("geometry_msgs.msg").Point
    place = RobotPlace()
    follow(place)
    faces = rospy.Publisher("/faces", kendon.FaceExtraction, queue_size=50, tcp_nodelay=True)
    wait_for(lambda: faces.get_num_connections() > 0, "the node", 60)
    for attempt in range(3):  # rviz's first seconds are slow in software
        person = SimulatedPerson(script("normal"))
        begin, taken = time.monotonic(), False
        home = place.pose
        while not person.finished:
            time.sleep(max(0.0, begin + person.t - time.monotonic()))
            x, y, _ = home.to_local((place.pose.x, place.pose.y, 0.0))
            here = place.pose._replace(x=x, y=y, yaw=place.pose.yaw - home.yaw)
            message = fill_face(kendon.FaceExtraction(), person.frame(here), point)
            message.header.stamp = rospy.Time.now()
            message.face_id = str(attempt)
            faces.publish(message)
            person.step(here)
            if attempt == 2 and person.t >= seconds and not taken:
                taken = True
                subprocess.Popen(
                    ["import", "-window", "root", "-colors", "64", str(picture)], env=display
                )
        time.sleep(6.0)  # until the person is forgotten


def follow(place: RobotPlace) -> None:
    """Keep up with where the servers say that the robot is, and tell rviz by TF."""
    rospy = ros_module("rospy")
    located = ros_module("geometry_msgs.msg").PoseWithCovarianceStamped
    transforms = ros_module("tf2_msgs.msg").TFMessage
    one = ros_module("geometry_msgs.msg").TransformStamped
    told = rospy.Publisher("/tf", transforms, queue_size=10)
    rospy.Subscriber("/amcl_pose", located, place.take_localised)

    def tell() -> None:
        while True:
            frame = one()
            frame.header.stamp = rospy.Time.now()
            frame.header.frame_id, frame.child_frame_id = "map", "base_footprint"
            move, turn = frame.transform.translation, frame.transform.rotation
            move.x, move.y = place.pose.x, place.pose.y
            _, _, turn.z, turn.w = yaw_quaternion(place.pose.yaw)
            told.publish(transforms([frame]))
            time.sleep(0.05)

    threading.Thread(target=tell, daemon=True).start()


if __name__ == "__main__":
    arguments: list[Any] = sys.argv[1:]
    main(
        Path(arguments[0]) if arguments else ROOT / "docs" / "rviz.png",
        float(arguments[1]) if len(arguments) > 1 else 5.0,
    )
    os._exit(0)  # threads of ROS tell of frames to the end

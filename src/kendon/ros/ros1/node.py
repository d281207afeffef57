"""kendon as a ROS 1 node: faces in, the state out, and the robot's answers (thesis figure 4.1)."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from kendon.errors import UnknownNameError
from kendon.person import PersonFrame
from kendon.robots.base import CommandKind, CommandStatus, Robot
from kendon.ros.parts import AnsweringPart, Told, make_part
from kendon.ros.place import RobotPlace
from kendon.ros.ros1.connection import MasterWatch, flush, require_type
from kendon.ros.ros1.environment import messages, ros_module
from kendon.ros.ros1.rviz import MarkerPublisher
from kendon.ros.ros1.vizzy import follow_robot
from kendon.ros.settings import Input, NodeSettings, Part, StateType
from kendon.ros.stream import PersonStream
from kendon.ros.telling import fill_belief, fill_observation, fill_state, phase_of_state

#: So many messages may wait; older ones are worth less than newer ones.
_WAITING = 100
#: How long to wait for a message until time goes on without it [s].
_PAUSE = 0.02
#: How long simulated time may stand still until the user is told [s].
_NO_CLOCK = 5.0

#: The topics people are told of on.
FACES, PEOPLE = "faces", "people"


class GreetingNode:
    """The node, in a process that `kendon.ros.ros1.connection.start_node` has made one.

    Args:
        robot: answers; told where it is by the same `place`.
        place: where the robot is.
        settings: what the user said.
        tell: called with each sentence for the user, when it is known.

    Raises:
        DataError: the input topic carries messages of another type.
        KendonError: the model or the tree of the settings cannot be read.
    """

    def __init__(
        self,
        robot: Robot,
        place: RobotPlace,
        settings: NodeSettings,
        tell: Callable[[str], None] = lambda sentence: None,
    ) -> None:
        self._rospy = rospy = ros_module("rospy")
        self._master = MasterWatch()
        self.robot = robot
        self.place = place
        self.settings = settings
        self.lost = 0  # messages that came faster than they could be taken in
        self._tell = tell
        self._told: set[str] = set()
        self._ending = False
        self._inbox: queue.Queue[tuple[str, Any, float]] = queue.Queue()
        self._kendon = messages("kendon_msgs")
        self._geometry = ros_module("geometry_msgs.msg")
        self._state_class = self._class_of_state()
        name = PEOPLE if settings.input is Input.PEOPLE else FACES
        self.stream = PersonStream(place, settings, rospy.resolve_name(name))
        self.part = make_part(self.stream, robot, settings)
        self._publish = self._publishers()
        self._subscribe(name)
        self._markers = MarkerPublisher(robot, place) if settings.markers else None
        self._started = time.monotonic()

    def run(self) -> Iterator[Told]:
        """What there is to tell, published, until `stop`; then the robot is stopped."""
        rospy = self._rospy
        try:
            while not (self._ending or rospy.is_shutdown()):
                try:
                    kind, message, now = self._inbox.get(timeout=_PAUSE)
                except queue.Empty:
                    yield from self._tell_all(self.part.idle(rospy.get_time()))
                    self._look_around()
                    continue
                yield from self._tell_all(self._take(kind, message, now))
                if self._inbox.empty():
                    self._look_around()
        finally:
            self.part.end()
            self._settle()

    def stop(self) -> None:
        """Let `run` end; may be called in a signal handler."""
        self._ending = True

    def _settle(self) -> None:
        """Wait until the robot has stopped, and all that was told has left."""
        stop = self.robot.running(CommandKind.STOP)
        while stop and stop.running:  # no longer than the robot's patience
            time.sleep(_PAUSE)
            self.robot.update(self.robot.time + _PAUSE)
        if stop and stop.status is CommandStatus.FAILED:
            self._tell(f"The robot has not said that it stopped: {stop.reason}.")
        if stuck := flush(self.settings.patience):
            self._tell(f"Nobody took the last messages of {', '.join(stuck)}.")

    def _take(self, kind: str, message: Any, now: float) -> Iterator[Told]:
        if kind == "state":
            assert isinstance(self.part, AnsweringPart)
            try:
                self.part.state(phase_of_state(message), now)
            except UnknownNameError as error:
                self._note(
                    f"A message of {self._rospy.resolve_name('state')} is left out: {error}."
                )
            return
        frame: PersonFrame | None = self.stream.take(message, now)
        if frame is not None:
            yield from self.part.frame(frame, now)

    def _tell_all(self, told: Iterable[Told]) -> Iterator[Told]:
        """Publish what there is to tell."""
        for one in told:
            moment = one.moment
            if moment.is_new and moment.observation and moment.belief:
                stamp = self._rospy.Time.from_sec(one.stamp)
                belief, observation = self._kendon.Belief(), self._kendon.Observation()
                for message in (belief, observation):
                    message.header.stamp = stamp
                    message.header.frame_id = self.place.bases[0]
                self._publish["belief"].publish(fill_belief(belief, moment.belief))
                self._publish["observation"].publish(
                    fill_observation(observation, moment.observation)
                )
                self._publish["state"].publish(fill_state(self._state_class(), moment.belief.phase))
            if self._markers is not None:
                self._markers.show(moment)
            yield one

    def _publishers(self) -> dict[str, Any]:
        if self.settings.part is Part.ANSWERING:
            return {}
        types = {
            "state": self._state_class,
            "belief": self._kendon.Belief,
            "observation": self._kendon.Observation,
        }
        publisher = self._rospy.Publisher
        return {name: publisher(name, kind, queue_size=10) for name, kind in types.items()}

    def _subscribe(self, name: str) -> None:
        settings = self.settings
        if settings.input is Input.PEOPLE:
            self._listen(name, self._geometry.PoseArray, "person")
        else:
            self._listen(name, self._kendon.FaceExtraction, "person")
        if settings.part is Part.ANSWERING:
            self._listen("state", self._state_class, "state")
        follow_robot(self.place)

    def _listen(self, name: str, kind: Any, what: str) -> None:
        """Put the messages of a topic into the inbox."""
        topic = self._rospy.resolve_name(name)
        others = ", ".join(choice.value for choice in Input)
        require_type(
            topic, kind._type, f"choose the input ({others}) or remap it ({name}:=/other/topic)"
        )

        def came(message: Any) -> None:
            if self._inbox.qsize() >= _WAITING:
                self.lost += 1
                return
            self._inbox.put((what, message, self._rospy.get_time()))

        self._rospy.Subscriber(name, kind, came, queue_size=_WAITING, tcp_nodelay=True)

    def _class_of_state(self) -> Any:
        standard = ros_module("std_msgs.msg")
        return standard.String if self.settings.state_type is StateType.STRING else standard.Int32

    def _look_around(self) -> None:
        """Tell what has become known meanwhile."""
        for sentence in self.stream.notes:
            self._note(sentence)
        if changed := self._master.check():
            self._tell(changed)  # each time anew
        if self.lost:
            self._note("Messages come faster than they can be taken in; some are left out.")
        if not self._rospy.get_time() and time.monotonic() - self._started > _NO_CLOCK:
            self._note("use_sim_time is set, but nothing tells the time on /clock: waiting for it.")

    def _note(self, sentence: str) -> None:
        if sentence not in self._told:
            self._told.add(sentence)
            self._tell(sentence)

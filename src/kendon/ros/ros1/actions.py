"""One action server of the robot, as a client that never waits sees it."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field
from typing import Any

from kendon.errors import RobotError
from kendon.ros.ros1.environment import ros_module

#: How long a server may be unheard of until it counts as gone [s]; actionlib's tell their status
#: five times a second.
_STATUS_HOLDS = 5.0


@dataclass(eq=False)
class Goal:
    """A goal that was sent: how it stands, as ROS's threads tell it."""

    asked: Any  # what was sent
    after_cancel: bool = False  # of all goals, on another topic: the server may hear of it later
    handle: Any = None
    id: str = ""
    heard: bool = False  # since it was last looked at
    over: bool = False
    status: int = 0  # of actionlib_msgs/GoalStatus, once it is over
    text: str = ""  # what the server says to that
    result: Any = None
    lock: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def take_heard(self) -> bool:
        """Whether there was a sign of life since this was last asked."""
        with self.lock:
            heard, self.heard = self.heard, False
        return heard

    def note_heard(self) -> None:
        """Note a sign of life."""
        with self.lock:
            self.heard = True


class ActionLink:
    """A client of one action.

    Args:
        name: of the action, as it is resolved (``move_base``).
        action: its class (``MoveBaseAction``).
    """

    def __init__(self, name: str, action: Any) -> None:
        self._rospy = rospy = ros_module("rospy")
        self.name: str = rospy.resolve_name(name)
        self._goals: dict[str, Goal] = {}  # by id, until they are over
        self._status_at: float | None = None  # [s], when the server last told its status
        self._client = ros_module("actionlib").ActionClient(name, action)
        actionlib_msgs = ros_module("actionlib_msgs.msg")
        self._done = ros_module("actionlib").CommState.DONE
        self._lost = actionlib_msgs.GoalStatus.LOST
        self._cancel_all = actionlib_msgs.GoalID
        statuses = actionlib_msgs.GoalStatus
        self._taken_off = (statuses.PREEMPTED, statuses.RECALLED)
        self._cancelled = False  # all goals, since the last one was sent
        rospy.Subscriber(
            f"{self.name}/status", actionlib_msgs.GoalStatusArray, self._take_status, queue_size=10
        )

    @property
    def connected(self) -> bool:
        """Whether a server takes goals and has told of itself lately."""
        return (
            self._client.pub_goal.get_num_connections() > 0
            and self._status_at is not None
            and self._now() - self._status_at <= _STATUS_HOLDS
        )

    def send(self, goal: Any) -> Goal:
        """Send a goal.

        Raises:
            RobotError: no server is there.
        """
        if not self.connected:
            raise RobotError(f"no action server answers at {self.name}")
        sent = Goal(goal, self._cancelled)
        self._cancelled = False
        sent.handle = self._client.send_goal(
            goal,
            transition_cb=lambda handle: self._moved_on(sent, handle),
            feedback_cb=lambda handle, feedback: sent.note_heard(),
        )
        sent.id = sent.handle.comm_state_machine.action_goal.goal_id.id
        self._goals[sent.id] = sent
        return sent

    def cancel(self, goal: Goal) -> None:
        """Ask the server to stop.

        Raises:
            RobotError: nobody hears it.
        """
        if goal.over:
            return
        goal.handle.cancel()
        if self._client.pub_cancel.get_num_connections() == 0:
            raise RobotError(f"nobody listens at {self.name}/cancel")

    def cancel_all(self) -> None:
        """Ask the server to stop whatever it does, for whomever."""
        self._client.pub_cancel.publish(self._cancel_all())
        self._cancelled = True

    def swept(self, goal: Goal) -> bool:
        """Whether a goal may have ended by the cancel of all goals that went out before it."""
        return goal.over and goal.after_cancel and goal.status in self._taken_off

    def _take_status(self, message: Any) -> None:
        self._status_at = self._now()
        for status in message.status_list:
            if goal := self._goals.get(status.goal_id.id):
                goal.note_heard()

    def _moved_on(self, goal: Goal, handle: Any) -> None:
        goal.note_heard()
        if handle.get_comm_state() != self._done:
            return
        goal.status = handle.get_terminal_state()
        goal.text = handle.get_goal_status_text() or ""
        goal.result = handle.get_result()
        goal.over = True
        self._goals.pop(goal.id, None)

    def _now(self) -> float:
        # By the wall: a robot that is silent is silent, however simulated time goes.
        return time.monotonic()

"""All nodes kendon has itself, entered into the registry.

Names and ports of the leaves are the thesis's and Vizzy's. Added by kendon: `patience` and
`frame_id` of GetPoseFromFace, `retreat` of GetApproachCoords, `fixation_point_error_tolerance` of
GazeAtTarget (a field of Vizzy's action goal), and the nodes Express and IsGreeting. Ports that name
ROS topics, actions and voices are read for Vizzy's sake and have no effect: a kendon robot knows
its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from py_trees.behaviour import Behaviour

from kendon.trees import commands, control, decorators, leaves
from kendon.trees.ports import BoundPorts, Port
from kendon.trees.registry import Category, NodeType, register_node
from kendon.trees.state import TreeState

_ROS = "Unused by kendon: the robot knows its own."
_FACE_IN = Port("closest_face", "input", "pose", doc="The person's face.")
_GOAL_OUT = Port("goal_pose", "output", "pose", doc="The base's goal, in map.")
_FRAME = Port("frame_id", "input", "frame", "", "The frame of a pose written out; map if left out.")


# ---- control nodes


def _control(name: str, make: Callable[[str, Sequence[Behaviour]], Behaviour]) -> None:
    def factory(
        label: str, ports: BoundPorts, state: TreeState, children: Sequence[Behaviour]
    ) -> Behaviour:
        return make(label, children)

    doc = (make.__doc__ or "").split("\n")[0]
    register_node(NodeType(name, "Control", factory, (), doc, (1, None), True))


for _class in (
    control.Sequence,
    control.SequenceWithMemory,
    control.ReactiveSequence,
    control.Fallback,
    control.ReactiveFallback,
):
    _control(_class.__name__, _class)

register_node(
    NodeType(
        "Parallel",
        "Control",
        lambda name, ports, state, children: control.Parallel(
            name, children, ports.input("success_count"), ports.input("failure_count")
        ),
        (
            Port("success_count", "input", "int", "-1", "So many successes are SUCCESS."),
            Port("failure_count", "input", "int", "1", "So many failures are FAILURE."),
        ),
        "Ticks all children; table 2.2's M is success_count.",
        (1, None),
        True,
    )
)


def _switch(cases: int) -> None:
    names = [f"case_{i}" for i in range(1, cases + 1)]
    register_node(
        NodeType(
            f"Switch{cases}",
            "Control",
            lambda label, ports, state, children: control.Switch(
                label, children, ports.input("variable"), [ports.input(n) for n in names]
            ),
            (
                Port("variable", "input", "any", doc="What is compared with the cases."),
                *(Port(n, "input", "any", doc="Chooses the child in this place.") for n in names),
            ),
            "Ticks the child whose case equals the variable, else the last.",
            (cases + 1, cases + 1),
            True,
        )
    )


for _cases in range(2, 7):
    _switch(_cases)


# ---- decorators


def _decorator(
    name: str,
    make: Callable[[str, Behaviour, BoundPorts, TreeState], Behaviour],
    doc: str,
    *ports: Port,
) -> None:
    def factory(
        label: str, bound: BoundPorts, state: TreeState, children: Sequence[Behaviour]
    ) -> Behaviour:
        return make(label, children[0], bound, state)

    register_node(NodeType(name, "Decorator", factory, ports, doc, (1, 1), True))


_decorator(
    "Inverter",
    lambda name, child, ports, state: decorators.Inverter(name, child),
    "SUCCESS becomes FAILURE and the other way round.",
)
_decorator(
    "ForceSuccess",
    lambda name, child, ports, state: decorators.ForceSuccess(name, child),
    "FAILURE becomes SUCCESS.",
)
_decorator(
    "ForceFailure",
    lambda name, child, ports, state: decorators.ForceFailure(name, child),
    "SUCCESS becomes FAILURE.",
)
_decorator(
    "KeepRunningUntilFailure",
    lambda name, child, ports, state: decorators.KeepRunningUntilFailure(name, child),
    "Starts a child that succeeded again; ends with its FAILURE.",
)
_decorator(
    "Repeat",
    lambda name, child, ports, state: decorators.Repeat(name, child, ports.input("num_cycles")),
    "Repeats a succeeding child.",
    Port("num_cycles", "input", "int", doc="How often; -1 is for ever.", minimum=-1),
)
_decorator(
    "RetryUntilSuccessful",
    lambda name, child, ports, state: decorators.RetryUntilSuccessful(
        name, child, ports.input("num_attempts")
    ),
    "Tries a failing child again.",
    Port("num_attempts", "input", "int", doc="How often; -1 is for ever.", minimum=-1),
)
_decorator(
    "RunOnce",
    lambda name, child, ports, state: decorators.RunOnce(name, child, ports.input("then_skip")),
    "Lets the child complete once in the tree's life.",
    Port("then_skip", "input", "bool", "true", "Skip afterwards, else repeat the answer."),
)
_decorator(
    "Timeout",
    lambda name, child, ports, state: decorators.Timeout(name, child, ports.input("msec"), state),
    "Halts a child that runs too long and fails.",
    Port("msec", "input", "int", doc="[ms], on the flow's clock; 0 is never.", minimum=0),
)


# ---- leaves


def _leaf(
    name: str,
    make: Callable[[str, BoundPorts, TreeState], Behaviour],
    *ports: Port,
    category: Category = "Action",
    builtin: bool = False,
) -> None:
    def factory(
        label: str, bound: BoundPorts, state: TreeState, children: Sequence[Behaviour]
    ) -> Behaviour:
        return make(label, bound, state)

    doc = (make.__doc__ or "").split("\n")[0]
    register_node(NodeType(name, category, factory, ports, doc, (0, 0), builtin))


_leaf("AlwaysSuccess", leaves.AlwaysSuccess, builtin=True)
_leaf("AlwaysFailure", leaves.AlwaysFailure, builtin=True)
_leaf(
    "SetBlackboard",
    leaves.SetBlackboard,
    Port("value", "input", "any", doc="What is written."),
    Port("output_key", "output", "any", doc="Where to.", bare_key=True),
    builtin=True,
)
_leaf(
    "GetState",
    leaves.GetState,
    Port("state", "output", "string", doc="The phase's number, 1 to 6."),
)
_leaf(
    "IsGreeting",
    leaves.IsGreeting,
    Port(
        "probability", "input", "double", "0.6", "The least that counts as greeting.",
        minimum=0, maximum=1,
    ),
    category="Condition",
)  # fmt: skip
_leaf(
    "GetPoseFromFace",
    leaves.GetPoseFromFace,
    Port("closest_face", "output", "pose", doc="The person's face."),
    Port("patience", "input", "double", "1.0", "How old a face may be [s].", minimum=0),
    Port("frame_id", "input", "frame", "map", "The frame it is written in."),
)
_leaf("TurnToPersonCoords", leaves.TurnToPersonCoords, _FACE_IN, _GOAL_OUT)
_leaf(
    "GetApproachCoords",
    leaves.GetApproachCoords,
    _FACE_IN,
    Port("distance", "input", "double", "1.0", "To keep from the person [m].", minimum=0),
    Port("retreat", "input", "bool", "false", "Back off from a person who is nearer."),
    _GOAL_OUT,
)
_leaf(
    "GazeDownCoords",
    leaves.GazeDownCoords,
    _FACE_IN,
    Port("fixation_pose", "output", "pose", doc="The face at half its height."),
)
_leaf(
    "MoveBase",
    commands.MoveBase,
    Port("goal_pose", "input", "pose", doc="Where the base goes."),
    _FRAME,
    Port("action_name", "input", "string", "", _ROS),
)
_leaf(
    "GazeAtTarget",
    commands.GazeAtTarget,
    Port("fixation_pose", "input", "pose", doc="What the robot looks at."),
    _FRAME,
    Port(
        "fixation_point_error_tolerance",
        "input",
        "double",
        "0.05",
        "A point that moved by less is the same [m].",
        minimum=0,
    ),
    Port("action_name", "input", "string", "", _ROS),
)
_leaf(
    "ArmRoutines",
    commands.ArmRoutines,
    Port("gesture", "input", "gesture", doc="HOME, WAVE, STRETCH, HANDSHAKE, ... or a number."),
    Port("topic", "input", "string", "", _ROS),
)
_leaf(
    "Speak",
    commands.Speak,
    Port("utterance", "input", "string", doc="What is said."),
    Port("language", "input", "string", "en", "A BCP 47 tag."),
    Port("voice", "input", "string", "", _ROS),
    Port("action_name", "input", "string", "", _ROS),
)
_leaf(
    "Express",
    commands.Express,
    Port("expression", "input", "string", doc="neutral, smile, ..."),
    Port("intensity", "input", "double", "1.0", "0 to 1.", minimum=0, maximum=1),
)
_leaf(
    "WaitForXSeconds",
    leaves.WaitForXSeconds,
    Port("seconds", "input", "double", "5", "On the flow's clock [s]; inf is for ever.", minimum=0),
    Port("result", "input", "string", "SUCCESS", "The answer.", choices=("SUCCESS", "FAILURE")),
)
for _name, _type in (("CompareInt", "int"), ("CompareDouble", "double")):
    _leaf(
        _name,
        leaves.Compare,
        Port("A", "input", _type, doc="The left side."),
        Port("Condition", choices=tuple(leaves.COMPARISONS), doc="<, <=, ==, >=, >"),
        Port("B", "input", _type, doc="The right side."),
        category="Condition",
    )

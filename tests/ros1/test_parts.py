"""The parts of a node, without any ROS."""

from __future__ import annotations

from pathlib import Path

import pytest

from kendon.errors import TreeError
from kendon.robots import make_robot
from kendon.ros.parts import make_part
from kendon.ros.settings import NodeSettings, Part
from kendon.ros.stream import PersonStream
from kendon.sources.ros_place import RobotPlace
from kendon.trees import GreetingTree


@pytest.mark.parametrize("part", [Part.BOTH, Part.ANSWERING])
def test_a_tree_that_asks_for_what_the_robot_has_not_is_refused_at_once(
    part: Part, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tree = tmp_path / "mine.xml"
    tree.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="Mine"><ArmRoutines gesture="NOD"/>'
        "</BehaviorTree></root>",
        encoding="utf-8",
    )
    GreetingTree(tree)  # nothing is wrong with the tree itself
    settings = NodeSettings(part=part, tree=str(tree))
    robot = make_robot("point")
    monkeypatch.setattr(type(robot), "gestures", ("home", "wave"))
    with pytest.raises(TreeError, match="the robot has no gesture 'NOD'; it has home, wave"):
        make_part(PersonStream(RobotPlace(), settings, "faces"), robot, settings)

"""Blackboards: SubTree scopes and remapping, port conversion, the registry."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from trees.tree_fakes import ScriptedLeaf, Stage, one_tree, xml

from kendon.errors import TreeError, UnknownNameError
from kendon.phases import Phase
from kendon.trees import (
    NODES,
    BoundPorts,
    GreetingTree,
    NodeType,
    Port,
    TreeState,
    parse_trees,
    register_node,
)
from kendon.trees.ports import UNSET, Scope
from kendon.trees.registry import node_type

WRITER = '<SetBlackboard value="7" output_key="inner"/>'


def board(subtree: str, body: str = WRITER, before: str = "") -> dict[str, object]:
    other = f'<BehaviorTree ID="Other">{body}</BehaviorTree>'
    tree = one_tree(f"<Sequence>{before}{subtree}</Sequence>", other)
    Stage(tree).run(Phase.IA)
    return tree.blackboard


def test_a_subtree_has_its_own_blackboard() -> None:
    assert board('<SubTree ID="Other"/>') == {}


def test_a_remapped_key_is_the_parents_entry() -> None:
    assert board('<SubTree ID="Other" inner="{outer}"/>') == {"outer": "7"}
    assert board('<SubTree ID="Other" inner="{=}"/>') == {"inner": "7"}


def test_autoremap_shares_all_but_private_keys() -> None:
    assert board('<SubTree ID="Other" _autoremap="true"/>') == {"inner": "7"}
    private = WRITER.replace("inner", "_inner")
    assert board('<SubTree ID="Other" _autoremap="true"/>', private) == {}


def test_a_text_given_to_a_subtree_is_on_its_blackboard() -> None:
    check = '<Sequence><CompareInt A="{n}" Condition="==" B="5"/>{}</Sequence>'
    body = check.replace("{}", '<SetBlackboard value="yes" output_key="@answer"/>')
    assert board('<SubTree ID="Other" n="5"/>', body) == {"answer": "yes"}
    assert board('<SubTree ID="Other" n="6"/>', body) == {}


def test_remapping_through_two_levels() -> None:
    deep = '<SubTree ID="Deep" inner="{middle}"/>'
    tree = one_tree(
        '<SubTree ID="Other" middle="{outer}"/>',
        f'<BehaviorTree ID="Other">{deep}</BehaviorTree>'
        f'<BehaviorTree ID="Deep">{WRITER}</BehaviorTree>',
    )
    Stage(tree).run(Phase.IA)
    assert tree.blackboard == {"outer": "7"}


def test_two_uses_of_one_tree_share_nothing() -> None:
    body = (
        '<Sequence><GetState state="{@seen}"/><CompareInt A="{x}" Condition="==" B="1"/></Sequence>'
    )
    tree = one_tree(
        '<Fallback><SubTree ID="Other" x="2"/><SubTree ID="Other" x="1"/></Fallback>',
        f'<BehaviorTree ID="Other">{body}</BehaviorTree>',
    )
    stage = Stage(tree)
    assert stage.run(Phase.HD) is Status.SUCCESS
    assert tree.blackboard == {"seen": "3"}


@pytest.mark.parametrize(
    ("a", "condition", "b", "holds"),
    [
        ("1", "<", "2", True),
        ("2", "<=", "2", True),
        ("1", "==", "2", False),
        ("1", ">", "1", False),
    ],
)
def test_comparisons(a: str, condition: str, b: str, holds: bool) -> None:
    sign = condition.replace("<", "&lt;")
    for kind in ("CompareInt", "CompareDouble"):
        stage = Stage(f'<{kind} A="{a}" Condition="{sign}" B="{b}"/>')
        assert (stage.run(None) is Status.SUCCESS) is holds


def test_a_value_that_does_not_fit_a_port_fails_the_leaf_with_its_sentence() -> None:
    stage = Stage(
        '<Sequence><SetBlackboard value="soon" output_key="{s}"/>'
        '<WaitForXSeconds seconds="{s}"/></Sequence>'
    )
    assert stage.run(None) is Status.FAILURE
    assert stage.message("WaitForXSeconds") == "port 'seconds' needs a number, not 'soon'"


def test_a_pose_is_no_number() -> None:
    stage = Stage(
        '<Sequence><GetPoseFromFace closest_face="{f}"/><WaitForXSeconds seconds="{f}"/></Sequence>'
    )
    assert stage.run(None) is Status.FAILURE
    assert "port 'seconds' needs a number, but {f} holds Pose(" in stage.message("WaitForXSeconds")


def test_an_entry_that_nobody_wrote() -> None:
    stage = Stage('<MoveBase goal_pose="{goal}"/>')
    assert stage.run(None) is Status.FAILURE
    assert stage.message("MoveBase") == (
        "port 'goal_pose' reads {goal}, which no node has written yet"
    )


def test_unset_shows_itself() -> None:
    assert repr(UNSET) == "unset"
    scope = Scope()
    scope.entry("a")
    assert dict(scope) == {}


# ---- the registry


def scripted_factory(
    name: str, ports: BoundPorts, state: TreeState, children: Sequence[Behaviour]
) -> Behaviour:
    return ScriptedLeaf(ports.input("script").get())


@pytest.fixture
def script_node() -> Iterator[NodeType]:
    port = Port("script", doc="Letters.")
    yield register_node(NodeType("Script", "Action", scripted_factory, (port,), "Plays."))
    del NODES["Script"]


def test_users_extend_the_table(script_node: NodeType) -> None:
    stage = Stage('<Sequence><Script script="RS"/></Sequence>')
    assert stage.run(None) is Status.RUNNING
    assert stage.run(None) is Status.SUCCESS
    with pytest.raises(TreeError, match="already"):
        register_node(script_node)


def test_a_port_of_an_unknown_type_is_refused() -> None:
    bad = NodeType("Bad", "Action", scripted_factory, (Port("a", type="float"),))
    with pytest.raises(TreeError, match="no port type 'float'; valid: string, double"):
        register_node(bad)


def test_an_unknown_node_type_lists_the_valid_ones() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'Speak'"):
        node_type("Speek")


# ---- display


def test_states_have_unique_paths_parents_first() -> None:
    tree = GreetingTree()
    states = tree.states()
    assert len({s.path for s in states}) == len(states)
    assert states[0].path == "Greeting/ReactiveSequence"
    assert {s.status for s in states} == {"idle"}
    parents = {s.path.rpartition("/")[0] for s in states} - {"Greeting"}
    seen: set[str] = set()
    for state in states:
        parent = state.path.rpartition("/")[0]
        assert parent not in parents or parent in seen
        seen.add(state.path)


def test_another_main_tree() -> None:
    library = parse_trees(
        xml("<AlwaysFailure/>", '<BehaviorTree ID="B"><AlwaysSuccess/></BehaviorTree>')
    )
    assert Stage(GreetingTree(library, main="B")).run(None) is Status.SUCCESS
    with pytest.raises(UnknownNameError, match="no tree 'C'; valid: Main, B"):
        GreetingTree(library, main="C")

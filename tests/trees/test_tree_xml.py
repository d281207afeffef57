"""Reading and writing BehaviorTree.CPP XML: round trips, version 3, and each error's sentence."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from trees.tree_fakes import xml

from kendon.errors import DataError, TreeError
from kendon.trees import (
    NODES,
    GreetingTree,
    NodeSpec,
    TreeLibrary,
    format_trees,
    parse_trees,
    read_trees,
    shipped_trees,
    write_trees,
)
from kendon.trees.xml import format_model


def test_all_forms_of_a_node_read_the_same() -> None:
    compact = parse_trees(xml('<Sequence><Speak name="hello" utterance="Hi"/></Sequence>'))
    explicit = parse_trees(
        xml('<Control ID="Sequence"><Action ID="Speak" name="hello" utterance="Hi"/></Control>')
    )
    assert compact == explicit
    assert compact.trees["Main"] == NodeSpec(
        "Sequence", children=[NodeSpec("Speak", "hello", {"utterance": "Hi"})]
    )


def test_conditions_and_decorators_by_their_class() -> None:
    body = (
        '<Decorator ID="Inverter"><Condition ID="CompareInt" A="1" Condition="&lt;" B="2"/>'
        "</Decorator>"
    )
    root = parse_trees(xml(body)).trees["Main"]
    assert (root.kind, root.children[0].kind) == ("Inverter", "CompareInt")
    assert root.children[0].attributes["Condition"] == "<"


def test_lines_are_known() -> None:
    library = parse_trees(xml("<Sequence>\n\n<AlwaysSuccess/></Sequence>"))
    assert [node.line for node in library.trees["Main"].walk()] == [1, 3]


def test_a_file_with_one_tree_needs_no_main() -> None:
    text = '<root BTCPP_format="4"><BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree></root>'
    assert parse_trees(text).main == "A"


def test_version_3_names_become_version_4s() -> None:
    text = """
    <root main_tree_to_execute="Main">
      <BehaviorTree ID="Main">
        <SequenceStar>
          <Parallel success_threshold="2" failure_threshold="1">
            <AlwaysSuccess/>
            <RetryUntilSuccesful num_attempts="3"><AlwaysFailure/></RetryUntilSuccesful>
          </Parallel>
          <SubTree ID="Other" inner="outer" __shared_blackboard="false"/>
          <SubTreePlus ID="Other" inner="text" braces="{outer}" __autoremap="true"/>
        </SequenceStar>
      </BehaviorTree>
      <BehaviorTree ID="Other"><AlwaysSuccess/></BehaviorTree>
      <TreeNodesModel><Action ID="Charge"/></TreeNodesModel>
    </root>"""
    root = parse_trees(text).trees["Main"]
    assert root.kind == "SequenceWithMemory"
    parallel, plain, plus = root.children
    assert parallel.attributes == {"success_count": "2", "failure_count": "1"}
    assert parallel.children[1].kind == "RetryUntilSuccessful"
    assert plain.attributes == {"ID": "Other", "inner": "{outer}"}
    assert plus.attributes == {
        "ID": "Other",
        "inner": "text",
        "braces": "{outer}",
        "_autoremap": "true",
    }


def test_vizzys_version_3_leaves_build() -> None:
    text = """
    <root main_tree_to_execute="Main"><BehaviorTree ID="Main"><Sequence>
      <Action ID="ArmRoutines" gesture="1" topic="/vizzyArmRoutines/command"/>
      <Action ID="GazeAtTarget" action_name="gaze" fixation_pose="1;0;1" frame_id="/map"/>
      <Action ID="MoveBase" action_name="move_base" frame_id="map" goal_pose="1;0;0;0;0;0;1"/>
      <Action ID="Speak" action_name="gcloud_tts" language="pt" utterance="Muito prazer" voice=""/>
      <Action ID="WaitForXSeconds" result="SUCCESS" seconds="2"/>
    </Sequence></BehaviorTree></root>"""
    assert len(GreetingTree(parse_trees(text)).states()) == 6


def test_includes_are_read_once_and_relative_to_the_file(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "b.xml").write_text(
        '<root BTCPP_format="4"><include path="../a.xml"/>'
        '<BehaviorTree ID="B"><AlwaysSuccess/></BehaviorTree></root>'
    )
    main = tmp_path / "a.xml"
    main.write_text(
        '<root BTCPP_format="4" main_tree_to_execute="A"><include path="sub/b.xml"/>'
        '<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree></root>'
    )
    library = read_trees(main)
    assert set(library.trees) == {"A", "B"}
    written = tmp_path / "flat.xml"
    write_trees(library, written)
    assert read_trees(written) == library


def test_the_shipped_trees_survive_a_round_trip(tmp_path: Path) -> None:
    library = shipped_trees()
    text = format_trees(library)
    again = parse_trees(text)
    assert again == library
    assert format_trees(again) == text
    assert set(library.trees) == {
        "Greeting",
        "InitiationOfApproach",
        "DistanceSalutation",
        "HeadDip",
        "Approach",
        "FinalApproach",
        "CloseSalutation",
    }


def test_the_shipped_model_is_the_registrys() -> None:
    library = shipped_trees()
    used = {node.kind for root in library.trees.values() for node in root.walk()}
    path = Path(__file__).parents[2] / "src" / "kendon" / "trees" / "greeting.xml"
    assert "\n".join(format_model(used)) in path.read_text(encoding="utf-8")


texts = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn")), min_size=1, max_size=12
).map(lambda t: f"x{t}")
leaves = st.one_of(
    st.builds(lambda n: NodeSpec("AlwaysSuccess", n), texts),
    st.builds(lambda n, u: NodeSpec("Speak", n, {"utterance": u}), texts, texts),
    st.just(NodeSpec("SubTree", attributes={"ID": "Other", "key": "{outer}"})),
)
nodes = st.recursive(
    leaves,
    lambda inner: st.builds(
        lambda kind, children: NodeSpec(kind, children=children),
        st.sampled_from(["Sequence", "ReactiveFallback", "SequenceWithMemory", "Parallel"]),
        st.lists(inner, min_size=1, max_size=4),
    ),
    max_leaves=12,
)


@given(nodes)
def test_any_tree_survives_a_round_trip(root: NodeSpec) -> None:
    library = TreeLibrary("Main", {"Main": root, "Other": NodeSpec("AlwaysSuccess")})
    text = format_trees(library)
    assert parse_trees(text) == library
    assert format_trees(parse_trees(text)) == text


OTHER = '<BehaviorTree ID="Other"><SubTree ID="Main"/></BehaviorTree>'
CASES = 'variable="{v}" case_1="1" case_2="2"'

BAD = {
    "unknown node": (
        xml("<Sequence>\n<Spek utterance='Hi'/></Sequence>"),
        "f.xml line 2, tree 'Main', node Spek: there is no tree node 'Spek'; valid: AlwaysFailure,"
        r" .* did you mean 'Speak'\?",
    ),
    "missing port": (
        xml("<Speak name='hello'/>"),
        "f.xml line 1, tree 'Main', node Speak 'hello': the required port 'utterance' is missing;"
        r" its ports: utterance \(input\), language \(input\)",
    ),
    "unknown port": (
        xml("<Speak utterance='Hi' langage='en'/>"),
        "there is no port 'langage'; valid: utterance, language, voice, action_name."
        r" did you mean 'language'\?",
    ),
    "children of a switch": (
        xml(f"<Switch2 {CASES}><AlwaysSuccess/><AlwaysSuccess/></Switch2>"),
        r"node Switch2: it needs 3 \(2 cases and the default\) children, not 2",
    ),
    "children of a decorator": (
        xml("<Inverter><AlwaysSuccess/><AlwaysSuccess/></Inverter>"),
        "node Inverter: it needs 1 child, not 2",
    ),
    "no children": (xml("<Sequence/>"), "node Sequence: it needs at least 1 child, not 0"),
    "children of a leaf": (
        xml("<AlwaysSuccess><AlwaysSuccess/></AlwaysSuccess>"),
        "node AlwaysSuccess: it needs no children, not 1",
    ),
    "recursion": (
        xml('<SubTree ID="Other"/>', OTHER),
        "f.xml: the trees contain each other: Main -> Other -> Main",
    ),
    "missing main": (
        '<root BTCPP_format="4" main_tree_to_execute="Mian"><BehaviorTree ID="Main">'
        "<AlwaysSuccess/></BehaviorTree></root>",
        r"the main tree does not exist: there is no tree 'Mian'; valid: Main; did you mean 'Main'",
    ),
    "no main said": (
        '<root BTCPP_format="4"><BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree>'
        '<BehaviorTree ID="B"><AlwaysSuccess/></BehaviorTree></root>',
        "does not say main_tree_to_execute, and the file holds 2 trees: A, B",
    ),
    "malformed": (
        "<root>\n<BehaviorTree>\n</root>",
        "f.xml line 3: this is not well-formed XML: mismatched tag",
    ),
    "empty file": ("", "f.xml line 1: this is not well-formed XML: no element found"),
    "entities": (
        '<!DOCTYPE root [<!ENTITY a "b">]><root/>',
        "f.xml line 1: a document type declaration is not allowed",
    ),
    "not a tree file": ("<robot/>", "f.xml line 1: a tree file begins with <root>, not <robot>"),
    "future version": ('<root BTCPP_format="5"/>', "BTCPP_format '5' is unknown; valid: 3, 4"),
    "stray element": ("<root>\n<Speak/></root>", "line 2: <root> holds BehaviorTree, .* not Speak"),
    "parallel threshold": (
        xml('<Parallel success_count="3"><AlwaysSuccess/><AlwaysSuccess/></Parallel>'),
        "node Parallel: a Parallel with 2 children takes counts from -2 to 2, not 3",
    ),
    "wrong number": (
        xml('<WaitForXSeconds seconds="soon"/>'),
        "node WaitForXSeconds: port 'seconds' needs a number, not 'soon'",
    ),
    "not a whole number": (
        xml('<Repeat num_cycles="1.5"><AlwaysSuccess/></Repeat>'),
        "port 'num_cycles' needs a whole number, not '1.5'",
    ),
    "number out of range": (
        xml('<WaitForXSeconds seconds="-1"/>'),
        "port 'seconds' is at least 0, not -1",
    ),
    "intensity out of range": (
        xml('<Express expression="smile" intensity="2"/>'),
        "port 'intensity' is at most 1, not 2",
    ),
    "unknown gesture": (
        xml('<ArmRoutines gesture="BOW"/>'),
        "port 'gesture' needs one of HOME, WAVE, .* or its number, not 'BOW'",
    ),
    "unknown frame": (
        xml('<MoveBase goal_pose="{g}" frame_id="odom"/>'),
        "port 'frame_id' needs one of map, base_footprint, not 'odom'",
    ),
    "unknown result": (
        xml('<WaitForXSeconds result="MAYBE"/>'),
        "port 'result' takes SUCCESS, FAILURE, not 'MAYBE'",
    ),
    "output without a key": (
        xml('<GetState state="state"/>'),
        "port 'state' is an output and needs a blackboard key in braces, like {state}, not 'state'",
    ),
    "script": (
        xml('<AlwaysSuccess _skipIf="x == 1"/>'),
        "the script '_skipIf' cannot be run; kendon's trees take no scripts",
    ),
    "subtree that does not exist": (
        xml('<SubTree ID="Man"/>'),
        "node SubTree 'Man': there is no tree 'Man'; valid: Main",
    ),
    "subtree without an id": (xml("<SubTree/>"), "a SubTree needs the attribute ID"),
    "subtree with children": (
        xml('<SubTree ID="A"><AlwaysSuccess/></SubTree>', OTHER.replace("Other", "A")),
        "a SubTree has no children of its own",
    ),
    "tree written as a node": (
        xml("<Other/>", '<BehaviorTree ID="Other"><AlwaysSuccess/></BehaviorTree>'),
        'this is a tree, written <SubTree ID="Other"/>',
    ),
    "version 3 name in version 4": (
        xml("<SequenceStar><AlwaysSuccess/></SequenceStar>"),
        "node SequenceStar: version 4 calls it SequenceWithMemory",
    ),
    "wrong class": (
        xml('<Condition ID="Speak" utterance="Hi"/>'),
        "node Speak: it is of class Action, not Condition",
    ),
    "class without id": (xml("<Action/>"), "<Action> needs the attribute ID, the node's type"),
    "two roots": (
        xml("<AlwaysSuccess/><AlwaysSuccess/>"),
        "tree 'Main' needs exactly one node at its top, not 2",
    ),
    "tree without id": ("<root><BehaviorTree/></root>", "a BehaviorTree needs the attribute ID"),
    "two trees of one name": (
        xml("<AlwaysSuccess/>", '<BehaviorTree ID="Main"><AlwaysSuccess/></BehaviorTree>'),
        "there are two trees with the ID 'Main'",
    ),
    "include without path": ("<root><include/></root>", "an include needs the attribute path"),
    "include that does not exist": (
        '<root><include path="gone.xml"/></root>',
        "gone.xml: the tree file cannot be read: No such file or directory",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_every_error_is_one_clear_sentence(name: str) -> None:
    text, sentence = BAD[name]
    with pytest.raises(TreeError, match=sentence) as caught:
        parse_trees(text, "f.xml")
    assert str(caught.value).startswith("f.xml")
    assert "\n" not in str(caught.value)


def test_a_file_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(TreeError, match=r"gone.xml: the tree file cannot be read: No such file"):
        read_trees(tmp_path / "gone.xml")


def test_a_file_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match=r"trees.xml: cannot be written"):
        write_trees(shipped_trees(), tmp_path / "file" / "trees.xml")


def test_a_library_made_by_hand_is_checked_too() -> None:
    library = TreeLibrary("Main", {"Main": NodeSpec("Speak")})
    for use in (GreetingTree, format_trees):
        with pytest.raises(TreeError, match="the required port 'utterance' is missing"):
            use(library)


def test_every_node_type_says_what_it_is() -> None:
    for node in NODES.values():
        assert node.doc.endswith("."), node.id
        for port in node.ports:
            assert port.doc, (node.id, port.name)
            if port.default:
                port.parse(port.default)

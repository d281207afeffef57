"""The texts of the page as HTML: the phase in words, the behaviour tree, the robot's commands."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from kendon.greeter import Action, describe
from kendon.phases import Phase
from kendon.robots import CommandStatus
from kendon.viewer.browser.stage import NODE_STATES, Node, Snapshot

#: What a person does in each phase, for somebody who has read nothing (thesis 2.1).
MEANINGS: dict[Phase, str] = {
    Phase.IA: "has seen the robot and decides whether to greet",
    Phase.DS: "greets from afar: a wave, a nod, a toss of the head",
    Phase.HD: "lowers the head for a moment before coming nearer",
    Phase.APP: "walks up, looking elsewhere on the way",
    Phase.FA: "comes up close, looks again and smiles",
    Phase.CS: "greets nearby: shakes hands, hugs, bows",
}
_MARKS = {"running": "▶", "success": "✓", "failure": "✗", "idle": "·"}
_COLORS = {"running": "#0072B2", "success": "#00795a", "failure": "#b3261e", "idle": "#999"}
_STATUS = {
    CommandStatus.RUNNING: "…", CommandStatus.SUCCEEDED: "", CommandStatus.FAILED: "failed",
    CommandStatus.CANCELLED: "",
}  # fmt: skip


def phase_card(snapshot: Snapshot) -> str:
    """The phase in words, what it means, and what the robot does."""
    phase = snapshot.phase
    if phase is None:
        color, title, meaning = "#777", "Nobody to greet", "no person is in sight yet"
        number = ""
    else:
        color, title, meaning = phase.color, phase.title, f"The person {MEANINGS[phase]}"
        number = f"phase {phase.value} of 6, {phase.name}"
    saying = f" and says “{escape(snapshot.saying)}”" if snapshot.saying else ""
    ink = "#fff" if phase in (Phase.FA, Phase.CS, None) else "#111"
    return (
        f'<div data-phase="{phase.name if phase else ""}" style="font:14px system-ui,sans-serif;'
        f'line-height:1.35;background:{color};color:{ink};border-radius:6px;padding:8px 12px">'
        f'<div style="font-size:20px;font-weight:700">{title}</div>'
        f'<div style="font-size:12px">{number}</div>'
        f'<div style="margin-top:2px">{meaning}.</div></div>'
        '<div style="font:14px system-ui,sans-serif;padding:6px 2px 0;min-height:2.8em">'
        f"<b>The robot</b> {escape(snapshot.doing)}{saying}.</div>"
    )


def tree_view(nodes: Sequence[Node], states: bytes) -> str:
    """The behaviour tree: each node with its state, below subtrees that idle nothing."""
    rows = []
    hidden: set[int] = set()
    for place, node in enumerate(nodes):
        if node.parent in hidden:
            hidden.add(place)
            continue
        state = NODE_STATES[states[place]]
        if node.kind == "SubTree" and state == "idle":
            hidden.add(place)
        if _plain(node):
            continue
        rows.append(_row(node, _depth(node, nodes), state))
    return (
        '<div style="font:12px/1.45 system-ui,sans-serif;white-space:nowrap;overflow-x:auto">'
        + "".join(rows) + "</div>"
    )  # fmt: skip


def _plain(node: Node) -> bool:
    """Whether a node only passes on what its child answers, and is left out of the picture."""
    return node.kind in ("ForceSuccess", "KeepRunningUntilFailure") and node.name == node.kind


def _depth(node: Node, nodes: Sequence[Node]) -> int:
    depth = 0
    while node.parent >= 0:
        node = nodes[node.parent]
        depth += not _plain(node)
    return depth


def _row(node: Node, depth: int, state: str) -> str:
    weight = "600" if state == "running" else "400"
    return (
        f'<div style="padding-left:{depth * 12}px;color:{_COLORS[state]};font-weight:{weight}">'
        f'<span style="display:inline-block;width:1.2em">{_MARKS[state]}</span>'
        f"{escape(node_words(node))}</div>"
    )


def node_words(node: Node) -> str:
    """A node's name as words: ``DistanceSalutation`` is “Distance Salutation”."""
    words = "".join(f" {c}" if c.isupper() and i and not node.name[i - 1].isupper() else c
                    for i, c in enumerate(node.name))  # fmt: skip
    return words.replace("  ", " ")


def command_log(actions: Sequence[Action], until: float, most: int = 12) -> str:
    """The newest commands until a time, newest first; follow-ups of a drive or a look once."""
    rows = [row for start, row in log_rows(actions) if start <= until + 1e-6]
    body = "".join(rows[: -most - 1 : -1]) or '<div style="color:#777">nothing yet</div>'
    return f'<div style="font:12px/1.5 system-ui,sans-serif">{body}</div>'


def log_rows(actions: Sequence[Action]) -> list[tuple[float, str]]:
    """When each command was sent [s], and its line of the log; follow-ups once."""
    rows: list[tuple[float, str]] = []
    last: dict[str, str] = {}
    for action in actions:
        words = describe(action.command)
        if last.get(action.channel) != words:
            rows.append((action.start, _log_row(action)))
        last[action.channel] = words
    return rows


def _log_row(action: Action) -> str:
    color = action.phase.color if action.phase else "#777"
    status = _STATUS[action.command.status]
    return (
        '<div style="display:flex;gap:8px">'
        f'<span style="color:#666;width:4.2em;text-align:right">{action.start:.1f} s</span>'
        f'<span style="border-left:4px solid {color};padding-left:6px;color:#222">'
        f"<b>{action.channel}</b> {escape(action.label)}"
        f' <span style="color:#b3261e">{status}</span></span></div>'
    )

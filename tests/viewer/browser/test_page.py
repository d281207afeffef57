"""The page in a real browser: it shows a greeting, and does what its user wants."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from viewer.browser import encounters

from kendon.phases import Phase
from kendon.viewer.browser.session import Choices, Session

pytest.importorskip("viser", reason="viser is not installed")
playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

from kendon.viewer.browser.replay import write_replay  # noqa: E402
from kendon.viewer.browser.server import Page  # noqa: E402

CHROMIUM = Path("/usr/bin/chromium")
pytestmark = pytest.mark.skipif(not CHROMIUM.exists(), reason=f"there is no {CHROMIUM}")
#: A software-drawn page on a busy machine is slow: nothing here is timed [ms].
PATIENCE = 60_000
#: Wide enough for the panels, and with little to draw.
SIZE = {"width": 720, "height": 420}


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Opens pages in a browser that has seen nothing before."""
    with playwright.sync_playwright() as driver:
        contexts: list[Any] = []

        def open_page(address: str, **options: Any) -> Any:
            context = driver.chromium.launch_persistent_context(
                str(tmp_path / f"profile{len(contexts)}"),
                executable_path=str(CHROMIUM),
                args=[
                    "--headless=new", "--no-sandbox", "--disable-gpu", "--use-gl=angle",
                    "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                ],
                viewport=SIZE,
                **options,
            )  # fmt: skip
            contexts.append(context)
            page = context.pages[0]
            page.set_default_timeout(PATIENCE)
            page.goto(address)
            return page

        yield open_page
        for context in contexts:
            context.close()


@pytest.fixture
def served() -> Iterator[Callable[[Session], Page]]:
    """Serves pages of sessions until the test ends."""
    ends: list[Callable[[], None]] = []

    def serve(session: Session) -> Page:
        page, over = Page(session, lambda: "", port=0), threading.Event()
        thread = threading.Thread(target=page.run, args=(over.is_set,))
        thread.start()

        def end() -> None:
            over.set()
            thread.join()
            page.close()

        ends.append(end)
        return page

    yield serve
    for end in ends:
        end()


def test_a_wave_in_the_browser_is_answered_and_a_dragged_person_followed(
    browser: Callable[..., Any], served: Callable[[Session], Page]
) -> None:
    session = encounters.played()
    page = served(session)
    shown = browser(page.address)
    shown.wait_for_selector('[data-phase="IA"]')

    _press(shown, "Wave [1]")
    shown.wait_for_selector('[data-phase="DS"]')
    shown.get_by_text("waves").first.wait_for()
    assert any("waves" in s.doing for s in session.stage.snapshots)
    assert session.player is not None

    # The ring on the floor hands over places like this one.
    before = session.stage.robot.pose
    page.send_to((2.5, -2.0))
    shown.wait_for_selector('[data-phase="APP"], [data-phase="FA"]')
    player = session.player
    _until(shown, lambda: math.dist(player.actor.place, (2.5, -2.0)) < 0.1)
    _until(shown, lambda: session.stage.robot.pose.distance_to(before) > 0.3)


def test_time_is_stopped_and_the_past_looked_at_in_the_browser(
    browser: Callable[..., Any], served: Callable[[Session], Page]
) -> None:
    session = encounters.played()
    shown = browser(served(session).address)
    shown.wait_for_selector('[data-phase="IA"]')
    _press(shown, "Wave [1]")
    shown.wait_for_selector('[data-phase="DS"]')
    _press(shown, "Pause [space]")
    shown.get_by_role("button", name="Go on [space]").wait_for()
    stopped = session.stage.now
    session.post(lambda: session.look_back(0.5))
    shown.wait_for_selector('[data-phase="IA"]')
    assert session.stage.now == stopped
    shown.keyboard.press("n")
    _until(shown, lambda: session.generation == 1)
    _until(shown, lambda: session.stage.now > 1.0)


def test_a_replay_opens_without_a_network(browser: Callable[..., Any], tmp_path: Path) -> None:
    stage, _ = encounters.make(Choices("simulated:short", "kendon", "mujoco"))
    while stage.advance():
        pass
    file = tmp_path / "replay.html"
    write_replay(stage, file)
    asked: list[str] = []
    shown = browser("about:blank", offline=True)
    shown.on("request", lambda request: asked.append(request.url))
    shown.goto(file.as_uri())
    frame = shown.frame_locator("#picture")
    frame.locator("canvas").first.wait_for()
    frame.locator("[role=slider]").first.wait_for(state="attached")
    shown.wait_for_selector(f'[data-phase="{Phase.CS.name}"]')
    # The numbers beside the charts are those of the time that is shown.
    beside = shown.locator("#charts .values text").all_text_contents
    _until(shown, lambda: any(words.startswith("CS") for words in beside()))
    assert all(url.split(":")[0] in ("file", "about", "data", "blob") for url in asked)


def _press(shown: Any, name: str) -> None:
    """Click a button, also under the notice that the page is drawn without a graphics card."""
    shown.get_by_role("button", name=name).evaluate("button => button.click()")


def _until(shown: Any, happened: Callable[[], bool]) -> None:
    """Wait for something on this side of the browser."""
    for _ in range(PATIENCE // 100):
        if happened():
            return
        shown.wait_for_timeout(100)
    pytest.fail("it did not happen in time")

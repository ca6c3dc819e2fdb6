"""People at keyboards: plans of steps that pilot.js follows in the page, pressing real keys through Playwright."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Page

from tests.browser.support import wait_for

SCRIPT = (Path(__file__).parent / "pilot.js").read_text(encoding="utf-8")
FLY = "([seat, keys, plan]) => void window.__pilot(seat, keys, plan).catch((error) => console.error(error))"

Plan = list[tuple[Any, ...]]


@dataclass(frozen=True)
class Pilot:
    """One person: a page, a seat, the keys under their hands (wasd, arrows) and what they mean to do."""

    page: Page
    seat: int
    plan: Plan
    keys: str = "wasd"

    def fly(self) -> None:
        """Begin; the keys are pressed whenever Playwright waits for something."""
        if not self.page.evaluate("() => 'pressKey' in window"):
            self.page.expose_function("pressKey", lambda key, how: getattr(self.page.keyboard, how)(key))
            self.page.evaluate(f"() => {{ {SCRIPT} }}")
        self.page.evaluate(FLY, [self.seat, self.keys, self.plan])


def play(*pilots: Pilot, timeout_s: float) -> None:
    """Let them all play until the round is over."""
    for pilot in pilots:
        pilot.fly()
    wait_for(pilots[0].page, "game.phase.endsWith('_over')", timeout_s)

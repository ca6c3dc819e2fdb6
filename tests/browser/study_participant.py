"""A participant who uses nothing but the keyboard: reads which screen is there, and does what it asks."""

import json
from collections.abc import Callable

from playwright.sync_api import Page, expect

from tests.browser.support import wait_for
from tests.support import ROOT

MOST_TABS = 60
SCREEN = "#study-screen"


class KeyboardParticipant:
    """Goes through a study step by step; `seen` are the kinds of the screens in their order."""

    def __init__(self, page: Page, look: Callable[[str], None] = lambda kind: None, language: str = "en") -> None:
        """`look` is called with the kind of each screen before anything is done there."""
        self.page = page
        self.words: dict[str, str] = json.loads((ROOT / f"web/words/{language}.json").read_text(encoding="utf-8"))
        self.seen: list[str] = []
        self._look = look
        self._ways: dict[str, Callable[[], None]] = {
            "consent": self._consent,
            "form": self.fill_in,
            "questionnaire": self.fill_in,
            "input-check": self._input_check,
            "practice": self._practice,
            "round": self._round,
            "break": lambda: self.press(self.words["study.page.goOn"]),
            "debrief": self._debrief,
        }

    def walk(self, until: str = "code", most: int = 60) -> None:
        """Do every step up to the first screen of the kind `until`."""
        for _ in range(most):
            self.page.wait_for_selector(f"{SCREEN}[data-kind] h1")
            kind = self.kind()
            self.seen.append(kind)
            self._look(kind)
            if kind == until:
                return
            before = self._identity()
            self._ways[kind]()
            self._wait_for_another_screen(before)
        raise AssertionError(f"no {until} after {self.seen}")

    def kind(self) -> str:
        """The kind of the step that is shown."""
        return str(self.page.locator(SCREEN).get_attribute("data-kind"))

    def _identity(self) -> str:
        return str(self.page.evaluate(f"document.querySelector('{SCREEN}').dataset.key"))

    def _wait_for_another_screen(self, before: str) -> None:
        self.page.wait_for_function(
            "([screen, before]) => { const main = document.querySelector(screen);"
            " return main?.dataset.key && main.dataset.key !== before; }",
            arg=[SCREEN, before],
        )

    # ---- fingers ----------------------------------------------------------------------------------------------

    def tab_to(self, selector: str) -> None:
        """Press Tab until what matches has the focus."""
        for _ in range(MOST_TABS):
            if self.page.evaluate("(selector) => document.activeElement?.matches(selector) === true", selector):
                return
            self.page.keyboard.press("Tab")
        raise AssertionError(f"the keyboard does not reach {selector}")

    def press(self, name: str) -> None:
        """Press Tab until the button has the focus, then Enter; it may be drawn anew meanwhile."""
        button = self.page.get_by_role("button", name=name, exact=True)
        expect(button).to_be_visible()
        for _ in range(MOST_TABS):
            if button.evaluate("button => button === document.activeElement"):
                self.page.keyboard.press("Enter")
                return
            self.page.keyboard.press("Tab")
        raise AssertionError(f"the keyboard does not reach {name!r}")

    # ---- screens ----------------------------------------------------------------------------------------------

    def _consent(self) -> None:
        for box in self.page.locator(f"{SCREEN} input[type=checkbox]").all():
            box.evaluate("box => box.setAttribute('data-box', '')")
            self.tab_to("[data-box]")
            self.page.keyboard.press("Space")
            box.evaluate("box => box.removeAttribute('data-box')")
        self.press(self.words["study.consent.agree"])

    def fill_in(self) -> None:
        for question in self.page.locator(".question").all():
            question.evaluate("one => one.setAttribute('data-now', '')")
            if question.locator("textarea").count():
                self.tab_to("[data-now] textarea")
                self.page.keyboard.type("Fine.")
            else:
                self.tab_to("[data-now] input:not(.no-answer input)")
                self.page.keyboard.press("Space")
            question.evaluate("one => one.removeAttribute('data-now')")
        where = self.page.locator(".heading .muted").inner_text()
        last = self.page.get_by_role("button", name=self.words["form.finish"]).count() > 0
        self.press(self.words["form.finish" if last else "form.next"])
        if not last:
            expect(self.page.locator(".heading .muted")).not_to_have_text(where)
            self.fill_in()

    def _input_check(self) -> None:
        for key in ("KeyW", "KeyA", "KeyS", "KeyD", "Space", "ShiftLeft"):
            self.page.keyboard.press(key)
        expect(self.page.get_by_text(self.words["study.check.done"])).to_be_visible()
        expect(self.page.locator(".check-connection .pill")).to_contain_text("ms")
        self.press(self.words["study.page.goOn"])

    def enter_game(self) -> None:
        """The map card asks whether they are ready; the game does not ask again."""
        self.press(self.words["study.round.ready"])
        self.page.wait_for_url("**/play/*")
        wait_for(self.page, "game.status === 'open' && game.phase !== 'lobby'")

    def _practice(self) -> None:
        self.enter_game()
        self._look("in practice")
        self.press(self.words["study.play.enough"])
        self.page.wait_for_url("**/study")

    def _round(self) -> None:
        self.enter_game()
        self._look("in a round")
        wait_for(self.page, "game.phase.endsWith('_over')", timeout_s=30)
        self._look("after a round")
        self.press(self.words["study.play.goOn"])
        self.page.wait_for_url("**/study")

    def _debrief(self) -> None:
        if self.page.locator("input[name=keep]").count():
            self.tab_to("input[name=keep]")
            self.page.keyboard.press("Space")
        self.press(self.words["study.page.goOn"])

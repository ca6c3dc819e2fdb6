"""A Chromium that stands still holds up no other test."""

import signal
from collections.abc import Iterator

import psutil
import pytest
from playwright.sync_api import Error, Playwright

from tests.browser import chromium
from tests.browser.chromium import PLAYWRIGHTS, Chromium


@pytest.fixture
def own(playwright: Playwright, monkeypatch: pytest.MonkeyPatch) -> Iterator[Chromium]:
    monkeypatch.setattr(chromium, "ANSWERS_S", 1.0)
    own = Chromium(playwright)
    yield own
    own.close()


def stand_still() -> None:
    for process in psutil.Process().children(recursive=True):
        if PLAYWRIGHTS in process.cmdline():
            process.send_signal(signal.SIGSTOP)


def test_it_is_killed_where_it_does_not_close_and_the_next_test_gets_a_new_one(own: Chromium) -> None:
    with pytest.raises(Error), own.for_a_test() as browser:
        browser.new_context()
        stand_still()
    with own.for_a_test() as browser:
        assert browser.new_page().evaluate("6 * 7") == 42


def test_it_is_replaced_where_it_stood_still_between_two_tests(own: Chromium) -> None:
    with own.for_a_test() as first:
        pass
    stand_still()
    with own.for_a_test() as second:
        assert (first.is_connected(), second.is_connected()) == (False, True)


def test_what_a_test_leaves_open_is_closed(own: Chromium) -> None:
    with pytest.raises(ZeroDivisionError), own.for_a_test() as browser:
        browser.new_page()
        raise ZeroDivisionError
    assert browser.contexts == []
    assert browser.is_connected()

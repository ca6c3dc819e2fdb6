"""Servers with several processes in real browsers: one process is killed, and whoever played there plays on."""

import os
import signal
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from movingout.server.study_bots.data_check import read_stored
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import read_study
from tests.browser.pages import admin_token
from tests.browser.study_participant import KeyboardParticipant
from tests.browser.study_served import served_study
from tests.browser.support import (
    DESKTOP,
    Server,
    free_port,
    seat_tokens_script,
    start,
    start_process,
    stop_process,
    wait_for,
)
from tests.server.study_bots.support import agents_text

pytestmark = pytest.mark.slow


def kill_home(server: Server, token: str) -> None:
    """kill -9 of the process with a room; there is only one."""
    (busy,) = [row for row in server.request("/api/admin/state", token=token)["processes"] if row["rooms"]]
    os.kill(busy["pid"], signal.SIGKILL)


def play_on(page: Page, tick: int) -> None:
    """The page finds its room again by itself; a key ends the pause."""
    wait_for(page, f"game.status === 'open' && (game.phase !== 'playing' || game.tick > {tick})", 60)
    if page.evaluate("window.__movingout.phase") == "paused":
        page.wait_for_timeout(900)
        page.keyboard.press("Space")
    wait_for(page, f"game.tick > {tick}", 60)


def test_a_game_goes_on_when_its_process_is_killed(browser: Browser, tmp_path: Path) -> None:
    server = Server(f"http://127.0.0.1:{free_port()}", tmp_path / "data", tmp_path / "server.log")
    process = start_process(server, "play", "--countdown", "1", "--processes", "2")
    try:
        context = browser.new_context(base_url=server.url, viewport=DESKTOP)  # type: ignore[arg-type]
        room = server.make_room("HandOff", red="idle")
        context.add_init_script(seat_tokens_script(room))
        page = context.new_page()
        page.goto(room["join_path"])
        start(page)
        wait_for(page, "game.tick > 10", 30)
        kill_home(server, admin_token(server))
        play_on(page, 30)
        seats: Any = page.evaluate("window.__movingout.seats")
        assert seats == [0]
    finally:
        stop_process(process)


def test_a_round_of_a_study_goes_on_when_its_process_is_killed(browser: Browser, tmp_path: Path) -> None:
    with served_study(tmp_path, agents_text(ticks=60), browser, processes=2) as study:
        person = KeyboardParticipant(study.page("/?PROLIFIC_PID=person-1"))
        person.walk(until="round")
        person.enter_game()
        wait_for(person.page, "game.tick > 10", 30)
        kill_home(study.server, study.token)
        play_on(person.page, 15)
        person.page.wait_for_url("**/study", timeout=90_000)
        assert study.third_parties() == set()
        assert study.complaints() == []
        (played,) = read_stored(StudyFolder(read_study(study.file), study.server.data)).rounds
        assert (played["outcome"], played["ticks"]) == ("time", 60)

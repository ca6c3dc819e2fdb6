"""A study served by a real server, faster than real time, and participants who use it over HTTP and WebSockets."""

import asyncio
import contextlib
import json
import time
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from websockets.exceptions import ConnectionClosed, InvalidHandshake

from movingout.server.connection.asgi import App
from movingout.server.host import Host
from movingout.server.processes.front_server import front_server
from movingout.server.public_host import PublicHost
from movingout.server.security.tokens import hash_token
from movingout.server.settings import Settings
from movingout.server.study.api.app import create_study_app
from movingout.server.study.api.dashboard import Dashboard
from movingout.server.study.api.participant_view import ParticipantViews
from movingout.server.study.monitor import StudyMonitor
from movingout.server.study.running_study import RunningStudy
from movingout.server.uvicorn_server import game_server
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from tests.server.live import ADMIN, WAIT_S, Live, Person, limits, serve

SPEED = 20  # ticks of 5 ms

SOLO = """
format: 1
id: solo
title: {en: StudyRooms with partners, de: Mit Partnern spielen}
languages: [en, de]
participants: 400
consent:
  version: "1"
  text: {en: "# Consent\\n\\nWe record **how** you play.", de: "# Einwilligung\\n\\nWir zeichnen auf."}
  boxes: [{id: adult, text: I am 18 or older., required: true}, {id: release, text: You may publish it.}]
pay: {per_hour: 12}
demographics: demographics
practice: {map: Simple, limit_ticks: 20, agent: idle}
partners: [{id: good, agent: idle}, {id: bad, agent: idle}]
blocks:
  - {id: play, partners: [good, bad], maps: [HandOff], limit_ticks: 20, after_partner: [movingout-paper-nine]}
debrief: {text: "# Thank you"}
"""
PAIR = """
format: 1
id: pair
title: StudyRooms together
participants: 400
group: 2
consent: {version: "1", text: We record how you play.}
demographics: ""
practice: {map: Simple, limit_ticks: 30}
blocks: [{id: play, maps: [HandOff], limit_ticks: 20, rounds: 2}]
pairing: {wait_s: 30, return_s: 5}
"""


def one_process(settings: Settings) -> tuple[Host, App]:
    host = Host(settings)
    return host, host.endpoint


@dataclass
class Served:
    """A running study."""

    live: Live
    running: RunningStudy
    monitor: StudyMonitor
    folder: StudyFolder

    def ask(self, action: str, **order: Any) -> Any:
        """An action of the experimenter, which must succeed."""
        status, answer = self.live.call(f"/api/experimenter/{action}", order, ADMIN)
        assert status == 200, answer
        return answer

    def state(self) -> dict[str, Any]:
        status, answer = self.live.call("/api/experimenter/state", token=ADMIN)
        assert status == 200, answer
        return dict(answer)

    def row(self, pid: str) -> dict[str, Any]:
        """A participant's row on the experimenter's page, as of now."""
        asked = Dashboard(self.running, ParticipantViews(self.running)).state()
        state = asyncio.run_coroutine_threadsafe(asked, self.live.loop).result(WAIT_S)
        return next(dict(row) for row in state["participants"] if row["pid"] == pid)

    def alerts(self) -> list[str]:
        """The kinds of the alerts, the newest first."""
        return [alert["about"] for alert in self.running.alerts.to_json()]

    def visitor(
        self, language: str = "en", beside: str = "", known: Sequence[str] = (), **parameters: str
    ) -> "Visitor":
        """Somebody who opens the link, in a browser that has the tokens `known`."""
        status, answer = self.arrive(language, beside, known, **parameters)
        assert status == 200, answer
        return Visitor(self, answer["token"], answer["view"])

    def arrive(
        self, language: str = "en", beside: str = "", known: Sequence[str] = (), **parameters: str
    ) -> tuple[int, Any]:
        body = {"parameters": parameters, "language": language, "beside": beside, "known": [*known]}
        return self.live.call("/api/study/arrive", body)

    def look(self) -> None:
        """Run the checks that the server makes once a second."""
        asyncio.run_coroutine_threadsafe(self.monitor.look(), self.live.loop).result(WAIT_S)

    def later(self, seconds: float, staying: "Visitor | None" = None) -> None:
        """As if all pages, but that of who stays, had been silent for so long."""
        here = staying and staying.pid

        def age() -> None:
            for session in self.running.participants:
                session.last_seen_at -= 0.0 if session.pid == here else seconds
                session.present_since -= seconds
                session.waits_since -= seconds
                session.resumed_at -= seconds
            for one in self.running.units._waiting_room.present(float("-inf")):
                one.since -= seconds
                one.heard -= 0.0 if one.pid == here else seconds

        self.live.run(age)


class Visitor:
    """A participant's page."""

    def __init__(self, served: Served, token: str, view: dict[str, Any]) -> None:
        self.served = served
        self.token = token
        self.view = view

    @property
    def step(self) -> dict[str, Any]:
        return dict(self.view["step"])

    @property
    def kind(self) -> str:
        return str(self.view["step"]["kind"])

    @property
    def pid(self) -> str:
        """The pseudonym, which the page is never sent."""
        found = self.served.running.databases.identities.of_session(hash_token(self.token).hex())
        assert found is not None
        return found

    def call(self, path: str, body: object = None) -> tuple[int, Any]:
        return self.served.live.call(f"/api/study/{path}", body, self.token)

    def look(self, language: str = "") -> dict[str, Any]:
        """Reload."""
        return self._take(self.call("view" + (f"?lang={language}" if language else "")))

    def next(self, **said: Any) -> dict[str, Any]:
        return self._take(self.call("next", {"key": self.step["key"], **said}))

    def stop(self, keep: bool) -> dict[str, Any]:
        return self._take(self.call("stop", {"keep": keep}))

    def decline(self) -> dict[str, Any]:
        return self._take(self.call("decline", {}))

    def answer(self, item: str, value: int = -1, text: str = "", key: str = "") -> tuple[int, Any]:
        body = {"key": key or self.step["key"], "item": item, "value": value, "text": text, "elapsed_ms": 900.0}
        return self.call("answer", {**body, "hidden_ms": 10.0})

    def _take(self, answer: tuple[int, Any]) -> dict[str, Any]:
        status, body = answer
        assert status == 200, body
        self.view = body["view"]
        return dict(self.view)

    # ---- walking ------------------------------------------------------------------------------------------------

    def agree(self) -> None:
        self.next(boxes=["adult"])

    def fill_in(self) -> None:
        """Answer everything that is asked on this screen, and go on."""
        self.answer_all()
        self.next()

    def answer_all(self) -> None:
        for item in self.step["items"]:
            text = "fine" if item["kind"] == "text" else ""
            value = {"likert7": 4, "tlx": 10, "choice": 0, "text": -1}[item["kind"]]
            assert self.answer(item["id"], value, text) == (200, {"saved": True})

    def wait_until(self, reached: Callable[["Visitor"], bool]) -> None:
        """Reload until `reached` is true."""
        deadline = time.monotonic() + WAIT_S
        while not reached(self):
            assert time.monotonic() < deadline, self.view
            time.sleep(0.02)
            self.look()

    def player(self) -> Person:
        """Join the room of the round, and be ready; as a page does, again where a process is being replaced."""
        room, deadline = self.step["room"], time.monotonic() + WAIT_S
        while True:
            try:
                person = self.served.live.person(room["id"], mode="play", tokens=[room["token"]])
                break
            except (ConnectionError, TimeoutError, InvalidHandshake, ConnectionClosed):
                assert time.monotonic() < deadline
                time.sleep(0.1)
        person.say(type="ready", seat=room["seat"], ready=True)
        return person

    def play(self) -> None:
        """Play the whole round, up to the next screen."""
        key = self.step["key"]
        if self.step["state"] != "playing":
            self.next()
        self.wait_until(lambda one: one.step.get("state") == "playing" or one.step["key"] != key)
        person = self.player()
        with contextlib.suppress(ConnectionClosed):
            person.play_out(self.step["room"]["seat"])
        person.connection.close()
        self.wait_until(lambda one: one.step["key"] != key)

    def do(self) -> None:
        """Complete this screen."""
        actions: dict[str, Callable[[], Any]] = {
            "consent": self.agree,
            "form": self.fill_in,
            "questionnaire": self.fill_in,
            "input-check": lambda: self.next(rtt_ms=8.0, device="keyboard"),
            "practice": self.play,
            "round": self.play,
            "waiting": lambda: self.wait_until(lambda one: one.kind != "waiting"),
            "debrief": lambda: self.next(keep=True),
            "break": self.next,
        }
        actions[self.kind]()

    def go_to(self, kind: str) -> "Visitor":
        """Complete screens up to the first one of this kind."""
        while self.kind != kind:
            self.do()
        return self


@contextmanager
def served(
    data: Path,
    text: str = SOLO,
    *,
    codes: bool = False,
    signed: bool = False,
    any_device: bool = False,
    database: str | None = None,
    beside: Path | None = None,
    port: int = 0,
    host_of: Callable[[Settings], tuple[PublicHost, App]] = one_process,
    **settings: Any,
) -> Iterator[Served]:
    """Serve a study, whose file lies in the folder `beside`, for one `with` block; its data remain."""
    folder = StudyFolder(parse_study(text, folder=beside), data, database)
    options = {
        "study": folder.study.id,
        "lobby": False,
        "tick_s": 0.1 / SPEED,
        "countdown_s": 0.05,
        "agent_workers": 0,
        **settings,
    }
    made: list[Any] = []

    def app_of(chosen: Any) -> Any:
        app = create_study_app(
            *host_of(chosen), folder, text, needs_code=codes, needs_signature=signed, any_device=any_device
        )
        made.append(app.state)
        return app

    many = limits(
        sockets_per_address=500,
        waiting_per_address=500,
        wrong_tokens_per_minute=100_000,
        study_changes_per_s=2.0 * SPEED,
        study_answers_per_s=5.0 * SPEED,
        messages_per_s=60.0 * SPEED,
        message_burst=60.0 * SPEED,
    )
    server_of = game_server if host_of is one_process else front_server
    with serve(data, many, app_of, port, server_of=server_of, **options) as live:
        yield Served(live, made[0].running, made[0].monitor, folder)


def events_of(visitor: Visitor, count: int) -> list[dict[str, Any]]:
    """The next events of a participant's stream."""
    request = urllib.request.Request(f"http://{visitor.served.live.address}/api/study/events")
    request.add_header("Authorization", f"Bearer {visitor.token}")
    found: list[dict[str, Any]] = []
    with urllib.request.urlopen(request, timeout=WAIT_S) as stream:
        for line in stream:
            if line.startswith(b"data: "):
                found.append(json.loads(line[6:]))
            if len(found) == count:
                return found
    raise AssertionError(f"the stream ended after {found}")

"""A study that exists only in the browser's network: each screen at will, every request heard, every fault possible.

The pages' scripts and the game come from the running server; `/api/study` is answered here, in the shape in which the
server answers it.
"""

import json
from dataclasses import dataclass, field
from typing import Any

from playwright.sync_api import Page, Route

from movingout.maps import load_map, map_to_json
from movingout.server.api.middleware import content_security_policy
from movingout.study.design.instruments import DEMOGRAPHICS, NASA_TLX
from movingout.study.questionnaire import PAPER, Questionnaire
from tests.support import ROOT

Step = dict[str, Any]
TITLE = "Playing with partners"
CONSENT = (
    "<h1>Taking part in a research study</h1><p>This is research. We study how people and computer programs work "
    "together when they move things.</p><p><strong>Stopping.</strong> Taking part is voluntary.</p>"
)


def consent() -> Step:
    boxes = [
        {"id": "adult", "text": "I am 18 or older.", "required": True},
        {"id": "release", "text": "My recordings may be published without my name.", "required": False},
    ]
    return {"key": "consent", "kind": "consent", "version": "1", "html": CONSENT, "boxes": boxes}


def questions(questionnaire: Questionnaire, kind: str = "questionnaire", letter: str | None = None) -> Step:
    items = [item.as_json() for item in questionnaire.items]
    step = {"key": questionnaire.id, "kind": kind, "title": questionnaire.title, "items": items, "answers": {}}
    return {**step, "partner_letter": letter}


def play(state: str = "card", kind: str = "round", map_name: str = "HandOff", **more: Any) -> Step:
    chosen = load_map(map_name)
    return {
        "key": f"{kind}/{map_name}", "kind": kind, "map": map_to_json(chosen), "title": chosen.title,
        "description": chosen.description, "seat": 0, "partner_letter": "A" if kind == "round" else None,
        "number": 3, "of": 12, "limit_s": 50, "room": None, "state": state, **more,
    }  # fmt: skip


def code(outcome: str = "done", **more: Any) -> Step:
    earned = {"minutes": 62, "amount": 20.67, "currency": "USD"}
    step = {"key": "code", "kind": "code", "code": "K7QX4WPL2M", "outcome": outcome, "earned": earned, "kept": True}
    return {**step, "completion_url": None, **more}


def debrief() -> Step:
    html = "<h1>Thank you</h1><p>The partners were different computer programs.</p>"
    return {"key": "debrief", "kind": "debrief", "html": html, "ask_to_keep": True}


def input_check(**more: Any) -> Step:
    return {"key": "input-check", "kind": "input-check", "gamepad_required": False, "rtt_ms": 2000, **more}


def waiting(**more: Any) -> Step:
    step = {"key": "waiting", "kind": "waiting", "since_s": 72, "wait_s": 300, "people": 1, "otherwise": "code"}
    return {**step, **more}


def every_screen() -> dict[str, Step]:
    """Each screen by the name of its picture."""
    return {
        "consent": consent(),
        "form": questions(DEMOGRAPHICS, "form"),
        "questionnaire": questions(PAPER, letter="A"),
        "tlx": questions(NASA_TLX),
        "input-check": input_check(),
        "practice": play(kind="practice", map_name="Simple", limit_s=120),
        "round": play(map_name="AdaptiveAssist"),
        "round-waiting": play("waiting"),
        "round-running": play("playing", room={"id": "r", "token": "t", "seat": 0, "path": "/play/r"}),
        "round-over": play("over"),
        "waiting": waiting(),
        "break": {"key": "break", "kind": "break", "seconds": 120},
        "paused": {"key": "paused", "kind": "paused"},
        "debrief": debrief(),
        "code": code(completion_url="https://example.org/complete"),
        "code-declined": code("declined", code=None, earned=None),
        "ended-elsewhere": {"key": "elsewhere", "kind": "ended-elsewhere"},
    }


@dataclass
class FakePerson:
    """A participant: the steps to come, the first of which is shown."""

    steps: list[Step]
    language: str = "en"
    done: int = 0
    can_stop: bool = True
    was_here: bool = False  # in this browser, before another one

    def view(self) -> dict[str, Any]:
        return {
            "study": {"title": TITLE if self.language == "en" else "Mit Partnern spielen"},
            "language": self.language,
            "languages": ["en", "de"],
            "step": self.steps[0],
            "position": {"done": self.done, "total": self.done + len(self.steps)},
            "can_stop": self.can_stop,
        }

    def next(self) -> None:
        self.steps = self.steps[1:]
        self.done += 1


@dataclass
class FakeStudy:
    """Answers the study's API on every page that it is installed on."""

    people: dict[str, FakePerson] = field(default_factory=dict)  # by token
    coming: list[FakePerson] = field(default_factory=list)  # who arrives next
    group: int = 1
    pays: bool = True
    languages: tuple[str, ...] = ("en", "de")
    leaves_rooms: bool = False  # a round is over when the page asks where it is after having been in the room
    asks_code: bool = True
    refusals: dict[str, tuple[int, str, str]] = field(default_factory=dict)  # path to status, code, message
    heard: list[tuple[str, dict[str, Any]]] = field(default_factory=list)  # path and body of every POST
    urls: list[str] = field(default_factory=list)

    @classmethod
    def at(cls, *steps: Step, **more: Any) -> "FakeStudy":
        """One participant who is there already."""
        return cls(people={"token-of-person-1": FakePerson(list(steps))}, **more)

    def install(self, page: Page) -> None:
        page.on("request", lambda request: self.urls.append(request.url))
        page.route("**/study", lambda route: self._page(route, "study/study.html"))
        page.route("**/study?*", lambda route: self._page(route, "study/study.html"))
        page.route("**/api/study**", self._answer)
        page.route("**/api/study/**", self._answer)

    def open(self, page: Page, query: str = "") -> None:
        """The study page, where those who are here sit already."""
        self.install(page)
        keys = ("movingout-study-token", "movingout-study-token-2")
        kept = dict(zip(keys, self.people, strict=False))
        once = f"for (const [key, token] of Object.entries({json.dumps(kept)})) localStorage.setItem(key, token);"
        page.evaluate(once)
        page.goto("/study" + query)

    def sent(self, path: str) -> list[dict[str, Any]]:
        return [body for heard, body in self.heard if heard == path]

    def answers(self) -> dict[str, tuple[int, str]]:
        """The newest value and text of each question, in the order of the first ones."""
        return {body["item"]: (body["value"], body["text"]) for body in self.sent("/answer")}

    def _page(self, route: Route, name: str) -> None:
        host = route.request.url.split("/")[2]
        policy = {"content-security-policy": content_security_policy(host)}
        body = (ROOT / "web" / name).read_text(encoding="utf-8")
        route.fulfill(body=body, content_type="text/html; charset=utf-8", headers=policy)

    def _answer(self, route: Route) -> None:
        request = route.request
        path = request.url.partition("/api/study")[2].partition("?")[0]
        body: dict[str, Any] = request.post_data_json or {}
        if request.method == "POST":
            self.heard.append((path, body))
        if path in self.refusals:
            status, name, message = self.refusals[path]
            if status == 0:
                route.abort()
            else:
                route.fulfill(status=status, json={"error": {"code": name, "message": message}})
        elif path == "":
            study = {"title": TITLE, "languages": self.languages, "asks_code": self.asks_code, "group": self.group}
            study |= {"pays": self.pays, "one_screen": self.group == 2}
            route.fulfill(json=study)
        elif path == "/events":
            route.fulfill(body='data: {"changed": true}\n\n', content_type="text/event-stream")
        elif path == "/arrive":
            token = f"token-of-person-{len(self.people) + 1}"
            comes = self.coming.pop(0)
            was = next((at for at, known in enumerate(body["known"]) if self.people.get(known) is comes), None)
            self.people[token] = comes
            comes.language = body["language"]
            was_here = was is not None or comes.was_here
            route.fulfill(json={"token": token, "view": comes.view(), "replaces": was, "was_here": was_here})
        else:
            self._answer_participant(route, path, body)

    def _answer_participant(self, route: Route, path: str, body: dict[str, Any]) -> None:
        token = (route.request.headers.get("authorization") or "").removeprefix("Bearer ")
        person = self.people.get(token)
        if person is None:
            error = {"code": "no_participant", "message": "unknown"}
            route.fulfill(status=401, json={"error": error})
            return
        if "?lang=" in route.request.url:
            person.language = route.request.url.rpartition("=")[2]
        if path == "/view" and self.leaves_rooms and person.steps[0].get("state") == "playing":
            person.next()
        if path == "/next" and body["key"] == person.steps[0]["key"]:
            person.next()
        if path == "/decline":
            person.steps = [code("declined", code=None, earned=None)]
        if path == "/stop":
            person.steps = [code("withdrew", kept=body["keep"])]
        if path == "/answer":
            route.fulfill(json={"saved": True})
        else:
            route.fulfill(json={"view": person.view()})

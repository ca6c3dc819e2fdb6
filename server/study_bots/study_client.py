"""The HTTP API of a study and its event stream, as a participant's page uses them."""

import asyncio
import json
from collections.abc import AsyncIterator
from http import HTTPStatus
from typing import Any

import httpx

from movingout.study.errors import StudyError

RETRY_S = 0.25
GIVE_UP_S = 120.0  # without a response
RETRIED = (
    HTTPStatus.REQUEST_TIMEOUT,  # of a proxy that the request did not reach in time
    HTTPStatus.TOO_MANY_REQUESTS,
    HTTPStatus.BAD_GATEWAY,
    HTTPStatus.SERVICE_UNAVAILABLE,
    HTTPStatus.GATEWAY_TIMEOUT,
    HTTPStatus.INSUFFICIENT_STORAGE,
)
View = dict[str, Any]


class SimulationError(StudyError):
    """The simulation cannot continue."""


class RequestRefused(StudyError):
    """The server refused a request; `code` tells the page why."""

    def __init__(self, status: int, code: str, message: str) -> None:
        super().__init__(message)
        self.status = status
        self.code = code


class StudyClient:
    """One participant's page. Requests are repeated while the server is unreachable, as the page does.

    Raises SimulationError where that lasts, and RequestRefused.
    """

    def __init__(self, http: httpx.AsyncClient) -> None:
        self._http = http
        self._token = ""

    async def arrive(self, parameters: dict[str, str], language: str) -> View:
        arrived = await self._ask("POST", "/api/study/arrive", {"parameters": parameters, "language": language})
        self._token = arrived["token"]
        view: View = arrived["view"]
        return view

    async def view(self) -> View:
        view: View = (await self._ask("GET", "/api/study/view"))["view"]
        return view

    async def next(self, key: str, **said: object) -> View:
        view: View = (await self._ask("POST", "/api/study/next", {"key": key, **said}))["view"]
        return view

    async def stop(self, keep: bool) -> View:
        view: View = (await self._ask("POST", "/api/study/stop", {"keep": keep}))["view"]
        return view

    async def answer(self, key: str, item: str, value: int, text: str, elapsed_ms: float) -> None:
        """One answer; returns once the server has confirmed that it is saved."""
        click = {"key": key, "item": item, "value": value, "text": text, "elapsed_ms": elapsed_ms, "hidden_ms": 0}
        await self._ask("POST", "/api/study/answer", click)

    async def events(self) -> AsyncIterator[None]:
        """One item per event, without end; reconnects when the stream breaks."""
        while True:
            try:
                async with self._http.stream(
                    "GET", "/api/study/events", headers=self._headers(), timeout=httpx.Timeout(10.0, read=15.0)
                ) as stream:
                    async for line in stream.aiter_lines():
                        if line.startswith("data:"):
                            yield None
            except httpx.TransportError:
                pass
            await asyncio.sleep(RETRY_S)

    def _headers(self) -> dict[str, str]:
        return {"Authorization": f"Bearer {self._token}"} if self._token else {}

    async def _ask(self, method: str, path: str, body: object = None) -> Any:
        waited = 0.0
        while True:
            try:
                answer = await self._http.request(method, path, json=body, headers=self._headers())
                if answer.status_code not in RETRIED:
                    return _content(answer)
                problem = f"{path} answered {answer.status_code}: {answer.text[:200]}"
            except httpx.TransportError as error:
                problem = f"the server does not respond: {error or type(error).__name__}"
            if waited > GIVE_UP_S:
                raise SimulationError(f"{problem}, for {GIVE_UP_S:.0f} s")
            waited += RETRY_S
            await asyncio.sleep(RETRY_S)


def _content(answer: httpx.Response) -> Any:
    try:
        content = answer.json()
    except json.JSONDecodeError:
        raise SimulationError(f"{answer.url} answered {answer.status_code}, but not with JSON") from None
    if answer.is_success:
        return content
    error = content.get("error", {})
    raise RequestRefused(answer.status_code, error.get("code", ""), error.get("message", answer.text[:200]))

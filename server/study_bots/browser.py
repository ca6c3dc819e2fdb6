"""A participant's browser as far as the server can tell: the study's HTTP API and its stream of news."""

import asyncio
import json
from collections.abc import AsyncIterator
from http import HTTPStatus
from typing import Any

import httpx

from movingout.study.errors import StudyError

RETRY_S = 0.25
PATIENCE_S = 120.0  # without any answer
LATER = (HTTPStatus.BAD_GATEWAY, HTTPStatus.SERVICE_UNAVAILABLE, HTTPStatus.INSUFFICIENT_STORAGE)
View = dict[str, Any]


class SimulationError(StudyError):
    """The rehearsal cannot go on."""


class RequestRefused(StudyError):
    """The server did not do what was asked for; `code` is what the page would go by."""

    def __init__(self, status: int, code: str, message: str) -> None:
        super().__init__(message)
        self.status = status
        self.code = code


class StudyBrowser:
    """One participant's. A server that is away is asked again, as the page does."""

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
        """One click; returns once the server says that it is saved."""
        click = {"key": key, "item": item, "value": value, "text": text, "elapsed_ms": elapsed_ms, "hidden_ms": 0}
        await self._ask("POST", "/api/study/answer", click)

    async def news(self) -> AsyncIterator[None]:
        """One item per event, for as long as the participant is there; begins again when the stream breaks."""
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
                if answer.status_code not in LATER:
                    return _content(answer)
                problem = f"{path} answers {answer.status_code}: {answer.text[:200]}"
            except httpx.TransportError as error:
                problem = f"the server does not answer: {error or type(error).__name__}"
            if waited > PATIENCE_S:
                raise SimulationError(f"{problem}, for {PATIENCE_S:.0f} s")
            waited += RETRY_S
            await asyncio.sleep(RETRY_S)


def _content(answer: httpx.Response) -> Any:
    try:
        content = answer.json()
    except json.JSONDecodeError:
        raise SimulationError(f"{answer.url} answers {answer.status_code}, and no JSON") from None
    if answer.is_success:
        return content
    error = content.get("error", {})
    raise RequestRefused(answer.status_code, error.get("code", ""), error.get("message", answer.text[:200]))

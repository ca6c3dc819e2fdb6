"""One question to an endpoint with the OpenAI chat API, bounded in time and size."""

import time
from collections.abc import Callable, Sequence
from typing import Any, Literal

from movingout.agents.errors import AgentError
from movingout.agents.llm.model_id import ModelId
from movingout.maps.extras import needs_extra

Message = dict[str, str]
Chat = Callable[[Sequence[Message]], str]
"""Messages in, text out. Raises ChatError."""

Fault = Literal["busy", "timeout", "unreachable", "http", "rubbish"]
MAX_BYTES = 1 << 20  # of an answer
MAX_SAID = 200  # characters of an error that are passed on
CONNECT_S = 5.0
TRIES_S = 10.0  # for the first contact: the server, or this machine, may be busy


class ChatError(Exception):
    """There is no answer; `wait_s` is for how long the server asks not to be asked, 0 where it does not say."""

    def __init__(self, fault: Fault, text: str, wait_s: float = 0.0) -> None:
        super().__init__(text)
        self.fault = fault
        self.wait_s = wait_s


class ChatEndpoint:
    """A model that can be asked. Each call has its own connection, so that a call that hangs delays no other."""

    def __init__(
        self,
        model: ModelId,
        key: str,
        timeout_s: float,
        extra: dict[str, Any],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`extra`: further fields of requests. Raises MissingExtraError without httpx."""
        with needs_extra("llm", "a language model as partner"):
            import httpx
        self._httpx = httpx
        self._model = model
        self._key = key
        self._timeout_s = timeout_s
        self._extra = extra
        self._clock = clock

    def __call__(self, messages: Sequence[Message]) -> str:
        """The model's text. Raises ChatError."""
        request = {"model": self._model.model, "messages": list(messages), "stream": False, **self._extra}
        document = self._asked("POST", "/chat/completions", request, self._timeout_s)
        try:
            text = document["choices"][0]["message"]["content"]
        except (KeyError, IndexError, TypeError):
            raise ChatError("rubbish", "the answer has no choices[0].message.content") from None
        if not isinstance(text, str):
            raise ChatError("rubbish", "the answer's content is no text")
        return self._without_key(text)

    def meet(self) -> None:
        """Raises AgentError when nothing answers at the address, or when it refuses the key."""
        try:
            self._asked("GET", "/models", None, TRIES_S)
        except ChatError as error:
            if error.fault in ("unreachable", "timeout"):
                raise AgentError(
                    f"llm: nothing answers at {self._model.url} ({error}); start the server, or correct url"
                ) from None
            if str(error).startswith(("HTTP 401", "HTTP 403")):
                raise AgentError(f"llm: {self._model.url} refuses the key ({error})") from None

    def _asked(self, method: str, path: str, request: dict[str, Any] | None, within_s: float) -> Any:
        httpx, headers = self._httpx, {"Authorization": f"Bearer {self._key}"} if self._key else {}
        until = self._clock() + within_s
        try:
            with (
                httpx.Client(timeout=httpx.Timeout(within_s, connect=min(CONNECT_S, within_s))) as http,
                http.stream(method, self._model.url + path, json=request, headers=headers) as answer,
            ):
                body = self._body(answer.iter_bytes(), until)
                if answer.status_code != 200:
                    raise self._refused(answer.status_code, answer.headers.get("retry-after", ""), body)
        except httpx.TimeoutException:
            raise ChatError("timeout", f"no answer within {within_s:g} s") from None
        except (httpx.HTTPError, httpx.InvalidURL, OSError, ValueError) as error:  # ValueError: it cannot be sent
            raise ChatError("unreachable", self._said(str(error) or type(error).__name__)) from None
        try:
            return httpx.Response(200, content=body).json()
        except (ValueError, RecursionError):
            raise ChatError("rubbish", "the answer is no JSON") from None

    def _body(self, blocks: Any, until: float) -> bytes:
        body = b""
        for block in blocks:
            body += block
            if len(body) > MAX_BYTES:
                raise ChatError("rubbish", f"the answer is longer than {MAX_BYTES >> 20} MB")
            if self._clock() > until:
                raise ChatError("timeout", "the answer did not end in time")
        return body

    def _refused(self, status: int, retry_after: str, body: bytes) -> ChatError:
        said = self._said(f"HTTP {status}: {body.decode(errors='replace')}")
        if status not in (429, 503):
            return ChatError("http", said)
        try:
            wait_s = max(0.0, float(retry_after))
        except ValueError:
            wait_s = 0.0  # a date, or nothing
        return ChatError("busy", said, wait_s if wait_s < float("inf") else 0.0)

    def _said(self, text: str) -> str:
        return " ".join(self._without_key(text).split())[:MAX_SAID]

    def _without_key(self, text: str) -> str:
        """Servers may repeat what they were sent."""
        return text.replace(self._key, "[key]") if self._key else text

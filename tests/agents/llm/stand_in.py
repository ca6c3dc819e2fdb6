"""A stand-in for a server with the OpenAI chat API: on loopback, with answers, delays and faults that a test wants."""

import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

from movingout.agents.llm.chat import Message

Think = Callable[[str], str]


@dataclass(slots=True)
class Reply:
    """What comes back: a status, a body, headers, after a delay; `drips` sends a byte at a time."""

    body: str
    status: int = 200
    headers: Mapping[str, str] = field(default_factory=dict)
    delay_s: float = 0.0
    drips_s: float = 0.0


def said(text: object) -> Reply:
    """The model's text as the API wraps it."""
    return Reply(json.dumps({"choices": [{"message": {"role": "assistant", "content": text}}]}))


@dataclass
class StandIn:
    """The server: `reply` gives the answer to each request."""

    reply: Callable[[list[Message]], Reply]
    url: str = ""
    models: Reply = field(default_factory=lambda: Reply('{"data": []}'))
    requests: list[dict[str, Any]] = field(default_factory=list)
    keys: list[str] = field(default_factory=list)


@contextmanager
def stand_in(reply: Callable[[list[Message]], Reply]) -> Iterator[StandIn]:
    """A server as long as the block lasts."""
    made = StandIn(reply)

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self._send(made.models)

        def do_POST(self) -> None:
            request = json.loads(self.rfile.read(int(self.headers["content-length"])))
            made.requests.append(request)
            made.keys.append(self.headers.get("authorization", ""))
            self._send(made.reply(request["messages"]))

        def _send(self, reply: Reply) -> None:
            time.sleep(reply.delay_s)
            body = reply.body.encode()
            self.send_response(reply.status)
            for name, value in {**reply.headers, "content-length": str(len(body))}.items():
                self.send_header(name, value)
            self.end_headers()
            try:
                for start in range(0, len(body), 1 if reply.drips_s else len(body) or 1):
                    self.wfile.write(body[start : start + 1] if reply.drips_s else body)
                    time.sleep(reply.drips_s)
            except OSError:
                pass  # the client has gone

        def log_message(self, format: str, *values: object) -> None:
            """Quiet."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    made.url = f"http://127.0.0.1:{server.server_address[1]}/v1"
    thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    try:
        yield made
    finally:
        server.shutdown()
        server.server_close()
        thread.join()

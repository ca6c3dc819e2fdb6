"""A small S3-compatible store for the tests: on loopback, in memory, failing as it is told."""

import base64
import hashlib
import http.server
import re
import threading
import urllib.parse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

KEY = "tester"  # the only key that it knows


@dataclass
class S3Server:
    """What the store holds, and how it behaves."""

    port: int = 0
    buckets: dict[str, dict[str, bytes]] = field(default_factory=lambda: {"lab": {}})
    fails: str = ""  # the code of the error that every request gets, such as AccessDenied
    spoils: bool = False  # whether it keeps other bytes than it is sent
    encrypts: bool = False  # whether an ETag is no MD5
    puts: list[str] = field(default_factory=list)
    on_put: Callable[[str], object] = lambda key: None  # called before the bytes are kept

    @property
    def environment(self) -> dict[str, str]:
        """The variables of the environment by which a client finds it."""
        return {
            "AWS_ENDPOINT_URL": f"http://127.0.0.1:{self.port}",
            "AWS_ACCESS_KEY_ID": KEY,
            "AWS_SECRET_ACCESS_KEY": "secret",
            "AWS_REGION": "us-east-1",
        }


@contextmanager
def s3_server() -> Iterator[S3Server]:
    state = S3Server()

    class Handler(_Handler):
        store = state

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    state.port = server.server_address[1]
    thread = threading.Thread(target=server.serve_forever, args=(0.05,))
    thread.start()
    try:
        yield state
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


class _Handler(http.server.BaseHTTPRequestHandler):
    store: S3Server
    protocol_version = "HTTP/1.1"

    def log_message(self, format: str, *args: Any) -> None:
        pass

    def do_PUT(self) -> None:
        def put(objects: dict[str, bytes], key: str, body: bytes) -> None:
            digest = base64.b64encode(hashlib.sha256(body).digest()).decode()
            if self.headers.get("x-amz-checksum-sha256") != digest:
                return self._fail(400, "BadDigest")
            self.store.on_put(key)
            objects[key] = body[:-1] + b"?" if self.store.spoils else body
            self.store.puts.append(key)
            self._answer(200, b"", ETag=self._tag(objects[key]))

        self._with_bucket(put)

    def do_GET(self) -> None:
        def get(objects: dict[str, bytes], key: str, body: bytes) -> None:
            if not key:
                return self._list(objects)
            if key not in objects:
                return self._fail(404, "NoSuchKey")
            self._answer(200, objects[key], ETag=self._tag(objects[key]))

        self._with_bucket(get)

    do_HEAD = do_GET

    def do_POST(self) -> None:
        def delete(objects: dict[str, bytes], key: str, body: bytes) -> None:
            names = re.findall("<Key>(.*?)</Key>", body.decode())
            for name in names:
                objects.pop(name, None)
            rows = "".join(f"<Deleted><Key>{name}</Key></Deleted>" for name in names)
            self._answer(200, f"<DeleteResult>{rows}</DeleteResult>".encode())

        self._with_bucket(delete)

    def _with_bucket(self, work: Any) -> None:
        body = self.rfile.read(int(self.headers.get("Content-Length", "0")))
        bucket, _, key = urllib.parse.unquote(urllib.parse.urlsplit(self.path).path).lstrip("/").partition("/")
        if self.store.fails:
            self._fail(403, self.store.fails)
        elif f"Credential={KEY}/" not in self.headers.get("Authorization", ""):
            self._fail(403, "InvalidAccessKeyId")
        elif bucket not in self.store.buckets:
            self._fail(404, "NoSuchBucket")
        else:
            work(self.store.buckets[bucket], key, body)

    def _list(self, objects: dict[str, bytes]) -> None:
        prefix = urllib.parse.parse_qs(urllib.parse.urlsplit(self.path).query).get("prefix", [""])[0]
        rows = "".join(
            f"<Contents><Key>{name}</Key><Size>{len(data)}</Size><ETag>{self._tag(data)}</ETag>"
            "<LastModified>2026-11-23T00:00:00.000Z</LastModified></Contents>"
            for name, data in sorted(objects.items())
            if name.startswith(prefix)
        )
        self._answer(200, f"<ListBucketResult><IsTruncated>false</IsTruncated>{rows}</ListBucketResult>".encode())

    def _tag(self, data: bytes) -> str:
        kind = "0" * 32 if self.store.encrypts else hashlib.md5(data, usedforsecurity=False).hexdigest()
        return f'"{kind}"'

    def _fail(self, status: int, code: str) -> None:
        self._answer(status, f"<Error><Code>{code}</Code></Error>".encode())

    def _answer(self, status: int, body: bytes, **headers: str) -> None:
        self.send_response(status)
        for name, value in headers.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Last-Modified", "Mon, 23 Nov 2026 00:00:00 GMT")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

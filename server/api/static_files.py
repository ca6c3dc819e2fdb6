"""Files of web/ from memory, read again when they change: a request costs neither a thread nor a disk.

Texts are kept compressed as well: at 50 KB/s the lobby is there after a third of the time.
"""

import gzip
import hashlib
import mimetypes
import re
from pathlib import Path
from typing import NamedTuple

from starlette.requests import Request
from starlette.responses import Response

from movingout.server.api.module_preloads import with_preloads

HEADERS = {"cache-control": "no-cache", "vary": "accept-encoding"}  # revalidated, so that a new version shows at once
TEXTS = ("text/", "application/json", "image/svg+xml")
GZIP = re.compile(r"\bgzip\b(?!\s*;\s*q=0(\.0*)?\s*(,|$))")  # in Accept-Encoding, RFC 9110, 12.5.3
SMALLEST = 500  # bytes; less fits into one packet anyway


class _Kept(NamedTuple):
    stamp: tuple[int, int]  # time of the change in ns, size
    body: bytes
    packed: bytes  # the same, compressed; empty where that gains nothing
    digest: str
    media_type: str


class StaticCache:
    """The files below one folder. Not for large ones: each that was asked for stays in memory."""

    def __init__(self, root: Path) -> None:
        self._root = root.resolve()
        self._kept: dict[str, _Kept] = {}

    def response(self, name: str, request: Request | None = None, status: int = 200) -> Response | None:
        """The file as a response, "not modified" where the browser has it; None when there is no such file."""
        try:
            path = (self._root / name).resolve()
            found = path.stat() if path.is_relative_to(self._root) and path.is_file() else None
            kept = None if found is None else self._read(path, (found.st_mtime_ns, found.st_size))
        except (OSError, ValueError):  # a name too long, a NUL in it, or a file that was just deleted
            return None
        if kept is None:
            return None
        packed = request is not None and kept.packed and GZIP.search(request.headers.get("accept-encoding", ""))
        headers = {**HEADERS, "etag": f'"{kept.digest}{"-gzip" if packed else ""}"'}
        if request is not None and headers["etag"] in request.headers.get("if-none-match", ""):
            return Response(status_code=304, headers=headers)
        if packed:
            headers["content-encoding"] = "gzip"
        return Response(kept.packed if packed else kept.body, status, headers, kept.media_type)

    def _read(self, path: Path, stamp: tuple[int, int]) -> _Kept:
        kept = self._kept.get(str(path))
        if kept is None or kept.stamp != stamp:
            body = with_preloads(path.read_bytes(), self._root) if path.suffix == ".html" else path.read_bytes()
            media_type = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
            kept = _Kept(stamp, body, _packed(body, media_type), hashlib.sha256(body).hexdigest()[:24], media_type)
            self._kept[str(path)] = kept
        return kept


def _packed(body: bytes, media_type: str) -> bytes:
    """Compressed, always to the same bytes; empty for what is small or no text."""
    return gzip.compress(body, mtime=0) if len(body) >= SMALLEST and media_type.startswith(TEXTS) else b""

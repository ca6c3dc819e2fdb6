"""The server's log: as lines or as JSON, without control characters, and never flooded by one kind of message."""

import ipaddress
import json
import logging
import re
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, Literal, TextIO

from movingout.maps.files import terminal
from movingout.server.connection.token_bucket import TokenBucket

LogFormat = Literal["text", "json"]
PER_MINUTE = 10  # messages of one kind, in bursts of twice as many
MOST_KINDS = 500
LONGEST = 2000  # letters of a message
_LEFT_OUT = "left_out"  # attribute of a record: how many like it were left out before it


class RateLimit(logging.Filter):
    """Lets so many messages of one kind pass: one logger, one level, one template."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._buckets: dict[tuple[str, int, str], tuple[TokenBucket, list[int]]] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        key = record.name, record.levelno, _template(record)
        if key not in self._buckets:
            if len(self._buckets) >= MOST_KINDS:
                del self._buckets[next(iter(self._buckets))]
            self._buckets[key] = TokenBucket(PER_MINUTE / 60.0, 2.0 * PER_MINUTE, self._clock()), [0]
        bucket, left_out = self._buckets[key]
        if not bucket.take(self._clock()):
            left_out[0] += 1
            return False
        setattr(record, _LEFT_OUT, left_out[0])
        left_out[0] = 0
        return True


def _template(record: logging.LogRecord) -> str:
    """asyncio has none: of its texts, what comes before the first object, which is named by its address."""
    text = str(record.msg)[:200]
    return re.split(r"[\n<(]", text, maxsplit=1)[0] if record.name == "asyncio" else text


class CleanFormatter(logging.Formatter):
    """Of tracebacks each line is made printable: the text of an exception may come from strangers."""

    def formatException(self, ei: Any) -> str:
        return "\n".join(_clean(line) for line in super().formatException(ei).split("\n"))


class TextFormatter(CleanFormatter):
    """One line per message, but for tracebacks."""

    def __init__(self) -> None:
        super().__init__("%(levelname)s %(name)s: %(message)s")

    def formatMessage(self, record: logging.LogRecord) -> str:
        left_out = getattr(record, _LEFT_OUT, 0)
        tail = f" ({left_out} more like this were left out)" if left_out else ""
        return f"{record.levelname} {record.name}: {printable(record.message)}{tail}"


class JsonFormatter(CleanFormatter):
    """One JSON object per line: at, level, logger, message, left_out, exception."""

    def format(self, record: logging.LogRecord) -> str:
        row: dict[str, object] = {
            "at": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": printable(record.getMessage()),
        }
        if left_out := getattr(record, _LEFT_OUT, 0):
            row["left_out"] = left_out
        if record.exc_info:
            row["exception"] = self.formatException(record.exc_info)
        return json.dumps(row, ensure_ascii=False)


def printable(text: str) -> str:
    """Without what a terminal would obey and without network addresses, which are personal data; at most so long."""
    return _clean(text.strip())


def _clean(line: str) -> str:
    return _IPV4.sub("[address]", _LIKE_IPV6.sub(_without_ipv6, terminal.printable(line[:LONGEST])))


_IPV4 = re.compile(r"(?<![\d.])(?!127\.0\.0\.1|0\.0\.0\.0)(?:\d{1,3}\.){3}\d{1,3}(?!\.?\d)")
_LIKE_IPV6 = re.compile(r"(?<!\w)[0-9A-Fa-f:.]{3,}")  # a time of day as well


def _without_ipv6(match: re.Match[str]) -> str:
    """A dot or colons beside an address belong to the sentence; this machine's own stays, as that of IPv4 does.

    Of one with a port, or behind a word that could be a part of it, nothing stays.
    """
    text = match[0]
    run = text.rstrip(":.")
    behind = run.partition(":")[2]
    cut = run.rpartition(":")[0], behind, behind.rpartition(":")[0]
    for address in (text, text.rstrip("."), run, text.strip(":."), *cut):
        try:
            found = ipaddress.IPv6Address(address)
        except ValueError:
            continue
        own = found.is_unspecified or (found.ipv4_mapped or found).is_loopback
        return text if own else text.replace(run if address in cut else address, "[address]")
    return text


def log_to(stream: TextIO | None = None, form: LogFormat = "text") -> None:
    """From now on, warnings and errors of this process go to `stream` (standard error)."""
    handler = logging.StreamHandler(stream or sys.stderr)
    handler.setFormatter(JsonFormatter() if form == "json" else TextFormatter())
    handler.addFilter(RateLimit())
    logging.basicConfig(level=logging.WARNING, handlers=[handler], force=True)
    for name in ("uvicorn", "uvicorn.error", "uvicorn.access"):  # its own handlers would print everything once more
        logging.getLogger(name).handlers.clear()
        logging.getLogger(name).propagate = True

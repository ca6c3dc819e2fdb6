"""The error of a refused HTTP request."""

from typing import Any

from movingout.maps.errors import MovingOutError
from movingout.server.notices import ErrorCode
from movingout.server.persistence.work_process import ReadersBusy


class ApiError(Exception):
    """A request that cannot be served; becomes {"error": {"code", "message", "values"}}.

    `retry_s`: after how many seconds it may be served, 0 where nothing is known.
    """

    def __init__(self, status: int, code: ErrorCode, message: str, *, retry_s: int = 0, **values: Any) -> None:
        super().__init__(message)
        self.status = status
        self.code = code
        self.headers = {"retry-after": str(retry_s)} if retry_s else None
        self.values = values

    def as_json(self) -> dict[str, Any]:
        return error_json(self.code, str(self), self.values)


def unreadable(error: MovingOutError, status: int, code: ErrorCode, message: str = "") -> ApiError:
    """What to answer where a recording cannot be had: that it is so, or that it is so for a minute."""
    if isinstance(error, ReadersBusy):
        return ApiError(503, "readers_busy", str(error), retry_s=60)
    return ApiError(status, code, message or str(error))


def error_json(code: ErrorCode, message: str, values: dict[str, Any] | None = None) -> dict[str, Any]:
    """The body of a refusal: `code` and `values` for pages, `message` in English for programs."""
    return {"error": {"code": code, "message": message, "values": values or {}}}

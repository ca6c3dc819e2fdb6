"""The error of a refused HTTP request."""

from typing import Any

from movingout.server.notices import ErrorCode


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


def error_json(code: ErrorCode, message: str, values: dict[str, Any] | None = None) -> dict[str, Any]:
    """The body of a refusal: `code` and `values` for pages, `message` in English for programs."""
    return {"error": {"code": code, "message": message, "values": values or {}}}

"""How a request is refused over HTTP."""


class ApiError(Exception):
    """A request that cannot be served; becomes {"error": {"code", "message"}}."""

    def __init__(self, status: int, code: str, message: str) -> None:
        super().__init__(message)
        self.status = status
        self.code = code

"""How much of one HTTP request has come, and how much may: Uvicorn alone would keep every byte."""

from dataclasses import dataclass

URL_BYTES = 4 * 1024
HEAD_BYTES = 16 * 1024  # of a request, without its body
NODE_BYTES = 256 * 1024  # of the longest body that is announced: what nodes of a cluster tell each other


@dataclass
class RequestSize:
    """The bytes of one request as they come; `body_bytes` is the limit of settings on those of a body."""

    body_bytes: int
    head_is_whole: bool = False
    _head: int = 0  # received since the request began, while its head is not whole
    _headers: int = 0  # names and values received so far
    _later: int = 0  # received since the head was whole
    _announced: int = 0  # of the body

    def add_data(self, size: int) -> None:
        """`size` bytes have come, after the parser was given them."""
        if self.head_is_whole:
            self._later += size
        else:
            self._head += size

    def add_header(self, name: bytes, value: bytes) -> None:
        """A whole header, of the head or of the trailer."""
        self._headers += len(name) + len(value)
        if not self.head_is_whole and name.lower() == b"content-length" and value.isdigit():
            self._announced = int(value)

    @property
    def head_too_large(self) -> bool:
        return self._head > HEAD_BYTES

    @property
    def headers_too_large(self) -> bool:
        return self._headers > HEAD_BYTES

    @property
    def too_much_later(self) -> bool:
        """Of a body in small chunks, the trailer, and what is no request: also of a body that no route reads."""
        return self._later > 2 * self.body_bytes + HEAD_BYTES + min(self._announced, NODE_BYTES)

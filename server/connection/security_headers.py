"""What browsers may do with answers: the headers that every one of this server has, whoever gives it."""

from movingout.server.connection.origin import Headers

FIXED = (
    (b"x-content-type-options", b"nosniff"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"permissions-policy", b"camera=(), microphone=(), geolocation=(), gamepad=(self)"),
)
NO_STORE = (b"cache-control", b"no-store")  # codes, seats and tokens: the next person at this machine reads none
REFERRER = (b"referrer-policy", b"same-origin")
OF_REFUSALS = (
    *FIXED,
    NO_STORE,
    REFERRER,
    (b"content-security-policy", b"default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"),
)
"""Of what is answered before there is an application: no page that needs anything."""


def plain_refusal(status: str, text: str, more: Headers) -> bytes:
    """A whole answer in plain text, after which the connection is closed: status as in `400 Bad Request`.

    `more` are headers such as the date. `text` is ASCII.
    """
    body = text.encode("ascii")
    headers = (
        *more,
        (b"content-type", b"text/plain; charset=utf-8"),
        (b"content-length", str(len(body)).encode()),
        (b"connection", b"close"),
        *OF_REFUSALS,
    )
    lines = [f"HTTP/1.1 {status}".encode(), *(name + b": " + value for name, value in headers)]
    return b"\r\n".join([*lines, b"", body])

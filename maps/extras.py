"""Optional libraries: what needs which extra of the package, and the command that installs it."""

import contextlib
from collections.abc import Iterator

from movingout.maps.errors import MovingOutError

DISTRIBUTION = "moving-out-live"


class MissingExtraError(MovingOutError):
    """Something was asked for that needs an extra which is not installed."""

    def __init__(self, extra: str, what: str) -> None:
        """`what` is the subject of the sentence: "training", "the 3D viewer"."""
        super().__init__(f"{what} needs the extra `{extra}`; install it with: pip install '{DISTRIBUTION}[{extra}]'")


@contextlib.contextmanager
def needs_extra(extra: str, what: str) -> Iterator[None]:
    """Imports of optional libraries stand in this block: MissingExtraError instead of ImportError.

    A missing module of our own stays the error that it is.
    """
    try:
        yield
    except ImportError as error:
        if (error.name or "").partition(".")[0] == "movingout":
            raise
        raise MissingExtraError(extra, what) from error

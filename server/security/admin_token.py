"""The admin token of a data folder: made at the first start and kept, so that open pages survive a restart."""

from pathlib import Path

from movingout.server.security.kept_secret import kept_secret

NAME = "admin-token"


def kept_token(data: Path) -> str:
    """The token of this folder. Raises OSError."""
    return kept_secret(data / NAME)

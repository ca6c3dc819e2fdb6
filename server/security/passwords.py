"""Passwords on the command line, where everybody on the machine can read them."""

import argparse
import sys
from urllib.parse import parse_qs, urlsplit

OPTIONS = ("database", "identities", "cluster")  # that take the address of a database, in any command
PASSWORD_SEEN = (
    "movingout: everybody on this machine can read the password of the database in the list of processes; "
    "leave it out of the address, and set PGPASSWORD or use ~/.pgpass"
)


def warn_of_passwords(args: argparse.Namespace) -> None:
    """Say so once, whatever the command."""
    if any(_has_password(getattr(args, option, None)) for option in OPTIONS):
        print(PASSWORD_SEEN, file=sys.stderr)


def _has_password(address: object) -> bool:
    if not isinstance(address, str):
        return False
    try:
        parts = urlsplit(address)
        return bool(parts.password) or "password" in parse_qs(parts.query)
    except ValueError:  # it is no address, which is said later
        return False

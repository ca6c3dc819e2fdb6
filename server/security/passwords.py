"""Passwords on the command line, where everybody on the machine can read them."""

import argparse
from urllib.parse import parse_qs, urlsplit

OPTIONS = ("database", "identities", "cluster")  # that take the address of a database, in any command
PASSWORD_SEEN = (
    "movingout: everybody on this machine can read the password of the database in the list of processes; "
    "leave it out of the address, and set PGPASSWORD or use ~/.pgpass"
)


def password_warning(args: argparse.Namespace) -> str:
    """What to tell whoever has given one, whatever the command; empty where there is none."""
    return PASSWORD_SEEN if any(_has_password(getattr(args, option, None)) for option in OPTIONS) else ""


def _has_password(address: object) -> bool:
    if not isinstance(address, str):
        return False
    try:
        parts = urlsplit(address)
        return bool(parts.password) or "password" in parse_qs(parts.query)
    except ValueError:  # it is no address, which is said later
        return False

"""SIGUSR1, which drains a server: held back until there is one, since by default it ends a process."""

import signal

DRAIN = getattr(signal, "SIGUSR1", None)  # none on Windows
SERVERS = (["play"], ["study", "serve"])  # the commands that take it


def hold_back(arguments: list[str]) -> None:
    """Of a command that serves; processes that it starts meanwhile never get the signal."""
    if DRAIN is not None and any(arguments[: len(words)] == words for words in SERVERS):
        signal.pthread_sigmask(signal.SIG_BLOCK, [DRAIN])


def let_in() -> None:
    """From now on, and what came before as well."""
    if DRAIN is not None:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [DRAIN])

"""The experimenter's notes, as the dashboard shows them."""

from collections.abc import Collection
from time import time
from typing import Any

from movingout.server.study.databases import StudyDatabases
from movingout.server.study.participants import Participants
from movingout.study.store.database import NUL
from movingout.study.store.tables import notes


class ExperimenterNotes:
    """All notes of a study, the newest first."""

    def __init__(self, databases: StudyDatabases, participants: Participants) -> None:
        self._databases = databases
        self._participants = participants
        self._notes: list[dict[str, Any]] = []

    async def restore(self) -> None:
        """Read them from the database, after the participants."""
        for row in await self._databases.run(self._databases.store.rows, notes):
            pid, text = self._about(row["text"]) if row["unit"] is None else (None, row["text"])
            self._insert(row["at_ms"] / 1e3, text, self._members(row["unit"]) or pid)

    async def add(self, text: str, unit: int | None, pid: str | None) -> None:
        """A note on a unit, on a participant who has no unit yet, or on the whole study."""
        text = text.replace(NUL, "")
        # without a unit the text itself says whom it is about: it is deleted with their data
        await self._databases.run(self._databases.store.note, text if unit or not pid else f"{pid}: {text}", unit)
        self._insert(time(), text, self._members(unit) or pid)

    def forget(self, pids: Collection[str]) -> None:
        """Show no note on these participants or their units any more, as the database has none."""
        self._notes = [one for one in self._notes if not any(pid in f"{one['pid']} {one['text']}" for pid in pids)]

    def to_json(self) -> list[dict[str, Any]]:
        return self._notes

    def _insert(self, at: float, text: str, pid: str | None) -> None:
        self._notes.insert(0, {"at": at, "text": text, "pid": pid})

    def _about(self, stored: str) -> tuple[str | None, str]:
        """The participant that a stored text begins with, and the rest of it."""
        pid, _, text = stored.partition(": ")
        return (pid, text) if text and self._participants.get(pid) else (None, stored)

    def _members(self, unit: int | None) -> str | None:
        pids = [session.pid for session in self._participants if unit and session.record.unit == unit]
        return " and ".join(pids) or None

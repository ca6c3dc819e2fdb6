"""What the experimenter can do to a running study. Everything is kept in the audit or beside the data."""

from time import time
from typing import Any

import msgspec

from movingout.server.study.participant_session import Guest
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.session_service import Reception
from movingout.server.study.unit import Crew
from movingout.study.errors import StudyError

PAYMENT_COLUMNS = ("source", "id", "pid", "outcome", "code", "minutes", "amount", "currency", "data_kept")


class Order(msgspec.Struct):
    """The body of what the experimenter asks for: about whom, and why."""

    pid: str | None = None
    unit: int | None = None
    episode: str | None = None
    reason: str = ""
    text: str = ""


class Experimenter:
    """The actions of the experimenter's screen."""

    def __init__(self, running: RunningStudy, reception: Reception) -> None:
        self._running = running
        self._reception = reception

    async def pause(self, order: Order) -> None:
        """Stop the clock of one unit, or of everybody."""
        await self._set_paused(order, True)

    async def resume(self, order: Order) -> None:
        await self._set_paused(order, False)

    async def _set_paused(self, order: Order, paused: bool) -> None:
        running = self._running
        async with running.lock:
            crew = self._crew(order) if order.pid or order.unit is not None else None
            await self._audit("pause" if paused else "resume", order)
            await running.pause(paused, crew)

    async def restart_round(self, order: Order) -> None:
        """The running round does not count; it is played again from its map card."""
        running = self._running
        async with running.lock:
            crew = self._crew(order)
            if crew.game is None:
                raise StudyError("no round is running there now")
            await self._audit("restart-round", order)
            running.playing.close(crew, "The experimenter starts this round again.")
            await running.playing.write_down(crew)

    async def kick(self, order: Order) -> None:
        """The study ends for a participant, who gets a code."""
        async with self._running.lock:
            guest = self._guest(order)
            await self._audit("kick", order)
            await self._running.dismiss(guest, "withdrew")

    async def invalid(self, order: Order) -> None:
        """A round does not count."""
        episode = order.episode or self._crew(order).episode
        if not episode:
            raise StudyError("they have not played a round yet")
        await self._running.run(self._running.records.rounds.mark, episode, False, order.reason)

    async def note(self, order: Order) -> None:
        """Something to remember, of a participant or of the whole study."""
        running, text = self._running, (order.text or order.reason).strip()
        if not text:
            raise StudyError("a note says something")
        unit = order.unit if order.unit is not None else self._guest(order).place.unit if order.pid else None
        pids = [guest.pid for guest in running.guests.values() if unit is not None and guest.place.unit == unit]
        if order.unit is not None and not pids:
            raise StudyError(f"there is no unit {order.unit} here")
        await running.run(running.records.store.note, text, unit)
        running.notes.insert(0, {"at": time(), "text": text, "pid": " and ".join(pids) or order.pid})

    async def open_next(self, order: Order) -> dict[str, str]:
        """A code for whoever comes next, and the link with it."""
        code = await self._reception.new_code()
        await self._audit("open-next", order)
        return {"code": code, "path": f"/study?code={code}"}

    async def payments(self) -> list[dict[str, Any]]:
        """One row for each who has a code: who they are where they were recruited, and what their time is worth."""
        running = self._running
        known = await running.run(running.records.identities.everybody)
        await running.run(running.records.store.audit, "experimenter", "payments")
        rows = []
        for guest in running.guests.values():
            if guest.place.code is None:
                continue
            source, external_id = known.get(guest.pid, ("", ""))
            worth = running.worth(guest) or {"minutes": "", "amount": "", "currency": ""}
            about = {"source": source, "id": _plain(external_id), "pid": guest.pid, "outcome": guest.place.outcome}
            rows.append({**about, "code": guest.place.code, **worth, "data_kept": guest.place.keep is not False})
        return rows

    async def _audit(self, action: str, order: Order) -> None:
        """The reason may say who it was: it goes beside the data, as a note, and not into the audit."""
        running = self._running
        unit = {} if order.unit is None else {"unit": order.unit}
        await running.run(running.records.store.audit, "experimenter", action, order.pid or "", **unit)
        if order.reason.strip():
            reason = f"{action}: {order.reason.strip()}"
            await self.note(Order(pid=order.pid, unit=order.unit, text=reason))

    def _guest(self, order: Order) -> Guest:
        guest = self._running.guests.get(order.pid or "")
        if guest is None:
            raise StudyError(f"there is no participant {order.pid!r} here")
        return guest

    def _crew(self, order: Order) -> Crew:
        """Whom an order is about. Raises StudyError when they do not play (yet)."""
        unit = self._guest(order).place.unit if order.pid else order.unit
        crew = self._running.crews.get(-1 if unit is None else unit)
        if crew is None:
            raise StudyError("they have not come as far as the game, or have finished")
        return crew


def _plain(text: str) -> str:
    """What came in a link is no formula for a spreadsheet."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@", "\t", "\r") else text

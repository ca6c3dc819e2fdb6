"""A participant as the running server knows them: their record in the database, their steps, and who is present now.

Nothing here needs to outlive the server.
"""

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from math import inf
from typing import Any

from movingout.study.design.definition import NOTICED_S
from movingout.study.design.step_order import LAST_SOLO_STEP, WAITING
from movingout.study.design.steps import Step
from movingout.study.store.store import Participant

UNPAID_S = 300.0  # a longer absence is not paid
HIDDEN_S = 75.0  # a hidden tab asks once a minute, while its stream stays open
Listener = Callable[[dict[str, Any]], None]


@dataclass(eq=False)
class ParticipantSession:
    """One participant."""

    record: Participant
    steps: tuple[Step, ...]
    last_seen_at: float  # seconds of the monotonic clock
    step_since: float  # when the current step was reached
    present_since: float = -inf  # when a page of theirs was opened after none was, on the same clock
    waits_since: float = -inf  # when they came back to a partner who was gone, as was last found, on the same clock
    source: str = ""  # who recruited them, as in arrival_link.py
    rtt_ms: float = -1.0
    device: str = ""  # of the input check; empty after a restart
    refused: str = ""  # why the input check was not passed
    consented: bool = False  # whether the database has their consent; the move to the next step may have failed
    declined: bool = False
    texts_since_ms: int = 0  # their page is shown no text that was written before
    resumed_at: float = -inf  # when the experimenter's last pause ended for them, on the same clock
    any_device: bool = False  # whether they may come back in another browser, once
    absence_told: bool = True  # whether the experimenter knows that they are away; who has not come back yet is no news
    unpaid_s: float = 0.0  # absences that have ended, also with a pause, and that are not in the database yet
    unpaid_until: float = -inf  # when a pause began in a long absence, which is in `unpaid_s` up to then
    away_before_s: float = 0.0  # of an absence that began before the server started or slept, what lies before that
    heard: bool = False  # a page of theirs was heard since that was last noted in the database
    ended_at: float = 0.0  # when they were given their code, on the same clock; 0 before a restart
    listeners: list[Listener] = field(default_factory=list)  # the event streams of the pages that are open

    @property
    def pid(self) -> str:
        return self.record.pid

    @property
    def finished(self) -> bool:
        return self.declined or self.record.code is not None

    @property
    def step(self) -> Step | None:
        """The current step; None in the waiting room."""
        return next((step for step in self.steps if step.key == self.record.step), None)

    @property
    def has_consented(self) -> bool:
        """Whether they have agreed: they are past the first screen then, unless a database error came between."""
        return self.consented or not self.at_consent

    @property
    def at_consent(self) -> bool:
        """Whether they are at the first screen, which asks for their consent."""
        return self.record.step == self.steps[0].key

    @property
    def before_unit_steps(self) -> bool:
        """Whether they have not reached the first step of their unit yet."""
        return self.record.step in (LAST_SOLO_STEP, WAITING) and not self.finished

    def steps_done(self) -> int:
        if self.finished:
            return len(self.steps)
        keys = [step.key for step in self.steps]
        return keys.index(LAST_SOLO_STEP) + 1 if self.record.step == WAITING else keys.index(self.record.step)

    def has_rounds_left(self, over: Collection[str] = ()) -> bool:
        """Whether rounds or the practice are still to come; in blocks that are `over`, none but the current one is."""
        return any(
            step.kind in ("practice", "round") and (step.block not in over or step.key == self.record.step)
            for step in self.steps[self.steps_done() :]
        )

    def present(self, now: float) -> bool:
        """Whether a page of theirs is open, be it hidden behind another tab."""
        return now - self.last_seen_at < (HIDDEN_S if self.listeners else NOTICED_S)

    def absent_s(self, now: float) -> float:
        """For how long no page of theirs was heard, since the last pause: a pause is no absence."""
        return now - max(self.last_seen_at, self.resumed_at) + self.away_before_s

    def seen(self, now: float, paused: bool) -> None:
        """A page of theirs is open. The absence that ends with it is not paid where it was long, and no pause."""
        if not paused:
            self._note_absence(now)
        if not self.present(now):
            self.present_since = now
        self.last_seen_at = now
        self.heard = True

    def slept(self, seconds: float, now: float) -> None:
        """The server slept for so long: an absence, as a stop of it is. Who has not come back yet is no news.

        Whoever was here has as long to come back as after a stop.
        """
        self.away_before_s += seconds
        self.absence_told = True
        if self.present(now):
            self.away_before_s += now - max(self.last_seen_at, self.resumed_at)
            self.last_seen_at = now

    def pause_begins(self, now: float) -> None:
        """A pause is no absence, and ends the one that it begins in, wherever they come back."""
        if self._note_absence(now):
            self.unpaid_until = now

    def _note_absence(self, now: float) -> bool:
        """Whether an absence that ends now is not paid."""
        absent_s = self.absent_s(now)
        unpaid = absent_s > UNPAID_S and not self.finished
        self.unpaid_s += absent_s if unpaid else 0.0
        self.away_before_s = 0.0
        return unpaid

    def away_s(self, now: float) -> float:
        """For how long they have been away, without what is in `unpaid_s` already; 0 for who is here."""
        return 0.0 if self._is_heard(now) else min(self.absent_s(now), now - self.unpaid_until + self.away_before_s)

    def _is_heard(self, now: float) -> bool:
        """Whether they are present, and not only because everybody counts as present after a start of the server."""
        return self.present(now) and not self.away_before_s

    def is_gone(self, now: float, after_s: float) -> bool:
        """Whether they closed their page longer ago than a partner has to wait; after a start they may come back."""
        return not self.present(now) and self.absent_s(now) > after_s

    def stayed_away(self, now: float, after_s: float) -> bool:
        """Whether who is ended now had gone longer ago than that, be it before the server started."""
        return not self._is_heard(now) and self.absent_s(now) > after_s

    def has_waited(self, now: float, for_s: float, partner: "ParticipantSession") -> bool:
        """Whether they are here and have waited for a partner who is gone: they may have been away, too.

        Who looks in now and then, as a hidden tab does, waits on in between.
        """
        if partner.present(self.waits_since):  # that was before the partner left
            self.waits_since = self.present_since
        return self.present(now) and now - self.waits_since > for_s


def notify(sessions: Iterable[ParticipantSession]) -> None:
    """Tell their open pages to ask for the view again."""
    for session in sessions:
        for listener in list(session.listeners):
            listener({"changed": True})

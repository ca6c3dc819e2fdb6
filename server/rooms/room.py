"""A room: two seats, a series of maps, and what may happen when; its phases are the table of phases.py.

Pure and synchronous: nothing here awaits, sleeps or reads a clock; times (seconds of the server's monotonic clock)
are arguments, and everything else comes in as `Services`. `tick` computes ahead: at time T it takes the
inputs, steps the world to T + 100 ms at once, and sends what will be seen until then.
"""

import math

from movingout.maps.errors import MovingOutError
from movingout.recordings import EpisodeWriter
from movingout.recordings.episode import FINISHED, Episode, Outcome
from movingout.server import messages as m
from movingout.server.frames import Beat, Input
from movingout.server.notices import NOTHING, Notice
from movingout.server.rooms import room_notices as notices
from movingout.server.rooms import time_limits as limits
from movingout.server.rooms.pause import RoundPause, give_up, play_on
from movingout.server.rooms.phases import BETWEEN_ROUNDS, IN_ROUND, PhaseEvent, next_phase, possible
from movingout.server.rooms.round_series import AT_THE_START, RoomProgress, RoundSeries
from movingout.server.rooms.rounds.round import TickTiming
from movingout.server.rooms.seat import ClientHandle, Seat
from movingout.server.rooms.seat_assignment import SeatAssignment
from movingout.server.rooms.services import RoomConfig, Services, WrongRequest
from movingout.world import WorldError
from movingout.world.constants import TICK_SECONDS


class Room:
    """One room. Every public method is called from the event loop's thread and returns at once."""

    def __init__(
        self,
        room_id: str,
        config: RoomConfig,
        seats: list[Seat],
        services: Services,
        now: float,
        progress: RoomProgress = AT_THE_START,
    ) -> None:
        self.id = room_id
        self.config = config
        self.seats = seats
        self.phase: m.Phase = progress.phase
        self.notice = progress.notice  # why the room is in its phase
        self.until = 0.0  # when the countdown or the pause ends
        self.missed_ticks = 0
        self.was_joined = progress.joined  # whether anybody ever took a seat, or came where agents have both
        self.held = NOTHING  # why the person who runs a study has stopped the clock
        self._held_next = NOTHING  # why no further round begins
        self.seating = SeatAssignment(room_id, seats, services.new_token, services.new_id, not config.study)
        self._services = services
        self._due = self._announced = self._empty_since = self._over_since = self.unchanged_since = now
        self.series = RoundSeries(config, seats, services, progress, room_id)
        self.round = self.series.prepare()

    # ---- clients --------------------------------------------------------------------------------------------

    def join(self, client: ClientHandle, request: m.Join, now: float) -> m.Welcome:
        """Admit a client, to seats or as a spectator, and send it the state. Raises Refused."""
        taken, replaced = self.seating.join(client, request, now)
        self.was_joined |= bool(taken) or not any(seat.taken_by_client for seat in self.seats)
        if self.phase == "lobby":
            self._call_agents()
        for old in replaced:
            old.dismiss(m.CLOSE_REPLACED, notices.REPLACED)
        welcome = self.seating.welcome(request.mode, taken, self.config)
        client.tell(welcome)
        for message in (*self.series.messages(self.round), self.full_state()):
            client.tell(message)
        if self.series.results and self.phase in BETWEEN_ROUNDS:
            client.tell(self.series.results[-1])
        for grant in taken:
            self.seats[grant.seat].ready |= self.config.tutorial and self.phase == "lobby"  # it begins by itself
            self._returned(self.seats[grant.seat], now)
        self.announce(now)
        self._services.changed(self.id)
        return welcome

    def depart(self, client: ClientHandle, now: float) -> None:
        """A client's connection is gone."""
        dropped = self.seating.depart(client, now)
        if self.phase == "closed":
            return
        for seat in dropped:
            self._dropped(seat, now)
        if not self.seating.clients:
            self._empty_since = now
        self.announce(now)

    def close(self, code: int, notice: Notice, outcome: Outcome = "stopped") -> None:
        """End everything: the round with `outcome`, every connection with `code`."""
        if self.round.started and self.phase in IN_ROUND:
            self._end_round(outcome)
        self._move(PhaseEvent.CLOSED, notice)
        self.seating.dismiss(code, notice)
        self.series.free_agents()

    def resume(self, episode: Episode, writer: EpisodeWriter, until: float) -> None:
        """Resume a round that a crash interrupted; its players have until `until` to return."""
        self.round.resume(episode, writer)
        self._move(PhaseEvent.INTERRUPTED, notices.resumed(self.round.state.tick), until)

    def suspend(self, notice: Notice = notices.RESTARTING) -> None:
        """The server shuts down: a round stays as recorded so far, to be resumed after the restart."""
        self.round.suspend()
        self.seating.dismiss(m.CLOSE_SHUTDOWN, notice)
        self.series.free_agents()

    def take_input(self, client: ClientHandle, frame: Input, now: float) -> None:
        """Take an input for one seat of `client`, and its acknowledgement in any case. Raises WrongRequest."""
        if client.acknowledge(frame.ack_tick, now) and self.round.started:
            client.tell(self.full_state())
        seat = self.seats[frame.seat]
        if seat.client is not client:
            raise WrongRequest("not_your_seat", f"the {seat.colour} seat is not yours")
        if seat.controls.submit(frame, now) and self.phase == "playing":
            self.round.record_input(frame, client.rtt_ms)

    def empty_s(self, now: float) -> float:
        """For how long nobody has been connected, outside of a round; 0 while somebody is."""
        return 0.0 if self.seating.clients or self.phase in IN_ROUND else now - self._empty_since

    # ---- time -----------------------------------------------------------------------------------------------

    def tick(self, now: float, due: float, skipped: int = 0) -> None:
        """Everything that depends on time; called every 100 ms, `skipped` is the number of ticks left out."""
        self._due = due
        self._expire(now)
        self.try_start(now)
        if self.phase == "countdown" and self._may_play(due):
            self._play()
        if self.phase == "playing":
            self.missed_ticks += skipped
            self._step(TickTiming(due, max(0.0, now - due) * 1e3, skipped), now)
        if now - self._announced >= limits.ANNOUNCE_S:
            self.announce(now)

    def beat(self) -> None:
        """Half a tick after a bundle: a few bytes, so that TCP notices a loss sooner."""
        if self.phase == "playing":
            frame = Beat(tick=self.round.state.tick).encode()
            for client in self.seating.clients:
                client.beat(frame)

    def _expire(self, now: float) -> None:
        if self.phase == "paused":
            self.round.pauses.count([] if self.held else self.seats, now)
            if now >= self.until and not self.held and play_on(self.seats):
                self.try_start(now)
            elif now >= self.until:
                self.finish(*give_up(self.seats, self.config.resume_s, self.round.pauses))
        elif self.phase in ("lobby", "round_over"):
            for seat in self.seats:
                if seat.token is not None and not seat.present and now - seat.absent_since >= self.config.resume_s:
                    self._give_seat_up(seat)
        if self.seating.clients:
            return
        if self.phase == "lobby" and now - self._empty_since >= limits.AGENTS_WAIT_S:
            self.series.free_agents()  # others may need them; they come back with the first client
        unjoined_s = limits.INVITED_S if any(seat.shared for seat in self.seats) else limits.UNJOINED_S
        if now - self._empty_since >= (limits.EMPTY_S if self.was_joined or self.config.study else unjoined_s):
            self.close(m.CLOSE_ROOM_OVER, notices.NOBODY_HERE)

    def _give_seat_up(self, seat: Seat) -> None:
        """A player has been away too long between rounds."""
        if self.phase == "lobby" and seat.shared:
            seat.vacate()
            self._services.changed(self.id)
        elif self.phase == "round_over":
            seat.gone = True
            self.enter(PhaseEvent.SERIES_ENDED, notices.about("not_back", [seat], "did not come back."))

    def _step(self, timing: TickTiming, now: float) -> None:
        try:
            bundle = self.round.step(self.seats, now, timing)
        except WorldError as error:
            self.finish("error", Notice("simulation_failed", f"The simulated world failed: {error}"))
            return
        for client in self.seating.clients:
            client.show(self.round.state.tick, bundle, now)
        if learned := self.round.learned():
            self.seating.tell(learned)
        if (outcome := self.round.outcome()) is None:
            self.round.ask_agents(self.seats, timing.due + TICK_SECONDS)
        else:
            self.finish(outcome, NOTHING)

    # ---- from phase to phase --------------------------------------------------------------------------------

    def _call_agents(self) -> None:
        """A client has joined: the agents are needed."""
        try:
            self.series.seat_agents(self.round)
        except MovingOutError as error:  # other rooms have them all now
            self.enter(PhaseEvent.SERIES_ENDED, Notice("cannot_start", str(error)))

    def try_start(self, now: float) -> None:
        """Start the countdown when everybody is ready, and no `hold` or `hold_next` stands against it."""
        self.hold_next(self._held_next)
        if self.held or not possible(self.phase, PhaseEvent.ALL_READY) or not self.seating.clients:
            return
        if not all(seat.is_ready and not seat.gone for seat in self.seats):
            return
        if self.phase in BETWEEN_ROUNDS and not self._next_round(now):
            return
        countdown_s = min(self.config.countdown_s, limits.PRACTICE_COUNTDOWN_S if self.config.practice else math.inf)
        notice = notices.agent_notice(self.seats, with_cautions=not self.round.started and not self.config.study)
        self.enter(PhaseEvent.ALL_READY, notice, self._due + TICK_SECONDS + countdown_s)
        self.round.ask_agents(self.seats, self.until)

    def _next_round(self, now: float) -> bool:
        """Prepare the map that follows, or the same one when somebody asked for it; False to wait."""
        people = [seat for seat in self.seats if seat.taken_by_client]
        again = any(seat.wants_again for seat in people)
        shown = not people and now - self._over_since < limits.SHOW_RESULT_S
        try:
            if shown or (self.phase == "series_over" and not again) or not self.series.map_is_ready(again):
                return False
            self.round = self.series.follow(again)
        except MovingOutError as error:  # the map has no variant, or no worker has time for the agent any more
            self.enter(PhaseEvent.SERIES_ENDED, Notice("cannot_start", str(error)))
            return False
        for message in (*self.series.messages(self.round), self.full_state()):
            self.seating.tell(message)
        return True

    def _may_play(self, due: float) -> bool:
        """Whether the countdown is over and no agent is still loading (waits at most AGENT_PATIENCE_S for one)."""
        late = due >= self.until + limits.AGENT_PATIENCE_S
        return late or (due >= self.until - limits.EARLY_S and all(seat.is_ready for seat in self.seats))

    def _play(self) -> None:
        if self.round.started:
            self.round.note("resume")
        else:
            self.series.begin(self.round)
        for seat in self.seats:
            seat.controls.release()
            if seat.client is not None and seat.controls.newest is not None:  # it came while nothing was recorded
                self.round.record_input(seat.controls.newest, seat.rtt_ms)
        self.round.note_focus(self.seats)
        self.enter(PhaseEvent.START, NOTHING)

    def finish(self, outcome: Outcome, notice: Notice) -> None:
        """The round is over: announce the result and finish the recording. Raises PhaseError outside of a round."""
        self._end_round(outcome)
        self._over_since = self._due
        for seat in self.seats:
            seat.ready = False
        goes_on = self.series.more and outcome in FINISHED
        self.enter(PhaseEvent.ROUND_ENDED if goes_on else PhaseEvent.SERIES_ENDED, notice)

    def _end_round(self, outcome: Outcome) -> None:
        self.seating.tell(result := self.series.end(self.round, outcome))
        self._services.ended(self.id, self.round.episode_id, result)

    def _move(self, event: PhaseEvent, notice: Notice, until: float = 0.0) -> None:
        """Change to the phase that follows. Raises PhaseError when the event cannot happen now."""
        self.phase, self.notice, self.until = next_phase(self.phase, event), notice, until
        self.unchanged_since = self._due

    def enter(self, event: PhaseEvent, notice: Notice, until: float = 0.0) -> None:
        """Change the phase and announce it. Raises PhaseError when the event cannot happen now."""
        self._move(event, notice, until)
        self.seating.tell(self.state())
        self._services.changed(self.id)

    # ---- people come and go, and the experimenter stops the clock -------------------------------------------

    def _returned(self, seat: Seat, now: float) -> None:
        if self.phase == "paused":
            self.round.note("return", seat.index)
            self.enter_pause(now)
            self.try_start(now)

    def _dropped(self, seat: Seat, now: float) -> None:
        if self.phase in ("lobby", "round_over", "series_over"):
            seat.ready = False
        elif self.round.started:
            self.round.note_drop(seat, self.seats)
            self.enter_pause(now)
            self._expire(now)
        else:
            seat.ready = False
            self.enter(PhaseEvent.CALLED_OFF, notices.about("lost", [seat], "lost the connection."))

    def enter_pause(self, now: float) -> None:
        """Pause, or stay paused, until everybody is present and ready."""
        waiting = RoundPause.waiting_for(self.seats, self.config.resume_s, self.round.pauses, now)
        pause = RoundPause.held(self.held, now) if self.held else waiting
        self.enter(PhaseEvent.INTERRUPTED, pause.notice, pause.until)

    def hold(self, notice: Notice, now: float) -> None:
        """The experimenter pauses the room; only `release` ends that."""
        self.held = notice
        if self.phase == "playing":
            self.round.note("pause")
        if self.phase in ("playing", "paused") or (self.phase == "countdown" and self.round.started):
            self.enter_pause(now)
        elif self.phase == "countdown":
            self.enter(PhaseEvent.CALLED_OFF, notice)

    def hold_next(self, notice: Notice) -> None:
        """Let no further round begin; one that has begun goes on."""
        self._held_next = notice
        if notice and not self.held and self.phase != "closed" and self.phase not in IN_ROUND:
            self.held = notice
            self.seating.tell(self.state())

    def release(self, now: float) -> None:
        """The experimenter ends the pause: a countdown starts as soon as everybody is present and ready."""
        self.held = NOTHING
        if self.phase == "paused":
            self.enter_pause(now)
        self.try_start(now)

    def focus(self, client: ClientHandle, visible: bool) -> None:
        """A page is hidden, which releases its controls, or visible; while the clock stands it is noted later."""
        for seat in self.seating.seats_of(client):
            seat.show(visible)
        if self.phase == "playing":
            self.round.note_focus(self.seats)

    # ---- what clients see -----------------------------------------------------------------------------------

    def state(self) -> m.RoomState:
        notice = notices.told(self.phase, self.notice, self._held_next, self.seats)
        return m.RoomState(
            phase=self.phase, until_ms=self.until * 1e3, seats=[seat.view() for seat in self.seats],
            spectators=self.seating.spectators, recording=self.recording, reason_code=notice.code,
            reason=notices.reason(notice, bool(self.config.study)), reason_values=notice.values,
        )  # fmt: skip

    @property
    def recording(self) -> bool:
        """Whether this round is or will be recorded."""
        return self.round.is_recorded if self.round.started else self.config.recorded

    def full_state(self) -> m.FullState:
        return self.round.full_state((self._due + TICK_SECONDS * (self.phase == "playing")) * 1e3)

    def announce(self, now: float) -> None:
        """Tell everybody the state, which may have changed within its phase."""
        self._announced = now
        self.seating.tell(self.state())

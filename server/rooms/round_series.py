"""The rounds of a room in order: maps, agents, results."""

import logging
from dataclasses import dataclass

from movingout.recordings import RecordingError
from movingout.recordings.episode import Outcome
from movingout.server import messages as m
from movingout.server.notices import NOTHING, Notice
from movingout.server.rooms.room_notices import recording_problem
from movingout.server.rooms.round import LiveRound
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig, Services

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class RoomProgress:
    """Where a room is in its series: at the beginning, or where a restart found it."""

    index: int = 0  # of the round in the series
    epoch: int = 0  # rounds so far, replays included
    results: tuple[m.Result, ...] = ()
    phase: m.Phase = "lobby"
    notice: Notice = NOTHING  # why it is where it is


AT_THE_START = RoomProgress()


class RoundSeries:
    """Prepares, begins and ends each round of a room. Knows no client, no clock and no phase."""

    def __init__(
        self,
        config: RoomConfig,
        seats: list[Seat],
        services: Services,
        progress: RoomProgress,
    ) -> None:
        self.index = progress.index  # of the round in the series
        self.epoch = progress.epoch  # counts rounds, replays included
        self.results = list(progress.results)
        self._config = config
        self._seats = seats
        self._services = services

    @property
    def more(self) -> bool:
        """Whether another map follows."""
        return self.index + 1 < len(self._config.maps)

    def prepare(self) -> LiveRound:
        """The next round, with its agents loading. Raises MapError and AgentError."""
        self.epoch += 1
        seed = self._config.challenge2_seed
        seed = None if seed is None else seed + self.index
        the_map = self._services.load_map(self._config.maps[self.index], seed, self._config.split)
        the_round = LiveRound(
            map_spec=the_map,
            limit_ticks=self._config.round_ticks,
            epoch=self.epoch,
            episode_id=self._services.new_id(),
            seed=seed or 0,
        )
        self.free_agents()
        self.seat_agents(the_round)
        return the_round

    def seat_agents(self, the_round: LiveRound) -> None:
        """Give every agent seat its player. Raises AgentError when no worker has capacity for another agent."""
        for seat in self._seats:
            if seat.kind in ("agent", "ghost") and seat.player is None:
                seat.player = self._services.agents.open(
                    seat.agent_id, the_round.map, seat.index, the_round.seed, the_round.limit_ticks
                )

    def free_agents(self) -> None:
        for seat in self._seats:
            seat.close_player()

    def begin(self, the_round: LiveRound) -> None:
        """Start a round, and record it unless it is practice."""
        if self._config.practice:
            the_round.begin(None)
            return
        blue, red = self._seats
        header = the_round.header((blue.info(), red.info()), self._services.wall_ns(), self._config.study)
        try:
            the_round.begin(self._services.open_recording(header, the_round.state))
        except RecordingError as error:
            log.error("not recording: %s", error)
            the_round.begin(None, recording_problem(error))
        for seat in self._seats:
            if seat.agent_caution:
                the_round.note("unseen_map", seat.index, detail=seat.agent_caution)

    def end(self, the_round: LiveRound, outcome: Outcome) -> m.Result:
        """End a round and hand its recording over to be finalised."""
        result = the_round.result(self.index, outcome)
        self.results.append(result)
        journal = the_round.finish(outcome)
        if journal is not None:
            self._services.archive(journal)
        self.free_agents()
        return result

    def message(self, the_round: LiveRound) -> m.Round:
        """What clients need to draw a round."""
        return the_round.message(self.index, len(self._config.maps), self._config.practice)

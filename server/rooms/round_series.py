"""The rounds of a room in order: maps, agents, results."""

import logging
from collections import deque
from dataclasses import dataclass

from movingout.agents.built_in import TUTORIAL_PARTNER
from movingout.maps import MapError, MapSpec
from movingout.recordings import RecordingError
from movingout.recordings.episode import Outcome
from movingout.server import messages as m
from movingout.server.notices import NOTHING, Notice
from movingout.server.rooms.room_notices import recording_problem
from movingout.server.rooms.rounds.round import LiveRound
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig, Services
from movingout.server.rooms.tutorial import PARTNER_NAME, TutorialProgress, tutorial_map

log = logging.getLogger(__name__)

KEPT_RESULTS = 50  # "again" has no end, and all of them are written at each change of the room


@dataclass(frozen=True)
class RoomProgress:
    """Where a room is in its series: at the beginning, or where a restart found it."""

    index: int = 0  # of the round in the series
    epoch: int = 0  # rounds so far, replays included
    results: tuple[m.Result, ...] = ()
    phase: m.Phase = "lobby"
    notice: Notice = NOTHING  # why it is where it is
    joined: bool = False  # whether anybody ever came
    next_episode: str = ""  # id of the round that is prepared first, where a study has its row already


AT_THE_START = RoomProgress()


class RoundSeries:
    """Prepares, begins and ends each round of a room. Knows no client, no clock and no phase."""

    def __init__(
        self,
        config: RoomConfig,
        seats: list[Seat],
        services: Services,
        progress: RoomProgress,
        room_id: str,
    ) -> None:
        self.index = progress.index  # of the round in the series
        self.epoch = progress.epoch  # counts rounds, replays included
        self.results = deque(progress.results, KEPT_RESULTS)  # of the newest rounds
        self._config = config
        self._seats = seats
        self._services = services
        self._room_id = room_id
        self._next_episode = progress.next_episode

    @property
    def more(self) -> bool:
        """Whether another map follows."""
        return self.index + 1 < len(self._config.maps)

    def map_is_ready(self, again: bool) -> bool:
        """Whether `follow` has a map at once; otherwise it is being made. Raises MapError where it cannot be."""
        index = self.index + (not again)
        try:
            seed = self._config.variant_seed(index)
            return self._services.map_is_ready(self._config.designed(index), seed, self._config.split)
        except MapError:
            for seat in self._seats:
                seat.wants_again = False  # otherwise the room would try it at each tick
            raise

    def follow(self, again: bool) -> LiveRound:
        """The round of the map that follows, or of the same one again. Raises MapError and AgentError."""
        self.index += not again
        for seat in self._seats:
            seat.wants_again = False
        return self.prepare()

    def prepare(self) -> LiveRound:
        """The next round, with its agents loading. Raises MapError and AgentError."""
        self.epoch += 1
        seed = self._config.variant_seed(self.index)
        the_map, tutorial = self._map(seed), None
        if self._config.tutorial:
            tutorial = TutorialProgress(the_map, self._players)
        episode_id, self._next_episode = self._next_episode or self._services.new_episode_id(self._room_id), ""
        the_round = LiveRound(
            map_spec=the_map,
            limit_ticks=self._config.round_ticks,
            epoch=self.epoch,
            episode_id=episode_id,
            seed=seed or 0,
            tutorial=tutorial,
        )
        self.free_agents()
        self.seat_agents(the_round)
        return the_round

    def _map(self, seed: int | None) -> MapSpec:
        if self._config.tutorial:
            return tutorial_map(self._players)
        return self._services.world_map(self._config.designed(self.index), seed, self._config.split)

    @property
    def _players(self) -> tuple[bool, bool]:
        blue, red = self._seats
        return blue.taken_by_client, red.taken_by_client

    def replace_learner(self, the_round: LiveRound, seat: Seat) -> None:
        """A player has left a tutorial, and its partner takes the seat: the other player may need it. AgentError."""
        if the_round.tutorial is not None:
            the_round.note_skip(seat.index)
            the_round.tutorial.leave(seat.index)
            seat.kind, seat.agent_id, seat.name = "agent", TUTORIAL_PARTNER, PARTNER_NAME
            self.seat_agents(the_round)

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
        """Start a round, and record it unless it is mere practice."""
        if not self._config.recorded:
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

    def messages(self, the_round: LiveRound) -> list[m.ServerMessage]:
        """What clients need to draw a round."""
        drawn = the_round.message(self.index, len(self._config.maps), self._config.practice)
        return [drawn] if the_round.tutorial is None else [drawn, the_round.tutorial.message()]

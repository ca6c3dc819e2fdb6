"""How the room of a round is set up: its map, its rules and its seats."""

import asyncio
from collections.abc import Mapping

from movingout.maps import MapError, MapSpec, map_to_json
from movingout.server.own_maps.solving import TooSlow
from movingout.server.own_maps.workers import Busy
from movingout.server.public_host import PublicHost
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.rooms.tutorial import PARTNER_NAME, partner_seat
from movingout.server.security.tokens import hash_token
from movingout.server.study.unit import StudyUnit
from movingout.study.design.allocation import letters
from movingout.study.design.definition import Study
from movingout.study.design.steps import Step

Variant = tuple[str, str, int]  # block, map and seed


class RoomSetup:
    """The configuration of the rooms of one study. `simulated` participants are marked in the recordings."""

    def __init__(self, study: Study, host: PublicHost, simulated: bool) -> None:
        self._study = study
        self._host = host
        self._names = {"study": study.id, **({"simulated": "yes"} if simulated else {})}  # for recordings
        self._letters = letters(study)
        self._splits = {block.id: block.split for block in study.blocks}
        self._pings = {block.id: block.pings == "on" for block in study.blocks}
        self._unvaried: dict[Variant, str] = {}  # why
        self._too_slow: set[Variant] = set()  # once: the machine may have been busy
        self._making: dict[Variant, asyncio.Task[str]] = {}
        # As they are now: rooms in other processes and on other nodes do not know where the study file lies.
        self._own_maps = {name: map_to_json(study.load_map(name)) for name in study.own_maps}
        self._shown = {name: (str(own["name"]), str(own["title"])) for name, own in self._own_maps.items()}

    async def prepare(self, step: Step) -> str:
        """Make the randomised map of a round ahead, in another process; why it has none, else "". Raises Busy.

        What could not be made is not tried again before the next start; what took too long is, once. All who ask
        meanwhile wait for the same try.
        """
        variant = _variant_of(step)
        if variant is None or variant in self._unvaried:
            return self._why_unvaried(variant)
        if variant not in self._making:
            self._making[variant] = asyncio.create_task(self._make(variant, self.config(step)))
        return await asyncio.shield(self._making[variant])

    async def _make(self, variant: Variant, config: RoomConfig) -> str:
        try:
            await self._host.prepare_maps(config)
        except TooSlow as error:
            if variant not in self._too_slow:
                self._too_slow.add(variant)
                raise Busy(str(error)) from None
            self._unvaried[variant] = str(error)
        except MapError as error:
            self._unvaried[variant] = str(error)
        finally:
            del self._making[variant]
        return self._why_unvaried(variant)

    def _why_unvaried(self, variant: Variant | None) -> str:
        return "" if variant is None else self._unvaried.get(variant, "")

    def map_of(self, step: Step) -> MapSpec:
        """The map of a round or of the practice, after `prepare`; as designed where it has no variant."""
        config = self.config(step)
        if self._why_unvaried(_variant_of(step)):
            return config.designed(0)
        return self._host.prepared_maps.world_map(config.designed(0), config.variant_seed(0), config.split)

    def shown_map(self, name: str) -> tuple[str, str]:
        """Name and title of a map as its rooms show it; of one that the study file names no more, only the name."""
        if name not in self._shown:
            try:
                designed = self._study.load_map(name)
            except MapError:
                self._shown[name] = name, ""
            else:
                self._shown[name] = designed.name, designed.title
        return self._shown[name]

    def config(self, step: Step, unit: StudyUnit | None = None) -> RoomConfig:
        practice, turn = self._study.practice, step.turn
        name = turn.map if turn else practice.map if practice else ""
        return RoomConfig(
            maps=(name,),
            own_maps={name: self._own_maps[name]} if name in self._own_maps else {},
            limit_ticks=step.limit_ticks,
            practice=turn is None,
            tutorial=turn is None and practice is not None and practice.tutorial,
            challenge2_seed=turn.variant_seed if turn else None,
            split=self._splits.get(step.block, "train"),
            countdown_s=self._host.settings.countdown_s,
            resume_s=float(self._study.pairing.return_s),
            pings=self._pings.get(step.block, any(self._pings.values())),  # practised where they will be needed
            study={**self._names, "unit": str(unit.record.id), "step": step.key} if unit else {},
        )

    def seats(self, unit: StudyUnit, step: Step, keys: Mapping[str, str]) -> list[Seat]:
        """Participants with a key under their pseudonyms, agents under their letters.

        In practice the seat of a participant who has finished practising is idle, in a tutorial its partner's.
        """
        seats, tutorial = {}, self.config(step).tutorial
        for session in unit.members:
            index = unit.seat_of(step, session)
            key = keys.get(session.pid)
            human = Seat(index, "human", alias=session.pid, key=hash_token(key)) if key else None
            seats[index] = human or (partner_seat(index) if tutorial else Seat(index, "idle", name="idle"))
        for index in {0, 1} - set(seats):
            if tutorial:
                seats[index] = partner_seat(index)
                continue
            agent = self._agent(step)
            kind = "idle" if agent == "idle" else "agent"
            seats[index] = Seat(index, kind, agent, name=self._letter(step))  # type: ignore[arg-type]
        return [seats[0], seats[1]]

    def blinded(self, step: Step, problem: str) -> str:
        """Why a room cannot be opened, as the experimenter may read it: with the letter in place of the agent's id."""
        return problem.replace(repr(self._agent(step)), self._letter(step))

    def unloaded(self, step: Step) -> str:
        """Likewise, where it is the agent that cannot play."""
        return f"{self._letter(step)} cannot be loaded; the server's log has the reason"

    def _letter(self, step: Step) -> str:
        return self._letters.get(step.partner, PARTNER_NAME)

    def _agent(self, step: Step) -> str:
        """The id of the agent that plays with a participant."""
        if step.partner:
            return self._study.partner(step.partner).agent
        if self._study.group == 1 and self._study.practice:
            return self._study.practice.agent
        return self._study.pairing.agent


def _variant_of(step: Step) -> Variant | None:
    """None for a map as designed."""
    if step.turn is None or step.turn.variant_seed is None:
        return None
    return step.block, step.turn.map, step.turn.variant_seed

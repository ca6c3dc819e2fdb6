"""Train and test split by participant: nobody in a test episode appears in a training episode."""

import hashlib
from collections import defaultdict
from collections.abc import Sequence

from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.episode import SeatInfo
from movingout.recordings.recorded_seat import GHOST
from movingout.recordings.storage.listing import Players

TRAIN, TEST = "train", "test"


def participants(players: Players) -> tuple[str, ...]:
    """The people of an episode, or its agents when no person took part; nobody when names are missing."""
    people = [seat.name for seat in players.seats if seat.kind in ("human", "ghost")]
    return tuple(sorted({name for name in people or [seat.name for seat in players.seats] if name}))


def split(episodes: Sequence[Players], share: float, seed: int = 0) -> list[str]:
    """`train` or `test` for each episode; about `share` of the episodes are for testing.

    People who played together are one group (the paper's pairs), and groups are never divided. The same names and
    seed give the same split. Without names an episode is a group of its own.
    """
    groups = _groups(_unmasked(episodes))
    order = sorted(groups, key=lambda name: hashlib.sha256(f"{seed}:{name}".encode()).digest())
    result = [TRAIN] * len(episodes)
    wanted = round(share * len(episodes))
    taken = 0
    for name in order:
        size = len(groups[name])
        if abs(taken + size - wanted) < abs(taken - wanted):  # only where that comes nearer to the share
            taken += size
            for index in groups[name]:
                result[index] = TEST
    return result


def _unmasked(episodes: Sequence[Players]) -> list[Players]:
    """A replayed seat whose episode is here counts as whoever played it then."""
    played = {
        f"{GHOST}:{players.episode_id}#{colour}": seat
        for players in episodes
        for colour, seat in zip(SEAT_COLOURS, players.seats, strict=True)
    }

    def who(seat: SeatInfo) -> SeatInfo:
        seen = set()
        while seat.kind == GHOST and seat.name in played and seat.name not in seen:  # a replay of a replay
            seen.add(seat.name)
            seat = played[seat.name]
        return seat

    return [Players(players.episode_id, (who(players.seats[0]), who(players.seats[1]))) for players in episodes]


def _groups(episodes: Sequence[Players]) -> dict[str, list[int]]:
    """Episode indices by connected component of people; a component is named by its first name."""
    leader: dict[str, str] = {}

    def find(name: str) -> str:
        while leader.setdefault(name, name) != name:
            name = leader[name]
        return name

    for players in episodes:
        names = participants(players)
        for name in names[1:]:
            one, other = sorted((find(names[0]), find(name)))
            leader[other] = one
    groups: dict[str, list[int]] = defaultdict(list)
    for index, players in enumerate(episodes):
        names = participants(players)
        groups[find(names[0]) if names else f"episode {players.episode_id}"].append(index)
    return groups

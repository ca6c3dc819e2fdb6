"""Train and test split by participant, by episode or by map; what belongs together is on one side."""

import hashlib
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal, get_args

from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.episode import ROOM_PSEUDONYM, SeatInfo, is_person, is_room_pseudonym
from movingout.recordings.errors import RecordingError
from movingout.recordings.recorded_seat import GHOST
from movingout.recordings.storage.listing import Players

TRAIN, TEST = "train", "test"
SplitBy = Literal["participant", "episode", "map"]
SPLIT_BY: tuple[SplitBy, ...] = get_args(SplitBy)


def participants(players: Players) -> tuple[str, ...]:
    """The people of an episode, or its agents when no person took part; nobody when names are missing."""
    people = [seat.name for seat in players.seats if is_person(seat.kind)]
    return tuple(sorted({name for name in people or [seat.name for seat in players.seats] if name}))


def has_people(players: Players) -> bool:
    """Whether a person took part, or is replayed."""
    return any(is_person(seat.kind) for seat in players.seats)


def split(episodes: Sequence[Players], share: float, seed: int = 0, by: SplitBy = "participant") -> list[str]:
    """`train` or `test` for each episode; about `share` of the episodes are for testing.

    By participant nobody in a test episode appears in a training episode; people who played together are one group
    (the paper's pairs). By map no map appears on both sides. Groups are never divided. The same names and seed give
    the same split. Without names an episode is a group of its own.
    """
    groups = components(episodes) if by == "participant" else _plain_groups(episodes, by)
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


def obtained(parts: Sequence[str], wanted: float, by: SplitBy) -> str:
    """A sentence that says how many episodes are for testing, and what to do where that is none."""
    tests = parts.count(TEST)
    share = f"{tests} of {len(parts)} recordings ({tests / max(len(parts), 1):.0%})"
    sentence = f"for testing: {share}; {wanted:.0%} were asked for, split by {by}"
    if tests:
        return sentence
    if len(parts) == 1:
        return f"{sentence}. One recording is never divided"
    if by == "episode" and round(wanted * len(parts)) > 0:
        return f"{sentence}. Episodes that are equal action by action are never divided: ask for a larger share"
    if by == "episode":
        return f"{sentence}. That is less than one recording: ask for a larger share"
    return f"{sentence}. What belongs together is never divided: ask for a larger share, or use another --split-by"


def has_room_names(episodes: Iterable[Players]) -> bool:
    """Whether a person is known by a name that holds for one room alone."""
    seats = (seat for players in episodes for seat in players.seats)
    return any(is_person(seat.kind) and is_room_pseudonym(seat.name) for seat in seats)


def caution(episodes: Sequence[Players], by: SplitBy) -> str:
    """A sentence where a split by participant may have a person on both sides; empty where it has not."""
    if by != "participant" or not has_room_names(episodes):
        return ""
    return (
        f"Names {ROOM_PSEUDONYM}… hold for one room each: somebody who played in several may be in both parts; "
        "only the names of a study keep people apart"
    )


def divided(episodes: Sequence[Players], count: int, seed: int = 0) -> list[int]:
    """The group, from 1 to `count`, of each episode; nobody is in two groups, and people who played together share one.

    People are drawn in an order that depends on the seed and on names alone; each goes to the group that has the fewest
    episodes so far. Raises RecordingError when there are fewer people who never played together than groups.
    """
    found = components(episodes)
    if len(found) < count:
        raise RecordingError(_too_few(found, episodes, count))
    order = sorted(found, key=lambda name: hashlib.sha256(f"{seed}:{name}".encode()).digest())
    result, sizes = [0] * len(episodes), [0] * count
    for name in order:
        group = sizes.index(min(sizes))
        sizes[group] += len(found[name])
        for index in found[name]:
            result[index] = group + 1
    return result


def _too_few(found: Mapping[str, Sequence[int]], episodes: Sequence[Players], count: int) -> str:
    names = sorted({name for players in episodes for name in participants(players)})
    who = f"{len(names)} ({', '.join(names[:4])}{', …' if len(names) > 4 else ''})" if names else "none by name"
    return (
        f"{count} groups need {count} participants or pairs who never played with each other; these recordings have "
        f"{len(found)} (participants: {who}); add recordings of other people"
    )


def _plain_groups(episodes: Sequence[Players], by: SplitBy) -> dict[str, list[int]]:
    groups: dict[str, list[int]] = defaultdict(list)
    for index, players in enumerate(episodes):
        groups[players.map if by == "map" else players.episode_id].append(index)
    return groups


def unmasked(episodes: Sequence[Players]) -> list[Players]:
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

    return [players._replace(seats=(who(players.seats[0]), who(players.seats[1]))) for players in episodes]


def components(episodes: Sequence[Players]) -> dict[str, list[int]]:
    """Episode indices by connected component of people who played together; a component has its first name."""
    episodes = unmasked(episodes)
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

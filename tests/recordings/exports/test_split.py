"""The split: no participant is on both sides."""

import random

from movingout.recordings import SeatInfo
from movingout.recordings.exports.split import TEST, TRAIN, caution, obtained, participants, split
from movingout.recordings.storage.listing import Players


def players(episode_id: str, blue: str, red: str, red_kind: str = "human") -> Players:
    return Players(episode_id, (SeatInfo("human", blue), SeatInfo(red_kind, red)))  # type: ignore[arg-type]


def pairs(count: int, episodes: int) -> list[Players]:
    """Pairs of people who play some episodes together."""
    return [players(f"{p}-{e}", f"P{2 * p}", f"P{2 * p + 1}") for p in range(count) for e in range(episodes)]


def test_no_participant_is_in_both_parts() -> None:
    episodes = pairs(18, 12)
    random.Random(1).shuffle(episodes)
    parts = split(episodes, 0.2)
    people = {
        part: {name for e, p in zip(episodes, parts, strict=True) if p == part for name in participants(e)}
        for part in (TRAIN, TEST)
    }
    assert people[TRAIN].isdisjoint(people[TEST])
    assert len(people[TRAIN] | people[TEST]) == 36
    assert abs(parts.count(TEST) / len(parts) - 0.2) < 0.03


def test_people_who_share_a_partner_stay_together() -> None:
    chain = [players("1", "A", "B"), players("2", "C", "D"), players("3", "B", "C")]
    assert len(set(split(chain, 0.5))) == 1


def test_an_agent_partner_does_not_tie_people_together() -> None:
    episodes = [players(str(number), f"P{number}", "bass@all", "agent") for number in range(10)]
    assert split(episodes, 0.3).count(TEST) == 3


def test_the_same_names_and_seed_give_the_same_split_in_any_order() -> None:
    episodes = pairs(9, 2)
    first = dict(zip((e.episode_id for e in episodes), split(episodes, 0.3, seed=4), strict=True))
    episodes.reverse()
    assert first == dict(zip((e.episode_id for e in episodes), split(episodes, 0.3, seed=4), strict=True))
    assert any(split(episodes, 0.3, seed=seed) != split(episodes, 0.3, seed=4) for seed in range(5))


def test_without_a_share_everything_is_for_training() -> None:
    assert set(split(pairs(5, 3), 0.0)) == {TRAIN}


def test_episodes_without_names_are_groups_of_their_own() -> None:
    nameless = [players(str(number), "", "") for number in range(10)]
    assert split(nameless, 0.5).count(TEST) == 5


def test_a_ghost_is_on_the_side_of_whoever_played_it_then() -> None:
    apart = [players(str(number), f"P{number}", f"Q{number}") for number in range(8)]
    ghost = players("again", "P0", "ghost:5#red", "ghost")
    ghost_of_the_ghost = players("and again", "P7", "ghost:again#red", "ghost")
    for seed in range(8):
        parts = split([*apart, ghost, ghost_of_the_ghost], 0.5, seed)
        assert parts[0] == parts[5] == parts[7] == parts[8] == parts[9]


def test_a_ghost_of_an_agent_ties_nobody_together() -> None:
    then = players("then", "P0", "scripted", "agent")
    ghosts = [players(str(number), f"P{number}", "ghost:then#red", "ghost") for number in range(1, 10)]
    assert split([then, *ghosts], 0.3).count(TEST) == 3


def test_by_map_no_map_is_on_both_sides_and_by_episode_everybody_may_be() -> None:
    episodes = [player._replace(map=f"map {number % 4}") for number, player in enumerate(pairs(1, 12))]
    parts = split(episodes, 0.25, by="map")
    maps = {part: {e.map for e, p in zip(episodes, parts, strict=True) if p == part} for part in (TRAIN, TEST)}
    assert maps[TRAIN].isdisjoint(maps[TEST]) and parts.count(TEST) == 3
    assert split(episodes, 0.25, by="episode").count(TEST) == 3


def test_the_share_that_was_reached_is_said() -> None:
    one_pair = pairs(1, 8)
    sentence = obtained(split(one_pair, 0.25), 0.25, "participant")
    assert sentence.startswith("for testing: 0 of 8 recordings (0%); 25% were asked for, split by participant. What")
    assert "another --split-by" in sentence
    assert obtained(split(one_pair, 0.25, by="episode"), 0.25, "episode") == (
        "for testing: 2 of 8 recordings (25%); 25% were asked for, split by episode"
    )
    assert obtained([TRAIN], 0.25, "map").endswith("split by map. One recording is never divided")
    assert obtained([TRAIN] * 4, 0.1, "episode").endswith("less than one recording: ask for a larger share")
    alike = obtained([TRAIN] * 4, 0.5, "episode")
    assert alike.endswith("equal action by action are never divided: ask for a larger share")


def test_names_of_one_room_are_no_people_that_a_split_keeps_apart() -> None:
    lobby, study = [players("a", "person-tyncpf", "idle", "agent")], [players("b", "P7KXM2Q", "idle", "agent")]
    assert "in both parts" in caution([*study, *lobby], "participant")
    agents = [Players("c", (SeatInfo("agent", "person-tyncpf"), SeatInfo("agent", "person-delay4")))]
    assert caution(study, "participant") == caution(lobby, "map") == caution(agents, "participant") == ""

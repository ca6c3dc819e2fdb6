"""Recombined and perturbed states of the kitchen, in games of cooks who act at random."""

from itertools import islice

import numpy as np
import pytest

from movingout.agents.errors import AgentError
from movingout.agents.overcooked.augmentation import (
    LENGTH,
    KitchenPiece,
    PlayedGame,
    augmented_samples,
    draw_pieces,
    perturbed,
    played,
    recombination,
    replayed,
)
from movingout.agents.overcooked.kitchen import HEADINGS, INTERACT, STAY, Kitchen, Singles, is_installed, row_of
from movingout.agents.overcooked.recordings import KitchenEpisode, kitchen_windows
from movingout.agents.policies.config import PolicyConfig

pytestmark = pytest.mark.skipif(not is_installed(), reason="the extra overcooked is not installed")
OWN, PARTNER, KITCHEN = slice(0, 27), slice(27, 54), slice(54, None)  # parts of a view
FETCH = ((1, 0), INTERACT, (-1, 0), (0, -1), INTERACT, (1, 0))  # from (3, 1): an onion into the pot, and back


@pytest.fixture(scope="module")
def games() -> list[PlayedGame]:
    return [replayed(_random_game(seed)) for seed in range(3)]


def test_a_game_can_be_continued_from_each_state_that_it_came_through(games: list[PlayedGame]) -> None:
    game, room = games[0], Kitchen()
    assert len(game.states) == len(game.places) == len(game.episode.rows) + 1
    for tick in (0, 57, 130):
        room.state = game.states[tick]
        for seen, rows in zip(game.episode.observations[tick:], game.episode.rows[tick:], strict=True):
            assert np.array_equal([room.observation(cook) for cook in (0, 1)], seen)
            room.step(rows)


def test_a_game_that_the_kitchen_plays_in_another_way_is_refused() -> None:
    game = _random_game(0)
    game.rows[20:40] = row_of(STAY, (0, -1))
    with pytest.raises(AgentError, match=r"pair 0, tick 2\d: the kitchen does not play as was recorded"):
        replayed(game)


def test_a_piece_has_the_own_cook_of_one_game_and_the_partner_of_another(games: list[PlayedGame]) -> None:
    room, valid = Kitchen(), 0
    for piece in islice(draw_pieces(games, np.random.default_rng(0)), 200):
        cook, mine = piece.cook, slice(piece.start, piece.start + LENGTH)
        theirs = slice(piece.other_start, piece.other_start + LENGTH)
        assert piece.other is not piece.own
        for tick in (0, LENGTH):
            assert piece.own.places[mine.start + tick, cook] == piece.other.places[theirs.start + tick, cook]
        seen = played(piece, room)
        if seen is None:
            continue
        valid += 1
        recorded, others = piece.own.episode.observations[mine, cook], piece.other.episode.observations[theirs, cook]
        assert np.array_equal(seen[:, OWN], recorded[:, OWN]), "the own cook does what it did"
        assert np.array_equal(seen[:, PARTNER], others[:, PARTNER]), "as the partner did in the other game"
        assert np.array_equal(seen[0, KITCHEN], recorded[0, KITCHEN]), "in the kitchen of the own game"
        assert np.array_equal(piece.targets[:LENGTH], piece.own.episode.rows[mine, cook])
    assert 30 < valid < 200


def test_every_tick_of_a_piece_follows_from_the_one_before_by_the_rules(games: list[PlayedGame]) -> None:
    piece, seen = next(
        (one, found)
        for one in draw_pieces(games, np.random.default_rng(1))
        if (found := played(one, Kitchen())) is not None and not np.array_equal(found[0, KITCHEN], found[-1, KITCHEN])
    )
    room = Kitchen()
    first = piece.own.states[piece.start].deepcopy()
    theirs = piece.other.states[piece.other_start].players[1 - piece.cook]
    first.players = tuple(theirs if who != piece.cook else mine for who, mine in enumerate(first.players))
    room.state = first
    for tick in range(LENGTH):
        assert np.array_equal(room.observation(piece.cook), seen[tick])
        rows = np.empty((2, 5), np.float32)
        rows[piece.cook] = piece.own.episode.rows[piece.start + tick, piece.cook]
        rows[1 - piece.cook] = piece.other.episode.rows[piece.other_start + tick, 1 - piece.cook]
        room.step(rows)


def test_an_onion_that_finds_no_room_in_the_pot_makes_a_piece_invalid() -> None:
    fetches = replayed(_scripted_game("one", *FETCH, STAY, STAY))
    empty = replayed(_scripted_game("none", *[STAY] * LENGTH))
    full = replayed(_scripted_game("three", *FETCH, *FETCH, *FETCH, *[STAY] * LENGTH))
    assert played(KitchenPiece(empty, 0, 0, fetches, 0), Kitchen()) is not None
    assert played(KitchenPiece(full, 0, 3 * len(FETCH), fetches, 0), Kitchen()) is None


def test_the_share_of_valid_pieces_is_that_of_the_pieces_tried(games: list[PlayedGame]) -> None:
    samples, report = recombination(games, 12, np.random.default_rng(4))
    room, tried = Kitchen(), list(islice(draw_pieces(games, np.random.default_rng(4)), report.tried))
    assert sum(played(piece, room) is not None for piece in tried) == report.valid == len(samples) == 12
    assert report.share == 12 / report.tried < 1.0
    assert played(tried[-1], room) is not None, "it stops with the last one that was wanted"


def test_the_same_seed_draws_the_same_samples_and_another_one_others(games: list[PlayedGame]) -> None:
    episodes = [game.episode for game in games]
    first, again, other = (augmented_samples(episodes, seed)[0] for seed in (5, 5, 6))
    assert len(first) == len(again) > 20
    for one, two in zip(first, again, strict=True):
        assert one.participant == two.participant
        assert np.array_equal(one.features, two.features) and np.array_equal(one.targets, two.targets)
    assert not np.array_equal(kitchen_windows(episodes, first).features, kitchen_windows(episodes, other).features)


def test_shares_are_of_the_recorded_ticks_and_nothing_is_added_for_none(games: list[PlayedGame]) -> None:
    episodes = [game.episode for game in games]
    recorded, ticks = kitchen_windows(episodes), 2 * sum(len(one.rows) for one in episodes)
    samples, _ = augmented_samples(episodes, 0, recombined_share=0.1, share=0.02)
    more = kitchen_windows(episodes, samples)
    pieces = round(0.1 * ticks / LENGTH)
    assert len(more) == ticks + pieces * LENGTH + round(0.02 * ticks) and more.names == recorded.names
    none, report = augmented_samples(episodes, 0, recombined_share=0.0, share=0.0)
    assert none == [] and report.tried == 0
    for name in ("features", "targets", "starts", "ends", "people"):
        assert np.array_equal(getattr(kitchen_windows(episodes, none), name), getattr(recorded, name))


def test_a_perturbed_partner_is_turned_or_a_tile_away_and_nothing_else_is_changed(games: list[PlayedGame]) -> None:
    moved = turned = 0
    for sample in islice(perturbed(games[:1], np.random.default_rng(2)), 200):
        cook, recorded = int(sample.participant[-1]), games[0].episode
        starts = _starts(recorded, cook, sample.targets, sample.features[0])
        assert starts, "what the own cook and the kitchen are, and what is done, is recorded"
        changes = [sample.features[0, PARTNER] != recorded.observations[start, cook, PARTNER] for start in starts]
        assert all(change.sum() >= 2 for change in changes)
        apart = [np.add.reduceat(change, [0, 20, 24]).tolist() for change in changes]
        assert [2, 0, 0] in apart or [0, 2, 0] in apart
        moved, turned = moved + ([2, 0, 0] in apart), turned + ([0, 2, 0] in apart)
    assert moved > 20 < turned


def test_a_perturbed_partner_is_not_where_the_own_cook_goes(games: list[PlayedGame]) -> None:
    for sample in islice(perturbed(games, np.random.default_rng(3)), 300):
        game = games[int(sample.participant.split()[1].rstrip(","))]
        cook = int(sample.participant[-1])
        tile = int(sample.features[0, PARTNER][:20].argmax())
        for start in _starts(game.episode, cook, sample.targets, sample.features[0]):
            seen = game.episode.observations[start : start + LENGTH, cook]
            was = int(seen[0, PARTNER][:20].argmax())
            assert tile == was or tile not in seen[:, :20].argmax(axis=1)


def test_pieces_are_as_long_as_the_policy_plans() -> None:
    assert PolicyConfig().horizon == LENGTH


def _starts(game: KitchenEpisode, cook: int, targets: Singles, seen: Singles) -> list[int]:
    """Ticks at which a cook saw and did this, but for the partner."""
    return [
        start
        for start in range(len(game.rows))
        if np.array_equal(game.rows[start : start + LENGTH, cook], targets)
        and np.array_equal(game.observations[start, cook, OWN], seen[OWN])
        and np.array_equal(game.observations[start, cook, KITCHEN], seen[KITCHEN])
    ]


def _random_game(seed: int) -> KitchenEpisode:
    random = np.random.default_rng(seed)
    choices = (*HEADINGS, STAY, INTERACT, INTERACT)
    return _game(f"pair {seed}", [[choices[random.integers(len(choices))] for _ in range(2)] for _ in range(160)])


def _scripted_game(pair: str, *second: object) -> KitchenEpisode:
    """The second cook acts, the first stays."""
    return _game(pair, [[STAY, action] for action in second])


def _game(pair: str, actions: list[list[object]]) -> KitchenEpisode:
    room, seen, rows, soups = Kitchen(), [], [], []
    for both in actions:
        seen.append([room.observation(cook) for cook in (0, 1)])
        facing = [player.orientation for player in room.state.players]
        rows.append([row_of(action, heading) for action, heading in zip(both, facing, strict=True)])
        soups.append(room.step(np.array(rows[-1])) / 20.0)
    return KitchenEpisode(pair, np.array(seen, np.float32), np.array(rows, np.float32), np.array(soups, np.float32))

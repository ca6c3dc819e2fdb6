"""Augmentation in the kitchen: a cook's stretch of one game with the partner of another, and a partner moved by a tile.

Recombination (paper, "Recombination of Sub-Trajectories") is that of `agents.bass.recombination`. Where a cook starts
and ends a stretch in the same places in two games, the partner of one also fits the other; a place is the tile, the
heading and what is held, all exact. Counters and pot stay those of the own game. The engine plays every piece, and a
piece is kept only if both cooks come through the places of their own games, tick by tick, so no onion, dish or soup
that one of them took or left there is missing.

Perturbation (paper, "Generating New States by Perturbing the Partner's Pose") has no small step here: the paper's noise
is far below a tile. A partner is turned, or moved to a free tile beside it, in a small share of the ticks, and only
where the own cook does not enter that tile in the ticks that are learned: there its recorded actions would be wrong.
Nobody plays on from such a state, as in the paper; it is only seen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from movingout.agents.bass.recombination import RecombinationReport, StretchTable
from movingout.agents.data.dataset import Indices, SeatSamples
from movingout.agents.errors import AgentError
from movingout.agents.overcooked.kitchen import CARRIED, HEADINGS, HEIGHT, WIDTH, Kitchen, Singles, features, tile_of
from movingout.agents.overcooked.recordings import KitchenEpisode

LENGTH = 8  # ticks of a piece, and of what is learned from a perturbed state; the policy's horizon
RECOMBINED = 0.25  # recombined ticks, as a share of the recorded ones, as in Moving Out
PERTURBED = 0.05  # perturbed ticks, likewise: a tile is far
TRIES = 8  # per requested piece
_HANDS = len(CARRIED) + 1
_PLACES = WIDTH * HEIGHT * len(HEADINGS) * _HANDS


@dataclass(frozen=True, slots=True, eq=False)
class PlayedGame:
    """A recorded game with the states of the engine, in which it can be continued."""

    episode: KitchenEpisode
    states: tuple[Any, ...]  # T + 1, of the package
    places: Indices  # (T + 1, 2) of both cooks: tile, heading and what is held, as one number


@dataclass(frozen=True, slots=True, eq=False)
class KitchenPiece:
    """LENGTH ticks of a cook of `own` from `start`, with the partner of `other` from `other_start`."""

    own: PlayedGame
    cook: int
    start: int
    other: PlayedGame
    other_start: int

    @property
    def targets(self) -> Singles:
        """What the cook did (LENGTH to 2 * LENGTH, 5), including the ticks after the piece."""
        return self.own.episode.rows[self.start : self.start + 2 * LENGTH, self.cook]

    @property
    def rows(self) -> Singles:
        """What both do (LENGTH, 2, 5)."""
        rows = self.own.episode.rows[self.start : self.start + LENGTH].copy()
        rows[:, 1 - self.cook] = self.other.episode.rows[self.other_start : self.other_start + LENGTH, 1 - self.cook]
        return rows

    @property
    def places(self) -> Indices:
        """Where both were in their own games (LENGTH + 1, 2)."""
        places = self.own.places[self.start : self.start + LENGTH + 1].copy()
        theirs = self.other.places[self.other_start : self.other_start + LENGTH + 1]
        places[:, 1 - self.cook] = theirs[:, 1 - self.cook]
        return places


def augmented_samples(
    episodes: Sequence[KitchenEpisode], seed: int, recombined_share: float = RECOMBINED, share: float = PERTURBED
) -> tuple[list[SeatSamples], RecombinationReport]:
    """Samples to learn besides the recorded ones, both shares of the recorded ticks, and how many pieces are valid.

    Raises AgentError where the package is missing, or does not play a game as it was recorded.
    """
    games = [replayed(episode) for episode in episodes]
    ticks = 2 * sum(len(episode.rows) for episode in episodes)
    random = np.random.default_rng(seed)
    pieces, report = recombination(games, round(recombined_share * ticks / LENGTH), random)
    return [*pieces, *islice(perturbed(games, random), round(share * ticks))], report


def replayed(episode: KitchenEpisode) -> PlayedGame:
    """A game with the states that the engine comes through when both do what is recorded.

    Raises AgentError where the package is missing, or shows a cook something else than is recorded.
    """
    room, states = Kitchen(), list[Any]()
    for seen, rows in zip(episode.observations, episode.rows, strict=True):
        if not np.array_equal([room.observation(cook) for cook in (0, 1)], seen):
            raise AgentError(f"{episode.pair}, tick {len(states)}: the kitchen does not play as was recorded")
        states.append(room.state)
        room.step(rows)
    states.append(room.state)
    return PlayedGame(episode, tuple(states), np.array([_places(state) for state in states], np.int64))


def recombination(
    games: Sequence[PlayedGame], count: int, random: np.random.Generator
) -> tuple[list[SeatSamples], RecombinationReport]:
    """Up to `count` random pieces that the engine confirms, and a report on how many it did."""
    room, tried, found = Kitchen(), 0, list[SeatSamples]()
    for piece in islice(draw_pieces(games, random), TRIES * count):
        if len(found) == count:
            break
        tried += 1
        seen = played(piece, room)
        if seen is not None:
            found.append(SeatSamples(piece.own.episode.participant(piece.cook), seen, piece.targets))
    return found, RecombinationReport(tried, len(found))


def draw_pieces(games: Sequence[PlayedGame], random: np.random.Generator) -> Iterator[KitchenPiece]:
    """All ticks at which a piece may start, in random order, each with a random match in another game.

    Ticks without a match are left out.
    """
    table = StretchTable({(number, cook): _keys(game, cook) for number, game in enumerate(games) for cook in (0, 1)})
    starts = [
        (number, cook, start)
        for number, game in enumerate(games)
        for cook in (0, 1)
        for start in range(len(game.places) - LENGTH)
    ]
    for drawn in random.permutation(len(starts)):
        number, cook, start = starts[drawn]
        others, ticks = table.matches(number, cook, start)
        if len(others):
            match = random.integers(len(others))
            yield KitchenPiece(games[number], cook, start, games[others[match]], int(ticks[match]))


def _keys(game: PlayedGame, cook: int) -> Indices:
    """Keys of a cook's stretches (T + 1 - LENGTH,), equal where it is the same cook and both ends are."""
    places = game.places[:, cook]
    keys: Indices = (cook * _PLACES + places[:-LENGTH]) * _PLACES + places[LENGTH:]
    return keys


def played(piece: KitchenPiece, room: Kitchen) -> Singles | None:
    """What the cook sees before each tick of a piece (LENGTH, 120), as the engine plays it; None when it is not valid.

    The room is left in the last state.
    """
    partner = 1 - piece.cook
    mixed = piece.own.states[piece.start].deepcopy()
    mixed.players = list(mixed.players)
    mixed.players[partner] = piece.other.states[piece.other_start].players[partner].deepcopy()
    room.state = mixed
    seen = []
    for rows, places in zip(piece.rows, piece.places[1:], strict=True):
        seen.append(room.observation(piece.cook))
        room.step(rows)
        if not np.array_equal(_places(room.state), places):
            return None
    return np.array(seen, np.float32)


def perturbed(games: Sequence[PlayedGame], random: np.random.Generator) -> Iterator[SeatSamples]:
    """Random ticks, each of a random cook who sees its partner turned or a tile away; without end."""
    free = {tile_of(position) for position in Kitchen().tiles}
    while games:
        game, cook = games[int(random.integers(len(games)))], int(random.integers(2))
        start = int(random.integers(len(game.episode.rows)))
        way = game.places[start : start + LENGTH + 1, cook] // (len(HEADINGS) * _HANDS)
        state = game.states[start].deepcopy()
        if _perturb(state.players[1 - cook], free - set(way.tolist()), random):
            rows = game.episode.rows[start : start + LENGTH, cook]
            yield SeatSamples(game.episode.participant(cook), features(state.to_dict(), cook)[None], rows)


def _perturb(partner: Any, free: set[int], random: np.random.Generator) -> bool:
    """Turn a cook of the package, or move it to a free tile beside it; whether it is another place now."""
    before, heading = partner.pos_and_or, HEADINGS[random.integers(len(HEADINGS))]
    beside = partner.position[0] + heading[0], partner.position[1] + heading[1]
    if random.random() < 0.5:
        partner.update_pos_and_or(partner.position, heading)
    elif tile_of(beside) in free:
        partner.update_pos_and_or(beside, partner.orientation)
    return bool(partner.pos_and_or != before)


def _places(state: Any) -> list[int]:
    """The places of both cooks in a state of the package."""
    return [
        (tile_of(one.position) * len(HEADINGS) + HEADINGS.index(one.orientation)) * _HANDS
        + (1 + CARRIED.index(one.held_object.name) if one.held_object else 0)
        for one in state.players
    ]

"""Pings in a study's recordings: who asked for help how often, and whether the partner came."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from movingout.recordings import RecordingError, read_episode
from movingout.recordings.pings import PingOutcome, ping_outcomes
from movingout.recordings.storage.index import path_of
from movingout.study.design.definition import Study


@dataclass(frozen=True, slots=True)
class PingRound:
    """The pings of one player in one round."""

    player: str  # pseudonym of a participant, "" for an agent
    partner: str  # id of the partner of the round, "" in pairs
    pings: tuple[PingOutcome, ...]
    block: str = ""


def ping_rounds(
    study: Study, rounds: Iterable[dict[str, Any]], players: Iterable[dict[str, Any]], recordings: Path
) -> tuple[PingRound, ...]:
    """Two entries per round of the blocks with pings; a round without a readable recording is left out."""
    blocks = {block.id for block in study.blocks if block.pings == "on"}
    seated = {(one["round"], one["seat"]): one["pid"] for one in players}
    found: list[PingRound] = []
    for row in rounds:
        if row["block"] not in blocks:
            continue
        try:
            outcomes = ping_outcomes(read_episode(path_of(recordings, row["episode"])))
        except RecordingError:
            continue
        for seat in (0, 1):
            said = tuple(one for one in outcomes if one.ping.seat == seat)
            found.append(PingRound(seated.get((row["id"], seat), ""), row["partner"], said, row["block"]))
    return tuple(found)

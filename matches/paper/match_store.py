"""Played matches, kept by who played: a match is played once for all tables, and again only with other weights.

One that failed is played again by the next command: what stopped it may be over.

data/matches/<key>/results-0-of-1.jsonl    one folder per pair; the key stands for ids, weights and versions
"""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.matches.callbacks import OnProgress, no_op
from movingout.matches.match import Match, MatchResult
from movingout.matches.preparation import make_folder
from movingout.matches.results.other_code import of_other_code, with_code
from movingout.matches.results.results_folder import EXACT, Shard, read_results, to_play
from movingout.matches.run import play_matches
from movingout.recordings.versions import versions


class MatchStore:
    """The results in a folder. Weights are looked up once, so that a store lives no longer than a command."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._versions = [versions()[name] for name in EXACT]
        self._places: dict[tuple[str, ...], Path] = {}
        self._untrained: set[tuple[str, ...]] = set()  # pairs whose place changes once their agents are there
        self._results: dict[Path, dict[str, MatchResult]] = {}
        self._tried: set[Match] = set()  # by this store: what fails for it is not tried for every table

    def find(self, match: Match) -> MatchResult | None:
        """The result of a match with the present weights; None when it has not been played."""
        kept = self._kept(self._place(match))
        return kept.get(match.id) if kept else None  # most pairs of a new folder have not met: an id takes time

    def missing(self, matches: Sequence[Match]) -> list[Match]:
        """The distinct matches to play: not played, or failed in an earlier command. Looks again for agents."""
        for pair in self._untrained:
            del self._places[pair]
        self._untrained.clear()
        return [match for match in dict.fromkeys(matches) if self._is_missing(match)]

    def failed_before(self, matches: Sequence[Match]) -> int:
        """How many of those that `missing` names have failed."""
        return sum(self.find(match) is not None for match in self.missing(matches))

    def of_other_code(self, matches: Sequence[Match]) -> int:
        """How many of these were played by other code of this project than is here."""
        return of_other_code(result for match in matches if (result := self.find(match)) is not None)

    def play(self, matches: Sequence[Match], workers: int, progress: OnProgress = no_op) -> None:
        """Play what is missing; each result is on disk as soon as its match ends."""
        if todo := self.missing(matches):
            play_matches(todo, workers=workers, on_result=self._keep, progress=progress)

    def _keep(self, result: MatchResult) -> None:
        result, place = with_code(result), self._place(result.match)
        make_folder(place)
        with Shard(place) as shard:
            shard.append([result])
        self._kept(place)[result.match.id] = result
        self._tried.add(result.match)

    def _is_missing(self, match: Match) -> bool:
        result = self.find(match)
        return result is None or (match not in self._tried and bool(to_play([match], {match.id: result})))

    def _kept(self, place: Path) -> dict[str, MatchResult]:
        if place not in self._results:
            self._results[place] = read_results(place) if place.is_dir() else {}
        return self._results[place]

    def _place(self, match: Match) -> Path:
        """The folder of a pair; another one once an agent has weights that it did not have."""
        pair = tuple(sorted(match.seats))
        if pair not in self._places:
            weights = [fingerprint(agent_id) for agent_id in pair]
            text = json.dumps([pair, weights, self._versions])
            self._places[pair] = self.folder / hashlib.sha256(text.encode()).hexdigest()[:16]
            if not all(weights):
                self._untrained.add(pair)
        return self._places[pair]

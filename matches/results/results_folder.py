"""A results folder: the grid, and one line per finished match, appended and never changed.

grid.json              the grid, its hash, and of the first run the versions, checkpoints, own code, maps, …
results-0-of-1.jsonl   one file per shard; a torn last line (a killed driver, a full disk) is cut off by the next run
"""

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any

from pydantic import ValidationError

from movingout.maps.files.data_sync import sync_data
from movingout.maps.files.file_lock import lock_file
from movingout.maps.files.output_file import draft_of
from movingout.matches.errors import MatchError
from movingout.matches.experiment.grid import Grid
from movingout.matches.experiment.plan import ORDER
from movingout.matches.match import Match, MatchResult, result_from_json
from movingout.matches.results.provenance import Provenance
from movingout.recordings.versions import versions

GRID = "grid.json"
FORMAT = 2
EXACT = ("movingout", "pymunk")  # another version may give other results
_PROVENANCE = {
    "checkpoints": "other weights of",
    "code": "other code of",
    "maps": "another version of the map",
    "lists": "another version of the list",
    "groups": "other members of",
    "metrics": "other code of the metric",
}
_PUT_BACK = {"lists": "put that one back", "groups": "the trained agents of then are to be here, and no others"}


def write_whole(path: Path, text: str) -> None:
    """Write a file atomically. Raises MatchError."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with draft_of(path) as draft:
            draft.write_text(text, encoding="utf-8")
    except OSError as error:
        raise MatchError(f"cannot write {path}: {error.strerror or error}") from error


def open_folder(folder: Path, grid: Grid, provenance: Provenance) -> None:
    """Write the grid into a new folder, or check that the folder is this grid's. Raises MatchError when it is not."""
    mine = {
        "format": FORMAT,
        "order": ORDER,
        "sha256": grid.sha256,
        "grid": grid.model_dump(mode="json"),
        "versions": versions(),
        **asdict(provenance),
    }
    if not (folder / GRID).exists():
        if any(folder.glob("results-*.jsonl")):
            raise MatchError(f"{folder} holds results but no {GRID}; choose another folder")
        write_whole(folder / GRID, json.dumps(mine, indent=1) + "\n")
        return
    theirs = read_head(folder)
    if grid.sha256 not in (theirs["sha256"], _fingerprint(theirs["grid"])):
        raise MatchError(
            f"{folder} holds results of another grid ({theirs['grid'].get('name')!r}); choose another folder with --out"
        )
    for name in EXACT:
        if theirs["versions"].get(name) != versions()[name]:
            raise MatchError(
                f"{folder} was started with {name} {theirs['versions'].get(name)}, this is {versions()[name]}: "
                "their results are not comparable; choose another folder with --out"
            )
    for key, what in _PROVENANCE.items():
        before: dict[str, str] = theirs.get(key, {})  # a folder of an earlier version may lack some
        if changed := [name for name, sha in mine[key].items() if before.get(name, sha) != sha]:
            raise MatchError(f"{folder} was started with {what} {', '.join(changed)}; choose another folder with --out")


def add_metrics(folder: Path, provenance: Provenance) -> None:
    """Write down the code of metrics that the folder does not know, before their first values. Raises MatchError.

    They were installed after its first run, or an earlier version wrote none down.
    """
    head = read_head(folder)
    known: dict[str, str] = head.get("metrics", {})
    if provenance.metrics.keys() - known.keys():
        head["metrics"] = provenance.metrics | known
        write_whole(folder / GRID, json.dumps(head, indent=1) + "\n")


def _fingerprint(written: Any) -> str:
    """That of a grid in `grid.json`, as it is counted now; empty for one that cannot be played here."""
    try:
        return Grid.model_validate(written).sha256
    except ValidationError:
        return ""


def order_of(folder: Path) -> int:
    """In which order members of groups take turns in a folder. Raises MatchError where it cannot be read."""
    return int(read_head(folder).get("order", 1)) if (folder / GRID).exists() else ORDER


def check_named(folder: Path, head: dict[str, Any], now: Mapping[str, Mapping[str, str]]) -> None:
    """Raises MatchError where a list or a group names others now than when the folder was begun.

    Which matches it holds cannot be told then. What an earlier version did not write down does not count.
    """
    for key, hashes in now.items():
        before: dict[str, str] = head.get(key, {})
        if changed := [name for name, sha in hashes.items() if before.get(name, sha) != sha]:
            raise MatchError(f"{folder} was played with {_PROVENANCE[key]} {', '.join(changed)}; {_PUT_BACK[key]}")


def read_head(folder: Path) -> dict[str, Any]:
    """`grid.json` of a results folder. Raises MatchError when there is none or it cannot be read."""
    try:
        head = json.loads((folder / GRID).read_text(encoding="utf-8"))
    except OSError as error:
        raise MatchError(f"{folder} is not a results folder: {GRID}: {error.strerror or error}") from error
    except ValueError as error:
        raise MatchError(f"{folder / GRID} is damaged: {error}") from error
    if not isinstance(head, dict) or head.get("format") != FORMAT or not {"sha256", "grid", "versions"} <= head.keys():
        raise MatchError(
            f"{folder / GRID} is not of format {FORMAT}: another version wrote it, and its results cannot be read "
            "here; play the grid again, into an empty folder"
        )
    return head


def read_results(folder: Path) -> dict[str, MatchResult]:
    """The results of all shards by match id; of a match that failed and was played again, the later one.

    Raises MatchError for a line that is damaged in the middle of a file.
    """
    results: dict[str, MatchResult] = {}
    for path in sorted(folder.glob("results-*.jsonl")):
        try:
            lines = path.read_bytes().split(b"\n")
        except OSError as error:
            raise MatchError(f"cannot read {path}: {error.strerror or error}") from error
        for number, line in enumerate(lines[:-1], start=1):  # anything after the last newline is torn
            try:
                result = result_from_json(json.loads(line))
            except (ValueError, AttributeError, MatchError) as error:
                raise MatchError(f"{path}, line {number}: {error}") from error
            if result.ending != "failed" or not _played_through(results.get(result.match.id)):
                results[result.match.id] = result  # the files of shards are in no order of time: a failure yields
    return results


def to_play(matches: Sequence[Match], results: Mapping[str, MatchResult]) -> list[Match]:
    """Those without a result, and those that failed: what stopped them may be over."""
    return [match for match in matches if not _played_through(results.get(match.id))]


def _played_through(result: MatchResult | None) -> bool:
    return result is not None and result.ending != "failed"


class Shard:
    """The file that one driver appends to. It is locked while open, where the file system has locks."""

    def __init__(self, folder: Path, index: int = 0, count: int = 1) -> None:
        """Raises MatchError where it cannot be written, or another process writes it."""
        self.path = folder / f"results-{index}-of-{count}.jsonl"
        try:
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise MatchError(f"cannot write {self.path}: {error.strerror or error}") from error
        try:
            locked = lock_file(self._file)
        except OSError as error:
            os.close(self._file)
            raise MatchError(f"cannot lock {self.path}: {error.strerror or error}") from error
        if not locked:
            os.close(self._file)
            raise MatchError(f"another process is writing {self.path}; wait for it, or use --shard")
        self._end = self._cut_torn_line()

    def __enter__(self) -> "Shard":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.close(self._file)

    def append(self, results: Iterable[MatchResult]) -> None:
        """Append results, all or none, and flush them to disk. Raises MatchError."""
        lines = "".join(json.dumps(result.to_json(), allow_nan=False) + "\n" for result in results).encode()
        try:
            written = os.pwrite(self._file, lines, self._end)
            if written < len(lines):
                raise OSError(0, "the disk is full")
            sync_data(self._file)
        except OSError as error:
            os.ftruncate(self._file, self._end)
            raise MatchError(
                f"cannot write {self.path}: {error.strerror or error}; finished matches are kept; "
                "run the same command again to continue"
            ) from error
        self._end += len(lines)

    def _cut_torn_line(self) -> int:
        size = os.fstat(self._file).st_size
        end = os.pread(self._file, size, 0).rfind(b"\n") + 1
        os.ftruncate(self._file, end)
        return end

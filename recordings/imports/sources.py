"""Reading the official files: the recorder's JSON, the evaluator's JSON, and data set rows as Parquet, JSON or JSONL.

Local files only. Nothing is believed here but the outermost shape; `steps` looks inside.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, cast, get_args

from movingout.maps.json_format import MASSES
from movingout.recordings.episode import Outcome
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.reader import read_bytes
from movingout.recordings.imports.parquet_rows import parquet_rows
from movingout.world.constants import MAX_TICKS

SUFFIXES = (".json", ".jsonl", ".parquet")
Shape = Literal["recorder", "evaluator", "dataset"]


class NoTrajectoriesError(RecordingError):
    """A file of another shape, such as lies beside trajectories."""


@dataclass(frozen=True, slots=True)
class TrajectoryFile:
    """One trajectory as it lay in a file."""

    file: Path
    place: str  # where in the file: "episode 0", "row 12"
    shape: Shape
    map_name: Any  # a name or an old number
    steps: Any  # JSON text or the parsed list
    blue: str
    red: str
    time: str  # as the recorder wrote it, may be empty
    recorded_ns: int  # when the file was last changed
    trajectory_id: str = ""  # of a row that has one
    kinds: tuple[str, str] = ("", "")  # of blue and red where the file says them, as our own exports do
    simulated: bool = False  # by programs that took part in a rehearsal, as our own exports say
    outcome: Outcome | None = None  # where the file says it, as our own exports do
    limit_ticks: int = 0  # likewise; 0 where it does not
    masses: tuple[float, ...] = ()  # of the items, likewise: no state has them, and those of variants are other ones

    @property
    def id(self) -> str:
        """The same for the same content, so that importing twice makes no copy."""
        content = self.steps if isinstance(self.steps, str) else json.dumps(self.steps, sort_keys=True, default=str)
        return _digest(f"{self.map_name}\n{content}")[:16]

    @property
    def played(self) -> str:
        """The same for the same states and actions, in whichever shape they were written."""
        try:
            steps = json.loads(self.steps) if isinstance(self.steps, str) else self.steps
            content = json.dumps([[states, action] for _, states, action in steps], sort_keys=True)
        except (ValueError, TypeError, RecursionError):
            return self.id  # converting it will say what is wrong
        return _digest(f"{self.map_name}\n{content}")


def _digest(text: str) -> str:
    """Of any text: JSON may have half a letter (`\\ud800`), which is no UTF-8."""
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()


def without_copies(found: Sequence[TrajectoryFile]) -> list[TrajectoryFile]:
    """Each trajectory once, in order; of copies in several shapes the one that says who was a person.

    A folder of our own export has every episode as a recorder's file and as a row of the data set.
    """
    same = [source.played for source in found] if len({s.shape for s in found}) > 1 else [s.id for s in found]
    kept: dict[str, TrajectoryFile] = {}
    for key, source in zip(same, found, strict=True):
        if key not in kept or (any(source.kinds) and not any(kept[key].kinds)):
            kept[key] = source
    return list(kept.values())


def find(paths: Sequence[Path]) -> list[Path]:
    """The files named and those in the folders named and below, but for hidden ones.

    Raises RecordingError for files of other kinds, or none.
    """
    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            inside = (file for file in path.rglob("*") if file.suffix in SUFFIXES and file.is_file())
            files += sorted(f for f in inside if not any(p.startswith(".") for p in f.relative_to(path).parts))
        elif path.suffix in SUFFIXES:
            files.append(path)
        else:
            raise RecordingError(f"{path} is none of {', '.join(SUFFIXES)}")
    if not files:
        raise RecordingError(f"nothing to import there; {', '.join(SUFFIXES)} files are read")
    return files


def read_all(paths: Sequence[Path]) -> tuple[list[TrajectoryFile], list[Path]]:
    """The trajectories of files and folders, and the files in folders that are of another shape.

    Raises RecordingError where such a file is named, or there is nothing else.
    """
    found: list[TrajectoryFile] = []
    others: dict[Path, NoTrajectoriesError] = {}
    for file in find(paths):
        try:
            found += read(file)
        except NoTrajectoriesError as error:
            if file in paths:
                raise
            others[file] = error
    if others and not found:
        raise next(iter(others.values()))
    return found, [*others]


def read(file: Path) -> list[TrajectoryFile]:
    """The trajectories of a file; RecordingError with the place when its shape is none of the official ones."""
    if file.suffix == ".parquet":
        return [_row(file, number, row) for number, row in enumerate(parquet_rows(file))]
    if file.suffix == ".jsonl":
        lines = (line for line in _text(file).splitlines() if line.strip())
        return [_row(file, number, _json(line, file, f"line {number + 1}")) for number, line in enumerate(lines)]
    document = _json(_text(file), file, "")
    if isinstance(document, list) and document and all(_is_row(entry) for entry in document):
        return [_row(file, number, row) for number, row in enumerate(document)]
    return list(_episodes(file, document))


def _episodes(file: Path, document: Any) -> Iterator[TrajectoryFile]:
    """The recorder's and the evaluator's shape: a list of episodes, or the steps of a single one."""
    if not isinstance(document, list) or not document:
        raise NoTrajectoriesError(f"{file}: a list of episodes is needed, as the official recorder writes it")
    episodes = document if isinstance(document[0], list) else [document]
    for number, steps in enumerate(episodes):
        place = f"episode {number}"
        if not isinstance(steps, list) or not all(_is_step(step) for step in steps):
            kind = RecordingError if _begins_with_steps(episodes) else NoTrajectoriesError
            raise kind(f"{file}, {place}: each step needs 'id', 'states' and 'action'")
        first = steps[0] if steps else {"id": ""}  # one without a step is refused by itself
        blue, red = str(first.get("blue_name") or ""), str(first.get("red_name") or "")
        evaluated = {blue, red} == {"model_1", "model_2"}
        yield TrajectoryFile(
            file=file,
            place=place,
            shape="evaluator" if evaluated else "recorder",
            map_name=first["id"],
            steps=[[step.get("step", index), step["states"], step["action"]] for index, step in enumerate(steps)],
            blue="model_1" if evaluated else blue,  # the evaluator calls robot 1's model red
            red="model_2" if evaluated else red,
            time=str(first.get("time") or ""),
            recorded_ns=file.stat().st_mtime_ns,
        )


def _row(file: Path, number: int, row: Any) -> TrajectoryFile:
    if not _is_row(row):
        kind = RecordingError if number else NoTrajectoriesError
        raise kind(f"{file}, row {number}: 'map_name' and 'steps_data' are needed")
    return TrajectoryFile(
        file=file,
        place=f"row {number}",
        shape="dataset",
        map_name=row["map_name"],
        steps=row["steps_data"],
        blue=str(row.get("blue") or ""),
        red=str(row.get("red") or ""),
        time="",
        recorded_ns=file.stat().st_mtime_ns,
        trajectory_id=str(row["trajectory_id"]) if row.get("trajectory_id") is not None else "",  # 0 is one
        kinds=(str(row.get("blue_kind") or ""), str(row.get("red_kind") or "")),
        simulated=row.get("simulated") == "yes",
        outcome=_outcome(row.get("outcome")),
        limit_ticks=_limit(row.get("limit_ticks")),
        masses=_masses(row.get("masses")),
    )


def _outcome(value: Any) -> Outcome | None:
    """How a row says that it ended, None where it does not. What was interrupted is whole as an import."""
    if value == "interrupted":
        return "stopped"
    return cast(Outcome, value) if value in get_args(Outcome) else None


def _limit(value: Any) -> int:
    """The longest that an episode could last [ticks], 0 where a row does not say it."""
    return value if type(value) is int and 1 <= value <= MAX_TICKS else 0


def _masses(value: Any) -> tuple[float, ...]:
    """The masses of the items, empty where a row does not say them."""
    least, most = MASSES
    known = isinstance(value, list) and all(type(mass) in (int, float) and least <= mass <= most for mass in value)
    return tuple(map(float, value)) if known else ()


def _is_row(value: Any) -> bool:
    return isinstance(value, Mapping) and "map_name" in value and "steps_data" in value


def _is_step(value: Any) -> bool:
    return isinstance(value, Mapping) and "id" in value and "states" in value and "action" in value


def _begins_with_steps(episodes: Sequence[Any]) -> bool:
    """Whether they are trajectories of which one is damaged, and nothing else altogether."""
    first = episodes[0]
    return isinstance(first, list) and (not first or _is_step(first[0]))


def _text(file: Path) -> str:
    try:
        return read_bytes(file).decode("utf-8")
    except UnicodeDecodeError as error:
        raise RecordingError(f"{file} is not text: {error}") from error


def _json(text: str, file: Path, place: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"{file} {place}: not JSON: {error}".replace("  ", " ")) from error

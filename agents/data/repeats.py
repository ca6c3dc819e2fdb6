"""What a folder has of other runs: recordings that are kept, and episodes to play that it has under another name.

Training takes all of them.
"""

from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from movingout.agents.data.demonstrations import EpisodeJob
from movingout.maps.spec import SEAT_COLOURS
from movingout.maps.suggestion import counted
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.metadata import EPISODE, STUDY
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import read_metadata


def folder_sentences(todo: Sequence[EpisodeJob], folder: Path) -> Iterator[str]:
    """How many recordings of other runs are there, before they are looked into, and how many are to be repeated."""
    if others := len(list(_of_others(folder, {job.episode_id for job in todo}))):
        are, they = ("are", "they are") if others != 1 else ("is", "it is")
        yield f"{counted(others, 'recording')} of other runs {are} in {folder}; {they} kept, and training takes all"
    if repeats := repeats_sentence(todo, folder):
        yield repeats


def repeats_sentence(todo: Sequence[EpisodeJob], folder: Path) -> str:
    """How many of these episodes are like others in the folder, and which `--seed` makes none of those; else empty."""
    missing = [job for job in todo if not (folder / f"{job.episode_id}{SUFFIX}").exists()]
    there = set(_played(folder, {job.episode_id for job in todo})) if missing else set()
    repeated = sum(_play(job) in there for job in missing)
    if not repeated:
        return ""
    has, others, them = ("have", "others", "them") if repeated != 1 else ("has", "another", "it")
    maps = {job.map.name for job in todo}
    finished = {job.seed for job in set(todo) - set(missing)}
    used = {int(seed) for name, *_, seed in there if name in maps} | finished
    free = 1 + max(used)
    return (
        f"{counted(repeated, 'episode')} {has} the map, seats and seed of {others} in {folder} and will repeat {them}; "
        f"--seed {free} makes new ones"
    )


def _play(job: EpisodeJob) -> tuple[str, ...]:
    return job.map.name, job.map.variant, *job.agent_ids, str(job.ticks), str(job.seed)


def _played(folder: Path, own: Collection[str]) -> Iterator[tuple[str, ...]]:
    """The same of the recordings in a folder that are of agents and can be read, but for those of this run by name.

    Each takes milliseconds to open, and the thousands of a run that goes on would all be its own.
    """
    for path in sorted(_of_others(folder, own)):
        with suppress(RecordingError, KeyError):
            records = read_metadata(path)
            said, ids = records[EPISODE], records[STUDY]
            blue, red = (ids[colour] for colour in SEAT_COLOURS)
            yield said["map"], said["map_variant"], blue, red, said["limit_ticks"], said["seed"]


def _of_others(folder: Path, own: Collection[str]) -> Iterator[Path]:
    return (path for path in folder.glob(f"*{SUFFIX}") if path.name.removesuffix(SUFFIX) not in own)

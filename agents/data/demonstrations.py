"""Episodes of scripted pairs, recorded like live play: one MCAP file each, in parallel processes."""

import hashlib
import re
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Protocol

from movingout.agents.catalogue import load_agent
from movingout.agents.data.calls import results_of
from movingout.agents.data.corrections import SUFFIX, read_about, save_correction
from movingout.agents.data.dagger import LabellingJob, label_episode
from movingout.agents.data.recipes import CODE, check_labels, check_recording, labelling_recipe, weights_of
from movingout.agents.data.rollout import rollout
from movingout.agents.errors import AgentError
from movingout.agents.fault_place import located
from movingout.agents.map_limits import check_own_maps_seen
from movingout.maps import MapSpec
from movingout.maps.errors import MovingOutError
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c, noticing_ctrl_c
from movingout.maps.randomize import Split, randomize
from movingout.recordings import EpisodeHeader, EpisodeWriter, SeatInfo, TickRecord, finalise
from movingout.recordings.errors import BusyError, cannot
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX, owned
from movingout.recordings.file_format.metadata import SOFTWARE
from movingout.recordings.storage.finished import SUFFIX as RECORDING_SUFFIX
from movingout.recordings.storage.listing import read_metadata, read_summary
from movingout.recordings.versions import code_sha256, versions
from movingout.world import WorldError
from movingout.world.metrics import EpisodeMetrics, task_completion_rate
from movingout.world.scoring import delivered_items

MOST_OF_ID = 80  # characters of the id of an episode


class Player(Protocol):
    """Who plays: a scripted person, or a partner of a family."""

    @property
    def name(self) -> str: ...

    @property
    def agent_id(self) -> str: ...

    @property
    def sha256(self) -> str: ...


Pair = tuple[Player, Player]


@dataclass(frozen=True, slots=True)
class EpisodeJob:
    """One episode to play."""

    episode_id: str
    map: MapSpec
    seats: Pair
    seed: int
    ticks: int

    @property
    def agent_ids(self) -> tuple[str, str]:
        """Of blue and red."""
        return self.seats[0].agent_id, self.seats[1].agent_id


@dataclass(frozen=True, slots=True)
class WrittenEpisode:
    """One episode that was written."""

    path: Path
    map: str
    ticks: int
    tcr: float


def episode_jobs(
    people: Sequence[Player], maps: Sequence[MapSpec], episodes: int, ticks: int, seed: int, prefix: str
) -> list[EpisodeJob]:
    """`episodes` per map and pair of neighbours in the list; the pair changes seats after half of them (paper)."""
    pairs = [(people[k], people[k + 1]) for k in range(0, len(people) - 1, 2)]
    made = []
    for the_map in maps:
        for number, pair in enumerate(pairs):
            for episode in range(episodes):
                seats = pair if episode < (episodes + 1) // 2 else (pair[1], pair[0])
                name = _episode_id(f"{prefix}-{_map_name(the_map)}-{pair[0].name}{pair[1].name}-{episode:02d}")
                made.append(EpisodeJob(name, the_map, seats, seed + number * episodes + episode, ticks))
    return _with_own_names(made)


def variant_jobs(
    people: Sequence[Player], maps: Sequence[MapSpec], variants: int, ticks: int, seed: int, prefix: str, split: Split
) -> list[EpisodeJob]:
    """`variants` per map, each on a variant of its own; pairs of neighbours take turns, and change seats every round.

    The paper's Challenge 2 has 60 per map by four experts. Raises MapError for a map without a playable variant.
    """
    pairs = [(people[k], people[k + 1]) for k in range(0, len(people) - 1, 2)]
    made = []
    for the_map in maps:
        for number in range(variants):
            turn, pair = divmod(number, len(pairs))
            seats = pairs[pair] if turn % 2 == 0 else pairs[pair][::-1]
            varied = randomize(the_map, seed + number, split)
            name = _episode_id(f"{prefix}-{_map_name(varied)}-{seats[0].name}{seats[1].name}")
            made.append(EpisodeJob(name, varied, (seats[0], seats[1]), seed + number, ticks))
    return _with_own_names(made)


def _with_own_names(jobs: Sequence[EpisodeJob]) -> list[EpisodeJob]:
    """The same jobs; where a pair plays again, or two names became the same, the later ones get a number."""
    seen: Counter[str] = Counter()
    named = []
    for job in jobs:
        seen[job.episode_id] += 1
        again = f"-again{seen[job.episode_id]}" if seen[job.episode_id] > 1 else ""
        named.append(replace(job, episode_id=job.episode_id[: MOST_OF_ID - len(again)] + again))
    return named


def _episode_id(said: str) -> str:
    """The same as the id of an episode: signs that it cannot have replaced, what is too long cut off, but unique."""
    name = re.sub(r"[^A-Za-z0-9_-]", "-", said).lstrip("-_")
    if len(name) <= MOST_OF_ID:
        return name
    return f"{name[: MOST_OF_ID - 9]}-{hashlib.sha256(said.encode()).hexdigest()[:8]}"


def _map_name(the_map: MapSpec) -> str:
    """A map's name in episode names, with the variant of Challenge 2."""
    return f"{the_map.file_name}-{the_map.variant}" if the_map.variant else the_map.file_name


def write_episode(job: EpisodeJob, folder: Path, code: str = "") -> WrittenEpisode:
    """Play and write one episode, unless another process has written it by now. BusyError while one writes it.

    `code`: the hash of the code that plays, to be kept in the file.
    """
    _remove_unfinished(folder / f"{job.episode_id}{JOURNAL_SUFFIX}")
    if (there := _recording(job, folder)).exists():
        check_recording(there, job.map, job.agent_ids, job.ticks)
        written = read_summary(there)
        return WrittenEpisode(there, job.map.name, written.ticks, written.metrics["tcr"] or 0.0)
    agents = (load_agent(job.seats[0].agent_id), load_agent(job.seats[1].agent_id))
    blue, red = (SeatInfo("agent", one.name, _weights(one.agent_id) or one.sha256) for one in job.seats)
    header = EpisodeHeader(
        job.episode_id, job.map, job.seed, job.ticks, (blue, red), time.time_ns(), "scripted",
        {"blue": job.seats[0].agent_id, "red": job.seats[1].agent_id},
    )  # fmt: skip
    software = {**versions(), **({CODE: code} if code else {})}
    metrics = EpisodeMetrics(job.map)
    writer: EpisodeWriter | None = None
    played = 0
    for step in rollout(job.map, agents, job.seed, job.ticks):
        writer = writer or EpisodeWriter.create(folder, header, step.before, software=software)
        delivered = tuple(delivered_items(job.map, step.after.item_poses).tolist())
        writer.tick(TickRecord(step.actions, ("agent", "agent"), (-1, -1), step.after, delivered, 0.0))
        metrics.update(step.before, step.actions, step.after)
        played = step.after.tick
    assert writer is not None, "an episode has at least one tick"
    tcr = metrics.result().tcr
    path = finalise(writer.close("delivered" if tcr == 1.0 else "time"))
    return WrittenEpisode(path, job.map.name, played, tcr)


def _recording(job: EpisodeJob, folder: Path) -> Path:
    return folder / f"{job.episode_id}{RECORDING_SUFFIX}"


def _remove_unfinished(journal: Path) -> None:
    """Remove the journal of an episode that was stopped, or lost with a node. BusyError while a process writes it."""
    if not journal.exists():
        return
    try:
        with owned(journal):
            journal.unlink()
    except BusyError as error:
        raise BusyError(
            f"another process writes this episode here ({journal}); wait until it is over, or choose another folder"
        ) from error


def _weights(agent_id: str) -> str:
    """The hash of a trained agent; empty for others, whose habits a player's own hash names."""
    return weights_of([agent_id]).get(agent_id, "")


def write_all(todo: Sequence[EpisodeJob], folder: Path, workers: int, ray: str = "") -> Iterator[WrittenEpisode]:
    """Play and write episodes in `workers` processes, or on the Ray cluster at an address.

    Yields them as they finish and skips those that exist, but for what was cut off. Raises DataError, before
    anything is played, where one that exists is of another map, of other agents or of other ticks, and AgentError
    where an agent does not see all of a map. Raises RecordingError for a folder that cannot be made.
    """
    _make(folder)
    missing, cut_off = [], []
    for job in todo:
        path = _recording(job, folder)
        if not path.exists():
            missing.append(job)
        elif not check_recording(path, job.map, job.agent_ids, job.ticks):
            missing.append(job)
            cut_off.append(path)
    check_own_maps_seen((agent_id, job.map) for job in missing for agent_id in job.agent_ids)
    for path in cut_off:
        path.unlink(missing_ok=True)
    calls = [partial(_answered, job, partial(write_episode, job, folder.resolve(), code_sha256())) for job in missing]
    yield from results_of(calls, workers, ray)


def label_all(todo: Sequence[LabellingJob], folder: Path, workers: int, ray: str = "") -> Iterator[WrittenEpisode]:
    """Play and label episodes likewise; neither may the learner or the expert be another. Raises as `write_all`."""
    _make(folder)
    paths = {job: _labels(job, folder.resolve()) for job in todo}
    missing = []
    for job, path in paths.items():
        if path.exists():
            check_labels(path, job)
        else:
            missing.append((job, path))
    check_own_maps_seen((agent_id, job.map) for job, _ in missing for agent_id in (*job.agent_ids, job.expert))
    calls = [partial(_answered, job, partial(_label_and_save, job, path, code_sha256())) for job, path in missing]
    yield from results_of(calls, workers, ray)


def of_other_code(todo: Sequence[EpisodeJob | LabellingJob], folder: Path) -> int:
    """How many of these are in the folder already, made by other code of this project, as all were that name none."""
    codes = []
    for job in todo:
        path = _recording(job, folder) if isinstance(job, EpisodeJob) else _labels(job, folder)
        if path.exists():
            labelled = isinstance(job, LabellingJob)
            said = read_about(path).get("recipe", {}) if labelled else read_metadata(path).get(SOFTWARE, {})
            codes.append(said.get(CODE, ""))
    return sum(code != code_sha256() for code in codes)


def _make(folder: Path) -> None:
    """Raises RecordingError for a folder that cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot("write to", folder, error) from error


def _labels(job: LabellingJob, folder: Path) -> Path:
    return folder / f"{_file_name(job)}{SUFFIX}"


def _file_name(job: LabellingJob) -> str:
    """A file name unique to the job."""
    learner = re.sub(r"[^A-Za-z0-9]+", "-", job.learner)
    return f"{learner}-{_map_name(job.map)}-{job.partner[0]}-{job.seed}"


def _label_and_save(job: LabellingJob, path: Path, code: str) -> WrittenEpisode:
    correction = label_episode(job)
    save_correction(path, correction, {**labelling_recipe(job), CODE: code})
    trajectory = correction.trajectory
    rate = task_completion_rate(trajectory.map, delivered_items(trajectory.map, trajectory.item_poses[-1]))
    return WrittenEpisode(path, trajectory.map.name, trajectory.ticks, rate)


def _answered(job: EpisodeJob | LabellingJob, call: Callable[[], WrittenEpisode]) -> WrittenEpisode:
    """What the call returns. Raises AgentError for whatever an agent raised or answered: its code may be anybody's."""
    with noticing_ctrl_c():
        try:
            return call()
        except (AgentError, WorldError) as error:
            raise _fault(job, str(error), error) from error
        except MovingOutError:
            raise
        except FOREIGN_CODE_RAISES as error:
            if is_ctrl_c(error):
                raise
            raise _fault(job, f"{type(error).__name__}: {error}", error) from error


def _fault(job: EpisodeJob | LabellingJob, said: str, error: BaseException) -> AgentError:
    """Who played what, and that the rest is not lost."""
    by = f", labelled by {job.expert}" if isinstance(job, LabellingJob) and job.expert != job.learner else ""
    who = f"{' with '.join(job.agent_ids)}{by}"
    sentence = f"{who} on {job.map.name}, seed {job.seed}: {said}; finished episodes are kept"
    return AgentError(located(sentence, error))

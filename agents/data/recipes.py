"""What an episode in a folder was made by: one of another recipe is not taken for the one that is asked for."""

from collections.abc import Iterable, Mapping
from hashlib import sha256
from pathlib import Path

import orjson

from movingout.agents.around_others import acting_id
from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.agents.data.corrections import load_correction, read_about
from movingout.agents.data.dagger import EXPERT, LabellingJob
from movingout.agents.errors import DataError
from movingout.maps import MapSpec, map_from_json
from movingout.maps.errors import MapError
from movingout.maps.files.input_file import open_input
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.errors import cannot
from movingout.recordings.file_format.metadata import EPISODE, RECORDING, SEATS, STUDY
from movingout.recordings.file_format.reader import UNREADABLE
from movingout.recordings.file_format.records import attachment_in
from movingout.recordings.storage.listing import LARGEST_MAP, MAP_FILE, read_metadata
from movingout.world.metrics import task_completion_rate
from movingout.world.scoring import delivered_items

Recipe = Mapping[str, object]
"""Values by what they are called in a sentence. `weights` are hashes by the id of the agent."""
CODE = "movingout_code"
"""Under what a file has the hash of the code that made it: it is told apart by it, but not refused."""


def weights_of(agent_ids: Iterable[str]) -> dict[str, str]:
    """The hashes of those that have any; inside another agent, too."""
    return {one: sha for one in sorted(set(agent_ids)) if (sha := fingerprint(acting_id(one)))}


def labelling_recipe(job: LabellingJob) -> dict[str, object]:
    """What labels depend on beside the map, the seed and the seats, as it is written into their file."""
    partner = job.partner[1]
    weights = weights_of((job.learner, job.expert, partner))
    return {"learner": job.learner, "expert": job.expert, "partner": partner, "ticks": job.ticks, "weights": weights}


def check_labels(path: Path, job: LabellingJob) -> None:
    """Raises DataError for a file of labels of another recipe, or one that cannot be read."""
    about = read_about(path)
    recipe: Recipe = about["recipe"] if "recipe" in about else _recipe_of_before(path, job.ticks)
    _check(path, {"map": _map(path, about.get("map")), **recipe}, {"map": job.map, **labelling_recipe(job)})


def _recipe_of_before(path: Path, limit: int) -> Recipe:
    """What a file says that has no recipe in it. Its expert is taken for the default, its learner for its name's."""
    trajectory = load_correction(path).trajectory
    delivered = task_completion_rate(trajectory.map, delivered_items(trajectory.map, trajectory.item_poses[-1])) == 1.0
    return {"expert": EXPERT, "ticks": max(limit, trajectory.ticks) if delivered else trajectory.ticks}


def check_recording(path: Path, the_map: MapSpec, agent_ids: tuple[str, str], ticks: int) -> bool:
    """Whether a recording of this recipe is whole; one that was cut off is to be made again.

    Raises DataError for a recording of another recipe, RecordingError for one that cannot be read.

    Which of the two sat in blue does not count: with more episodes per pair, they change seats later.
    """
    records = read_metadata(path)
    players = [(records.get(STUDY, {}).get(colour), seat) for colour, seat in zip(SEAT_COLOURS, SEATS, strict=True)]
    ids = [agent_id for agent_id, _ in players if agent_id]
    hashes = {agent_id: records.get(seat, {}).get("checkpoint_sha256", "") for agent_id, seat in players if agent_id}
    of_before = {"", *(sha256(agent_id.encode()).hexdigest() for agent_id in hashes)}  # where no weights were noted
    there = {
        "map": _map(path, _map_document(path)),
        "ticks": records.get(EPISODE, {}).get("limit_ticks"),
        "agents": sorted(ids) if len(ids) == len(SEATS) else None,
        "weights": {one: sha for one, sha in hashes.items() if sha not in of_before},
    }
    now = {"map": the_map, "ticks": str(ticks), "agents": sorted(agent_ids), "weights": weights_of(agent_ids)}
    _check(path, there, now)
    return records.get(RECORDING, {}).get("complete") == "true"


def _map_document(path: Path) -> object:
    try:
        with open_input(path) as stream:
            return orjson.loads(attachment_in(stream, MAP_FILE, LARGEST_MAP) or b"null")
    except OSError as error:
        raise cannot("read", path, error) from error
    except UNREADABLE as error:
        raise DataError(f"{path} is damaged: {error}; remove it, to have it made again") from error


def _map(path: Path, document: object) -> MapSpec:
    try:
        return map_from_json(document)
    except MapError as error:
        raise DataError(f"the map in {path} cannot be read: {error}; remove the file, to have it made again") from error


def _check(path: Path, there: Recipe, now: Recipe) -> None:
    """Raises DataError, naming the first thing that differs. What the file does not say does not count."""
    for name, wanted in now.items():
        found = there.get(name)
        if found is not None and found != wanted and (said := _difference(name, found, wanted)):
            raise DataError(f"{path} is there already, {said}; choose another --out")


def _difference(name: str, found: object, wanted: object) -> str:
    """What differs, as the end of a sentence; empty where nothing does."""
    if isinstance(wanted, MapSpec):
        return f"with another version of the map {wanted.name}"
    if isinstance(wanted, dict) and isinstance(found, dict):
        changed = [agent_id for agent_id, sha in wanted.items() if found.get(agent_id, sha) != sha]
        return f"with other weights of {', '.join(changed)}" if changed else ""
    before, after = (" and ".join(value) if isinstance(value, list) else value for value in (found, wanted))
    return f"with the {name} {before}, not {after}"

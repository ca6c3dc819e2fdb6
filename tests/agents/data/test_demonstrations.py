"""Episodes of pairs written in processes: what an agent that fails says to whoever ordered them."""

import re
from pathlib import Path
from typing import NamedTuple

import pytest

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.data.dagger import LabellingJob
from movingout.agents.data.demonstrations import EpisodeJob, episode_jobs, label_all, write_all, write_episode
from movingout.agents.errors import AgentError
from movingout.maps import load_map, map_from_json, map_to_json
from movingout.recordings import EpisodeWriter, RecordingError, read_episode
from movingout.recordings.errors import BusyError
from movingout.recordings.file_format.metadata import EPISODE_ID
from movingout.recordings.storage.finished import recover
from tests.recordings.support import begin


class Raising:
    """A partner whose code has a fault."""

    def reset(self, episode: EpisodeInfo) -> None:
        """Remember nothing."""

    def act(self, observation: Observation) -> ActionChunk:
        raise RuntimeError("no way home")


class Leaving(Raising):
    """Ends the program instead of answering."""

    def act(self, observation: Observation) -> ActionChunk:
        raise SystemExit("no way home")


class Interrupting(Raising):
    """Raises what Ctrl-C raises."""

    def act(self, observation: Observation) -> ActionChunk:
        raise KeyboardInterrupt("no way home")


class Silent(Raising):
    """Answers nothing."""

    def act(self, observation: Observation) -> ActionChunk:
        return None  # type: ignore[return-value]


class Somebody(NamedTuple):
    name: str
    agent_id: str
    sha256: str = ""


RAISING = f"{__name__}:Raising"
LEAVING = f"{__name__}:Leaving"
INTERRUPTING = f"{__name__}:Interrupting"
SILENT = f"{__name__}:Silent"
KEPT = r"no way home; finished episodes are kept \(.*, line \d+\)"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("workers", "partner", "raised"),
    [
        (1, RAISING, "RuntimeError"),
        (2, RAISING, "RuntimeError"),
        (1, LEAVING, "SystemExit"),
        (1, INTERRUPTING, "KeyboardInterrupt"),
    ],
)
def test_a_partner_that_raises_is_answered_with_a_sentence(
    tmp_path: Path, workers: int, partner: str, raised: str
) -> None:
    the_map = load_map("HandOff")
    sentence = f"idle with {partner} on HandOff, seed 3: {raised}: {KEPT}"
    pair = (Somebody("Idle", "idle"), Somebody("Raising", partner))
    played = write_all([EpisodeJob("one", the_map, pair, seed=3, ticks=5)], tmp_path, workers)
    with pytest.raises(AgentError, match=sentence):
        list(played)
    job = LabellingJob(the_map, learner="idle", expert="idle", partner=("Raising", partner), seat=0, seed=3, ticks=5)
    with pytest.raises(AgentError, match=sentence):
        list(label_all([job], tmp_path, workers))


def test_an_answer_that_is_no_chunk_is_told_with_who_played_what(tmp_path: Path) -> None:
    the_map = load_map("HandOff")
    said = "on HandOff, seed 3: act() returned None"
    pair = (Somebody("Idle", "idle"), Somebody("Silent", SILENT))
    with pytest.raises(AgentError, match=re.escape(f"idle with {SILENT} {said}")) as error:
        list(write_all([EpisodeJob("one", the_map, pair, seed=3, ticks=5)], tmp_path, 1))
    assert "; finished episodes are kept" in str(error.value)
    job = LabellingJob(the_map, "idle", SILENT, partner=("Idle", "idle"), seat=0, seed=3, ticks=90)
    with pytest.raises(AgentError, match=re.escape(f"idle with idle, labelled by {SILENT} {said}")):
        list(label_all([job], tmp_path, 1))


def test_a_map_that_somebody_does_not_see_is_refused_before_anything_is_played(tmp_path: Path) -> None:
    goals = [{"x0": x, "y0": 1.2, "x1": x + 0.35, "y1": 0.8} for x in (-1.2, -0.75, -0.3, 0.15, 0.6)]
    five = map_from_json(map_to_json(load_map("Simple")) | {"name": "Five", "goals": goals})
    idle, sees_four = Somebody("Idle", "idle"), Somebody("DP", "dp@all")
    jobs = [EpisodeJob(f"e{k}", five, (idle, one), seed=0, ticks=5) for k, one in enumerate((idle, sees_four))]
    with pytest.raises(AgentError, match="dp@all cannot play Five"):
        list(write_all(jobs, tmp_path, 1))
    labels = [LabellingJob(five, "idle", "dp@all", ("Idle", "idle"), seat=0, seed=0, ticks=5)]
    with pytest.raises(AgentError, match="dp@all cannot play Five"):
        list(label_all(labels, tmp_path, 1))
    assert not list(tmp_path.iterdir())


def test_what_was_written_before_is_kept(tmp_path: Path) -> None:
    the_map = load_map("HandOff")
    idle = Somebody("Idle", "idle")
    jobs = [EpisodeJob("good", the_map, (idle, idle), seed=0, ticks=5)]
    (written,) = write_all(jobs, tmp_path, 1)
    jobs.append(EpisodeJob("bad", the_map, (idle, Somebody("Raising", RAISING)), seed=1, ticks=5))
    with pytest.raises(AgentError):
        list(write_all(jobs, tmp_path, 1))
    assert written.path.exists()
    assert list(write_all(jobs[:1], tmp_path, 1)) == []


def test_what_another_process_writes_is_left_to_it_and_what_it_has_written_stays(tmp_path: Path) -> None:
    """The journal was deleted under the other process, which then failed."""
    idle = Somebody("Idle", "idle")
    job = EpisodeJob("one", load_map("HandOff"), (idle, idle), seed=0, ticks=5)
    writer, _ = begin(tmp_path, episode_id="one")
    with pytest.raises(BusyError, match=r"another process writes this episode here .*one\.mcap\.journal"):
        list(write_all([job], tmp_path, 1))
    assert writer.path.exists()
    writer.abandon()
    (written,) = write_all([job], tmp_path, 1)  # that one was stopped
    before = written.path.read_bytes()
    assert write_episode(job, tmp_path) == written and written.path.read_bytes() == before


def test_an_episode_that_was_cut_off_and_recovered_is_played_again(tmp_path: Path) -> None:
    """It passed for whole, and was there already."""
    idle = Somebody("Idle", "idle")
    job = EpisodeJob("one", load_map("HandOff"), (idle, idle), seed=0, ticks=5)
    (made,) = write_all([job], tmp_path, 1)
    whole = read_episode(made.path)
    made.path.unlink()
    writer = EpisodeWriter.create(tmp_path, whole.header, whole.initial)
    writer.tick(whole.ticks[0])
    writer.abandon()
    (stub,) = recover(tmp_path)
    assert stub.recording == made.path and stub.ticks == 1
    (again,) = write_all([job], tmp_path, 1)
    assert again.ticks == 5 and read_episode(again.path).complete
    assert list(write_all([job], tmp_path, 1)) == []


def test_a_file_where_the_folder_should_be_is_told_in_a_sentence(tmp_path: Path) -> None:
    """It ended in a traceback."""
    file = tmp_path / "taken"
    file.write_text("x")
    for play_all in (write_all, label_all):
        with pytest.raises(RecordingError, match=r"cannot write to .*taken: File exists"):
            list(play_all([], file, 1))


def test_episodes_have_ids_whatever_the_map_and_the_players_are_called() -> None:
    """The longest name of a map, with players of a family, was refused in the middle of the writing."""
    the_map = load_map("generated:coordination:123456:hard:mirror:rot270")
    players = [Somebody("planner01", "idle"), Somebody("dp@mine-lag-0.5", "idle")]
    jobs = episode_jobs(players, [the_map], 3, ticks=1, seed=0, prefix="families1s0")
    ids = [job.episode_id for job in jobs]
    assert len(set(ids)) == 3 and all(EPISODE_ID.fullmatch(one) for one in ids)
    (plain,) = episode_jobs([Somebody("A01", "idle"), Somebody("A02", "idle")], [load_map("Simple")], 1, 1, 0, "A1s0")
    assert plain.episode_id == "A1s0-Simple-A01A02-00"


def test_a_pair_that_stands_twice_in_a_list_plays_twice() -> None:
    people = [Somebody("idle", "idle")] * 4 + [Somebody("a.b", "greedy"), Somebody("a@b", "novice")] * 2
    jobs = episode_jobs(people, [load_map("HandOff")], 2, 5, 0, "e")
    assert len({job.episode_id for job in jobs}) == len(jobs) == 8
    assert [job.episode_id for job in jobs[:3]] == [
        "e-HandOff-idleidle-00",
        "e-HandOff-idleidle-01",
        "e-HandOff-idleidle-00-again2",
    ]

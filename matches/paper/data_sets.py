"""The episodes that agents learn from: recorded by scripted people or given, listed, and divided among groups."""

from pathlib import Path

from movingout.agents.data.demonstrations import EpisodeJob, episode_jobs, variant_jobs, write_all
from movingout.agents.scripted.populations import population
from movingout.maps import load_map, map_names
from movingout.matches.callbacks import OnProgress
from movingout.matches.errors import MatchError
from movingout.matches.paper.given_choice import on_paper_maps, with_people
from movingout.matches.paper.given_variants import fair_variants
from movingout.matches.paper.workspace import DATA, GROUPS, Workspace
from movingout.recordings.groups import NEEDED, GroupedRecording, grouped, grouped_by_style, is_varied, write_groups
from movingout.recordings.spreadsheet import read_rows
from movingout.recordings.storage.copies import without_copies
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import read_summary

POPULATIONS = "AB"  # those of C are never learned from
EXPERTS = 4  # who record for Challenge 2, as in the paper
LEAST_TICKS = 8  # that an episode must have on average: shorter ones hold no chunk of actions


def record_scripted(challenge: int, space: Workspace, progress: OnProgress) -> None:
    """Let scripted people record; what is there already is kept."""
    jobs = _challenge_2(space) if challenge == 2 else _challenge_1(space)
    folder = _recorded(challenge)
    there = sum((folder / f"{job.episode_id}{SUFFIX}").exists() for job in jobs)
    for number, _ in enumerate(write_all(jobs, folder, space.workers), start=there + 1):
        progress(number, len(jobs))


def list_episodes(challenge: int, space: Workspace) -> None:
    """Write the list of a challenge's episodes, with two groups of participants for Challenge 1.

    Raises RecordingError or MatchError for recordings that the tables cannot be made from.
    """
    write_groups(space.listing(f"c{challenge}"), listed_episodes(challenge, space))


def rewrite_list(challenge: int, space: Workspace) -> None:
    """Write the list again, in its order, where there is one, of recordings that lie elsewhere by now.

    Raises MatchError where other episodes or groups come of it, and what `list_episodes` raises.
    """
    listing = space.listing(f"c{challenge}")
    if not listing.exists():
        return
    rows = {(row.episode, str(row.group)): row for row in listed_episodes(challenge, space)}
    before = [(line["episode"], line["group"]) for _, line in read_rows(listing, NEEDED)]
    if sorted(rows) != sorted(before):
        raise MatchError(
            f"of the recordings of --data, others or other groups would be learned from than {listing.resolve()} has; "
            "choose another folder with --out"
        )
    write_groups(listing, [rows[line] for line in before])


def check_lists(space: Workspace) -> None:
    """Raises MatchError where a list names given recordings that are not there, as in a folder from another computer.

    Recordings of scripted people may be gone: what was measured needs them no more.
    """
    for listing in filter(Path.exists, map(space.listing, ("c1", "c2") if space.given else ())):
        files = [listing.parent / line["file"] for _, line in read_rows(listing, NEEDED)]
        if lost := [file for file in files if not file.exists()]:
            raise MatchError(
                f"{listing} names {lost[0]}, which is not there: `movingout paper tables LABEL -o {Path.cwd()} --data "
                "RECORDINGS`, with the other options that the folder was begun with, lists the recordings where they "
                "are now"
            )


def listed_episodes(challenge: int, space: Workspace) -> list[GroupedRecording]:
    """The lines of that list. Raises RecordingError or MatchError, as `list_episodes`."""
    found = space.given_files() if space.given else sorted(_recorded(challenge).glob(f"*{SUFFIX}"))
    once = without_copies(found)  # of all: a recording and an import of it may be of different challenges
    paths = [path for path in once if is_varied(path) == (challenge == 2)]
    if not paths:
        raise MatchError(_nothing(challenge, len(found)))
    if space.given:
        paths = on_paper_maps(with_people(paths, found), map_names())
    if space.given and challenge == 2:
        paths = fair_variants(paths, space.evaluation)
    rows = _grouped(found, paths, challenge, space)
    _check(rows, challenge, space)
    return rows


def _grouped(found: list[Path], paths: list[Path], challenge: int, space: Workspace) -> list[GroupedRecording]:
    least = space.min_tcr if space.given else 0.0
    if challenge == 2 or space.grouping == "random":
        return grouped(found, len(GROUPS) if challenge == 1 else 1, space.seed, least, paths)
    rows, names = grouped_by_style(found, dict(space.styles), least, paths)
    if len(names) != len(GROUPS):
        raise MatchError(
            f"the tables compare {len(GROUPS)} groups, and these recordings have {len(names)} styles "
            f"({', '.join(names)}); give those of two, or call several styles by one name"
        )
    return rows


def _recorded(challenge: int) -> Path:
    return DATA / "demos" / f"c{challenge}"


def _challenge_1(space: Workspace) -> list[EpisodeJob]:
    """Pairs of A and pairs of B; every pair plays every map, and changes seats after half of its episodes."""
    maps, budget = [load_map(name) for name in map_names()], space.budget
    return [
        job
        for name in POPULATIONS
        for job in episode_jobs(
            population(name)[: budget.people], maps, budget.episodes, budget.ticks, space.seed, f"{name}1"
        )
    ]


def _challenge_2(space: Workspace) -> list[EpisodeJob]:
    """Four people of A, each episode on a variant of its own."""
    maps, experts = [load_map(name) for name in map_names()], population("A")[:EXPERTS]
    return variant_jobs(experts, maps, space.budget.variants, space.budget.ticks, space.seed, "A2", space.split)


def _nothing(challenge: int, count: int) -> str:
    if challenge == 2:
        return (
            f"none of {count} recordings is on a varied map, which Challenge 2 learns from; ask for a table of "
            "Challenge 1, or leave out --data, so that scripted people record"
        )
    return f"none of {count} recordings is on a map as designed, which Challenge 1 learns from"


def _check(rows: list[GroupedRecording], challenge: int, space: Workspace) -> None:
    """Raises MatchError for a group that lacks a map, and for episodes that are too short to learn from."""
    ticks = [read_summary(row.path).ticks for row in rows]
    if sum(ticks) < LEAST_TICKS * len(rows):
        raise MatchError(
            f"{len(rows)} episodes have {sum(ticks)} frames together, too few to learn from: an agent plans "
            f"{LEAST_TICKS} at a time"
        )
    for group in sorted({row.group for row in rows}):
        lacking = [name for name in map_names() if name not in {row.map for row in rows if row.group == group}]
        if lacking:
            whose = f"group {group} of Challenge 1" if challenge == 1 else "Challenge 2"
            raise MatchError(
                f"{whose} has no episode on {', '.join(lacking)}; every group needs each of the twelve maps: "
                f"{map_remedy(challenge, space, {row.map for row in rows}.issuperset(lacking))}"
            )


def map_remedy(challenge: int, space: Workspace, others_played: bool = True) -> str:
    """What may help where a group lacks maps; `others_played`: whether the other group has all of these."""
    ways = ["record them"]
    if space.min_tcr:
        ways.append(f"keep poorer episodes with a --min-tcr below {space.min_tcr:g}")
    if challenge == 1 and others_played:
        other = "another --seed" if space.grouping == "random" else "other --styles"
        ways.append(f"divide the participants otherwise with {other}")
    return ", or ".join(ways)

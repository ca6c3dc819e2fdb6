"""A list of recordings, each with the group of participants that it belongs to: a CSV file for people and for training.

file,group,episode,map,variant,blue,red,tcr,simulated
HandOff-0.mcap,1,4f1c…,HandOff,,P1,P2,0.75,

`simulated` is `yes` for episodes of a rehearsal, in which programs took part in a study. Files are relative to the
folder of the list where they lie below it. Nobody is in two groups.
"""

import csv
import io
from collections import Counter
from collections.abc import Collection, Sequence, Set
from pathlib import Path
from typing import NamedTuple

from movingout.maps.files.output_file import draft_of
from movingout.maps.suggestion import counted
from movingout.recordings.episode import FINISHED, is_simulated
from movingout.recordings.errors import RecordingError, cannot, with_folder
from movingout.recordings.exports.split import divided, has_people, participants, unmasked
from movingout.recordings.spreadsheet import check_name, read_rows
from movingout.recordings.storage.copies import without_copies
from movingout.recordings.storage.listing import Players, Summary, misnamed, read_players, read_summary
from movingout.recordings.storage.study_rounds import counted_recordings
from movingout.recordings.styles import Styles, style_of_pair, styles_of

COLUMNS = ("file", "group", "episode", "map", "variant", "blue", "red", "tcr", "simulated")
NEEDED = COLUMNS[:-1]  # lists of before do not say who is simulated


class GroupedRecording(NamedTuple):
    """One line of the list."""

    path: Path
    group: int  # from 1
    episode: str
    map: str
    variant: str
    people: tuple[str, str]  # in blue and red
    tcr: float
    simulated: bool = False


def is_varied(path: Path) -> bool:
    """Whether an episode is on a varied map (Challenge 2). Raises RecordingError, naming folder and file."""
    with with_folder(path):
        return bool(read_summary(path).variant)


def of_challenge(paths: Sequence[Path], challenge: int) -> list[Path]:
    """Those on maps as designed (1) or on varied ones (2). Raises RecordingError where there is none."""
    found = [path for path in paths if is_varied(path) == (challenge == 2)]
    if paths and not found:
        where = "a varied map (Challenge 2)" if challenge == 2 else "a map as designed (Challenge 1)"
        raise RecordingError(f"none of {counted(len(paths), 'recording')} is on {where}")
    return found


def grouped(
    paths: Sequence[Path], groups: int, seed: int = 0, min_tcr: float = 0.0, once: Sequence[Path] | None = None
) -> list[GroupedRecording]:
    """Divide recordings into groups that share no participant.

    Left out are those with a TCR below `min_tcr`, tutorials, what was cut off, live rounds that ended early, copies,
    and what a study does not count (`storage.study_rounds`). `once` are those to divide of `paths`, where the caller
    has chosen: none of them is a copy of another.

    Raises RecordingError for a file that cannot be read, when none is left, for too few participants, and for several
    groups of people without a name: the same person might be in two of them.
    """
    kept = _kept(paths, min_tcr, once)
    if groups > 1:
        _check_named([players for _, _, players in kept])
    numbers = divided([players for _, _, players in kept], groups, seed)
    return [
        _line(path, summary, players, number) for (path, summary, players), number in zip(kept, numbers, strict=True)
    ]


def grouped_by_style(
    paths: Sequence[Path], styles: Styles, min_tcr: float = 0.0, once: Sequence[Path] | None = None
) -> tuple[list[GroupedRecording], list[str]]:
    """A group for each style, in the order of their names, and these names; who plays each is in one group alone.

    Left out are also episodes of people of different styles. Raises RecordingError as `grouped`, for people without a
    style, and where fewer than two styles are left.
    """
    kept = _kept(paths, min_tcr, once)
    who = [participants(players) for players in unmasked([players for _, _, players in kept])]
    of_people = styles_of((name for names in who for name in names), styles)
    found = [style_of_pair(names, of_people) for names in who]
    names = sorted(set(found) & set(of_people.values()))
    if len(names) < 2:
        raise RecordingError(
            f"groups by style need episodes of two styles or more; these recordings have {', '.join(names) or 'none'}, "
            "and episodes of people of different styles are left out"
        )
    rows = [
        _line(path, summary, players, names.index(style) + 1)
        for (path, summary, players), style in zip(kept, found, strict=True)
        if style in names
    ]
    return rows, names


_Read = tuple[Path, Summary, Players]


def _read(path: Path) -> _Read:
    with with_folder(path):
        return path, read_summary(path), read_players(path)


def _kept(paths: Sequence[Path], min_tcr: float, once: Sequence[Path] | None) -> list[_Read]:
    """Those that count and are good enough. Raises RecordingError where none is."""
    counting = set(counted_recordings(paths))  # of all: a copy elsewhere has no study beside it
    found = [_read(path) for path in (without_copies(paths) if once is None else once)]
    valid = _valid(found, counting)
    kept = [entry for entry in valid if _tcr(entry[1]) >= min_tcr]
    if not kept:
        raise RecordingError(f"{_why_nothing(found, valid, min_tcr)}; nothing can be divided into groups")
    return kept


def _valid(found: Sequence[_Read], counting: Set[Path]) -> list[_Read]:
    """Those that count for whoever recorded them."""
    return [
        (path, summary, players)
        for path, summary, players in found
        if summary.source != "tutorial" and not _broken_off(summary) and path in counting
    ]


def _broken_off(summary: Summary) -> bool:
    """Whether an episode was cut off, or a live round ended early; what was imported may end where its file ends."""
    return not summary.complete or (summary.source == "live" and summary.outcome not in FINISHED)


def _why_nothing(found: Sequence[_Read], valid: Sequence[_Read], min_tcr: float) -> str:
    if not found:
        return "there are no recordings"
    if not valid:
        why = "they are tutorials, were broken off, or their study leaves them out"
        return f"none of {counted(len(found), 'recording')} counts: {why}"
    return f"none of {counted(len(valid), 'recording')} has a TCR of {min_tcr:g} or more"


def _check_named(episodes: Sequence[Players]) -> None:
    nameless = sum(map(_is_nameless, unmasked(episodes)))
    if nameless:
        verb = "does" if nameless == 1 else "do"
        raise RecordingError(
            f"{nameless} of {counted(len(episodes), 'recording')} {verb} not say who played, "
            "so that the same person might be in two groups; name participants with --participants of `recordings "
            "import`, into a new folder, or leave these recordings out"
        )


def _is_nameless(players: Players) -> bool:
    return any(seat.kind == "human" and not seat.name for seat in players.seats)


def _line(path: Path, summary: Summary, players: Players, group: int) -> GroupedRecording:
    blue, red = (seat.name for seat in players.seats)
    return GroupedRecording(
        path, group, summary.id, summary.map, summary.variant, (blue, red), _tcr(summary), is_simulated(summary.study)
    )


def _tcr(summary: Summary) -> float:
    return summary.metrics["tcr"] or 0.0


def people_of_groups(rows: Sequence[GroupedRecording]) -> dict[int, set[str]]:
    """The people in the episodes of each group, "" for those without a name.

    Agents only where no person took part in any episode. Raises RecordingError for a file that cannot be read.
    """
    episodes = unmasked([read_players(row.path) for row in rows])
    people = any(has_people(players) for players in episodes)
    found: dict[int, set[str]] = {group: set() for group in sorted({row.group for row in rows})}
    for row, players in zip(rows, episodes, strict=True):
        if has_people(players) or not people:
            found[row.group].update(participants(players))
        if _is_nameless(players):
            found[row.group].add("")
    return found


def group_sentences(rows: Sequence[GroupedRecording], styles: Sequence[str] = ()) -> list[str]:
    """One sentence per group: its episodes and people, and the maps that it lacks while another group has them."""
    maps = sorted({row.map for row in rows})
    sentences = []
    for group, people in people_of_groups(rows).items():
        mine = [row for row in rows if row.group == group]
        lacking = [name for name in maps if name not in {row.map for row in mine}]
        without = f"; no episode on {', '.join(lacking)}" if lacking else ""
        whose = f"group {group}, {styles[group - 1]}" if styles else f"group {group}"
        varied = sum(bool(row.variant) for row in mine)
        of_these = f", {varied} of them on varied maps (Challenge 2)" if varied else ""
        of_whom = f"{counted(len(mine), 'episode')} of {counted_people(people)}"
        played = f"; {simulation(mine)}" if any(row.simulated for row in mine) else ""
        sentences.append(f"{whose}: {of_whom}{of_these}{without}{played}")
    return sentences


def counted_people(people: Collection[str]) -> str:
    """How many these are; "" stands for those without a name."""
    named = len(set(people) - {""})
    words = [counted(named, "participant")] * bool(named) + ["people without a name"] * ("" in people)
    return " and ".join(words) or "agents alone"


def simulation(rows: Sequence[GroupedRecording]) -> str:
    """How many episodes are of a rehearsal."""
    number = sum(row.simulated for row in rows)
    return f"{'all' if number == len(rows) else f'{number:,}'} by simulated participants, who are programs"


def write_groups(path: Path, rows: Sequence[GroupedRecording]) -> None:
    """Write the list, over an older one if there is one. Raises RecordingError."""
    check_name(path)
    here, text = path.resolve().parent, io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in rows:
        if bad := misnamed(row.path):
            raise RecordingError(bad.problem)
        file = row.path.resolve()
        shown = file.relative_to(here) if file.is_relative_to(here) else file
        simulated = "yes" if row.simulated else ""
        about = row.group, row.episode, row.map, row.variant, *row.people, f"{row.tcr:.4f}", simulated
        writer.writerow([shown, *about])
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with draft_of(path) as draft:  # half a list would pass for a whole one
            draft.write_text(text.getvalue(), encoding="utf-8")
    except OSError as error:
        raise cannot("write", path, error) from error


def read_groups(path: Path) -> list[GroupedRecording]:
    """Read such a list. Raises RecordingError for one that is not, or that names a file that is not there."""
    rows = [_read_line(path, number, line) for number, line in read_rows(path, NEEDED)]
    missing = [row.path for row in rows if not row.path.exists()]
    if missing:
        raise RecordingError(f"{path.name} names {missing[0]}, which is not there; make the list again")
    return rows


def listed_maps(path: Path) -> Counter[str]:
    """How many episodes of each map such a list has; the recordings need not be there. Raises RecordingError."""
    return Counter(line["map"] for _, line in read_rows(path, NEEDED))


def _read_line(path: Path, number: int, line: dict[str, str]) -> GroupedRecording:
    try:
        return GroupedRecording(
            path.parent / line["file"], int(line["group"]), line["episode"], line["map"], line["variant"],
            (line["blue"], line["red"]), float(line["tcr"].replace(",", ".")), line.get("simulated") == "yes",
        )  # fmt: skip
    except ValueError as error:
        raise RecordingError(
            f"{path.name}, line {number}: not a line of `movingout recordings split` ({error}); make the list again"
        ) from error


def of_group(path: Path, group: int) -> list[Path]:
    """The recordings of one group in a list. Raises RecordingError when it has none."""
    rows = read_groups(path)
    found = [row.path for row in rows if row.group == group]
    if not found:
        known = ", ".join(
            f"{number} ({count} episodes)" for number, count in sorted(Counter(r.group for r in rows).items())
        )
        raise RecordingError(f"{path.name} has no group {group}; it has {known or 'none'}")
    return found

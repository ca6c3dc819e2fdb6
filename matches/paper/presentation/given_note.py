"""Whose recordings a table or figure was made from; where they were given, in a sentence for each challenge."""

from collections.abc import Collection

from movingout.maps.suggestion import counted
from movingout.matches.paper.given_players import counted_players
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import GroupedRecording, people_of_groups, read_groups, simulation

SCRIPTED = "Here all episodes are of scripted people, who stand in for the paper's participants."


def people_notes(space: Workspace, challenges: Collection[int]) -> list[str]:
    """Who recorded what was learned from in these challenges, whether given or not."""
    return given_notes(space, challenges) if space.given else [SCRIPTED]


def given_notes(space: Workspace, challenges: Collection[int]) -> list[str]:
    """Of the lists of episodes that have been made; empty where scripted people recorded."""
    if not space.given:
        return []
    lists = {challenge: space.listing(f"c{challenge}") for challenge in sorted(challenges) if challenge}
    return [_note(challenge, read_groups(path)) for challenge, path in lists.items() if path.exists()]


def _note(challenge: int, rows: list[GroupedRecording]) -> str:
    groups = people_of_groups(rows)
    sizes = [len(people - {""}) for people in groups.values()]
    divided = f", in groups of {' and '.join(map(str, sizes))}" if len(sizes) > 1 else ""
    recordings = f"{counted(len(rows), 'given recording')} of {counted_players(rows)}"
    note = f"Challenge {challenge}: learned from {recordings}{divided}"
    return f"{note}; {simulation(rows)}." if any(row.simulated for row in rows) else f"{note}."

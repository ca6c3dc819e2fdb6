"""How the people of Challenge 1 were divided, where that is not as in the paper."""

from movingout.matches.paper.workspace import Workspace
from movingout.recordings.errors import RecordingError
from movingout.recordings.groups import read_groups
from movingout.recordings.styles import style_of_pair, styles_of

STYLES = "The two groups of people are two styles of play, in the order of their names, not drawn at random."
POPULATIONS = (
    "The two groups of people were drawn at random and are two populations, each of a style of its own: the division "
    "is that of --groups style, which is harder."
)


def group_notes(space: Workspace) -> list[str]:
    """At most one sentence; of what was drawn, once episodes have been listed."""
    if space.grouping == "style":
        return [STYLES]
    return [POPULATIONS] if _are_populations(space) else []


def _are_populations(space: Workspace) -> bool:
    """Whether each group has scripted people of one population, and none of another group's."""
    listing = space.listing("c1")
    if space.given or not listing.exists():
        return False
    try:
        rows = read_groups(listing)
        styles = styles_of((name for row in rows for name in row.people), {})
    except RecordingError:  # others than scripted people, or recordings that are no longer there
        return False
    found = {(row.group, style_of_pair(row.people, styles)) for row in rows}
    return len(found) == len({group for group, _ in found}) == len({style for _, style in found})

"""What stands below a picture: how much it was made with, from whose episodes, and what differs from the paper."""

from movingout.matches.paper.entry import PaperEntry
from movingout.matches.paper.methods import trained_id
from movingout.matches.paper.presentation.given_note import people_notes
from movingout.matches.paper.workspace import Workspace


def figure_notes(entry: PaperEntry, space: Workspace) -> tuple[str, ...]:
    """In sentences. Of given episodes alone, without agents, no budget says how many there are."""
    drawing = entry.drawing
    if drawing is None:
        return entry.remarks
    data = {*drawing.data, *(trained_id(agent_id).data for agent_id in drawing.agents)}
    budget = [space.budget.sentence] if drawing.agents or (data and not space.given) else []
    people = people_notes(space, {2 if name == "c2" else 1 for name in data}) if data else []
    return (*budget, *people, *entry.remarks)

"""How players are named where all episodes of one player count together."""

import pytest

from movingout.recordings.episode import player_label


@pytest.mark.parametrize(
    ("kind", "name", "label"),
    [
        ("human", "P-1", "people"),
        ("agent", "scripted", "scripted"),
        ("agent", "person:name=C03", "person"),
        ("agent", "dp@all:mirrored=yes", "dp@all"),
        ("agent", "lab_agents:Idle", "lab_agents:Idle"),
        ("agent", "lab_agents:Driver:speed=2", "lab_agents:Driver"),
        ("agent", "late:agent=lab_agents:Driver,delay=1", "late"),
        ("ghost", "ghost:then#red", "ghost"),
        ("idle", "", "idle"),
    ],
)
def test_agents_are_told_apart_by_what_they_are_and_not_by_their_options(kind: str, name: str, label: str) -> None:
    """Two agents of one module passed for one."""
    assert player_label(kind, name) == label
